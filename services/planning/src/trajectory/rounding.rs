//! Way-points of a translating body passed along curves, so that it need not stop at each.
//!
//! An arc, or a pair of clothoids, replaces the ends of two legs, which it leaves and meets along their
//! directions. It may come no closer to any wall than what it replaces, by exact distances on both, or
//! on clothoids by distances that are certified from below; so all that is known of the path's
//! clearance stays true.

use std::f64::consts::PI;

use super::smooth_turn::{SmoothTurn, TurnStart};
use crate::budget::{Budget, Spent};
use crate::clearance::Clearance;
use crate::clearance::clothoid::{PRECISION, PlacedClothoid};
use crate::clearance::translating::{Body, clearance_body_legs};
use crate::free_space::walls::{Walls, planar};
use crate::geometry::distance::{distance_point_segment, distance_segment_segment};
use crate::geometry::{Sign, Vector, polygon};
use crate::motion::{Curve, Leg, wrapped};

/// Turns sharper than this, radians, or nearly none, stay as they are.
const SHARPEST: f64 = PI - 1e-3;
const SLIGHTEST: f64 = 1e-6;

/// How often an arc that comes too close is halved before the corner stays sharp.
const HALVINGS: usize = 40;

/// Steps that an edge against a wall takes.
const STEPS_PER_PAIR: u64 = 8;

/// Distances that differ by this part of the coordinates are equal.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// What corners are rounded with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CornerShape {
    /// An arc.
    Arc,
    /// Two clothoids, so that the curvature is continuous.
    Clothoids,
}

/// A part of a circle, run through from `start` by `sweep`.
#[derive(Debug, Clone, Copy)]
struct RoundedCorner {
    center: Vector<2>,
    radius: f64,
    start: f64,
    sweep: f64,
}

impl RoundedCorner {
    fn at(&self, part: f64) -> Vector<2> {
        let (sin, cos) = libm::sincos(self.start + part * self.sweep);
        self.center + Vector::from([cos, sin]) * self.radius
    }

    /// Which part of the arc lies in this direction from the centre, if any does.
    fn part_towards(&self, way: &Vector<2>) -> Option<f64> {
        let angle = wrapped(libm::atan2(way.y, way.x) - self.start) * self.sweep.signum();
        let part = angle / self.sweep.abs();
        (0.0..=1.0).contains(&part).then_some(part)
    }

    /// The least distance to a segment, and where on the arc it is, from 0 to 1.
    fn distance(&self, (a, b): (&Vector<2>, &Vector<2>)) -> (f64, f64) {
        let mut best = (f64::INFINITY, 0.0);
        let mut take = |distance: f64, part: f64| {
            if distance < best.0 {
                best = (distance, part);
            }
        };
        for part in [0.0, 1.0] {
            take(distance_point_segment(&self.at(part), (a, b)), part);
        }
        // Towards an end of the segment, or away from it where that is inside the circle.
        for end in [a, b] {
            let way = end - self.center;
            if let Some(part) = self.part_towards(&way) {
                take((way.norm() - self.radius).abs(), part);
            }
        }
        let along = b - a;
        let length = along.norm();
        if length > 0.0 {
            let normal = Vector::from([-along.y, along.x]) / length;
            let height = normal.dot(&(self.center - a));
            if height.abs() < self.radius {
                // Where the circle crosses the segment's line.
                let half = (self.radius * self.radius - height * height).sqrt();
                for half in [half, -half] {
                    let crossing = along * (half / length) - normal * height;
                    let place = (self.center + crossing - a).dot(&along) / (length * length);
                    if (0.0..=1.0).contains(&place)
                        && let Some(part) = self.part_towards(&crossing)
                    {
                        take(0.0, part);
                    }
                }
            }
            // Straight across from the segment.
            for normal in [normal, -normal] {
                if let Some(part) = self.part_towards(&normal) {
                    take(distance_point_segment(&self.at(part), (a, b)), part);
                }
            }
        }
        best
    }

    fn curve(&self) -> Curve<2> {
        let Self { center, radius, start, sweep } = *self;
        Curve::Arc { center, radius, start_angle: wrapped(start), sweep, reverse: false }
    }
}

/// Where a path turns.
#[derive(Debug, Clone, Copy)]
struct WayPoint {
    at: Vector<2>,
    /// Directions before and after.
    before: Vector<2>,
    after: Vector<2>,
    /// Signed angle from one to the other.
    turn: f64,
}

