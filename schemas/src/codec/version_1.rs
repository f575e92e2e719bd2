//! Version 1 of recorded messages, readable for ever.
//!
//! What version 2 changed is frozen here: scenes, footprints, trajectories, legs and refusals.
//! Everything else is shared with the current messages; whoever changes one of those copies its present form
//! into this file. `schemas/tests/pinned/version_1` and the recordings in `recordings/`
//! hold the bytes.

use serde::Deserialize;

use super::version_2::{Limits, Solid};
use super::{DecodeError, decode};
use crate::message::{
    self, AxisBox, Clearance, ClearanceWish, Curve, Direction, ErrorCode, Goal, Pose, RequestKey,
    Rule, Sample, Sampling, StartTurn, Task, Vector,
};
use crate::wire::previous;

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
}

/// See [`message::Body`].
#[derive(Deserialize)]
enum Body {
    Polygon(Vec<Vector>),
    Box(AxisBox),
    Footprint { width: f64, length: f64 },
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
    duration: f64,
    clearance: Clearance,
    gaps: Vec<f64>,
    route: Vec<u64>,
    channels: Vec<AxisBox>,
    legs: Vec<Leg>,
    samples: Vec<Sample>,
}

/// See [`message::Leg`].
#[derive(Deserialize)]
struct Leg {
    curve: Curve,
    length: f64,
    clearance: f64,
    junction: Option<u64>,
    rule: Option<Rule>,
}

/// See [`message::Refusal`].
#[derive(Deserialize)]
struct Refusal {
    code: ErrorCode,
    #[serde(deserialize_with = "message::text")]
    message: String,
    #[serde(deserialize_with = "message::optional_text")]
    field: Option<String>,
    junction: Option<u64>,
    axis: Option<u32>,
    needs: Option<f64>,
    has: Option<f64>,
    least: Option<f64>,
    most: Option<f64>,
    heading: Option<f64>,
}

pub(super) fn request(bytes: &[u8]) -> Result<message::Request, DecodeError> {
    let Request { key, sent_ns, content } = decode(bytes)?;
    let content = match content {
        RequestContent::Scene(scene) => message::RequestContent::Scene(scene.upgrade()),
        RequestContent::Unreadable { header, cells } => {
            message::RequestContent::Unreadable { header: upgrade_header(&header), cells }
        }
    };
    Ok(message::Request { key, sent_ns, content })
}

/// The header kept with unreadable memory, as a planner of the current version sees it.
fn upgrade_header(words: &[u64]) -> Vec<u64> {
    let mut old = previous::RequestHeader::default();
    let length = words.len().min(old.0.len());
    old.0[..length].copy_from_slice(&words[..length]);
    bytemuck::cast_slice(bytemuck::bytes_of(&previous::upgrade_request(&old))).to_vec()
}

pub(super) fn reply(bytes: &[u8]) -> Result<message::ReplyPart, DecodeError> {
    let ReplyPart { key, id, sent_ns, part, last, answer, answers, content } = decode(bytes)?;
    let content = content.map(Trajectory::upgrade).map_err(Refusal::upgrade);
    Ok(message::ReplyPart { key, id, sent_ns, part, last, answer, answers, content })
}

impl SceneRequest {
    fn upgrade(self) -> message::SceneRequest {
        let Self { id, task, free_space, body, exit, start, goal, .. } = self;
        let Self { start_turn, clearance, limits, sampling, deadline, .. } = self;
        let FreeSpace { channels, in_order, solids, bounds } = free_space;
        let solids = solids.map(Solid::upgrade_all);
        message::SceneRequest {
            id,
            task,
            free_space: message::FreeSpace { channels, in_order, solids, bounds, named: None },
            body: match body {
                Body::Polygon(vertices) => message::Body::Polygon(vertices),
                Body::Box(sides) => message::Body::Box(sides),
                Body::Footprint { width, length } => {
                    message::Body::Footprint(message::Footprint::Centered { width, length })
                }
            },
            exit,
            start,
            goal,
            start_turn,
            reverse: None,
            turn_in_place: None,
            min_turn_radius: None,
            turn_cost: None,
            stop_cost: None,
            report: None,
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

impl Trajectory {
    fn upgrade(self) -> message::Trajectory {
        let Self { dimension, gaps_per_junction, exit, length, duration, clearance, .. } = self;
        let Self { gaps, route, channels, legs, samples, .. } = self;
        message::Trajectory {
            dimension,
            gaps_per_junction,
            exit,
            length,
            bound: None,
            complete: true,
            duration,
            clearance,
            free_clearance: None,
            gaps,
            route,
            channels,
            legs: legs.into_iter().map(Leg::upgrade).collect(),
            samples,
            exceeds: None,
            stops: None,
        }
    }
}

impl Leg {
    fn upgrade(self) -> message::Leg {
        let Self { curve, length, clearance, junction, rule } = self;
        message::Leg { curve, length, clearance, junction, rule, reverse: false, rung: None }
    }
}

impl Refusal {
    fn upgrade(self) -> message::Refusal {
        let Self { code, message, field, junction, axis, needs, has, least, most, heading } = self;
        let setting = None;
        message::Refusal {
            code,
            message,
            field,
            junction,
            axis,
            needs,
            has,
            least,
            most,
            heading,
            setting,
        }
    }
}
