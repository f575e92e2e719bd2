//! Routes: the order in which to travel channels that are given in any order.
//!
//! [`Router`] searches for all movers ([`BodyMover`] by Table 1, [`RobotMover`] on guiding
//! circles); [`blocked`] explains why there is no route between solids.

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

pub use blocked::{Blocked, Passage, Region, blocked};
pub use driving::RobotMover;
pub use error::RouteError;
pub use judgement::Judgement;
pub use label::Label;
pub use mover::Mover;
pub use search::Search;
pub use translating::BodyMover;
pub use traveller::Traveller;

use label::{Ending, Entry, NONE};
use search::farthest;
use widest::is_of_the_search;

const SIGNS: [Sign; 2] = [Sign::Negative, Sign::Positive];

/// The search ends after this many blocked routes.
const MOST_BLOCKED: usize = 16;

/// The second search for a robot's route may take this many times the steps of the first, plus
/// [`LEAST_EFFORT`].
const EFFORT: usize = 4;
const LEAST_EFFORT: usize = 3 << 18;

/// Ways compared in the time that one pair of junctions takes.
const LOOKS_OF_A_STEP: usize = 32;

/// Steps of the budget that a pair of junctions takes, each way into the second of them, and
/// each way found before that it is compared with.
const STEPS_PER_PAIR: usize = 4;
const STEPS_PER_WAY: u64 = 10;
const STEPS_PER_LOOK: usize = 1;

/// For every slot its first label, and the directions that lead on.
const BYTES_PER_SLOT: usize = size_of::<u32>() + size_of::<u8>();

/// Slots cleared in one step.
const SLOTS_PER_STEP: u64 = 16;

/// Channels passed over in one step.
const CHANNELS_PER_STEP: u64 = 4;

/// Directions not known yet.
const UNKNOWN: u8 = u8::MAX;

/// Lengths that differ by no more than this count as equal, metres.
const SAME_LENGTH: f64 = 1e-9;

/// Searches for routes. Reusable memory.
///
/// # The shortest route
///
/// Of all sequences of channels that never turn back through the junction they came by, the
/// route is the one whose [`Chain`](crate::free_space::Chain) has the shortest path by the
/// rules: by [`crate::disassembly::disassemble`], the way out included, for a body
/// ([`BodyMover`]), and by [`crate::driving::route`] for a robot ([`RobotMover`]). A channel may
/// be travelled twice if that is shorter. Ties are always decided alike: for the fewest
/// channels, then for the lowest index where the search met them.
///
/// # The search
///
/// Where a rule puts a body in a junction, and which corner a robot turns about, depends on the
/// directions in which it comes and goes, which a chain takes from the centres of the junctions
/// before and after. So the search (A*, by the straight line to the mouth or the goal) runs over
/// junctions with both directions and one bit: whether the channel before had a choice of axes.
/// Thus it chooses axes as a chain does. What else the length of a path depends on, and when one
/// way into a junction makes another useless, is up to the [`Mover`].
///
/// A robot's route is searched for twice. The first search takes straight lines from junction to
/// junction ([`Mover::outline`]) and is quick. The second takes the result as a bound and looks
/// for the shortest route, within some 800,000 steps and four times those of the first. In
/// corridors it completes. In the open, where a line passes many junctions in many orders, it may
/// not; then the first result stands (over fields of pillars 0.2 % longer than the shortest).
/// Only routes count whose path leads through their junctions and passes each corner at the gap
/// or farther; others might cut a corner.
///
/// Time grows with the pairs of consecutive junctions: n log n for n channels that each meet a
/// few others; a channel with k junctions may cost k^2. Memory is `8 D + 56` bytes (104 for a
/// robot) for every way found into a state (some ten per junction), and 10 per junction.
///
/// ```
/// use planning::budget::Budget;
/// use planning::disassembly::Gap;
/// use planning::free_space::End;
/// use planning::free_space::graph::Graph;
/// use planning::geometry::{AxisBox, Direction, Sign};
/// use planning::route::{BodyMover, Router};
///
/// // Section 4's channels C_1, C_2, C_3, given in any order.
/// let space = |min: [f64; 2], max: [f64; 2]| AxisBox::new(min.into(), max.into());
/// let channels = [
///     space([1.0, 2.0], [5.0, 7.0])?,
///     space([1.0, 2.0], [7.0, 6.0])?,
///     space([4.0, 1.0], [7.0, 6.0])?,
/// ];
/// let (mut graph, budget) = (Graph::default(), Budget::default());
/// graph.build(&channels, &budget)?;
///
/// let male = space([4.5, 1.01], [6.99, 4.0])?;
/// let exit = End::Exit(Direction { axis: 1, sign: Sign::Positive });
/// let mut body = BodyMover::new(&male, Gap::Uniform(0.2), exit)?;
/// let mut router = Router::default();
/// router.find(&graph, &mut body, &budget)?;
/// assert_eq!(router.route(), [2, 1, 0]);
/// assert!((router.length() - 7.40323366632768).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Router<const D: usize, M: Mover<D>> {
    labels: Vec<Label<M::State>>,
    /// The first label of every slot.
    heads: Vec<u32>,
    /// The directions that lead on from the junction of every slot, as bits, once known.
    onwards: Vec<u8>,
    ends: Vec<Ending>,
    open: BinaryHeap<Entry>,
    starts: Vec<usize>,
    seen: Vec<bool>,
    /// Pairs of junctions looked at.
    steps: usize,
    /// Steps and looks drawn from the budget so far.
    drawn: usize,
    /// What of their time has been drawn, steps.
    worked: usize,
    /// Comparisons of a new way with a known one.
    looks: usize,
    route: Vec<usize>,
    length: f64,
    /// For the outline of a motion.
    first: Option<Box<Router<D, BodyMover<D>>>>,
}

