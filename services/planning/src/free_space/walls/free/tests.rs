use crate::budget::Budget;
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::polygon::{Polygon, edges};
use crate::geometry::{AxisBox, Vector};
use proptest::prelude::*;

fn space<const D: usize>(min: [f64; D], max: [f64; D]) -> AxisBox<D> {
    AxisBox::new(min.into(), max.into()).expect("a box")
}

/// Whether a box of 4 m by 2 m at the origin is free beside a segment of wall.
#[track_caller]
fn check_segment(from: [f64; 2], to: [f64; 2], free: bool) {
    for (from, to) in [(from, to), (to, from)] {
        let mut walls = Walls::default();
        walls.push(Wall { from: from.into(), to: to.into() });
        assert_eq!(
            walls.is_free(&space([0., 0.], [4., 2.]), &Budget::default()).unwrap(),
            free,
            "{from:?} to {to:?}"
        );
    }
}

#[test]
fn wall_that_touches_a_side_leaves_it_free() {
    check_segment([4., -1.], [4., 3.], true);
    check_segment([4., 0.5], [4., 1.], true);
    check_segment([1., 2.], [3., 2.], true);
    check_segment([2., 2.], [3., 5.], true);
    check_segment([-1., 3.], [1., 5.], true);
}

#[test]
fn wall_through_a_corner_leaves_it_free() {
    check_segment([3., -1.], [5., 1.], true);
    check_segment([4., 2.], [6., 2.5], true);
    // The same with coordinates that are rounded.
    let mut walls = Walls::default();
    let slope = (1.3 - 0.7) / 0.3;
    walls.push(Wall { from: [0.7, 0.1 - 3.0 * slope].into(), to: [3.8, 0.1 + 0.1 * slope].into() });
    assert!(walls.is_free(&space([0.1, 0.1], [3.7, 0.9]), &Budget::default()).unwrap());
}

#[test]
fn wall_in_the_interior_does_not() {
    check_segment([2., -1.], [2., 3.], false);
    check_segment([1., 0.5], [2., 0.75], false);
    check_segment([4., 1.], [3.999, 1.], false);
    check_segment([2.9, -1.], [5., 1.1], false);
    check_segment([0., 0.], [4., 2.], false);
    check_segment([-3., 0.], [6., 2.], false);
}

#[test]
fn box_inside_of_a_solid_is_not_free() {
    let inside = space([1., 1.], [2., 2.]);
    let mut walls = Walls::default();
    walls.push_box(&space([0., 0.], [3., 3.]));
    assert!(!walls.is_free(&inside, &Budget::default()).unwrap());
    assert!(!walls.is_free(&space([0., 0.], [3., 3.]), &Budget::default()).unwrap());
    assert!(walls.is_free(&space([3., 0.], [4., 3.]), &Budget::default()).unwrap());
    walls.clear();
    let corners = [[0., 0.], [9., 0.], [0., 9.]].map(Vector::from);
    walls.push_polygon(&Polygon::new(corners.to_vec(), &Budget::default()).expect("a triangle"));
    assert!(!walls.is_free(&inside, &Budget::default()).unwrap());
    assert!(walls.is_free(&space([4.5, 4.5], [6., 6.]), &Budget::default()).unwrap());
    assert!(!walls.is_free(&space([4.4, 4.5], [6., 6.]), &Budget::default()).unwrap());
}

#[test]
fn wall_in_space_leaves_what_it_touches() {
    let mut walls = Walls::default();
    walls.push(Wall { from: [0., 0., 1.].into(), to: [2., 2., 1.].into() });
    assert!(walls.is_free(&space([0., 0., 1.], [2., 2., 3.]), &Budget::default()).unwrap());
    assert!(walls.is_free(&space([2., 0., 0.], [3., 2., 3.]), &Budget::default()).unwrap());
    assert!(!walls.is_free(&space([1.9, 0., 0.], [3., 2., 3.]), &Budget::default()).unwrap());
}

fn whole_boxes<const D: usize>(count: usize) -> impl Strategy<Value = Vec<AxisBox<D>>> {
    let corner = proptest::array::uniform::<_, D>(-6..6_i32);
    let size = proptest::array::uniform::<_, D>(1..=4_i32);
    let number = |v: [i32; D]| Vector::from(v.map(f64::from));
    let whole = move |(c, s)| AxisBox::new(number(c), number(c) + number(s)).expect("a box");
    proptest::collection::vec((corner, size).prop_map(whole), count)
}

