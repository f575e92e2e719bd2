//! Limits on jerk: seven phases on a leg, never exceeded, and as fast as an independent program's.

use super::*;

fn straight(length: f64) -> Vec<Leg<2>> {
    polyline(&[[0.0, 0.0], [length, 0.0]])
}

fn limits(speed: f64, acceleration: f64, jerk: f64) -> Limits {
    let limits = Limits::new(speed, acceleration, 2.0, 3.0, 1e6).unwrap();
    limits.with_jerk(Some(jerk), Some(4.0)).unwrap()
}

/// Length, speed, acceleration, jerk, and the duration from rest to rest by Ruckig 0.19.
const FROM_REST_TO_REST: [([f64; 4], f64); 6] = [
    ([1.0, 1.0, 1.0, 1.0], 3.1748021039363987),
    ([12.0, 9.0, 1.0, 1.0], 8.0),
    ([0.25, 9.0, 1.0, 1.0], 2.0),
    ([5.0, 1.0, 0.5, 2.0], 7.25),
    ([0.01, 1.0, 0.5, 2.0], 0.5428835233189813),
    ([100.0, 1.5, 0.3, 0.2], 73.16666666666669),
];

#[test]
fn durations_are_those_of_an_independent_program() {
    for ([length, speed, acceleration, jerk], expected) in FROM_REST_TO_REST {
        let legs = straight(length);
        let profile = planned(&legs, &limits(speed, acceleration, jerk), Stops::EveryLeg);
        let duration = profile.duration();
        assert!((duration - expected).abs() < 1e-12 * expected, "{duration} for {expected}");
    }
}

/// Length, speeds at its start and its end, limits on speed, acceleration and jerk, and the
/// duration by Ruckig 0.19.
const FROM_SPEED_TO_SPEED: [([f64; 6], f64); 6] = [
    ([3.0, 0.5, 0.0, 1.0, 0.5, 1.0], 4.625),
    ([3.0, 0.0, 0.7, 1.0, 0.5, 1.0], 4.415),
    ([2.0, 0.6, 0.4, 1.0, 0.5, 1.0], 2.7906875905849873),
    ([0.9, 0.9, 0.2, 1.0, 0.5, 4.0], 1.5926653919326457),
    ([4.0, 1.0, 1.0, 1.0, 0.5, 1.0], 4.0),
    ([1.2, 0.2, 0.9, 1.4, 0.6, 3.0], 1.8343602837449247),
];

#[test]
fn legs_between_speeds_are_those_of_an_independent_program() {
    use crate::trajectory::ramp::Ramping;
    for ([length, from, to, speed, acceleration, jerk], expected) in FROM_SPEED_TO_SPEED {
        let ramping = Ramping { acceleration, jerk };
        let peak = ramping.peak((from, to), speed, length);
        let (up, down) = (ramping.ramp(from, peak), ramping.ramp(peak, to));
        let cruise = (length - up.distance - down.distance) / peak;
        let duration = up.time + cruise + down.time;
        assert!((duration - expected).abs() < 1e-12 * expected, "{duration} for {expected}");
    }
}

#[test]
fn turn_in_place_has_seven_phases_too() {
    // 4 t^3 j / 2 = 1 rad at 4 rad/s3: t = 1/2 s, four times; the peak is 1 rad/s.
    let turn = Curve::Turn { position: Vector::zeros(), from_heading: 0.0, sweep: 1.0 };
    let legs: [Leg<2>; 1] = [leg(turn)];
    let profile = planned(&legs, &limits(1.0, 1.0, 1.0), Stops::AtTurns);
    assert!((profile.duration() - 2.0).abs() < 1e-15, "{}", profile.duration());
    let middle = profile.samples(&legs, Sampling::period(1.0).unwrap()).nth(1).unwrap();
    assert!((middle.heading - 0.5).abs() < 1e-15 && (middle.yaw_rate - 1.0).abs() < 1e-15);
}

#[test]
fn without_a_limit_on_jerk_nothing_changes() {
    let legs = drive(0.7, &[2.0, 0.4, 3.0], &[(0.8, 1.2), (0.5, -0.9)], 0.4);
    let plain = Limits::default();
    let same = plain.with_jerk(None, None).unwrap();
    let states = |limits: &Limits| -> Vec<_> {
        let profile = planned(&legs, limits, Stops::AtTurns);
        profile.samples(&legs, Sampling::period(0.02).unwrap()).collect()
    };
    assert_eq!(states(&plain), states(&same));
}

