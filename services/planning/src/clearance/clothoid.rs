//! Clearance over clothoids, certified from below.
//!
//! A piece of a clothoid is compared to the arc that has its place, direction and curvature half-way
//! (it *osculates* there). With the sharpness c and the length h of the piece, the direction differs
//! from the arc's by `c u^2 / 2` at a distance u from the middle, by at most `c h^2 / 8`; the place, by
//! integration, by at most `c h^3 / 48`. No point of a body that reaches out by r is farther from where
//! the arc would bring it than `c h^3 / 48 + r c h^2 / 8`, and the clearance over an arc is exact.
//! The piece that may be nearest is halved until that is less than [`PRECISION`] says; all others are
//! then farther from the walls.

use super::Clearance;
use crate::budget::Spent;
use crate::free_space::walls::planar;
use crate::geometry::clothoid::Clothoid;
use crate::geometry::{Sign, Vector, rotated, unit};
use crate::motion::{Curve, bend_of, wrapped};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::{FRAC_PI_2, PI};

/// By how much the clearance over a clothoid may be too small, as a part of its length and the reach of
/// the body together. It is never too great.
pub const PRECISION: f64 = 2e-10;

/// A piece that turns less than this, radians, is compared to a line.
const STRAIGHT: f64 = 1e-10;

/// How often a clothoid is halved at most; then a piece is a millionth of it.
const MOST_HALVINGS: u32 = 20;

/// Halvings after which an arc length is known to rounding.
const HALVINGS_ALONG: u32 = 52;

/// What rounding may add to a place, as a part of the coordinates and radii that it is computed from.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// A clothoid in the plane.
#[derive(Debug, Clone, Copy)]
pub struct PlacedClothoid {
    from: Vector<2>,
    from_heading: f64,
    bend: Clothoid,
    length: f64,
    reverse: bool,
}

/// An arc or a line in place of a piece of a clothoid.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Osculating {
    pub(crate) curve: Curve<2>,
    /// How far the reference point may be from it, metres.
    pub(crate) apart: f64,
    /// By what angle the heading may differ, radians.
    askew: f64,
}

/// A piece of a clothoid, and how near it comes at least.
#[derive(Debug, Clone, Copy)]
struct ClothoidPiece {
    /// As parts of the clothoid.
    ends: [f64; 2],
    /// How often the clothoid has been halved.
    depth: u32,
    near: Clearance<2>,
    /// Whether it is known so well that it need not be halved.
    is_final: bool,
}

/// The nearest is greatest; of those as near, the first.
impl Ord for ClothoidPiece {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_value = other.near.value.total_cmp(&self.near.value);
        by_value.then(other.ends[0].total_cmp(&self.ends[0]))
    }
}

impl PartialOrd for ClothoidPiece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for ClothoidPiece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for ClothoidPiece {}

impl PlacedClothoid {
    /// That of a curve, if it is one.
    pub fn of<const D: usize>(curve: &Curve<D>) -> Option<Self> {
        let Curve::Clothoid { from, from_heading, curvatures, length, reverse, .. } = curve else {
            return None;
        };
        let bend = bend_of(*curvatures, *length);
        let (from, from_heading) = (planar(from), *from_heading);
        Some(Self { from, from_heading, bend, length: *length, reverse: *reverse })
    }

    /// The direction of travel at its start, radians.
    fn direction(&self) -> f64 {
        self.from_heading + if self.reverse { PI } else { 0.0 }
    }

    /// Its place after a part of it.
    pub fn at(&self, part: f64) -> Vector<2> {
        self.from + rotated(&self.bend.place(part * self.length), &unit(self.direction()))
    }

