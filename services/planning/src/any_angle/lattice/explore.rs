//! The search for a robot that turns in place.
//!
//! Where the robot can turn anywhere, a pose is a point, and the heading does not matter. Such
//! points are joined by straight lines: to the next bin in every direction of [`Headings`], to
//! the ends of narrow passages ([`passage`](super::passage)) and to the goal. In a fine search
//! there are poses in narrow places as well, one in each bin and heading, joined by straight lines
//! and by turns from one heading to the next.
//!
//! Poses are exact, bins only tell which are alike (hybrid A*: D. Dolgov, S. Thrun, M. Montemerlo
//! and J. Diebel, "Path planning for autonomous vehicles in unknown semi-structured environments",
//! International Journal of Robotics Research 29(5), 2010).

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::SQRT_2;

use super::field::{DETOUR, Field};
use super::headings::{Headings, SAME_HEADING};
use super::passage::GateAxis;
use super::probe::Probe;
use super::table::{NOTHING, Table};
use super::way::Way;
use crate::budget::{Cap, Held, Spent};
use crate::driving::shortest_turn;
use crate::geometry::{Vector, unit};

/// Steps of the budget that a node takes, and an offer of one.
const STEPS_PER_NODE: u64 = 10;
const STEPS_PER_OFFER: u64 = 3;

/// Any heading: the robot can turn anywhere there.
pub(super) const ANY: u16 = u16::MAX;

/// The same in the open, where bins are larger by this factor.
pub(super) const OPEN: u16 = ANY - 1;
pub(super) const OPEN_BINS: f64 = 4.0;

/// The key of the goal; those of stations have the highest bit and their index.
const GOAL: u64 = u64::MAX;
const STATION: u64 = 1 << 63;

/// Whatever direction a move has, it ends in another bin.
const MOVE: f64 = SQRT_2 * (1.0 + 1e-9);

/// How far from a station others are tried, in turning circles' radii; at least 4 bins.
const FAR: f64 = 6.0;

/// How far the way out of a narrow place may lead, in turning circles' radii.
const WAY_OUT: f64 = 16.0;

/// In a narrow place the robot turns by no more than this towards a station or the goal, radians.
const SMALL_TURN: f64 = 0.5;

/// A place that is not met by chance: an end of a passage, or a place before a narrow goal.
#[derive(Debug, Clone, Copy)]
struct Station {
    at: Vector<2>,
    /// The station at the other end of the passage, and whether it can be driven to forwards and
    /// backwards.
    passage: Option<(u32, [bool; 2])>,
    /// The heading of a free line to the goal, and whether it is driven backwards.
    arrival: Option<(f64, bool)>,
}

#[derive(Debug, Clone, Copy)]
struct PoseNode {
    at: Vector<2>,
    /// With which the robot arrives, radians.
    heading: f64,
    /// Whether it arrives backwards.
    back: bool,
    /// Whether it arrives by driving rather than by turning.
    moves: bool,
    /// The index of its heading in a narrow place, or [`ANY`].
    slot: u16,
    /// The distance from the walls is at least this, metres; or if less than the turning circle takes, at most.
    clear: f64,
    cost: f64,
    before: u32,
    key: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OpenPose {
    /// The cost of the way through a node at least, in small units: no rounding decides.
    pub(super) least: u64,
    pub(super) node: u32,
}

impl Ord for OpenPose {
    /// The least first, the first of equals.
    fn cmp(&self, other: &Self) -> Ordering {
        other.least.cmp(&self.least).then(other.node.cmp(&self.node))
    }
}

impl PartialOrd for OpenPose {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// PoseMemory of a search.
#[derive(Debug, Default)]
pub(super) struct PoseMemory {
    nodes: Vec<PoseNode>,
    heap: BinaryHeap<OpenPose>,
    table: Table,
    stations: Vec<Station>,
    /// The square in which each station lies, in order.
    squares: Vec<(i64, i64, u32)>,
    /// Whether the last search ended at its limit of steps.
    pub(super) is_cut_short: bool,
}

impl PoseMemory {
    pub(super) fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<PoseNode>()
            + self.heap.capacity() * size_of::<OpenPose>()
            + self.stations.capacity() * size_of::<Station>()
            + self.table.bytes()
    }
}

/// How a search is made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Manner {
    /// Side of a bin, metres.
    pub(super) bin: f64,
    /// Whether there are poses in narrow places.
    pub(super) is_fine: bool,
    /// Steps of the budget after which it ends.
    pub(super) most_steps: u64,
}

