//! What a body does: legs in travel order, each a line, an arc, a clothoid or a turn in place.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::geometry::clothoid::Clothoid;
use crate::geometry::{Sign, Vector};

/// A rule of the paper, by table and number (numbering: `docs/errata.md`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Rule {
    /// 1: part assembly (section 3); 2: mobile robot (section 5).
    pub table: u8,
    /// Number of the rule in its table, from 1.
    pub number: u8,
}

/// How a leg was found: which construction of the driving path it belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Rung {
    /// The taut path of the guiding circles.
    Taut,
    /// The taut path with other radii at the corners that block it.
    Radius,
    /// Turns in place on the way and straight legs between them.
    Aligned,
    /// Legs driven backwards.
    Reverse,
    /// The search over a lattice of poses.
    Lattice,
}

/// The curve that the body's reference point follows, and how the body turns on it.
///
/// Positions are metres, angles radians counter-clockwise from +x. In assembly
/// tasks positions are displacements from the assembled state and headings are 0.
///
/// ```
/// use std::f64::consts::FRAC_PI_2;
/// use planning::geometry::Vector;
/// use planning::motion::Curve;
///
/// // A left turn through a quarter circle of radius 2 m about (0, 2), from the origin.
/// let center = Vector::from([0.0, 2.0]);
/// let (start_angle, sweep) = (-FRAC_PI_2, FRAC_PI_2);
/// let arc = Curve::Arc { center, radius: 2.0, start_angle, sweep, reverse: false };
/// assert_eq!(arc.length(), 2.0 * FRAC_PI_2);
/// assert!((arc.start() - Vector::from([0.0, 0.0])).norm() < 1e-15);
/// assert!((arc.end() - Vector::from([2.0, 2.0])).norm() < 1e-15);
/// assert_eq!((arc.start_heading(), arc.end_heading()), (0.0, FRAC_PI_2));
///
/// // Driven back to the origin, the robot still heads the way it came.
/// let back = arc.reversed();
/// assert!(back.is_reverse());
/// assert_eq!((back.start_heading(), back.end_heading()), (FRAC_PI_2, 0.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Curve<const D: usize> {
    /// A straight segment, travelled along the heading or, with the heading opposite to the
    /// direction, backwards.
    Line {
        /// Where it begins.
        from: Vector<D>,
        /// Where it ends.
        to: Vector<D>,
        /// Heading at its end, in (-pi, pi].
        heading: f64,
        /// Signed angle turned on the way, evenly over the length; 0 except on the
        /// paper's turn while moving to the first arriving point.
        turned: f64,
    },
    /// A part of a guiding circle (equation 5.1), in the first two coordinates, the heading
    /// tangent to it.
    Arc {
        /// Centre of the circle.
        center: Vector<D>,
        /// Its radius rho.
        radius: f64,
        /// Angle from the centre to the arriving point, in (-pi, pi].
        start_angle: f64,
        /// Signed angle run through; positive runs counter-clockwise, and the body turns left.
        sweep: f64,
        /// Whether it is driven backwards: the heading is then opposite to the direction of
        /// travel.
        reverse: bool,
    },
    /// A piece of a clothoid, in the first two coordinates, the heading tangent to it. Its ends are
    /// stated: they are those of neighbours, to rounding where the clothoid leads.
    Clothoid {
        /// Where it begins.
        from: Vector<D>,
        /// Where it ends.
        to: Vector<D>,
        /// Heading where it begins, in (-pi, pi].
        from_heading: f64,
        /// Radians turned per metre travelled, where it begins and where it ends; positive turns
        /// left. Between them the curvature changes evenly with the arc length.
        curvatures: [f64; 2],
        /// Its arc length.
        length: f64,
        /// Whether it is driven backwards: the heading is then opposite to the direction of
        /// travel.
        reverse: bool,
    },
    /// A turn in place.
    Turn {
        /// Where.
        position: Vector<D>,
        /// Heading before, in (-pi, pi].
        from_heading: f64,
        /// Signed angle turned; positive turns left.
        sweep: f64,
    },
}

impl<const D: usize> Curve<D> {
    /// A line without turning; the heading is 0, as in assembly tasks.
    pub fn translation(from: Vector<D>, to: Vector<D>) -> Self {
        Self::Line { from, to, heading: 0.0, turned: 0.0 }
    }

