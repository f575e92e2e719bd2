//! The way through channels that are in any order.

use super::graph::Graph;
use super::{Corner, End, HalfSpace, all_axes, longest, mouth_of, proper, towards};
use crate::geometry::{AxisBox, Direction, Sign, Vector};
use std::collections::BinaryHeap;
use std::mem;

mod blocked;
mod driving;
mod error;
mod label;
mod refusal;
mod translating;
mod traveller;
mod widest;

pub use blocked::{Blocked, Passage, Place, blocked};
pub use driving::Driving;
pub use error::RouteError;
pub use label::Label;
pub use translating::Translating;
pub use traveller::{Motion, Traveller};

use label::{Ending, Entry, NONE, Way, number};

const SIGNS: [Sign; 2] = [Sign::Negative, Sign::Positive];

/// How many routes may be blocked before the search is given up.
const MOST_BLOCKED: usize = 16;

/// The second search of a robot's route may take so many times the steps of the first, and so
/// many more.
const EFFORT: usize = 4;
const LEAST_EFFORT: usize = 1 << 16;

/// No set of directions.
const UNKNOWN: u8 = u8::MAX;

/// Lengths that differ by no more are the same, metres.
const SAME_LENGTH: f64 = 1e-9;

/// What was found about a route, by following it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Judgement {
    /// It can be followed; the length of its path, metres.
    Length(f64),
    /// It can't: what stands in the way is met on the arc about this junction or the
    /// straight line that leads to it; `None`: on the last line, to the goal.
    /// Junctions are counted from 0 in travel order.
    Blocked(Option<usize>),
    /// It can't, and nor can any other.
    Hopeless,
}

/// Looks for routes, in memory that is used again.
///
/// # What is shortest
///
/// The route is the one whose [`Chain`](super::Chain) has the shortest path by the
/// rules, of all sequences of channels that do not go straight back through the
/// junction they came by: for a body ([`Translating`]) by the length that
/// [`crate::disassembly::disassemble`] gives, the way out included, for a robot
/// ([`Driving`]) by that of [`crate::driving::route`]. A channel may be travelled twice
/// where that is shorter than any way without. Of several routes of the very same
/// length one is always the same: it has the fewest channels, and then the lowest
/// index where the search met them.
///
/// # How
///
/// Where the rule puts a body in a junction, and which corner a robot turns about there,
/// depends on the directions in which it comes and goes, which the chain takes from the
/// centres of the junctions before and after. So the search (A*, by what is missing to
/// the mouth or the goal in a straight line) goes over junctions with both directions,
/// and one bit that says whether the channel before had a choice of axes; this makes the
/// chain's choice the search's own. What else a path's length depends on, and when one
/// way into a junction makes another useless, is the [`Motion`]'s.
///
/// A robot's route is sought twice. The first search goes by straight lines from junction to
/// junction ([`Motion::outline`]) and is quick; the second takes what the first found as a
/// bound and looks for the shortest, as far as it comes with some four times the steps. In
/// corridors it comes to the end. In the open, where a line leads through many junctions in
/// many orders, it may not: then the route stands that was found first (over fields of
/// pillars 0.2 % longer than need be). Only routes count whose path leads through their junctions
/// and passes each corner at the gap, however far: others may cut a corner.
///
/// Time goes with the pairs of junctions passed one after the other: n log n for n
/// channels that meet a few others each; a channel with k junctions may cost k^2.
/// Memory is `8 D + 56` bytes (for a robot 104) for every way found to a state (some ten
/// per junction), never for more of them than 24 per pair, and 10 bytes per junction.
#[derive(Debug, Clone)]
pub struct Router<const D: usize, M: Motion<D>> {
    labels: Vec<Label<M::State>>,
    /// For every slot the first label.
    heads: Vec<u32>,
    /// For every slot the directions that lead on from the junction, as bits, once known.
    onwards: Vec<u8>,
    ends: Vec<Ending>,
    open: BinaryHeap<Entry>,
    starts: Vec<usize>,
    seen: Vec<bool>,
    steps: usize,
    route: Vec<usize>,
    length: f64,
    /// For the outline of a motion.
    first: Option<Box<Router<D, Translating<D>>>>,
}

impl<const D: usize, M: Motion<D>> Default for Router<D, M> {
    fn default() -> Self {
        Self {
            labels: Vec::new(),
            heads: Vec::new(),
            onwards: Vec::new(),
            ends: Vec::new(),
            open: BinaryHeap::new(),
            starts: Vec::new(),
            seen: Vec::new(),
            steps: 0,
            route: Vec::new(),
            length: 0.0,
            first: None,
        }
    }
}

