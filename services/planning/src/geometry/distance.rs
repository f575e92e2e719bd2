//! Exact least distances between pairs of shapes.

use super::Vector;
use super::orientation::{determinant, segments_cross};

/// Where a point that travels along a segment comes closest to a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest<const D: usize> {
    /// The least distance, metres; 0 for contact and overlap.
    pub distance: f64,
    /// The first place on the segment at that distance, from 0 (its first end) to 1.
    pub at: f64,
    /// The point of the other shape at that distance, metres.
    pub point: Vector<D>,
}

/// Least distance between the segment from `from` to `to` and the box from `min`
/// to `max`, which may be flat.
///
/// The squared distance is convex and piecewise quadratic along the segment; its pieces
/// meet where the segment passes the planes of the box's sides.
///
/// ```
/// use planning::geometry::Vector;
/// use planning::geometry::distance::distance_segment_box;
///
/// let (from, to) = (Vector::from([-2.0, 5.0]), Vector::from([2.0, 5.0]));
/// let (min, max) = (Vector::from([0.0, 0.0]), Vector::from([1.0, 2.0]));
/// let closest = distance_segment_box((&from, &to), (&min, &max));
/// // First above the corner (0, 2), half-way along.
/// assert_eq!((closest.distance, closest.at), (3.0, 0.5));
/// assert_eq!(closest.point, Vector::from([0.0, 2.0]));
/// ```
pub fn distance_segment_box<const D: usize>(
    (from, to): (&Vector<D>, &Vector<D>),
    (min, max): (&Vector<D>, &Vector<D>),
) -> Closest<D> {
    let way = to - from;
    // While within the sides along every axis it moves on, it is as near as it gets.
    let (mut enter, mut exit) = (0.0_f64, 1.0_f64);
    for axis in 0..D {
        if way[axis] != 0.0 {
            let a = (min[axis] - from[axis]) / way[axis];
            let b = (max[axis] - from[axis]) / way[axis];
            enter = enter.max(a.min(b));
            exit = exit.min(a.max(b));
        }
    }
    if enter <= exit {
        let mut square = 0.0;
        for axis in 0..D {
            if way[axis] == 0.0 {
                let excess = excess(from[axis], min[axis], max[axis]);
                square += excess * excess;
            }
        }
        let point = (from + way * enter).sup(min).inf(max);
        return Closest { distance: square.sqrt(), at: enter, point };
    }
    // Otherwise the minimum is unique: where the slope changes sign.
    let slope = |at: f64, on: usize| {
        let mut slope = 0.0;
        for axis in 0..D {
            // On the plane of a side the excess is rounding only.
            if axis != on {
                slope += way[axis] * excess(from[axis] + at * way[axis], min[axis], max[axis]);
            }
        }
        slope
    };
    let (mut falling, mut rising) = ((0.0, slope(0.0, D)), (1.0, slope(1.0, D)));
    let at = if falling.1 >= 0.0 {
        0.0
    } else if rising.1 <= 0.0 {
        1.0
    } else {
        for axis in 0..D {
            if way[axis] == 0.0 {
                continue;
            }
            for side in [min[axis], max[axis]] {
                let at = (side - from[axis]) / way[axis];
                if falling.0 < at && at < rising.0 {
                    let slope = slope(at, axis);
                    if slope < 0.0 {
                        falling = (at, slope);
                    } else {
                        rising = (at, slope);
                    }
                }
            }
        }
        // Linear in between.
        falling.0 + (rising.0 - falling.0) * (falling.1 / (falling.1 - rising.1))
    };
    let here = if at == 1.0 { *to } else { from + way * at };
    let point = here.sup(min).inf(max);
    Closest { distance: (here - point).norm(), at, point }
}

/// Least distance between the segment from `from` to `to` and the one from `a` to `b`.
pub fn distance_segment_segment(
    (from, to): (&Vector<2>, &Vector<2>),
    (a, b): (&Vector<2>, &Vector<2>),
) -> Closest<2> {
    if let Some(at) = crossing((from, to), (a, b)) {
        return Closest { distance: 0.0, at, point: from + (to - from) * at };
    }
    // Otherwise the least distance is at an end of one of them.
    let ends = [
        at_end(from, 0.0, (a, b)),
        at_middle(a, (from, to)),
        at_middle(b, (from, to)),
        at_end(to, 1.0, (a, b)),
    ];
    let nearer = |x: Closest<2>, y: Closest<2>| {
        if (y.distance, y.at) < (x.distance, x.at) { y } else { x }
    };
    nearer(nearer(ends[0], ends[1]), nearer(ends[2], ends[3]))
}

/// Least distance of a point from the segment from `a` to `b`, metres.
pub(crate) fn distance_point_segment(point: &Vector<2>, (a, b): (&Vector<2>, &Vector<2>)) -> f64 {
    let place = nearest_place(point, (a, b));
    // Not by the point at `place`, whose rounding grows with the coordinates.
    if place == 1.0 { (point - b).norm() } else { ((point - a) - (b - a) * place).norm() }
}

/// The point of the segment from `a` to `b` nearest to a point.
pub(crate) fn nearest_on_segment(
    point: &Vector<2>,
    segment: (&Vector<2>, &Vector<2>),
) -> Vector<2> {
    point_at(nearest_place(point, segment), segment)
}

/// The third component of the cross product.
pub(crate) fn cross(a: &Vector<2>, b: &Vector<2>) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Signed distance of `value` from the interval; 0 inside.
fn excess(value: f64, min: f64, max: f64) -> f64 {
    value - value.max(min).min(max)
}

/// Where on the first segment the interiors of two segments cross.
fn crossing((from, to): (&Vector<2>, &Vector<2>), (a, b): (&Vector<2>, &Vector<2>)) -> Option<f64> {
    if !segments_cross((from, to), (a, b)) {
        return None;
    }
    let wall = b - a;
    let (mut before, mut after) = (cross(&wall, &(from - a)), cross(&wall, &(to - a)));
    if before * after >= 0.0 {
        // Too close to parallel for plain products.
        (before, after) = (determinant(a, b, from), determinant(a, b, to));
    }
    Some(before / (before - after))
}

/// The place on the segment from `a` to `b` nearest to `point`, from 0 to 1.
fn nearest_place(point: &Vector<2>, (a, b): (&Vector<2>, &Vector<2>)) -> f64 {
    let way = b - a;
    let square = way.norm_squared();
    if square > 0.0 { ((point - a).dot(&way) / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// The point at `place` on the segment, exact at its ends.
fn point_at(place: f64, (a, b): (&Vector<2>, &Vector<2>)) -> Vector<2> {
    if place == 1.0 { *b } else { a + (b - a) * place }
}

fn at_end(end: &Vector<2>, at: f64, other: (&Vector<2>, &Vector<2>)) -> Closest<2> {
    let point = point_at(nearest_place(end, other), other);
    Closest { distance: (end - point).norm(), at, point }
}

fn at_middle(point: &Vector<2>, way: (&Vector<2>, &Vector<2>)) -> Closest<2> {
    let at = nearest_place(point, way);
    Closest { distance: (point - point_at(at, way)).norm(), at, point: *point }
}

#[cfg(test)]
mod tests;