    /// Arc length of the reference point's path, metres; 0 for a turn in place.
    pub fn length(&self) -> f64 {
        match self {
            Self::Line { from, to, .. } => (to - from).norm(),
            Self::Arc { radius, sweep, .. } => radius * sweep.abs(),
            Self::Clothoid { length, .. } => *length,
            Self::Turn { .. } => 0.0,
        }
    }

    /// Signed angle by which the body turns, radians; positive turns left.
    pub fn turned(&self) -> f64 {
        match *self {
            Self::Line { turned, .. } => turned,
            Self::Arc { sweep, .. } | Self::Turn { sweep, .. } => sweep,
            Self::Clothoid { curvatures: [first, last], length, .. } => {
                0.5 * (first + last) * length
            }
        }
    }

    /// Radians turned per metre travelled at its start and at its end; positive turns left. Those
    /// of a turn in place are infinite.
    pub fn curvatures(&self) -> [f64; 2] {
        match *self {
            Self::Clothoid { curvatures, .. } => curvatures,
            _ => [self.turned() / self.length(); 2],
        }
    }

    /// Where it begins, metres: as given, but for arcs, where it is computed.
    pub fn start(&self) -> Vector<D> {
        match *self {
            Self::Line { from, .. } => from,
            Self::Arc { center, radius, start_angle, .. } => on_circle(center, radius, start_angle),
            Self::Clothoid { from, .. } => from,
            Self::Turn { position, .. } => position,
        }
    }

    /// Where it ends, metres: as given, but for arcs, where it is computed.
    pub fn end(&self) -> Vector<D> {
        match *self {
            Self::Line { to, .. } => to,
            Self::Arc { center, radius, start_angle, sweep, .. } => {
                on_circle(center, radius, start_angle + sweep)
            }
            Self::Clothoid { to, .. } => to,
            Self::Turn { position, .. } => position,
        }
    }

    /// Heading where it begins, radians in (-pi, pi].
    pub fn start_heading(&self) -> f64 {
        match *self {
            Self::Line { heading, turned, .. } => wrapped(heading - turned),
            Self::Arc { start_angle, sweep, reverse, .. } => {
                wrapped(heading_on_arc(start_angle, sweep, reverse))
            }
            Self::Turn { from_heading, .. } | Self::Clothoid { from_heading, .. } => {
                wrapped(from_heading)
            }
        }
    }

    /// Heading where it ends, radians in (-pi, pi].
    pub fn end_heading(&self) -> f64 {
        match *self {
            Self::Line { heading, .. } => wrapped(heading),
            Self::Arc { start_angle, sweep, reverse, .. } => {
                wrapped(heading_on_arc(start_angle, sweep, reverse) + sweep)
            }
            Self::Clothoid { from_heading, .. } => wrapped(from_heading + self.turned()),
            Self::Turn { from_heading, sweep, .. } => wrapped(from_heading + sweep),
        }
    }

    /// Whether a robot drives it backwards: on a line, whether the direction of travel is
    /// more than a quarter turn from the heading (at its start, if it turns on the way).
    /// A turn in place, and a line too short to have a direction, are not driven backwards.
    ///
    /// In assembly tasks, where the heading is not that of travel, this means nothing.
    ///
    /// ```
    /// use planning::geometry::Vector;
    /// use planning::motion::Curve;
    ///
    /// let (from, to) = (Vector::from([0.0, 0.0]), Vector::from([3.0, 0.0]));
    /// let line = Curve::Line { from, to, heading: 0.0, turned: 0.0 };
    /// assert!(!line.is_reverse());
    /// assert!(line.reversed().is_reverse());
    /// ```
    #[inline]
    pub fn is_reverse(&self) -> bool {
        match self {
            Self::Line { from, to, heading, turned } => {
                let heading = wrapped(heading - turned);
                // By quadrants first: most lines need no sine.
                let (ahead, left) = (heading.abs() <= FRAC_PI_2, heading >= 0.0);
                let in_quadrant = (to[0] >= from[0]) == ahead && (to[1] >= from[1]) == left;
                !in_quadrant && goes_back(from, to, heading)
            }
            Self::Arc { reverse, .. } | Self::Clothoid { reverse, .. } => *reverse,
            Self::Turn { .. } => false,
        }
    }

