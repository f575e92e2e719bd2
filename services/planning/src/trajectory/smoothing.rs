//! Robots that turn at corners with continuous curvature, so that they need not stop at them.
//!
//! Each arc gives way to a [smooth turn](super::smooth_turn) between the same tangents, which comes no
//! closer to any wall than what it replaces, and no closer to the arc's centre, which on a taut path
//! is the corner turned about. So the gap that the motion keeps stays as it is.

use super::clothoid_bounds::ClothoidBounds;
use super::limits::Limits;
use super::profile::runs_into;
use super::smooth_turn::{SmoothTurn, TurnStart};
use crate::budget::{Budget, Spent};
use crate::clearance::Clearance;
use crate::clearance::clothoid::PRECISION;
use crate::clearance::rectangle::{Footprint, Met, nearest, nearest_along, stays_clear};
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::{Sign, Vector, unit};
use crate::motion::{Curve, Leg};
use std::f64::consts::PI;

/// What parts of a turn may be on clothoids.
const ON_CLOTHOIDS: [f64; 3] = [1.0, 0.6, 0.3];

/// How far outside of an arc a smooth turn may begin, as parts of the way at which both have the
/// same middle.
const BEYOND: [f64; 5] = [1.0, 0.75, 0.5, 0.25, 0.0];

/// How much of the line beside an arc a smooth turn may take.
const OF_LINE: f64 = 0.99;

/// Arcs of less turn, radians, or radius, metres, stay as they are.
const NOTHING: f64 = 1e-6;

/// Distances that differ by this part of the coordinates are equal.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Steps that trying a turn takes.
const STEPS_PER_TURN: u64 = 8;

/// What is asked of a robot whose turns are to be smooth.
#[derive(Debug, Clone, Copy)]
pub struct SmoothDriving<'a> {
    /// The robot.
    pub footprint: &'a Footprint,
    /// The walls that it comes no closer to.
    pub walls: &'a Walls<2>,
    /// What decides which turn is the fastest.
    pub limits: &'a Limits,
    /// The least radius of any turn, metres.
    pub min_turn_radius: f64,
}

/// A motion whose turns are smooth where that is possible.
#[derive(Debug, Clone, Default)]
pub struct SmoothedDrive {
    /// The legs in travel order.
    pub legs: Vec<Leg<2>>,
    /// The clearance over every leg, metres; infinite without walls.
    pub leg_clearances: Vec<f64>,
    /// The clearance over the whole motion; `None` without walls.
    pub clearance: Option<Clearance<2>>,
    /// Arc length, metres.
    pub length: f64,
}

/// An arc that is to give way, and how much of the lines beside it may, metres.
#[derive(Debug, Clone, Copy)]
struct SharpTurn {
    center: Vector<2>,
    radius: f64,
    sweep: f64,
    start: TurnStart,
    end: Vector<2>,
    room: f64,
}

/// A smooth turn in place of an arc.
#[derive(Debug, Clone, Copy)]
struct TurnTrial {
    shape: SmoothTurn,
    size: f64,
    beyond: f64,
    /// The square of the greatest speed on it.
    most: f64,
}

/// Puts smooth turns in place of arcs: of those that are free, the one that can be driven fastest.
/// Arcs for which there is none stay.
pub fn smooth_drive(
    task: &SmoothDriving<'_>,
    legs: &[Leg<2>],
    budget: &Budget<'_>,
) -> Result<SmoothedDrive, Spent> {
    let mut smoothed = SmoothedDrive::default();
    let made = &mut smoothed.legs;
    let mut rest = legs.to_vec();
    for index in 0..rest.len() {
        let leg = rest[index];
        budget.step(1)?;
        let found = match SharpTurn::of(made.last(), &rest[index..]) {
            Some(turn) => task.smoothed(&turn, &leg.curve, budget)?,
            None => None,
        };
        let Some(SmoothFit { from, to, curves }) = found else {
            made.push(leg);
            continue;
        };
        if let Some(Leg { curve: Curve::Line { to: end, .. }, .. }) = made.last_mut() {
            *end = from;
        }
        if let Some(Leg { curve: Curve::Line { from: begin, .. }, .. }) = rest.get_mut(index + 1) {
            *begin = to;
        }
        made.extend(curves.into_iter().map(|curve| Leg { curve, ..leg }));
    }
    let mut whole = Met::NOTHING;
    nearest_along(task.footprint, made, task.walls, budget, |_, met, at| {
        whole.offer(met.value, at, met.wall);
        smoothed.leg_clearances.push(met.value);
        Ok::<_, Spent>(())
    })?;
    smoothed.clearance = whole.clearance();
    smoothed.length = smoothed.legs.iter().map(|leg| leg.curve.length()).sum();
    Ok(smoothed)
}

/// The curves of a smooth turn, and where they begin and end.
struct SmoothFit {
    from: Vector<2>,
    to: Vector<2>,
    curves: Vec<Curve<2>>,
}

