//! The way through channels that are in any order.

use super::graph::Graph;
use super::{Corner, End, HalfSpace, all_axes, longest, mouth_of, proper, towards};
use crate::disassembly::{out_of_the_mouth, target};
use crate::geometry::{AxisBox, Direction, Sign, Vector};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

mod blocked;
mod error;
mod refusal;
mod traveller;
mod widest;

pub use blocked::{Blocked, Passage, Place, blocked};
pub use error::RouteError;
pub use traveller::Traveller;

const NONE: u32 = u32::MAX;

const SIGNS: [Sign; 2] = [Sign::Negative, Sign::Positive];

/// Looks for routes, in memory that is used again.
///
/// # What is shortest
///
/// The route is the one whose [`Chain`](super::Chain) has the shortest path by the
/// rules, of all sequences of channels that do not go straight back through the
/// junction they came by. For a body that is the length that
/// [`crate::disassembly::disassemble`] gives, the way out included; for a robot see
/// [`Traveller::robot`]. A channel may be travelled twice where that is shorter
/// than any way without. Of several routes of the very same length one is always
/// the same: it has the fewest channels, and then the lowest index where the
/// search met them.
///
/// # How
///
/// Where the rule puts a body in a junction depends on the directions in which it
/// comes and goes, which the chain takes from the centres of the junctions before
/// and after. So the search (A*, by what is missing to the mouth or the goal in a
/// straight line) goes over junctions with both directions, and one bit that says
/// whether the channel before had a choice of axes; this makes the chain's choice
/// the search's own. In three dimensions the coordinate that a rule leaves alone
/// depends on everything before; a state then keeps every way to it that is not
/// beaten by another for all that may follow, which is by more than the difference
/// of the two coordinates.
///
/// Time goes with the pairs of junctions passed one after the other: n log n for n
/// channels that meet a few others each; a channel with k junctions may cost k^2.
/// Memory is `8 D + 104` bytes for every way found to a state (some ten per
/// junction), and never for more of them than 12 per pair.
#[derive(Debug, Clone, Default)]
pub struct Router<const D: usize> {
    labels: Vec<Label<D>>,
    /// For every junction and way through it the first label.
    heads: Vec<u32>,
    open: BinaryHeap<Entry>,
    starts: Vec<usize>,
    steps: usize,
    route: Vec<usize>,
    length: f64,
}

/// How a junction is passed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Way {
    approach: Direction,
    leaving: Direction,
    /// Whether the channel before could only have the axis it has.
    forced: bool,
}

/// A way to a state.
#[derive(Debug, Clone, Copy)]
struct Label<const D: usize> {
    /// Displacement there, metres.
    at: Vector<D>,
    /// Length so far, metres.
    length: f64,
    /// The channel before the junction; the last channel at the end.
    channel: u32,
    /// The junction, as the channel's slot; `NONE` at the end.
    slot: u32,
    /// The label before.
    before: u32,
    /// The next label of this slot.
    next: u32,
    junctions: u32,
    way: Way,
    beaten: bool,
}

/// An open label; the greatest comes first.
#[derive(Debug, Clone, Copy)]
struct Entry {
    /// Length so far and what is missing at least, metres.
    estimate: f64,
    junctions: u32,
    slot: u32,
    label: u32,
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |entry: &Self| (entry.junctions, entry.slot, entry.label);
        other.estimate.total_cmp(&self.estimate).then_with(|| key(other).cmp(&key(self)))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Entry {}

/// What is looked for.
struct Search<'a, const D: usize> {
    graph: &'a Graph<D>,
    traveller: &'a Traveller<D>,
    end: End<D>,
    /// With an exit: where the channels that reach farthest along it end.
    mouth: Option<HalfSpace>,
}

impl<const D: usize> Router<D> {
    /// The route found last: indices of channels in travel order. Empty after an error.
    pub fn route(&self) -> &[usize] {
        &self.route
    }

