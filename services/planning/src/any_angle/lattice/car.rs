//! The search with arcs, for robots that can't turn in place, and for places where straight lines
//! don't lead on (hybrid A*, see [`explore`](super::explore)).

use std::collections::BinaryHeap;
use std::f64::consts::TAU;

use super::explore::{ANY, OPEN, OPEN_BINS, OpenPose, pose_key};
use super::field::{DETOUR, Field};
use super::probe::Probe;
use super::steer::{RunAlong, SteerPlace, Steered, Steering, Word};
use super::table::{NOTHING, Table};
use crate::budget::{Cap, Held, Spent};
use crate::driving::shortest_turn;
use crate::geometry::Vector;

/// Bins in a turn.
pub(super) const HEADINGS: u16 = 64;

/// Length of a move, in bins: it ends in another one.
const MOVE: f64 = 1.51;

/// Steps of the budget that a node, and a move, takes.
const STEPS_PER_NODE: u64 = 10;
const STEPS_PER_MOVE: u64 = 30;

const GOAL: u64 = u64::MAX;

/// Where the robot can turn anywhere, poses are alike whatever their heading, and it drives on in
/// these parts of a turn.
const WAYS_ON: u16 = 32;

#[derive(Debug, Clone, Copy)]
struct ArcNode {
    place: SteerPlace,
    /// The motion that leads there.
    word: Word,
    cost: f64,
    before: u32,
    key: u64,
    can_turn: bool,
    is_open: bool,
}

/// ArcMemory of a search.
#[derive(Debug, Default)]
pub(super) struct ArcMemory {
    nodes: Vec<ArcNode>,
    heap: BinaryHeap<OpenPose>,
    table: Table,
    words: Vec<Word>,
    /// Whether the last search ended at its limit of steps.
    pub(super) is_cut_short: bool,
}

impl ArcMemory {
    pub(super) fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<ArcNode>()
            + self.heap.capacity() * size_of::<OpenPose>()
            + self.table.bytes()
    }
}

/// Places and the motions between them.
#[derive(Debug, Clone, Default)]
pub(super) struct ArcTrack {
    pub(super) places: Vec<SteerPlace>,
    pub(super) words: Vec<Word>,
}

/// How a search is made.
#[derive(Debug, Clone, Copy)]
pub(super) struct ArcManner<'a> {
    pub(super) steering: &'a Steering,
    /// Side of a bin, metres.
    pub(super) bin: f64,
    /// Steps of the budget after which it ends.
    pub(super) most_steps: u64,
}

/// The least costly track found, or `None`.
pub(super) fn explore(
    probe: &Probe<'_>,
    field: &mut Field,
    manner: ArcManner<'_>,
    memory: &mut ArcMemory,
) -> Result<Option<ArcTrack>, Spent> {
    memory.nodes.clear();
    memory.heap.clear();
    memory.table.clear();
    memory.is_cut_short = false;
    let mut held = Held::new(probe.budget, memory.table.bytes())?;
    let ArcManner { steering, bin, most_steps } = manner;
    let most_steps = probe.budget.drawn(Cap::Steps).saturating_add(most_steps);
    let mut search = ExploreArcs { probe, field, steering, bin, memory };
    let place = SteerPlace { at: Vector::zeros(), heading: 0.0 };
    search.reach(NOTHING, 0.0, (place, Word::NOTHING))?;
    // A move is long enough to leave its bin, and turns by a bin of headings at least.
    let turn = 1.01 * TAU / f64::from(HEADINGS);
    let size = (MOVE * bin).max(steering.radius * turn);
    let mut until_shot = 0_u32;
    while let Some(OpenPose { node: index, .. }) = search.memory.heap.pop() {
        probe.budget.step(STEPS_PER_NODE)?;
        let node = search.memory.nodes[index as usize];
        if search.memory.table.get(node.key) != Some(index) {
            continue;
        }
        if node.key == GOAL {
            return Ok(Some(search.track_to(index)));
        }
        if probe.budget.drawn(Cap::Steps) > most_steps {
            search.memory.is_cut_short = true;
            break;
        }
        if until_shot == 0 {
            search.shoot(index, &node)?;
            // The nearer the goal, the more often.
            until_shot = (search.way_left(&node.place.at) / (4.0 * size) + 1e-6) as u32;
        } else {
            until_shot -= 1;
        }
        if node.can_turn {
            let size = if node.is_open { OPEN_BINS * size } else { size };
            search.drive_anywhere(index, &node, size)?;
        } else {
            search.drive_on(index, &node, size, turn)?;
        }
        held.resize(search.memory.bytes())?;
    }
    Ok(None)
}

struct ExploreArcs<'a, 'm> {
    probe: &'a Probe<'a>,
    field: &'m mut Field,
    steering: &'a Steering,
    bin: f64,
    memory: &'m mut ArcMemory,
}

impl ExploreArcs<'_, '_> {
    fn drive_on(&mut self, index: u32, node: &ArcNode, size: f64, turn: f64) -> Result<(), Spent> {
        for along in [RunAlong::Line, RunAlong::Circle(1.0), RunAlong::Circle(-1.0)] {
            for back in self.steering.senses() {
                self.offer(index, node, &[Steered { along, size, back: *back }])?;
            }
        }
        if self.steering.turn.is_some() {
            for along in [RunAlong::Turn(1.0), RunAlong::Turn(-1.0)] {
                self.offer(index, node, &[Steered { along, size: turn, back: false }])?;
            }
        }
        Ok(())
    }

