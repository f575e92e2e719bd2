//! What a body does: legs in travel order, each a line, an arc or a turn in place.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::geometry::{Sign, Vector};

/// A rule of the paper, by table and number (numbering: `docs/errata.md`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Rule {
    /// 1: part assembly (section 3); 2: mobile robot (section 5).
    pub table: u8,
    /// Number of the rule in its table, from 1.
    pub number: u8,
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
/// let arc = Curve::Arc { center, radius: 2.0, start_angle: -FRAC_PI_2, sweep: FRAC_PI_2 };
/// assert_eq!(arc.length(), 2.0 * FRAC_PI_2);
/// assert!((arc.start() - Vector::from([0.0, 0.0])).norm() < 1e-15);
/// assert!((arc.end() - Vector::from([2.0, 2.0])).norm() < 1e-15);
/// assert_eq!((arc.start_heading(), arc.end_heading()), (0.0, FRAC_PI_2));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Curve<const D: usize> {
    /// A straight segment.
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
    /// A part of a guiding circle (equation 5.1), in the first two coordinates,
    /// the heading tangent to it.
    Arc {
        /// Centre of the circle.
        center: Vector<D>,
        /// Its radius rho.
        radius: f64,
        /// Angle from the centre to the arriving point, in (-pi, pi].
        start_angle: f64,
        /// Signed angle run through; positive turns left.
        sweep: f64,
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
            Self::Turn { .. } => 0.0,
        }
    }

    /// Signed angle by which the body turns, radians; positive turns left.
    pub fn turned(&self) -> f64 {
        match *self {
            Self::Line { turned, .. } => turned,
            Self::Arc { sweep, .. } | Self::Turn { sweep, .. } => sweep,
        }
    }

    /// Where it begins, metres: as given, but for arcs, where it is computed.
    pub fn start(&self) -> Vector<D> {
        match *self {
            Self::Line { from, .. } => from,
            Self::Arc { center, radius, start_angle, .. } => on_circle(center, radius, start_angle),
            Self::Turn { position, .. } => position,
        }
    }

    /// Where it ends, metres: as given, but for arcs, where it is computed.
    pub fn end(&self) -> Vector<D> {
        match *self {
            Self::Line { to, .. } => to,
            Self::Arc { center, radius, start_angle, sweep } => {
                on_circle(center, radius, start_angle + sweep)
            }
            Self::Turn { position, .. } => position,
        }
    }

    /// Heading where it begins, radians in (-pi, pi].
    pub fn start_heading(&self) -> f64 {
        match *self {
            Self::Line { heading, turned, .. } => wrapped(heading - turned),
            Self::Arc { start_angle, sweep, .. } => wrapped(tangent_heading(start_angle, sweep)),
            Self::Turn { from_heading, .. } => wrapped(from_heading),
        }
    }

    /// Heading where it ends, radians in (-pi, pi].
    pub fn end_heading(&self) -> f64 {
        match *self {
            Self::Line { heading, .. } => wrapped(heading),
            Self::Arc { start_angle, sweep, .. } => {
                wrapped(tangent_heading(start_angle, sweep) + sweep)
            }
            Self::Turn { from_heading, sweep, .. } => wrapped(from_heading + sweep),
        }
    }

    /// The same poses in reverse order; `None` for an arc, which a robot only
    /// follows forwards.
    ///
    /// ```
    /// use planning::geometry::Vector;
    /// use planning::motion::Curve;
    ///
    /// let (from, to) = (Vector::from([0.0, 0.0]), Vector::from([3.0, 4.0]));
    /// let line = Curve::Line { from, to, heading: 1.0, turned: 0.5 };
    /// let back = Curve::Line { from: to, to: from, heading: 0.5, turned: -0.5 };
    /// assert_eq!(line.reversed(), Some(back));
    /// assert_eq!(back.reversed(), Some(line));
    /// ```
    pub fn reversed(&self) -> Option<Self> {
        match *self {
            // Differences, since a sign change would make a negative zero.
            Self::Line { from, to, turned, .. } => Some(Self::Line {
                from: to,
                to: from,
                heading: self.start_heading(),
                turned: 0.0 - turned,
            }),
            Self::Arc { .. } => None,
            Self::Turn { position, sweep, .. } => {
                Some(Self::Turn { position, from_heading: self.end_heading(), sweep: 0.0 - sweep })
            }
        }
    }
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
fn tangent_heading(angle: f64, sweep: f64) -> f64 {
    angle + Sign::of(sweep).factor() * FRAC_PI_2
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
mod tests {
    use super::*;
    use proptest::prelude::*;

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
    fn reversed_translation_has_no_negative_zero() {
        let back = Curve::translation(Vector::from([1.0]), Vector::from([2.0])).reversed();
        let Some(Curve::Line { heading, turned, .. }) = back else { panic!("{back:?}") };
        assert_eq!((heading.to_bits(), turned.to_bits()), (0, 0));
    }

    fn any_curve() -> impl Strategy<Value = Curve<2>> {
        let point = || (-9.0..9.0_f64, -9.0..9.0_f64).prop_map(|(x, y)| Vector::from([x, y]));
        prop_oneof![
            (point(), point(), -PI..PI, -PI..PI)
                .prop_map(|(from, to, heading, turned)| Curve::Line { from, to, heading, turned }),
            (point(), 0.1..9.0_f64, -PI..PI, -TAU..TAU).prop_map(
                |(center, radius, start_angle, sweep)| Curve::Arc {
                    center,
                    radius,
                    start_angle,
                    sweep
                }
            ),
            (point(), -PI..PI, -TAU..TAU).prop_map(|(position, from_heading, sweep)| Curve::Turn {
                position,
                from_heading,
                sweep
            }),
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
            let Some(back) = curve.reversed() else { return Ok(()) };
            prop_assert_eq!((back.start(), back.end()), (curve.end(), curve.start()));
            for (one, other) in [
                (back.start_heading(), curve.end_heading()),
                (back.end_heading(), curve.start_heading()),
            ] {
                prop_assert!(wrapped(one - other).abs() < 1e-14);
            }
            prop_assert_eq!(back.length(), curve.length());
        }

        /// On an arc the heading is the direction of travel, and the ends are on the circle.
        #[test]
        fn arc_sets_out_along_its_heading(
            radius in 0.1..9.0_f64, start_angle in -PI..PI, sweep in 0.1..6.0_f64, left: bool,
        ) {
            let sweep = if left { sweep } else { -sweep };
            let center = Vector::from([3.0, -2.0]);
            let arc = Curve::Arc { center, radius, start_angle, sweep };
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