/// The least costly way found, or `None`.
pub(super) fn explore(
    probe: &Probe<'_>,
    (field, headings, axes): (&mut Field, &Headings, &[GateAxis]),
    manner: Manner,
    memory: &mut PoseMemory,
) -> Result<Option<Way>, Spent> {
    memory.nodes.clear();
    memory.heap.clear();
    memory.table.clear();
    memory.stations.clear();
    memory.is_cut_short = false;
    let mut held = Held::new(probe.budget, memory.table.bytes())?;
    let unit_cost = 1e-6 * manner.bin;
    let most_steps = probe.budget.drawn(Cap::Steps).saturating_add(manner.most_steps);
    let mut search = Explore { probe, field, headings, manner, memory, unit_cost };
    search.add_passages(axes)?;
    search.add_arrivals()?;
    search.sort_stations();
    search.set_out()?;
    let mut best = None;
    while let Some(OpenPose { node: index, .. }) = search.memory.heap.pop() {
        probe.budget.step(STEPS_PER_NODE)?;
        let node = search.memory.nodes[index as usize];
        if search.memory.table.get(node.key) != Some(index) {
            continue;
        }
        if node.key == GOAL {
            best = Some(index);
            break;
        }
        if probe.budget.drawn(Cap::Steps) > most_steps {
            search.memory.is_cut_short = true;
            break;
        }
        search.expand(index, &node)?;
        held.resize(search.memory.bytes())?;
    }
    Ok(best.map(|goal| search.way_to(goal)))
}

struct Explore<'a, 'm> {
    probe: &'a Probe<'a>,
    field: &'m mut Field,
    headings: &'m Headings,
    manner: Manner,
    memory: &'m mut PoseMemory,
    unit_cost: f64,
}

impl Explore<'_, '_> {
    /// Both ends of each passage.
    fn add_passages(&mut self, axes: &[GateAxis]) -> Result<(), Spent> {
        for axis in axes {
            let Some(ends) = axis.ends(self.probe)? else { continue };
            let mut ways = [[false; 2]; 2];
            for (index, ways) in ways.iter_mut().enumerate() {
                let (from, to) = (&ends[index], &ends[1 - index]);
                ways[0] = self.probe.is_line_free(from, to, false)?;
                ways[1] = self.can_reverse() && self.probe.is_line_free(from, to, true)?;
            }
            if ways == [[false; 2]; 2] {
                continue;
            }
            let first = self.memory.stations.len() as u32;
            for (at, passage) in [(ends[0], (first + 1, ways[0])), (ends[1], (first, ways[1]))] {
                self.memory.stations.push(Station { at, passage: Some(passage), arrival: None });
            }
        }
        Ok(())
    }

    /// The places from which the robot drives straight to a goal where it can't turn.
    fn add_arrivals(&mut self) -> Result<(), Spent> {
        let Probe { goal, goal_heading, .. } = *self.probe;
        if self.probe.can_turn(&goal)? {
            return Ok(());
        }
        for heading in &self.headings.all {
            if let Some(last) = goal_heading
                && self.probe.turn(&goal, *heading, last)?.is_none()
            {
                continue;
            }
            for back in self.senses() {
                let way = if *back { unit(*heading) } else { -unit(*heading) };
                let most = WAY_OUT * self.probe.swing;
                let Some(far) = self.probe.way_to_turn(&goal, &way, most)? else { continue };
                let at = goal + way * far;
                if self.probe.is_line_free(&at, &goal, *back)? {
                    let arrival = Some((*heading, *back));
                    self.memory.stations.push(Station { at, passage: None, arrival });
                }
            }
        }
        Ok(())
    }

    fn sort_stations(&mut self) {
        let mut squares = std::mem::take(&mut self.memory.squares);
        squares.clear();
        for (index, station) in self.memory.stations.iter().enumerate() {
            let [x, y] = self.square(&station.at);
            squares.push((x, y, index as u32));
        }
        squares.sort_unstable();
        self.memory.squares = squares;
    }

