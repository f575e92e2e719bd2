use super::*;
use crate::budget::Allowance;
use crate::disassembly::{DisassemblyPath, Gap, disassemble};
use crate::free_space::solids::Solids;
use crate::free_space::{Chain, mouth_of};
use crate::geometry::{AxisBox, Direction, Vector};
use crate::section_4::{CHANNELS, MALE};
use proptest::prelude::*;

mod blocked;
mod refusals;
mod robots;
mod scenes;
mod unions;
use scenes::{Crowd, corridors, crowd, solids_around};

const UP: Direction = Direction { axis: 1, sign: Sign::Positive };
const RIGHT: Direction = Direction { axis: 0, sign: Sign::Positive };

fn space<const D: usize>(min: [f64; D], max: [f64; D]) -> AxisBox<D> {
    AxisBox::new(min.into(), max.into()).expect("a box")
}

fn find<const D: usize, M: Mover<D> + Clone>(
    channels: &[AxisBox<D>],
    mover: &M,
) -> Result<(Vec<usize>, f64), RouteError> {
    let (mut graph, mut router) = (Graph::default(), Router::default());
    graph.build(channels, &Budget::default()).expect("few junctions");
    let result = router.find(&graph, &mut mover.clone(), &Budget::default());
    assert_eq!(router.route().is_empty(), result.is_err());
    result.map(|()| (router.route().to_vec(), router.length()))
}

fn body<const D: usize>(
    min: [f64; D],
    max: [f64; D],
    gap: Gap<'_, D>,
    end: End<D>,
) -> BodyMover<D> {
    BodyMover::new(&space(min, max), gap, end).expect("a traveller")
}

/// The body of most scenes, 1 m each way.
fn cube(x: f64, z: f64, end: End<2>) -> BodyMover<2> {
    body([x, z], [x + 1.0, z + 1.0], Gap::Uniform(0.1), end)
}

#[track_caller]
fn check<const D: usize, M: Mover<D> + Clone>(channels: &[AxisBox<D>], mover: &M, route: &[usize]) {
    let found = find(channels, mover);
    assert_eq!(found.expect("a route").0, route);
}

#[track_caller]
fn check_error<const D: usize, M: Mover<D> + Clone>(
    channels: &[AxisBox<D>],
    mover: &M,
    error: RouteError,
) {
    assert_eq!(find(channels, mover), Err(error));
}

/// C_1, C_2, C_3 of section 4.
fn section_4() -> [AxisBox<2>; 3] {
    let [c_3, c_2, c_1] = CHANNELS.map(|[min, max]| space(min, max));
    [c_1, c_2, c_3]
}

fn male(gap: Gap<'_, 2>) -> BodyMover<2> {
    body(MALE[0], MALE[1], gap, End::Exit(UP))
}

#[test]
fn section_4_is_put_in_order() {
    for (gap, length) in [
        (Gap::Uniform(0.01), 6.919200165541185),
        (Gap::Uniform(0.2), 7.40323366632768),
        (Gap::Safest, 8.50994224312348),
        (Gap::Fraction(1.0), 8.50994224312348),
    ] {
        let (route, found) = find(&section_4(), &male(gap)).expect("a route");
        assert_eq!(route, [2, 1, 0]);
        assert!((found - length).abs() < 1e-14, "{found}");
    }
}

#[test]
fn body_in_the_last_channel_goes_straight_out() {
    let (route, length) =
        find(&section_4(), &body([2., 3.], [3., 4.], Gap::Safest, End::Exit(UP))).expect("a route");
    assert_eq!((route, length), (vec![0], 4.0));
}

#[test]
fn start_may_lie_in_several_channels() {
    // In C_2 and C_3; from C_2 it is nearer.
    check(&section_4(), &body([5.5, 3.], [6.5, 4.], Gap::Uniform(0.1), End::Exit(UP)), &[1, 0]);
}

