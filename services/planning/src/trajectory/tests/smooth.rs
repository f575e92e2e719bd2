//! Corners of continuous curvature: no limit is exceeded, no clearance lost, and ends stay.

use super::*;
use crate::clearance::rectangle::{Footprint, clearance_rectangle_pose, nearest_along};
use crate::clearance::translating::{Body, clearance_body_legs};
use crate::free_space::walls::Walls;
use crate::geometry::AxisBox;

fn robot() -> Footprint {
    Footprint::offset(0.6, 0.7, 0.3).unwrap()
}

fn smoothed(legs: &[Leg<2>], walls: &Walls<2>, limits: &Limits, least: f64) -> SmoothedDrive {
    let footprint = robot();
    let task = SmoothDriving { footprint: &footprint, walls, limits, min_turn_radius: least };
    smooth_drive(&task, legs, &Budget::default()).unwrap()
}

fn least_clearance(legs: &[Leg<2>], walls: &Walls<2>) -> f64 {
    let mut least = f64::INFINITY;
    nearest_along::<crate::budget::Spent>(
        &robot(),
        legs,
        walls,
        &Budget::default(),
        |_, met, _| {
            least = least.min(met.value);
            Ok(())
        },
    )
    .unwrap();
    least
}

/// Walls around boxes.
fn walls_of(boxes: &[([f64; 2], [f64; 2])]) -> Walls<2> {
    let mut walls = Walls::default();
    for (corner, size) in boxes {
        let corner = Vector::from(*corner);
        walls.push_box(&AxisBox::new(corner, corner + Vector::from(*size)).unwrap());
    }
    walls
}

fn any_boxes() -> impl Strategy<Value = Vec<([f64; 2], [f64; 2])>> {
    let corner = prop::array::uniform2(-12.0..12.0_f64);
    prop::collection::vec((corner, prop::array::uniform2(0.1..3.0_f64)), 1..6)
}

fn any_drive() -> impl Strategy<Value = Vec<Leg<2>>> {
    let sweep = prop_oneof![-2.8..-0.05_f64, 0.05..2.8_f64, Just(FRAC_PI_2)];
    let line = prop_oneof![9 => 0.2..4.0_f64, 1 => Just(0.0)];
    (
        -2.0..2.0_f64,
        prop::collection::vec(line, 4),
        prop::collection::vec((0.31..2.0_f64, sweep), 3),
    )
        .prop_map(|(turn, lines, arcs)| drive(turn, &lines, &arcs, -turn))
}

/// By hand: in the open a right angle of radius 1 m gives way to two clothoids that begin outside of
/// the arc and pass its middle.
#[test]
fn right_angle_gives_way_to_clothoids() {
    let legs = drive(0.0, &[4.0, 4.0], &[(1.0, FRAC_PI_2)], 0.0);
    let limits = Limits::new(1.0, 0.5, 1.0, 1.0, 0.5).unwrap();
    let SmoothedDrive { legs: made, clearance, .. } =
        smoothed(&legs, &Walls::default(), &limits, 0.0);
    let clothoids = made.iter().filter(|leg| matches!(leg.curve, Curve::Clothoid { .. })).count();
    assert_eq!((clothoids, clearance), (2, None), "{made:?}");
    // It is driven without a stop, and faster than from stop to stop.
    let profile = planned(&made, &limits, Stops::AtJoints);
    assert_eq!(profile.yaw_jumps(&made), None);
    assert_eq!(profile.stops_on_the_way(&made, Stops::AtJoints), 0);
    let stopping = planned(&legs, &limits, Stops::AtJoints);
    assert_eq!(stopping.stops_on_the_way(&legs, Stops::AtJoints), 2);
    assert!(profile.duration() < stopping.duration() - 1.0);
}

#[test]
fn least_turn_radius_is_kept() {
    let legs = drive(0.0, &[4.0, 4.0], &[(1.0, FRAC_PI_2)], 0.0);
    for least in [0.5, 0.9, 1.0] {
        let made = smoothed(&legs, &Walls::default(), &Limits::default(), least).legs;
        for leg in made.iter().filter(|leg| !matches!(leg.curve, Curve::Turn { .. })) {
            let [first, last] = leg.curve.curvatures();
            assert!(first.abs().max(last.abs()) * least <= 1.0 + 1e-12, "{leg:?}");
        }
    }
}

