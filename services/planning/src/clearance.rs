//! The exact least distance between the moving body and the walls.

use crate::geometry::Vector;

pub mod rectangle;
pub mod translating;

/// How close the body comes to the walls over a motion, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance<const D: usize> {
    /// The least distance, metres.
    pub value: f64,
    /// Arc length from the beginning of the motion to where it is met first, metres.
    pub at: f64,
    /// The wall point that is that close.
    pub wall: Vector<D>,
}
