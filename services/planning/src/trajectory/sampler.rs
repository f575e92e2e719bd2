//! The states of a motion, one after another.

use super::profile::{Phase, Profile};
use super::sampling::{SampleGrid, Sampling, first_multiple};
use super::state::State;
use super::track::{Track, TrackShape};
use crate::geometry::Vector;
use crate::motion::{Curve, Leg};

/// Iterator over the states of a motion, made by [`Profile::samples`]: the first
/// and the last state of every leg, and between them those on the grid of the
/// [`Sampling`].
///
/// The end of a leg and the start of the next are one state, exactly at the way-point,
/// with the velocity and yaw rate of the next leg. A state on the grid within 1e-6 s of
/// the end of a leg is dropped. Times strictly increase from 0 to the duration.
#[derive(Debug, Clone)]
pub struct Sampler<'a, const D: usize> {
    profile: &'a Profile,
    legs: &'a [Leg<D>],
    grid: SampleGrid,
    track: Option<Track<D>>,
    law: Law,
    /// The step of the grid, and its next multiple.
    step: f64,
    multiple: f64,
    /// The multiple at which the current law ends, and those at which each of the leg's does.
    end: f64,
    ends: [f64; MOST_LAWS],
    /// How many laws of the leg have been begun, and how many it has.
    laws: usize,
    law_count: usize,
    /// Index of the next phase. Its start, which is the end of the one before, is the next
    /// state off the grid.
    phase: usize,
    /// How many states are left after those of the current law.
    remaining: u64,
}

/// Laws of a leg: without a limit on jerk three, with one seven.
const MOST_LAWS: usize = 7;

/// A motion at constant jerk, mostly at constant acceleration, seen from one place on it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Law {
    /// What the grid measures there.
    pub(super) mark: f64,
    /// Time there, seconds.
    pub(super) time: f64,
    /// Distance from the leg's start there, metres or radians.
    pub(super) along: f64,
    pub(super) speed: f64,
    pub(super) acceleration: f64,
    pub(super) jerk: f64,
    /// How long the law holds from there, seconds; negative before there. Only with jerk.
    pub(super) span: f64,
}

impl Profile {
    /// How many states [`Profile::samples`] will yield. The cost depends on the number of
    /// legs only, so a caller can refuse too many states before making any.
    pub fn sample_count(&self, sampling: Sampling) -> u64 {
        if self.leg_count() == 0 {
            return 0;
        }
        let grid = SampleGrid::new(sampling, self);
        // Never more than 2^50 states a measure, so the sum is exact.
        let between: u64 = self.phases().iter().map(|phase| grid.inside(phase).count()).sum();
        between + self.phases().len() as u64 + 1
    }

    /// The states of the motion along `legs`, which must be those planned.
    /// [`Iterator::for_each`] and other folds run a few times faster than a `for` loop.
    ///
    /// # Panics
    /// The iterator may panic if `legs` are not those planned.
    pub fn samples<'a, const D: usize>(
        &'a self,
        legs: &'a [Leg<D>],
        sampling: Sampling,
    ) -> Sampler<'a, D> {
        Sampler::new(self, legs, sampling)
    }
}

impl<'a, const D: usize> Sampler<'a, D> {
    fn new(profile: &'a Profile, legs: &'a [Leg<D>], sampling: Sampling) -> Self {
        Self {
            profile,
            legs,
            grid: SampleGrid::new(sampling, profile),
            track: None,
            law: Law::default(),
            step: 0.0,
            multiple: 0.0,
            end: 0.0,
            ends: [0.0; MOST_LAWS],
            laws: 0,
            law_count: 0,
            phase: 0,
            remaining: profile.sample_count(sampling),
        }
    }

    /// The next state once the multiples of the current law are used up: the first of the
    /// leg's next law, or the state at the end of the leg.
    #[inline(never)]
    fn advance(&mut self) -> Option<State<D>> {
        while self.laws < self.law_count {
            let law = self.laws;
            self.laws += 1;
            self.end = self.ends[law];
            if self.multiple < self.end {
                self.remaining -= (self.end - self.multiple) as u64;
                self.law = Law::of(&self.profile.phases()[self.phase - 1], law, &self.grid);
                return self.on_grid();
            }
        }
        if self.remaining == 0 {
            return None;
        }
        self.remaining -= 1;
        Some(self.way_point())
    }