#[test]
fn shorter_way_wins_over_fewer_channels() {
    // To the right straight up a long detour, to the left four short ones.
    let channels = [
        space([0., 0.], [60., 2.]),
        space([58., 0.], [60., 12.]),
        space([0., 10.], [60., 12.]),
        space([0., 10.], [2., 20.]),
        space([4., 0.], [6., 5.]),
        space([0., 3.], [6., 5.]),
        space([0., 3.], [2., 8.]),
        space([0., 6.], [9., 8.]),
        space([7., 6.], [9., 12.]),
    ];
    check(&channels, &cube(8.5, 0.5, End::Exit(UP)), &[0, 4, 5, 6, 7, 8, 2, 3]);
    let without = &channels[..4];
    check(without, &cube(8.5, 0.5, End::Exit(UP)), &[0, 1, 2, 3]);
}

#[test]
fn equal_ways_are_decided_by_index() {
    // Two ways round an island, mirror images.
    let mut channels = [
        space([-1., 0.], [1., 4.]),
        space([-9., 2.], [9., 4.]),
        space([-9., 2.], [-7., 9.]),
        space([7., 2.], [9., 9.]),
        space([-9., 7.], [9., 9.]),
        space([-1., 7.], [1., 12.]),
    ];
    let traveller = body([-0.5, 0.5], [0.5, 1.5], Gap::Uniform(0.25), End::Exit(UP));
    check(&channels, &traveller, &[0, 1, 2, 4, 5]);
    channels.swap(2, 3);
    check(&channels, &traveller, &[0, 1, 2, 4, 5]);
}

#[test]
fn goal_in_several_channels_is_reached_the_shorter_way() {
    let channels =
        [space([0., 0.], [9., 2.]), space([7., 0.], [9., 9.]), space([2., 7.], [9., 9.])];
    check(&channels, &cube(0.5, 0.5, End::Goal([8., 8.].into())), &[0, 1]);
    check(&channels, &cube(0.5, 0.5, End::Goal([3., 8.].into())), &[0, 1, 2]);
    check(&channels, &cube(0.5, 0.5, End::Goal([8., 1.].into())), &[0]);
}

#[test]
fn route_in_three_dimensions_turns_twice() {
    let channels = [
        space([0., 7., 0.], [2., 9., 9.]),
        space([0., 0., 0.], [9., 2., 2.]),
        space([0., 0., 0.], [2., 9., 2.]),
    ];
    let up = Direction { axis: 2, sign: Sign::Positive };
    let traveller = body([7., 0.5, 0.5], [8., 1.5, 1.5], Gap::Uniform(0.2), End::Exit(up));
    check(&channels, &traveller, &[1, 2, 0]);
}

#[test]
fn robot_takes_the_shorter_corridor() {
    let channels = [
        space([0., 0.], [30., 3.]),
        space([10., 0.], [13., 20.]),
        space([25., 0.], [28., 20.]),
        space([0., 17.], [30., 20.]),
    ];
    let robot = |x, goal: [f64; 2]| {
        RobotMover::new([x, 1.5].into(), goal.into(), Vector::repeat(1.5), (1.0, 0.2))
    };
    check(&channels, &robot(3.0, [6., 18.]), &[0, 1, 3]);
    check(&channels, &robot(24.0, [29., 18.]), &[0, 2, 3]);
}

#[test]
fn smallest_junction_on_the_best_way_is_named() {
    // Two ways: one lacks 0.5 m at a junction, the other 0.2 m at one and 0.3 m at the next.
    let channels = [
        space([0., 0.], [20., 2.]),
        space([2., 0.], [2.5, 9.]),
        space([10., 0.], [10.8, 9.]),
        space([0., 7.], [20., 7.7]),
        space([18., 7.], [20., 20.]),
    ];
    let error = RouteError::JunctionTooSmall {
        first: 2,
        second: 3,
        junction: 1,
        axis: 1,
        needs: 1.0,
        has: 0.7000000000000002,
        others: 2,
    };
    check_error(&channels, &cube(5., 0.5, End::Exit(UP)), error);
}