    /// Whether a robot drives it backwards at its end: on a line on which it turns, it may set out
    /// otherwise.
    #[inline]
    pub fn ends_in_reverse(&self) -> bool {
        match *self {
            Self::Line { from, to, heading, .. } => {
                Self::Line { from, to, heading, turned: 0.0 }.is_reverse()
            }
            _ => self.is_reverse(),
        }
    }

    /// The same poses in reverse order: a line, an arc or a clothoid driven forwards becomes one driven
    /// backwards.
    ///
    /// ```
    /// use planning::geometry::Vector;
    /// use planning::motion::Curve;
    ///
    /// let (from, to) = (Vector::from([0.0, 0.0]), Vector::from([3.0, 4.0]));
    /// let line = Curve::Line { from, to, heading: 1.0, turned: 0.5 };
    /// let back = Curve::Line { from: to, to: from, heading: 0.5, turned: -0.5 };
    /// assert_eq!(line.reversed(), back);
    /// assert_eq!(back.reversed(), line);
    /// ```
    pub fn reversed(&self) -> Self {
        match *self {
            // Differences, since a sign change would make a negative zero.
            Self::Line { from, to, turned, .. } => Self::Line {
                from: to,
                to: from,
                heading: self.start_heading(),
                turned: 0.0 - turned,
            },
            Self::Arc { center, radius, start_angle, sweep, reverse } => Self::Arc {
                center,
                radius,
                start_angle: wrapped(start_angle + sweep),
                sweep: 0.0 - sweep,
                // Without a sweep it is one pose, whose heading the flag decides.
                reverse: reverse != (sweep != 0.0),
            },
            Self::Clothoid { from, to, curvatures: [first, last], length, reverse, .. } => {
                Self::Clothoid {
                    from: to,
                    to: from,
                    from_heading: self.end_heading(),
                    curvatures: [0.0 - last, 0.0 - first],
                    length,
                    reverse: !reverse,
                }
            }
            Self::Turn { position, sweep, .. } => {
                Self::Turn { position, from_heading: self.end_heading(), sweep: 0.0 - sweep }
            }
        }
    }
}

/// How a piece of a clothoid bends, from its curvatures at both ends and its length.
pub(crate) fn bend_of([first, last]: [f64; 2], length: f64) -> Clothoid {
    Clothoid { curvature: first, sharpness: (last - first) / length + 0.0 }
}

/// A line shorter than this part of its coordinates has no direction.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Whether the way from one point to the other is more than a quarter turn from a heading.
fn goes_back<const D: usize>(from: &Vector<D>, to: &Vector<D>, heading: f64) -> bool {
    let (sin, cos) = libm::sincos(heading);
    let (x, y) = (to[0] - from[0], to[1] - from[1]);
    x * cos + y * sin < -ROUNDING * from.amax().max(to.amax())
}

/// The point of a circle in the first two coordinates at `angle` from its centre.
fn on_circle<const D: usize>(center: Vector<D>, radius: f64, angle: f64) -> Vector<D> {
    let (sin, cos) = libm::sincos(angle);
    let mut point = center;
    point[0] += radius * cos;
    point[1] += radius * sin;
    point
}

/// The heading at `angle` on a circle that is run around in the sense of `sweep`.
fn heading_on_arc(angle: f64, sweep: f64, reverse: bool) -> f64 {
    let sense = Sign::of(sweep);
    let side = if reverse { sense.opposite() } else { sense };
    angle + side.factor() * FRAC_PI_2
}

/// Where the robot is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Of the reference point, metres.
    pub position: Vector<2>,
    /// Radians counter-clockwise from +x.
    pub heading: f64,
}

/// One piece of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leg<const D: usize> {
    /// The curve followed.
    pub curve: Curve<D>,
    /// Junction (counted from 0 in travel order) that the leg leads to or turns
    /// in; `None` after the last one.
    pub junction: Option<usize>,
    /// The rule that chose where the leg ends; `None` where no rule did.
    pub rule: Option<Rule>,
    /// How it was found; `None` for channels in travel order and in assembly tasks.
    pub rung: Option<Rung>,
}

/// `angle`, radians, reduced to (-pi, pi] and without a negative zero.
#[inline]
pub fn wrapped(angle: f64) -> f64 {
    let mut angle = angle + 0.0;
    if angle > PI {
        angle -= TAU;
    } else if angle <= -PI {
        angle += TAU;
    }
    if angle.abs() > PI { reduced(angle) } else { angle }
}

