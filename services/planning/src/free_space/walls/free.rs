//! Whether a wall passes through a box.

use super::{Wall, planar};
use crate::geometry::orientation::{Side, side_of_line};
use crate::geometry::{AxisBox, Vector};

/// Whether the wall has a point inside `space` by more than rounding.
///
/// Both are convex, so they are apart if and only if a line (a plane) separates them: one
/// perpendicular to an axis or, for a segment, the line that it lies on.
pub(super) fn passes_through<const D: usize>(wall: &Wall<D>, space: &AxisBox<D>) -> bool {
    let size = [wall.from, wall.to, space.min(), space.max()].map(|corner| corner.amax());
    let rounding = 16.0 * f64::EPSILON * size.into_iter().fold(0.0, f64::max);
    let (min, max) = (space.min().add_scalar(rounding), space.max().add_scalar(-rounding));
    let (low, high) = wall.bounds();
    if !(0..D).all(|axis| low[axis] < max[axis] && min[axis] < high[axis]) {
        return false;
    }
    // In three dimensions walls are parallel to the axes.
    D != 2 || is_cut((&planar(&wall.from), &planar(&wall.to)), (&planar(&min), &planar(&max)))
}

/// Whether corners of the box lie on both sides of the line through `from` and `to`.
fn is_cut((from, to): (&Vector<2>, &Vector<2>), (min, max): (&Vector<2>, &Vector<2>)) -> bool {
    let corners = [*min, Vector::from([max[0], min[1]]), *max, Vector::from([min[0], max[1]])];
    let sides = corners.map(|corner| side_of_line(from, to, &corner));
    sides.contains(&Side::Left) && sides.contains(&Side::Right)
}

#[cfg(test)]
mod tests;