#[test]
fn equally_large_junction_is_too_small() {
    let channels = [space([0., 0.], [9., 2.]), space([8., 0.], [9., 9.])];
    let (first, second, junction, others) = (0, 1, 0, 0);
    let (axis, needs, has) = (0, 1.0, 1.0);
    let error = RouteError::JunctionTooSmall { first, second, junction, axis, needs, has, others };
    check_error(&channels, &cube(1., 0.5, End::Exit(UP)), error);
}

#[test]
fn channels_that_touch_could_be_opened() {
    let channels = [space([0., 0.], [9., 2.]), space([5., 2.], [8., 9.])];
    let (first, second, junction, others) = (0, 1, 0, 0);
    let (axis, needs, has) = (1, 1.0, 0.0);
    let error = RouteError::JunctionTooSmall { first, second, junction, axis, needs, has, others };
    check_error(&channels, &cube(1., 0.5, End::Exit(UP)), error);
}

#[test]
fn gap_too_large_is_told_from_a_body_too_large() {
    let channels = [space([0., 0.], [9., 2.]), space([7.5, 0.], [9., 9.])];
    let traveller = |gap| body([1., 0.5], [2., 1.5], Gap::Uniform(gap), End::Exit(UP));
    check(&channels, &traveller(0.2), &[0, 1]);
    let error = |gap| RouteError::GapOutOfRange {
        first: 0,
        second: 1,
        junction: 0,
        axis: 0,
        gap,
        least: 0.0,
        most: 0.25,
    };
    check_error(&channels, &traveller(0.25), error(0.25));
    check_error(&channels, &traveller(0.3), error(0.3));
}

#[test]
fn gap_leads_another_way() {
    let channels =
        [space([0., 0.], [30., 2.]), space([7.5, 0.], [9., 9.]), space([20., 0.], [23., 9.])];
    let traveller = |gap| body([1., 0.5], [2., 1.5], Gap::Uniform(gap), End::Exit(UP));
    check(&channels, &traveller(0.2), &[0, 1]);
    check(&channels, &traveller(0.3), &[0, 2]);
}

#[test]
fn channels_without_a_turn_are_told() {
    let channels = [space([0., 0.], [9., 2.]), space([6., 0.], [20., 2.])];
    let error = RouteError::Parallel { first: 0, second: 1, axis: 0 };
    check_error(&channels, &cube(1., 0.5, End::Exit(RIGHT)), error);
}

#[test]
fn body_may_stick_out_of_the_mouth() {
    let channels = [space([0., 0.], [9., 2.]), space([7., 0.], [9., 9.])];
    for bottom in [8., 8.5, 9., 10.] {
        check(&channels, &cube(7.5, bottom, End::Exit(UP)), &[1]);
    }
}

#[test]
fn start_and_goal_outside_are_told() {
    let channels = [space([0., 0.], [9., 2.]), space([7., 0.], [9., 9.])];
    let error = RouteError::StartOutside { channel: 0, axis: 1, body: 2.5, end: 2.0 };
    check_error(&channels, &cube(1., 1.5, End::Exit(UP)), error);
    let error = RouteError::StartOutside { channel: 1, axis: 0, body: 9.5, end: 9.0 };
    check_error(&channels, &cube(8.5, 5., End::Exit(UP)), error);
    let error = RouteError::GoalOutside { channel: 1, axis: 1, goal: 9.5, end: 9.0 };
    check_error(&channels, &cube(1., 0.5, End::Goal([8., 9.5].into())), error);
    check_error(&[], &cube(1., 1.5, End::Exit(UP)), RouteError::NoChannels);
}

