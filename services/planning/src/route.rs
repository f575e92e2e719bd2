//! The way through channels that are in any order.

use crate::budget::{Budget, Cap, Held, Spent};
use crate::free_space::End;
use crate::free_space::graph::Graph;
use crate::free_space::walls::Walls;
use crate::geometry::Sign;
use std::collections::BinaryHeap;
use std::mem;

mod blocked;
mod driving;
mod error;
mod judgement;
mod label;
mod mover;
mod refusal;
mod search;
mod translating;
mod traveller;
mod walk;
mod widest;

pub use blocked::{Blocked, Passage, Place, blocked};
pub use driving::Driving;
pub use error::RouteError;
pub use judgement::Judgement;
pub use label::Label;
pub use mover::Motion;
pub use search::Search;
pub use translating::Translating;
pub use traveller::Traveller;

use label::{Ending, Entry, NONE};
use search::farthest;
use widest::is_of_the_search;

const SIGNS: [Sign; 2] = [Sign::Negative, Sign::Positive];

/// How many routes may be blocked before the search is given up.
const MOST_BLOCKED: usize = 16;

/// The second search of a robot's route may take so many times the steps of the first, and so
/// many more.
const EFFORT: usize = 4;
const LEAST_EFFORT: usize = 3 << 18;

/// As many ways are compared in the time that a pair of junctions takes.
const LOOKS_OF_A_STEP: usize = 32;

/// For every slot its first label, and which directions lead on.
const BYTES_PER_SLOT: usize = size_of::<u32>() + size_of::<u8>();

/// So many slots are cleared in the time that a pair of junctions takes.
const SLOTS_PER_STEP: u64 = 16;

/// No set of directions.
const UNKNOWN: u8 = u8::MAX;

/// Lengths that differ by no more are the same, metres.
const SAME_LENGTH: f64 = 1e-9;

/// Looks for routes, in memory that is used again.
///
/// # What is shortest
///
/// The route is the one whose [`Chain`](crate::free_space::Chain) has the shortest path by the
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
/// bound and looks for the shortest, as far as it comes in some 800,000 steps and four times
/// those of the first. In corridors it comes to the end. In the open, where a line leads through
/// many junctions in many orders, it may not: then the route stands that was found first (over
/// fields of pillars 0.2 % longer than need be). Only routes count whose path leads through
/// their junctions and passes each corner at the gap, however far: others may cut a corner.
///
/// Time goes with the pairs of junctions passed one after the other: n log n for n
/// channels that meet a few others each; a channel with k junctions may cost k^2.
/// Memory is `8 D + 56` bytes (for a robot 104) for every way found to a state (some ten
/// per junction), and 10 bytes per junction.
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
    /// Pairs of junctions looked at.
    steps: usize,
    /// Steps and looks that have been drawn from the budget.
    drawn: usize,
    /// Ways found before that new ones were compared with.
    looks: usize,
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
            drawn: 0,
            looks: 0,
            route: Vec::new(),
            length: 0.0,
            first: None,
        }
    }
}

/// What a route is judged by.
type Judge<'a, T> = dyn FnMut(&[usize], f64) -> Result<Judgement<T>, Spent> + 'a;

