//! Where the parts stand in the base frame (paper, section 4), and where a motion begins and ends.
//!
//! Planning knows the fixed part's frame alone. The body is put where it is there at the start; what
//! is found is given relative to the assembled state, or, where the request wants that, samples in the
//! base frame.

use planning::geometry::Vector;
use planning::motion::{Curve, Leg};
use planning::trajectory::Profile;
use schemas::message::{self, AxisBox, Body, Frames, Goal, Refusal, SceneRequest, Task};

use crate::base_frame::{Base, FramePlace, Teller, check_place};
use crate::check;
use crate::scene::Scene;

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

impl<const D: usize> Ends<D> {
    /// Reads frames, start and goal.
    pub(super) fn of(scene: Scene<'_>) -> Result<Self, Refusal> {
        let base: Option<Base<D>> = match &scene.frames {
            Some(frames) => Some(Base::of(frames, scene.task)?),
            None => None,
        };
        // A displacement in the fixed part's frame.
        let displacement =
            |field: &str, position: &message::Vector, fixed: fn(&Base<D>) -> FramePlace<D>| {
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
            Curve::Clothoid { from, to, .. } => {
                *from += self.inside;
                *to += self.inside;
            }
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
        // On a curve a robot would turn, a part does not.
        let turns = legs.iter().any(|leg| !matches!(leg.curve, Curve::Line { .. }));
        let is_told_as_it_is = base.is_none() && self.inside.amax() == 0.0 && !turns;
        (!is_told_as_it_is).then(|| Teller::new(self.inside, base, legs, profile))
    }
}

/// The body of an assembly scene as the fixed part's frame sees it, in the assembled state; `None`
/// where that is as the scene gives it, or the scene is refused.
pub fn body_in_fixed_frame(scene: &SceneRequest) -> Option<Body> {
    fn put_by<const D: usize>(scene: &SceneRequest, frames: &Frames) -> Option<Body> {
        let base: Base<D> = Base::of(frames, scene.task).ok()?;
        put(&scene.body, Some(&base.assembled), &Vector::zeros()).ok()
    }
    let frames = scene.frames.as_ref().filter(|frames| frames.moving.is_some())?;
    match &scene.body {
        Body::Box(sides) if sides.min.dimension() == 3 => put_by::<3>(scene, frames),
        Body::Boxes(boxes) if boxes.iter().any(|sides| sides.min.dimension() == 3) => {
            put_by::<3>(scene, frames)
        }
        _ => put_by::<2>(scene, frames),
    }
}

/// The body as the fixed part's frame sees it, displaced.
fn put<const D: usize>(
    body: &Body,
    assembled: Option<&FramePlace<D>>,
    by: &Vector<D>,
) -> Result<Body, Refusal> {
    let still = FramePlace::new(Vector::zeros(), 0.0);
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
        Body::Box(sides) if place.is_by_quarters() => Ok(Body::Box(around(sides))),
        Body::Boxes(boxes) if place.is_by_quarters() => {
            Ok(Body::Boxes(boxes.iter().map(around).collect()))
        }
        Body::Boxes(_) if D == 2 => Err(Refusal::invalid(
            "frames.moving.heading",
            "frames.moving.heading: a union of boxes is turned by quarter turns only; give a polygon",
        )),
        Body::Box(_) | Body::Boxes(_) if D > 2 => Err(Refusal::invalid(
            "frames.moving.heading",
            "frames.moving.heading: in three dimensions parts are turned by quarter turns only",
        )),
        Body::Box(AxisBox { min, max }) => {
            let corner = |x: f64, z: f64| put(&message::Vector::from([x, z]));
            let ([a, b, _], [c, d, _]) = (min.padded(), max.padded());
            Ok(Body::Polygon(vec![corner(a, b), corner(c, b), corner(c, d), corner(a, d)]))
        }
        Body::Boxes(_) | Body::Footprint(_) => Err(check::wrong_body("body.footprint")),
    }
}

fn no_heading(field: &str) -> Refusal {
    let message = format!("{field} is not a field of assembly tasks: parts don't turn on the way");
    Refusal::invalid(field, message)
}
