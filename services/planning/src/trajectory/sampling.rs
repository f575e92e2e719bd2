//! Which states are sampled, and how many.

use super::profile::{Phase, Profile};
use crate::geometry::number::Number;
use thiserror::Error;

/// A state on the grid this close to the end of a leg is dropped, seconds.
const GIVES_WAY: f64 = 1e-6;

/// Spacing of states on turns in place when sampling by arc length, radians.
const TURN_SPACING: f64 = 0.05;

/// The finest step as a part of the whole: 2^-50, four units in the last place, so that
/// times strictly increase whatever is asked for.
const RESOLUTION: f64 = 1.0 / (1_u64 << 50) as f64;

/// Which states to sample between the ends of legs, which are always sampled.
///
/// Steps finer than 2^-50 of the whole motion are taken as that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling(SamplingKind);

#[derive(Debug, Clone, Copy, PartialEq)]
enum SamplingKind {
    Period(f64),
    Spacing(f64),
    Count(u64),
}

/// Why a number is no [`Sampling`].
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SamplingError {
    /// A step is not a positive number.
    #[error("{field} is {}, it must be finite and greater than 0", Number(*value))]
    NotPositive {
        /// `period` or `spacing`.
        field: &'static str,
        /// The number given.
        value: f64,
    },
    /// Fewer states than a motion has ends.
    #[error("count is {count}, it must be at least {least}: the first and the last state")]
    TooFew {
        /// The number given.
        count: u64,
        /// The least number allowed.
        least: u64,
    },
}

impl Sampling {
    /// At every multiple of `seconds` from the start.
    pub fn period(seconds: f64) -> Result<Self, SamplingError> {
        positive("period", seconds).map(SamplingKind::Period).map(Self)
    }

    /// At every multiple of `metres` of arc length from the start, and every
    /// 0.05 rad of each turn in place.
    pub fn spacing(metres: f64) -> Result<Self, SamplingError> {
        positive("spacing", metres).map(SamplingKind::Spacing).map(Self)
    }

    /// At `count` evenly spaced times, the first and the last state included.
    pub fn count(count: u64) -> Result<Self, SamplingError> {
        if count < 2 {
            return Err(SamplingError::TooFew { count, least: 2 });
        }
        Ok(Self(SamplingKind::Count(count)))
    }
}

fn positive(field: &'static str, value: f64) -> Result<f64, SamplingError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(SamplingError::NotPositive { field, value })
    }
}

/// Multiples of a step: of time over the whole motion, or of arc length over the
/// whole path and of angle on each turn in place.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampleGrid {
    pub(super) by_time: bool,
    step: f64,
    turn_step: f64,
    gives_way: f64,
}

/// Consecutive multiples of a grid's step: `first * step` to `(end - 1) * step`.
/// Whole numbers below 2^51.
#[derive(Debug, Clone, Copy)]
pub(super) struct Multiples {
    pub(super) first: f64,
    pub(super) end: f64,
}

impl Multiples {
    pub(super) fn count(&self) -> u64 {
        (self.end - self.first) as u64
    }
}

impl SampleGrid {
    pub(super) fn new(Sampling(kind): Sampling, profile: &Profile) -> Self {
        let instant = RESOLUTION * profile.duration();
        let (by_time, step) = match kind {
            SamplingKind::Period(seconds) => (true, seconds.max(instant)),
            SamplingKind::Count(count) => {
                (true, (profile.duration() / (count - 1) as f64).max(instant))
            }
            SamplingKind::Spacing(metres) => {
                let least = (RESOLUTION * profile.length()).max(instant * profile.fastest());
                (false, metres.max(least))
            }
        };
        Self {
            by_time,
            step,
            turn_step: TURN_SPACING.max(instant * profile.fastest_turn()),
            gives_way: GIVES_WAY.max(instant),
        }
    }

    /// The step on `phase`.
    pub(super) fn step(&self, phase: &Phase) -> f64 {
        if phase.in_place && !self.by_time { self.turn_step } else { self.step }
    }

    /// What the grid measures at the start and at the end of `phase`.
    pub(super) fn ends(&self, phase: &Phase) -> (f64, f64) {
        match (self.by_time, phase.in_place) {
            (true, _) => (phase.start, phase.end),
            (false, false) => (phase.offset, phase.end_offset),
            (false, true) => (0.0, phase.length),
        }
    }

    /// The multiples inside `phase`, without those dropped near its ends.
    pub(super) fn inside(&self, phase: &Phase) -> Multiples {
        let (start, end) = self.ends(phase);
        let step = self.step(phase);
        let duration = phase.end - phase.start;
        let none = Multiples { first: 0.0, end: 0.0 };
        if duration <= 2.0 * self.gives_way {
            return none;
        }
        let (after, before) = if self.by_time {
            (self.gives_way, self.gives_way)
        } else {
            (phase.run_from_start(self.gives_way), phase.run_to_end(self.gives_way))
        };
        let first = first_multiple(step, |x| x > start + after, start + after);
        let end = first_multiple(step, |x| x >= end - before, end - before);
        if first < end { Multiples { first, end } } else { none }
    }
}

/// A truncated quotient is off by no more than this.
const MOST_OFF: usize = 4;

/// The least whole number `k` with `passed(k * step)`; `passed` turns from false to true
/// at about `bound`.
pub(super) fn first_multiple(step: f64, passed: impl Fn(f64) -> bool, bound: f64) -> f64 {
    // Truncated, it is off by one at most.
    let mut multiple = (bound / step) as i64 as f64;
    let back = |multiple: f64| multiple > 0.0 && passed((multiple - 1.0) * step);
    let mut left = MOST_OFF;
    while left > 0 && back(multiple) {
        (multiple, left) = (multiple - 1.0, left - 1);
    }
    let mut left = MOST_OFF;
    while left > 0 && !passed(multiple * step) {
        (multiple, left) = (multiple + 1.0, left - 1);
    }
    multiple
}

impl Phase {
    /// How far the body gets in the first `time` seconds of the phase.
    fn run_from_start(&self, time: f64) -> f64 {
        if self.ramping().has_jerk() {
            return self.run_with_jerk(self.entry, self.rise_time, time);
        }
        run(self.entry, self.peak, self.acceleration, self.rise_time, self.rise, time)
    }

    /// How far the body gets in the last `time` seconds of the phase.
    fn run_to_end(&self, time: f64) -> f64 {
        if self.ramping().has_jerk() {
            return self.run_with_jerk(self.exit, self.fall_time, time);
        }
        run(self.exit, self.peak, self.acceleration, self.fall_time, self.fall, time)
    }
}

impl Phase {
    /// The same from an end where the speed is `speed` and a ramp of `ramp_time` begins; beyond
    /// its first part a bound.
    fn run_with_jerk(&self, speed: f64, ramp_time: f64, time: f64) -> f64 {
        let rising = time.min(self.ramping().onset(ramp_time));
        time * speed + self.jerk * rising * rising * (0.5 * time - rising / 3.0)
    }
}

/// How far a body gets within `time` of that end of a phase where its speed is `speed`:
/// the speed changes at `acceleration` for `ramp_time`, over `ramp`, up to `peak`. (If
/// `time` reaches the other ramp this is only a bound, which matters to what is dropped
/// on legs of a few microseconds.)
fn run(speed: f64, peak: f64, acceleration: f64, ramp_time: f64, ramp: f64, time: f64) -> f64 {
    if time <= ramp_time {
        time * (speed + 0.5 * acceleration * time)
    } else {
        ramp + peak * (time - ramp_time)
    }
}
