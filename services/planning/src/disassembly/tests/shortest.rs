//! The shortest way through the junctions: by closed forms, and against a visibility graph.

use super::optimum::optimum;
use super::*;
use crate::geometry::Vector;

fn shortest<const D: usize>(
    scene: &Scene<D>,
    gap: Gap<'_, D>,
) -> (Chain<D>, DisassemblyPath<D>, ShortestWay<D>) {
    let (chain, path) = plan(scene, gap).expect("a path");
    let way = shortest_way(&chain, &scene.body, None, &path, &Budget::default()).unwrap();
    (chain, path, way)
}

fn length<const D: usize>(way: &ShortestWay<D>) -> f64 {
    way.legs.iter().map(|leg| leg.curve.length()).sum()
}

/// The boxes of displacements that keep the gap.
fn spaces<const D: usize>(
    scene: &Scene<D>,
    chain: &Chain<D>,
    path: &DisassemblyPath<D>,
) -> Vec<[Vector<D>; 2]> {
    let shrunk = |(junction, gap): (&crate::free_space::Junction<D>, &Vector<D>)| {
        let space = &junction.space;
        [space.min() + gap - scene.body.min(), space.max() - gap - scene.body.max()]
    };
    chain.junctions().iter().zip(path.gaps()).map(shrunk).collect()
}

#[test]
fn rules_of_section_4_are_the_shortest() {
    for gap in [0.01, 0.1, 0.2] {
        let (_, path, way) = shortest(&section_4(), Gap::Uniform(gap));
        assert_eq!(way.legs, path.legs());
        assert_eq!(way.bound, path.length());
    }
    let (_, path, way) = shortest(&section_4(), Gap::Safest);
    assert_eq!((way.legs.as_slice(), way.bound), (path.legs(), path.length()));
}

/// From beside a wall the rules lead away from it first. The way goes straight to the corner inside.
#[test]
fn way_round_two_corners_is_in_closed_form() {
    // Up, to the right, and up: the corners inside are at (3, 5) and (9, 8), the body is 1 m each way.
    let scene = Scene {
        channels: vec![
            space([0.0, 0.0], [3.0, 8.0]),
            space([0.0, 5.0], [12.0, 8.0]),
            space([9.0, 5.0], [12.0, 20.0]),
        ],
        body: space([0.25, 1.0], [1.25, 2.0]),
        exit: Direction { axis: 1, sign: Sign::Positive },
    };
    let (_, path, way) = shortest(&scene, Gap::Uniform(0.5));
    // Its lower right corner passes (2.5, 5.5), its upper left one (9.5, 7.5).
    let (a, b) = (Vector::from([1.25, 4.5]), Vector::from([9.25, 5.5]));
    let expected = a.norm() + (b - a).norm() + 13.5;
    assert!((length(&way) - expected).abs() < 1e-12, "{} {expected}", length(&way));
    assert!((way.bound - expected).abs() < 1e-12 && expected <= path.length() + 1e-12);
}

/// A body that turns back in its second channel touches the side of a junction, as light is reflected.
#[test]
fn way_that_turns_back_is_reflected() {
    let scene = Scene {
        channels: vec![
            space([0.0, 0.0], [6.0, 9.0]),
            space([0.0, 6.0], [12.0, 9.0]),
            space([2.0, 0.0], [9.0, 9.0]),
        ],
        body: space([2.5, 1.0], [3.5, 2.0]),
        exit: Direction { axis: 1, sign: Sign::Negative },
    };
    let (chain, path, way) = shortest(&scene, Gap::Uniform(0.25));
    // Up until its lower side is 0.25 m above z = 6, and straight down again.
    let expected = 5.25 + 7.25;
    assert!((length(&way) - expected).abs() < 1e-9, "{} {expected}", length(&way));
    assert!(way.bound <= length(&way) && expected - way.bound < 1e-9);
    assert!(length(&way) < path.length() && chain.junctions().len() == 2);
}

/// Bends of a way in the plane are corners of the boxes, or places at which it is reflected; of ways
/// that bend at corners alone this is the shortest, by Dijkstra's search over all corners.
fn least_over_corners(spaces: &[[Vector<2>; 2]], exit: Direction, out: f64) -> f64 {
    // The corners of a box, by the number of boxes passed. A corner is reached by a straight line that
    // passes all boxes between in order.
    let corners = |space: &[Vector<2>; 2]| {
        let [min, max] = *space;
        [min, Vector::from([max[0], min[1]]), max, Vector::from([min[0], max[1]])]
    };
    let mut best: Vec<Vec<(Vector<2>, f64)>> = vec![vec![(Vector::zeros(), 0.0)]];
    for (index, space) in spaces.iter().enumerate() {
        let mut here = Vec::new();
        for corner in corners(space) {
            let mut least = f64::INFINITY;
            for (from_index, froms) in best.iter().enumerate() {
                for (from, length) in froms {
                    if passes_in_order(from, &corner, &spaces[from_index..index]) {
                        least = least.min(length + (corner - from).norm());
                    }
                }
            }
            here.push((corner, least));
        }
        best.push(here);
    }
    let mut least = f64::INFINITY;
    for (from_index, froms) in best.iter().enumerate() {
        for (from, length) in froms {
            let mut end = *from;
            end[exit.axis] = exit.sign.factor() * out;
            if passes_in_order(from, &end, &spaces[from_index..]) {
                least = least.min(length + (end - from).norm());
            }
        }
    }
    least
}

