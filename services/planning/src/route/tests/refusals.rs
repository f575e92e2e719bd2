//! Refusals when there is no route.

use super::*;
use crate::budget::Allowance;
use crate::route::widest::{Change, Space, extent};

#[test]
fn parts_that_are_apart_are_named() {
    let channels =
        [space([0., 0.], [9., 2.]), space([5., 2.25], [8., 9.]), space([0., 0.], [2., 3.])];
    let (first, second, junction, others) = (0, 1, 0, 0);
    let (axis, needs, apart) = (1, 1.0, 0.25);
    let error = RouteError::Apart { first, second, junction, axis, needs, apart, others };
    check_error(&channels, &cube(1., 0.5, End::Exit(UP)), error);
}

#[test]
fn smaller_change_is_named_whether_apart_or_not() {
    // Up at x = 3 the junction is 0.5 m wide, up at x = 6 there are 0.25 m between.
    let mut channels =
        [space([0., 0.], [9., 2.]), space([3., 0.], [3.5, 9.]), space([6., 2.25], [9., 9.])];
    let (first, junction, needs, others) = (0, 0, 1.0, 0);
    let (second, axis, has) = (1, 0, 0.5);
    let narrow = RouteError::JunctionTooSmall { first, second, junction, axis, needs, has, others };
    check_error(&channels, &cube(1., 0.5, End::Exit(UP)), narrow);
    // A narrower one lacks more than the other is apart beyond what it needs.
    channels[1] = space([3., 0.], [3.5, 1.75]);
    let (second, axis, apart) = (2, 1, 0.25);
    let apart = RouteError::Apart { first, second, junction, axis, needs, apart, others };
    check_error(&channels, &cube(1., 0.5, End::Exit(UP)), apart);
}

#[test]
fn far_parts_are_named_by_the_nearest_stepping_stone() {
    // Over the stone in between the farthest step is 50 m, not 101.
    let channels = [
        space([0., 0.], [9., 2.]),
        space([0., 103.], [9., 110.]),
        space([40., 54.], [60., 55.]),
        space([0., 52.], [9., 53.5]),
    ];
    let (junction, axis, needs, others) = (0, 1, 1.0, 1);
    let (first, second, apart) = (0, 3, 50.0);
    let error = RouteError::Apart { first, second, junction, axis, needs, apart, others };
    check_error(&channels, &cube(1., 0.5, End::Exit(UP)), error);
}

#[test]
fn body_that_passes_without_the_gap_is_told_so() {
    // Along x the gap is much too large, along z the body itself, by less.
    let channels = [space([0., 0.], [9., 2.]), space([7.5, 1.25], [9., 9.])];
    let traveller = body([1., 0.5], [2., 1.5], Gap::PerAxis([2.0, 0.1].into()), End::Exit(UP));
    let (first, second, junction, others) = (0, 1, 0, 0);
    let (axis, needs, has) = (1, 1.0, 0.75);
    let error = RouteError::JunctionTooSmall { first, second, junction, axis, needs, has, others };
    check_error(&channels, &traveller, error);
    // A way that the body passes without the gap comes before one that it does not pass.
    let channels =
        [space([0., 0.], [9., 2.]), space([1., 0.], [1.875, 9.]), space([7., 0.], [9., 9.])];
    let traveller = body([1., 0.5], [2., 1.5], Gap::Uniform(3.0), End::Exit(UP));
    let (second, axis, gap, least, most) = (2, 0, 3.0, 0.0, 0.5);
    let error = RouteError::GapOutOfRange { first, second, junction, axis, gap, least, most };
    check_error(&channels, &traveller, error);
}

#[test]
fn way_with_fewer_small_junctions_is_named() {
    // Both ways lack 0.5 m at two junctions; the one in front lacks 0.25 m at a third.
    let channels = [
        space([0., 0.], [20., 2.]),
        space([2., 0.], [2.5, 6.]),
        space([10., 0.], [10.5, 9.]),
        space([0., 5.], [4., 7.]),
        space([3., 5.], [3.75, 20.]),
        space([10., 7.], [14., 9.]),
        space([12., 7.], [14., 20.]),
    ];
    let (junction, axis, needs, has, others) = (0, 0, 1.0, 0.5, 1);
    let (first, second) = (0, 2);
    let error = RouteError::JunctionTooSmall { first, second, junction, axis, needs, has, others };
    check_error(&channels, &cube(5., 0.5, End::Exit(UP)), error);
}

#[test]
fn only_what_would_take_too_long_is_not_told() {
    let channels: Vec<_> = (0..40)
        .map(|index| space([3.0 * f64::from(index), 0.], [3.0 * f64::from(index) + 1.5, 2.]))
        .collect();
    let (mut graph, mut router) = (Graph::default(), Router::default());
    graph.build(&channels, &Budget::default()).expect("few junctions");
    let mut traveller = body([0.25, 0.5], [1.25, 1.5], Gap::Safest, End::Exit(RIGHT));
    let error = router.find(&graph, &mut traveller, &steps(20));
    assert_eq!(error, Err(RouteError::Separate { reached: 1, channels: 40 }));
    let error = router.find(&graph, &mut traveller, &steps(1000));
    assert!(matches!(error, Err(RouteError::Apart { apart: 1.5, others: 38, .. })), "{error:?}");
}

