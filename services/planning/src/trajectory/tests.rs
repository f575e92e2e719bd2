//! What any trajectory promises, over random chains of legs.

use super::*;
use crate::budget::Budget;
use crate::geometry::Vector;
use crate::motion::{Curve, Leg, wrapped};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

mod jerk;
mod reverse;
mod smooth;

fn leg<const D: usize>(curve: Curve<D>) -> Leg<D> {
    Leg { curve, junction: None, rule: None, rung: None }
}

fn polyline<const D: usize>(points: &[[f64; D]]) -> Vec<Leg<D>> {
    let line = |ends: &[[f64; D]]| {
        let (from, to) = (ends[0].into(), ends[1].into());
        leg(Curve::Line { from, to, heading: 0.0, turned: 0.0 })
    };
    points.windows(2).map(line).collect()
}

/// Turn in place, line, arc, ..., line, turn in place, each tangent to the next.
fn drive(start_turn: f64, lines: &[f64], arcs: &[(f64, f64)], goal_turn: f64) -> Vec<Leg<2>> {
    let mut position = Vector::from([3.0, -2.0]);
    let mut heading = 0.4;
    let mut legs = vec![leg(Curve::Turn { position, from_heading: heading, sweep: start_turn })];
    heading = wrapped(heading + start_turn);
    for (index, &length) in lines.iter().enumerate() {
        let (sin, cos) = libm::sincos(heading);
        let to = position + Vector::from([cos, sin]) * length;
        legs.push(leg(Curve::Line { from: position, to, heading, turned: 0.0 }));
        position = to;
        let Some(&(radius, sweep)) = arcs.get(index) else { break };
        let sense = sweep.signum();
        let center = position + Vector::from([-sin, cos]) * (sense * radius);
        let start_angle = wrapped(heading - sense * FRAC_PI_2);
        legs.push(leg(Curve::Arc { center, radius, start_angle, sweep, reverse: false }));
        let (sin, cos) = libm::sincos(start_angle + sweep);
        position = center + Vector::from([cos, sin]) * radius;
        heading = wrapped(heading + sweep);
    }
    legs.push(leg(Curve::Turn { position, from_heading: heading, sweep: goal_turn }));
    legs
}

fn planned<const D: usize>(legs: &[Leg<D>], limits: &Limits, stops: Stops) -> Profile {
    let mut profile = Profile::default();
    profile.plan(legs, limits, stops, &Budget::default()).unwrap();
    profile
}

fn any_limits() -> impl Strategy<Value = Limits> {
    (0.05..5.0_f64, 0.05..5.0_f64, 0.05..5.0_f64, 0.05..5.0_f64, 0.05..5.0_f64)
        .prop_map(|(a, b, c, d, e)| Limits::new(a, b, c, d, e).unwrap())
}

fn any_sampling() -> impl Strategy<Value = Sampling> {
    prop_oneof![
        (0.003..3.0_f64).prop_map(|period| Sampling::period(period).unwrap()),
        (0.003..3.0_f64).prop_map(|spacing| Sampling::spacing(spacing).unwrap()),
        (2..2000_u64).prop_map(|count| Sampling::count(count).unwrap()),
    ]
}

fn any_length() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.0..6.0_f64, 1 => 1e-9..1e-3_f64, 1 => Just(0.0)]
}

fn any_drive() -> impl Strategy<Value = Vec<Leg<2>>> {
    let sweep = (0.01..3.1_f64, any::<bool>()).prop_map(|(x, left)| if left { x } else { -x });
    (
        prop_oneof![Just(0.0), -PI..PI],
        prop::collection::vec(any_length(), 9),
        prop::collection::vec((0.05..4.0_f64, sweep), 0..=8),
        prop_oneof![Just(0.0), -PI..PI],
    )
        .prop_map(|(start, lines, arcs, goal)| drive(start, &lines, &arcs, goal))
}

fn any_assembly() -> impl Strategy<Value = Vec<Leg<3>>> {
    let point = prop_oneof![
        3 => prop::array::uniform3(-9.0..9.0_f64),
        1 => Just([1.0, 1.0, 1.0]),
        1 => Just([-1.0, 1.0, 1.0]),
    ];
    prop::collection::vec(point, 2..9).prop_map(|points| polyline(&points))
}

