//! The speed profile over the legs.

use super::clothoid_bounds::{ACROSS, ALONG, ClothoidBounds};
use super::limits::Limits;
use super::ramp::{Ramp, Ramping};
use crate::budget::{Budget, Spent};
use crate::geometry::Vector;
use crate::motion::{Curve, Leg, wrapped};

/// Legs shorter than this, metres (turns smaller than this, radians), do not move. No square
/// of anything derived from more can underflow.
const NOTHING: f64 = 1e-100;

/// Steps of the budget that timing one leg takes.
const STEPS_PER_LEG: u64 = 4;

/// The body stops between two legs whose headings differ by more than this, radians.
const SAME_HEADING: f64 = 1e-9;

/// Curvatures that differ by no more than this part are the same where a clothoid begins or ends.
const SAME_CURVATURE: f64 = 1e-9;

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
    /// Wherever the direction of travel changes by more than 1e-9 rad from one leg to the next
    /// (parts whose corners are rounded). On arcs the accelerations along and across the path
    /// together stay within the limit on acceleration.
    AtKinks,
    /// As [`Stops::AtTurns`], and wherever the curvature jumps. The limits on yaw acceleration and
    /// yaw jerk then hold on arcs as well, and that on yaw acceleration on clothoids.
    AtJoints,
}

/// Where a motion's yaw rate jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct YawJumps {
    /// At how many joints of legs.
    pub joints: usize,
    /// The greatest jump, rad/s.
    pub greatest: f64,
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
    jerk: f64,
    /// Square of the greatest speed on the leg.
    most: f64,
    /// Square of the speed at the leg's start.
    entry: f64,
}