    /// The length of the path by the rules along the route, metres.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Finds the shortest route from where the traveller is to `end`: out of a
    /// channel that reaches farthest along an exit, or to a goal (where the
    /// traveller's centre is to be). Looks at no more than `most_steps` pairs of
    /// junctions.
    pub fn find(
        &mut self,
        graph: &Graph<D>,
        traveller: &Traveller<D>,
        end: End<D>,
        most_steps: usize,
    ) -> Result<(), RouteError> {
        self.route.clear();
        self.length = 0.0;
        self.steps = 0;
        if graph.channels().is_empty() {
            return Err(RouteError::NoChannels);
        }
        let mouth = match end {
            End::Exit(exit) => farthest(graph.channels(), exit),
            End::Goal(_) => None,
        };
        let search = Search { graph, traveller, end, mouth };
        search.find_starts(&mut self.starts)?;
        search.check_goal()?;
        self.search(&search, most_steps)?;
        if self.route.is_empty() {
            return Err(refusal::why_not(&search, &self.starts, most_steps));
        }
        Ok(())
    }

    fn search(&mut self, search: &Search<'_, D>, most_steps: usize) -> Result<(), RouteError> {
        self.labels.clear();
        self.open.clear();
        self.heads.clear();
        self.heads.resize(search.graph.slot_count(), NONE);
        for index in 0..self.starts.len() {
            self.start_in(search, self.starts[index]);
        }
        while let Some(entry) = self.open.pop() {
            let label = self.labels[entry.label as usize];
            if label.slot == NONE {
                self.trace(entry.label);
                return Ok(());
            }
            if !label.beaten {
                self.go_on(search, entry.label, &label);
            }
            if self.steps > most_steps {
                return Err(RouteError::TooManySteps { has: self.steps, most: most_steps });
            }
        }
        Ok(())
    }