impl WayPoint {
    fn between<const D: usize>(one: &Curve<D>, other: &Curve<D>) -> Option<Self> {
        let (Curve::Line { from, to, .. }, Curve::Line { to: end, .. }) = (one, other) else {
            return None;
        };
        let (from, to, end) = (planar(from), planar(to), planar(end));
        let (before, after) = (to - from, end - to);
        let (before, after) = (before.try_normalize(0.0)?, after.try_normalize(0.0)?);
        let turn = libm::atan2(before.perp(&after), before.dot(&after));
        let corner = Self { at: to, before, after, turn };
        (SLIGHTEST..SHARPEST).contains(&turn.abs()).then_some(corner)
    }

    /// The arc that leaves and meets the legs at this distance from the corner.
    fn arc(&self, reach: f64) -> RoundedCorner {
        let radius = reach / libm::tan(0.5 * self.turn.abs());
        let sense = self.turn.signum();
        let inwards = Vector::from([-self.before.y, self.before.x]) * sense;
        let out = -inwards;
        let center = self.at - self.before * reach + inwards * radius;
        RoundedCorner { center, radius, start: libm::atan2(out.y, out.x), sweep: self.turn }
    }

    /// The curves that leave and meet the legs at this distance from the corner.
    fn curves(&self, shape: CornerShape, reach: f64) -> Vec<Curve<2>> {
        match shape {
            CornerShape::Arc => vec![self.arc(reach).curve()],
            CornerShape::Clothoids => {
                let turn = SmoothTurn::new(self.turn.abs(), 1.0);
                let size = turn.between_tangents(reach);
                let start = TurnStart {
                    position: self.at - self.before * reach,
                    heading: libm::atan2(self.before.y, self.before.x),
                    reverse: false,
                };
                let end = self.at + self.after * reach;
                turn.curves(size, Sign::of(self.turn), &start, end).collect()
            }
        }
    }
}

/// A curve of the plane among `D` coordinates, of which the others are those of a point.
fn raised<const D: usize>(curve: &Curve<2>, like: &Vector<D>) -> Curve<D> {
    let raise = |point: &Vector<2>| {
        let mut raised = *like;
        (raised[0], raised[1]) = (point.x, point.y);
        raised
    };
    match *curve {
        Curve::Line { from, to, heading, turned } => {
            Curve::Line { from: raise(&from), to: raise(&to), heading, turned }
        }
        Curve::Arc { center, radius, start_angle, sweep, reverse } => {
            Curve::Arc { center: raise(&center), radius, start_angle, sweep, reverse }
        }
        Curve::Clothoid { from, to, from_heading, curvatures, length, reverse } => {
            let (from, to) = (raise(&from), raise(&to));
            Curve::Clothoid { from, to, from_heading, curvatures, length, reverse }
        }
        Curve::Turn { position, from_heading, sweep } => {
            Curve::Turn { position: raise(&position), from_heading, sweep }
        }
    }
}