/// A robot that touches the corner that it turns about has no room: the arc stays, and it stops.
#[test]
fn arc_without_room_stays() {
    let legs = drive(0.0, &[4.0, 4.0], &[(1.0, FRAC_PI_2)], 0.0);
    let Curve::Arc { center, .. } = legs[2].curve else { panic!("{legs:?}") };
    // All around what the robot sweeps on the arc, 1e-10 m away.
    let mut walls = Walls::default();
    walls.push(crate::free_space::walls::Wall { from: center, to: center });
    let within = least_clearance(&legs, &walls);
    assert!((within - 0.7).abs() < 1e-12);
    let outer = (0..200).map(|step| f64::from(step) * 0.0314);
    let radius = libm::sqrt(1.3 * 1.3 + 0.7 * 0.7) + 1e-3;
    for angle in outer {
        let at = center + crate::geometry::unit(angle) * radius;
        let next = center + crate::geometry::unit(angle + 0.0314) * radius;
        if at.x > center.x - 0.2 || at.y < center.y + 0.2 {
            walls.push(crate::free_space::walls::Wall { from: at, to: next });
        }
    }
    let made = smoothed(&legs, &walls, &Limits::default(), 0.0);
    let before = least_clearance(&legs, &walls);
    assert!(made.clearance.unwrap().value >= before - 1e-9);
}

