//! Clothoids: curves whose curvature changes evenly with their arc length.
//!
//! The direction of travel is a square polynomial of the arc length, so places on a clothoid are
//! Fresnel integrals. They are summed over pieces of little turn, each by its power series:
//! plain sums and products, the same on every machine.

use super::{Vector, rotated, unit};

/// The greatest sum `|a| + |b|` that [`unit_chord`] takes.
pub(crate) const MOST_PHASE: f64 = 0.25;

/// Terms of the power series. What is left out is less than 5e-18 ([`unit_chord`]).
const TERMS: usize = 25;

/// A clothoid that begins at the origin along +x.
///
/// ```
/// use planning::geometry::clothoid::Clothoid;
///
/// // The Fresnel integrals C(1) and S(1) (Abramowitz and Stegun, table 7.7).
/// let clothoid = Clothoid { curvature: 0.0, sharpness: std::f64::consts::PI };
/// let place = clothoid.place(1.0);
/// assert!((place.x - 0.779_893_400_376_822_8).abs() < 1e-15);
/// assert!((place.y - 0.438_259_147_390_354_8).abs() < 1e-15);
/// assert_eq!(clothoid.turned(1.0), std::f64::consts::FRAC_PI_2);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clothoid {
    /// Curvature where it begins, rad/m; positive to the left.
    pub curvature: f64,
    /// Change of the curvature along it, rad/m2.
    pub sharpness: f64,
}

impl Clothoid {
    /// The curvature `along` metres from its beginning, rad/m.
    pub fn curvature_at(&self, along: f64) -> f64 {
        self.curvature + self.sharpness * along
    }

    /// The signed angle turned in the first `along` metres, radians.
    pub fn turned(&self, along: f64) -> f64 {
        along * (self.curvature + 0.5 * self.sharpness * along)
    }

    /// The place `along` metres from its beginning. Its error is some 1e-16 of `along` for each
    /// quarter of a radian that the clothoid turns.
    pub fn place(&self, along: f64) -> Vector<2> {
        let steepest = self.curvature.abs().max(self.curvature_at(along).abs());
        let phase = steepest * along.abs() + 0.5 * self.sharpness.abs() * along * along;
        let pieces = (phase / MOST_PHASE).ceil().max(1.0);
        let part = along / pieces;
        let mut place = Vector::zeros();
        for piece in 0..pieces as u64 {
            let from = part * piece as f64;
            let chord = self.chord(from, part);
            place += rotated(&chord, &unit(self.turned(from)));
        }
        place
    }

    /// The displacement over the next `further` metres from a place on, along whose direction +x
    /// is; `further` must turn it so little that [`unit_chord`] takes it.
    pub(crate) fn chord(&self, from: f64, further: f64) -> Vector<2> {
        let (a, b) = self.phases(from, further);
        unit_chord(a, b) * further
    }

    /// What [`unit_chord`] takes for it.
    pub(crate) fn phases(&self, from: f64, further: f64) -> (f64, f64) {
        (self.curvature_at(from) * further, 0.5 * self.sharpness * further * further)
    }
}