    /// The state at the next multiple.
    #[inline]
    fn on_grid(&mut self) -> Option<State<D>> {
        let track = self.track.as_mut()?;
        let measured = self.multiple * self.step;
        self.multiple += 1.0;
        let (time, along, speed) = if self.law.jerk != 0.0 {
            self.law.motion_with_jerk(measured, self.grid.by_time)
        } else if self.grid.by_time {
            self.law.motion::<true>(measured)
        } else {
            self.law.motion::<false>(measured)
        };
        Some(track.state(time, along, speed))
    }

    /// Folds the states of the current law up to the multiple `end`; `place` makes each.
    #[inline]
    fn run<const BY_TIME: bool, B>(
        &mut self,
        end: f64,
        init: B,
        f: &mut impl FnMut(B, State<D>) -> B,
        place: impl Fn(&mut Track<D>, f64, f64, f64) -> State<D>,
    ) -> B {
        let mut all = init;
        if let Some(track) = &mut self.track {
            // Copies outside `self` stay in registers.
            let (law, step) = (self.law, self.step);
            let (mut near, mut multiple) = (track.clone(), self.multiple);
            while multiple < end {
                let (time, along, speed) = law.motion::<BY_TIME>(multiple * step);
                all = f(all, place(&mut near, time, along, speed));
                multiple += 1.0;
            }
            self.multiple = multiple;
            *track = near;
        }
        all
    }

    /// Calls `take` with the next `count` states, or as many as are left. The same states as
    /// from [`Iterator::next`], a few times faster.
    #[inline]
    pub fn for_next(&mut self, count: usize, mut take: impl FnMut(State<D>)) {
        self.fold_next(count as f64, (), |(), state| take(state));
    }

    /// Folds the next `left` states, those of each law in one loop.
    #[inline]
    fn fold_next<B>(&mut self, mut left: f64, init: B, mut f: impl FnMut(B, State<D>) -> B) -> B {
        let mut all = init;
        while left > 0.0 {
            if self.multiple < self.end {
                let end = self.end.min(self.multiple + left);
                left -= end - self.multiple;
                if self.law.jerk != 0.0 {
                    while self.multiple < end
                        && let Some(state) = self.on_grid()
                    {
                        all = f(all, state);
                    }
                    continue;
                }
                // A loop for each shape, so that no state has to decide.
                let shape = self.track.as_ref().map_or(TrackShape::Line, Track::shape);
                let f = &mut f;
                all = match (shape, self.grid.by_time) {
                    (TrackShape::Line, true) => self.run::<true, B>(end, all, f, Track::on_line),
                    (TrackShape::Line, false) => self.run::<false, B>(end, all, f, Track::on_line),
                    (TrackShape::Bend, true) => self.run::<true, B>(end, all, f, Track::on_bend),
                    (TrackShape::Bend, false) => self.run::<false, B>(end, all, f, Track::on_bend),
                    (TrackShape::Arc, true) => self.run::<true, B>(end, all, f, Track::on_arc),
                    (TrackShape::Arc, false) => self.run::<false, B>(end, all, f, Track::on_arc),
                    (TrackShape::Clothoid, true) => {
                        self.run::<true, B>(end, all, f, Track::on_clothoid)
                    }
                    (TrackShape::Clothoid, false) => {
                        self.run::<false, B>(end, all, f, Track::on_clothoid)
                    }
                };
            } else if let Some(state) = self.advance() {
                left -= 1.0;
                all = f(all, state);
            } else {
                break;
            }
        }
        all
    }

    /// Enters the next phase and returns the state at its start; after the last one, the
    /// state of rest at the end.
    fn way_point(&mut self) -> State<D> {
        let profile = self.profile;
        let last = self.phase.checked_sub(1).map(|index| profile.phases()[index].leg);
        let next = profile.phases().get(self.phase);
        self.phase += 1;
        let mut state = match next {
            Some(phase) => self.enter(phase),
            None => State {
                time: profile.duration(),
                position: Vector::zeros(),
                heading: self.legs.last().map_or(0.0, |leg| leg.curve.end_heading()),
                velocity: Vector::zeros(),
                yaw_rate: 0.0,
            },
        };
        // Stated ends are exact, so an arc takes its own from its neighbours.
        let stated = match (last, next) {
            (_, None) => self.legs.last().map(|leg| leg.curve.end()),
            (None, Some(_)) => self.legs.first().and_then(|leg| stated(&leg.curve, Curve::start)),
            (Some(leg), Some(_)) => stated(&self.legs[leg].curve, Curve::end)
                .or_else(|| stated(&self.legs[leg + 1].curve, Curve::start)),
        };
        if let Some(position) = stated {
            state.position = position;
        }
        // At rest, negative directions make negative zeros.
        state.position = state.position.map(|x| x + 0.0);
        state.velocity = state.velocity.map(|x| x + 0.0);
        state.yaw_rate += 0.0;
        state
    }

