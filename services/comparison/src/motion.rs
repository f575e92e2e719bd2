//! How far one trajectory is from another.

use std::f64::consts::TAU;

use schemas::message::{Sample, Trajectory};

/// The largest deviation of a kind among the samples, and where it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// How far apart the samples are.
    pub distance: f64,
    /// The first sample that is so far apart.
    pub sample: usize,
    /// How far along the recorded path that is, metres.
    pub arc_length: f64,
}

/// A number of a trajectory before and after.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// As recorded.
    pub recorded: f64,
    /// As planned now.
    pub planned: f64,
}

impl Change {
    /// By how much it has grown; 0 where both are the same infinity.
    pub fn by(self) -> f64 {
        let Self { recorded, planned } = self;
        if recorded.to_bits() == planned.to_bits() { 0.0 } else { planned - recorded }
    }
}

/// How a planned trajectory deviates from the recorded one.
///
/// Samples are compared one by one in their order, as far as both go: the n-th with the n-th.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionChange {
    /// Largest distance between reference points, metres.
    pub position: Option<Deviation>,
    /// Largest angle between headings, radians.
    pub heading: Option<Deviation>,
    /// Largest difference of times, seconds.
    pub time: Option<Deviation>,
    /// Largest distance between velocities, m/s.
    pub speed: Option<Deviation>,
    /// Arc length, metres.
    pub length: Change,
    /// Seconds.
    pub duration: Change,
    /// Least distance to the walls, metres.
    pub clearance: Change,
    /// The channels travelled, before and after, if they differ.
    pub route: Option<[Vec<u64>; 2]>,
    /// How many legs, before and after.
    pub legs: [usize; 2],
    /// How many samples, before and after.
    pub samples: [usize; 2],
}

impl MotionChange {
    /// Measures the deviations of `planned` from `recorded`.
    pub fn between(recorded: &Trajectory, planned: &Trajectory) -> Self {
        let largest = |distance: fn(&Sample, &Sample) -> f64| {
            let mut largest: Option<(usize, f64)> = None;
            for (index, (one, other)) in recorded.samples.iter().zip(&planned.samples).enumerate() {
                let distance = distance(one, other);
                // A NaN is as far apart as can be.
                if largest.is_none_or(|(_, most)| distance.total_cmp(&most).is_gt()) {
                    largest = Some((index, distance));
                }
            }
            largest.filter(|(_, distance)| *distance != 0.0).map(|(sample, distance)| {
                let arc_length = arc_length_at_sample(recorded, sample);
                Deviation { distance, sample, arc_length }
            })
        };
        let change = |of: fn(&Trajectory) -> f64| {
            let [recorded, planned] = [recorded, planned].map(of);
            Change { recorded, planned }
        };
        let routes = || [&recorded.route, &planned.route].map(Clone::clone);
        Self {
            position: largest(|one, other| apart(one.position, other.position)),
            heading: largest(|one, other| turned(one.heading, other.heading)),
            time: largest(|one, other| (one.t - other.t).abs()),
            speed: largest(|one, other| apart(one.velocity, other.velocity)),
            length: change(|trajectory| trajectory.length),
            duration: change(|trajectory| trajectory.duration),
            clearance: change(|trajectory| trajectory.clearance.value),
            route: (recorded.route != planned.route).then(routes),
            legs: [recorded.legs.len(), planned.legs.len()],
            samples: [recorded.samples.len(), planned.samples.len()],
        }
    }
}

/// Distance of two points.
pub(crate) fn apart(one: [f64; 3], other: [f64; 3]) -> f64 {
    let squares = one.iter().zip(other).map(|(one, other)| (one - other) * (one - other));
    squares.sum::<f64>().sqrt()
}

/// Least angle between two headings.
pub(crate) fn turned(one: f64, other: f64) -> f64 {
    let turned = (one - other).rem_euclid(TAU);
    turned.min(TAU - turned)
}

/// How far along the path a sample is: chords between samples, stretched to the path's length.
fn arc_length_at_sample(trajectory: &Trajectory, sample: usize) -> f64 {
    let (mut to, mut whole) = (0.0, 0.0);
    for (index, pair) in trajectory.samples.windows(2).enumerate() {
        if index == sample {
            to = whole;
        }
        whole += apart(pair[0].position, pair[1].position);
    }
    if sample + 1 >= trajectory.samples.len() {
        to = whole;
    }
    if whole > 0.0 { to * (trajectory.length / whole) } else { 0.0 }
}

/// How far along the path an element of one of a trajectory's lists is, if it is on the path.
pub(crate) fn arc_length(trajectory: &Trajectory, item: (&str, usize)) -> Option<f64> {
    match item {
        ("sample", index) => Some(arc_length_at_sample(trajectory, index)),
        ("leg", index) => {
            let before = trajectory.legs.get(..index)?;
            Some(before.iter().map(|leg| leg.length).sum())
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Along x at 1 m/s, a sample each second.
    fn straight(samples: usize) -> Trajectory {
        let sample = |index: usize| Sample {
            t: index as f64,
            position: [index as f64, 0.0, 0.0],
            velocity: [1.0, 0.0, 0.0],
            ..Sample::default()
        };
        let length = (samples - 1) as f64;
        let samples = (0..samples).map(sample).collect();
        Trajectory { length, duration: length, samples, ..Trajectory::default() }
    }

    #[test]
    fn equal_trajectories_have_no_deviations() {
        let change = MotionChange::between(&straight(5), &straight(5));
        let MotionChange { position, heading, time, speed, route, .. } = &change;
        assert_eq!([position, heading, time, speed], [&None; 4]);
        assert_eq!((route, change.length.by()), (&None, 0.0));
    }

    #[test]
    fn the_largest_deviations_are_found_with_their_places() {
        let mut planned = straight(5);
        planned.samples[1].position = [1.5, 0.0, 0.0];
        planned.samples[3].position = [3.0 + 3.0, 4.0, 0.0];
        planned.samples[2].heading = -0.25;
        planned.samples[4].t += 0.5;
        planned.duration += 0.5;
        planned.route = vec![1];
        let change = MotionChange::between(&straight(5), &planned);
        let place = |distance, sample: usize| {
            Some(Deviation { distance, sample, arc_length: sample as f64 })
        };
        assert_eq!(change.position, place(5.0, 3), "3 and 4 make 5");
        assert_eq!(change.heading, place(0.25, 2));
        assert_eq!(change.time, place(0.5, 4));
        assert_eq!((change.speed, change.duration.by()), (None, 0.5));
        assert_eq!(change.route, Some([vec![], vec![1]]));
    }

    #[test]
    fn headings_a_whole_turn_apart_are_equal() {
        assert!(turned(0.5, 0.5 + TAU) < 1e-12);
        assert!((turned(3.0, -3.0) - (TAU - 6.0)).abs() < 1e-12);
    }

    #[test]
    fn lists_are_compared_as_far_as_both_go() {
        let change = MotionChange::between(&straight(5), &straight(3));
        assert_eq!((change.position, change.samples, change.length.by()), (None, [5, 3], -2.0));
    }

    #[test]
    fn what_is_no_number_is_farthest() {
        let mut planned = straight(5);
        planned.samples[1].position[0] = f64::NAN;
        planned.samples[3].position[0] = 100.0;
        let position = MotionChange::between(&straight(5), &planned).position.unwrap();
        assert!(position.distance.is_nan() && position.sample == 1);
    }
}
