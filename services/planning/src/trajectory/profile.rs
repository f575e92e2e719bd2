//! The speed profile over the legs.

use super::limits::Limits;
use crate::budget::{Budget, Spent};
use crate::motion::{Curve, Leg, wrapped};

/// Legs shorter than this, metres (turns smaller than this, radians), do not move. No square
/// of anything derived from more can underflow.
const NOTHING: f64 = 1e-100;

/// Steps of the budget that timing one leg takes.
const STEPS_PER_LEG: u64 = 4;

/// The body stops between two legs whose headings differ by more than this, radians.
const SAME_HEADING: f64 = 1e-9;

/// Where a body stops on the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stops {
    /// At the end of every leg, as a polyline has no tangent there (assembly).
    EveryLeg,
    /// Before and after turns in place, wherever the headings of two legs differ by more
    /// than 1e-9 rad, before a line that turns on the way, which sets out across its heading,
    /// and at cusps, where the robot changes between driving forwards and backwards (driving).
    /// Elsewhere headings are taken to be tangent to the path.
    AtTurns,
}

/// The fastest motion along legs from rest to rest under [`Limits`]. Reusable memory.
///
/// Legs must be of finite length.
#[derive(Debug, Clone, Default)]
pub struct Profile {
    bounds: Vec<Bound>,
    phases: Vec<Phase>,
    leg_ends: Vec<f64>,
    duration: f64,
    length: f64,
    fastest: f64,
    fastest_turn: f64,
}

/// What bounds the speed on a leg on which something moves.
#[derive(Debug, Clone, Copy)]
struct Bound {
    leg: usize,
    in_place: bool,
    length: f64,
    acceleration: f64,
    /// Square of the greatest speed on the leg.
    most: f64,
    /// Square of the speed at the leg's start.
    entry: f64,
}

/// The motion on one leg that takes time: the speed rises at `acceleration` from
/// `entry` to `peak`, stays, and falls to `exit`. Seconds and metres; radians instead
/// of metres for a turn in place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Phase {
    pub(super) leg: usize,
    pub(super) in_place: bool,
    /// Time at its start and at its end, seconds.
    pub(super) start: f64,
    pub(super) end: f64,
    /// Arc length of the whole path at its start and at its end, metres.
    pub(super) offset: f64,
    pub(super) end_offset: f64,
    pub(super) length: f64,
    pub(super) acceleration: f64,
    pub(super) entry: f64,
    pub(super) peak: f64,
    pub(super) exit: f64,
    /// Over what distance and time the speed rises.
    pub(super) rise: f64,
    pub(super) rise_time: f64,
    /// Over what distance and time the speed falls.
    pub(super) fall: f64,
    pub(super) fall_time: f64,
}

impl Profile {
    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        self.bounds.capacity() * size_of::<Bound>()
            + self.phases.capacity() * size_of::<Phase>()
            + self.leg_ends.capacity() * size_of::<f64>()
    }

    /// Plans the motion along `legs`, each beginning where the one before ends.
    ///
    /// Legs that neither move nor turn take no time; a line or an arc without length
    /// that turns counts as a turn in place.
    pub fn plan<const D: usize>(
        &mut self,
        legs: &[Leg<D>],
        limits: &Limits,
        stops: Stops,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        budget.step(STEPS_PER_LEG * legs.len() as u64)?;
        self.bound_forward(legs, limits, stops);
        self.bound_backward();
        self.time(legs.len());
        Ok(())
    }

    /// Duration of the whole motion, seconds.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Arc length of the whole path, metres.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// When leg number `leg`, counted from 0, begins and ends, seconds.
    ///
    /// # Panics
    /// If there is no such leg.
    pub fn leg_times(&self, leg: usize) -> (f64, f64) {
        let start = if leg == 0 { 0.0 } else { self.leg_ends[leg - 1] };
        (start, self.leg_ends[leg])
    }

    pub(super) fn leg_count(&self) -> usize {
        self.leg_ends.len()
    }

    pub(super) fn phases(&self) -> &[Phase] {
        &self.phases
    }

    /// Greatest speed reached along the path, m/s.
    pub(super) fn fastest(&self) -> f64 {
        self.fastest
    }

    /// Greatest yaw rate reached in turns in place, rad/s.
    pub(super) fn fastest_turn(&self) -> f64 {
        self.fastest_turn
    }

    /// Bounds every leg by its limits, and its start by the speed that can be reached
    /// until there: `v_out^2 <= v_in^2 + 2 a l`. Squares of speeds add up as lengths do.
    fn bound_forward<const D: usize>(&mut self, legs: &[Leg<D>], limits: &Limits, stops: Stops) {
        self.bounds.clear();
        for (leg, Leg { curve, .. }) in legs.iter().enumerate() {
            let Some(mut bound) = bound(curve, limits) else { continue };
            bound.leg = leg;
            if let (Some(last), Stops::AtTurns) = (self.bounds.last(), stops)
                && !(last.in_place || bound.in_place)
                && runs_into(&legs[last.leg].curve, curve)
            {
                let reached = last.entry + 2.0 * last.acceleration * last.length;
                bound.entry = reached.min(last.most).min(bound.most);
            }
            self.bounds.push(bound);
        }
    }

    /// Bounds the start of every leg by the speed that can be braked from by its end.
    fn bound_backward(&mut self) {
        let mut exit = 0.0;
        for bound in self.bounds.iter_mut().rev() {
            bound.entry = bound.entry.min(exit + 2.0 * bound.acceleration * bound.length);
            exit = bound.entry;
        }
    }

    /// Times the legs one after another.
    fn time(&mut self, legs: usize) {
        self.phases.clear();
        self.leg_ends.clear();
        self.leg_ends.reserve(legs);
        (self.fastest, self.fastest_turn) = (0.0, 0.0);
        let (mut clock, mut odometer) = (Sum::default(), Sum::default());
        let (mut start, mut offset) = (0.0, 0.0);
        for (index, bound) in self.bounds.iter().enumerate() {
            let exit = self.bounds.get(index + 1).map_or(0.0, |next| next.entry);
            let mut phase = bound.phase(exit);
            (phase.start, phase.offset) = (start, offset);
            clock.add(phase.end);
            phase.end = clock.total().max(start);
            if bound.in_place {
                phase.end_offset = offset;
                self.fastest_turn = self.fastest_turn.max(phase.peak);
            } else {
                odometer.add(phase.length);
                phase.end_offset = odometer.total().max(offset);
                self.fastest = self.fastest.max(phase.peak);
            }
            self.leg_ends.resize(bound.leg, start);
            self.leg_ends.push(phase.end);
            (start, offset) = (phase.end, phase.end_offset);
            // Too short for the clock to resolve: both ends are one state.
            if phase.end > phase.start {
                self.phases.push(phase);
            }
        }
        self.leg_ends.resize(legs, start);
        (self.duration, self.length) = (start, offset);
    }
}