/// Checks the samples of a motion by differences: of the heading and the place as well as of their
/// rates.
fn check_driven(profile: &Profile, legs: &[Leg<2>], limits: &Limits) {
    let sampling = Sampling::period(0.004).unwrap();
    let mut last: Option<State<2>> = None;
    for state in profile.samples(legs, sampling) {
        assert!(state.yaw_rate.abs() <= limits.yaw_rate() + 1e-9, "{state:?}");
        assert!(state.velocity.norm() <= limits.speed() + 1e-9, "{state:?}");
        if let Some(last) = last.filter(|last| state.time - last.time > 1e-5) {
            let dt = state.time - last.time;
            let within = |change: f64, most: f64, what: &str| {
                assert!(
                    change.abs() <= most * dt * (1.0 + 1e-9) + 1e-9,
                    "{what}: {last:?} {state:?}"
                );
            };
            within(state.yaw_rate - last.yaw_rate, limits.yaw_acceleration(), "yaw acceleration");
            let speeds = state.velocity.norm() - last.velocity.norm();
            within(speeds, limits.acceleration(), "acceleration");
            let most = libm::hypot(limits.acceleration(), limits.lateral_acceleration());
            within((state.velocity - last.velocity).norm(), most, "acceleration in all");
            // Rates are those of what they are rates of.
            let mean = 0.5 * (state.velocity + last.velocity);
            let off = (state.position - last.position - mean * dt).norm();
            assert!(off <= 0.5 * most * dt * dt + 1e-9, "{last:?} {state:?}");
            let turned = wrapped(state.heading - last.heading);
            let off = turned - 0.5 * (state.yaw_rate + last.yaw_rate) * dt;
            assert!(off.abs() <= 0.5 * limits.yaw_acceleration() * dt * dt + 1e-9);
        }
        last = Some(state);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Whatever the limits and the walls: limits are kept by differences of samples, the robot stays
    /// farther from the walls than the motion says, which is no nearer than before, and it arrives
    /// where it did.
    #[test]
    fn smooth_drive_keeps_limits_clearance_and_ends(
        legs in any_drive(), boxes in any_boxes(), limits in any_limits(),
    ) {
        let walls = walls_of(&boxes);
        let before = least_clearance(&legs, &walls);
        let made = smoothed(&legs, &walls, &limits, 0.0);
        let claimed = made.clearance.unwrap().value;
        prop_assert!(claimed >= before - 2e-9 || before == 0.0, "{claimed} {before}");
        prop_assert_eq!(made.leg_clearances.len(), made.legs.len());
        let profile = planned(&made.legs, &limits, Stops::AtJoints);
        prop_assert!(profile.duration().is_finite());
        check_driven(&profile, &made.legs, &limits);
        for pair in made.legs.windows(2) {
            let [one, next] = [&pair[0].curve, &pair[1].curve];
            prop_assert!((one.end() - next.start()).norm() < 1e-12);
            prop_assert!(wrapped(one.end_heading() - next.start_heading()).abs() < 1e-12);
        }
        let ends = |legs: &[Leg<2>]| {
            let (first, last) = (legs[0].curve, legs[legs.len() - 1].curve);
            [first.start(), last.end()]
        };
        prop_assert_eq!(ends(&made.legs), ends(&legs));
        for state in profile.samples(&made.legs, Sampling::period(0.05).unwrap()) {
            let near = clearance_rectangle_pose(
                &robot(), &state.position, state.heading, &walls, &Budget::default(),
            );
            let near = near.unwrap().unwrap().value;
            prop_assert!(near >= claimed - 1e-11, "{} at {:?}, said {}", near, state, claimed);
        }
    }

    /// The same for parts: of what the velocity and the acceleration are as vectors.
    #[test]
    fn smooth_way_points_keep_limits_clearance_and_ends(
        points in prop::collection::vec(prop::array::uniform2(-6.0..6.0_f64), 3..6),
        boxes in any_boxes(), speed in 0.2..2.0_f64, acceleration in 0.2..2.0_f64,
        jerk in prop::option::of(0.2..8.0_f64),
    ) {
        let body = AxisBox::new([-0.2, -0.3].into(), [0.4, 0.1].into()).unwrap();
        let body = Body::from_box(&body);
        let walls = walls_of(&boxes);
        let legs = polyline(&points);
        let (mut made, mut each) = (Vec::new(), Vec::new());
        let budget = Budget::default();
        let before = clearance_body_legs(&body, &walls, &legs, &mut each, &budget).unwrap();
        let shape = (&body, CornerShape::Clothoids);
        let whole = round_corners(shape, &walls, &legs, (&mut made, &mut each), &budget).unwrap();
        let (before, whole) = (before.unwrap().value, whole.unwrap().value);
        prop_assert!(whole >= before - 1e-8);
        prop_assert_eq!(made.len(), each.len());
        let limits = Limits::new(speed, acceleration, 1.0, 1.0, 1.0).unwrap();
        let limits = limits.with_jerk(jerk, None).unwrap();
        let profile = planned(&made, &limits, Stops::AtKinks);
        let states: Vec<_> = profile.samples(&made, Sampling::period(0.01).unwrap()).collect();
        prop_assert_eq!(states[0].position, Vector::from(points[0]));
        prop_assert_eq!(states[states.len() - 1].position, Vector::from(points[points.len() - 1]));
        for pair in states.windows(2) {
            let dt = pair[1].time - pair[0].time;
            let change = (pair[1].velocity - pair[0].velocity).norm();
            prop_assert!(change <= acceleration * dt * (1.0 + 1e-9) + 1e-9, "{:?}", pair);
            prop_assert!(pair[0].velocity.norm() <= speed + 1e-9);
            let still = Curve::translation(pair[0].position, pair[0].position);
            let near = clearance_body_legs(&body, &walls, &[leg(still)], &mut each, &budget);
            let near = near.unwrap().unwrap().value;
            prop_assert!(near >= whole - 1e-11, "{} {}", near, whole);
        }
        let Some(jerk) = jerk else { return Ok(()) };
        for three in states.windows(3) {
            let dt = [0, 1].map(|at| three[at + 1].time - three[at].time);
            if dt[0].min(dt[1]) < 1e-3 {
                continue;
            }
            let mean = [0, 1].map(|at| (three[at + 1].velocity - three[at].velocity) / dt[at]);
            let change = 2.0 * (mean[1] - mean[0]).norm() / (dt[0] + dt[1]);
            prop_assert!(change <= jerk * (1.0 + 1e-9) + 1e-7, "{} {:?}", change, three);
        }
    }
    /// Rounding is no kink: a part stops where two lines meet, and nowhere else.
    #[test]
    fn rounded_way_points_are_passed_without_a_stop(
        points in prop::collection::vec(prop::array::uniform2(-6.0..6.0_f64), 3..8),
        boxes in any_boxes(), is_smooth in any::<bool>(),
    ) {
        let body = AxisBox::new([-0.2, -0.3].into(), [0.4, 0.1].into()).unwrap();
        let body = Body::from_box(&body);
        let shape = if is_smooth { CornerShape::Clothoids } else { CornerShape::Arc };
        let (mut made, mut each) = (Vec::new(), Vec::new());
        let (legs, walls, budget) = (polyline(&points), walls_of(&boxes), Budget::default());
        round_corners((&body, shape), &walls, &legs, (&mut made, &mut each), &budget).unwrap();
        let is_line = |leg: &Leg<2>| matches!(leg.curve, Curve::Line { .. });
        let corners = made.windows(2).filter(|pair| pair.iter().all(is_line)).count();
        let profile = planned(&made, &Limits::default(), Stops::AtKinks);
        prop_assert_eq!(profile.stops_on_the_way(&made, Stops::AtKinks), corners);
    }
}
