use super::*;
use crate::budget::{Allowance, Cap};
use proptest::prelude::*;

fn polygon(vertices: &[[f64; 2]]) -> Result<Polygon, PolygonError> {
    Polygon::new(vertices.iter().map(|v| Vector::from(*v)).collect(), &Budget::default())
}

#[track_caller]
fn check_error(vertices: &[[f64; 2]], error: PolygonError) {
    assert_eq!(polygon(vertices).unwrap_err(), error);
}

fn crossing(vertices: &[[f64; 2]], first: usize, second: usize) -> PolygonError {
    let edge =
        |i: usize| [Vector::from(vertices[i]), Vector::from(vertices[(i + 1) % vertices.len()])];
    PolygonError::Crossing { first, second, first_edge: edge(first), second_edge: edge(second) }
}

#[test]
fn either_orientation_is_accepted() {
    let square = [[0., 0.], [2., 0.], [2., 1.], [0., 1.]];
    let mut reversed = square;
    reversed.reverse();
    for vertices in [square, reversed] {
        let polygon = polygon(&vertices).expect("a square");
        assert_eq!(polygon.bounds().size(), Vector::from([2.0, 1.0]));
        assert!(polygon.is_axis_box());
        assert!(polygon.contains(&Vector::from([1.0, 0.5])));
        assert!(!polygon.contains(&Vector::from([3.0, 0.5])));
    }
}

#[test]
fn slanted_square_and_dented_square_are_no_boxes() {
    assert!(!polygon(&[[1., 0.], [2., 1.], [1., 2.], [0., 1.]]).expect("a diamond").is_axis_box());
    let dented = polygon(&[[0., 0.], [2., 0.], [2., 2.], [1., 1.], [0., 2.]]).expect("dented");
    assert!(!dented.is_axis_box());
    assert!(!dented.contains(&Vector::from([1.0, 1.5])));
    assert!(dented.contains(&Vector::from([0.25, 1.5])));
}

#[test]
fn two_vertices_are_rejected() {
    check_error(&[[0., 0.], [1., 1.]], PolygonError::TooFewVertices { has: 2, needs: 3 });
}

#[test]
fn infinite_vertex_is_rejected() {
    let y = f64::INFINITY;
    let error = PolygonError::NotFinite { vertex: 1, x: 1.0, y };
    check_error(&[[0., 0.], [1., y], [2., 0.]], error);
}

#[test]
fn flat_polygon_is_rejected() {
    let error = PolygonError::Flat { vertices: 3, axis: 1, value: 5.0 };
    check_error(&[[0., 5.], [1., 5.], [2., 5.]], error);
    // Slanted: the last edge runs back over the first.
    let slanted = [[0., 0.], [1., 1.], [3., 3.]];
    check_error(&slanted, crossing(&slanted, 0, 2));
}

#[test]
fn bow_tie_is_rejected() {
    let bow = [[0., 0.], [2., 2.], [2., 0.], [0., 2.]];
    check_error(&bow, crossing(&bow, 0, 2));
    assert_eq!(
        crossing(&bow, 0, 2).to_string(),
        "edges 0 and 2 of the polygon cross: (0, 0) to (2, 2) and (2, 0) to (0, 2)"
    );
}

#[test]
fn repeated_vertex_is_rejected() {
    let error = |first, second| PolygonError::Repeated { first, second, x: 1.0, y: 0.0 };
    check_error(&[[0., 0.], [1., 0.], [1., 0.], [0., 1.]], error(1, 2));
    check_error(&[[0., 0.], [1., 0.], [2., 2.], [1., 0.], [0., 1.]], error(1, 3));
    check_error(&[[1., 0.], [2., 2.], [0., 1.], [1., 0.]], error(0, 3));
}

#[test]
fn spike_is_rejected() {
    let spike = [[0., 0.], [4., 0.], [2., 0.], [2., 2.]];
    check_error(&spike, crossing(&spike, 0, 1));
}

#[test]
fn touching_edge_is_rejected() {
    let touching = [[0., 0.], [4., 0.], [4., 4.], [2., 0.], [0., 4.]];
    check_error(&touching, crossing(&touching, 0, 2));
}