/// What is looked for.
pub struct Search<'a, const D: usize> {
    graph: &'a Graph<D>,
    traveller: Traveller<D>,
    /// With an exit: where the channels that reach farthest along it end.
    mouth: Option<HalfSpace>,
}

/// What came of one search.
enum Found {
    /// The route is there.
    Route,
    /// No way leads to the end.
    Nothing,
    /// The shortest is blocked, and what blocks it is ruled out from here on.
    Blocked,
    /// The shortest is blocked, and looking on is of no use.
    Hopeless,
}

impl<const D: usize, M: Motion<D>> Router<D, M> {
    /// The route found last: indices of channels in travel order. Empty after an error.
    pub fn route(&self) -> &[usize] {
        &self.route
    }

    /// The length of the path by the rules along the route, metres.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Finds the shortest route: out of a channel that reaches farthest along an exit, or
    /// to a goal (where the traveller's centre is to be). Looks at no more than
    /// `most_steps` pairs of junctions.
    pub fn find(
        &mut self,
        graph: &Graph<D>,
        motion: &mut M,
        most_steps: usize,
    ) -> Result<(), RouteError> {
        self.find_judged(graph, motion, most_steps, |_, length| Judgement::Length(length))
    }

    /// Finds the shortest route that can be followed, as `judge` finds out: it is given a
    /// route and its length by the search, metres, and is asked last about the route that
    /// is taken. What blocks a route is avoided from there on, until as many as 16 have
    /// been refused.
    pub fn find_judged(
        &mut self,
        graph: &Graph<D>,
        motion: &mut M,
        most_steps: usize,
        mut judge: impl FnMut(&[usize], f64) -> Judgement,
    ) -> Result<(), RouteError> {
        self.route.clear();
        self.length = 0.0;
        self.steps = 0;
        let found = self.try_find(graph, motion, most_steps, &mut judge);
        if found.is_err() {
            self.route.clear();
        }
        found
    }

    fn try_find(
        &mut self,
        graph: &Graph<D>,
        motion: &mut M,
        most_steps: usize,
        judge: &mut dyn FnMut(&[usize], f64) -> Judgement,
    ) -> Result<(), RouteError> {
        if graph.channels().is_empty() {
            return Err(RouteError::NoChannels);
        }
        let traveller = *motion.traveller();
        let mouth = match traveller.end {
            End::Exit(exit) => farthest(graph.channels(), exit),
            End::Goal(_) => None,
        };
        let search = Search { graph, traveller, mouth };
        search.find_starts(&mut self.starts)?;
        search.check_goal()?;
        if !self.is_connected(&search) {
            return self.judge_any(&search, most_steps, judge);
        }
        self.onwards.clear();
        self.onwards.resize(graph.slot_count(), UNKNOWN);
        let Some(outline) = motion.outline() else {
            return self.find_shortest(&search, motion, (f64::INFINITY, most_steps), judge);
        };
        self.find_from_outline(&search, motion, outline, most_steps, judge)
    }

    /// Finds a route by the outline of the motion, and then looks for a shorter one.
    fn find_from_outline(
        &mut self,
        search: &Search<'_, D>,
        motion: &mut M,
        mut outline: Translating<D>,
        most_steps: usize,
        judge: &mut dyn FnMut(&[usize], f64) -> Judgement,
    ) -> Result<(), RouteError> {
        let mut first = mem::take(&mut self.first).unwrap_or_default();
        let mut length = f64::INFINITY;
        let found = first.find_judged(search.graph, &mut outline, most_steps, |route, along| {
            let judgement = judge(route, along);
            if let Judgement::Length(exact) = judgement {
                length = exact;
                return Judgement::Length(along);
            }
            judgement
        });
        let effort = first.steps.saturating_mul(EFFORT).saturating_add(LEAST_EFFORT);
        let found = match found {
            Ok(()) => match self.find_shortest(search, motion, (length, effort), judge) {
                Ok(()) => Ok(()),
                // None is shorter, or it would take too long to tell.
                Err(_) => {
                    self.route.clone_from(&first.route);
                    judge(&self.route, length);
                    self.length = length;
                    Ok(())
                }
            },
            Err(RouteError::Blocked) => {
                let shortest = self.find_shortest(search, motion, (f64::INFINITY, effort), judge);
                shortest.map_err(|_| RouteError::Blocked)
            }
            Err(error) => Err(error),
        };
        self.first = Some(first);
        found
    }

