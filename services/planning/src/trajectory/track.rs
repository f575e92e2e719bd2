//! Position and heading of the body along one leg.

use super::state::State;
use crate::geometry::clothoid::{Clothoid, MOST_PHASE, unit_chord};
use crate::geometry::{Sign, Vector, rotated, unit};
use crate::motion::{Curve, Leg, bend_of, wrapped};
use std::f64::consts::PI;

/// Angle between the nodes of an arc, where sine and cosine are computed, radians.
const NODE_SPACING: f64 = 0.5;

/// The direction of a line shorter than this part of its coordinates suffers from rounding.
const SHORT: f64 = 1e-6;

/// A leg, prepared for many evaluations in travel order.
#[derive(Debug, Clone)]
pub(super) struct Track<const D: usize> {
    /// Where it begins; for an arc its centre.
    origin: Vector<D>,
    /// Displacement per metre; zero for turns in place and arcs.
    direction: Vector<D>,
    /// Heading at its start.
    heading: f64,
    /// Signed radians turned per metre; +-1 in place.
    curvature: f64,
    bow: Bow,
}

/// How the way of a leg bends.
#[derive(Debug, Clone)]
enum Bow {
    /// Not at all.
    Straight,
    Round(Arc),
    Spiral(Spiral),
}

/// What has to be computed for each state of a leg.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TrackShape {
    /// The position: a line.
    Line,
    /// The heading as well: a turn in place, a line that turns on the way.
    Bend,
    /// The direction of travel, too: an arc.
    Arc,
    /// All of it by series: a clothoid.
    Clothoid,
}

/// A clothoid, with the place and the direction of travel at a node nearby.
#[derive(Debug, Clone)]
struct Spiral {
    bend: Clothoid,
    /// The direction of travel at its start, radians.
    direction: f64,
    /// Arc length, displacement from the start and unit vector of travel at the node.
    node: f64,
    place: Vector<2>,
    towards: Vector<2>,
}

/// An arc about a centre, with the direction from it to the body at a node nearby.
#[derive(Debug, Clone)]
struct Arc {
    radius: f64,
    start_angle: f64,
    /// +1.0 turns left, -1.0 right.
    sense: f64,
    /// Angle run through at the node, and its rounding error, which for large angles
    /// exceeds all others.
    node: f64,
    error: f64,
    cos: f64,
    sin: f64,
}

impl<const D: usize> Track<D> {
    /// The track of a leg; `length` in metres, or in radians if it turns `in_place`.
    pub(super) fn new(leg: &Leg<D>, length: f64, in_place: bool) -> Self {
        let heading = leg.curve.start_heading();
        let none = Vector::zeros();
        match leg.curve {
            Curve::Line { from, turned, .. } if in_place => Self {
                origin: from,
                direction: none,
                heading,
                curvature: sense(turned),
                bow: Bow::Straight,
            },
            Curve::Line { from, to, turned, .. } => Self {
                origin: from,
                direction: direction(&from, &to, length, heading),
                heading,
                curvature: turned / length + 0.0,
                bow: Bow::Straight,
            },
            Curve::Turn { position, sweep, .. } => {
                let curvature = sense(sweep);
                Self { origin: position, direction: none, heading, curvature, bow: Bow::Straight }
            }
            // The radius is negligible: the centre is the place.
            Curve::Arc { center, sweep, .. } if in_place => {
                let curvature = sense(sweep);
                Self { origin: center, direction: none, heading, curvature, bow: Bow::Straight }
            }
            // Driven backwards the place and the way are the same; the heading is the curve's.
            Curve::Arc { center, radius, start_angle, sweep, .. } => {
                let sense = sense(sweep);
                let bow = Bow::Round(Arc::new(radius, start_angle, sense));
                Self { origin: center, direction: none, heading, curvature: sense / radius, bow }
            }
            Curve::Clothoid { from, .. } if in_place => {
                let curvature = sense(leg.curve.turned());
                Self { origin: from, direction: none, heading, curvature, bow: Bow::Straight }
            }
            Curve::Clothoid { from, from_heading, curvatures, reverse, .. } => {
                let direction = from_heading + if reverse { PI } else { 0.0 };
                let bow = Bow::Spiral(Spiral::new(bend_of(curvatures, length), direction));
                Self { origin: from, direction: none, heading, curvature: curvatures[0], bow }
            }
        }
        .normalised()
    }

    /// Without negative zeros, so that sums have none.
    fn normalised(mut self) -> Self {
        self.origin = self.origin.map(|x| x + 0.0);
        self.direction = self.direction.map(|x| x + 0.0);
        self
    }

