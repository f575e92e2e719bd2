use super::*;
use proptest::prelude::*;

fn v<const D: usize>(v: [f64; D]) -> Vector<D> {
    Vector::from(v)
}

#[track_caller]
fn check_box(from: [f64; 2], to: [f64; 2], distance: f64, at: f64, point: [f64; 2]) {
    let unit = (&v([0.0, 0.0]), &v([2.0, 1.0]));
    let found = distance_segment_box((&v(from), &v(to)), unit);
    assert_eq!(found, Closest { distance, at, point: v(point) });
}

#[test]
fn segment_beside_a_box() {
    check_box([-4.0, 3.0], [4.0, 3.0], 2.0, 0.5, [0.0, 1.0]);
    check_box([1.0, 3.0], [4.0, 3.0], 2.0, 0.0, [1.0, 1.0]);
    check_box([-4.0, 5.0], [-3.0, 5.0], 5.0, 1.0, [0.0, 1.0]);
}

#[test]
fn segment_through_a_box_meets_it_where_it_enters() {
    check_box([-2.0, 0.5], [6.0, 0.5], 0.0, 0.25, [0.0, 0.5]);
    check_box([-1.0, 2.0], [1.0, 0.0], 0.0, 0.5, [0.0, 1.0]);
    check_box([1.0, 0.5], [6.0, 0.5], 0.0, 0.0, [1.0, 0.5]);
}

#[test]
fn segment_past_a_corner() {
    let unit = (&v([0.0, 0.0]), &v([2.0, 1.0]));
    let found = distance_segment_box((&v([-2.0, 1.0]), &v([0.0, 3.0])), unit);
    assert!((found.distance - 2.0_f64.sqrt()).abs() < 1e-15);
    assert!((found.at - 0.5).abs() < 1e-15);
    assert_eq!(found.point, v([0.0, 1.0]));
}

#[test]
fn point_and_box() {
    check_box([5.0, 5.0], [5.0, 5.0], 5.0, 0.0, [2.0, 1.0]);
    check_box([1.0, 0.5], [1.0, 0.5], 0.0, 0.0, [1.0, 0.5]);
}

#[track_caller]
fn check_segment(
    way: [[f64; 2]; 2],
    other: [[f64; 2]; 2],
    distance: f64,
    at: f64,
    point: [f64; 2],
) {
    let [[from, to], [a, b]] = [way.map(v), other.map(v)];
    let found = distance_segment_segment((&from, &to), (&a, &b));
    assert_eq!(found, Closest { distance, at, point: v(point) });
}

#[test]
fn segments() {
    // Crossing, touching, along each other, parallel, apart, and points.
    check_segment([[0., 0.], [4., 0.]], [[1., -1.], [1., 1.]], 0.0, 0.25, [1., 0.]);
    check_segment([[0., 0.], [4., 0.]], [[1., 0.], [1., 1.]], 0.0, 0.25, [1., 0.]);
    check_segment([[0., 0.], [4., 0.]], [[1., 0.], [9., 0.]], 0.0, 0.25, [1., 0.]);
    check_segment([[0., 0.], [4., 0.]], [[9., 2.], [1., 2.]], 2.0, 0.25, [1., 2.]);
    check_segment([[2., 0.], [4., 0.]], [[9., 2.], [1., 2.]], 2.0, 0.0, [2., 2.]);
    check_segment([[0., 0.], [4., 0.]], [[7., 4.], [9., 4.]], 5.0, 1.0, [7., 4.]);
    check_segment([[0., 0.], [0., 0.]], [[3., 4.], [3., 4.]], 5.0, 0.0, [3., 4.]);
}

/// Least distance by dense sampling, and the bound on its error.
fn sampled<const D: usize>(
    (from, to): (&Vector<D>, &Vector<D>),
    distance: impl Fn(&Vector<D>) -> f64,
) -> (f64, f64) {
    const STEPS: u32 = 2000;
    let least = (0..=STEPS)
        .map(|step| distance(&(from + (to - from) * (f64::from(step) / f64::from(STEPS)))))
        .fold(f64::INFINITY, f64::min);
    (least, (to - from).norm() / f64::from(STEPS) / 2.0 + 1e-12)
}

fn check_sampled<const D: usize>(from: [f64; D], to: [f64; D], size: [f64; D]) {
    let (from, to, min, max) = (v(from), v(to), Vector::<D>::zeros(), v(size));
    let found = distance_segment_box((&from, &to), (&min, &max));
    let outside = |p: &Vector<D>| (p - p.sup(&min).inf(&max)).norm();
    let (least, bound) = sampled((&from, &to), outside);
    assert!(found.distance <= least + 1e-12 && least - bound <= found.distance);
    assert!((outside(&(from + (to - from) * found.at)) - found.distance).abs() < 1e-12);
}

fn coordinates<const D: usize>() -> impl Strategy<Value = [f64; D]> {
    // Whole numbers as well, for what is parallel, flush and touching.
    let coordinate = prop_oneof![-5.0..5.0f64, (-5..5i8).prop_map(f64::from)];
    proptest::array::uniform::<_, D>(coordinate)
}

fn sizes<const D: usize>() -> impl Strategy<Value = [f64; D]> {
    coordinates::<D>().prop_map(|size| size.map(f64::abs))
}

proptest! {
    #[test]
    fn distance_segment_box_is_least(from in coordinates::<2>(), to in coordinates(), size in sizes()) {
        check_sampled(from, to, size);
    }

    #[test]
    fn distance_segment_box_is_least_in_space(
        from in coordinates::<3>(), to in coordinates(), size in sizes(),
    ) {
        check_sampled(from, to, size);
    }

    #[test]
    fn distance_segment_segment_is_least(
        from in coordinates::<2>(), to in coordinates(), a in coordinates(), b in coordinates(),
    ) {
        let (from, to, a, b) = (v(from), v(to), v(a), v(b));
        let found = distance_segment_segment((&from, &to), (&a, &b));
        let outside = |p: &Vector<2>| at_end(p, 0.0, (&a, &b)).distance;
        let (least, bound) = sampled((&from, &to), outside);
        prop_assert!(found.distance <= least + 1e-12 && least - bound <= found.distance);
        let here = from + (to - from) * found.at;
        prop_assert!(((here - found.point).norm() - found.distance).abs() < 1e-12);
    }
}