    /// Finds the shortest route that is shorter than a bound, looking at no more than so
    /// many pairs of junctions.
    fn find_shortest(
        &mut self,
        search: &Search<'_, D>,
        motion: &mut M,
        bounds: (f64, usize),
        judge: &mut dyn FnMut(&[usize], f64) -> Judgement,
    ) -> Result<(), RouteError> {
        for blocked in 0..MOST_BLOCKED {
            match self.search(search, motion, bounds, judge)? {
                Found::Route => return Ok(()),
                Found::Blocked => {}
                Found::Nothing if blocked == 0 => return self.judge_any(search, bounds.1, judge),
                Found::Nothing | Found::Hopeless => break,
            }
        }
        Err(RouteError::Blocked)
    }

    /// Whether junctions that are large enough lead from a start to an end.
    fn is_connected(&mut self, search: &Search<'_, D>) -> bool {
        let Self { starts, seen, route: open, .. } = self;
        seen.clear();
        seen.resize(search.graph.channels().len(), false);
        open.clear();
        open.extend_from_slice(starts);
        starts.iter().for_each(|start| seen[*start] = true);
        while let Some(channel) = open.pop() {
            if search.ends_in(channel) {
                open.clear();
                return true;
            }
            for slot in search.graph.slots(channel) {
                let next = search.graph.neighbour_at(slot);
                let passable = || search.passable(&search.graph.channels()[channel], slot);
                if !seen[next] && passable().is_some() {
                    seen[next] = true;
                    open.push(next);
                }
            }
        }
        false
    }

    /// Says why there is no route. If nothing can be said but that the path can't be made
    /// through junctions that are large enough, the judge is asked about that route.
    fn judge_any(
        &mut self,
        search: &Search<'_, D>,
        most_steps: usize,
        judge: &mut dyn FnMut(&[usize], f64) -> Judgement,
    ) -> Result<(), RouteError> {
        self.route = refusal::why_not(search, &self.starts, most_steps)?;
        match judge(&self.route, f64::INFINITY) {
            Judgement::Length(length) => {
                self.length = length;
                Ok(())
            }
            _ => Err(RouteError::Blocked),
        }
    }

    fn search(
        &mut self,
        search: &Search<'_, D>,
        motion: &mut M,
        (bound, most_steps): (f64, usize),
        judge: &mut dyn FnMut(&[usize], f64) -> Judgement,
    ) -> Result<Found, RouteError> {
        self.labels.clear();
        self.ends.clear();
        self.open.clear();
        self.heads.clear();
        self.heads.resize(search.graph.slot_count(), NONE);
        for index in 0..self.starts.len() {
            self.start_in(search, motion, self.starts[index]);
        }
        while let Some(entry) = self.open.pop() {
            if entry.estimate >= bound {
                return Ok(Found::Hopeless);
            }
            if entry.slot == NONE {
                let Ending { length, before, .. } = self.ends[entry.label as usize];
                self.trace(entry.label);
                match judge(&self.route, length) {
                    Judgement::Length(exact) if exact <= length + SAME_LENGTH => {
                        self.length = exact;
                        return Ok(Found::Route);
                    }
                    // Others may be shorter.
                    Judgement::Length(exact) => {
                        self.ends[entry.label as usize].length = exact;
                        self.open.push(Entry { estimate: exact, ..entry });
                    }
                    Judgement::Blocked(junction) => {
                        return Ok(match motion.avoid(&self.labels, before, junction) {
                            true => Found::Blocked,
                            false => Found::Hopeless,
                        });
                    }
                    Judgement::Hopeless => return Ok(Found::Hopeless),
                }
                continue;
            }
            let label = self.labels[entry.label as usize];
            if !label.beaten {
                self.go_on(search, motion, entry.label, &label);
            }
            if self.steps > most_steps {
                return Err(RouteError::TooManySteps { has: self.steps, most: most_steps });
            }
        }
        Ok(Found::Nothing)
    }

    /// All first steps out of a channel that the traveller is in.
    fn start_in(&mut self, search: &Search<'_, D>, motion: &M, first: usize) {
        let channel = &search.graph.channels()[first];
        let start = search.traveller.center();
        if search.ends_in(first) {
            // Any axis will do.
            self.finish(search, motion, first, NONE, 0);
        }
        for slot in search.graph.slots(first) {
            self.steps += 1;
            let Some(junction) = search.passable(channel, slot) else { continue };
            let center = junction.center();
            let possible = or_all::<D>(proper(&junction, channel));
            let forced = possible.count_ones() == 1;
            for leaving in 0..D {
                let Some(axis) = longest(possible & !(1 << leaving), &start, &center) else {
                    continue;
                };
                let approach = towards(&start, &center, axis);
                for sign in SIGNS {
                    let leaving = Direction { axis: leaving, sign };
                    let corner = Corner { junction, approach, leaving };
                    self.enter(search, motion, (first, slot), &corner, forced, (NONE, 0));
                }
            }
        }
    }