    /// The arc length at which it is as far from its start as a place on it, metres; it must turn by
    /// less than half a turn.
    pub fn along(&self, place: &Vector<2>) -> f64 {
        let far = (place - self.from).norm();
        let (mut low, mut high) = (0.0, self.length);
        for _ in 0..HALVINGS_ALONG {
            let middle = 0.5 * (low + high);
            if self.bend.place(middle).norm() < far {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// What osculates in the middle between two parts of it.
    pub(crate) fn osculating(&self, [low, high]: [f64; 2]) -> Osculating {
        let h = (high - low) * self.length;
        let along = 0.5 * (low + high) * self.length;
        let middle = self.at(0.5 * (low + high));
        let direction = self.direction() + self.bend.turned(along);
        let (curvature, sharpness) = (self.bend.curvature_at(along), self.bend.sharpness.abs());
        let turn = curvature * h;
        let (apart, askew) = (sharpness * h * h * h / 48.0, sharpness * h * h / 8.0);
        let rounding = ROUNDING * (middle.amax() + self.from.amax() + self.length);
        if turn.abs() <= STRAIGHT {
            let half = unit(direction) * (0.5 * h);
            let heading = wrapped(direction + if self.reverse { PI } else { 0.0 });
            let curve =
                Curve::Line { from: middle - half, to: middle + half, heading, turned: 0.0 };
            let (bow, tilt) = (turn.abs() * h / 8.0, 0.5 * turn.abs());
            return Osculating { curve, apart: apart + bow + rounding, askew: askew + tilt };
        }
        let side = Sign::of(curvature).factor();
        let radius = 1.0 / curvature.abs();
        let out = direction - side * FRAC_PI_2;
        let curve = Curve::Arc {
            center: middle - unit(out) * radius,
            radius,
            start_angle: wrapped(out - 0.5 * turn),
            sweep: turn,
            reverse: self.reverse,
        };
        Osculating { curve, apart: apart + rounding + ROUNDING * radius, askew }
    }

    /// The least distance over it, as `look` finds it over arcs and lines up to what is told by
    /// their part; at most `most`. Of the body no point is farther than `reach` from the reference
    /// point; 0 where it does not turn. Ends where a distance of at most `enough` is sure.
    ///
    /// `look` is also told how much less its result counts.
    pub(crate) fn least(
        &self,
        (reach, most, enough): (f64, f64, f64),
        mut look: impl FnMut(&Curve<2>, f64) -> Result<Clearance<2>, Spent>,
    ) -> Result<Clearance<2>, Spent> {
        let precision = 0.5 * PRECISION * (self.length + reach);
        let mut open: BinaryHeap<ClothoidPiece> = BinaryHeap::new();
        let mut next = [Some(([0.0, 1.0], 0)), None];
        loop {
            for (ends, depth) in next.into_iter().flatten() {
                let Osculating { curve, apart, askew } = self.osculating(ends);
                let less = apart + reach * askew;
                let Clearance { value, at, wall } = look(&curve, less)?;
                let at = ends[0] + (ends[1] - ends[0]) * at;
                let near = Clearance { value: value - less, at, wall };
                if value + less <= enough {
                    return Ok(near);
                }
                if near.value < most {
                    let is_final = less <= precision || depth == MOST_HALVINGS;
                    open.push(ClothoidPiece { ends, depth, near, is_final });
                }
            }
            // The nearest decides.
            let Some(nearest) = open.pop() else {
                return Ok(Clearance { value: most, at: 0.0, wall: Vector::zeros() });
            };
            if nearest.is_final {
                return Ok(nearest.near);
            }
            let ClothoidPiece { ends: [low, high], depth, .. } = nearest;
            let middle = 0.5 * (low + high);
            next = [[low, middle], [middle, high]].map(|ends| Some((ends, depth + 1)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn clothoid(curvatures: [f64; 2], length: f64, reverse: bool) -> PlacedClothoid {
        let [from, to] = [[1.0, -2.0], [0.0, 0.0]].map(Vector::from);
        let from_heading = 0.7;
        let curve = Curve::Clothoid { from, to, from_heading, curvatures, length, reverse };
        PlacedClothoid::of(&curve).unwrap()
    }

    proptest! {
        /// Places and headings of the body on a piece, against those on what osculates.
        #[test]
        fn pieces_stay_beside_what_osculates(
            curvatures in prop::array::uniform2(-2.0..2.0_f64), length in 0.1..3.0_f64,
            low in 0.0..0.9_f64, size in 1e-5..1.0_f64, reverse in any::<bool>(),
        ) {
            let clothoid = clothoid(curvatures, length, reverse);
            let high = (low + size).min(1.0);
            let Osculating { curve, apart, askew } = clothoid.osculating([low, high]);
            let h = (high - low) * length;
            prop_assert!((curve.length() - h).abs() < 1e-9);
            for step in 0..=10 {
                let part = f64::from(step) / 10.0;
                let along = low + part * (high - low);
                let (place, heading) = match curve {
                    Curve::Line { from, to, heading, .. } => (from + (to - from) * part, heading),
                    Curve::Arc { center, radius, start_angle, sweep, .. } => {
                        let place = center + unit(start_angle + part * sweep) * radius;
                        (place, curve.start_heading() + part * sweep)
                    }
                    _ => panic!("{curve:?}"),
                };
                prop_assert!((clothoid.at(along) - place).norm() <= apart + 1e-13);
                let turned = clothoid.bend.turned(along * length);
                let off = wrapped(clothoid.from_heading + turned - heading).abs();
                prop_assert!(off <= askew + 1e-14, "{off} {askew}");
            }
        }
    }
}