fn steps(route_steps: u64) -> Budget<'static> {
    Budget::new(Allowance { route_steps, ..Allowance::NONE })
}

/// What the widest way lacks: the least that joins start and end when junctions are
/// opened one after the other, by what they lack.
fn brute_force<const D: usize>(
    space: &Space<'_, D>,
    starts: &[usize],
    is_end: impl Fn(usize) -> bool,
) -> (Change, f64) {
    let count = space.channels.len();
    let mut pairs: Vec<(Change, f64, usize, usize)> = Vec::new();
    for one in 0..count {
        for other in 0..one {
            let lack = space.lack(&space.channels[one], &space.channels[other]);
            pairs.push((lack.change, lack.metres, one, other));
        }
    }
    pairs.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    // Which part each channel belongs to.
    let mut parts: Vec<usize> = (0..count).collect();
    let joined = |parts: &[usize]| {
        let ends = (0..count).filter(|index| is_end(*index));
        ends.into_iter().any(|end| starts.iter().any(|start| parts[*start] == parts[end]))
    };
    let mut lack = (Change::Nothing, 0.0);
    for (change, metres, one, other) in pairs {
        if joined(&parts) {
            break;
        }
        lack = (change, metres);
        let (from, to) = (parts[one], parts[other]);
        parts.iter_mut().filter(|part| **part == from).for_each(|part| *part = to);
    }
    lack
}

fn check_widest<const D: usize>(
    crowd: &Crowd<D>,
    gap: Gap<'_, D>,
    walled: bool,
) -> Result<(), TestCaseError> {
    let mover = BodyMover::new(&crowd.body, gap, End::Exit(crowd.exit));
    let traveller = *mover.expect("a traveller").traveller();
    let mut graph = Graph::default();
    graph.build(&crowd.channels, &Budget::default()).expect("few junctions");
    let mouth = farthest(&crowd.channels, crowd.exit);
    let is_end = |index: usize| Some(mouth_of(&crowd.channels[index], crowd.exit)) == mouth;
    let starts: Vec<_> = (0..crowd.channels.len())
        .filter(|index| crowd.channels[*index].contains(&crowd.body))
        .collect();
    let channels = graph.channels();
    let room = walled.then(Vector::zeros);
    let space = Space { channels, tree: graph.tree(), traveller: &traveller, room };
    let way = space.widest_way(&starts, is_end, &Budget::default()).expect("a way");
    let expected = brute_force(&space, &starts, is_end);
    prop_assert_eq!((way.lack.change, way.lack.metres), expected);
    // The numbers are those of the junction named.
    prop_assert_eq!(way.junction.is_none(), expected.0 == Change::Nothing);
    if let Some(junction) = way.junction {
        let [one, other] = [way.route[junction], way.route[junction + 1]].map(|at| &channels[at]);
        let lack = space.lack(one, other);
        prop_assert_eq!((lack.change, lack.metres), expected);
        if lack.change == Change::Junction {
            let has = extent(one, other, lack.axis);
            prop_assert_eq!(lack.metres, traveller.needs_along(lack.axis).0 - has);
        }
    }
    prop_assert!(starts.contains(&way.route[0]));
    prop_assert!(is_end(way.route[way.route.len() - 1]));
    // Ties go by index, not by what was looked at before.
    let again = space.widest_way(&starts, is_end, &Budget::default()).expect("a way");
    prop_assert_eq!(again.route, way.route);
    Ok(())
}

/// Boxes that are mostly apart.
fn scattered<const D: usize>(most: usize) -> impl Strategy<Value = Crowd<D>> {
    (crowd::<D>(most), proptest::array::uniform::<_, D>(1.0..9.0f64)).prop_map(
        |(mut crowd, spread)| {
            let spread = Vector::from(spread);
            for channel in &mut crowd.channels[1..] {
                *channel = channel.translated(&channel.min().component_mul(&spread));
            }
            crowd
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn no_way_lacks_less_in_two_dimensions(crowd in crowd::<2>(9), gap in gaps(), walled: bool) {
        check_widest(&crowd, gap, walled)?;
    }

    #[test]
    fn no_way_lacks_less_in_three_dimensions(crowd in crowd::<3>(9), gap in gaps(), walled: bool) {
        check_widest(&crowd, gap, walled)?;
    }

    #[test]
    fn no_way_over_gaps_lacks_less_in_two_dimensions(crowd in scattered::<2>(20), gap in gaps(), walled: bool) {
        check_widest(&crowd, gap, walled)?;
    }

    #[test]
    fn no_way_over_gaps_lacks_less_in_three_dimensions(crowd in scattered::<3>(20), gap in gaps(), walled: bool) {
        check_widest(&crowd, gap, walled)?;
    }
}
