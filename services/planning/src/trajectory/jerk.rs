//! The laws of a leg's seven phases under a limit on jerk, and the states under them.

use super::profile::Phase;
use super::sampler::Law;
use super::sampling::SampleGrid;

/// Which of the seven phases cruises; three before it speed up, three after it brake.
const CRUISE: usize = 3;

/// Halvings after which a time is found to rounding.
const HALVINGS: usize = 64;

/// A ramp as a motion from its slow end: away from it at the leg's start, towards it at its end.
struct Slope {
    /// Speed at the slow end.
    speed: f64,
    jerk: f64,
    /// How long the jerk lasts, at either end of the ramp, and how long the acceleration stays.
    onset: f64,
    steady: f64,
}

/// Time, distance, speed and acceleration from a slope's slow end on.
type Place = [f64; 4];

impl Slope {
    fn of(phase: &Phase, is_rise: bool) -> Self {
        let (speed, time) =
            if is_rise { (phase.entry, phase.rise_time) } else { (phase.exit, phase.fall_time) };
        let onset = phase.ramping().onset(time);
        Self { speed, jerk: phase.jerk, onset, steady: (time - 2.0 * onset).max(0.0) }
    }

    /// Where part 0, 1 or 2 begins, its jerk, and how long it lasts.
    fn part(&self, part: usize) -> (Place, f64, f64) {
        let Self { speed, jerk, onset, steady } = *self;
        let most = jerk * onset;
        let faster = speed + 0.5 * most * onset;
        let there = onset * (speed + most * onset / 6.0);
        match part {
            0 => ([0.0, 0.0, speed, 0.0], jerk, onset),
            1 => ([onset, there, faster, most], 0.0, steady),
            _ => {
                let there = there + steady * (faster + 0.5 * most * steady);
                ([onset + steady, there, faster + most * steady, most], -jerk, onset)
            }
        }
    }
}

impl Law {
    /// The law of one of the seven phases, seen from the end of the leg that it is nearer to.
    pub(super) fn with_jerk(phase: &Phase, law: usize, grid: &SampleGrid) -> Self {
        let (start, end) = grid.ends(phase);
        if law == CRUISE {
            return Self {
                mark: start + if grid.by_time { phase.rise_time } else { phase.rise },
                time: phase.start + phase.rise_time,
                along: phase.rise,
                speed: phase.peak,
                ..Self::default()
            };
        }
        let is_rise = law < CRUISE;
        let part = if is_rise { law } else { 2 * CRUISE - law };
        let ([time, there, speed, acceleration], jerk, span) = Slope::of(phase, is_rise).part(part);
        let measured = if grid.by_time { time } else { there };
        if is_rise {
            let (time, along, mark) = (phase.start + time, there, start + measured);
            return Self { mark, time, along, speed, acceleration, jerk, span };
        }
        // Time runs towards the end: the acceleration is turned round, its change is not.
        Self {
            mark: end - measured,
            time: phase.end - time,
            along: phase.length - there,
            speed,
            acceleration: 0.0 - acceleration,
            jerk,
            span: -span,
        }
    }

    /// What the grid measures where one of the first six phases ends.
    pub(super) fn end_with_jerk(phase: &Phase, law: usize, grid: &SampleGrid) -> f64 {
        match law {
            0 | 1 => Self::with_jerk(phase, law + 1, grid).mark,
            2 => Self::with_jerk(phase, CRUISE, grid).mark,
            // Seen from the end, a phase begins where the one before it ends.
            CRUISE => {
                let (_, end) = grid.ends(phase);
                end - if grid.by_time { phase.fall_time } else { phase.fall }
            }
            _ => Self::with_jerk(phase, law, grid).mark,
        }
    }

    /// Time, distance from the leg's start and speed where the grid measures `measured`.
    pub(super) fn motion_with_jerk(&self, measured: f64, by_time: bool) -> (f64, f64, f64) {
        let Self { mark, time, along, speed, acceleration, jerk, span } = *self;
        let moved = |time: f64| time * (speed + time * (0.5 * acceleration + jerk / 6.0 * time));
        let beyond = measured - mark;
        let elapsed = if by_time {
            beyond
        } else {
            // The distance grows with time.
            let (mut low, mut high) = (span.min(0.0), span.max(0.0));
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if moved(middle) <= beyond { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        };
        let there = (speed + elapsed * (acceleration + 0.5 * jerk * elapsed)).max(0.0);
        let time = if by_time { measured } else { time + elapsed };
        (time, if by_time { along + moved(elapsed) } else { along + beyond }, there)
    }
}