impl Bound {
    /// The trapezoid or triangle of speed from `entry` to `exit` (both squares). Its `end`
    /// is still its duration.
    fn phase(&self, exit: f64) -> Phase {
        let Self { leg, in_place, length, acceleration, most, entry } = *self;
        // The speed at which rising and falling would meet: p^2 - entry + p^2 - exit = 2 a l.
        let meeting = acceleration * length + 0.5 * (entry + exit);
        let peak = meeting.min(most).max(entry).max(exit);
        let rise = (peak - entry) / (2.0 * acceleration);
        let fall = (peak - exit) / (2.0 * acceleration);
        let cruise = (length - rise - fall).max(0.0);
        let (entry, peak, exit) = (entry.sqrt(), peak.sqrt(), exit.sqrt());
        // Length over mean speed: a difference of speeds would cancel on short legs.
        let rise_time = 2.0 * rise / (entry + peak);
        let fall_time = 2.0 * fall / (peak + exit);
        Phase {
            leg,
            in_place,
            start: 0.0,
            end: rise_time + cruise / peak + fall_time,
            offset: 0.0,
            end_offset: 0.0,
            length,
            acceleration,
            entry,
            peak,
            exit,
            rise,
            rise_time,
            fall,
            fall_time,
        }
    }
}

/// What bounds the speed on `curve` by itself; `None` if nothing moves on it.
fn bound<const D: usize>(curve: &Curve<D>, limits: &Limits) -> Option<Bound> {
    let square = |x: f64| x * x;
    let length = curve.length();
    let angle = curve.turned().abs();
    let in_place = length < NOTHING;
    let (length, acceleration, most) = if in_place {
        (angle, limits.yaw_acceleration(), square(limits.yaw_rate()))
    } else {
        let speed = square(limits.speed());
        let most = match *curve {
            // v <= omega rho and v^2 / rho <= a (docs/method.md 8).
            Curve::Arc { radius, .. } => speed
                .min(square(limits.yaw_rate() * radius))
                .min(limits.lateral_acceleration() * radius),
            // v |turned| / length <= omega.
            Curve::Line { .. } if angle > NOTHING => {
                speed.min(square(limits.yaw_rate() * length / angle))
            }
            Curve::Line { .. } | Curve::Turn { .. } => speed,
        };
        (length, limits.acceleration(), most)
    };
    (length >= NOTHING).then_some(Bound {
        leg: 0,
        in_place,
        length,
        acceleration,
        most,
        entry: 0.0,
    })
}

/// Whether a body can go from `curve` on to `next` without a stop: the heading stays, and
/// `next` sets out along it, or backwards if `curve` ends backwards.
fn runs_into<const D: usize>(curve: &Curve<D>, next: &Curve<D>) -> bool {
    let turns = matches!(*next, Curve::Line { turned, .. } if turned != 0.0);
    !turns
        && wrapped(next.start_heading() - curve.end_heading()).abs() <= SAME_HEADING
        && ends_backwards(curve) == next.is_reverse()
}

/// Whether the body is driven backwards at the end of `curve`.
fn ends_backwards<const D: usize>(curve: &Curve<D>) -> bool {
    match *curve {
        Curve::Line { from, to, heading, .. } => {
            Curve::Line { from, to, heading, turned: 0.0 }.is_reverse()
        }
        _ => curve.is_reverse(),
    }
}

/// A compensated sum (Neumaier): a million legs are timed as accurately as one.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    rounded: f64,
    rest: f64,
}

impl Sum {
    fn add(&mut self, term: f64) {
        let rounded = self.rounded + term;
        let (large, small) =
            if self.rounded >= term { (self.rounded, term) } else { (term, self.rounded) };
        self.rest += (large - rounded) + small;
        self.rounded = rounded;
    }

    fn total(&self) -> f64 {
        self.rounded + self.rest
    }
}
