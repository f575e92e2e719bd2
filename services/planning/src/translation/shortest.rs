//! The shortest way out among sums.
//!
//! A* over the vertices of those sums that turned out to be in the way. A line is looked at only
//! when its turn comes; the sum that lies in its way is then known from there on, and every place
//! reached so far gets the lines that touch it. At any moment the known sums have a shortest way
//! that is no longer than the one sought, and the first line of it that has not been looked at is
//! in the queue. So the first way that is complete is the shortest; and where the queue is empty,
//! there is none.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use super::sums::Sums;
use crate::budget::{Budget, Held, Spent};
use crate::geometry::distance::cross;
use crate::geometry::orientation::Side;
use crate::geometry::{Direction, Vector, polygon};

/// Steps that a line takes which is put into the queue.
const STEPS_PER_LINE: u64 = 4;

/// Bytes that a place takes, and a line in the queue.
const BYTES_PER_PLACE: usize = 160;
const BYTES_PER_LINE: usize = 64;

/// Where a way out ends: at this displacement along an axis, or beyond.
#[derive(Debug, Clone, Copy)]
pub(super) struct Out {
    pub(super) exit: Direction,
    /// Along the exit, metres; greater than 0.
    pub(super) distance: f64,
}

impl Out {
    fn missing(&self, at: &Vector<2>) -> f64 {
        (self.distance - self.exit.coordinate(at)).max(0.0)
    }

    /// The place on the line of the goal beside `at`, exactly on it.
    fn beside(&self, at: &Vector<2>) -> Vector<2> {
        let mut to = *at;
        to[self.exit.axis] = self.exit.sign.factor() * self.distance;
        to
    }
}

/// A displacement that can be reached.
#[derive(Debug, Clone, Copy)]
struct Settled {
    at: Vector<2>,
    /// The side on which the sum is that the way touches here; `None` at the start.
    side: Option<Side>,
    /// Along the side of that sum that follows: a way that turns farther would enter it.
    along: Vector<2>,
    length: f64,
    before: usize,
}

/// A line that may be part of the way.
#[derive(Debug, Clone, Copy)]
struct Line {
    /// The least length of a way along it.
    least: f64,
    /// The order in which lines were found.
    turn: u64,
    from: usize,
    /// The length to its beginning when it was found.
    length: f64,
    to: Vector<2>,
    /// `None` at the goal.
    side: Option<Side>,
    /// The side of the sum that follows.
    along: Vector<2>,
}

impl PartialEq for Line {
    fn eq(&self, other: &Self) -> bool {
        self.turn == other.turn
    }
}

impl Eq for Line {}

impl PartialOrd for Line {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Line {
    /// The greatest is looked at first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.least.total_cmp(&self.least).then(other.turn.cmp(&self.turn))
    }
}

type StepKey = (u64, u64, bool);

struct WaySearch<'s, 'a, 'b> {
    sums: &'s mut Sums<'a>,
    out: Out,
    budget: &'b Budget<'b>,
    held: Held<'b>,
    places: Vec<Settled>,
    by_key: BTreeMap<StepKey, usize>,
    queue: BinaryHeap<Line>,
    turn: u64,
    known: Vec<usize>,
    bytes: usize,
}

/// The shortest way from no displacement to the goal, both included; `None` where there is none.
pub(super) fn shortest(
    sums: &mut Sums<'_>,
    out: Out,
    budget: &Budget<'_>,
) -> Result<Option<Vec<Vector<2>>>, Spent> {
    let mut search = WaySearch {
        sums,
        out,
        budget,
        held: Held::new(budget, 0)?,
        places: Vec::new(),
        by_key: BTreeMap::new(),
        queue: BinaryHeap::new(),
        turn: 0,
        known: Vec::new(),
        bytes: 0,
    };
    let nowhere = Vector::zeros();
    let start = Settled { at: nowhere, side: None, along: nowhere, length: 0.0, before: 0 };
    search.places.push(start);
    search.expand(0)?;
    while let Some(line) = search.queue.pop() {
        budget.step(1)?;
        let Line { from, to, side, along, length, .. } = line;
        let begin = search.places[from];
        if begin.length < length {
            continue;
        }
        let length = length + (to - begin.at).norm();
        if side.is_some_and(|side| search.is_beaten(&to, side, length)) {
            continue;
        }
        if let Some(sum) = search.sums.in_the_way((&begin.at, &to), budget)? {
            search.learn(sum)?;
            continue;
        }
        let Some(side) = side else { return Ok(Some(search.way(from, to))) };
        search.reach(Settled { at: to, side: Some(side), along, length, before: from })?;
    }
    Ok(None)
}

fn key(at: &Vector<2>, side: Side) -> StepKey {
    // No negative zero.
    ((at.x + 0.0).to_bits(), (at.y + 0.0).to_bits(), side == Side::Left)
}

