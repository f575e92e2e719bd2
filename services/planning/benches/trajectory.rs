//! Speed profiles and a thousand samples, over lines and over a chain of arcs.

use divan::{Bencher, black_box};
use planning::budget::Budget;
use planning::geometry::Vector;
use planning::motion::{Curve, Leg};
use planning::trajectory::{Limits, Profile, Sampling, State, Stops};
use std::f64::consts::{FRAC_PI_2, PI};

fn main() {
    divan::main();
}

fn leg(curve: Curve<2>) -> Leg<2> {
    Leg { curve, junction: None, rule: None, rung: None }
}

/// Section 4's path at gap 0.2: three lines with stops.
fn lines() -> (Vec<Leg<2>>, Stops) {
    let points = [[0.0, 0.0], [-0.3, 1.19], [-2.19, 1.8], [-2.19, 5.99]].map(Vector::from);
    let line = |ends: &[Vector<2>]| {
        leg(Curve::Line { from: ends[0], to: ends[1], heading: 0.0, turned: 0.0 })
    };
    (points.windows(2).map(line).collect(), Stops::EveryLeg)
}

/// A staircase: `corners` quarter turns of radius 1 between lines of 5 metres.
fn staircase(corners: usize) -> (Vec<Leg<2>>, Stops) {
    let mut legs = Vec::new();
    let mut from = Vector::from([0.0, 0.0]);
    for corner in 0..=corners {
        let up = corner % 2 == 0;
        let (along, across) = if up { ([0.0, 1.0], [1.0, 0.0]) } else { ([1.0, 0.0], [0.0, 1.0]) };
        let (along, across) = (Vector::from(along), Vector::from(across));
        let to = from + 5.0 * along;
        let heading = if up { FRAC_PI_2 } else { 0.0 };
        legs.push(leg(Curve::Line { from, to, heading, turned: 0.0 }));
        if corner < corners {
            let (start_angle, sweep) = if up { (PI, -FRAC_PI_2) } else { (-FRAC_PI_2, FRAC_PI_2) };
            legs.push(leg(Curve::Arc {
                center: to + across,
                radius: 1.0,
                start_angle,
                sweep,
                reverse: false,
            }));
        }
        from = to + across + along;
    }
    (legs, Stops::AtTurns)
}

fn sampled(bencher: Bencher, (legs, stops): (Vec<Leg<2>>, Stops), sampling: Sampling) {
    let mut profile = Profile::default();
    profile.plan(&legs, &Limits::default(), stops, &Budget::default()).unwrap();
    let samples = profile.samples(&legs, sampling);
    let mut slots: Vec<State<2>> = samples.collect();
    bencher.bench_local(|| {
        let samples = profile.samples(black_box(&legs), black_box(sampling));
        let mut slots = slots.iter_mut();
        samples.for_each(|state| {
            if let Some(slot) = slots.next() {
                *slot = state;
            }
        });
        black_box(slots.len())
    });
}

#[divan::bench]
fn thousand_samples_over_lines_one_by_one(bencher: Bencher) {
    let (legs, stops) = lines();
    let mut profile = Profile::default();
    profile.plan(&legs, &Limits::default(), stops, &Budget::default()).unwrap();
    let sampling = Sampling::count(1000).unwrap();
    let mut slots: Vec<State<2>> = profile.samples(&legs, sampling).collect();
    bencher.bench_local(|| {
        let samples = profile.samples(black_box(&legs), black_box(sampling));
        for (slot, state) in slots.iter_mut().zip(samples) {
            *slot = state;
        }
        black_box(slots.last().copied())
    });
}

#[divan::bench]
fn thousand_samples_over_lines(bencher: Bencher) {
    sampled(bencher, lines(), Sampling::count(1000).unwrap());
}

#[divan::bench]
fn thousand_samples_over_20_arcs(bencher: Bencher) {
    sampled(bencher, staircase(20), Sampling::count(1000).unwrap());
}

#[divan::bench]
fn spaced_samples_over_20_arcs(bencher: Bencher) {
    sampled(bencher, staircase(20), Sampling::spacing(0.137).unwrap());
}

#[divan::bench(args = [20, 1000, 10_000])]
fn count_only(bencher: Bencher, corners: usize) {
    let (legs, stops) = staircase(corners);
    let mut profile = Profile::default();
    profile.plan(&legs, &Limits::default(), stops, &Budget::default()).unwrap();
    let sampling = Sampling::period(0.02).unwrap();
    bencher.bench_local(|| profile.sample_count(black_box(sampling)));
}

#[divan::bench(args = [0, 20, 1000, 10_000])]
fn plan(bencher: Bencher, corners: usize) {
    let (legs, stops) = staircase(corners);
    let mut profile = Profile::default();
    bencher.bench_local(|| {
        profile.plan(black_box(&legs), &Limits::default(), stops, &Budget::default()).unwrap();
        profile.duration()
    });
}