impl<const D: usize, M: Mover<D>> Default for Router<D, M> {
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
            worked: 0,
            looks: 0,
            route: Vec::new(),
            length: 0.0,
            first: None,
        }
    }
}

/// Judges a route by following it.
type Judge<'a, T> = dyn FnMut(&[usize], f64) -> Result<Judgement<T>, Spent> + 'a;

/// The outcome of one search.
enum Found<T> {
    /// A route, with what the judge made of it.
    Route(T),
    /// No route.
    Nothing,
    /// The shortest route is blocked; what blocks it is ruled out from now on.
    Blocked,
    /// Further search is useless or would take too long.
    Hopeless,
}

impl<const D: usize, M: Mover<D>> Router<D, M> {
    /// The last route found: indices of channels in travel order. Empty after an error.
    pub fn route(&self) -> &[usize] {
        &self.route
    }

    /// Length of the path by the rules along the route, metres.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Memory held, bytes.
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

    /// Finds the shortest route: out of a channel that reaches farthest along an exit, or to
    /// a goal for the traveller's centre. Each search is limited to [`Cap::RouteSteps`] pairs of
    /// junctions, comparisons of ways counted by the time that they take.
    pub fn find(
        &mut self,
        graph: &Graph<D>,
        mover: &mut M,
        budget: &Budget<'_>,
    ) -> Result<(), RouteError> {
        self.find_judged(graph, None, mover, budget, |_, length| {
            Ok(Judgement::Accepted { length, value: () })
        })
    }

    /// Finds the shortest route that can be followed, according to `judge`, which is given a
    /// route and its length by the search, metres. Returns what the judge made of the route. What
    /// blocks a route is avoided from then on; the search ends after 16 blocked routes. A robot
    /// that knows `walls` rejects lines that touch them during the search.
    pub fn find_judged<T>(
        &mut self,
        graph: &Graph<D>,
        walls: Option<&Walls<D>>,
        mover: &mut M,
        budget: &Budget<'_>,
        mut judge: impl FnMut(&[usize], f64) -> Result<Judgement<T>, Spent>,
    ) -> Result<T, RouteError> {
        self.route.clear();
        self.length = 0.0;
        let found = self.try_find((graph, walls), mover, budget, &mut judge);
        if found.is_err() {
            self.route.clear();
        }
        found
    }

    fn try_find<T>(
        &mut self,
        (graph, walls): (&Graph<D>, Option<&Walls<D>>),
        mover: &mut M,
        budget: &Budget<'_>,
        judge: &mut Judge<'_, T>,
    ) -> Result<T, RouteError> {
        if graph.channels().is_empty() {
            return Err(RouteError::NoChannels);
        }
        let traveller = *mover.traveller();
        budget.step(graph.channels().len() as u64 / CHANNELS_PER_STEP)?;
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
        if let Some(margin) = mover.outline() {
            return self.find_from_outline(&search, mover, margin, judge);
        }
        if !self.is_connected(&search)? {
            return self.judge_any(&search, judge);
        }
        self.find_shortest(&search, mover, (f64::INFINITY, usize::MAX), judge)
    }

