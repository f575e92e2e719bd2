//! Exact answers about poses and short motions, in the frame of the start pose.

use std::f64::consts::{PI, TAU};

use super::Kept;
use super::scene::OwnScene;
use crate::any_angle::Errand;
use crate::any_angle::disc::distance_to;
use crate::budget::{Budget, Spent};
use crate::clearance::rectangle::{clearance_rectangle_pose, free_clearance, stays_clear};
use crate::driving::{Pose, SAME_HEADING, shortest_turn};
use crate::geometry::distance::distance_point_segment;
use crate::geometry::{Vector, rotated, unit, unrotated};
use crate::motion::{Curve, Leg, wrapped};

/// Steps of the budget that looking at a point, or at a motion, takes beside its walls.
const STEPS_PER_LOOK: u64 = 4;

/// Lines longer than this part of the turning circle's radius are looked at piece by piece: the
/// box around a slanted line holds many walls that are far from it.
const PIECE: f64 = 8.0;

/// What a search asks the walls. Points and headings are those of the start pose's frame: the
/// start is the origin and heads along x.
#[derive(Debug, Clone, Copy)]
pub(super) struct Probe<'a> {
    pub(super) errand: &'a Errand<'a>,
    pub(super) budget: &'a Budget<'a>,
    /// What every motion keeps from the walls, metres.
    needs: f64,
    /// Whether the start or the goal is nearer to a wall than that, and so may other poses be to
    /// the same wall points.
    is_docked: bool,
    /// How far computed positions may be off, metres.
    rounding: f64,
    /// The unit of length, metres.
    pub(super) unit: f64,
    /// The errand in metres, and what it keeps there, if the unit is another.
    exact: Option<(&'a Errand<'a>, f64)>,
    /// A circle of this radius about the reference point is free: so is every heading, metres.
    pub(super) swing: f64,
    /// The reference point is nowhere nearer to a wall, metres.
    pub(super) inner: f64,
    /// Where the goal is, metres.
    pub(super) goal: Vector<2>,
    /// Ways longer than this are of no use, metres.
    pub(super) most_length: f64,
    /// The heading at the goal, radians.
    pub(super) goal_heading: Option<f64>,
    /// The start's heading.
    axis: Vector<2>,
}

impl<'a> Probe<'a> {
    pub(super) fn new(
        errand: &'a Errand<'a>,
        kept: Kept,
        budget: &'a Budget<'a>,
    ) -> Result<Self, Spent> {
        let Errand { footprint, start, goal, walls, .. } = errand;
        let Kept { least, as_at_ends, most_length } = kept;
        let rounding = rounding_of(errand);
        let needs = least.max(errand.contact()) + 2.0 * rounding;
        let axis = unit(start.heading);
        let half = footprint.width() / 2.0;
        let mut is_docked = false;
        if as_at_ends {
            let ends = [(start.position, Some(start.heading)), (goal.position, goal.heading)];
            for (position, heading) in ends {
                let Some(heading) = heading else { continue };
                let near = clearance_rectangle_pose(footprint, &position, heading, walls, budget)?;
                is_docked |= near.is_some_and(|near| near.value <= needs);
            }
        }
        Ok(Self {
            errand,
            budget,
            needs,
            is_docked,
            rounding,
            unit: 1.0,
            exact: None,
            swing: footprint.swing_radius() + needs + rounding,
            inner: half.min(footprint.front()).min(footprint.rear()) + needs,
            most_length,
            goal: unrotated(&(goal.position - start.position), &axis),
            goal_heading: goal.heading.map(|heading| wrapped(heading - start.heading)),
            axis,
        })
    }

    /// The same in a scene's own frame, where `own` is the errand.
    pub(super) fn own(
        (errand, kept): (&'a Errand<'a>, Kept),
        (own, scene): (&'a Errand<'a>, &OwnScene),
        budget: &'a Budget<'a>,
    ) -> Result<Self, Spent> {
        let least = scene.kept(kept.least);
        let most_length = scene.at_most(kept.most_length);
        let probe = Self::new(own, Kept { least, most_length, ..kept }, budget)?;
        let needs = kept.least.max(errand.contact()) + 2.0 * rounding_of(errand);
        Ok(Self { unit: scene.length, exact: Some((errand, needs)), ..probe })
    }

    /// The gap that the robot needs to pass in line, metres.
    pub(super) fn width(&self) -> f64 {
        self.errand.footprint.width() + 2.0 * self.needs
    }

    pub(super) fn in_world(&self, point: &Vector<2>) -> Vector<2> {
        if *point == self.goal {
            return self.errand.goal.position;
        }
        self.errand.start.position + rotated(point, &self.axis)
    }

    pub(super) fn in_frame(&self, point: &Vector<2>) -> Vector<2> {
        unrotated(&(point - self.errand.start.position), &self.axis)
    }

    pub(super) fn world_heading(&self, heading: f64) -> f64 {
        wrapped(self.errand.start.heading + heading)
    }

