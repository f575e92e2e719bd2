//! Where the parts stand in the base frame (paper, section 4), and where a motion begins and ends.
//!
//! Planning knows the fixed part's frame alone. The body is put where it is there at the start; what
//! is found is given relative to the assembled state, or, where the request wants that, samples in the
//! base frame.

use std::f64::consts::FRAC_PI_2;

use planning::geometry::Vector;
use planning::motion::{Curve, Leg, wrapped};
use planning::trajectory::{Profile, State};
use schemas::message::{self, AxisBox, Body, Frames, Goal, Refusal, SampleFrame, Task};

use crate::check;
use crate::scene::Scene;

/// A heading this close to a multiple of a quarter turn, radians, is taken as that multiple.
const QUARTER: f64 = 1e-9;

/// A turn of the first two coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turn {
    cos: f64,
    sin: f64,
}

impl Turn {
    fn by(heading: f64) -> Self {
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
    fn is_quarters(&self) -> bool {
        self.cos == 0.0 || self.sin == 0.0
    }

    fn apply<const D: usize>(&self, mut v: Vector<D>) -> Vector<D> {
        let (x, y) = (v[0], v[1]);
        v[0] = self.cos * x - self.sin * y + 0.0;
        v[1] = self.sin * x + self.cos * y + 0.0;
        v
    }

    fn undo<const D: usize>(&self, v: Vector<D>) -> Vector<D> {
        Self { sin: -self.sin, ..*self }.apply(v)
    }
}

/// Where a frame is in another.
#[derive(Debug, Clone, Copy)]
struct Place<const D: usize> {
    origin: Vector<D>,
    heading: f64,
    turn: Turn,
}

impl<const D: usize> Place<D> {
    fn new(origin: Vector<D>, heading: f64) -> Self {
        Self { origin, heading, turn: Turn::by(heading) }
    }

    fn of(pose: &message::Pose) -> Self {
        Self::new(check::vector(&pose.position), pose.heading)
    }

    /// A point of this frame as the outer one sees it.
    fn out(&self, point: Vector<D>) -> Vector<D> {
        self.origin + self.turn.apply(point)
    }

    /// A point of the outer frame as this one sees it.
    fn inwards(&self, point: Vector<D>) -> Vector<D> {
        self.turn.undo(point - self.origin)
    }
}

/// Where the motion begins and ends, and how it is told.
#[derive(Debug, Clone)]
pub(super) struct Ends<const D: usize> {
    /// The body where it is inside the part: at the start of a disassembly; if it is not as the
    /// request gives it.
    pub(super) body: Option<Body>,
    /// The displacement of that place from the assembled state.
    inside: Vector<D>,
    /// The free place beyond the mouth, as a displacement from that.
    pub(super) outside: Option<Vector<D>>,
    base: Option<Base<D>>,
}

/// The base frame as the parts stand in it.
#[derive(Debug, Clone, Copy)]
struct Base<const D: usize> {
    fixed: Place<D>,
    at_end: Place<D>,
    /// The moving part's frame in the fixed part's, in the assembled state.
    assembled: Place<D>,
    /// Whether samples are told in it.
    in_samples: bool,
}

impl<const D: usize> Base<D> {
    fn of(frames: &Frames, task: Task) -> Result<Self, Refusal> {
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
        let fixed: Place<D> = Place::of(fixed);
        let at_end = fixed_at_end.as_ref().map_or(fixed, Place::of);
        let then = if task == Task::Assemble { at_end } else { fixed };
        let assembled = match moving {
            None => Place::new(Vector::zeros(), 0.0),
            Some(moving) => {
                let moving: Place<D> = Place::of(moving);
                Place::new(then.inwards(moving.origin), moving.heading - then.heading)
            }
        };
        let in_samples = *samples == Some(SampleFrame::Base);
        Ok(Self { fixed, at_end, assembled, in_samples })
    }
}

impl<const D: usize> Ends<D> {
    /// Reads frames, start and goal.
    pub(super) fn of(scene: Scene<'_>) -> Result<Self, Refusal> {
        let base: Option<Base<D>> = match &scene.frames {
            Some(frames) => Some(Base::of(frames, scene.task)?),
            None => None,
        };
        // A displacement in the fixed part's frame.
        let displacement =
            |field: &str, position: &message::Vector, fixed: fn(&Base<D>) -> Place<D>| {
                check_place(&format!("{field}.position"), position)?;
                let position = check::vector(position);
                Ok(match &base {
                    None => position,
                    Some(base) => fixed(base).inwards(position) - base.assembled.origin,
                })
            };
        let start = match &scene.start {
            Some(start) if start.heading != 0.0 => return Err(no_heading("start.heading")),
            Some(start) => Some(displacement("start", &start.position, |base| base.fixed)?),
            None => None,
        };
        let goal = match &scene.goal {
            Some(Goal { heading: Some(_), .. }) => return Err(no_heading("goal.heading")),
            Some(goal) => Some(displacement("goal", &goal.position, |base| base.at_end)?),
            None => None,
        };
        let (inside, outside) =
            if scene.task == Task::Assemble { (goal, start) } else { (start, goal) };
        let assembled = base.map(|base| base.assembled);
        let moved = inside.is_some() || scene.frames.is_some_and(|frames| frames.moving.is_some());
        let inside = inside.unwrap_or_else(Vector::zeros);
        let body = match moved {
            true => Some(put(&scene.body, assembled.as_ref(), &inside)?),
            false => None,
        };
        Ok(Self { body, inside, outside: outside.map(|outside| outside - inside), base })
    }