/// Checks that consecutive states of `legs` keep to `limits`.
///
/// Rounding: a time is right to half a unit in its last place, a coordinate to
/// a few, so a step in place is off by `(|p| + v t) 8 eps`, a step in speed by
/// `(v + a t) 8 eps`, a step in heading by `(pi + w t) 8 eps`.
fn check_limits<const D: usize>(states: &[State<D>], limits: &Limits) {
    let (speed, yaw_rate) = (limits.speed(), limits.yaw_rate());
    for pair in states.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        let rounding = |size: f64, rate: f64| 8.0 * f64::EPSILON * (size + rate * b.time);
        let dt = b.time - a.time;
        assert!(dt > 0.0, "times increase: {} {}", a.time, b.time);
        let moved = (b.position - a.position).norm();
        let extent = a.position.norm() + b.position.norm();
        assert!(moved <= speed * dt + rounding(extent, speed), "{a:?} {b:?}");
        let (v, w) = (a.velocity.norm(), b.velocity.norm());
        assert!(w <= speed * (1.0 + 4.0 * f64::EPSILON));
        assert!(
            (w - v).abs() <= limits.acceleration() * dt + rounding(speed, limits.acceleration()),
            "{a:?} {b:?}"
        );
        let turned = wrapped(b.heading - a.heading).abs();
        assert!(turned <= yaw_rate * dt + rounding(PI, yaw_rate), "{a:?} {b:?}");
        assert!(b.yaw_rate.abs() <= yaw_rate * (1.0 + 4.0 * f64::EPSILON));
        // v^2 / rho is v times the yaw rate.
        let lateral = w * b.yaw_rate.abs();
        assert!(lateral <= limits.lateral_acceleration() * (1.0 + 8.0 * f64::EPSILON));
        if a.position == b.position {
            let change = (b.yaw_rate - a.yaw_rate).abs();
            let most = limits.yaw_acceleration();
            // The last state of a turn is the following leg's, whose yaw rate is 0 too.
            assert!(change <= most * dt + rounding(yaw_rate, most), "{a:?} {b:?}");
        }
    }
}

/// What every sequence of states must be, whatever is asked for.
fn check_states<const D: usize>(
    legs: &[Leg<D>],
    limits: &Limits,
    stops: Stops,
    sampling: Sampling,
) -> Vec<State<D>> {
    let profile = planned(legs, limits, stops);
    let mut one_by_one = Vec::new();
    let mut samples = profile.samples(legs, sampling);
    while let Some(state) = samples.next() {
        one_by_one.push(state);
        assert_eq!(samples.len() as u64 + one_by_one.len() as u64, profile.sample_count(sampling));
    }
    assert_eq!(samples.len(), 0);
    assert!(samples.next().is_none());
    let states = profile.samples(legs, sampling).fold(Vec::new(), |mut states, state| {
        states.push(state);
        states
    });
    assert_eq!(states, one_by_one);

    check_limits(&states, limits);
    let (first, last) = (states.first().unwrap(), states.last().unwrap());
    assert_eq!((first.time, last.time), (0.0, profile.duration()));
    for state in [first, last] {
        assert_eq!((state.velocity, state.yaw_rate), (Vector::<D>::zeros(), 0.0));
    }
    for state in &states {
        let numbers = [state.time, state.heading, state.yaw_rate];
        let vectors = state.position.iter().chain(state.velocity.iter());
        for &x in numbers.iter().chain(vectors) {
            assert!(x.is_finite() && x.to_bits() != (-0.0_f64).to_bits(), "{state:?}");
        }
        assert!(-PI < state.heading && state.heading <= PI);
    }
    // Every way-point is a state, to the bit, at the time that its leg ends.
    for (index, Leg { curve, .. }) in legs.iter().enumerate() {
        let (start, end) = profile.leg_times(index);
        let at = |time: f64| {
            let found = states.binary_search_by(|state| state.time.total_cmp(&time));
            states[found.unwrap_or_else(|_| panic!("a state at {time}"))]
        };
        let (before, after) = (at(start), at(end));
        if let Curve::Line { from, to, .. } = *curve
            && start < end
        {
            assert_eq!((before.position, after.position), (from, to));
        }
        if start < end {
            assert_eq!(before.heading, curve.start_heading());
            assert!(wrapped(after.heading - curve.end_heading()).abs() < 1e-9);
        }
    }
    states
}