    /// The distance of a point from the walls, at most `most`; metres.
    pub(super) fn distance(&self, point: &Vector<2>, most: f64) -> Result<f64, Spent> {
        let point = self.in_world(point);
        let mut least = most;
        let mut looks = STEPS_PER_LOOK;
        self.errand.walls.near(&point, &point, most, self.budget, |_, wall| {
            looks += 1;
            least = least.min(distance_to(wall, &point));
        })?;
        self.budget.step(looks)?;
        Ok(least)
    }

    /// Whether the robot can turn anywhere here.
    pub(super) fn can_turn(&self, point: &Vector<2>) -> Result<bool, Spent> {
        Ok(self.distance(point, self.swing)? >= self.swing)
    }

    /// The straight line between two points, driven forwards or backwards.
    pub(super) fn line(&self, from: &Vector<2>, to: &Vector<2>, back: bool) -> Curve<2> {
        let [from, to] = [from, to].map(|point| self.in_world(point));
        let way = to - from;
        let direction = libm::atan2(way.y, way.x);
        let heading = if back { wrapped(direction + PI) } else { direction };
        Curve::Line { from, to, heading, turned: 0.0 }
    }

    /// Whether the robot can drive straight from one point to another.
    pub(super) fn is_line_free(
        &self,
        from: &Vector<2>,
        to: &Vector<2>,
        back: bool,
    ) -> Result<bool, Spent> {
        let way = to - from;
        let length = way.norm();
        if length < self.errand.contact() {
            return Ok(true);
        }
        let pieces = (length / (PIECE * self.swing)).ceil().clamp(1.0, 1e6);
        let mut piece = 0.0;
        while piece < pieces {
            let ends = [piece, piece + 1.0]
                .map(|end| if end == pieces { *to } else { from + way * (end / pieces) });
            if !self.is_free(&self.line(&ends[0], &ends[1], back))? {
                return Ok(false);
            }
            piece += 1.0;
        }
        Ok(true)
    }

    /// Whether a motion keeps what it must from the walls.
    pub(super) fn is_free(&self, curve: &Curve<2>) -> Result<bool, Spent> {
        self.budget.step(STEPS_PER_LOOK)?;
        let Errand { footprint, walls, .. } = self.errand;
        let is_clear = stays_clear(footprint, curve, walls, self.needs, self.budget)?;
        if is_clear || !self.is_docked || !self.is_beside_end(curve) {
            return Ok(is_clear);
        }
        let bare = self.errand.contact() + 2.0 * self.rounding;
        Ok(stays_clear(footprint, curve, walls, bare, self.budget)? && self.is_as_at_ends(curve)?)
    }

    /// Whether the robot may come as near to the same wall points as it is at the start or the
    /// goal: it gets there, or next to it.
    fn is_beside_end(&self, curve: &Curve<2>) -> bool {
        let ends = [self.errand.start.position, self.errand.goal.position];
        let apart = |end: &Vector<2>| match curve {
            Curve::Line { from, to, .. } => distance_point_segment(end, (from, to)),
            Curve::Arc { center, radius, .. } => ((end - center).norm() - radius).abs(),
            Curve::Clothoid { from, length, .. } => (end - from).norm() - length,
            Curve::Turn { position, .. } => (end - position).norm(),
        };
        ends.iter().any(|end| apart(end) <= 2.0 * self.swing)
    }

    /// A turn in place by an angle.
    pub(super) fn turn_by(&self, at: &Vector<2>, from: f64, sweep: f64) -> Curve<2> {
        let (position, from_heading) = (self.in_world(at), self.world_heading(from));
        Curve::Turn { position, from_heading, sweep }
    }

    /// The free clearance over a motion, metres; 0 if it touches a wall. Where any heading will do
    /// at the goal, what the robot keeps there counts in full.
    pub(super) fn free_clearance(&self, curve: &Curve<2>) -> Result<f64, Spent> {
        let Errand { footprint, start, goal, walls, .. } = self.errand;
        let bare = self.errand.contact() + 2.0 * self.rounding;
        if !stays_clear(footprint, curve, walls, bare, self.budget)? {
            return Ok(0.0);
        }
        let last = goal.heading.map_or(*start, |heading| Pose { position: goal.position, heading });
        let leg = Leg { curve: *curve, junction: None, rule: None, rung: None };
        let free = free_clearance(footprint, &[leg], walls, &[*start, last], self.budget)?;
        Ok(free.map_or(f64::INFINITY, |free| free.value))
    }

    /// Whether its free clearance is greater than this, metres.
    pub(super) fn is_freer(&self, curve: &Curve<2>, least: f64) -> Result<bool, Spent> {
        let Errand { footprint, walls, .. } = self.errand;
        let bare = self.errand.contact() + 2.0 * self.rounding;
        // What keeps that from all walls is free by as much.
        let is_clear = stays_clear(footprint, curve, walls, least.max(bare), self.budget)?;
        Ok(is_clear || self.free_clearance(curve)? > least)
    }