/// What came of one search.
enum Found<T> {
    /// The route is there, and this is what the judge made of it.
    Route(T),
    /// No way leads to the end.
    Nothing,
    /// The shortest is blocked, and what blocks it is ruled out from here on.
    Blocked,
    /// Looking on is of no use, or would take too long.
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

    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        let labels = self.labels.capacity() * size_of::<Label<M::State>>();
        let slots = self.heads.capacity() * size_of::<u32>() + self.onwards.capacity();
        let open = self.open.capacity() * size_of::<Entry>();
        let ends = self.ends.capacity() * size_of::<Ending>();
        let channels = self.seen.capacity();
        let indices = (self.starts.capacity() + self.route.capacity()) * size_of::<usize>();
        let first = self.first.as_ref().map_or(0, |first| first.bytes());
        labels + slots + open + ends + channels + indices + first
    }

    /// Finds the shortest route: out of a channel that reaches farthest along an exit, or
    /// to a goal (where the traveller's centre is to be). Each search looks at no more pairs of
    /// junctions than [`Cap::RouteSteps`], or compares as many ways as would take that time.
    pub fn find(
        &mut self,
        graph: &Graph<D>,
        motion: &mut M,
        budget: &Budget<'_>,
    ) -> Result<(), RouteError> {
        self.find_judged(graph, None, motion, budget, |_, length| {
            Ok(Judgement::Accepted { length, value: () })
        })
    }

    /// Finds the shortest route that can be followed, as `judge` finds out: it is given a
    /// route and its length by the search, metres. Returns what the judge made of the route that
    /// is taken. What blocks a route is avoided from there on, until as many as 16 have
    /// been refused. Where a robot is told of `walls`, it leaves out lines that touch them at
    /// once.
    pub fn find_judged<T>(
        &mut self,
        graph: &Graph<D>,
        walls: Option<&Walls<D>>,
        motion: &mut M,
        budget: &Budget<'_>,
        mut judge: impl FnMut(&[usize], f64) -> Result<Judgement<T>, Spent>,
    ) -> Result<T, RouteError> {
        self.route.clear();
        self.length = 0.0;
        let found = self.try_find((graph, walls), motion, budget, &mut judge);
        if found.is_err() {
            self.route.clear();
        }
        found
    }

    fn try_find<T>(
        &mut self,
        (graph, walls): (&Graph<D>, Option<&Walls<D>>),
        motion: &mut M,
        budget: &Budget<'_>,
        judge: &mut Judge<'_, T>,
    ) -> Result<T, RouteError> {
        if graph.channels().is_empty() {
            return Err(RouteError::NoChannels);
        }
        let traveller = *motion.traveller();
        budget.step(graph.channels().len() as u64)?;
        let mouth = match traveller.end {
            End::Exit(exit) => farthest(graph.channels(), exit),
            End::Goal(_) => None,
        };
        let search = Search { graph, traveller, mouth, walls, budget };
        search.find_starts(&mut self.starts)?;
        search.check_goal()?;
        let slots = graph.slot_count();
        let _held = Held::new(budget, slots * BYTES_PER_SLOT + graph.channels().len())?;
        budget.step(slots as u64 / SLOTS_PER_STEP)?;
        self.onwards.clear();
        self.onwards.resize(slots, UNKNOWN);
        if let Some(margin) = motion.outline() {
            return self.find_from_outline(&search, motion, margin, judge);
        }
        if !self.is_connected(&search)? {
            return self.judge_any(&search, judge);
        }
        self.find_shortest(&search, motion, (f64::INFINITY, usize::MAX), judge)
    }

    /// Finds a route by the outline of the motion, and then looks for a shorter one.
    fn find_from_outline<T>(
        &mut self,
        search: &Search<'_, D>,
        motion: &mut M,
        margin: f64,
        judge: &mut Judge<'_, T>,
    ) -> Result<T, RouteError> {
        let budget = search.budget;
        let mut first = mem::take(&mut self.first).unwrap_or_default();
        let mut outline = Translating::with_margin(search.traveller, margin);
        let mut length = f64::INFINITY;
        let found = first.find_judged(search.graph, None, &mut outline, budget, |route, along| {
            Ok(match judge(route, along)? {
                Judgement::Accepted { length: exact, value } => {
                    length = exact;
                    Judgement::Accepted { length: along, value }
                }
                refused => refused,
            })
        });
        let effort = first.steps.saturating_mul(EFFORT).saturating_add(LEAST_EFFORT);
        let found = match found {
            Ok(value) => match self.find_shortest(search, motion, (length, effort), judge) {
                Err(RouteError::Spent(spent)) if !is_of_the_search(&spent) => Err(spent.into()),
                // None is shorter, or it would take too long to tell.
                Err(_) => {
                    self.route.clone_from(&first.route);
                    self.length = length;
                    Ok(value)
                }
                shorter => shorter,
            },
            Err(RouteError::Blocked) => {
                match self.find_shortest(search, motion, (f64::INFINITY, effort), judge) {
                    Err(RouteError::Spent(spent)) if !is_of_the_search(&spent) => Err(spent.into()),
                    shortest => shortest.map_err(|_| RouteError::Blocked),
                }
            }
            Err(error) => Err(error),
        };
        self.first = Some(first);
        found
    }

    /// Finds the shortest route that is shorter than a bound, in no more than so many steps.
    fn find_shortest<T>(
        &mut self,
        search: &Search<'_, D>,
        motion: &mut M,
        bounds: (f64, usize),
        judge: &mut Judge<'_, T>,
    ) -> Result<T, RouteError> {
        search.budget.restart(Cap::RouteSteps);
        (self.steps, self.looks, self.drawn) = (0, 0, 0);
        let is_bounded = bounds.0.is_finite();
        for blocked in 0..MOST_BLOCKED {
            match self.search(search, motion, bounds, judge)? {
                Found::Route(value) => return Ok(value),
                Found::Blocked => {}
                Found::Nothing if blocked == 0 && !is_bounded => {
                    return self.judge_any(search, judge);
                }
                Found::Nothing | Found::Hopeless => break,
            }
        }
        Err(RouteError::Blocked)
    }

    /// Whether junctions that are large enough lead from a start to an end.
    fn is_connected(&mut self, search: &Search<'_, D>) -> Result<bool, Spent> {
        let Self { starts, seen, route: open, .. } = self;
        seen.clear();
        seen.resize(search.graph.channels().len(), false);
        open.clear();
        open.extend_from_slice(starts);
        starts.iter().for_each(|start| seen[*start] = true);
        while let Some(channel) = open.pop() {
            if search.ends_in(channel) {
                open.clear();
                return Ok(true);
            }
            let slots = search.graph.slots(channel);
            search.budget.step(slots.len() as u64)?;
            for slot in slots {
                let next = search.graph.neighbour_at(slot);
                let passable = || search.passable(&search.graph.channels()[channel], slot);
                if !seen[next] && passable().is_some() {
                    seen[next] = true;
                    open.push(next);
                }
            }
        }
        Ok(false)
    }

    /// Says why there is no route. If nothing can be said but that the path can't be made
    /// through junctions that are large enough, the judge is asked about that route.
    fn judge_any<T>(
        &mut self,
        search: &Search<'_, D>,
        judge: &mut Judge<'_, T>,
    ) -> Result<T, RouteError> {
        self.route = refusal::why_not(search, &self.starts)?;
        match judge(&self.route, f64::INFINITY)? {
            Judgement::Accepted { length, value } => {
                self.length = length;
                Ok(value)
            }
            _ => Err(RouteError::Blocked),
        }
    }

    fn search<T>(
        &mut self,
        search: &Search<'_, D>,
        motion: &mut M,
        bounds: (f64, usize),
        judge: &mut Judge<'_, T>,
    ) -> Result<Found<T>, RouteError> {
        self.labels.clear();
        self.ends.clear();
        self.open.clear();
        self.heads.clear();
        self.heads.resize(search.graph.slot_count(), NONE);
        let found = self.search_on(search, motion, bounds, judge);
        let labels = self.labels.len() * Self::BYTES_PER_LABEL;
        search.budget.release(labels + self.ends.len() * Self::BYTES_PER_ENDING);
        found
    }

    fn search_on<T>(
        &mut self,
        search: &Search<'_, D>,
        motion: &mut M,
        (bound, effort): (f64, usize),
        judge: &mut Judge<'_, T>,
    ) -> Result<Found<T>, RouteError> {
        for index in 0..self.starts.len() {
            self.start_in(search, motion, self.starts[index])?;
        }
        // The shortest of those that are longer than the search had it.
        let mut longer: Option<(u32, f64, T)> = None;
        while let Some(entry) = self.open.pop() {
            if entry.estimate >= bound {
                return Ok(Found::Hopeless);
            }
            if entry.slot == NONE {
                let Ending { length, before, .. } = self.ends[entry.label as usize];
                self.trace(entry.label);
                if let Some((.., value)) = longer.take_if(|(end, ..)| *end == entry.label) {
                    self.length = length;
                    return Ok(Found::Route(value));
                }
                search.budget.step(self.route.len() as u64)?;
                match judge(&self.route, length)? {
                    Judgement::Accepted { length: exact, value }
                        if exact <= length + SAME_LENGTH =>
                    {
                        self.length = exact;
                        return Ok(Found::Route(value));
                    }
                    // Others may be shorter.
                    Judgement::Accepted { length: exact, value } => {
                        self.ends[entry.label as usize].length = exact;
                        self.open.push(Entry { estimate: exact, ..entry });
                        if longer.as_ref().is_none_or(|(_, least, _)| exact < *least) {
                            longer = Some((entry.label, exact, value));
                        }
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
                self.go_on(search, motion, entry.label, &label)?;
            }
            let steps = self.steps + self.looks / LOOKS_OF_A_STEP;
            if steps > effort {
                return Ok(Found::Hopeless);
            }
            search.budget.draw(Cap::RouteSteps, (steps - self.drawn) as u64)?;
            self.drawn = steps;
        }
        Ok(Found::Nothing)
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

#[cfg(test)]
mod tests;