#[test]
fn only_outlines_that_turn_once_around_are_convex() {
    let on_circle = |count: usize, turns: usize, reverse: bool| {
        let angle = |i: usize| (turns * i) as f64 * std::f64::consts::TAU / count as f64;
        let mut outline: Vec<Vector<2>> =
            (0..count).map(|i| [libm::cos(angle(i)), libm::sin(angle(i))].into()).collect();
        if reverse {
            outline.reverse();
        }
        is_convex(&outline)
    };
    for reverse in [false, true] {
        for count in 3..40 {
            assert!(on_circle(count, 1, reverse), "{count} vertices");
        }
        // A pentagram and a heptagram turn to one side, too, but twice and three times around.
        assert!(!on_circle(5, 2, reverse) && !on_circle(7, 2, reverse));
        assert!(!on_circle(7, 3, reverse));
    }
    let dented = [[0., 0.], [2., 0.], [2., 2.], [1., 1.], [0., 2.]].map(Vector::from);
    let straight = [[0., 0.], [1., 0.], [2., 0.], [2., 2.]].map(Vector::from);
    assert!(!is_convex(&dented) && !is_convex(&straight));
}

/// A comb with many teeth, big enough for the index.
fn comb(teeth: usize) -> Vec<[f64; 2]> {
    let tooth = |i: usize| {
        let x = 2.0 * i as f64;
        [[x, 0.0], [x + 0.5, 9.0], [x + 1.5, 9.0], [x + 2.0, 0.0]]
    };
    let teeth = (0..teeth).flat_map(|i| tooth(i).into_iter().take(3)).collect::<Vec<_>>();
    let far = 2.0 * (teeth.len() / 3) as f64;
    teeth.into_iter().chain([[far, 0.0], [far, -1.0], [0.0, -1.0]]).collect()
}

#[test]
fn large_polygon_is_checked_through_the_index() {
    assert!(polygon(&comb(1000)).is_ok());
    let mut crossed = comb(1000);
    crossed[1501][0] = 1100.0;
    assert!(matches!(polygon(&crossed), Err(PolygonError::Crossing { first: 1500, .. })));
}

#[test]
fn intricate_polygon_is_rejected_in_bounded_time() {
    // Slanted strips: nearly every pair of bounding boxes meets.
    let count = 20_000;
    let mut vertices: Vec<[f64; 2]> = Vec::new();
    for i in 0..count {
        let shift = f64::from(i) * 1e-4;
        let (near, far) = ([shift, -shift], [100.0 + shift, 100.0 - shift]);
        vertices.extend(if i % 2 == 0 { [near, far] } else { [far, near] });
    }
    vertices.push([-50.0, -50.0]);
    let budget = Budget::new(Allowance { steps: 1 << 26, ..Allowance::NONE });
    let vertices = vertices.into_iter().map(Vector::from).collect();
    let spent = Spent::Limit { cap: Cap::Steps, most: 1 << 26 };
    assert_eq!(Polygon::new(vertices, &budget), Err(spent.into()));
}

proptest! {
    /// The index and looking at all pairs find the same, first, pair.
    #[test]
    fn index_agrees_with_all_pairs(
        vertices in proptest::collection::vec(proptest::array::uniform2(0..40i8), 3..80),
    ) {
        let vertices: Vec<Vector<2>> =
            vertices.iter().map(|v| Vector::from(v.map(f64::from))).collect();
        let mut all = Ok(());
        for (first, second) in (0..vertices.len())
            .flat_map(|first| (first + 1..vertices.len()).map(move |second| (first, second)))
        {
            all = all.and_then(|()| check_pair(&vertices, first, second));
        }
        prop_assert_eq!(check_indexed(&vertices, &Budget::default()), all);
    }

    /// A convex outline has no wrong pair of edges.
    #[test]
    fn convex_outlines_are_simple(
        vertices in proptest::collection::vec(proptest::array::uniform2(0..5i8), 3..8),
    ) {
        let vertices: Vec<Vector<2>> =
            vertices.iter().map(|v| Vector::from(v.map(f64::from))).collect();
        if is_convex(&vertices) {
            prop_assert_eq!(check_indexed(&vertices, &Budget::default()), Ok(()));
        }
    }

    /// Star-shaped polygons are simple.
    #[test]
    fn star_is_accepted(radii in proptest::collection::vec(0.5..5.0f64, 3..200)) {
        let angle = |i: usize| i as f64 * std::f64::consts::TAU / radii.len() as f64;
        let star: Vec<[f64; 2]> = radii
            .iter()
            .enumerate()
            .map(|(i, r)| [r * libm::cos(angle(i)), r * libm::sin(angle(i))])
            .collect();
        let star = polygon(&star).expect("a star");
        prop_assert!(star.contains(&Vector::from([1e-3, 2e-3])));
    }
}