    fn square(&self, at: &Vector<2>) -> [i64; 2] {
        [at.x, at.y].map(|x| (x / (FAR * self.probe.swing)).floor() as i64)
    }

    /// The start, and the places where the robot can turn after it has driven straight out.
    fn set_out(&mut self) -> Result<(), Spent> {
        let start = Vector::zeros();
        let clear = self.probe.distance(&start, self.probe.swing)?;
        let can_turn = clear >= self.probe.swing;
        let slot = if can_turn { ANY } else { 0 };
        let root = PoseNode {
            at: start,
            heading: 0.0,
            back: false,
            moves: false,
            slot,
            clear,
            cost: 0.0,
            before: NOTHING,
            key: self.key(&start, slot),
        };
        self.push(root);
        if can_turn {
            return Ok(());
        }
        for heading in &self.headings.all {
            if self.probe.turn(&start, 0.0, *heading)?.is_none() {
                continue;
            }
            for back in self.senses() {
                let way = if *back { -unit(*heading) } else { unit(*heading) };
                let most = WAY_OUT * self.probe.swing;
                let Some(far) = self.probe.way_to_turn(&start, &way, most)? else { continue };
                let at = way * far;
                if self.probe.is_line_free(&start, &at, *back)? {
                    let key = self.key(&at, ANY);
                    self.offer_line((0, &root), &at, *heading, *back, (ANY, key, 0.0));
                }
            }
        }
        // The goal may be straight ahead.
        self.offer_goal(0, &root)
    }

    fn expand(&mut self, index: u32, node: &PoseNode) -> Result<(), Spent> {
        let headings = self.headings;
        if node.slot == ANY {
            for slot in 0..headings.all.len() {
                for back in self.senses() {
                    self.drive_on(index, node, slot, *back)?;
                }
            }
        } else if self.manner.is_fine {
            for back in self.senses() {
                self.drive_on(index, node, node.slot as usize, *back)?;
            }
            let count = headings.all.len();
            for next in [node.slot as usize + 1, node.slot as usize + count - 1] {
                self.turn_to(index, node, next % count)?;
            }
        }
        self.offer_stations(index, node)?;
        self.offer_goal(index, node)
    }

    /// Straight on into another bin.
    fn drive_on(
        &mut self,
        index: u32,
        node: &PoseNode,
        slot: usize,
        back: bool,
    ) -> Result<(), Spent> {
        self.probe.budget.step(STEPS_PER_OFFER)?;
        let heading = self.headings.all[slot];
        let length = MOVE * self.bin(node.clear);
        let way = unit(heading) * if back { -length } else { length };
        let at = node.at + way;
        let cost = self.cost_of_line(node, heading, back, length);
        if self.way_left(&at).is_infinite() {
            return Ok(());
        }
        let swing = self.probe.swing;
        let [mut clear, most] = self.field.clear_about(self.probe, &at)?;
        if clear < swing {
            clear = if most < swing { most } else { self.probe.distance(&at, swing)? };
        }
        let (slot, key) = if clear >= swing {
            (ANY, self.free_key(&at, clear))
        } else if self.manner.is_fine {
            (slot as u16, self.key(&at, slot as u16))
        } else {
            return Ok(());
        };
        if self.is_beaten(key, cost)
            || (clear.min(node.clear) < swing + length / 2.0
                && !self.probe.is_line_free(&node.at, &at, back)?)
        {
            return Ok(());
        }
        self.offer_line((index, node), &at, heading, back, (slot, key, clear));
        Ok(())
    }

    /// To the next heading, in a narrow place.
    fn turn_to(&mut self, index: u32, node: &PoseNode, slot: usize) -> Result<(), Spent> {
        self.probe.budget.step(STEPS_PER_OFFER)?;
        let heading = self.headings.all[slot];
        let stop = if node.moves { self.probe.errand.costs.stop } else { 0.0 };
        let angle = shortest_turn(node.heading, heading).abs();
        let cost = node.cost + stop + self.probe.errand.costs.turn * angle;
        let slot = slot as u16;
        let key = self.key(&node.at, slot);
        if self.is_beaten(key, cost) || self.probe.turn(&node.at, node.heading, heading)?.is_none()
        {
            return Ok(());
        }
        self.push(PoseNode { heading, moves: false, slot, cost, before: index, key, ..*node });
        Ok(())
    }