#[test]
fn gaps_that_make_no_route_are_rejected() {
    let cube = space([0., 0.], [1., 1.]);
    let check = |gap, error| assert_eq!(BodyMover::new(&cube, gap, End::Exit(UP)), Err(error));
    check(Gap::Uniform(0.0), RouteError::GapNotPositive { axis: 0, gap: 0.0, least: 0.0 });
    let error = RouteError::GapNotPositive { axis: 1, gap: -1.0, least: 0.0 };
    check(Gap::PerAxis([1.0, -1.0].into()), error);
    let three = [Vector::zeros(); 3];
    check(Gap::PerJunction(&three), RouteError::GapPerJunction { has: 3 });
    let error = RouteError::FractionOutOfRange { fraction: 1.5, least: 0.0, most: 1.0 };
    check(Gap::Fraction(1.5), error);
    assert!(BodyMover::new(&cube, Gap::Uniform(f64::NAN), End::Exit(UP)).is_err());
}

#[test]
fn memory_is_as_documented() {
    assert!(size_of::<Label<Vector<2>>>() + size_of::<Entry>() <= 8 * 2 + 56);
    assert!(size_of::<Label<Vector<3>>>() + size_of::<Entry>() <= 8 * 3 + 56);
    assert!(size_of::<Label<driving::Passing>>() + size_of::<Entry>() <= 104);
}

#[test]
fn steps_and_junctions_are_capped() {
    let mut graph = Graph::default();
    let limits = Allowance { junctions: 3, route_steps: 3, ..Allowance::NONE };
    let budget = Budget::new(limits);
    graph.build(&section_4(), &budget).expect("3 junctions");
    assert_eq!(graph.junctions(), 3);
    assert_eq!(graph.neighbours(1).collect::<Vec<_>>(), [0, 2]);
    let mut router = Router::default();
    let mut male = male(Gap::Safest);
    let result = router.find(&graph, &mut male, &budget);
    assert_eq!(result, Err(Spent::Limit { cap: Cap::RouteSteps, most: 3 }.into()));
    let few = Budget::new(Allowance { junctions: 2, ..limits });
    assert_eq!(graph.build(&section_4(), &few), Err(Spent::Limit { cap: Cap::Junctions, most: 2 }));
    assert_eq!(few.drawn(Cap::Bytes), 0);
    assert_eq!(graph.channels(), []);
}

/// The length by the rules along a route, if it makes a chain that the body passes.
fn length_along<const D: usize>(crowd: &Crowd<D>, route: &[usize], gap: Gap<'_, D>) -> Option<f64> {
    let channels: Vec<_> = route.iter().map(|index| crowd.channels[*index]).collect();
    let (mut chain, mut path) = (Chain::default(), DisassemblyPath::default());
    chain.build(&channels, &crowd.body.center(), End::Exit(crowd.exit), &Budget::default()).ok()?;
    disassemble(&chain, &crowd.body, gap, &mut path, &Budget::default()).ok()?;
    Some(path.length())
}

/// The least length over all ways of up to `most` channels that do not go straight
/// back, and over those that pass no channel twice, looked at one by one.
fn brute_force<const D: usize>(crowd: &Crowd<D>, gap: Gap<'_, D>, most: usize) -> (f64, f64) {
    let mouth = farthest(&crowd.channels, crowd.exit);
    let meet =
        |a: usize, b: usize| a != b && crowd.channels[a].intersection(&crowd.channels[b]).is_some();
    let mut least = (f64::INFINITY, f64::INFINITY);
    let mut routes: Vec<Vec<usize>> = (0..crowd.channels.len())
        .filter(|index| crowd.channels[*index].contains(&crowd.body))
        .map(|index| vec![index])
        .collect();
    while let Some(route) = routes.pop() {
        let last = route[route.len() - 1];
        if Some(mouth_of(&crowd.channels[last], crowd.exit)) == mouth
            && let Some(length) = length_along(crowd, &route, gap)
        {
            least.0 = least.0.min(length);
            if is_simple(&route) {
                least.1 = least.1.min(length);
            }
        }
        if route.len() == most {
            continue;
        }
        for next in 0..crowd.channels.len() {
            let back = route.len() > 1 && route[route.len() - 2] == next;
            if meet(last, next) && !back {
                routes.push(route.iter().copied().chain([next]).collect());
            }
        }
    }
    least
}

fn is_simple(route: &[usize]) -> bool {
    (1..route.len()).all(|index| !route[..index].contains(&route[index]))
}

