//! Motions on circles of one radius, on lines, and, if the robot can, by turns in place.
//!
//! Two poses are joined by an arc, a line and an arc, each driven forwards or, where the robot
//! may, backwards: the words CSC of J. A. Reeds and L. A. Shepp, "Optimal paths for a car that goes
//! both forwards and backwards", Pacific Journal of Mathematics 145(2), 1990, with any changes of
//! sense. Or by a turn in place, a line and a turn in place.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::probe::Probe;
use crate::budget::Spent;
use crate::geometry::{Vector, unit};
use crate::motion::{Curve, wrapped};

/// Angles and parts of the radius up to this are left out.
const NOTHING: f64 = 1e-11;

/// A change of the circle costs this part of the radius: of motions as long, the simplest is taken.
const CHANGE: f64 = 0.01;

/// Costs that differ by less than this part of the radius count as the same.
pub(super) const SAME_COST: f64 = 1e-7;

/// Steps of the budget that the words between two poses take.
const STEPS_PER_JOIN: u64 = 60;

/// In the start pose's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SteerPlace {
    pub(super) at: Vector<2>,
    /// Radians.
    pub(super) heading: f64,
}

/// What a piece of a motion follows. A side of 1 is to the left of the robot, -1 to the right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum RunAlong {
    Line,
    /// A circle whose centre is on this side.
    Circle(f64),
    /// A turn in place to this side.
    Turn(f64),
}

/// A piece of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Steered {
    pub(super) along: RunAlong,
    /// Metres; radians for a turn in place.
    pub(super) size: f64,
    pub(super) back: bool,
}

impl Steered {
    fn is_turn(&self) -> bool {
        matches!(self.along, RunAlong::Turn(_))
    }
}

/// Up to three pieces in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Word {
    pieces: [Steered; 3],
    count: usize,
    /// Length, turns in place, stops and changes, metres.
    pub(super) cost: f64,
}

impl Word {
    pub(super) const NOTHING: Self = Self {
        pieces: [Steered { along: RunAlong::Line, size: 0.0, back: false }; 3],
        count: 0,
        cost: 0.0,
    };

    pub(super) fn pieces(&self) -> &[Steered] {
        &self.pieces[..self.count]
    }
}

/// What the robot's steering can do.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steering {
    /// Of its circles, metres.
    pub(super) radius: f64,
    pub(super) reverse: bool,
    /// What a stop costs, metres.
    pub(super) stop: f64,
    /// What turning in place costs, metres a radian; `None` if the robot can't.
    pub(super) turn: Option<f64>,
}