    /// To the stations nearby, and through the passage whose end this is.
    fn offer_stations(&mut self, index: u32, node: &PoseNode) -> Result<(), Spent> {
        let own = (node.key & STATION != 0).then_some(node.key ^ STATION);
        let is_special = own.is_some() || node.before == NOTHING;
        let reach = if is_special { FAR } else { 2.0 };
        let near = (reach * self.probe.swing).max(4.0 * self.manner.bin);
        let [x, y] = self.square(&node.at);
        for (right, up) in (-1..=1).flat_map(|right| (-1..=1).map(move |up| (right, up))) {
            let square = (x + right, y + up);
            let squares = &self.memory.squares;
            let mut next = squares.partition_point(|(x, y, _)| (*x, *y) < square);
            self.probe.budget.step(STEPS_PER_OFFER)?;
            while let Some((x, y, other)) = self.memory.squares.get(next).copied() {
                if (x, y) != square {
                    break;
                }
                next += 1;
                let other = u64::from(other);
                let at = self.memory.stations[other as usize].at;
                if own == Some(other) || (at - node.at).norm_squared() > near * near {
                    continue;
                }
                for back in self.senses() {
                    self.offer_exact((index, node), &at, *back, STATION | other)?;
                }
            }
        }
        let Some(own) = own else { return Ok(()) };
        let station = self.memory.stations[own as usize];
        if let Some((other, ways)) = station.passage {
            let at = self.memory.stations[other as usize].at;
            for (back, is_free) in [false, true].into_iter().zip(ways) {
                if is_free {
                    self.offer_free((index, node), &at, back, STATION | u64::from(other));
                }
            }
        }
        if let Some((heading, back)) = station.arrival {
            self.offer_arrival((index, node), heading, back)?;
        }
        Ok(())
    }

    /// Straight to the goal.
    fn offer_goal(&mut self, index: u32, node: &PoseNode) -> Result<(), Spent> {
        let goal = self.probe.goal;
        let apart = goal - node.at;
        let far = apart.norm();
        // Otherwise a wall is between.
        if far > DETOUR * self.field.to_goal(&node.at) + 2.0 * self.field.step {
            return Ok(());
        }
        for back in self.senses() {
            let heading = Self::heading_to(node, &goal, *back);
            if node.slot != ANY
                && (shortest_turn(node.heading, heading).abs() > SMALL_TURN
                    || self.probe.turn(&node.at, node.heading, heading)?.is_none())
            {
                continue;
            }
            if self.is_beaten(GOAL, self.cost_of_line(node, heading, *back, far))
                || !self.probe.is_line_free(&node.at, &goal, *back)?
            {
                continue;
            }
            if let Some(last) = self.probe.goal_heading
                && self.probe.turn(&goal, heading, last)?.is_none()
            {
                continue;
            }
            self.offer_arrival((index, node), heading, *back)?;
        }
        Ok(())
    }

    /// Along a line to the goal that is free.
    fn offer_arrival(
        &mut self,
        (index, node): (u32, &PoseNode),
        heading: f64,
        back: bool,
    ) -> Result<(), Spent> {
        let goal = self.probe.goal;
        let mut cost = self.cost_of_line(node, heading, back, (goal - node.at).norm());
        if let Some(last) = self.probe.goal_heading {
            let Some(sweep) = self.probe.turn(&goal, heading, last)? else { return Ok(()) };
            cost += self.probe.errand.costs.turn * sweep.abs();
        }
        if !self.is_beaten(GOAL, cost) {
            let slot = 0;
            let (at, moves, before, key) = (goal, true, index, GOAL);
            self.push(PoseNode { at, heading, back, moves, slot, clear: 0.0, cost, before, key });
        }
        Ok(())
    }

    /// Straight to a point, if walls let it.
    fn offer_exact(
        &mut self,
        (index, node): (u32, &PoseNode),
        at: &Vector<2>,
        back: bool,
        key: u64,
    ) -> Result<(), Spent> {
        self.probe.budget.step(STEPS_PER_OFFER)?;
        let heading = Self::heading_to(node, at, back);
        let cost = self.cost_of_line(node, heading, back, (at - node.at).norm());
        if self.is_beaten(key, cost) {
            return Ok(());
        }
        if node.slot != ANY
            && (shortest_turn(node.heading, heading).abs() > SMALL_TURN
                || self.probe.turn(&node.at, node.heading, heading)?.is_none())
        {
            return Ok(());
        }
        if self.probe.is_line_free(&node.at, at, back)? {
            self.offer_free((index, node), at, back, key);
        }
        Ok(())
    }

