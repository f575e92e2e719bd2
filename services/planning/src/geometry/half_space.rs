//! Half-spaces (paper, section 2).

use super::{Direction, Sign, Vector};

/// A closed half-space bounded by a plane across an axis (equation 2.1):
/// `H_s(c)+ = {P: P_s >= c}` or `H_s(c)- = {P: P_s <= c}`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    /// The coordinate `s`, and on which side of the plane the half-space lies.
    pub side: Direction,
    /// The constant `c`, metres.
    pub bound: f64,
}

impl HalfSpace {
    /// Whether `point` lies in it, its plane included.
    pub fn contains<const D: usize>(&self, point: &Vector<D>) -> bool {
        match self.side.sign {
            Sign::Positive => point[self.side.axis] >= self.bound,
            Sign::Negative => point[self.side.axis] <= self.bound,
        }
    }
}