/// Solids leave a box free if none has an interior in common with it.
fn check_boxes<const D: usize>(boxes: &[AxisBox<D>]) {
    let (space, solids) = boxes.split_first().expect("a box");
    let mut walls = Walls::default();
    solids.iter().for_each(|solid| walls.push_box(solid));
    let free = solids.iter().all(|solid| solid.intersection(space).is_none());
    assert_eq!(walls.is_free(space, &Budget::default()).unwrap(), free);
    walls.index(&Budget::default()).unwrap();
    assert_eq!(walls.is_free(space, &Budget::default()).unwrap(), free, "with an index");
}

/// Whether a segment between grid points has a point in the interior, in whole numbers: at
/// which parts of its length, as fractions, it enters and leaves what lies between the sides.
fn passes(from: [i64; 2], to: [i64; 2], min: [i64; 2], max: [i64; 2]) -> bool {
    let (mut enters, mut leaves) = (vec![], vec![]);
    for axis in 0..2 {
        let way = to[axis] - from[axis];
        let (a, b) = (min[axis] - from[axis], max[axis] - from[axis]);
        match way.signum() {
            0 if a >= 0 || b <= 0 => return false,
            0 => {}
            1 => (enters.push((a, way)), leaves.push((b, way))).0,
            _ => (enters.push((-b, -way)), leaves.push((-a, -way))).0,
        }
    }
    let less = |a: &(i64, i64), b: &(i64, i64)| a.0 * b.1 < b.0 * a.1;
    enters.iter().all(|enter| less(enter, &(1, 1)) && leaves.iter().all(|leave| less(enter, leave)))
        && leaves.iter().all(|leave| less(&(0, 1), leave))
}

proptest! {
    #[test]
    fn solid_boxes_leave_free_what_they_do_not_overlap(boxes in whole_boxes::<2>(4)) {
        check_boxes(&boxes);
    }

    #[test]
    fn many_solids_leave_free_what_they_do_not_overlap(boxes in whole_boxes::<2>(30)) {
        check_boxes(&boxes);
    }

    #[test]
    fn solid_boxes_in_space_leave_free_what_they_do_not_overlap(boxes in whole_boxes::<3>(5)) {
        check_boxes(&boxes);
    }

    #[test]
    fn segment_leaves_free_what_it_does_not_pass_through(
        from in proptest::array::uniform2(-9..9_i64),
        to in proptest::array::uniform2(-9..9_i64),
        min in proptest::array::uniform2(-5..4_i64),
        size in proptest::array::uniform2(1..=4_i64),
    ) {
        prop_assume!(from != to);
        let max = [min[0] + size[0], min[1] + size[1]];
        let number = |point: [i64; 2]| Vector::from(point.map(|value| value as f64));
        let mut walls = Walls::default();
        walls.push(Wall { from: number(from), to: number(to) });
        let space = AxisBox::new(number(min), number(max)).expect("a box");
        prop_assert_eq!(walls.is_free(&space, &Budget::default()).unwrap(), !passes(from, to, min, max));
    }

    /// No point of a free box is inside of a solid.
    #[test]
    fn free_box_has_no_point_of_a_solid(
        corners in proptest::collection::vec(proptest::array::uniform2(-9..9_i32), 3..6),
        boxes in whole_boxes::<2>(1),
    ) {
        let corners = corners.into_iter().map(|corner| Vector::from(corner.map(f64::from)));
        let Ok(polygon) = Polygon::new(corners.collect(), &Budget::default()) else { return Ok(()) };
        let mut walls = Walls::default();
        walls.push_polygon(&polygon);
        let (min, size) = (boxes[0].min(), boxes[0].size());
        let inside = (0..400).any(|number: i32| {
            let part = Vector::from([number % 20, number / 20].map(|at| (f64::from(at) + 0.5) / 20.0));
            polygon.contains(&(min + size.component_mul(&part)))
        });
        let passed = edges(polygon.vertices()).any(|(from, to)| {
            let whole = |point: Vector<2>| [point[0] as i64, point[1] as i64];
            passes(whole(from), whole(to), whole(min), whole(min + size))
        });
        prop_assert_eq!(walls.is_free(&boxes[0], &Budget::default()).unwrap(), !inside && !passed);
    }
}