    /// Makes `phase` the current one and returns the state at its start.
    fn enter(&mut self, phase: &Phase) -> State<D> {
        let inside = self.grid.inside(phase);
        self.step = self.grid.step(phase);
        self.multiple = inside.first;
        self.laws = 0;
        self.law_count = Law::count(phase);
        // No law has begun, so none has multiples left.
        self.end = inside.first;
        self.ends = [inside.end; MOST_LAWS];
        if inside.first < inside.end {
            // Near the border of two laws either may evaluate a multiple: they agree to rounding.
            for law in 0..self.law_count - 1 {
                let bound = Law::end(phase, law, &self.grid);
                self.ends[law] = first_multiple(self.step, |x| x >= bound, bound).min(inside.end);
            }
        }
        let mut track = Track::new(&self.legs[phase.leg], phase.length, phase.in_place);
        let state = track.state(phase.start, 0.0, phase.entry);
        self.track = Some(track);
        state
    }
}

/// The start or end of a curve if the curve states it; arcs compute theirs.
fn stated<const D: usize>(
    curve: &Curve<D>,
    end: impl Fn(&Curve<D>) -> Vector<D>,
) -> Option<Vector<D>> {
    (!matches!(curve, Curve::Arc { .. })).then(|| end(curve))
}

impl Law {
    /// Time, distance from the leg's start and speed where the grid measures `measured`.
    #[inline]
    fn motion<const BY_TIME: bool>(&self, measured: f64) -> (f64, f64, f64) {
        let Self { mark, time, along, speed, acceleration, .. } = *self;
        let beyond = measured - mark;
        if BY_TIME {
            let moved = beyond * (speed + 0.5 * acceleration * beyond);
            (measured, along + moved, speed + acceleration * beyond)
        } else {
            let there = (speed * speed + 2.0 * acceleration * beyond).max(0.0).sqrt();
            // Distance over mean speed.
            (time + 2.0 * beyond / (speed + there), along + beyond, there)
        }
    }

    /// How many laws a phase has.
    fn count(phase: &Phase) -> usize {
        if phase.ramping().has_jerk() { MOST_LAWS } else { 3 }
    }

    /// The laws of a phase: speeding up, cruising, braking. The last is seen from the end of
    /// the phase, so that it meets the end exactly.
    fn of(phase: &Phase, law: usize, grid: &SampleGrid) -> Self {
        if phase.ramping().has_jerk() {
            return Self::with_jerk(phase, law, grid);
        }
        let (start, end) = grid.ends(phase);
        match law {
            0 => Self {
                mark: start,
                time: phase.start,
                along: 0.0,
                speed: phase.entry,
                acceleration: phase.acceleration,
                ..Self::default()
            },
            1 => Self {
                mark: Self::end(phase, 0, grid),
                time: phase.start + phase.rise_time,
                along: phase.rise,
                speed: phase.peak,
                ..Self::default()
            },
            _ => Self {
                mark: end,
                time: phase.end,
                along: phase.length,
                speed: phase.exit,
                acceleration: -phase.acceleration,
                ..Self::default()
            },
        }
    }

    /// What the grid measures where a law of `phase` other than the last ends.
    fn end(phase: &Phase, law: usize, grid: &SampleGrid) -> f64 {
        if phase.ramping().has_jerk() {
            return Self::end_with_jerk(phase, law, grid);
        }
        let (start, end) = grid.ends(phase);
        match (law, grid.by_time) {
            (0, true) => start + phase.rise_time,
            (0, false) => start + phase.rise,
            (_, true) => end - phase.fall_time,
            (_, false) => end - phase.fall,
        }
    }
}

impl<const D: usize> Iterator for Sampler<'_, D> {
    type Item = State<D>;

    #[inline]
    fn next(&mut self) -> Option<State<D>> {
        if self.multiple < self.end { self.on_grid() } else { self.advance() }
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let exact = usize::try_from(self.remaining + (self.end - self.multiple) as u64).ok();
        (exact.unwrap_or(usize::MAX), exact)
    }

    /// The same states as from [`Iterator::next`], a few times faster.
    #[inline]
    fn fold<B, F: FnMut(B, State<D>) -> B>(mut self, init: B, f: F) -> B {
        self.fold_next(f64::INFINITY, init, f)
    }
}

impl<const D: usize> ExactSizeIterator for Sampler<'_, D> {}
