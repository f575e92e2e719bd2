//! Refusals when solids block the way.

use super::*;

fn with_boxes<const D: usize>(boxes: &[AxisBox<D>]) -> Solids<D> {
    let mut solids = Solids::default();
    boxes.iter().for_each(|solid| solids.push_box(*solid, &Budget::default()).unwrap());
    solids
}

fn all_boxes<const D: usize>(
    solids: &mut Solids<D>,
    bounds: &AxisBox<D>,
    room: &Vector<D>,
) -> Vec<AxisBox<D>> {
    let mut boxes = Vec::new();
    solids.channels(bounds, room, &Budget::default(), &mut boxes).expect("few boxes");
    boxes
}

const BOUNDS: ([f64; 2], [f64; 2]) = ([0., 0.], [8., 6.]);

/// A robot that needs 1 m, and 2 m to turn.
fn look(solids: &[AxisBox<2>], start: [f64; 2], goal: [f64; 2]) -> Option<Blocked<2>> {
    let bounds = space(BOUNDS.0, BOUNDS.1);
    let boxes = all_boxes(&mut with_boxes(solids), &bounds, &Vector::zeros());
    let robot = RobotMover::new(start.into(), goal.into(), Vector::repeat(2.0), (1.0, 0.2));
    blocked(&boxes, &bounds, &Vector::repeat(1.0), robot.traveller(), &Budget::default()).unwrap()
}

fn place(min: [f64; 2], max: [f64; 2]) -> Region<2> {
    Region { min: min.into(), max: max.into() }
}

#[track_caller]
fn check_narrow(
    blocked: Option<Blocked<2>>,
    place: Region<2>,
    axis: usize,
    has: f64,
    others: usize,
) {
    let Some(Blocked::Narrow { passage, others: found, .. }) = blocked else {
        panic!("{blocked:?}")
    };
    assert_eq!(passage, Passage { place, axis, needs: 2.0, has });
    assert_eq!(found, others);
}

#[test]
fn door_is_the_part_between_its_rooms() {
    let solids = [space([4., 0.], [4.5, 2.]), space([4., 3.25], [4.5, 6.])];
    let door = place([4., 2.], [4.5, 3.25]);
    check_narrow(look(&solids, [2., 5.], [6., 1.]), door, 1, 1.25, 0);
    // From within the doorway, and along it.
    check_narrow(look(&solids, [4.25, 2.5], [6., 1.]), door, 1, 1.25, 0);
    check_narrow(look(&solids, [2., 5.], [6., 2.5]), door, 1, 1.25, 0);
}

#[test]
fn solids_corner_to_corner_leave_a_line_or_what_they_overlap_in() {
    let solids = [space([0., 3.], [3., 6.]), space([4.5, 0.], [8., 3.])];
    let blocked = look(&solids, [1., 1.], [7., 5.]);
    check_narrow(blocked, place([3., 3.], [4.5, 3.]), 0, 1.5, 0);
    let solids = [space([0., 2.5], [3., 6.]), space([4.5, 0.], [8., 3.])];
    let blocked = look(&solids, [1., 1.], [7., 5.]);
    check_narrow(blocked, place([3., 2.5], [4.5, 3.]), 0, 1.5, 0);
    let solids = [space([0., 3.], [3., 6.]), space([4.5, 0.], [8., 2.])];
    let blocked = look(&solids, [1., 1.], [7., 5.]);
    check_narrow(blocked, place([3., 0.], [4.5, 6.]), 0, 1.5, 0);
}

#[test]
fn every_narrow_place_is_counted_once() {
    let solids = [
        space([2., 0.], [2.5, 2.]),
        space([2., 3.25], [2.5, 6.]),
        space([5.5, 0.], [6., 3.]),
        space([5.5, 4.], [6., 6.]),
    ];
    let blocked = look(&solids, [1., 5.], [7., 1.]);
    check_narrow(blocked, place([5.5, 3.], [6., 4.]), 1, 1.0, 1);
}