    /// All first steps out of a channel that the traveller is in.
    fn start_in(&mut self, search: &Search<'_, D>, first: usize) {
        let channel = &search.graph.channels()[first];
        let start = search.traveller.center();
        let at = Vector::zeros();
        if search.ends_in(first) {
            // Any axis will do.
            self.finish(search, first, NONE, &at, 0.0, 0);
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
                    self.enter(search, (first, slot), corner, forced, (NONE, &at, 0.0, 0));
                }
            }
        }
    }

    /// All steps on from a junction.
    fn go_on(&mut self, search: &Search<'_, D>, index: u32, label: &Label<D>) {
        let Way { approach, leaving, forced } = label.way;
        let (graph, before) = (search.graph, label.channel as usize);
        let here = graph.neighbour_at(label.slot as usize);
        let channel = &graph.channels()[here];
        let Some(from) = graph.channels()[before].intersection(channel) else { return };
        let center = from.center();
        let mine = proper(&from, channel);
        // What the channel before needs for itself.
        let taken = if forced { 1 << approach.axis } else { 0 };

        if search.ends_in(here) {
            let out = match search.end {
                End::Exit(exit) => (taken >> exit.axis & 1 == 0).then_some(exit),
                End::Goal(goal) => longest(or_all::<D>(mine) & !taken, &center, &goal)
                    .map(|axis| towards(&center, &goal, axis)),
            };
            if out == Some(leaving) {
                self.finish(search, here, index, &label.at, label.length, label.junctions);
            }
        }
        for slot in graph.slots(here) {
            self.steps += 1;
            if graph.neighbour_at(slot) == before {
                continue;
            }
            let Some(junction) = search.passable(channel, slot) else { continue };
            let next = junction.center();
            let possible = or_all::<D>(mine | proper(&junction, channel)) & !taken;
            if towards(&center, &next, leaving.axis) != leaving {
                continue;
            }
            for axis in (0..D).filter(|axis| *axis != leaving.axis) {
                if longest(possible & !(1 << axis), &center, &next) != Some(leaving.axis) {
                    continue;
                }
                for sign in SIGNS {
                    let corner =
                        Corner { junction, approach: leaving, leaving: Direction { axis, sign } };
                    let forced = possible.count_ones() == 1;
                    let from = (index, &label.at, label.length, label.junctions);
                    self.enter(search, (here, slot), corner, forced, from);
                }
            }
        }
    }

    /// Opens the label of a step into a junction, unless it is beaten.
    fn enter(
        &mut self,
        search: &Search<'_, D>,
        (channel, slot): (usize, usize),
        corner: Corner<D>,
        forced: bool,
        (before, from, length, junctions): (u32, &Vector<D>, f64, u32),
    ) {
        let next = search.graph.neighbour_at(slot);
        if search.graph.slots(next).len() == 1 && !search.ends_in(next) {
            return; // A dead end.
        }
        let Traveller { least, greatest, .. } = search.traveller;
        let gap = search.traveller.gap_in(&corner.junction);
        let (at, _) = target(&corner, (least, greatest), gap.as_ref(), from);
        let length = length + (at - from).norm();
        let way = Way { approach: corner.approach, leaving: corner.leaving, forced };

        let mut previous = NONE;
        let mut other = self.heads[slot];
        while other != NONE {
            let known = &mut self.labels[other as usize];
            let following = known.next;
            if known.way == way {
                let apart = (known.at - at).abs().sum();
                if known.length + apart <= length {
                    return;
                }
                if length + apart <= known.length {
                    known.beaten = true;
                    self.unlink(slot, previous, following);
                    other = following;
                    continue;
                }
            }
            previous = other;
            other = following;
        }
        let label = Label {
            at,
            length,
            channel: channel as u32,
            slot: slot as u32,
            before,
            next: self.heads[slot],
            junctions: junctions + 1,
            way,
            beaten: false,
        };
        self.heads[slot] = self.open(label, length + search.missing(&at));
    }

    fn unlink(&mut self, slot: usize, previous: u32, following: u32) {
        match self.labels.get_mut(previous as usize) {
            Some(label) => label.next = following,
            None => self.heads[slot] = following,
        }
    }

    /// Opens the label of the way out of the last channel, or to the goal.
    fn finish(
        &mut self,
        search: &Search<'_, D>,
        last: usize,
        before: u32,
        from: &Vector<D>,
        length: f64,
        junctions: u32,
    ) {
        let at = search.destination(from);
        let length = length + (at - from).norm();
        let nowhere = Direction { axis: 0, sign: Sign::Positive };
        self.open(
            Label {
                at,
                length,
                channel: last as u32,
                slot: NONE,
                before,
                next: NONE,
                junctions,
                way: Way { approach: nowhere, leaving: nowhere, forced: false },
                beaten: false,
            },
            length,
        );
    }

    fn open(&mut self, label: Label<D>, estimate: f64) -> u32 {
        // Labels are fewer than `NONE`: there are at most 12 per step, and memory ends before.
        let index = self.labels.len() as u32;
        let (junctions, slot) = (label.junctions, label.slot);
        self.labels.push(label);
        self.open.push(Entry { estimate, junctions, slot, label: index });
        index
    }

    fn trace(&mut self, last: u32) {
        self.length = self.labels[last as usize].length;
        let mut at = last;
        while let Some(label) = self.labels.get(at as usize) {
            self.route.push(label.channel as usize);
            at = label.before;
        }
        self.route.reverse();
    }
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
        let Traveller { least, greatest, .. } = self.traveller;
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
        let End::Goal(goal) = self.end else { return Ok(()) };
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
        match self.end {
            End::Exit(exit) => Some(mouth_of(channel, exit)) == self.mouth,
            End::Goal(goal) => holds(channel, &goal, &goal),
        }
    }

    /// The junction of a channel with its neighbour, if the traveller fits.
    fn passable(&self, channel: &AxisBox<D>, slot: usize) -> Option<AxisBox<D>> {
        let next = &self.graph.channels()[self.graph.neighbour_at(slot)];
        channel.intersection(next).filter(|junction| self.traveller.fits(junction))
    }

    /// Where the path ends that comes from `from`.
    fn destination(&self, from: &Vector<D>) -> Vector<D> {
        let Traveller { least, greatest, .. } = self.traveller;
        match (self.end, &self.mouth) {
            (End::Goal(goal), _) => goal - self.traveller.center(),
            (End::Exit(_), Some(mouth)) => out_of_the_mouth((least, greatest), mouth, *from),
            (End::Exit(_), None) => *from,
        }
    }

    /// What is missing at least.
    fn missing(&self, from: &Vector<D>) -> f64 {
        (self.destination(from) - from).norm()
    }
}

#[cfg(test)]
mod tests;