proptest! {
    #[test]
    fn assembly_keeps_its_limits_and_way_points(
        legs in any_assembly(), limits in any_limits(), sampling in any_sampling(),
    ) {
        let states = check_states(&legs, &limits, Stops::EveryLeg, sampling);
        let profile = planned(&legs, &limits, Stops::EveryLeg);
        for index in 0..legs.len() {
            let (_, end) = profile.leg_times(index);
            let state = states.iter().find(|state| state.time == end).unwrap();
            prop_assert_eq!(state.velocity, Vector::<3>::zeros());
        }
    }

    #[test]
    fn driving_keeps_its_limits_and_way_points(
        legs in any_drive(), limits in any_limits(), sampling in any_sampling(),
    ) {
        check_states(&legs, &limits, Stops::AtTurns, sampling);
    }

    /// The greatest speed at a place is what can be braked from until any slower
    /// leg or stop ahead, and reached from any behind: `v^2 <= c^2 + 2 a d` for
    /// all of them, and equal for one.
    #[test]
    fn speed_is_the_greatest_that_is_allowed(
        legs in any_drive(), limits in any_limits(), sampling in any_sampling(),
    ) {
        let profile = planned(&legs, &limits, Stops::AtTurns);
        let mut caps = vec![(0.0, 0.0, 0.0)];
        let mut offset = 0.0;
        for Leg { curve, .. } in &legs {
            let length = curve.length();
            let most: f64 = match *curve {
                Curve::Arc { radius, .. } => {
                    (limits.yaw_rate() * radius)
                        .min((limits.lateral_acceleration() * radius).sqrt())
                        .min(limits.speed())
                }
                _ => limits.speed(),
            };
            if length > 0.0 {
                caps.push((offset, offset + length, most * most));
            }
            offset += length;
        }
        caps.push((offset, offset, 0.0));
        let (mut offset, mut index, mut checked) = (0.0, 0, 0_u32);
        for state in profile.samples(&legs, sampling) {
            while index < legs.len() && profile.leg_times(index).1 <= state.time {
                offset += legs[index].curve.length();
                index += 1;
            }
            let Some(Leg { curve, .. }) = legs.get(index) else { break };
            let place = offset + match *curve {
                Curve::Turn { .. } | Curve::Clothoid { .. } => continue,
                Curve::Line { from, .. } => (state.position - from).norm(),
                Curve::Arc { center, radius, start_angle, sweep, .. } => {
                    let arm = state.position - center;
                    let angle = libm::atan2(arm[1], arm[0]) - start_angle;
                    radius * wrapped(sweep.signum() * angle)
                }
            };
            let allowed = caps.iter().map(|&(from, to, square)| {
                square + 2.0 * limits.acceleration() * (from - place).max(place - to).max(0.0)
            });
            let allowed = allowed.fold(f64::INFINITY, f64::min);
            let square = state.velocity.norm_squared();
            // A place is right to 1e-13: coordinates are below 100 m.
            let rounding = 1e-12 * (limits.acceleration() + square);
            prop_assert!((square - allowed).abs() <= rounding, "{state:?} {square} {allowed}");
            checked += 1;
        }
        prop_assert!(checked > 0 || profile.length() == 0.0);
    }

    /// Within the rounding of times and the kinks of speed, which miss
    /// `a dt^2 / 4` of length each, the speeds add up to the length.
    #[test]
    fn speeds_add_up_to_the_length(legs in any_drive(), limits in any_limits()) {
        let profile = planned(&legs, &limits, Stops::AtTurns);
        let sampling = Sampling::count(5000).unwrap();
        let states: Vec<_> = profile.samples(&legs, sampling).collect();
        let run = |pair: &[State<2>]| {
            let (a, b) = (&pair[0], &pair[1]);
            0.5 * (a.velocity.norm() + b.velocity.norm()) * (b.time - a.time)
        };
        let total: f64 = states.windows(2).map(run).sum();
        let dt = profile.duration() / 4999.0;
        let missed = 2.0 * legs.len() as f64 * 0.25 * limits.acceleration() * dt * dt;
        prop_assert!((total - profile.length()).abs() <= missed + 1e-11);
    }

    #[test]
    fn count_is_exact_where_numbers_end(
        legs in any_drive(), exponent in -9..12_i32, step in -12..3_i32, by_time in any::<bool>(),
    ) {
        let limit = libm::exp10(exponent.into());
        let limits = Limits::new(limit, (1.0 / limit).max(1e-9), 1.0, 1.0, 1.0).unwrap();
        let profile = planned(&legs, &limits, Stops::AtTurns);
        let size = if by_time { profile.duration() } else { profile.length() };
        prop_assume!(size > 0.0);
        let step = size * libm::exp10(step.into());
        let sampling =
            if by_time { Sampling::period(step) } else { Sampling::spacing(step) }.unwrap();
        let samples = profile.samples(&legs, sampling);
        prop_assert_eq!(samples.len() as u64, profile.sample_count(sampling));
        if samples.len() < 20_000 {
            let states: Vec<_> = samples.clone().collect();
            prop_assert_eq!(states.len(), samples.len());
            prop_assert!(states.windows(2).all(|pair| pair[0].time < pair[1].time));
        } else {
            let times: Vec<_> = samples.take(20_000).map(|state| state.time).collect();
            prop_assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}

#[test]
fn section_4_is_timed_by_triangles_and_trapezoids() {
    let legs = polyline(&[[0.0, 0.0], [-0.3, 1.19], [-2.19, 1.8], [-2.19, 5.99]]);
    let profile = planned(&legs, &Limits::default(), Stops::EveryLeg);
    // Below v^2 / a = 2 m a triangle: 2 sqrt(l / a); else l / v + v / a.
    let triangle = |length: f64| 2.0 * (length / 0.5).sqrt();
    let (a, b) = (triangle(1.22723265927859), triangle(1.98600100704909));
    let expected = [a, a + b, a + b + 4.19 + 2.0];
    for (index, expected) in expected.into_iter().enumerate() {
        let (_, end) = profile.leg_times(index);
        assert!((end - expected).abs() < 1e-14 * expected, "{end} {expected}");
    }
    assert!((profile.length() - 7.40323366632768).abs() < 1e-14);
    assert_eq!(profile.duration(), profile.leg_times(2).1);
}

#[test]
fn arc_is_run_at_its_own_speed_without_stopping() {
    // v = min(1, 0.5 * 1.5, sqrt(0.5 * 1.5)) = 0.75 on the arc.
    let limits = Limits::new(1.0, 0.5, 0.5, 1.0, 0.5).unwrap();
    let legs = drive(0.0, &[5.0, 5.0], &[(1.5, FRAC_PI_2)], 0.0);
    let profile = planned(&legs, &limits, Stops::AtTurns);
    // Up to 1 m/s in 1 m, down to 0.75 in 0.4375 m.
    let line = 2.0 + 0.5 + (5.0 - 1.0 - 0.4375);
    let arc = 1.5 * FRAC_PI_2 / 0.75;
    assert!((profile.duration() - (2.0 * line + arc)).abs() < 1e-14 * profile.duration());
    let states: Vec<_> = profile.samples(&legs, Sampling::count(2).unwrap()).collect();
    // The state where line and arc meet is the arc's.
    assert_eq!(states.len(), 4);
    assert!((states[1].yaw_rate - 0.5).abs() < 1e-15);
    assert_eq!(states[2].yaw_rate, 0.0);
    assert!((states[1].velocity.norm() - 0.75).abs() < 1e-15);
}

#[test]
fn turn_in_place_is_sampled_by_angle() {
    let position = Vector::from([1.0, 2.0]);
    let legs = [leg(Curve::Turn { position, from_heading: 3.0, sweep: 1.0 })];
    let profile = planned(&legs, &Limits::default(), Stops::AtTurns);
    assert_eq!(profile.duration(), 2.0);
    let states: Vec<_> = profile.samples(&legs, Sampling::spacing(0.1).unwrap()).collect();
    assert_eq!(states.len(), 21);
    for (index, state) in states.iter().enumerate() {
        assert_eq!((state.position, state.velocity), (position, Vector::<2>::zeros()));
        let turned = wrapped(state.heading - 3.0);
        assert!((turned - 0.05 * index as f64).abs() < 1e-15);
    }
    assert!((states[10].yaw_rate - 1.0).abs() < 1e-15);
}

#[test]
fn line_that_turns_keeps_the_yaw_rate() {
    let (from, to) = (Vector::from([0.0, 0.0]), Vector::from([4.0, 0.0]));
    let curve = Curve::Line { from, to, heading: 0.0, turned: -2.0 };
    let after = Curve::Line { from: to, to: Vector::from([9.0, 0.0]), heading: 0.0, turned: 0.0 };
    let legs = [leg(curve), leg(after)];
    let limits = Limits::new(1.0, 0.5, 0.25, 1.0, 0.5).unwrap();
    let states = check_states(&legs, &limits, Stops::AtTurns, Sampling::period(0.01).unwrap());
    let fastest = states.iter().map(|state| state.yaw_rate.abs()).fold(0.0, f64::max);
    assert_eq!(fastest, 0.25);
    assert_eq!(states[0].heading, 2.0);
    let end = states.iter().find(|state| state.position == to).unwrap();
    assert_eq!((end.velocity[0], end.yaw_rate), (0.5, 0.0));
}

#[test]
fn period_is_a_product_and_gives_way_to_way_points() {
    // Two legs of 2 s; 2 s is a multiple of the period but for rounding.
    let legs = polyline(&[[0.0, 0.0], [0.5, 0.0], [0.5, 0.5]]);
    let profile = planned(&legs, &Limits::default(), Stops::EveryLeg);
    let sampling = Sampling::period(0.1 + 1e-8).unwrap();
    let times: Vec<_> = profile.samples(&legs, sampling).map(|state| state.time).collect();
    assert_eq!(times.len(), 41);
    for (index, &time) in times.iter().enumerate() {
        let expected = match index {
            20 => 2.0,
            40 => 4.0,
            index => index as f64 * (0.1 + 1e-8),
        };
        assert_eq!(time, expected);
    }
}

#[test]
fn too_fine_a_grid_is_counted_at_once() {
    let legs = drive(1.0, &[5.0, 5.0], &[(1.5, FRAC_PI_2)], 0.5);
    let profile = planned(&legs, &Limits::default(), Stops::AtTurns);
    for sampling in [Sampling::period(1e-300), Sampling::spacing(1e-300), Sampling::count(u64::MAX)]
    {
        let sampling = sampling.unwrap();
        assert!(profile.sample_count(sampling) > 1 << 48);
        let times: Vec<_> = profile.samples(&legs, sampling).take(9).map(|s| s.time).collect();
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
    }
}

#[test]
fn nothing_to_do_is_one_state_of_rest() {
    let sampling = Sampling::count(10).unwrap();
    let still = polyline(&[[1.0, -0.0], [1.0, -0.0], [1.0, -0.0]]);
    let profile = planned(&still, &Limits::default(), Stops::EveryLeg);
    let states: Vec<_> = profile.samples(&still, sampling).collect();
    assert_eq!((profile.duration(), profile.length(), states.len()), (0.0, 0.0, 1));
    assert_eq!(states[0].position[1].to_bits(), 0.0_f64.to_bits());
    let profile = planned::<2>(&[], &Limits::default(), Stops::EveryLeg);
    assert_eq!(profile.sample_count(sampling), 0);
    assert!(profile.samples::<2>(&[], sampling).next().is_none());
}

#[test]
fn wrong_samplings_are_refused_by_name() {
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for (field, result) in
            [("period", Sampling::period(value)), ("spacing", Sampling::spacing(value))]
        {
            let message = format!("{field} is {value}, it must be finite and greater than 0");
            assert_eq!(result.unwrap_err().to_string(), message);
        }
    }
    for count in [0, 1] {
        assert_eq!(Sampling::count(count), Err(SamplingError::TooFew { count, least: 2 }));
    }
}

#[test]
fn million_legs_are_timed_to_the_last_digits() {
    let points: Vec<_> = (0..=1_000_000).map(|i| [f64::from(i % 2) * 0.125, 0.0]).collect();
    let legs = polyline(&points);
    let profile = planned(&legs, &Limits::default(), Stops::EveryLeg);
    assert_eq!((profile.duration(), profile.length()), (1e6, 125_000.0));
    let sampling = Sampling::period(0.3).unwrap();
    // Every third second is a multiple of 0.3 too.
    let count = profile.sample_count(sampling);
    assert_eq!(profile.samples(&legs, sampling).fold(0, |count, _| count + 1), count);
    assert_eq!(count, 1_000_001 + 3_333_333 - 333_333);
}

#[test]
fn plan_forgets_the_one_before() {
    let legs = drive(1.0, &[5.0, 5.0], &[(1.5, FRAC_PI_2)], 0.5);
    let mut used = planned(&legs, &Limits::default(), Stops::EveryLeg);
    used.plan(&legs, &Limits::default(), Stops::AtTurns, &Budget::default()).unwrap();
    let fresh = planned(&legs, &Limits::default(), Stops::AtTurns);
    let sampling = Sampling::period(0.1).unwrap();
    assert!(used.samples(&legs, sampling).eq(fresh.samples(&legs, sampling)));
}
