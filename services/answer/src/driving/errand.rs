//! What a robot is asked to do.

use planning::any_angle::{self, Abilities, Costs};
use planning::budget::Budget;
use planning::clearance::rectangle::Footprint;
use planning::driving::{Goal, Pose, StartTurn, limits};
use planning::free_space::floor::Floor;
use planning::free_space::walls::Walls;
use planning::geometry::number::Number;
use planning::geometry::{AxisBox, Vector};
use planning::route;
use schemas::message::{self, Body, ErrorCode, Refusal, SceneRequest};

use crate::check;
use crate::refuse::{self, Refused};
use crate::scene::Scene;

/// The robot, where it stands and where it goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Errand {
    pub(super) footprint: Footprint,
    pub(super) start: Pose,
    pub(super) goal: Goal,
    pub(super) start_turn: StartTurn,
    pub(super) abilities: Abilities,
    pub(super) costs: Costs,
    /// Whether the reply has bounds and free clearances for channels in travel order, too.
    pub(super) full_report: bool,
}

impl Errand {
    /// `any_order`: whether the robot may travel its free space in any order.
    pub(super) fn of(scene: Scene<'_>, any_order: bool) -> Result<Self, Refusal> {
        let Body::Footprint(footprint) = &scene.body else {
            let message = "body: in task \"drive\" the body is a footprint";
            return Err(Refusal::invalid("body", message));
        };
        let footprint = footprint_of(footprint)?;
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
        let size = footprint.width().max(footprint.length());
        check::not_far_out("start.position", start.position.as_slice(), size)?;
        check::not_far_out("goal.position", goal.position.as_slice(), size)?;
        Ok(Self {
            footprint,
            start: Pose { position: check::vector(&start.position), heading: start.heading },
            goal: Goal { position: check::vector(&goal.position), heading: goal.heading },
            start_turn: match scene.start_turn {
                None | Some(message::StartTurn::InPlace) => StartTurn::InPlace,
                Some(message::StartTurn::WhileMoving) => StartTurn::WhileMoving,
            },
            abilities: abilities(scene, any_order)?,
            costs: costs(scene, &footprint)?,
            full_report: scene.report == Some(message::Report::Full),
        })
    }

    /// Refuses a start or a goal outside of the free space.
    pub(super) fn check_inside(
        &self,
        scene: Scene<'_>,
        channels: Option<&[AxisBox<2>]>,
        walls: &Walls<2>,
        budget: &Budget<'_>,
    ) -> Result<(), Refused> {
        let ends = [
            (ErrorCode::BodyOutsideFreeSpace, "start.position", self.start.position),
            (ErrorCode::GoalOutsideFreeSpace, "goal.position", self.goal.position),
        ];
        for (code, field, position) in ends {
            let outside = |what: &str| {
                let refusal = Refusal::new(code, format!("{field} {what}"));
                Refused::from(Refusal { field: Some(field.to_owned()), ..refusal }).whole()
            };
            if let Some(channels) = channels {
                budget.step(channels.len() as u64)?;
                if !channels.iter().any(|channel| channel.holds(&position)) {
                    return Err(outside("is in none of the channels"));
                }
                continue;
            }
            if let Some(bounds) = &scene.free_space.bounds {
                let (min, max) = (check::vector::<2>(&bounds.min), check::vector::<2>(&bounds.max));
                let beyond = (0..2).find_map(|axis| {
                    let at = position[axis];
                    let ends = if at <= min[axis] { min[axis] } else { max[axis] };
                    (at <= min[axis] || at >= max[axis]).then_some((axis, ends, at))
                });
                if let Some(beyond) = beyond {
                    return Err(Refused::from(refuse::out_of_bounds(code, field, beyond)).whole());
                }
            }
            if let Some((solid, depth)) = walls.depth_in_solid(&position, budget)? {
                let refusal = refuse::in_solid(code, field, solid, depth);
                return Err(Refused::from(refusal).whole());
            }
        }
        Ok(())
    }

    /// The robot among walls at any angle.
    pub(super) fn among<'a>(&self, walls: &'a Walls<2>, floor: &'a Floor) -> any_angle::Errand<'a> {
        let Self { footprint, start, goal, start_turn, abilities, costs, .. } = *self;
        any_angle::Errand { footprint, start, goal, start_turn, abilities, costs, walls, floor }
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

fn footprint_of(footprint: &message::Footprint) -> Result<Footprint, Refusal> {
    let field = "body.footprint";
    let (made, sizes) = match *footprint {
        message::Footprint::Centered { width, length } => {
            (Footprint::new(width, length), [width, length, 0.0])
        }
        message::Footprint::Offset { width, front, rear } => {
            (Footprint::offset(width, front, rear), [width, front, rear])
        }
    };
    let made = made.map_err(|error| {
        let message = format!("{field}: {error}");
        let (has, least) = (Some(error.least()), Some(0.0));
        Refusal { has, least, ..Refusal::invalid(field, message) }
    })?;
    check::in_range(|| field.to_owned(), &sizes)?;
    Ok(made)
}

fn abilities(scene: Scene<'_>, any_order: bool) -> Result<Abilities, Refusal> {
    let &SceneRequest { reverse, turn_in_place, min_turn_radius, .. } = scene.request;
    let default = Abilities::default();
    if let Some(radius) = min_turn_radius {
        if !(radius.is_finite() && radius > 0.0) {
            let message = format!(
                "min_turn_radius is {} m; it must be finite and greater than 0",
                Number(radius)
            );
            let refusal = Refusal::invalid("min_turn_radius", message);
            return Err(Refusal { has: Some(radius), least: Some(0.0), ..refusal });
        }
        check::in_range(|| "min_turn_radius".to_owned(), &[radius])?;
    }
    if turn_in_place == Some(false) && min_turn_radius.is_none() {
        let message = "min_turn_radius is missing; a robot that can't turn in place needs it";
        return Err(Refusal::invalid("min_turn_radius", message));
    }
    let without_effect = [
        ("reverse", reverse == Some(true)),
        ("turn_in_place", turn_in_place == Some(false)),
        ("min_turn_radius", min_turn_radius.is_some()),
    ];
    if let Some((field, _)) = without_effect.into_iter().find(|(_, given)| *given)
        && !any_order
    {
        return Err(check::only_in_any_order(field));
    }
    Ok(Abilities {
        reverse: reverse.unwrap_or(default.reverse),
        turn_in_place: turn_in_place.unwrap_or(default.turn_in_place),
        min_turn_radius: min_turn_radius.unwrap_or(default.min_turn_radius),
    })
}

fn costs(scene: Scene<'_>, footprint: &Footprint) -> Result<Costs, Refusal> {
    let default = Costs::of(footprint);
    let cost = |field: &str, value: Option<f64>, default: f64, unit: &str| {
        let value = value.unwrap_or(default);
        check::not_negative(field, value, unit)?;
        check::in_range(|| field.to_owned(), &[value]).map(|()| value)
    };
    Ok(Costs {
        turn: cost("turn_cost", scene.turn_cost, default.turn, "m/rad")?,
        stop: cost("stop_cost", scene.stop_cost, default.stop, "m")?,
    })
}