#[test]
fn thinnest_wall_is_passed() {
    let solids = [space([3., 0.], [3.5, 6.]), space([5., 0.], [5.25, 6.])];
    let blocked = look(&solids, [1., 1.], [7., 1.]);
    let Some(Blocked::Wall { place: at, axis, thickness, others, junction, .. }) = blocked else {
        panic!("{blocked:?}")
    };
    assert_eq!((at, axis, thickness), (place([3., 0.], [3.5, 6.]), 0, 0.5));
    assert_eq!((junction, others), (0, 1));
    // Round about, the walls are thinner.
    let solids = [
        space([3., 0.], [4., 6.]),
        space([0., 2.], [3., 2.25]),
        space([4., 2.], [8., 2.25]),
        space([3., 4.], [4., 4.125]),
    ];
    let blocked = look(&solids, [1., 1.], [7., 1.]);
    assert!(
        matches!(blocked, Some(Blocked::Wall { thickness: 1.0, others: 0, .. })),
        "{blocked:?}"
    );
}

#[test]
fn nothing_is_said_where_nothing_is_in_the_way() {
    assert_eq!(look(&[], [1., 1.], [7., 1.]), None);
    let solids = [space([4., 0.], [4.5, 2.]), space([4., 4.25], [4.5, 6.])];
    assert_eq!(look(&solids, [2., 5.], [6., 1.]), None);
}

#[test]
fn places_that_are_taken_are_told() {
    let solids = [space([4., 0.], [4.5, 2.])];
    let at = place([4.25, 1.], [4.25, 1.]);
    assert_eq!(look(&solids, [4.25, 1.], [6., 1.]), Some(Blocked::StartTaken(at)));
    assert_eq!(look(&solids, [6., 1.], [4.25, 1.]), Some(Blocked::GoalTaken(at)));
}

/// Whether a body that is smaller by `less` on every axis gets out, told from the
/// channels that it has.
fn gets_out<const D: usize>(
    solids: &mut Solids<D>,
    bounds: &AxisBox<D>,
    body: &AxisBox<D>,
    exit: Direction,
    less: f64,
) -> bool {
    let size = body.size().add_scalar(-less);
    // Beyond the mouth all is free.
    let (mut min, mut max) = (bounds.min(), bounds.max());
    match exit.sign {
        Sign::Negative => min[exit.axis] -= 2.0,
        Sign::Positive => max[exit.axis] += 2.0,
    }
    let bounds = &AxisBox::new(min, max).expect("a box");
    let channels = all_boxes(solids, bounds, &size);
    let is_larger = |part: &AxisBox<D>| (0..D).all(|axis| part.size()[axis] > size[axis]);
    let mut reached: Vec<bool> = channels.iter().map(|channel| channel.contains(body)).collect();
    loop {
        let next = (0..channels.len()).find(|next| {
            let meets = |one: usize| {
                let common = channels[one].intersection(&channels[*next]);
                reached[one] && common.is_some_and(|common| is_larger(&common))
            };
            !reached[*next] && (0..channels.len()).any(meets)
        });
        match next {
            Some(next) => reached[next] = true,
            None => break,
        }
    }
    let at_mouth = |channel: &AxisBox<D>| mouth_of(channel, exit) == mouth_of(bounds, exit);
    channels.iter().zip(&reached).any(|(channel, reached)| *reached && at_mouth(channel))
}

