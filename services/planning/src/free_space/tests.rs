use super::random::scenes;
use super::*;
use crate::section_4::CHANNELS;
use proptest::prelude::*;

fn space<const D: usize>(min: [f64; D], max: [f64; D]) -> AxisBox<D> {
    AxisBox::new(min.into(), max.into()).expect("a box")
}

const fn to(axis: usize, sign: Sign) -> Direction {
    Direction { axis, sign }
}

const EXIT: End<2> = End::Exit(to(1, Sign::Positive));

/// The channels of section 4 of the paper.
fn section_4() -> [AxisBox<2>; 3] {
    CHANNELS.map(|[min, max]| space(min, max))
}

fn build<const D: usize>(
    channels: &[AxisBox<D>],
    start: [f64; D],
    end: End<D>,
) -> Result<Chain<D>, ChainError> {
    let mut chain = Chain::default();
    chain.build(channels, &start.into(), end, &Budget::default())?;
    Ok(chain)
}

#[track_caller]
fn check_axes<const D: usize>(
    channels: &[AxisBox<D>],
    start: [f64; D],
    end: End<D>,
    axes: &[usize],
) {
    let chain = build(channels, start, end).expect("a chain");
    assert_eq!(chain.axes(), axes);
}

#[track_caller]
fn check_error<const D: usize>(channels: &[AxisBox<D>], end: End<D>, error: ChainError) {
    assert_eq!(build(channels, [0.0; D], end).unwrap_err(), error);
}

#[test]
fn half_spaces_are_closed() {
    let above = HalfSpace { side: to(1, Sign::Positive), bound: 2.0 };
    let below = HalfSpace { side: to(1, Sign::Negative), bound: 2.0 };
    let at = |z| Vector::from([9.0, z]);
    assert!(above.contains(&at(2.0)) && below.contains(&at(2.0)));
    assert!(above.contains(&at(3.0)) && !below.contains(&at(3.0)));
    assert!(!above.contains(&at(1.0)) && below.contains(&at(1.0)));
}

#[test]
fn section_4_has_the_junctions_of_the_paper() {
    let chain = build(&section_4(), [5.745, 2.505], EXIT).expect("a chain");
    let (up, left) = (to(1, Sign::Positive), to(0, Sign::Negative));
    assert_eq!(
        chain.junctions(),
        [
            Junction { space: space([4., 2.], [7., 6.]), approach: up, leaving: left },
            Junction { space: space([1., 2.], [5., 6.]), approach: left, leaving: up },
        ]
    );
    assert_eq!(chain.axes(), [1, 0, 1]);
    assert_eq!(chain.mouth(), Some(HalfSpace { side: to(1, Sign::Negative), bound: 7.0 }));
}

#[test]
fn one_channel_has_no_junction() {
    let chain = build(&section_4()[..1], [5.0, 2.0], EXIT).expect("a chain");
    assert_eq!((chain.junctions(), chain.axes()), (&[][..], &[1][..]));
}

#[test]
fn axis_is_not_the_longer_side() {
    // Taller than wide, yet run through sideways.
    let channels = [
        space([0., 0.], [2., 9.]),
        space([0., 1.], [4., 8.]),
        space([2., 1.], [4., 20.]),
        space([2., 15.], [9., 20.]),
    ];
    check_axes(&channels, [1.0, 1.0], End::Exit(to(0, Sign::Positive)), &[1, 0, 1, 0]);
}

#[test]
fn greatest_distance_decides_between_two_candidates() {
    // A wide channel in three dimensions: both ends are proper parts in x and y.
    let channels = [
        space([0., 0., 0.], [2., 2., 9.]),
        space([0., 0., 7.], [9., 30., 9.]),
        space([6., 20., 0.], [8., 22., 9.]),
    ];
    check_axes(&channels, [1., 1., 1.], End::Exit(to(2, Sign::Negative)), &[2, 1, 2]);
}

#[test]
fn lowest_axis_wins_a_tie() {
    let channels = [
        space([0., 0., 0.], [2., 2., 9.]),
        space([0., 0., 7.], [9., 9., 9.]),
        space([6., 6., 0.], [8., 8., 9.]),
    ];
    check_axes(&channels, [1., 1., 1.], End::Exit(to(2, Sign::Negative)), &[2, 0, 2]);
}