/// The route is as long as its chain, and no other is shorter.
fn check_shortest<const D: usize>(crowd: &Crowd<D>, gap: Gap<'_, D>, most: usize) {
    let end = End::Exit(crowd.exit);
    let traveller = BodyMover::new(&crowd.body, gap, end).expect("a traveller");
    let (least, simple) = brute_force(crowd, gap, most);
    match find(&crowd.channels, &traveller) {
        Ok((route, length)) => {
            assert_eq!(length_along(crowd, &route, gap), Some(length), "{route:?}");
            assert!(length <= least + 1e-9, "{route:?}: {length} > {least}");
            if route.len() <= most {
                assert!((length - least).abs() < 1e-9, "{route:?}: {length} < {least}");
            }
            if is_simple(&route) && route.len() <= most {
                assert!((length - simple).abs() < 1e-9);
            }
        }
        Err(error) => assert!(least.is_infinite(), "{error}"),
    }
}

fn gaps<const D: usize>() -> impl Strategy<Value = Gap<'static, D>> {
    prop_oneof![
        Just(Gap::Uniform(0.05)),
        Just(Gap::Uniform(0.3)),
        Just(Gap::Fraction(0.5)),
        Just(Gap::Safest),
    ]
}

fn check_chain_from_its_walls<const D: usize>(
    crowd: &Crowd<D>,
    gap: f64,
) -> Result<(), TestCaseError> {
    let gap = Gap::Uniform(gap);
    let all: Vec<_> = (0..crowd.channels.len()).collect();
    let Some(expected) = length_along(crowd, &all, gap) else { return Ok(()) };
    let mut solids = Solids::default();
    let bounds = solids_around(crowd, &mut solids);
    let mut channels = Vec::new();
    let found = solids.channels(&bounds, &crowd.body.size(), &Budget::default(), &mut channels);
    found.expect("few channels");
    let mouth = farthest(&crowd.channels, crowd.exit);
    let ends = crowd.channels.iter().filter(|c| Some(mouth_of(*c, crowd.exit)) == mouth);
    let ends_there = mouth == crowd.channels.last().map(|c| mouth_of(c, crowd.exit));
    let same = channels.len() == crowd.channels.len()
        && (ends_there && ends.count() == 1)
        // It does not cross itself.
        && (2..channels.len()).all(|index| {
            let earlier = &crowd.channels[..index - 1];
            earlier.iter().all(|c| c.intersection(&crowd.channels[index]).is_none())
        })
        && crowd.channels.iter().all(|channel| channels.contains(channel));
    let end = End::Exit(crowd.exit);
    let traveller = BodyMover::new(&crowd.body, gap, end).expect("a traveller");
    let (route, length) = find(&channels, &traveller).expect("a route");
    if same {
        let along: Vec<_> = route.iter().map(|index| channels[*index]).collect();
        prop_assert_eq!(&along, &crowd.channels);
        prop_assert_eq!(length, expected);
    }
    // All of the chain's channels are among those found: the way is no longer.
    if ends_there && crowd.channels.iter().all(|channel| channels.contains(channel)) {
        prop_assert!(length <= expected + 1e-9);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn no_way_is_shorter_in_two_dimensions(crowd in crowd::<2>(7), gap in gaps()) {
        check_shortest(&crowd, gap, 6);
    }

    #[test]
    fn no_way_is_shorter_in_three_dimensions(crowd in crowd::<3>(7), gap in gaps()) {
        check_shortest(&crowd, gap, 5);
    }

    #[test]
    fn walls_of_a_chain_lead_along_the_chain(crowd in corridors::<2>(6), gap in 0.01..0.05f64) {
        check_chain_from_its_walls(&crowd, gap)?;
    }

    #[test]
    fn walls_of_a_chain_lead_along_the_chain_in_three_dimensions(crowd in corridors::<3>(5), gap in 0.01..0.05f64) {
        check_chain_from_its_walls(&crowd, gap)?;
    }
}