    /// Finds a route by the outline of the motion, then searches for a shorter one.
    fn find_from_outline<T>(
        &mut self,
        search: &Search<'_, D>,
        mover: &mut M,
        margin: f64,
        judge: &mut Judge<'_, T>,
    ) -> Result<T, RouteError> {
        let budget = search.budget;
        let mut first = mem::take(&mut self.first).unwrap_or_default();
        let mut outline = BodyMover::with_margin(search.traveller, margin);
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
            Ok(value) => match self.find_shortest(search, mover, (length, effort), judge) {
                Err(RouteError::Spent(spent)) if !is_of_the_search(&spent) => Err(spent.into()),
                // No route is shorter, or it would take too long to tell.
                Err(_) => {
                    self.route.clone_from(&first.route);
                    self.length = length;
                    Ok(value)
                }
                shorter => shorter,
            },
            Err(RouteError::Blocked) => {
                match self.find_shortest(search, mover, (f64::INFINITY, effort), judge) {
                    Err(RouteError::Spent(spent)) if !is_of_the_search(&spent) => Err(spent.into()),
                    shortest => shortest.map_err(|_| RouteError::Blocked),
                }
            }
            Err(error) => Err(error),
        };
        self.first = Some(first);
        found
    }

    /// Finds the shortest route below a bound on length, within a number of steps.
    fn find_shortest<T>(
        &mut self,
        search: &Search<'_, D>,
        mover: &mut M,
        bounds: (f64, usize),
        judge: &mut Judge<'_, T>,
    ) -> Result<T, RouteError> {
        search.budget.restart(Cap::RouteSteps);
        (self.steps, self.looks, self.drawn, self.worked) = (0, 0, 0, 0);
        let is_bounded = bounds.0.is_finite();
        for blocked in 0..MOST_BLOCKED {
            match self.search(search, mover, bounds, judge)? {
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

    /// Whether large enough junctions lead from a start to an end.
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

    /// Finds out why there is no route. If all junctions are large enough, but no path by the
    /// rules leads through them, the judge decides about that route.
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
        mover: &mut M,
        bounds: (f64, usize),
        judge: &mut Judge<'_, T>,
    ) -> Result<Found<T>, RouteError> {
        self.labels.clear();
        self.ends.clear();
        self.open.clear();
        self.heads.clear();
        self.heads.resize(search.graph.slot_count(), NONE);
        let found = self.search_on(search, mover, bounds, judge);
        let labels = self.labels.len() * Self::BYTES_PER_LABEL;
        search.budget.release(labels + self.ends.len() * Self::BYTES_PER_ENDING);
        found
    }

    fn search_on<T>(
        &mut self,
        search: &Search<'_, D>,
        mover: &mut M,
        (bound, effort): (f64, usize),
        judge: &mut Judge<'_, T>,
    ) -> Result<Found<T>, RouteError> {
        for index in 0..self.starts.len() {
            self.start_in(search, mover, self.starts[index])?;
        }
        // The shortest of the routes that turned out longer than in the search.
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
                    // Other routes may be shorter.
                    Judgement::Accepted { length: exact, value } => {
                        self.ends[entry.label as usize].length = exact;
                        self.open.push(Entry { estimate: exact, ..entry });
                        if longer.as_ref().is_none_or(|(_, least, _)| exact < *least) {
                            longer = Some((entry.label, exact, value));
                        }
                    }
                    Judgement::Blocked(junction) => {
                        return Ok(match mover.avoid(&self.labels, before, junction) {
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
                self.go_on(search, mover, entry.label, &label)?;
            }
            let steps = self.steps + self.looks / LOOKS_OF_A_STEP;
            if steps > effort {
                return Ok(Found::Hopeless);
            }
            search.budget.draw(Cap::RouteSteps, (steps - self.drawn) as u64)?;
            self.drawn = steps;
            let work = STEPS_PER_PAIR * self.steps + STEPS_PER_LOOK * self.looks;
            search.budget.step((work - self.worked) as u64)?;
            self.worked = work;
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