    /// All steps on from a junction.
    fn go_on(&mut self, search: &Search<'_, D>, motion: &M, index: u32, label: &Label<M::State>) {
        let (approach, leaving) = (label.way.approach(), label.way.leaving());
        let (graph, before) = (search.graph, label.channel as usize);
        let here = graph.neighbour_at(label.slot as usize);
        let channel = &graph.channels()[here];
        let Some(from) = graph.channels()[before].intersection(channel) else { return };
        let center = from.center();
        let mine = proper(&from, channel);
        // What the channel before needs for itself.
        let taken = if label.way.is_forced() { 1 << approach.axis } else { 0 };

        if search.ends_in(here) {
            let out = match search.traveller.end {
                End::Exit(exit) => (taken >> exit.axis & 1 == 0).then_some(exit),
                End::Goal(goal) => longest(or_all::<D>(mine) & !taken, &center, &goal)
                    .map(|axis| towards(&center, &goal, axis)),
            };
            if out == Some(leaving) {
                self.finish(search, motion, here, index, label.junctions);
            }
        }
        for slot in graph.slots(here) {
            self.steps += 1;
            if graph.neighbour_at(slot) == before {
                continue;
            }
            let neighbour = &graph.channels()[graph.neighbour_at(slot)];
            if !lies_towards(leaving, &center, channel, neighbour) {
                continue;
            }
            let Some(junction) = search.passable(channel, slot) else { continue };
            let next = junction.center();
            let possible = or_all::<D>(mine | proper(&junction, channel)) & !taken;
            for axis in (0..D).filter(|axis| *axis != leaving.axis) {
                if longest(possible & !(1 << axis), &center, &next) != Some(leaving.axis) {
                    continue;
                }
                for sign in SIGNS {
                    let corner =
                        Corner { junction, approach: leaving, leaving: Direction { axis, sign } };
                    let forced = possible.count_ones() == 1;
                    let from = (index, label.junctions);
                    self.enter(search, motion, (here, slot), &corner, forced, from);
                }
            }
        }
    }

    /// Opens the label of a step into a junction, if it is of use.
    fn enter(
        &mut self,
        search: &Search<'_, D>,
        motion: &M,
        (channel, slot): (usize, usize),
        corner: &Corner<D>,
        forced: bool,
        (before, junctions): (u32, u32),
    ) {
        let onwards = match self.onwards[slot] {
            UNKNOWN => {
                self.onwards[slot] = search.onwards(channel, slot);
                self.onwards[slot]
            }
            known => known,
        };
        if onwards >> number(corner.leaving) & 1 == 0 {
            return; // A dead end.
        }
        for step in motion.enter(search, &self.labels, before, corner).into_iter().flatten() {
            let label = Label {
                state: step.state,
                length: step.length,
                channel: channel as u32,
                slot: slot as u32,
                before,
                next: self.heads[slot],
                junctions: junctions + 1,
                way: Way::new(corner.approach, corner.leaving, forced),
                beaten: false,
            };
            if motion.compare(&mut self.labels, &label) {
                // Labels are fewer than `NONE`: there are at most 24 per step, and memory
                // ends before.
                let index = self.labels.len() as u32;
                self.heads[slot] = index;
                let Label { junctions, slot, .. } = label;
                self.labels.push(label);
                self.open.push(Entry { estimate: step.estimate, junctions, slot, label: index });
            }
        }
    }

    /// Opens the way out of the last channel, or to the goal.
    fn finish(
        &mut self,
        search: &Search<'_, D>,
        motion: &M,
        last: usize,
        before: u32,
        junctions: u32,
    ) {
        let Some(length) = motion.finish(search, &self.labels, before) else { return };
        let index = self.ends.len() as u32;
        self.ends.push(Ending { length, channel: last as u32, before });
        self.open.push(Entry { estimate: length, junctions, slot: NONE, label: index });
    }