/// The motion on one leg that takes time: the speed rises at `acceleration` at most from
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
    pub(super) jerk: f64,
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

    /// The jumps of the yaw rate between the legs that were planned, if there are any: where the
    /// curvature jumps and the body does not stop.
    pub fn yaw_jumps<const D: usize>(&self, legs: &[Leg<D>]) -> Option<YawJumps> {
        let mut jumps = YawJumps { joints: 0, greatest: 0.0 };
        for pair in self.phases.windows(2) {
            let (one, other) = (&pair[0], &pair[1]);
            if one.in_place || other.in_place {
                continue;
            }
            let [curve, next] = [one, other].map(|phase| &legs[phase.leg].curve);
            let jump = curvature_step(curve, next) * one.exit;
            if jump > 0.0 {
                jumps.joints += 1;
                jumps.greatest = jumps.greatest.max(jump);
            }
        }
        (jumps.joints > 0).then_some(jumps)
    }

    /// At how many joints of the legs that were planned the body stops, other than before and after
    /// turns in place and where a robot changes between driving forwards and backwards.
    pub fn stops_on_the_way<const D: usize>(&self, legs: &[Leg<D>], stops: Stops) -> usize {
        let moving = self.phases.windows(2).filter(|pair| !pair.iter().any(|one| one.in_place));
        let pairs = moving.map(|pair| [0, 1].map(|index: usize| &legs[pair[index].leg].curve));
        pairs.filter(|[curve, next]| stops.holds_up(curve, next)).count()
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
            let Some(mut bound) = bound(curve, limits, stops) else { continue };
            bound.leg = leg;
            if let Some(last) = self.bounds.last()
                && !(last.in_place || bound.in_place)
                && stops.passes(&legs[last.leg].curve, curve)
            {
                let reached = last.reach(last.entry);
                bound.entry = reached.min(last.most).min(bound.most);
            }
            self.bounds.push(bound);
        }
    }

    /// Bounds the start of every leg by the speed that can be braked from by its end.
    fn bound_backward(&mut self) {
        let mut exit = 0.0;
        for bound in self.bounds.iter_mut().rev() {
            bound.entry = bound.entry.min(bound.reach(exit));
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
    fn ramping(&self) -> Ramping {
        Ramping { acceleration: self.acceleration, jerk: self.jerk }
    }

    /// The greatest speed at one end of the leg, if that at the other is `speed`; squares both.
    fn reach(&self, speed: f64) -> f64 {
        let ramping = self.ramping();
        if !ramping.has_jerk() {
            return speed + 2.0 * self.acceleration * self.length;
        }
        let reached = ramping.reach(speed.sqrt(), self.length);
        reached * reached
    }

    /// The motion from `entry` to `exit` (both squares). Its `end` is still its duration.
    fn phase(&self, exit: f64) -> Phase {
        let Self { leg, in_place, length, acceleration, jerk, .. } = *self;
        let SpeedRamps { speeds: [entry, peak, exit], up, down } =
            if self.ramping().has_jerk() { self.s_curve(exit) } else { self.trapezoid(exit) };
        let [Ramp { time: rise_time, distance: rise }, Ramp { time: fall_time, distance: fall }] =
            [up, down];
        let cruise = (length - rise - fall).max(0.0);
        Phase {
            leg,
            in_place,
            start: 0.0,
            end: rise_time + cruise / peak + fall_time,
            offset: 0.0,
            end_offset: 0.0,
            length,
            acceleration,
            jerk,
            entry,
            peak,
            exit,
            rise,
            rise_time,
            fall,
            fall_time,
        }
    }

    /// Ramps of three phases each from `entry` to `exit` (both squares).
    fn s_curve(&self, exit: f64) -> SpeedRamps {
        let ramping = self.ramping();
        let [entry, exit] = [self.entry.sqrt(), exit.sqrt()];
        let peak = ramping.peak((entry, exit), self.most.sqrt(), self.length);
        let [up, down] = [ramping.ramp(entry, peak), ramping.ramp(peak, exit)];
        SpeedRamps { speeds: [entry, peak, exit], up, down }
    }

    /// The trapezoid or triangle of speed from `entry` to `exit` (both squares).
    fn trapezoid(&self, exit: f64) -> SpeedRamps {
        let Self { length, acceleration, most, entry, .. } = *self;
        // The speed at which rising and falling would meet: p^2 - entry + p^2 - exit = 2 a l.
        let meeting = acceleration * length + 0.5 * (entry + exit);
        let peak = meeting.min(most).max(entry).max(exit);
        let [rise, fall] = [entry, exit].map(|end| (peak - end) / (2.0 * acceleration));
        let [entry, peak, exit] = [entry, peak, exit].map(f64::sqrt);
        // Length over mean speed: a difference of speeds would cancel on short legs.
        let up = Ramp { time: 2.0 * rise / (entry + peak), distance: rise };
        let down = Ramp { time: 2.0 * fall / (peak + exit), distance: fall };
        SpeedRamps { speeds: [entry, peak, exit], up, down }
    }
}

/// How a leg gains speed and loses it.
struct SpeedRamps {
    /// At its start, between, and at its end, m/s.
    speeds: [f64; 3],
    up: Ramp,
    down: Ramp,
}

impl Phase {
    pub(super) fn ramping(&self) -> Ramping {
        Ramping { acceleration: self.acceleration, jerk: self.jerk }
    }
}

impl Stops {
    /// Whether a body that moves on `curve` goes on along `next` without a stop.
    fn passes<const D: usize>(self, curve: &Curve<D>, next: &Curve<D>) -> bool {
        match self {
            Self::EveryLeg => false,
            Self::AtTurns => runs_into(curve, next),
            Self::AtKinks => {
                angle_between(&direction(curve, true), &direction(next, false)) <= SAME_HEADING
            }
            Self::AtJoints => runs_into(curve, next) && curvature_step(curve, next) == 0.0,
        }
    }

    /// Whether a body stops between two curves though it neither turns in place there nor changes
    /// between driving forwards and backwards.
    fn holds_up<const D: usize>(self, curve: &Curve<D>, next: &Curve<D>) -> bool {
        let is_gear_change = match self {
            Self::EveryLeg | Self::AtKinks => false,
            Self::AtTurns | Self::AtJoints => curve.ends_in_reverse() != next.is_reverse(),
        };
        !is_gear_change && !self.passes(curve, next)
    }
}

/// By how much the curvature jumps from one curve to the next, rad/m. At a clothoid it does not where it
/// is the same to rounding.
fn curvature_step<const D: usize>(curve: &Curve<D>, next: &Curve<D>) -> f64 {
    let ([_, before], [after, _]) = (curve.curvatures(), next.curvatures());
    let step = (after - before).abs();
    let meets = [curve, next].iter().any(|curve| matches!(curve, Curve::Clothoid { .. }));
    if meets && step <= SAME_CURVATURE * before.abs().max(after.abs()) { 0.0 } else { step }
}

/// The direction of travel at the end of a curve, or at its start.
fn direction<const D: usize>(curve: &Curve<D>, at_end: bool) -> Vector<D> {
    match *curve {
        Curve::Line { from, to, .. } => to - from,
        Curve::Arc { start_angle, sweep, .. } => {
            let angle = start_angle + if at_end { sweep } else { 0.0 };
            let (sin, cos) = libm::sincos(angle);
            let mut way = Vector::zeros();
            (way[0], way[1]) = (-sin * sweep.signum(), cos * sweep.signum());
            way
        }
        Curve::Clothoid { reverse, .. } => {
            let heading = if at_end { curve.end_heading() } else { curve.start_heading() };
            let (sin, cos) = libm::sincos(heading);
            let sense = if reverse { -1.0 } else { 1.0 };
            let mut way = Vector::zeros();
            (way[0], way[1]) = (cos * sense, sin * sense);
            way
        }
        Curve::Turn { .. } => Vector::zeros(),
    }
}

/// The angle between two vectors, to rounding however small it is, radians.
fn angle_between<const D: usize>(one: &Vector<D>, other: &Vector<D>) -> f64 {
    let (one, other) = (one * other.norm(), other * one.norm());
    2.0 * libm::atan2((one - other).norm(), (one + other).norm())
}

/// What bounds the speed on `curve` by itself; `None` if nothing moves on it.
fn bound<const D: usize>(curve: &Curve<D>, limits: &Limits, stops: Stops) -> Option<Bound> {
    let square = |x: f64| x * x;
    let length = curve.length();
    let angle = curve.turned().abs();
    let in_place = length < NOTHING;
    let jerk = if in_place { limits.yaw_jerk() } else { limits.jerk() };
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
            Curve::Clothoid { .. } | Curve::Line { .. } | Curve::Turn { .. } => speed,
        };
        (length, limits.acceleration(), most)
    };
    let (mut acceleration, mut jerk, mut most) = (acceleration, jerk, most);
    match (stops, curve) {
        (_, Curve::Clothoid { curvatures, .. }) if !in_place => {
            let bend = ClothoidBounds::of(*curvatures, length);
            let bounds = match stops {
                Stops::AtKinks => bend.translated(limits),
                _ => bend.driven(limits),
            };
            (most, acceleration, jerk) = bounds;
        }
        (Stops::AtKinks, Curve::Arc { radius, .. }) if !in_place => {
            most = square(limits.speed()).min(ACROSS * limits.acceleration() * radius);
            acceleration = ALONG * limits.acceleration();
        }
        (Stops::AtJoints, _) if !in_place && angle > NOTHING => {
            acceleration = acceleration.min(limits.yaw_acceleration() * length / angle);
            jerk = jerk.min(limits.yaw_jerk() * length / angle);
        }
        _ => {}
    }
    (length >= NOTHING).then_some(Bound {
        leg: 0,
        in_place,
        length,
        acceleration,
        jerk,
        most,
        entry: 0.0,
    })
}

/// Whether a body can go from `curve` on to `next` without a stop: the heading stays, and
/// `next` sets out along it, or backwards if `curve` ends backwards.
pub(super) fn runs_into<const D: usize>(curve: &Curve<D>, next: &Curve<D>) -> bool {
    let turns = matches!(*next, Curve::Line { turned, .. } if turned != 0.0);
    !turns
        && wrapped(next.start_heading() - curve.end_heading()).abs() <= SAME_HEADING
        && curve.ends_in_reverse() == next.is_reverse()
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
