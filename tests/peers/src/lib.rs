//! Slow, obviously right planners to compare the planner with, and random scenes of the kinds that
//! people have.
//!
//! Nothing here uses the planner's own geometry: a rectangle meets a wall if the separating axis
//! test says so, a motion is free if the rectangle is at many poses along it, and a way is found by
//! a search over a grid of poses.

pub mod floor_plans;
pub mod judge;
pub mod kinds;
pub mod lattice;
pub mod rectangle;
pub mod safest;
pub mod scene;

/// A point or a direction in the plane, metres.
pub type Point = [f64; 2];

/// `a + b * factor`.
#[must_use]
pub fn along(a: Point, b: Point, factor: f64) -> Point {
    [a[0] + b[0] * factor, a[1] + b[1] * factor]
}

/// From `a` to `b`.
#[must_use]
pub fn between(a: Point, b: Point) -> Point {
    [b[0] - a[0], b[1] - a[1]]
}

/// Length of a vector.
#[must_use]
pub fn norm(a: Point) -> f64 {
    a[0].hypot(a[1])
}

/// The direction with this heading.
#[must_use]
pub fn direction(heading: f64) -> Point {
    [heading.cos(), heading.sin()]
}

/// A point turned about the origin.
#[must_use]
pub fn turned(a: Point, angle: f64) -> Point {
    let [cos, sin] = direction(angle);
    [cos * a[0] - sin * a[1], sin * a[0] + cos * a[1]]
}

/// The angle within half a turn of 0.
#[must_use]
pub fn wrapped(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - turn * (angle / turn).round()
}
