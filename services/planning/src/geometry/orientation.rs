//! Exact predicates: on which side of a line a point lies, and whether segments meet.
//!
//! Signs are decided by adaptive exact arithmetic (crate `robust`, after Shewchuk, "Adaptive
//! Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997), so they
//! are right for the coordinates as given, barring overflow and underflow of their products.

use robust::{Coord, orient2d};

use super::Vector;

/// Where a point lies, seen along a directed line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Left,
    On,
    Right,
}

impl Side {
    fn of(determinant: f64) -> Self {
        if determinant > 0.0 {
            Self::Left
        } else if determinant < 0.0 {
            Self::Right
        } else {
            Self::On
        }
    }

    fn is_opposite(self, other: Self) -> bool {
        matches!((self, other), (Self::Left, Self::Right) | (Self::Right, Self::Left))
    }
}

/// The cross product of `to - from` and `point - from`, square metres: its sign is exact.
pub(super) fn determinant(from: &Vector<2>, to: &Vector<2>, point: &Vector<2>) -> f64 {
    let coord = |point: &Vector<2>| Coord { x: point.x, y: point.y };
    orient2d(coord(from), coord(to), coord(point))
}

/// On which side of the line from `from` to `to` the point lies.
pub(crate) fn side_of_line(from: &Vector<2>, to: &Vector<2>, point: &Vector<2>) -> Side {
    Side::of(determinant(from, to, point))
}

/// On which side of the direction `from` the direction `to` lies.
pub(crate) fn side_of_direction(from: &Vector<2>, to: &Vector<2>) -> Side {
    side_of_line(&Vector::zeros(), from, to)
}

/// Whether two segments have one common point, which is no end of either.
pub(super) fn segments_cross(
    (a, b): (&Vector<2>, &Vector<2>),
    (c, d): (&Vector<2>, &Vector<2>),
) -> bool {
    side_of_line(a, b, c).is_opposite(side_of_line(a, b, d))
        && side_of_line(c, d, a).is_opposite(side_of_line(c, d, b))
}

/// Whether two closed segments have a point in common.
pub(crate) fn segments_meet(
    (a, b): (&Vector<2>, &Vector<2>),
    (c, d): (&Vector<2>, &Vector<2>),
) -> bool {
    let (c_side, d_side) = (side_of_line(a, b, c), side_of_line(a, b, d));
    let (a_side, b_side) = (side_of_line(c, d, a), side_of_line(c, d, b));
    let between = |p: &Vector<2>, a: &Vector<2>, b: &Vector<2>| {
        (0..2).all(|axis| a[axis].min(b[axis]) <= p[axis] && p[axis] <= a[axis].max(b[axis]))
    };
    (c_side.is_opposite(d_side) && a_side.is_opposite(b_side))
        || (c_side == Side::On && between(c, a, b))
        || (d_side == Side::On && between(d, a, b))
        || (a_side == Side::On && between(a, c, d))
        || (b_side == Side::On && between(b, c, d))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point(x: f64, y: f64) -> Vector<2> {
        Vector::from([x, y])
    }

    #[test]
    fn meeting_segments_include_touching_ones() {
        let base = (&point(0.0, 0.0), &point(4.0, 0.0));
        let meet = |a: [f64; 2], b: [f64; 2]| segments_meet(base, (&a.into(), &b.into()));
        assert!(meet([1., -1.], [1., 1.]) && meet([1., 0.], [1., 1.]) && meet([3., 0.], [9., 0.]));
        assert!(!meet([1., 1.], [1., 2.]) && !meet([5., 0.], [9., 0.]));
        assert!(!meet([5., -1.], [5., 1.]));
    }

    #[test]
    fn points_an_ulp_beside_a_line_are_told_apart() {
        let (from, to) = (point(0.1, 0.1), point(0.7, 0.7));
        let on = point(0.5, 0.5);
        assert_eq!(side_of_line(&from, &to, &on), Side::On);
        assert_eq!(side_of_line(&from, &to, &point(0.5, 0.5_f64.next_up())), Side::Left);
        assert_eq!(side_of_line(&from, &to, &point(0.5, 0.5_f64.next_down())), Side::Right);
    }

    #[test]
    fn touching_segments_meet_and_do_not_cross() {
        let (a, b) = (point(0.1, 0.1), point(0.7, 0.7));
        let (on, off) = (point(0.5, 0.5), point(0.5, 0.5_f64.next_up()));
        let far = point(0.0, 2.0);
        assert!(segments_meet((&a, &b), (&on, &far)));
        assert!(!segments_cross((&a, &b), (&on, &far)));
        assert!(!segments_meet((&a, &b), (&off, &far)));
        let beyond = point(0.5, 0.5_f64.next_down());
        assert!(segments_cross((&a, &b), (&beyond, &far)));
    }

    proptest! {
        /// On a grid of whole numbers, and on the same grid moved to where doubles are an
        /// eighth apart, 128-bit integers say the same.
        #[test]
        fn agrees_with_whole_numbers(
            [a, b, c] in proptest::array::uniform3(proptest::array::uniform2(-50..50_i128)),
            far: bool,
        ) {
            let cross = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            let expected = Side::of(cross as f64);
            let at = if far { 1e15 } else { 0.0 };
            let place = |p: [i128; 2]| point(at + p[0] as f64, at + p[1] as f64);
            prop_assert_eq!(side_of_line(&place(a), &place(b), &place(c)), expected);
        }
    }
}
