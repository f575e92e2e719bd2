//! The state of the body at one time.

use crate::geometry::Vector;

/// Where the body is at a time, and how it moves. No number is a negative zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<const D: usize> {
    /// Since the motion began, seconds.
    pub time: f64,
    /// Of the body's reference point, metres.
    pub position: Vector<D>,
    /// Counter-clockwise from +x, in (-pi, pi].
    pub heading: f64,
    /// Of the reference point, m/s.
    pub velocity: Vector<D>,
    /// Rate of turning, rad/s; positive turns left. It steps where a line meets
    /// an arc: at such an end of a leg it is the following leg's.
    pub yaw_rate: f64,
}
