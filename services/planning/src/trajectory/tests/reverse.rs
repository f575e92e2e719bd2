//! Legs driven backwards: headings, cusps, limits.

use super::*;
use crate::geometry::unit;
use crate::motion::tests::motions;

fn at(states: &[State<2>], time: f64) -> State<2> {
    *states.iter().find(|state| state.time == time).expect("a state at the end of a leg")
}

proptest! {
    #[test]
    fn limits_hold_forwards_and_backwards(
        curves in motions(12), limits in any_limits(), sampling in any_sampling(),
    ) {
        let legs: Vec<_> = curves.iter().copied().map(leg).collect();
        let states = check_states(&legs, &limits, Stops::AtTurns, sampling);
        let profile = planned(&legs, &limits, Stops::AtTurns);
        // Speed along the heading; the rounding of positions is some 1e-15 m.
        let along = |state: &State<2>| state.velocity.dot(&unit(state.heading));
        for pair in states.windows(2) {
            let change = (along(&pair[1]) - along(&pair[0])).abs();
            let most = limits.acceleration() * (pair[1].time - pair[0].time);
            prop_assert!(change <= most + 1e-12 * (1.0 + limits.speed()), "{pair:?}");
        }
        for (index, curve) in curves.iter().enumerate() {
            let (start, end) = profile.leg_times(index);
            for state in &states {
                if start <= state.time && state.time < end {
                    let along = along(state) * if curve.is_reverse() { -1.0 } else { 1.0 };
                    prop_assert!((along - state.velocity.norm()).abs() < 1e-12, "{state:?}");
                }
            }
            let Some(next) = curves.get(index + 1) else { continue };
            let turns = |curve: &Curve<2>| matches!(curve, Curve::Turn { .. });
            let velocity = at(&states, end).velocity.norm();
            if curve.is_reverse() != next.is_reverse() || turns(curve) || turns(next) {
                prop_assert_eq!(velocity, 0.0);
            } else {
                // Both are entered and left at a speed.
                prop_assert!(velocity > 0.0);
            }
        }
    }

    /// Driven back, it takes as long, and each pose comes as long before the end.
    #[test]
    fn the_way_back_mirrors_time(curves in motions(8), limits in any_limits()) {
        let legs: Vec<_> = curves.iter().copied().map(leg).collect();
        let back: Vec<_> = curves.iter().rev().map(|curve| leg(curve.reversed())).collect();
        let [there, back_again] =
            [&legs, &back].map(|legs| planned(legs, &limits, Stops::AtTurns));
        let duration = there.duration();
        prop_assert!((duration - back_again.duration()).abs() < 1e-12 * (1.0 + duration));
        let sampling = Sampling::count(50).unwrap();
        let back_states: Vec<_> = back_again.samples(&back, sampling).collect();
        for state in there.samples(&legs, sampling) {
            let mirrored = duration - state.time;
            let Some(other) =
                back_states.iter().find(|other| (other.time - mirrored).abs() < 1e-11 * duration)
            else {
                continue;
            };
            let rounding = 1e-10 * (1.0 + limits.speed() + limits.yaw_rate()) * (1.0 + duration);
            prop_assert!((state.position - other.position).norm() < rounding);
            prop_assert!(wrapped(state.heading - other.heading).abs() < rounding);
        }
    }
}

#[test]
fn cusp_is_a_stop() {
    // 1 m ahead and 1 m back, each a triangle of speed: 2 sqrt(1 / 0.5) s.
    let (from, to) = (Vector::from([2.0, 1.0]), Vector::from([3.0, 1.0]));
    let ahead = Curve::Line { from, to, heading: 0.0, turned: 0.0 };
    let legs = [leg(ahead), leg(ahead.reversed())];
    let profile = planned(&legs, &Limits::default(), Stops::AtTurns);
    let triangle = 2.0 * (1.0_f64 / 0.5).sqrt();
    assert!((profile.duration() - 2.0 * triangle).abs() < 1e-14);
    let states: Vec<_> = profile.samples(&legs, Sampling::period(0.1).unwrap()).collect();
    let cusp = at(&states, profile.leg_times(0).1);
    assert_eq!((cusp.position, cusp.velocity, cusp.heading), (to, Vector::zeros(), 0.0));
    assert!(states.iter().all(|state| state.heading == 0.0));
    let back = states.iter().filter(|state| state.time > cusp.time);
    assert!(back.map(|state| state.velocity.x).fold(0.0, f64::min) < -0.6);
}

#[test]
fn line_and_arc_backwards_run_into_each_other() {
    let legs = drive(0.0, &[2.0, 2.0], &[(1.5, FRAC_PI_2)], 0.0);
    let back: Vec<_> = legs.iter().rev().map(|l| leg(l.curve.reversed())).collect();
    let profile = planned(&back, &Limits::default(), Stops::AtTurns);
    let states: Vec<_> = profile.samples(&back, Sampling::period(0.05).unwrap()).collect();
    // Turned left on the way there, it turns right on the way back, in reverse.
    let arc = states.iter().filter(|state| state.yaw_rate != 0.0);
    assert!(arc.clone().count() > 10 && arc.clone().all(|state| state.yaw_rate < 0.0));
    for state in &states {
        let along = state.velocity.dot(&unit(state.heading));
        assert!((along + state.velocity.norm()).abs() < 1e-14);
    }
    assert!(at(&states, profile.leg_times(1).1).velocity.norm() > 0.5);
}

#[test]
fn turning_into_the_first_line_ends_forwards() {
    // The robot faces away at first; at the end of the line it drives ahead without a stop.
    let (from, to) = (Vector::from([0.0, 0.0]), Vector::from([4.0, 0.0]));
    let curve = Curve::Line { from, to, heading: 0.0, turned: 3.0 };
    let after = Curve::Line { from: to, to: Vector::from([9.0, 0.0]), heading: 0.0, turned: 0.0 };
    let legs = [leg(curve), leg(after)];
    assert!(curve.is_reverse());
    let profile = planned(&legs, &Limits::default(), Stops::AtTurns);
    let states: Vec<_> = profile.samples(&legs, Sampling::period(0.1).unwrap()).collect();
    assert!(at(&states, profile.leg_times(0).1).velocity.x > 0.5);
}
