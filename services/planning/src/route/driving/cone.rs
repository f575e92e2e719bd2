//! Cones of directions.

use crate::geometry::orientation::{Side, side_of_direction};
use crate::geometry::{Sign, Vector, unrotated};

/// Directions outside by no more than this, the sine of the angle, count as inside.
const ROUNDING: f64 = 1e-12;

/// The directions counter-clockwise from one to another, at most half a turn; or all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Unit vectors; zero stands for all directions.
    low: Vector<2>,
    high: Vector<2>,
}

/// The sine of the angle from `a` to `b`.
fn cross(a: &Vector<2>, b: &Vector<2>) -> f64 {
    unrotated(b, a).y
}

impl Cone {
    /// All directions.
    pub(super) const ALL: Self =
        Self { low: Vector::<2>::new(0.0, 0.0), high: Vector::<2>::new(0.0, 0.0) };

    /// The half turn from a direction in this sense.
    pub(super) fn half(from: &Vector<2>, turn: Sign) -> Self {
        match turn {
            Sign::Positive => Self { low: *from, high: -from },
            Sign::Negative => Self { low: -from, high: *from },
        }
    }

    /// The narrowest cone around directions that are pairwise less than half a turn apart.
    pub(super) fn around<'a>(directions: impl Iterator<Item = &'a Vector<2>>) -> Self {
        let cones = directions.map(|direction| Self { low: *direction, high: *direction });
        let wider = |a: Self, b: Self| Self {
            low: if side_of_direction(&a.low, &b.low) == Side::Right { b.low } else { a.low },
            high: if side_of_direction(&a.high, &b.high) == Side::Left { b.high } else { a.high },
        };
        cones.reduce(wider).unwrap_or(Self::ALL)
    }

    pub(super) fn holds(&self, direction: &Vector<2>) -> bool {
        cross(&self.low, direction) >= -ROUNDING && cross(direction, &self.high) >= -ROUNDING
            // Not opposite, at the edge of half a turn or of a narrow cone.
            && (self.low + self.high).dot(direction) >= -ROUNDING
    }

    pub(super) fn contains(&self, other: &Self) -> bool {
        self.holds(&other.low) && self.holds(&other.high)
    }

    /// The directions in both cones.
    pub(super) fn common(&self, other: &Self) -> Option<Self> {
        if *self == Self::ALL {
            return Some(*other);
        }
        let later = |a: &Self, b: &Self| a.holds(&b.low).then_some(b.low);
        let sooner = |a: &Self, b: &Self| a.holds(&b.high).then_some(b.high);
        let low = later(self, other).or_else(|| later(other, self))?;
        let high = sooner(self, other).or_else(|| sooner(other, self))?;
        (side_of_direction(&low, &high) != Side::Right).then_some(Self { low, high })
    }
}