impl Steering {
    pub(super) fn senses(&self) -> &'static [bool] {
        if self.reverse { &[false, true] } else { &[false] }
    }

    /// A word of up to three pieces, without those that are nothing.
    pub(super) fn word(&self, pieces: &[Steered]) -> Word {
        let mut word = Word::NOTHING;
        for piece in pieces {
            let least = if piece.is_turn() { NOTHING } else { NOTHING * self.radius };
            if piece.size <= least {
                continue;
            }
            word.cost += self.cost_between(word.pieces().last(), piece);
            word.cost += match piece.along {
                RunAlong::Turn(_) => self.turn.unwrap_or(0.0) * piece.size,
                _ => piece.size,
            };
            word.pieces[word.count] = *piece;
            word.count += 1;
        }
        word
    }

    /// What one piece after another costs, metres: a stop, or a little for the change alone.
    fn cost_between(&self, before: Option<&Steered>, after: &Steered) -> f64 {
        match before {
            None => 0.0,
            Some(before) if before.along == after.along && before.back == after.back => 0.0,
            // After a turn it has stopped already.
            Some(before) if before.is_turn() => CHANGE * self.radius,
            Some(before) if after.is_turn() || before.back != after.back => {
                self.stop + CHANGE * self.radius
            }
            Some(_) => CHANGE * self.radius,
        }
    }

    /// What one word after another costs, metres.
    pub(super) fn cost_of_change(&self, before: &Word, after: &Word) -> f64 {
        after.pieces().first().map_or(0.0, |next| self.cost_between(before.pieces().last(), next))
    }

    /// Where a piece leads.
    pub(super) fn follow(&self, from: &SteerPlace, piece: &Steered) -> SteerPlace {
        let forth = if piece.back { -piece.size } else { piece.size };
        match piece.along {
            RunAlong::Line => SteerPlace { at: from.at + unit(from.heading) * forth, ..*from },
            RunAlong::Circle(side) => {
                let center = self.center(from, side);
                let heading = from.heading + side * forth / self.radius;
                let at = center - normal(heading) * (side * self.radius);
                SteerPlace { at, heading: wrapped(heading) }
            }
            RunAlong::Turn(side) => {
                SteerPlace { heading: wrapped(from.heading + side * piece.size), ..*from }
            }
        }
    }

    /// The curve of a piece.
    pub(super) fn curve(&self, from: &SteerPlace, piece: &Steered, probe: &Probe<'_>) -> Curve<2> {
        match piece.along {
            RunAlong::Line => {
                let to = self.follow(from, piece);
                let heading = probe.world_heading(from.heading);
                let [from, to] = [&from.at, &to.at].map(|point| probe.in_world(point));
                Curve::Line { from, to, heading, turned: 0.0 }
            }
            RunAlong::Circle(side) => {
                let forth = if piece.back { -1.0 } else { 1.0 };
                Curve::Arc {
                    center: probe.in_world(&self.center(from, side)),
                    radius: self.radius,
                    start_angle: probe.world_heading(from.heading - side * FRAC_PI_2),
                    sweep: side * forth * piece.size / self.radius,
                    reverse: piece.back,
                }
            }
            RunAlong::Turn(side) => Curve::Turn {
                position: probe.in_world(&from.at),
                from_heading: probe.world_heading(from.heading),
                sweep: side * piece.size,
            },
        }
    }

    /// Whether the robot can drive a word; returns where it ends.
    pub(super) fn drive(
        &self,
        from: &SteerPlace,
        pieces: &[Steered],
        probe: &Probe<'_>,
    ) -> Result<Option<SteerPlace>, Spent> {
        let mut at = *from;
        for piece in pieces {
            if !probe.is_free(&self.curve(&at, piece, probe))? {
                return Ok(None);
            }
            at = self.follow(&at, piece);
        }
        Ok(Some(at))
    }

    /// The least costly words from one pose to another, or to a point with any heading, that cost
    /// less than `most`: in order of cost.
    pub(super) fn join(
        &self,
        from: &SteerPlace,
        (to, heading): (&Vector<2>, Option<f64>),
        most: f64,
        words: &mut Vec<Word>,
        probe: &Probe<'_>,
    ) -> Result<(), Spent> {
        probe.budget.step(STEPS_PER_JOIN)?;
        words.clear();
        self.join_by_turns(from, (to, heading), most, words);
        for side in [1.0, -1.0] {
            let center = self.center(from, side);
            let Some(heading) = heading else {
                self.join_point(from, (side, &center), to, most, words);
                continue;
            };
            for last_side in [1.0, -1.0] {
                let goal = SteerPlace { at: *to, heading };
                self.join_pose(from, [side, last_side], &goal, most, words);
            }
        }
        // Rounding does not decide.
        words.sort_by_key(|word| libm::round(word.cost / (SAME_COST * self.radius)) as i64);
        Ok(())
    }

    fn center(&self, from: &SteerPlace, side: f64) -> Vector<2> {
        from.at + normal(from.heading) * (side * self.radius)
    }

    fn join_point(
        &self,
        from: &SteerPlace,
        (side, center): (f64, &Vector<2>),
        to: &Vector<2>,
        most: f64,
        words: &mut Vec<Word>,
    ) {
        let apart = to - center;
        let Some(angles) = line_headings(&apart, -side * self.radius) else { return };
        for (heading, back) in angles.into_iter().zip([false, true]) {
            let begins = center - normal(heading) * (side * self.radius);
            let line = Steered { along: RunAlong::Line, size: (to - begins).norm(), back };
            if back && !self.reverse {
                continue;
            }
            for first in self.arcs(side, heading - from.heading) {
                self.offer(&[first, line], most, words);
            }
        }
    }

    fn join_pose(
        &self,
        from: &SteerPlace,
        sides: [f64; 2],
        to: &SteerPlace,
        most: f64,
        words: &mut Vec<Word>,
    ) {
        let centers = [self.center(from, sides[0]), self.center(to, sides[1])];
        let apart = centers[1] - centers[0];
        if apart.norm() <= NOTHING * self.radius {
            if sides[0] == sides[1] {
                for only in self.arcs(sides[0], to.heading - from.heading) {
                    self.offer(&[only], most, words);
                }
            }
            return;
        }
        let offset = self.radius * (sides[1] - sides[0]);
        let Some(angles) = line_headings(&apart, offset) else { return };
        for (heading, back) in angles.into_iter().zip([false, true]) {
            if back && !self.reverse {
                continue;
            }
            let along = unit(heading);
            let across = normal(heading) * self.radius;
            let ends = [centers[0] - across * sides[0], centers[1] - across * sides[1]];
            let size = (ends[1] - ends[0]).dot(&along).abs();
            let line = Steered { along: RunAlong::Line, size, back };
            for first in self.arcs(sides[0], heading - from.heading) {
                for last in self.arcs(sides[1], to.heading - heading) {
                    self.offer(&[first, line, last], most, words);
                }
            }
        }
    }

    fn join_by_turns(
        &self,
        from: &SteerPlace,
        (to, heading): (&Vector<2>, Option<f64>),
        most: f64,
        words: &mut Vec<Word>,
    ) {
        if self.turn.is_none() {
            return;
        }
        let way = to - from.at;
        let size = way.norm();
        if size <= NOTHING * self.radius {
            if let Some(heading) = heading {
                for turn in turns(heading - from.heading) {
                    self.offer(&[turn], most, words);
                }
            }
            return;
        }
        for back in self.senses() {
            let direction = libm::atan2(way.y, way.x);
            let ahead = if *back { direction + PI } else { direction };
            let line = Steered { along: RunAlong::Line, size, back: *back };
            for first in turns(ahead - from.heading) {
                let Some(heading) = heading else {
                    self.offer(&[first, line], most, words);
                    continue;
                };
                for last in turns(heading - ahead) {
                    self.offer(&[first, line, last], most, words);
                }
            }
        }
    }

    fn offer(&self, pieces: &[Steered], most: f64, words: &mut Vec<Word>) {
        let word = self.word(pieces);
        if word.cost < most {
            words.push(word);
        }
    }

    /// Both ways round a circle to a heading.
    fn arcs(&self, side: f64, turn: f64) -> impl Iterator<Item = Steered> + use<> {
        let left = side * turn;
        let mut angle = left - TAU * (left / TAU).floor();
        if TAU - angle <= NOTHING {
            angle = 0.0;
        }
        let (radius, count) = (self.radius, if self.reverse && angle > NOTHING { 2 } else { 1 });
        let both = [(angle, false), (TAU - angle, true)];
        both.into_iter().take(count).map(move |(angle, back)| Steered {
            along: RunAlong::Circle(side),
            size: radius * angle,
            back,
        })
    }
}

/// Both ways round by an angle, the shorter one first; only one of a full turn.
fn turns(angle: f64) -> impl Iterator<Item = Steered> {
    let short = wrapped(angle);
    let side = 1.0_f64.copysign(short);
    let count = if short.abs() > NOTHING { 2 } else { 1 };
    let both = [(short.abs(), side), (TAU - short.abs(), -side)];
    let piece = |(size, side)| Steered { along: RunAlong::Turn(side), size, back: false };
    both.into_iter().take(count).map(piece)
}

/// The headings of a line between two circles whose centres are apart by this, forwards and
/// backwards; `offset` is how far the second centre is to the left of the first, seen along
/// the heading. `None` where the circles are too near.
fn line_headings(apart: &Vector<2>, offset: f64) -> Option<[f64; 2]> {
    let sine = offset / apart.norm();
    if sine.abs() > 1.0 {
        return None;
    }
    let direction = libm::atan2(apart.y, apart.x);
    let angle = libm::asin(sine);
    Some([direction - angle, direction - (PI - angle)])
}

fn normal(heading: f64) -> Vector<2> {
    unit(heading + FRAC_PI_2)
}
