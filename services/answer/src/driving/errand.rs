//! What a robot is asked to do.

use planning::clearance::rectangle::Footprint;
use planning::driving::{Goal, Pose, StartTurn, limits};
use planning::geometry::Vector;
use planning::route;
use schemas::message::{self, Body, Refusal, SceneRequest};

use crate::check;

/// The robot, where it stands and where it goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Errand {
    pub(super) footprint: Footprint,
    pub(super) start: Pose,
    pub(super) goal: Goal,
    pub(super) start_turn: StartTurn,
}

impl Errand {
    pub(super) fn of(scene: &SceneRequest) -> Result<Self, Refusal> {
        let Body::Footprint(footprint) = &scene.body else {
            let message = "body: in task \"drive\" the body is a footprint";
            return Err(Refusal::invalid("body", message));
        };
        let sizes = [footprint.width, footprint.length];
        let footprint = Footprint::new(footprint.width, footprint.length).map_err(|error| {
            let message = format!("body.footprint: {error}");
            let (has, least) = (Some(error.least()), Some(0.0));
            Refusal { has, least, ..Refusal::invalid("body.footprint", message) }
        })?;
        check::in_range(|| "body.footprint".to_owned(), &sizes)?;
        let Some(start) = scene.start else {
            let message = "start is missing; task \"drive\" needs a start pose";
            return Err(Refusal::invalid("start", message));
        };
        let Some(goal) = scene.goal else {
            return Err(Refusal::invalid("goal", "goal is missing; task \"drive\" needs a goal"));
        };
        check::finite("start.position", start.position.as_slice())?;
        check::in_range(|| "start.position".to_owned(), start.position.as_slice())?;
        check::finite("start.heading", &[start.heading])?;
        check::finite("goal.position", goal.position.as_slice())?;
        check::in_range(|| "goal.position".to_owned(), goal.position.as_slice())?;
        check::finite("goal.heading", goal.heading.as_slice())?;
        Ok(Self {
            footprint,
            start: Pose { position: check::vector(&start.position), heading: start.heading },
            goal: Goal { position: check::vector(&goal.position), heading: goal.heading },
            start_turn: match scene.start_turn {
                None | Some(message::StartTurn::InPlace) => StartTurn::InPlace,
                Some(message::StartTurn::WhileMoving) => StartTurn::WhileMoving,
            },
        })
    }

    /// The robot as the search for a route knows it, if it keeps this gap, metres.
    pub(super) fn robot(&self, gap: f64) -> route::RobotMover {
        let Self { footprint, start, goal, .. } = self;
        // What the robot needs to turn (docs/method.md 6.4: R(g) < W).
        let needs = limits::outer_radius(footprint, gap);
        let sides = (footprint.width(), gap);
        route::RobotMover::new(start.position, goal.position, Vector::repeat(needs), sides)
    }
}