impl WaySearch<'_, '_, '_> {
    fn is_beaten(&self, at: &Vector<2>, side: Side, length: f64) -> bool {
        let known = self.by_key.get(&key(at, side));
        known.is_some_and(|place| self.places[*place].length <= length)
    }

    fn reach(&mut self, place: Settled) -> Result<(), Spent> {
        let Some(side) = place.side else { return Ok(()) };
        let index = match self.by_key.get(&key(&place.at, side)) {
            Some(index) => *index,
            None => {
                self.take(BYTES_PER_PLACE)?;
                self.places.push(place);
                self.by_key.insert(key(&place.at, side), self.places.len() - 1);
                self.places.len() - 1
            }
        };
        self.places[index] = place;
        self.expand(index)
    }

    fn take(&mut self, bytes: usize) -> Result<(), Spent> {
        self.bytes += bytes;
        self.held.resize(self.bytes)
    }

    fn expand(&mut self, from: usize) -> Result<(), Spent> {
        let at = self.places[from].at;
        let goal = if self.out.missing(&at) > 0.0 { self.out.beside(&at) } else { at };
        if self.may_be_shorter(from, &goal, None) {
            self.push(from, goal, None, Vector::zeros())?;
        }
        for index in 0..self.known.len() {
            self.join(from, self.known[index])?;
        }
        Ok(())
    }

    /// A sum is in the way.
    fn learn(&mut self, sum: usize) -> Result<(), Spent> {
        if !self.sums.learn(sum) {
            return Ok(());
        }
        self.known.push(sum);
        for from in 0..self.places.len() {
            self.join(from, sum)?;
        }
        Ok(())
    }

    /// Puts the lines from a place to a sum into the queue: those that touch it, and those to where
    /// it meets the line of the goal.
    fn join(&mut self, from: usize, sum: usize) -> Result<(), Spent> {
        let at = self.places[from].at;
        self.budget.step(1)?;
        if self.is_aside(from, self.sums.around(sum)) {
            return Ok(());
        }
        let vertices = self.sums.vertices(sum);
        let count = vertices.len();
        self.budget.step(1 + vertices.len() as u64)?;
        let mut found = Vec::new();
        self.sums.touching(sum, &at, |index, vertex, side| {
            let next = if side == Side::Left { index + 1 } else { index + count - 1 };
            found.push((*vertex, Some((index, side)), vertices[next % count] - vertex));
        });
        let exit = self.out.exit;
        let beyond = |vertex: &Vector<2>| exit.coordinate(vertex) - self.out.distance;
        for (a, b) in polygon::edges(vertices) {
            let (before, after) = (beyond(&a), beyond(&b));
            if (before < 0.0) != (after < 0.0) {
                let place = a + (b - a) * (before / (before - after));
                found.push((self.out.beside(&place), None, Vector::zeros()));
            }
        }
        for (to, vertex, along) in found {
            let side = vertex.map(|(_, side)| side);
            if !self.may_be_shorter(from, &to, side) {
                continue;
            }
            if let Some((index, _)) = vertex
                && self.sums.is_covered(sum, index, self.budget)?
            {
                continue;
            }
            self.push(from, to, side, along)?;
        }
        Ok(())
    }

    /// Whether a line can be part of a taut way, and of one that is shorter than those known.
    fn may_be_shorter(&self, from: usize, to: &Vector<2>, side: Option<Side>) -> bool {
        let place = &self.places[from];
        let way = to - place.at;
        let goes_on = place.side.is_none_or(|turns| self.goes_on(place, &way, turns));
        let length = place.length + way.norm();
        goes_on && !side.is_some_and(|side| self.is_beaten(to, side, length))
    }

    fn push(
        &mut self,
        from: usize,
        to: Vector<2>,
        side: Option<Side>,
        along: Vector<2>,
    ) -> Result<(), Spent> {
        let place = &self.places[from];
        let length = place.length + (to - place.at).norm();
        let least = length + side.map_or(0.0, |_| self.out.missing(&to));
        let line = Line { least, turn: self.turn, from, length: place.length, to, side, along };
        self.turn += 1;
        self.budget.step(STEPS_PER_LINE)?;
        self.take(BYTES_PER_LINE)?;
        self.queue.push(line);
        Ok(())
    }

    /// Whether a taut way that arrives at a place can go on by `way`: straight on, or towards the
    /// side of the sum that it touches there.
    fn goes_on(&self, place: &Settled, way: &Vector<2>, turns: Side) -> bool {
        let arriving = place.at - self.places[place.before].at;
        let least = 4.0 * self.sums.tolerance();
        let (before, after) = (arriving.norm(), way.norm());
        if before <= least || after <= least {
            return true;
        }
        // How far the way turns off from straight on.
        let off = cross(&arriving, way) / before.max(after);
        let off = if turns == Side::Left { off } else { -off };
        off >= -least && (off > least || arriving.dot(way) > 0.0)
    }

    /// Whether no way that goes on from a place leads into a circle: it would turn away from the sum
    /// that it touches there, or into it.
    fn is_aside(&self, from: usize, (center, radius): (Vector<2>, f64)) -> bool {
        let place = &self.places[from];
        let Some(side) = place.side else { return false };
        let least = 4.0 * self.sums.tolerance();
        let arriving = place.at - self.places[place.before].at;
        let to = center - place.at;
        let sign = if side == Side::Left { 1.0 } else { -1.0 };
        let is_right = |line: &Vector<2>, off: f64| {
            let length = line.norm();
            length > least && off < -(radius + 2.0 * least) * length
        };
        is_right(&arriving, sign * cross(&arriving, &to))
            || is_right(&place.along, sign * cross(&to, &place.along))
    }

    fn way(&self, from: usize, to: Vector<2>) -> Vec<Vector<2>> {
        let mut way = vec![to];
        let mut at = from;
        loop {
            let place = &self.places[at];
            way.push(place.at);
            if place.side.is_none() {
                break;
            }
            at = place.before;
        }
        way.reverse();
        way
    }
}