    /// Straight to a place where the robot can turn.
    fn offer_free(&mut self, from: (u32, &PoseNode), at: &Vector<2>, back: bool, key: u64) {
        let heading = Self::heading_to(from.1, at, back);
        self.offer_line(from, at, heading, back, (ANY, key, self.probe.swing));
    }

    fn offer_line(
        &mut self,
        (index, node): (u32, &PoseNode),
        at: &Vector<2>,
        heading: f64,
        back: bool,
        (slot, key, clear): (u16, u64, f64),
    ) {
        let cost = self.cost_of_line(node, heading, back, (at - node.at).norm());
        if !self.is_beaten(key, cost) {
            let (at, moves, before) = (*at, true, index);
            self.push(PoseNode { at, heading, back, moves, slot, clear, cost, before, key });
        }
    }

    fn push(&mut self, node: PoseNode) {
        let index = self.memory.nodes.len() as u32;
        let least = node.cost + self.way_left(&node.at);
        self.memory.nodes.push(node);
        self.memory.table.set(node.key, index);
        let least = libm::round(least / self.unit_cost) as u64;
        self.memory.heap.push(OpenPose { least, node: index });
    }

    fn is_beaten(&self, key: u64, cost: f64) -> bool {
        let known = self.memory.table.get(key);
        known.is_some_and(|known| self.memory.nodes[known as usize].cost <= cost + self.unit_cost)
    }

    /// The cost of the way from a point to the goal at least, metres.
    fn way_left(&self, at: &Vector<2>) -> f64 {
        let straight = (self.probe.goal - at).norm();
        straight.max(self.field.to_goal(at) / DETOUR - self.field.step)
    }

    fn cost_of_line(&self, node: &PoseNode, heading: f64, back: bool, length: f64) -> f64 {
        let costs = &self.probe.errand.costs;
        let angle = shortest_turn(node.heading, heading).abs();
        let stops = node.moves && (angle > SAME_HEADING || back != node.back);
        node.cost + length + costs.turn * angle + if stops { costs.stop } else { 0.0 }
    }

    fn heading_to(node: &PoseNode, at: &Vector<2>, back: bool) -> f64 {
        let way = if back { node.at - at } else { at - node.at };
        libm::atan2(way.y, way.x)
    }

    fn key(&self, at: &Vector<2>, slot: u16) -> u64 {
        pose_key(at, self.manner.bin, slot)
    }

    /// The key of a place where the robot can turn.
    fn free_key(&self, at: &Vector<2>, clear: f64) -> u64 {
        let is_open = self.field.is_open(clear, self.probe);
        pose_key(at, self.bin(clear), if is_open { OPEN } else { ANY })
    }

    /// Side of a bin, metres.
    fn bin(&self, clear: f64) -> f64 {
        let is_open = self.field.is_open(clear, self.probe);
        if is_open { OPEN_BINS * self.manner.bin } else { self.manner.bin }
    }

    fn can_reverse(&self) -> bool {
        self.probe.errand.abilities.reverse
    }

    fn senses(&self) -> &'static [bool] {
        if self.can_reverse() { &[false, true] } else { &[false] }
    }

    fn way_to(&self, goal: u32) -> Way {
        let mut way = Way::default();
        let mut index = goal;
        while let Some(node) = self.memory.nodes.get(index as usize) {
            if node.moves || node.before == NOTHING {
                way.knots.push(node.at);
            }
            if node.moves {
                way.backs.push(node.back);
            }
            index = node.before;
        }
        way.knots.reverse();
        way.backs.reverse();
        way
    }
}

/// The key of a bin.
pub(super) fn pose_key(at: &Vector<2>, bin: f64, slot: u16) -> u64 {
    let place = |x: f64| libm::round(x / bin) as i64 as u64 & 0x7F_FFFF;
    place(at.x) << 39 | place(at.y) << 16 | u64::from(slot)
}
