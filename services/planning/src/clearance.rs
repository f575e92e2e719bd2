//! The exact least distance between a moving body and the walls.
//!
//! [`translating`]: a box or a polygon along lines, in two and three dimensions.
//! [`rectangle`]: the robot's rectangle along lines, arcs and turns. [`clothoid`]: both along
//! clothoids, from below. Nothing is sampled.

use crate::geometry::Vector;

pub mod clothoid;
pub mod rectangle;
pub mod translating;

/// How close the body comes to the walls over a motion, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance<const D: usize> {
    /// The least distance, metres.
    pub value: f64,
    /// Arc length from the start of the motion to the first place at that distance, metres.
    pub at: f64,
    /// The wall point at that distance, metres.
    pub wall: Vector<D>,
}