/// The integral of exp(i (a u + b u^2)) over u from 0 to 1, as a vector, for `|a| + |b|` of at most
/// [`MOST_PHASE`].
///
/// The integrand f has f' = i (a + 2 b u) f, so its power series c has
/// (n + 1) c[n+1] = i (a c[n] + 2 b c[n-1]). With A = |a| + |b|, the terms of exp(i p) beyond the m-th
/// power of the phase p add up to at most 2 A^(m+1) / (m+1)!, and all others are of degree 2 m at most:
/// for m = 12 and A = 1/4 what is left out is less than 5e-18.
pub(crate) fn unit_chord(a: f64, b: f64) -> Vector<2> {
    let (mut before, mut now) = ([0.0, 0.0], [1.0, 0.0]);
    let mut terms = [[0.0; 2]; TERMS];
    for (n, term) in terms.iter_mut().enumerate() {
        let next = (n + 1) as f64;
        *term = [now[0] / next, now[1] / next];
        let sum = [0, 1].map(|part| a * now[part] + 2.0 * b * before[part]);
        (before, now) = (now, [-sum[1] / next, sum[0] / next]);
    }
    // The least first.
    let sum = terms.iter().rev().fold([0.0, 0.0], |sum, term| [sum[0] + term[0], sum[1] + term[1]]);
    Vector::from(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    /// By Boole's rule over so many panels: an error of some `h^6` times the sixth derivative.
    fn by_quadrature(clothoid: &Clothoid, along: f64, panels: u32) -> Vector<2> {
        let h = along / f64::from(panels);
        let at = |s: f64| unit(clothoid.turned(s));
        let (mut sum, mut rest) = (Vector::<2>::zeros(), Vector::<2>::zeros());
        for panel in 0..panels {
            let from = h * f64::from(panel);
            let weights = [7.0, 32.0, 12.0, 32.0, 7.0].into_iter().enumerate();
            let value: Vector<2> =
                weights.map(|(node, weight)| at(from + 0.25 * h * node as f64) * weight).sum();
            // Compensated, so that only the rule's error is left.
            let term = value * (h / 90.0) - rest;
            let next = sum + term;
            rest = (next - sum) - term;
            sum = next;
        }
        sum
    }

    /// Values to 16 digits: Abramowitz and Stegun, table 7.7, and the series of section 7.3 summed
    /// in 50 digits.
    #[test]
    fn fresnel_integrals_are_those_of_the_tables() {
        let clothoid = Clothoid { curvature: 0.0, sharpness: PI };
        let known = [
            (0.5, 0.492_344_225_871_446_4, 0.064_732_432_859_999_28),
            (1.0, 0.779_893_400_376_822_8, 0.438_259_147_390_354_8),
            (2.0, 0.488_253_406_075_340_8, 0.343_415_678_363_698_2),
            (5.0, 0.563_631_188_704_012_2, 0.499_191_381_917_116_9),
        ];
        for (along, c, s) in known {
            let place = clothoid.place(along);
            assert!((place - Vector::from([c, s])).amax() < 2e-15, "{along}: {place}");
        }
    }

    #[test]
    fn without_sharpness_it_is_a_circle() {
        for curvature in [1e-9, 0.3, -2.0] {
            let circle = Clothoid { curvature, sharpness: 0.0 };
            for along in [0.1, 1.0, 3.0] {
                let half = 0.5 * curvature * along;
                let chord = 2.0 * libm::sin(half) / curvature;
                let expected = unit(half) * chord;
                assert!((circle.place(along) - expected).amax() < 1e-15 * along);
            }
        }
        let line = Clothoid { curvature: 0.0, sharpness: 0.0 };
        assert_eq!(line.place(7.0), Vector::from([7.0, 0.0]));
    }

    proptest! {
        #[test]
        fn places_are_integrals_of_the_direction(
            curvature in -3.0..3.0_f64, sharpness in -3.0..3.0_f64, along in 0.01..2.5_f64,
        ) {
            let clothoid = Clothoid { curvature, sharpness };
            let expected = by_quadrature(&clothoid, along, 4000);
            prop_assert!((clothoid.place(along) - expected).amax() < 4e-15 * along.max(1.0));
        }

        #[test]
        fn chords_follow_each_other(
            a in -0.12..0.12_f64, b in -0.12..0.12_f64, part in 0.0..1.0_f64,
        ) {
            let clothoid = Clothoid { curvature: a, sharpness: 2.0 * b };
            let whole = unit_chord(a, b);
            let rest = rotated(&clothoid.chord(part, 1.0 - part), &unit(clothoid.turned(part)));
            prop_assert!((clothoid.chord(0.0, part) + rest - whole).amax() < 4e-16);
        }
    }
}
