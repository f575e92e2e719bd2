//! Version 2 of recorded messages, readable for ever.
//!
//! What version 3 changed is frozen here: scenes, solids, bodies, limits and trajectories. Everything else is shared
//! with the current messages; whoever changes one of those copies its present form into this file.
//! `schemas/tests/pinned/version_2` and the recordings in `recordings/` hold the bytes.

use serde::Deserialize;

use super::{DecodeError, decode};
use crate::message::{
    self, AxisBox, Clearance, ClearanceWish, Digest, Direction, Footprint, Goal, Leg, Pose,
    Refusal, Report, RequestKey, Sample, Sampling, StartTurn, Task, Vector,
};

/// See [`message::Request`].
#[derive(Deserialize)]
struct Request {
    key: RequestKey,
    sent_ns: u64,
    content: RequestContent,
}

/// See [`message::RequestContent`].
#[derive(Deserialize)]
#[expect(clippy::large_enum_variant, reason = "nearly every request is a scene")]
enum RequestContent {
    Scene(SceneRequest),
    Unreadable { header: Vec<u64>, cells: Vec<u64> },
}

/// See [`message::SceneRequest`].
#[derive(Deserialize)]
struct SceneRequest {
    id: Option<u64>,
    task: Task,
    free_space: FreeSpace,
    body: Body,
    exit: Vec<Direction>,
    start: Option<Pose>,
    goal: Option<Goal>,
    start_turn: Option<StartTurn>,
    reverse: Option<bool>,
    turn_in_place: Option<bool>,
    min_turn_radius: Option<f64>,
    turn_cost: Option<f64>,
    stop_cost: Option<f64>,
    report: Option<Report>,
    clearance: ClearanceWish,
    limits: Limits,
    sampling: Option<Sampling>,
    deadline: Option<f64>,
}

/// See [`message::FreeSpace`].
#[derive(Deserialize)]
struct FreeSpace {
    channels: Option<Vec<AxisBox>>,
    in_order: bool,
    solids: Option<Vec<Solid>>,
    bounds: Option<AxisBox>,
    named: Option<Digest>,
}

/// See [`message::Solid`].
#[derive(Deserialize)]
pub(super) enum Solid {
    Polygon(Vec<Vector>),
    Box(AxisBox),
}

/// See [`message::Body`].
#[derive(Deserialize)]
enum Body {
    Polygon(Vec<Vector>),
    Box(AxisBox),
    Footprint(Footprint),
}

/// See [`message::Limits`].
#[derive(Deserialize)]
pub(super) struct Limits {
    speed: Option<f64>,
    acceleration: Option<f64>,
    yaw_rate: Option<f64>,
    yaw_acceleration: Option<f64>,
    lateral_acceleration: Option<f64>,
}

/// See [`message::ReplyPart`].
#[derive(Deserialize)]
struct ReplyPart {
    key: RequestKey,
    id: Option<u64>,
    sent_ns: u64,
    part: u32,
    last: bool,
    answer: u32,
    answers: u32,
    content: Result<Trajectory, Refusal>,
}

/// See [`message::Trajectory`].
#[derive(Deserialize)]
struct Trajectory {
    dimension: u32,
    gaps_per_junction: u32,
    exit: Option<Direction>,
    length: f64,
    bound: Option<f64>,
    complete: bool,
    duration: f64,
    clearance: Clearance,
    free_clearance: Option<f64>,
    gaps: Vec<f64>,
    route: Vec<u64>,
    channels: Vec<AxisBox>,
    legs: Vec<Leg>,
    samples: Vec<Sample>,
}

pub(super) fn request(bytes: &[u8]) -> Result<message::Request, DecodeError> {
    let Request { key, sent_ns, content } = decode(bytes)?;
    let content = match content {
        RequestContent::Scene(scene) => message::RequestContent::Scene(scene.upgrade()),
        RequestContent::Unreadable { header, cells } => {
            message::RequestContent::Unreadable { header, cells }
        }
    };
    Ok(message::Request { key, sent_ns, content })
}

pub(super) fn reply(bytes: &[u8]) -> Result<message::ReplyPart, DecodeError> {
    let ReplyPart { key, id, sent_ns, part, last, answer, answers, content } = decode(bytes)?;
    let content = content.map(Trajectory::upgrade);
    Ok(message::ReplyPart { key, id, sent_ns, part, last, answer, answers, content })
}

impl SceneRequest {
    fn upgrade(self) -> message::SceneRequest {
        let Self { id, task, free_space, body, exit, start, goal, start_turn, reverse, .. } = self;
        let Self { turn_in_place, min_turn_radius, turn_cost, stop_cost, report, .. } = self;
        let Self { clearance, limits, sampling, deadline, .. } = self;
        let FreeSpace { channels, in_order, solids, bounds, named } = free_space;
        let solids = solids.map(Solid::upgrade_all);
        message::SceneRequest {
            id,
            task,
            free_space: message::FreeSpace { channels, in_order, solids, bounds, named },
            body: match body {
                Body::Polygon(vertices) => message::Body::Polygon(vertices),
                Body::Box(sides) => message::Body::Box(sides),
                Body::Footprint(footprint) => message::Body::Footprint(footprint),
            },
            exit,
            start,
            goal,
            start_turn,
            reverse,
            turn_in_place,
            min_turn_radius,
            turn_cost,
            stop_cost,
            report,
            clearance,
            limits: limits.upgrade(),
            sampling,
            deadline,
            frames: None,
            corners: None,
            stop_at_joints: None,
            path: None,
        }
    }
}

impl Solid {
    pub(super) fn upgrade_all(solids: Vec<Self>) -> Vec<message::Solid> {
        let upgrade = |solid| match solid {
            Self::Polygon(vertices) => message::Solid::Polygon(vertices),
            Self::Box(sides) => message::Solid::Box(sides),
        };
        solids.into_iter().map(upgrade).collect()
    }
}

impl Limits {
    pub(super) fn upgrade(self) -> message::Limits {
        let Self { speed, acceleration, yaw_rate, yaw_acceleration, lateral_acceleration } = self;
        message::Limits {
            speed,
            acceleration,
            yaw_rate,
            yaw_acceleration,
            lateral_acceleration,
            jerk: None,
            yaw_jerk: None,
        }
    }
}

impl Trajectory {
    fn upgrade(self) -> message::Trajectory {
        let Self { dimension, gaps_per_junction, exit, length, bound, complete, .. } = self;
        let Self { duration, clearance, free_clearance, gaps, route, channels, .. } = self;
        let Self { legs, samples, .. } = self;
        message::Trajectory {
            dimension,
            gaps_per_junction,
            exit,
            length,
            bound,
            complete,
            duration,
            clearance,
            free_clearance,
            gaps,
            route,
            channels,
            legs,
            samples,
            exceeds: None,
            stops: None,
        }
    }
}
