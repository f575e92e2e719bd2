//! Straight legs and turns in place between them.

use std::f64::consts::TAU;

use super::probe::Probe;
use crate::budget::Spent;
use crate::driving::legs::NO_LINE;
use crate::driving::{SAME_HEADING, shortest_turn};
use crate::geometry::Vector;
use crate::motion::{Curve, Leg, wrapped};

/// Sweeps up to this are no stop, radians.
pub(super) const NO_TURN: f64 = 1e-9;

/// Points joined by straight legs, in the start pose's frame.
#[derive(Debug, Clone, Default)]
pub(super) struct Way {
    pub(super) knots: Vec<Vector<2>>,
    /// Whether the leg from each point to the next is driven backwards.
    pub(super) backs: Vec<bool>,
    /// The angle turned at each point; empty until the way is [checked](Way::check).
    pub(super) sweeps: Vec<f64>,
}

impl Way {
    /// That of a motion of straight legs and turns in place; `None` if it has others.
    pub(super) fn of(legs: &[Leg<2>], probe: &Probe<'_>) -> Option<Self> {
        let mut way = Self { knots: vec![Vector::zeros()], sweeps: vec![0.0], ..Self::default() };
        for leg in legs {
            match leg.curve {
                Curve::Line { to, turned: 0.0, .. } => {
                    way.backs.push(leg.curve.is_reverse());
                    way.knots.push(probe.in_frame(&to));
                    way.sweeps.push(0.0);
                }
                Curve::Turn { sweep, .. } => *way.sweeps.last_mut()? += sweep,
                _ => return None,
            }
        }
        if let Some(last) = way.knots.last_mut().filter(|_| !way.backs.is_empty()) {
            *last = probe.goal;
        }
        Some(way)
    }

    /// The heading on a leg, radians.
    pub(super) fn heading(&self, leg: usize) -> f64 {
        let (from, to) = (&self.knots[leg], &self.knots[leg + 1]);
        let way = if self.backs[leg] { from - to } else { to - from };
        libm::atan2(way.y, way.x)
    }

    /// The headings before and after the turn at a point.
    pub(super) fn headings_at(&self, knot: usize, probe: &Probe<'_>) -> [f64; 2] {
        let before = match knot.checked_sub(1) {
            Some(leg) => self.heading(leg),
            None => 0.0,
        };
        let after = if knot < self.backs.len() {
            self.heading(knot)
        } else {
            probe.goal_heading.unwrap_or(before)
        };
        [before, after]
    }

    /// Finds the turns; returns whether all legs and turns are free.
    pub(super) fn check(&mut self, probe: &Probe<'_>) -> Result<bool, Spent> {
        self.sweeps.clear();
        for knot in 0..self.knots.len() {
            let [before, after] = self.headings_at(knot, probe);
            let Some(sweep) = probe.turn(&self.knots[knot], before, after)? else {
                return Ok(false);
            };
            self.sweeps.push(sweep);
        }
        for (leg, back) in self.backs.iter().enumerate() {
            if !probe.is_line_free(&self.knots[leg], &self.knots[leg + 1], *back)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Finds the turn at a point anew, the same way round.
    pub(super) fn turn_again(&mut self, knot: usize, probe: &Probe<'_>) {
        let [before, after] = self.headings_at(knot, probe);
        let short = shortest_turn(before, after);
        let turns = libm::round((self.sweeps[knot] - short) / TAU);
        self.sweeps[knot] = short + turns * TAU;
    }

    /// What a turn costs, with the stop for it; metres.
    pub(super) fn cost_of_turn(&self, knot: usize, sweep: f64, probe: &Probe<'_>) -> f64 {
        let costs = &probe.errand.costs;
        let is_inside = 0 < knot && knot < self.backs.len();
        let stops =
            is_inside && (sweep.abs() > NO_TURN || self.backs[knot - 1] != self.backs[knot]);
        costs.turn * sweep.abs() + if stops { costs.stop } else { 0.0 }
    }

    pub(super) fn length_of(&self, leg: usize) -> f64 {
        (self.knots[leg + 1] - self.knots[leg]).norm()
    }

    /// What it costs, once it is checked; metres.
    pub(super) fn cost(&self, probe: &Probe<'_>) -> f64 {
        let turns = self.sweeps.iter().enumerate();
        let turns: f64 = turns.map(|(knot, sweep)| self.cost_of_turn(knot, *sweep, probe)).sum();
        turns + (0..self.backs.len()).map(|leg| self.length_of(leg)).sum::<f64>()
    }

    /// The way in the scene as it is, to the goal as it is.
    pub(super) fn brought_back(&self, own: &Probe<'_>, exact: &Probe<'_>) -> Self {
        let last = self.backs.len();
        let mut way = Self::default();
        for (knot, at) in self.knots.iter().enumerate() {
            let is_inside = 0 < knot && knot < last;
            if is_inside
                && self.sweeps[knot].abs() <= NO_TURN
                && self.backs[knot - 1] == self.backs[knot]
            {
                continue;
            }
            if knot < last {
                way.backs.push(self.backs[knot]);
            }
            way.knots.push(if 0 < knot && knot == last { exact.goal } else { at * own.unit });
            way.sweeps.push(self.sweeps[knot]);
        }
        for knot in 0..way.knots.len() {
            way.turn_again(knot, exact);
        }
        way
    }

    /// Its curves, if they are free with all rounding.
    pub(super) fn curves(&self, probe: &Probe<'_>) -> Result<Option<Vec<Curve<2>>>, Spent> {
        let mut curves = Vec::with_capacity(2 * self.knots.len());
        let mut heading = wrapped(probe.errand.start.heading);
        let turn = |knot: usize, from_heading: f64, to: f64| {
            let short = shortest_turn(from_heading, to);
            // The way round that was found free.
            let turns = libm::round((self.sweeps[knot] - short) / TAU);
            let sweep = short + turns * TAU;
            let position = probe.in_world(&self.knots[knot]);
            Curve::Turn { position, from_heading, sweep }
        };
        for leg in 0..self.backs.len() {
            let line = probe.line(&self.knots[leg], &self.knots[leg + 1], self.backs[leg]);
            let Curve::Line { from, to, heading: next, .. } = line else { continue };
            if line.length() <= NO_LINE {
                continue;
            }
            let same = Probe::same_heading(&from, &to);
            if shortest_turn(heading, next).abs() <= same {
                curves.push(Curve::Line { from, to, heading, turned: 0.0 });
            } else {
                curves.push(turn(leg, heading, next));
                curves.push(line);
                heading = next;
            }
        }
        if let Some(goal) = probe.errand.goal.heading {
            let last = self.knots.len() - 1;
            let same = match curves.last() {
                Some(Curve::Line { from, to, .. }) => Probe::same_heading(from, to),
                _ => SAME_HEADING,
            };
            let goal = wrapped(goal);
            if shortest_turn(heading, goal).abs() > same {
                curves.push(turn(last, heading, goal));
            }
        }
        if curves.is_empty() {
            let position = probe.errand.start.position;
            curves.push(Curve::Turn { position, from_heading: heading, sweep: 0.0 });
        }
        for curve in &curves {
            if !probe.is_free(curve)? {
                return Ok(None);
            }
        }
        Ok(Some(curves))
    }
}