    /// Refills the route with the channels that lead to an end.
    fn trace(&mut self, end: u32) {
        let Ending { channel, before, .. } = self.ends[end as usize];
        self.route.clear();
        self.route.push(channel as usize);
        let mut at = before;
        while let Some(label) = self.labels.get(at as usize) {
            self.route.push(label.channel as usize);
            at = label.before;
        }
        self.route.reverse();
    }
}

/// Whether the middle of the common part of two channels lies that way from `center`.
fn lies_towards<const D: usize>(
    direction: Direction,
    center: &Vector<D>,
    one: &AxisBox<D>,
    other: &AxisBox<D>,
) -> bool {
    let Direction { axis, sign } = direction;
    let (min, max) =
        (one.min()[axis].max(other.min()[axis]), one.max()[axis].min(other.max()[axis]));
    Sign::of((min + max) / 2.0 - center[axis]) == sign
}

fn or_all<const D: usize>(axes: u8) -> u8 {
    if axes == 0 { all_axes::<D>() } else { axes }
}

/// The mouth of the channels that reach farthest along the exit.
fn farthest<const D: usize>(channels: &[AxisBox<D>], exit: Direction) -> Option<HalfSpace> {
    let mouths = channels.iter().map(|channel| mouth_of(channel, exit));
    let reach = |mouth: &HalfSpace| exit.sign.factor() * mouth.bound;
    mouths.reduce(|a, b| if reach(&b) > reach(&a) { b } else { a })
}

fn holds<const D: usize>(channel: &AxisBox<D>, min: &Vector<D>, max: &Vector<D>) -> bool {
    (0..D).all(|axis| channel.min()[axis] <= min[axis] && max[axis] <= channel.max()[axis])
}

impl<const D: usize> Search<'_, D> {
    /// The channels that the traveller is in, in ascending order.
    fn find_starts(&self, starts: &mut Vec<usize>) -> Result<(), RouteError> {
        let Traveller { least, greatest, .. } = &self.traveller;
        let channels = self.graph.channels();
        starts.clear();
        self.graph.tree().visit(least, least, 0.0, |index| {
            if holds(&channels[index], least, greatest) {
                starts.push(index);
            }
            0.0
        });
        starts.sort_unstable();
        if starts.is_empty() {
            let (channel, axis, body, end) = refusal::nearest(channels, least, greatest);
            return Err(RouteError::StartOutside { channel, axis, body, end });
        }
        Ok(())
    }

    fn check_goal(&self) -> Result<(), RouteError> {
        let End::Goal(goal) = self.traveller.end else { return Ok(()) };
        let channels = self.graph.channels();
        let mut found = false;
        self.graph.tree().visit(&goal, &goal, 0.0, |_| {
            found = true;
            -1.0
        });
        if !found {
            let (channel, axis, goal, end) = refusal::nearest(channels, &goal, &goal);
            return Err(RouteError::GoalOutside { channel, axis, goal, end });
        }
        Ok(())
    }

    fn ends_in(&self, index: usize) -> bool {
        let channel = &self.graph.channels()[index];
        match self.traveller.end {
            End::Exit(exit) => Some(mouth_of(channel, exit)) == self.mouth,
            End::Goal(goal) => holds(channel, &goal, &goal),
        }
    }

    /// The directions in which something lies in the channel behind a slot: another
    /// junction, or the end.
    fn onwards(&self, before: usize, slot: usize) -> u8 {
        let (graph, here) = (self.graph, self.graph.neighbour_at(slot));
        let directions = (0..D).flat_map(|axis| SIGNS.map(|sign| Direction { axis, sign }));
        if self.ends_in(here) {
            return directions.fold(0, |bits, direction| bits | 1 << number(direction));
        }
        let channel = &graph.channels()[here];
        let Some(junction) = graph.channels()[before].intersection(channel) else { return 0 };
        let center = junction.center();
        let others = || graph.slots(here).map(|slot| graph.neighbour_at(slot));
        let leads_on = |direction: &Direction| {
            others().any(|other| {
                let other = (other != before).then(|| &graph.channels()[other]);
                other.is_some_and(|other| lies_towards(*direction, &center, channel, other))
            })
        };
        directions.filter(leads_on).fold(0, |bits, direction| bits | 1 << number(direction))
    }

    /// The junction of a channel with its neighbour, if the traveller fits.
    fn passable(&self, channel: &AxisBox<D>, slot: usize) -> Option<AxisBox<D>> {
        let next = &self.graph.channels()[self.graph.neighbour_at(slot)];
        channel.intersection(next).filter(|junction| self.traveller.fits(junction))
    }
}

#[cfg(test)]
mod tests;
