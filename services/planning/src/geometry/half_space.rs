//! Half-spaces (paper, section 2).

use super::{Direction, Sign, Vector};

/// A closed half-space bounded by a plane across an axis (equation 2.1):
/// `H_s(c)+ = {P: P_s >= c}` or `H_s(c)- = {P: P_s <= c}`.
///
/// ```
/// use planning::geometry::{Direction, HalfSpace, Sign, Vector};
///
/// // Below the mouth of section 4's female part: z <= 7.
/// let side = Direction { axis: 1, sign: Sign::Negative };
/// let below = HalfSpace { side, bound: 7.0 };
/// assert!(below.contains(&Vector::from([3.0, 7.0])));
/// assert!(!below.contains(&Vector::from([3.0, 7.1])));
/// assert_eq!(below.nearest(Vector::from([3.0, 7.1])), Vector::from([3.0, 7.0]));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    /// The coordinate `s`, and the side of the plane on which the half-space lies.
    pub side: Direction,
    /// The constant `c`, metres.
    pub bound: f64,
}

impl HalfSpace {
    /// Whether `point` lies in the half-space or on its plane.
    pub fn contains<const D: usize>(&self, point: &Vector<D>) -> bool {
        match self.side.sign {
            Sign::Positive => point[self.side.axis] >= self.bound,
            Sign::Negative => point[self.side.axis] <= self.bound,
        }
    }

    /// The point of the half-space that is nearest to `point`.
    pub fn nearest<const D: usize>(&self, mut point: Vector<D>) -> Vector<D> {
        let value = &mut point[self.side.axis];
        *value = match self.side.sign {
            Sign::Positive => value.max(self.bound),
            Sign::Negative => value.min(self.bound),
        };
        point
    }
}