    /// After a turn in place by any angle.
    fn drive_anywhere(&mut self, index: u32, node: &ArcNode, size: f64) -> Result<(), Spent> {
        for way in 0..WAYS_ON {
            let heading = TAU * f64::from(way) / f64::from(WAYS_ON);
            let angle = shortest_turn(node.place.heading, heading);
            let along = RunAlong::Turn(1.0_f64.copysign(angle));
            let turn = Steered { along, size: angle.abs(), back: false };
            for back in self.steering.senses() {
                let line = Steered { along: RunAlong::Line, size, back: *back };
                self.offer(index, node, &[turn, line])?;
            }
        }
        Ok(())
    }

    fn offer(&mut self, index: u32, node: &ArcNode, pieces: &[Steered]) -> Result<(), Spent> {
        self.probe.budget.step(STEPS_PER_MOVE)?;
        let mut place = node.place;
        for piece in pieces {
            place = self.steering.follow(&place, piece);
        }
        let word = self.steering.word(pieces);
        let cost = node.cost + word.cost + self.steering.cost_of_change(&node.word, &word);
        if self.is_beaten(pose_key(&place.at, self.bin, Self::slot(&place)), cost)
            || self.way_left(&place.at).is_infinite()
            || self.steering.drive(&node.place, word.pieces(), self.probe)?.is_none()
        {
            return Ok(());
        }
        self.reach(index, cost, (place, word))
    }

    fn reach(
        &mut self,
        before: u32,
        cost: f64,
        (place, word): (SteerPlace, Word),
    ) -> Result<(), Spent> {
        let (mut can_turn, mut is_open) = (false, false);
        if self.steering.turn.is_some() {
            let swing = self.probe.swing;
            let [clear, most] = self.field.clear_about(self.probe, &place.at)?;
            is_open = self.field.is_open(clear, self.probe);
            can_turn = clear >= swing || most >= swing && self.probe.can_turn(&place.at)?;
        }
        let key = match (can_turn, is_open) {
            (true, true) => pose_key(&place.at, OPEN_BINS * self.bin, OPEN),
            (true, false) => pose_key(&place.at, self.bin, ANY),
            _ => pose_key(&place.at, self.bin, Self::slot(&place)),
        };
        if !self.is_beaten(key, cost) {
            self.push(ArcNode { place, word, cost, before, key, can_turn, is_open });
        }
        Ok(())
    }

    /// Tries to drive to the goal from here.
    fn shoot(&mut self, index: u32, node: &ArcNode) -> Result<(), Spent> {
        let known = self.memory.table.get(GOAL);
        let most = known.map_or(f64::INFINITY, |goal| self.memory.nodes[goal as usize].cost);
        let mut words = std::mem::take(&mut self.memory.words);
        let goal = (&self.probe.goal, self.probe.goal_heading);
        // Much longer ones are better found move by move.
        let detour = 1.5 * self.way_left(&node.place.at) + 8.0 * self.bin;
        let most = most.min(node.cost + detour + TAU * self.steering.radius);
        self.steering.join(&node.place, goal, most - node.cost, &mut words, self.probe)?;
        let mut found = None;
        for word in &words {
            if let Some(place) = self.steering.drive(&node.place, word.pieces(), self.probe)? {
                found = Some((*word, place));
                break;
            }
        }
        self.memory.words = words;
        if let Some((word, place)) = found {
            let cost = node.cost + word.cost + self.steering.cost_of_change(&node.word, &word);
            if !self.is_beaten(GOAL, cost) {
                let (before, key) = (index, GOAL);
                let (can_turn, is_open) = (false, false);
                self.push(ArcNode { place, word, cost, before, key, can_turn, is_open });
            }
        }
        Ok(())
    }

    fn push(&mut self, node: ArcNode) {
        let index = self.memory.nodes.len() as u32;
        let left = if node.key == GOAL { 0.0 } else { self.way_left(&node.place.at) };
        self.memory.nodes.push(node);
        self.memory.table.set(node.key, index);
        let least = libm::round((node.cost + left) / (1e-6 * self.bin)) as u64;
        self.memory.heap.push(OpenPose { least, node: index });
    }

    fn is_beaten(&self, key: u64, cost: f64) -> bool {
        let known = self.memory.table.get(key);
        known.is_some_and(|known| self.memory.nodes[known as usize].cost <= cost + 1e-6 * self.bin)
    }

    fn way_left(&self, at: &Vector<2>) -> f64 {
        let straight = (self.probe.goal - at).norm();
        straight.max(self.field.to_goal(at) / DETOUR - self.field.step)
    }

    fn slot(place: &SteerPlace) -> u16 {
        let turn = libm::round(place.heading / TAU * f64::from(HEADINGS)) as i64;
        turn.rem_euclid(i64::from(HEADINGS)) as u16
    }

    fn track_to(&self, goal: u32) -> ArcTrack {
        let mut track = ArcTrack::default();
        let mut index = goal;
        while let Some(node) = self.memory.nodes.get(index as usize) {
            track.places.push(node.place);
            if node.before != NOTHING {
                track.words.push(node.word);
            }
            index = node.before;
        }
        track.places.reverse();
        track.words.reverse();
        track
    }
}
