//! The frames of an assembly scene's parts (paper, section 4), and samples told in them.

use std::f64::consts::FRAC_PI_2;

use planning::clearance::clothoid::PlacedClothoid;
use planning::geometry::Vector;
use planning::motion::{Curve, Leg, wrapped};
use planning::trajectory::{Profile, State};
use schemas::message::{self, Frames, Refusal, SampleFrame, Task};

use crate::check;

/// A heading this close to a multiple of a quarter turn, radians, is taken as that multiple.
const QUARTER: f64 = 1e-9;

/// A turn of the first two coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turn {
    cos: f64,
    sin: f64,
}

impl Turn {
    pub(crate) fn by(heading: f64) -> Self {
        let heading = wrapped(heading);
        let quarters = libm::round(heading / FRAC_PI_2);
        if (heading - quarters * FRAC_PI_2).abs() > QUARTER {
            let (sin, cos) = libm::sincos(heading);
            return Self { cos, sin };
        }
        match quarters as i8 {
            0 => Self { cos: 1.0, sin: 0.0 },
            1 => Self { cos: 0.0, sin: 1.0 },
            -1 => Self { cos: 0.0, sin: -1.0 },
            _ => Self { cos: -1.0, sin: 0.0 },
        }
    }

    /// Whether axes stay axes.
    pub(crate) fn is_quarters(&self) -> bool {
        self.cos == 0.0 || self.sin == 0.0
    }

    pub(crate) fn apply<const D: usize>(&self, mut v: Vector<D>) -> Vector<D> {
        let (x, y) = (v[0], v[1]);
        v[0] = self.cos * x - self.sin * y + 0.0;
        v[1] = self.sin * x + self.cos * y + 0.0;
        v
    }

    pub(crate) fn undo<const D: usize>(&self, v: Vector<D>) -> Vector<D> {
        Self { sin: -self.sin, ..*self }.apply(v)
    }
}

/// Where a frame is in another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FramePlace<const D: usize> {
    pub(crate) origin: Vector<D>,
    heading: f64,
    turn: Turn,
}

impl<const D: usize> FramePlace<D> {
    pub(crate) fn new(origin: Vector<D>, heading: f64) -> Self {
        Self { origin, heading, turn: Turn::by(heading) }
    }

    pub(crate) fn of(pose: &message::Pose) -> Self {
        Self::new(check::vector(&pose.position), pose.heading)
    }

    /// Whether its axes are along the outer ones.
    pub(crate) fn is_by_quarters(&self) -> bool {
        self.turn.is_quarters()
    }

    /// A point of this frame as the outer one sees it.
    pub(crate) fn out(&self, point: Vector<D>) -> Vector<D> {
        self.origin + self.turn.apply(point)
    }

    /// A point of the outer frame as this one sees it.
    pub(crate) fn inwards(&self, point: Vector<D>) -> Vector<D> {
        self.turn.undo(point - self.origin)
    }
}

/// The base frame as the parts stand in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Base<const D: usize> {
    pub(crate) fixed: FramePlace<D>,
    pub(crate) at_end: FramePlace<D>,
    /// The moving part's frame in the fixed part's, in the assembled state.
    pub(crate) assembled: FramePlace<D>,
    /// Whether samples are told in it.
    pub(crate) in_samples: bool,
}

impl<const D: usize> Base<D> {
    pub(crate) fn of(frames: &Frames, task: Task) -> Result<Self, Refusal> {
        let Frames { fixed, fixed_at_end, moving, samples } = frames;
        let poses = [
            ("frames.fixed", Some(fixed)),
            ("frames.fixed_at_end", fixed_at_end.as_ref()),
            ("frames.moving", moving.as_ref()),
        ];
        for (field, pose) in poses {
            if let Some(message::Pose { position, heading }) = pose {
                check_place(&format!("{field}.position"), position)?;
                check::finite(&format!("{field}.heading"), &[*heading])?;
            }
        }
        let fixed: FramePlace<D> = FramePlace::of(fixed);
        let at_end = fixed_at_end.as_ref().map_or(fixed, FramePlace::of);
        let then = if task == Task::Assemble { at_end } else { fixed };
        let assembled = match moving {
            None => FramePlace::new(Vector::zeros(), 0.0),
            Some(moving) => {
                let moving: FramePlace<D> = FramePlace::of(moving);
                FramePlace::new(then.inwards(moving.origin), moving.heading - then.heading)
            }
        };
        let in_samples = *samples == Some(SampleFrame::Base);
        Ok(Self { fixed, at_end, assembled, in_samples })
    }
}