    /// A leg as a displacement from the assembled state.
    pub(super) fn tell(&self, leg: &Leg<D>) -> Leg<D> {
        if self.inside.amax() == 0.0 {
            return *leg;
        }
        let mut leg = *leg;
        match &mut leg.curve {
            Curve::Line { from, to, .. } => {
                *from += self.inside;
                *to += self.inside;
            }
            Curve::Arc { center, .. } => *center += self.inside,
            Curve::Turn { position, .. } => *position += self.inside,
        }
        leg
    }

    /// What makes samples of states; `None` if they are told as they are.
    pub(super) fn teller<'a>(
        &self,
        legs: &'a [Leg<D>],
        profile: &'a Profile,
    ) -> Option<Teller<'a, D>> {
        let base = self.base.filter(|base| base.in_samples);
        let is_told_as_it_is = base.is_none() && self.inside.amax() == 0.0;
        (!is_told_as_it_is).then_some(Teller {
            inside: self.inside,
            base,
            legs,
            profile,
            leg: 0,
            before: 0.0,
        })
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

impl<const D: usize> Teller<'_, D> {
    pub(crate) fn tell(&mut self, mut state: State<D>) -> State<D> {
        let part = self.part(&state);
        state.position += self.inside;
        let Some(Base { fixed, at_end, assembled, .. }) = &self.base else { return state };
        let turned = wrapped(at_end.heading - fixed.heading);
        let moved = at_end.origin - fixed.origin;
        let place = if part <= 0.0 || (turned == 0.0 && moved.amax() == 0.0) {
            *fixed
        } else if part >= 1.0 {
            *at_end
        } else {
            Place::new(fixed.origin + moved * part, fixed.heading + turned * part)
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
            Curve::Turn { .. } => 0.0,
        });
        (self.before + along) / self.profile.length()
    }
}

/// The body as the fixed part's frame sees it, displaced.
fn put<const D: usize>(
    body: &Body,
    assembled: Option<&Place<D>>,
    by: &Vector<D>,
) -> Result<Body, Refusal> {
    let still = Place::new(Vector::zeros(), 0.0);
    let place = assembled.unwrap_or(&still);
    let put = |point: &message::Vector| {
        let point = place.out(check::vector::<D>(point)) + by;
        message::Vector::new(point.as_slice()).unwrap_or_default()
    };
    let around = |AxisBox { min, max }: &AxisBox| {
        let (a, b): (Vector<D>, Vector<D>) = (check::vector(&put(min)), check::vector(&put(max)));
        // A box without an interior is refused as it was given.
        let is_box = min.as_slice().iter().zip(max.as_slice()).all(|(min, max)| min < max);
        let (least, most) = if is_box { (a.inf(&b), a.sup(&b)) } else { (a, b) };
        let corner =
            |corner: Vector<D>| message::Vector::new(corner.as_slice()).unwrap_or_default();
        AxisBox { min: corner(least), max: corner(most) }
    };
    match body {
        Body::Polygon(vertices) => Ok(Body::Polygon(vertices.iter().map(put).collect())),
        Body::Box(sides) if place.turn.is_quarters() => Ok(Body::Box(around(sides))),
        Body::Box(_) if D > 2 => Err(Refusal::invalid(
            "frames.moving.heading",
            "frames.moving.heading: in three dimensions parts are turned by quarter turns only",
        )),
        Body::Box(AxisBox { min, max }) => {
            let corner = |x: f64, z: f64| put(&message::Vector::from([x, z]));
            let ([a, b, _], [c, d, _]) = (min.padded(), max.padded());
            Ok(Body::Polygon(vec![corner(a, b), corner(c, b), corner(c, d), corner(a, d)]))
        }
        Body::Footprint(_) => Err(check::wrong_body("body.footprint")),
    }
}

fn check_place(field: &str, position: &message::Vector) -> Result<(), Refusal> {
    check::finite(field, position.as_slice())?;
    check::in_range(|| field.to_owned(), position.as_slice())
}

fn no_heading(field: &str) -> Refusal {
    let message = format!("{field} is not a field of assembly tasks: parts don't turn on the way");
    Refusal::invalid(field, message)
}