fn passes_in_order(from: &Vector<2>, to: &Vector<2>, spaces: &[[Vector<2>; 2]]) -> bool {
    let mut since: f64 = 0.0;
    spaces.iter().all(|[min, max]| {
        let (mut first, mut last) = (since, 1.0_f64);
        for axis in 0..2 {
            let along = to[axis] - from[axis];
            let (low, high) = (min[axis] - 1e-12 - from[axis], max[axis] + 1e-12 - from[axis]);
            if along == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return false;
                }
                continue;
            }
            first = first.max((low / along).min(high / along));
            last = last.min((low / along).max(high / along));
        }
        since = first;
        first <= last
    })
}

fn check<const D: usize>(scene: &Scene<D>, fraction: f64) -> Result<(), TestCaseError> {
    let (chain, path, way) = shortest(scene, Gap::Fraction(fraction));
    let length = length(&way);
    prop_assert!(way.bound <= length && length <= path.length());
    // The bound proves that nothing is shorter by more; mostly by 1e-8, seldom by twice as much.
    prop_assert!(length - way.bound <= 1e-7 * length, "{length} {}", way.bound);
    // And the way passes the junctions in order, at the gap.
    let spaces = spaces(scene, &chain, &path);
    let mut passed = 0;
    for leg in &way.legs {
        let (from, to) = (leg.curve.start(), leg.curve.end());
        for step in 0..=2000 {
            let at = from + (to - from) * (f64::from(step) / 2000.0);
            let slack = leg.curve.length() / 1000.0;
            while let Some([min, max]) = spaces.get(passed)
                && (0..D).all(|axis| min[axis] - slack <= at[axis] && at[axis] <= max[axis] + slack)
            {
                passed += 1;
            }
        }
    }
    prop_assert_eq!(passed, spaces.len());
    // No way moved a little is shorter.
    let mut each = Vec::new();
    let (mut walls, budget) = (crate::free_space::walls::Walls::default(), Budget::default());
    let mut complement = crate::free_space::walls::Complement::default();
    walls
        .set_complement(chain.channels(), chain.mouth_and_channel(0.0), &mut complement, &budget)
        .unwrap();
    walls.index(&budget).unwrap();
    let body = crate::clearance::translating::Body::from_box(&scene.body);
    crate::clearance::translating::clearance_body_legs(
        &body, &walls, &way.legs, &mut each, &budget,
    )
    .unwrap();
    let gap = path.gaps().iter().map(Vector::min).fold(f64::INFINITY, f64::min);
    prop_assert!(each.iter().skip(1).all(|near| near.value >= gap - 1e-9), "{gap} {each:?}");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn shortest_way_is_proved_in_the_plane(scene in scenes::<2>(8), fraction in 0.01..0.99f64) {
        check(&scene, fraction)?;
    }

    #[test]
    fn shortest_way_is_proved_in_space(scene in scenes::<3>(8), fraction in 0.01..0.99f64) {
        check(&scene, fraction)?;
    }

    /// Where no way is reflected; with reflections it is shorter.
    #[test]
    fn shortest_way_is_that_of_a_visibility_graph(
        scene in scenes::<2>(8),
        fraction in 0.01..0.99f64,
    ) {
        let (chain, path, way) = shortest(&scene, Gap::Fraction(fraction));
        let spaces = spaces(&scene, &chain, &path);
        let end = path.legs().last().expect("a leg").curve.end();
        let least = least_over_corners(&spaces, scene.exit, scene.exit.coordinate(&end));
        let is_corner = |at: &Vector<2>| spaces.iter().any(|[min, max]| {
            (0..2).all(|axis| at[axis] == min[axis] || at[axis] == max[axis])
        });
        let length = length(&way);
        prop_assert!(length <= least + 1e-9, "{length} {least}");
        let bends = way.legs.len() - 1;
        if way.legs[..bends].iter().all(|leg| is_corner(&leg.curve.end())) {
            prop_assert!((length - least).abs() < 1e-9, "{length} {least}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn shortest_way_is_the_optimum_found_one_way_point_at_a_time(
        scene in scenes::<2>(5),
        fraction in 0.01..0.9f64,
    ) {
        let (chain, path, way) = shortest(&scene, Gap::Fraction(fraction));
        let optimum = optimum(&scene, &chain, &path);
        prop_assert!(way.bound <= optimum + 1e-6, "{} {optimum}", way.bound);
    }
}