#[test]
fn channel_inside_its_neighbour_has_any_axis() {
    let channels = [space([3., 3.], [5., 5.]), space([0., 0.], [9., 9.])];
    check_axes(&channels, [4., 4.], EXIT, &[0, 1]);
    check_axes(&channels, [4., 4.], End::Exit(to(0, Sign::Positive)), &[1, 0]);
}

#[test]
fn exit_overrules_the_candidates_of_the_last_channel() {
    let l_turn = [space([0., 0.], [2., 9.]), space([0., 7.], [9., 9.])];
    check_axes(&l_turn, [1., 1.], End::Exit(to(0, Sign::Positive)), &[1, 0]);
    let error = ChainError::Parallel { first: 0, second: 1, axis: 1 };
    check_error(&l_turn, EXIT, error);
}

#[test]
fn goal_decides_the_last_direction() {
    let l_turn = [space([0., 0.], [2., 9.]), space([0., 7.], [9., 9.])];
    let chain = build(&l_turn, [1., 1.], End::Goal([8., 8.].into())).expect("a chain");
    assert_eq!(chain.exit(), Some(to(0, Sign::Positive)));
    assert_eq!(chain.junctions()[0].leaving, to(0, Sign::Positive));
    // A goal straight ahead in a room: the corridor's axis is taken.
    let room = [space([0., 4.], [11., 6.]), space([10., 0.], [30., 20.])];
    let chain = build(&room, [1., 5.], End::Goal([28., 5.5].into())).expect("a chain");
    assert_eq!(chain.axes(), [0, 1]);
}

#[test]
fn no_channel_is_rejected() {
    check_error::<2>(&[], EXIT, ChainError::Empty);
}

#[test]
fn channels_apart_are_rejected() {
    let channels = [space([0., 0.], [2., 9.]), space([3., 7.], [9., 9.])];
    let error = ChainError::Apart { first: 0, second: 1, axis: 0, end: 2.0, begin: 3.0 };
    check_error(&channels, EXIT, error);
    assert_eq!(
        error.to_string(),
        "channels 0 and 1 do not overlap along coordinate 0: one ends at 2, the other begins at 3"
    );
}

#[test]
fn channels_that_only_touch_are_rejected() {
    let channels = [space([0., 0.], [2., 9.]), space([0., 9.], [9., 11.])];
    let error = ChainError::Apart { first: 0, second: 1, axis: 1, end: 9.0, begin: 9.0 };
    check_error(&channels, EXIT, error);
}

#[test]
fn parallel_channels_are_rejected() {
    let channels =
        [space([0., 0.], [9., 2.]), space([8., 0.], [20., 2.]), space([18., 0.], [20., 9.])];
    check_error(&channels, EXIT, ChainError::Parallel { first: 0, second: 1, axis: 0 });
}

#[test]
fn failed_chain_is_empty() {
    let mut chain = build(&section_4(), [5.745, 2.505], EXIT).expect("a chain");
    chain.build(&[], &Vector::zeros(), EXIT, &Budget::default()).unwrap_err();
    assert_eq!((chain.channels(), chain.axes(), chain.exit()), (&[][..], &[][..], None));
    assert_eq!((chain.junctions(), chain.mouth()), (&[][..], None));
}

/// Directions that the construction of a random chain knows are found again.
fn check_directions<const D: usize>(scene: &super::random::Scene<D>) {
    let chain = build(&scene.channels, scene.body.center().into(), End::Exit(scene.exit));
    let chain = chain.expect("a chain");
    for (index, junction) in chain.junctions().iter().enumerate() {
        assert_ne!(junction.approach.axis, junction.leaving.axis);
        assert_eq!(junction.approach.axis, chain.axes()[index]);
        assert_eq!(junction.leaving.axis, chain.axes()[index + 1]);
        if let Some(after) = chain.junctions().get(index + 1) {
            assert_eq!(junction.leaving, after.approach);
            assert!(
                junction.leaving.coordinate(&junction.space.center())
                    < junction.leaving.coordinate(&after.space.center())
            );
        }
    }
    assert_eq!(chain.exit(), Some(scene.exit));
}

proptest! {
    #[test]
    fn consecutive_directions_fit_together_in_two_dimensions(scene in scenes::<2>(12)) {
        check_directions(&scene);
    }

    #[test]
    fn consecutive_directions_fit_together_in_three_dimensions(scene in scenes::<3>(12)) {
        check_directions(&scene);
    }
}