    /// Selects `on_line`, `on_bend`, `on_arc` or `on_clothoid`.
    #[inline]
    pub(super) fn shape(&self) -> TrackShape {
        match &self.bow {
            Bow::Round(_) => TrackShape::Arc,
            Bow::Spiral(_) => TrackShape::Clothoid,
            Bow::Straight if self.curvature == 0.0 => TrackShape::Line,
            Bow::Straight => TrackShape::Bend,
        }
    }

    /// The state at `time`, `along` from the start (metres, or radians in
    /// place) with `speed` there.
    #[inline]
    pub(super) fn state(&mut self, time: f64, along: f64, speed: f64) -> State<D> {
        match self.shape() {
            TrackShape::Line => self.on_line(time, along, speed),
            TrackShape::Bend => self.on_bend(time, along, speed),
            TrackShape::Arc => self.on_arc(time, along, speed),
            TrackShape::Clothoid => self.on_clothoid(time, along, speed),
        }
    }

    /// `state` of a line without turning.
    #[inline]
    pub(super) fn on_line(&mut self, time: f64, along: f64, speed: f64) -> State<D> {
        State {
            time,
            position: self.origin + self.direction * along,
            heading: self.heading,
            velocity: self.direction * speed,
            yaw_rate: 0.0,
        }
    }

    /// `state` of a turn in place and of a line that turns on the way.
    #[inline]
    pub(super) fn on_bend(&mut self, time: f64, along: f64, speed: f64) -> State<D> {
        State {
            heading: wrapped(self.heading + self.curvature * along),
            yaw_rate: self.curvature * speed,
            ..self.on_line(time, along, speed)
        }
    }

    /// `state` of an arc.
    #[inline]
    pub(super) fn on_arc(&mut self, time: f64, along: f64, speed: f64) -> State<D> {
        let mut state = self.on_bend(time, along, speed);
        if let Bow::Round(arc) = &mut self.bow {
            let (cos, sin) = arc.direction(along);
            let across = speed * arc.sense;
            state.position[0] += arc.radius * cos;
            state.position[1] += arc.radius * sin;
            // A product may be a negative zero, a sum with zero is not.
            state.velocity[0] = 0.0 - across * sin;
            state.velocity[1] = 0.0 + across * cos;
        }
        state
    }

    /// `state` of a clothoid.
    #[inline]
    pub(super) fn on_clothoid(&mut self, time: f64, along: f64, speed: f64) -> State<D> {
        let mut state = self.on_line(time, along, speed);
        if let Bow::Spiral(spiral) = &mut self.bow {
            let (place, towards) = spiral.at(along);
            for axis in 0..2 {
                state.position[axis] += place[axis];
                state.velocity[axis] += towards[axis] * speed;
            }
            state.heading = wrapped(self.heading + spiral.bend.turned(along));
            state.yaw_rate = spiral.bend.curvature_at(along) * speed + 0.0;
        }
        state
    }
}

impl Spiral {
    fn new(bend: Clothoid, direction: f64) -> Self {
        Self { bend, direction, node: 0.0, place: Vector::zeros(), towards: unit(direction) }
    }

    /// The displacement from the start and the unit vector of travel `along` metres from there.
    /// Nodes are computed independently, so errors do not add up.
    #[inline]
    fn at(&mut self, along: f64) -> (Vector<2>, Vector<2>) {
        let (mut a, mut b) = self.bend.phases(self.node, along - self.node);
        if a.abs() + b.abs() > MOST_PHASE {
            self.move_node(along);
            (a, b) = (0.0, 0.0);
        }
        let chord = unit_chord(a, b) * (along - self.node);
        let (versine, sin) = small_angle(a + b);
        let turned = rotated(&Vector::<2>::new(1.0 - versine, sin), &self.towards);
        (self.place + rotated(&chord, &self.towards), turned)
    }

    #[inline(never)]
    fn move_node(&mut self, along: f64) {
        self.node = along;
        self.place = rotated(&self.bend.place(along), &unit(self.direction));
        self.towards = unit(self.direction + self.bend.turned(along));
    }
}

impl Arc {
    fn new(radius: f64, start_angle: f64, sense: f64) -> Self {
        let (sin, cos) = libm::sincos(start_angle);
        Self { radius, start_angle, sense, node: 0.0, error: 0.0, cos, sin }
    }

    /// Cosine and sine of the angle from the centre to the body, `along` metres
    /// from the start of the arc: those of the nearest node, rotated by the small angle
    /// that remains. Nodes are computed independently, so errors do not add up.
    #[inline]
    fn direction(&mut self, along: f64) -> (f64, f64) {
        let turned = along / self.radius;
        let mut rest = turned - self.node;
        if rest.abs() > 0.5 * NODE_SPACING {
            self.move_node(turned);
            rest = turned - self.node;
        }
        let (versine, sin) = small_angle(rest * self.sense + self.error);
        (
            self.cos - (self.cos * versine + self.sin * sin),
            self.sin - (self.sin * versine - self.cos * sin),
        )
    }