/// Tells states relative to the assembled state, or in the base frame. They come in order.
#[derive(Debug, Clone)]
pub(crate) struct Teller<'a, const D: usize> {
    inside: Vector<D>,
    base: Option<Base<D>>,
    legs: &'a [Leg<D>],
    profile: &'a Profile,
    /// The leg at hand, and the length of those before.
    leg: usize,
    before: f64,
}

impl<'a, const D: usize> Teller<'a, D> {
    /// For a motion along these legs, which begins at the displacement `inside`; `base`: in the base
    /// frame.
    pub(crate) fn new(
        inside: Vector<D>,
        base: Option<Base<D>>,
        legs: &'a [Leg<D>],
        profile: &'a Profile,
    ) -> Self {
        Self { inside, base, legs, profile, leg: 0, before: 0.0 }
    }

    pub(crate) fn tell(&mut self, mut state: State<D>) -> State<D> {
        let part = self.part(&state);
        state.position += self.inside;
        (state.heading, state.yaw_rate) = (0.0, 0.0);
        let Some(Base { fixed, at_end, assembled, .. }) = &self.base else { return state };
        let turned = wrapped(at_end.heading - fixed.heading);
        let moved = at_end.origin - fixed.origin;
        let place = if part <= 0.0 || (turned == 0.0 && moved.amax() == 0.0) {
            *fixed
        } else if part >= 1.0 {
            *at_end
        } else {
            FramePlace::new(fixed.origin + moved * part, fixed.heading + turned * part)
        };
        // The fixed part moves evenly with the length of the path.
        let rate = match self.profile.length() {
            length if length > 0.0 => state.velocity.norm() / length,
            _ => 0.0,
        };
        let (yaw_rate, at) = (turned * rate, assembled.origin + state.position);
        let mut velocity = state.velocity;
        velocity[0] -= yaw_rate * at[1];
        velocity[1] += yaw_rate * at[0];
        State {
            time: state.time,
            position: place.out(at),
            heading: wrapped(place.heading + assembled.heading),
            velocity: (place.turn.apply(velocity) + moved * rate).map(|value| value + 0.0),
            yaw_rate: yaw_rate + 0.0,
        }
    }

    /// Which part of the path lies behind.
    fn part(&mut self, state: &State<D>) -> f64 {
        let (Some(_), true) = (self.base, self.profile.length() > 0.0) else { return 0.0 };
        while self.leg + 1 < self.legs.len() && self.profile.leg_times(self.leg).1 <= state.time {
            self.before += self.legs[self.leg].curve.length();
            self.leg += 1;
        }
        if state.time >= self.profile.duration() {
            return 1.0;
        }
        let along = self.legs.get(self.leg).map_or(0.0, |leg| match &leg.curve {
            Curve::Line { from, .. } => (state.position - from).norm(),
            Curve::Arc { center, radius, start_angle, sweep, .. } => {
                let (x, y) = (state.position[0] - center[0], state.position[1] - center[1]);
                let angle = wrapped(libm::atan2(y, x) - start_angle);
                radius * (angle * sweep.signum()).max(0.0)
            }
            Curve::Clothoid { .. } => {
                let at = Vector::from([state.position[0], state.position[1]]);
                PlacedClothoid::of(&leg.curve).map_or(0.0, |clothoid| clothoid.along(&at))
            }
            Curve::Turn { .. } => 0.0,
        });
        (self.before + along) / self.profile.length()
    }
}

/// Refuses places that can't be reckoned with.
pub(crate) fn check_place(field: &str, position: &message::Vector) -> Result<(), Refusal> {
    check::finite(field, position.as_slice())?;
    check::in_range(|| field.to_owned(), position.as_slice())
}