    /// Whether a motion that touches no wall keeps what it must, or as much as at an end.
    fn is_as_at_ends(&self, curve: &Curve<2>) -> Result<bool, Spent> {
        let arrives = curve.end() == self.errand.goal.position;
        // To the last bit, a wall along which the robot drives is as near as at the end.
        let (errand, needs, curve) = match self.exact {
            Some((errand, needs)) => (errand, needs, placed(curve, self.unit, &errand.start)),
            None => (self.errand, self.needs, *curve),
        };
        let Errand { footprint, start, goal, walls, .. } = errand;
        // A robot that need not have any heading there arrives with this one.
        let arrives = arrives.then(|| curve.end_heading());
        let last = goal.heading.or(arrives);
        let last = last.map_or(*start, |heading| Pose { position: goal.position, heading });
        let leg = Leg { curve, junction: None, rule: None, rung: None };
        let free = free_clearance(footprint, &[leg], walls, &[*start, last], self.budget)?;
        Ok(free.is_none_or(|free| free.value > needs))
    }

    /// What the reference point keeps from the walls at least, metres.
    pub(super) fn inner_at(&self, point: &Vector<2>) -> f64 {
        let is_beside = |end: &Vector<2>| (point - end).norm() <= 2.0 * self.swing;
        if self.is_docked && (is_beside(&Vector::zeros()) || is_beside(&self.goal)) {
            return self.inner - self.needs;
        }
        self.inner
    }

    /// The least angle to turn in place from one heading to another, as far as walls let it;
    /// `None` if neither way round is free.
    pub(super) fn turn(&self, at: &Vector<2>, from: f64, to: f64) -> Result<Option<f64>, Spent> {
        let sweep = shortest_turn(from, to);
        if sweep.abs() <= SAME_HEADING || self.can_turn(at)? {
            return Ok(Some(sweep));
        }
        let position = self.in_world(at);
        let from_heading = self.world_heading(from);
        for sweep in [sweep, sweep - TAU.copysign(sweep)] {
            if self.is_free(&Curve::Turn { position, from_heading, sweep })? {
                return Ok(Some(sweep));
            }
        }
        Ok(None)
    }

    /// From a point straight in a direction: how far the robot drives until it can turn, metres.
    /// `None` if it can't within `most`, or gets too near to a wall before.
    pub(super) fn way_to_turn(
        &self,
        from: &Vector<2>,
        direction: &Vector<2>,
        most: f64,
    ) -> Result<Option<f64>, Spent> {
        // Beyond the first place by a little, so that rounding does not matter.
        let (least_step, beyond) = (0.02 * self.swing, 1e-3 * self.swing);
        let mut way = 0.0;
        while way <= most {
            let lacks = self.swing - self.distance(&(from + direction * way), self.swing)?;
            if lacks <= 0.0 {
                let further = way + beyond;
                let can_turn = self.can_turn(&(from + direction * further))?;
                return Ok(Some(if can_turn { further } else { way }));
            }
            if lacks >= self.swing - 0.5 * self.inner {
                return Ok(None);
            }
            way += lacks.max(least_step);
        }
        Ok(None)
    }

    /// The turn between two headings that differ by no more than rounding at a line's ends is
    /// left out.
    pub(super) fn same_heading(from: &Vector<2>, to: &Vector<2>) -> f64 {
        let length = (to - from).norm();
        SAME_HEADING.max(4.0 * position_rounding(from, to) / length)
    }
}

/// A curve in the frame of a pose, in another unit, in metres.
fn placed(curve: &Curve<2>, unit_length: f64, start: &Pose) -> Curve<2> {
    let axis = unit(start.heading);
    let at = |point: &Vector<2>| start.position + rotated(&(point * unit_length), &axis);
    let turned = |heading: f64| wrapped(start.heading + heading);
    match *curve {
        Curve::Line { from, to, heading, turned: by } => {
            Curve::Line { from: at(&from), to: at(&to), heading: turned(heading), turned: by }
        }
        Curve::Arc { center, radius, start_angle, sweep, reverse } => Curve::Arc {
            center: at(&center),
            radius: radius * unit_length,
            start_angle: turned(start_angle),
            sweep,
            reverse,
        },
        Curve::Clothoid { from, to, from_heading, curvatures, length, reverse } => {
            Curve::Clothoid {
                from: at(&from),
                to: at(&to),
                from_heading: turned(from_heading),
                curvatures: curvatures.map(|curvature| curvature / unit_length),
                length: length * unit_length,
                reverse,
            }
        }
        Curve::Turn { position, from_heading, sweep } => {
            Curve::Turn { position: at(&position), from_heading: turned(from_heading), sweep }
        }
    }
}

fn rounding_of(Errand { start, goal, .. }: &Errand<'_>) -> f64 {
    position_rounding(&start.position, &goal.position)
}

/// How far computed positions may be off, metres.
fn position_rounding(a: &Vector<2>, b: &Vector<2>) -> f64 {
    4.0 * f64::EPSILON * a.amax().max(b.amax())
}
