//! The state of the body at one time.

use crate::geometry::Vector;

/// Where the body is at one time, and how it moves. No number is a negative zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<const D: usize> {
    /// Seconds since the motion began.
    pub time: f64,
    /// Position of the reference point, metres.
    pub position: Vector<D>,
    /// Heading, radians counter-clockwise from +x, in (-pi, pi].
    pub heading: f64,
    /// Velocity of the reference point, m/s.
    pub velocity: Vector<D>,
    /// Yaw rate, rad/s; positive turns left. It jumps where a line meets an arc: there
    /// it is that of the leg that begins.
    pub yaw_rate: f64,
}