/// Differences of speeds, accelerations and jerks along the path or in place, at steps of `dt`
/// inside one leg or across legs.
fn check_differences(legs: &[Leg<2>], limits: &Limits, stops: Stops) -> Result<(), TestCaseError> {
    let profile = planned(legs, limits, stops);
    let dt = profile.duration() / 4000.0;
    prop_assume!(dt > 1e-4);
    let sampling = Sampling::period(dt).unwrap();
    let states: Vec<_> = profile.samples(legs, sampling).collect();
    check_limits(&states, limits);
    // Samples of the grid alone, evenly spaced.
    let on_grid = |state: &&State<2>| {
        let steps = state.time / dt;
        (steps - steps.round()).abs() < 1e-6
    };
    let grid: Vec<_> = states.iter().filter(on_grid).collect();
    for four in grid.windows(3) {
        let even = (four[1].time - four[0].time - dt).abs() < 1e-9
            && (four[2].time - four[1].time - dt).abs() < 1e-9;
        if !even {
            continue;
        }
        let speeds: Vec<_> = four.iter().map(|state| state.velocity.norm()).collect();
        let jerk = (speeds[2] - 2.0 * speeds[1] + speeds[0]) / (dt * dt);
        let rounding = 64.0 * f64::EPSILON * limits.speed() / (dt * dt);
        prop_assert!(jerk.abs() <= limits.jerk() * (1.0 + 1e-6) + rounding, "{jerk} {four:?}");
        if speeds.iter().all(|speed| *speed == 0.0) {
            let rates: Vec<_> = four.iter().map(|state| state.yaw_rate).collect();
            let jerk = (rates[2] - 2.0 * rates[1] + rates[0]) / (dt * dt);
            let rounding = 64.0 * f64::EPSILON * limits.yaw_rate() / (dt * dt);
            prop_assert!(jerk.abs() <= limits.yaw_jerk() * (1.0 + 1e-6) + rounding);
        }
    }
    Ok(())
}

fn any_jerk() -> impl Strategy<Value = Limits> {
    (any_limits(), 0.1..20.0_f64, 0.1..20.0_f64)
        .prop_map(|(limits, jerk, yaw)| limits.with_jerk(Some(jerk), Some(yaw)).unwrap())
}

proptest! {
    #[test]
    fn limits_hold_for_parts(
        points in prop::collection::vec(prop::array::uniform2(-5.0..5.0_f64), 2..6),
        limits in any_jerk(),
    ) {
        check_differences(&polyline(&points), &limits, Stops::EveryLeg)?;
    }

    #[test]
    fn limits_hold_for_robots(legs in any_drive(), limits in any_jerk()) {
        check_differences(&legs, &limits, Stops::AtTurns)?;
    }

    /// Whatever the grid, each state is where the motion by time is then.
    #[test]
    fn states_by_distance_are_those_by_time(legs in any_drive(), limits in any_jerk()) {
        let profile = planned(&legs, &limits, Stops::AtTurns);
        let spacing = Sampling::spacing(0.05).unwrap();
        let by_distance: Vec<_> = profile.samples(&legs, spacing).collect();
        for pair in by_distance.windows(2) {
            prop_assert!(pair[0].time < pair[1].time);
        }
        let count = by_distance.len() as u64;
        prop_assert_eq!(profile.sample_count(spacing), count);
        let fine: Vec<_> = profile.samples(&legs, Sampling::count(3000).unwrap()).collect();
        let step = profile.duration() / 2999.0;
        let mut from = 0;
        for state in &by_distance {
            while from + 1 < fine.len() && fine[from + 1].time <= state.time {
                from += 1;
            }
            let moved = (state.position - fine[from].position).norm();
            prop_assert!(moved <= limits.speed() * step * (1.0 + 1e-6) + 1e-9);
        }
    }

    /// The greater the jerk may be, the faster, up to the motion without a limit on it.
    #[test]
    fn more_jerk_is_never_slower(legs in any_drive(), limits in any_limits()) {
        let duration = |jerk: Option<f64>| {
            let limits = limits.with_jerk(jerk, jerk).unwrap();
            planned(&legs, &limits, Stops::AtTurns).duration()
        };
        let durations = [Some(0.5), Some(5.0), Some(50.0), Some(1e11), None].map(duration);
        for pair in durations.windows(2) {
            prop_assert!(pair[1] <= pair[0] * (1.0 + 1e-9) + 1e-12, "{durations:?}");
        }
        let [.., hardly, none] = durations;
        prop_assert!((hardly - none).abs() <= 1e-4 * none.max(1.0), "{durations:?}");
    }

    /// Folds and single steps give the same states.
    #[test]
    fn states_are_the_same_one_by_one(legs in any_drive(), limits in any_jerk(), sampling in any_sampling()) {
        let profile = planned(&legs, &limits, Stops::AtTurns);
        let mut one_by_one = Vec::new();
        for state in profile.samples(&legs, sampling) {
            one_by_one.push(state);
        }
        let mut folded = Vec::new();
        profile.samples(&legs, sampling).for_each(|state| folded.push(state));
        prop_assert_eq!(&one_by_one, &folded);
        prop_assert_eq!(one_by_one.len() as u64, profile.sample_count(sampling));
    }
}