/// Solids on a grid of 1/4 m around a body of 1 m, and an exit.
fn cavity<const D: usize>(
    most: usize,
) -> impl Strategy<Value = (Vec<AxisBox<D>>, AxisBox<D>, Direction)> {
    let corner = proptest::array::uniform::<_, D>(-2..24i8);
    let size = proptest::array::uniform::<_, D>(1..14i8);
    let solids = proptest::collection::vec((corner, size), 0..=most);
    (solids, proptest::array::uniform::<_, D>(0..20i8), 0..D, any::<bool>()).prop_map(
        |(solids, at, axis, positive)| {
            let number = |value: [i8; D]| Vector::from(value.map(|value| f64::from(value) / 4.0));
            let body = AxisBox::new(number(at), number(at).add_scalar(1.0)).expect("a box");
            let solids = solids.iter().map(|(corner, size)| {
                AxisBox::new(number(*corner), number(*corner) + number(*size)).expect("a box")
            });
            let solids = solids.filter(|solid| solid.intersection(&body).is_none()).collect();
            let sign = if positive { Sign::Positive } else { Sign::Negative };
            (solids, body, Direction { axis, sign })
        },
    )
}

/// A body that is smaller by what is missing, and a little, gets out; otherwise not.
fn check_missing<const D: usize>(
    boxes: &[AxisBox<D>],
    body: &AxisBox<D>,
    exit: Direction,
) -> Result<(), TestCaseError> {
    let bounds = AxisBox::new(Vector::zeros(), Vector::repeat(6.0)).expect("a box");
    let boxes: Vec<_> = boxes.iter().filter_map(|solid| solid.intersection(&bounds)).collect();
    let mut solids = with_boxes(&boxes);
    let all = all_boxes(&mut solids, &bounds, &Vector::zeros());
    let body_out = BodyMover::new(body, Gap::Safest, End::Exit(exit)).expect("a traveller");
    let found =
        blocked(&all, &bounds, &body.size(), body_out.traveller(), &Budget::default()).unwrap();
    const LITTLE: f64 = 1.0 / 64.0;
    match found {
        None => prop_assert!(gets_out(&mut solids, &bounds, body, exit, 0.0)),
        Some(Blocked::Narrow { passage, .. }) => {
            let missing = passage.needs - passage.has;
            prop_assert_eq!(passage.needs, 1.0);
            prop_assert!(missing >= 0.0);
            prop_assert!(!gets_out(&mut solids, &bounds, body, exit, missing));
            prop_assert!(gets_out(&mut solids, &bounds, body, exit, missing + LITTLE));
            // The place is free, and as wide as it is said to be.
            let Region { min, max } = passage.place;
            prop_assert_eq!(max[passage.axis] - min[passage.axis], passage.has);
            if let Ok(place) = AxisBox::new(min, max) {
                prop_assert!(boxes.iter().all(|solid| solid.intersection(&place).is_none()));
            }
        }
        Some(Blocked::Wall { place, axis, thickness, .. }) => {
            prop_assert!(!gets_out(&mut solids, &bounds, body, exit, 1.0 - LITTLE));
            prop_assert_eq!(place.max[axis] - place.min[axis], thickness);
        }
        Some(Blocked::NoRoom(passage)) => {
            prop_assert!(passage.needs == 1.0 && passage.has <= 1.0);
            let has_room = |free: &AxisBox<D>| (0..D).all(|axis| free.size()[axis] > 1.0);
            prop_assert!(!all.iter().any(has_room));
        }
        other => prop_assert!(false, "{:?}", other),
    }
    Ok(())
}

/// What the body fills up to the mouth is no room, even though all is free beyond it.
#[test]
fn place_that_a_body_fills_has_no_room() -> Result<(), TestCaseError> {
    let solids = [space([0.0, 1.0], [6.0, 6.0])];
    let body = space([0.0, 0.0], [1.0, 1.0]);
    for sign in [Sign::Negative, Sign::Positive] {
        check_missing(&solids, &body, Direction { axis: 1, sign })?;
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn body_smaller_by_what_is_missing_gets_out_in_two_dimensions((solids, body, exit) in cavity::<2>(14)) {
        check_missing(&solids, &body, exit)?;
    }

    #[test]
    fn body_smaller_by_what_is_missing_gets_out_in_three_dimensions((solids, body, exit) in cavity::<3>(14)) {
        check_missing(&solids, &body, exit)?;
    }
}