    #[inline(never)]
    fn move_node(&mut self, turned: f64) {
        self.node = NODE_SPACING * ((turned / NODE_SPACING + 0.5) as i64 as f64);
        let (angle, error) = exact_sum(self.start_angle, self.sense * self.node);
        (self.sin, self.cos) = libm::sincos(angle);
        self.error = error;
    }
}

/// A sum and its rounding error (Knuth).
fn exact_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let from_b = sum - a;
    (sum, (a - (sum - from_b)) + (b - from_b))
}

/// `1 - cos x` and `sin x` for `|x| <= 0.25` by Taylor series; the terms left out are
/// below 3e-18.
#[inline]
fn small_angle(x: f64) -> (f64, f64) {
    const FACTORIAL: [f64; 13] = {
        let mut factorial = [1.0; 13];
        let mut n = 1;
        while n < 13 {
            factorial[n] = factorial[n - 1] * n as f64;
            n += 1;
        }
        factorial
    };
    const fn over(n: usize) -> f64 {
        1.0 / FACTORIAL[n]
    }
    const VERSINE: [f64; 6] = [over(2), -over(4), over(6), -over(8), over(10), -over(12)];
    const SINE: [f64; 5] = [-over(3), over(5), -over(7), over(9), -over(11)];
    let square = x * x;
    let series = |terms: &[f64]| terms.iter().rev().fold(0.0, |sum, term| sum * square + term);
    (square * series(&VERSINE), x + x * square * series(&SINE))
}

/// Unit vector of a line's travel.
///
/// Rounding could turn a very short line, such as between two guiding circles that almost
/// touch, anywhere: if the ends agree with the heading to rounding, the heading is taken, or
/// its opposite if the line is driven backwards.
fn direction<const D: usize>(
    from: &Vector<D>,
    to: &Vector<D>,
    length: f64,
    heading: f64,
) -> Vector<D> {
    let displacement = to - from;
    let extent = from.amax().max(to.amax());
    if length < SHORT * extent {
        let (sin, cos) = libm::sincos(heading);
        let mut along = Vector::zeros();
        (along[0], along[1]) = (cos, sin);
        for along in [along, -along] {
            if (displacement - along * length).amax() <= 4.0 * f64::EPSILON * extent {
                return along;
            }
        }
    }
    displacement / length
}

/// +1.0 for a left turn, -1.0 for a right turn.
fn sense(angle: f64) -> f64 {
    Sign::of(angle).factor()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn line_too_short_for_its_coordinates_goes_where_it_heads() {
        let (sin, cos) = libm::sincos(0.7);
        let from = Vector::from([1000.0, -2000.0]);
        let to = from + Vector::from([cos, sin]) * 1e-12;
        let length = (to - from).norm();
        assert_eq!(direction(&from, &to, length, 0.7), Vector::from([cos, sin]));
        // The shortest that can be told to be driven backwards.
        let to = from + Vector::from([cos, sin]) * 4e-12;
        let length = (to - from).norm();
        assert_eq!(direction(&to, &from, length, 0.7), Vector::from([-cos, -sin]));
    }

    #[test]
    fn short_line_goes_to_its_end_whatever_its_heading() {
        let (from, to) = (Vector::from([1.0, 2.0]), Vector::from([1.0, 2.0 + 1e-8]));
        let along = direction(&from, &to, (to - from).norm(), 0.0);
        assert_eq!(along, Vector::from([0.0, 1.0]));
    }

    proptest! {
        /// Two roundings of `libm`, two of products and two of sums, each half a
        /// unit in the last place of 1, here and one in the reference: 5e-16.
        #[test]
        fn arcs_agree_with_libm(
            start_angle in -PI..PI, sweep in -TAU..TAU, radius in 1e-3..1e3_f64,
            parts in 1..60_u32,
        ) {
            let mut arc = Arc::new(radius, start_angle, sense(sweep));
            for part in 0..=parts {
                let along = radius * sweep.abs() * f64::from(part) / f64::from(parts);
                let (cos, sin) = arc.direction(along);
                let (angle, error) = exact_sum(start_angle, sense(sweep) * (along / radius));
                let (exact_sin, exact_cos) = libm::sincos(angle);
                prop_assert!((cos - (exact_cos - error * exact_sin)).abs() <= 5e-16);
                prop_assert!((sin - (exact_sin + error * exact_cos)).abs() <= 5e-16);
            }
        }

        #[test]
        fn small_angles_agree_with_libm(x in -0.25..=0.25_f64) {
            let (versine, sin) = small_angle(x);
            let half = libm::sin(0.5 * x);
            prop_assert!((sin - libm::sin(x)).abs() <= f64::EPSILON * x.abs());
            prop_assert!((versine - 2.0 * half * half).abs() <= 3.0 * f64::EPSILON * versine);
        }
    }
}