/// The reduction of an angle more than one turn away.
#[cold]
fn reduced(angle: f64) -> f64 {
    let angle = angle - TAU * libm::round(angle / TAU);
    if angle <= -PI { PI } else { angle.min(PI) }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::geometry::{rotated, unit};
    use proptest::prelude::*;

    /// Up to `most` curves that follow each other: lines and arcs, forwards or backwards, and
    /// turns in place.
    pub(crate) fn motions(most: usize) -> impl Strategy<Value = Vec<Curve<2>>> {
        let step = (0..4_u8, 0.05..2.5_f64, -PI..PI, any::<bool>());
        let start = (-1.5..1.5_f64, -1.5..1.5_f64, -PI..PI);
        (prop::collection::vec(step, 1..=most), start).prop_map(|(steps, (x, y, heading))| {
            let (mut at, mut heading) = (Vector::from([x, y]), heading);
            let mut curves = Vec::new();
            for (kind, size, angle, reverse) in steps {
                let curve = match kind {
                    0 => {
                        let to = at + unit(heading) * if reverse { -size } else { size };
                        Curve::Line { from: at, to, heading, turned: 0.0 }
                    }
                    1 => Curve::Turn { position: at, from_heading: heading, sweep: angle },
                    _ => {
                        // Backwards, a left turn has its centre on the right.
                        let left = (angle > 0.0) != reverse;
                        let out = heading - if left { FRAC_PI_2 } else { -FRAC_PI_2 };
                        Curve::Arc {
                            center: at - unit(out) * size,
                            radius: size,
                            start_angle: wrapped(out),
                            sweep: angle,
                            reverse,
                        }
                    }
                };
                (at, heading) = (curve.end(), curve.end_heading());
                curves.push(curve);
            }
            curves
        })
    }

    /// The clothoid from a pose on, with its end where it leads.
    pub(crate) fn clothoid(
        from: Vector<2>,
        from_heading: f64,
        (curvatures, length): ([f64; 2], f64),
        reverse: bool,
    ) -> Curve<2> {
        let way = unit(from_heading + if reverse { PI } else { 0.0 });
        let to = from + rotated(&bend_of(curvatures, length).place(length), &way);
        Curve::Clothoid { from, to, from_heading, curvatures, length, reverse }
    }

    proptest! {
        #[test]
        fn curves_follow_each_other(curves in motions(6)) {
            for pair in curves.windows(2) {
                prop_assert!((pair[0].end() - pair[1].start()).norm() < 1e-14);
                let turn = wrapped(pair[0].end_heading() - pair[1].start_heading());
                prop_assert!(turn.abs() < 1e-14);
            }
        }
    }

    #[test]
    fn headings_are_in_the_half_open_turn() {
        let check = |angle: f64, expected: f64| {
            assert_eq!(wrapped(angle).to_bits(), expected.to_bits(), "{angle}");
        };
        check(0.0, 0.0);
        check(-0.0, 0.0);
        check(PI, PI);
        check(-PI, PI);
        check(1.5 * PI, -0.5 * PI);
        check(-1.5 * PI, 0.5 * PI);
        check(TAU, 0.0);
        check(-TAU, 0.0);
    }

    #[test]
    fn line_lost_in_rounding_is_not_driven_backwards() {
        let from = Vector::from([1000.0, 1000.0]);
        let line = |back: f64| Curve::Line {
            from,
            to: from - Vector::from([back, 0.0]),
            heading: 0.0,
            turned: 0.0,
        };
        assert!(!line(5e-13).is_reverse());
        assert!(line(5e-12).is_reverse());
    }

    #[test]
    fn reversed_translation_has_no_negative_zero() {
        let back = Curve::translation(Vector::from([1.0]), Vector::from([2.0])).reversed();
        let Curve::Line { heading, turned, .. } = back else { panic!("{back:?}") };
        assert_eq!((heading.to_bits(), turned.to_bits()), (0, 0));
    }

    fn any_sweep() -> impl Strategy<Value = f64> {
        prop_oneof![9 => -TAU..TAU, 1 => Just(0.0)]
    }

    fn any_curve() -> impl Strategy<Value = Curve<2>> {
        let point = || (-9.0..9.0_f64, -9.0..9.0_f64).prop_map(|(x, y)| Vector::from([x, y]));
        prop_oneof![
            (point(), point(), -PI..PI, -PI..PI)
                .prop_map(|(from, to, heading, turned)| Curve::Line { from, to, heading, turned }),
            (point(), 0.1..9.0_f64, -PI..PI, any_sweep(), any::<bool>()).prop_map(
                |(center, radius, start_angle, sweep, reverse)| Curve::Arc {
                    center,
                    radius,
                    start_angle,
                    sweep,
                    reverse,
                }
            ),
            (point(), -PI..PI, -TAU..TAU).prop_map(|(position, from_heading, sweep)| Curve::Turn {
                position,
                from_heading,
                sweep
            }),
            (point(), -PI..PI, -2.0..2.0_f64, -2.0..2.0_f64, 0.1..2.0_f64, any::<bool>()).prop_map(
                |(from, heading, first, last, length, reverse)| {
                    clothoid(from, heading, ([first, last], length), reverse)
                }
            ),
        ]
    }

    proptest! {
        #[test]
        fn wrapped_is_the_same_angle(angle in -1e4..1e4_f64) {
            let wrapped = wrapped(angle);
            prop_assert!(-PI < wrapped && wrapped <= PI);
            // 1e4 rad are 1592 turns, each with TAU's rounding, 2.5e-16.
            prop_assert!((libm::sin(wrapped) - libm::sin(angle)).abs() < 2e-12);
            prop_assert!((libm::cos(wrapped) - libm::cos(angle)).abs() < 2e-12);
        }

        #[test]
        fn heading_grows_by_the_angle_turned(curve in any_curve()) {
            let error = curve.end_heading() - curve.start_heading() - curve.turned();
            prop_assert!(wrapped(error).abs() < 1e-14);
        }

        #[test]
        fn reversal_exchanges_the_ends(curve in any_curve()) {
            let back = curve.reversed();
            for (one, other) in [(back.start(), curve.end()), (back.end(), curve.start())] {
                prop_assert!((one - other).norm() < 1e-13);
            }
            for (one, other) in [
                (back.start_heading(), curve.end_heading()),
                (back.end_heading(), curve.start_heading()),
            ] {
                prop_assert!(wrapped(one - other).abs() < 1e-14);
            }
            prop_assert_eq!(back.length(), curve.length());
            prop_assert_eq!(back.turned(), -curve.turned());
            let again = back.reversed();
            prop_assert!((again.start() - curve.start()).norm() < 1e-13);
            prop_assert!(wrapped(again.start_heading() - curve.start_heading()).abs() < 2e-14);
            if matches!(curve, Curve::Arc { sweep, .. } if sweep != 0.0) {
                prop_assert_ne!(back.is_reverse(), curve.is_reverse());
            }
        }

        /// By the dot product of heading and direction, from a step at the start.
        #[test]
        fn reverse_is_driven_against_the_heading(curve in any_curve()) {
            let way = match curve {
                Curve::Line { from, to, .. } => to - from,
                Curve::Arc { center, sweep, .. } => {
                    let out = curve.start() - center;
                    Vector::from([-out.y, out.x]) * sweep.signum()
                }
                Curve::Clothoid { from_heading, reverse, .. } => {
                    unit(from_heading + if reverse { PI } else { 0.0 })
                }
                Curve::Turn { .. } => Vector::zeros(),
            };
            let (sin, cos) = libm::sincos(curve.start_heading());
            let along = way.x * cos + way.y * sin;
            prop_assume!(along.abs() > 1e-12 || matches!(curve, Curve::Turn { .. }));
            prop_assert_eq!(curve.is_reverse(), along < 0.0);
        }

        /// On an arc driven forwards the heading is the direction of travel, and the ends are on the circle.
        #[test]
        fn arc_sets_out_along_its_heading(
            radius in 0.1..9.0_f64, start_angle in -PI..PI, sweep in 0.1..6.0_f64, left: bool,
        ) {
            let sweep = if left { sweep } else { -sweep };
            let center = Vector::from([3.0, -2.0]);
            let arc = Curve::Arc { center, radius, start_angle, sweep, reverse: false };
            for (point, heading) in
                [(arc.start(), arc.start_heading()), (arc.end(), arc.end_heading())]
            {
                let outwards = point - center;
                prop_assert!((outwards.norm() - radius).abs() < 1e-14);
                let (sin, cos) = libm::sincos(heading);
                let across = outwards.x * sin - outwards.y * cos;
                prop_assert!((across - sweep.signum() * radius).abs() < 1e-13);
            }
        }
    }
}
