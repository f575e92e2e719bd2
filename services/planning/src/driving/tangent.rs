//! Common tangents of oriented circles: one formula for every straight leg.

use crate::geometry::Vector;

/// A circle that the path runs around; a point has radius 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// The centre, metres.
    pub center: Vector<2>,
    /// The radius, metres; positive if the centre lies to the left of the path.
    pub signed_radius: f64,
}

/// A straight leg between two circles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tangent {
    /// Where it leaves the first circle.
    pub(crate) from: Vector<2>,
    /// Where it arrives at the second.
    pub(crate) to: Vector<2>,
    /// Unit vector along it.
    pub(crate) direction: Vector<2>,
    /// Metres.
    pub(crate) length: f64,
}

/// Circles that miss each other by less than this part of their distance count as touching.
const TOUCHING: f64 = 1e-12;

/// Those that do so by less than this have no leg between them: rounding would be its length.
const NO_LEG: f64 = 1e-14;

/// The tangent from `first` to `second` that passes each on its side; `None` if the circles
/// are too close for one.
///
/// A line with unit direction u and left normal n = iu touches circle j, of centre c_j and
/// signed radius q_j, if n.c_j = d + q_j. Subtracting, n.D = k with D = c2 - c1 and
/// k = q2 - q1, so D = (T + ik) u with the length T = sqrt(|D|^2 - k^2).
pub(crate) fn tangent(first: &Circle, second: &Circle) -> Option<Tangent> {
    let apart = second.center - first.center;
    let k = second.signed_radius - first.signed_radius;
    let square = apart.dot(&apart);
    let rest = square - k * k;
    // Also refuses NaN.
    if !(square > 0.0 && rest >= -TOUCHING * square) {
        return None;
    }
    let length = if rest <= NO_LEG * square { 0.0 } else { rest.sqrt() };
    let direction = Vector::<2>::new(
        (apart.x * length + apart.y * k) / square,
        (apart.y * length - apart.x * k) / square,
    );
    let normal = Vector::<2>::new(-direction.y, direction.x);
    Some(Tangent {
        from: first.center - normal * first.signed_radius,
        to: second.center - normal * second.signed_radius,
        direction,
        length,
    })
}