/// How close a translating body comes to walls on a rounded corner's curve: exactly on an arc, from below
/// on a clothoid. `at` is the part of the curve.
fn clearance_on_curve<const D: usize>(
    (body, outlines): (&Body<'_, D>, &[Vec<Vector<2>>]),
    walls: &Walls<D>,
    curve: &Curve<2>,
    budget: &Budget<'_>,
) -> Result<Clearance<D>, Spent> {
    let nearest = match *curve {
        Curve::Arc { center, radius, start_angle: start, sweep, .. } => {
            let arc = RoundedCorner { center, radius, start, sweep };
            return clearance_on_arc(outlines, walls, &arc, budget);
        }
        Curve::Line { from, to, .. } => {
            let curve = Curve::translation(spatial(&from), spatial(&to));
            let leg = Leg { curve, junction: None, rule: None, rung: None };
            let mut near = clearance_body_legs(body, walls, &[leg], &mut Vec::new(), budget)?;
            if let Some(near) = &mut near {
                near.at /= curve.length();
            }
            near
        }
        Curve::Clothoid { .. } => match PlacedClothoid::of(curve) {
            Some(clothoid) => {
                let bounds = (0.0, f64::INFINITY, f64::NEG_INFINITY);
                let near = clothoid.least(bounds, |piece, _| {
                    budget.step(1)?;
                    let near = clearance_on_curve((body, outlines), walls, piece, budget)?;
                    Ok(Clearance { value: near.value, at: near.at, wall: planar(&near.wall) })
                })?;
                Some(Clearance { value: near.value, at: near.at, wall: spatial(&near.wall) })
            }
            None => None,
        },
        Curve::Turn { .. } => None,
    };
    Ok(nearest.unwrap_or(Clearance { value: f64::INFINITY, at: 0.0, wall: Vector::zeros() }))
}

/// How close a translating body comes to walls on an arc.
fn clearance_on_arc<const D: usize>(
    outlines: &[Vec<Vector<2>>],
    walls: &Walls<D>,
    arc: &RoundedCorner,
    budget: &Budget<'_>,
) -> Result<Clearance<D>, Spent> {
    // The arc lies in the box around its middle of half its length.
    let (middle, reach) = (arc.at(0.5), 0.5 * arc.radius * arc.sweep.abs());
    let (mut min, mut max) =
        (Vector::<2>::repeat(f64::INFINITY), Vector::<2>::repeat(f64::NEG_INFINITY));
    let mut vertices = 0;
    for vertex in outlines.iter().flatten() {
        (min, max) = (min.inf(vertex), max.sup(vertex));
        vertices += 1;
    }
    let around = Vector::repeat(reach);
    let (min, max) = (spatial(&(min + middle - around)), spatial(&(max + middle + around)));
    let mut nearest = Clearance { value: f64::INFINITY, at: 0.0, wall: Vector::zeros() };
    let mut spent = Ok(());
    walls.nearest(&min, &max, budget, |_, wall| {
        spent = budget.step(STEPS_PER_PAIR * vertices);
        if spent.is_err() {
            return -1.0;
        }
        let (a, b) = (planar(&wall.from), planar(&wall.to));
        for (vertex, next) in outlines.iter().flat_map(|outline| polygon::edges(outline)) {
            // The body's vertex runs along the arc; the wall's end runs backwards past an edge.
            let shifted = RoundedCorner { center: arc.center + vertex, ..*arc };
            let (value, at) = shifted.distance((&a, &b));
            if value < nearest.value {
                let place = shifted.at(at);
                let wall = spatial(&nearest_on((&a, &b), &place));
                nearest = Clearance { value, at, wall };
            }
            for end in [a, b] {
                let mirrored =
                    RoundedCorner { center: end - arc.center, start: arc.start + PI, ..*arc };
                let (value, at) = mirrored.distance((&vertex, &next));
                if value < nearest.value {
                    nearest = Clearance { value, at, wall: spatial(&end) };
                }
            }
        }
        nearest.value
    })?;
    spent.map(|()| nearest)
}

fn nearest_on((a, b): (&Vector<2>, &Vector<2>), point: &Vector<2>) -> Vector<2> {
    distance_segment_segment((point, point), (a, b)).point
}

/// The point of the plane among `D` coordinates.
fn spatial<const D: usize>(point: &Vector<2>) -> Vector<D> {
    let mut spatial = Vector::zeros();
    (spatial[0], spatial[1]) = (point.x, point.y);
    spatial
}

/// Puts curves of a shape in place of the corners of a polyline: each as large as half of the shorter
/// leg beside it allows, halved until it comes no closer to a wall than the legs that it replaces.
/// `each` gets the clearance of every leg of `rounded`; the result is that of the whole motion.
///
/// Only the first two coordinates are looked at.
pub fn round_corners<const D: usize>(
    (body, corner_shape): (&Body<'_, D>, CornerShape),
    walls: &Walls<D>,
    legs: &[Leg<D>],
    (rounded, each): (&mut Vec<Leg<D>>, &mut Vec<Clearance<D>>),
    budget: &Budget<'_>,
) -> Result<Option<Clearance<D>>, Spent> {
    let outlines = body.outlines();
    let mut of_line = Vec::new();
    let mut on_line = |from: Vector<D>, to: Vector<D>| {
        let leg =
            Leg { curve: Curve::translation(from, to), junction: None, rule: None, rung: None };
        clearance_body_legs(body, walls, &[leg], &mut of_line, budget)
    };
    rounded.clear();
    each.clear();
    let mut begin = legs.first().map_or(Vector::zeros(), |leg| leg.curve.start());
    for (index, leg) in legs.iter().enumerate() {
        let end = leg.curve.end();
        let corner =
            legs.get(index + 1).and_then(|next| WayPoint::between(&leg.curve, &next.curve));
        let mut found = None;
        if let (Some(corner), Some(next)) = (corner, legs.get(index + 1)) {
            let mut reach = 0.5 * leg.curve.length().min(next.curve.length());
            for _ in 0..HALVINGS {
                let from = spatial(&(corner.at - corner.before * reach));
                let to = spatial(&(corner.at + corner.after * reach));
                let replaced = [on_line(from, end)?, on_line(end, to)?];
                let least = replaced.iter().flatten().map(|near| near.value);
                let least = least.fold(f64::INFINITY, f64::min);
                let mut curves = Vec::new();
                let mut nearest = f64::INFINITY;
                for curve in corner.curves(corner_shape, reach) {
                    let near = clearance_on_curve((body, &outlines), walls, &curve, budget)?;
                    nearest = nearest.min(near.value);
                    curves.push((curve, near));
                }
                let vertices = outlines.iter().flatten();
                let extent = end.amax() + vertices.map(|v| v.amax()).fold(0.0, f64::max);
                let below = match corner_shape {
                    CornerShape::Arc => 0.0,
                    CornerShape::Clothoids => 4.0 * PRECISION * reach,
                };
                if least > below && nearest >= least - below - ROUNDING * extent {
                    found = Some((curves, from, to));
                    break;
                }
                reach *= 0.5;
            }
        }
        let until = found.as_ref().map_or(end, |(_, from, _)| *from);
        // Two curves that meet do so but for rounding.
        let is_apart = (until - begin).amax() > ROUNDING * until.amax().max(begin.amax());
        if is_apart || found.is_none() {
            rounded.push(Leg { curve: Curve::translation(begin, until), ..*leg });
            each.extend(on_line(begin, until)?);
        }
        begin = end;
        if let Some((curves, _, to)) = found {
            for (curve, near) in &curves {
                rounded.push(Leg { curve: raised(curve, &end), ..*leg });
                if near.value < f64::INFINITY {
                    each.push(*near);
                }
            }
            begin = to;
        }
    }
    let mut whole: Option<Clearance<D>> = None;
    let mut travelled = 0.0;
    for (leg, near) in rounded.iter().zip(each.iter_mut()) {
        let length = leg.curve.length();
        // On a curve it is a part, on a line metres from its start.
        let is_line = matches!(leg.curve, Curve::Line { .. });
        near.at = travelled + if is_line { near.at } else { near.at * length };
        travelled += length;
        if whole.is_none_or(|whole| near.value < whole.value) {
            whole = Some(*near);
        }
    }
    Ok(whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::AxisBox;
    use proptest::prelude::*;

    fn polyline(points: &[[f64; 2]]) -> Vec<Leg<2>> {
        let line = |ends: &[[f64; 2]]| Leg {
            curve: Curve::translation(ends[0].into(), ends[1].into()),
            junction: None,
            rule: None,
            rung: None,
        };
        points.windows(2).map(line).collect()
    }

    type Rounded = (Vec<Leg<2>>, Vec<Clearance<2>>, Option<Clearance<2>>);

    fn rounded_by(
        shape: CornerShape,
        body: &AxisBox<2>,
        walls: &Walls<2>,
        legs: &[Leg<2>],
    ) -> Rounded {
        let (mut made, mut each) = (Vec::new(), Vec::new());
        let body = Body::from_box(body);
        let whole =
            round_corners((&body, shape), walls, legs, (&mut made, &mut each), &Budget::default());
        (made, each, whole.unwrap())
    }

    fn rounded(body: &AxisBox<2>, walls: &Walls<2>, legs: &[Leg<2>]) -> Rounded {
        rounded_by(CornerShape::Arc, body, walls, legs)
    }

    /// A right angle between legs of 4 m and 2 m in the open: an arc of radius 1 m about (3, 1).
    #[test]
    fn right_angle_has_a_quarter_circle() {
        let body = AxisBox::new([0.0, 0.0].into(), [1.0, 1.0].into()).unwrap();
        let legs = polyline(&[[0.0, 0.0], [4.0, 0.0], [4.0, 2.0]]);
        let (made, each, whole) = rounded(&body, &Walls::default(), &legs);
        assert_eq!((made.len(), each.len(), whole), (3, 0, None));
        let Curve::Arc { center, radius, sweep, .. } = made[1].curve else { panic!("{made:?}") };
        assert!((center - Vector::from([3.0, 1.0])).norm() < 1e-15);
        assert!((radius - 1.0).abs() < 1e-15 && (sweep - PI / 2.0).abs() < 1e-15);
        assert!((made[1].curve.start() - made[0].curve.end()).norm() < 1e-15);
        assert!((made[1].curve.end() - made[2].curve.start()).norm() < 1e-15);
    }

    /// A box in the inner corner of the turn, 0.1 m from both legs: the arc stays sharp enough.
    #[test]
    fn arc_keeps_to_the_clearance_of_its_corner() {
        let body = AxisBox::new([0.0, 0.0].into(), [1.0, 1.0].into()).unwrap();
        let legs = polyline(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]]);
        let mut walls = Walls::default();
        walls.push_box(&AxisBox::new([1.0, 1.1].into(), [3.9, 5.0].into()).unwrap());
        let (made, each, whole) = rounded(&body, &walls, &legs);
        let Curve::Arc { radius, .. } = made[1].curve else { panic!("{made:?}") };
        // On the arc the body's upper left corner is at least 0.1 m from (3.9, 1.1):
        // sqrt(2) (r + 0.1 - ...) by hand: (r - 0.1) sqrt(2) - r <= -0.1 ... r <= 0.1 / (sqrt(2) - 1) + 0.1.
        assert!(radius > 0.05 && radius < 0.35, "{radius}");
        assert!(each.iter().all(|near| near.value >= 0.1 - 1e-12), "{each:?}");
        assert!((whole.unwrap().value - 0.1).abs() < 1e-12);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]
        /// Against distances from dense places on the arc.
        #[test]
        fn distance_of_an_arc_is_that_of_its_points(
            center in prop::array::uniform2(-3.0..3.0_f64), radius in 0.1..3.0_f64,
            start in -PI..PI, sweep in prop_oneof![0.1..3.0_f64, -3.0..-0.1_f64],
            ends in prop::array::uniform4(-4.0..4.0_f64),
        ) {
            let arc = RoundedCorner { center: center.into(), radius, start, sweep };
            let [a, b, c, d] = ends;
            let (a, b) = (Vector::from([a, b]), Vector::from([c, d]));
            let (value, at) = arc.distance((&a, &b));
            let dense = (0..=4000).map(|k| f64::from(k) / 4000.0);
            let dense = dense.map(|part| distance_point_segment(&arc.at(part), (&a, &b)));
            let least = dense.fold(f64::INFINITY, f64::min);
            let step = radius * sweep.abs() / 4000.0;
            prop_assert!(value <= least + 1e-12 && least <= value + step, "{value} {least}");
            prop_assert!((distance_point_segment(&arc.at(at), (&a, &b)) - value).abs() < 1e-7);
        }

        /// No clearance is lost, ends meet, directions are tangent.
        #[test]
        fn rounding_loses_no_clearance(
            points in prop::collection::vec(prop::array::uniform2(-6.0..6.0_f64), 3..6),
            boxes in prop::collection::vec(
                (prop::array::uniform2(-8.0..8.0_f64), prop::array::uniform2(0.1..2.0_f64)), 1..6),
        ) {
            let body = AxisBox::new([-0.2, -0.3].into(), [0.4, 0.1].into()).unwrap();
            let mut walls = Walls::default();
            for (corner, size) in boxes {
                let corner = Vector::from(corner);
                walls.push_box(&AxisBox::new(corner, corner + Vector::from(size)).unwrap());
            }
            let legs = polyline(&points);
            let mut each = Vec::new();
            let translating = Body::from_box(&body);
            let before =
                clearance_body_legs(&translating, &walls, &legs, &mut each, &Budget::default());
            let before = before.unwrap().unwrap();
            let (made, each, whole) = rounded(&body, &walls, &legs);
            prop_assert_eq!(made.len(), each.len());
            prop_assert!(whole.unwrap().value >= before.value - 1e-12);
            for pair in made.windows(2) {
                prop_assert!((pair[0].curve.end() - pair[1].curve.start()).norm() < 1e-12);
            }
            prop_assert_eq!(made[0].curve.start(), legs[0].curve.start());
            prop_assert_eq!(made.last().unwrap().curve.end(), legs.last().unwrap().curve.end());
        }
    }
}