impl SharpTurn {
    /// The first of `legs`, if it is an arc, after the leg `before` it.
    fn of(before: Option<&Leg<2>>, legs: &[Leg<2>]) -> Option<Self> {
        let curve = &legs[0].curve;
        let Curve::Arc { center, radius, sweep, reverse, .. } = *curve else { return None };
        if radius < NOTHING || sweep.abs() < NOTHING {
            return None;
        }
        let line = |one: &Curve<2>, other: &Curve<2>, line: &Curve<2>| {
            let is_line = matches!(line, Curve::Line { turned: 0.0, .. });
            if is_line && runs_into(one, other) { line.length() } else { 0.0 }
        };
        let ahead = before.map_or(0.0, |leg| line(&leg.curve, curve, &leg.curve));
        let behind = legs.get(1).map_or(0.0, |leg| line(curve, &leg.curve, &leg.curve));
        // The turn at the other end of the line has the other half of it.
        let is_shared = legs.get(2).is_some_and(|leg| matches!(leg.curve, Curve::Arc { .. }));
        let behind = if is_shared { 0.5 * behind } else { behind };
        let start = TurnStart { position: curve.start(), heading: curve.start_heading(), reverse };
        let room = OF_LINE * ahead.min(behind);
        Some(Self { center, radius, sweep, start, end: curve.end(), room })
    }

    /// The unit vectors of travel at its start and at its end.
    fn ways(&self) -> [Vector<2>; 2] {
        let direction = self.start.heading + if self.start.reverse { PI } else { 0.0 };
        [direction, direction + self.sweep].map(unit)
    }

    /// Smooth turns in its place, the fastest first.
    fn trials(&self, limits: &Limits, min_turn_radius: f64) -> Vec<TurnTrial> {
        let mut trials = Vec::new();
        for part in ON_CLOTHOIDS {
            let shape = SmoothTurn::new(self.sweep.abs(), part);
            let most_beyond = shape.beyond_arc(self.radius).min(self.room);
            for share in BEYOND {
                let beyond = share * most_beyond;
                let size = shape.beside_arc(self.radius, beyond);
                if size >= min_turn_radius.max(NOTHING) && (share == 0.0 || beyond > 0.0) {
                    let (curvatures, length) = shape.first(size);
                    let (most, ..) = ClothoidBounds::of(curvatures, length).driven(limits);
                    trials.push(TurnTrial { shape, size, beyond, most });
                }
            }
        }
        trials.sort_by(|one, other| other.most.total_cmp(&one.most));
        trials
    }
}

impl SmoothDriving<'_> {
    /// The fastest smooth turn in place of an arc that comes no closer to walls.
    fn smoothed(
        &self,
        turn: &SharpTurn,
        arc: &Curve<2>,
        budget: &Budget<'_>,
    ) -> Result<Option<SmoothFit>, Spent> {
        let SharpTurn { start, end, .. } = *turn;
        let on_arc = self.nearest(arc, budget)?;
        let [before, after] = turn.ways();
        let mut corner = Walls::default();
        corner.push(Wall { from: turn.center, to: turn.center });
        for trial in turn.trials(self.limits, self.min_turn_radius) {
            budget.step(STEPS_PER_TURN)?;
            let TurnTrial { shape, size, beyond, .. } = trial;
            let (from, to) = (start.position - before * beyond, end + after * beyond);
            let mut kept = on_arc;
            if beyond > 0.0 {
                let line = |from, to, heading| Curve::Line { from, to, heading, turned: 0.0 };
                let replaced =
                    [line(from, start.position, start.heading), line(end, to, arc.end_heading())];
                for line in &replaced {
                    kept = kept.min(self.nearest(line, budget)?);
                }
            }
            let begin = TurnStart { position: from, ..start };
            let curves = shape.curves(size, Sign::of(turn.sweep), &begin, to).collect::<Vec<_>>();
            let beside = turn.radius - 0.5 * self.footprint.width();
            if self.keeps(&curves, self.walls, kept, budget)?
                && (beside <= 0.0 || self.keeps(&curves, &corner, beside, budget)?)
            {
                return Ok(Some(SmoothFit { from, to, curves }));
            }
        }
        Ok(None)
    }

    fn nearest(&self, curve: &Curve<2>, budget: &Budget<'_>) -> Result<f64, Spent> {
        let guess = self.footprint.length().max(self.footprint.width());
        Ok(nearest(self.footprint, curve, self.walls, guess, budget)?.value)
    }

    /// Whether the robot keeps this distance from walls, to what clearance on clothoids is known to.
    fn keeps(
        &self,
        curves: &[Curve<2>],
        walls: &Walls<2>,
        distance: f64,
        budget: &Budget<'_>,
    ) -> Result<bool, Spent> {
        if distance == f64::INFINITY {
            return Ok(true);
        }
        for curve in curves {
            let size = curve.length() + self.footprint.swing_radius();
            let extent = curve.start().amax() + size;
            let least = distance - 2.0 * PRECISION * size - ROUNDING * extent;
            if least <= 0.0 || !stays_clear(self.footprint, curve, walls, least, budget)? {
                return Ok(false);
            }
        }
        Ok(true)
    }
}
