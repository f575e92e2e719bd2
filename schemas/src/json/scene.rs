//! The scene request in JSON.

use serde::de::Error;
use serde::{Deserialize, Serialize};

use super::clearance::WishJson;
use super::digest::DigestJson;
use super::fault::Fault;
use super::footprint::FootprintJson;
use super::half_space::IntersectionJson;
use super::values::{BoxJson, Element, List, Numbers, Point, Word, Words};
use crate::message::{
    AxisBox, Body, Corners, Direction, Frames, FreeSpace, Goal, Limits, PathChoice, Pose, Report,
    SampleFrame, Sampling, SceneRequest, Solid, StartTurn, Task, Vector,
};

/// A scene request: where to plan, what moves, and how. Lengths are in metres, angles
/// in radians, times in seconds. Frames are right-handed with z up; assembly scenes in two
/// dimensions are in the plane (x, z), driving scenes in (x, y). Coordinates and sizes are
/// between -1e150 and 1e150. `null` is the same as a field left out.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct SceneJson<'a> {
    /// Echoed in the reply.
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<u64>,
    /// What to plan.
    task: Word<Task>,
    /// Where the body can move.
    free_space: FreeSpaceJson<'a>,
    /// What moves.
    body: BodyJson<'a>,
    /// Assembly tasks only: the direction in which the body leaves the part, or several of
    /// which the one with the shortest path is taken. Default: `"+z"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    exit: Option<Words<'a, Direction>>,
    /// Where the motion begins. `drive` requires it: where the robot stands. Assembly tasks: the
    /// displacement from the assembled state or, with `frames`, where the moving part's frame is in
    /// the base frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    start: Option<StartJson>,
    /// Where the motion ends. `drive` requires it: where the robot goes. Assembly tasks: as `start`.
    #[serde(skip_serializing_if = "Option::is_none")]
    goal: Option<GoalJson>,
    /// `drive` only: how the robot takes up its first heading. Default: `"in_place"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    start_turn: Option<Word<StartTurn>>,
    /// `drive` only: whether the robot may drive backwards. Default: false.
    #[serde(skip_serializing_if = "Option::is_none")]
    reverse: Option<bool>,
    /// `drive` only: whether the robot can turn in place; without, `min_turn_radius` is required.
    /// Default: true.
    #[serde(skip_serializing_if = "Option::is_none")]
    turn_in_place: Option<bool>,
    /// `drive` only: the least radius of the curve that the reference point follows, metres;
    /// greater than 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    min_turn_radius: Option<f64>,
    /// `drive` only: the length that a radian turned in place counts as where motions are
    /// compared, metres; at least 0. Default: a quarter of the robot's length.
    #[serde(skip_serializing_if = "Option::is_none")]
    turn_cost: Option<f64>,
    /// `drive` only: the length that a stop on the way counts as where motions are compared,
    /// metres; at least 0. Default: a tenth of the robot's length.
    #[serde(skip_serializing_if = "Option::is_none")]
    stop_cost: Option<f64>,
    /// Through channels in travel order: `"full"` for `bound` in trajectories, and in those of `drive`
    /// `free_clearance`.
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<Word<Report>>,
    /// The clearance gaps to plan with; one answer, or several.
    clearance: WishJson<'a>,
    /// How fast the body may move.
    #[serde(skip_serializing_if = "Option::is_none")]
    limits: Option<LimitsJson>,
    /// Which states of the motion the reply has. The ends of all legs are always among
    /// them. Default: one every 0.02 s.
    #[serde(skip_serializing_if = "Option::is_none")]
    sampling: Option<SamplingJson>,
    /// Seconds from the request's arrival within which the answer is useful; greater
    /// than 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    deadline: Option<f64>,
    /// Assembly tasks only: where the parts stand in the base frame. Channels, solids, bounds and
    /// the exit are in the fixed part's frame, the body's coordinates in the moving part's.
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<FramesJson>,
    /// How the body passes from one straight leg to the next. Default: `"sharp"` for assembly tasks,
    /// `"arc"` for `drive`.
    #[serde(skip_serializing_if = "Option::is_none")]
    corners: Option<Word<Corners>>,
    /// `drive` only: whether the robot stops wherever the curvature of its path jumps. Default:
    /// false.
    #[serde(skip_serializing_if = "Option::is_none")]
    stop_at_joints: Option<bool>,
    /// Assembly tasks through channels in travel order only: the way by the rules, or the shortest
    /// that keeps the gap. Default: `"rules"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    path: Option<Word<PathChoice>>,
}

impl<'a> From<&'a SceneRequest> for SceneJson<'a> {
    fn from(scene: &'a SceneRequest) -> Self {
        let SceneRequest {
            id,
            task,
            free_space,
            body,
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
            limits,
            sampling,
            deadline,
            frames,
            corners,
            stop_at_joints,
            path,
        } = scene;
        Self {
            id: *id,
            task: Word(*task),
            free_space: free_space.into(),
            body: body.into(),
            exit: (!exit.is_empty()).then(|| exit.as_slice().into()),
            start: start.map(|start| StartJson::of(start, *task)),
            goal: goal.map(GoalJson::from),
            start_turn: start_turn.map(Word),
            reverse: *reverse,
            turn_in_place: *turn_in_place,
            min_turn_radius: *min_turn_radius,
            turn_cost: *turn_cost,
            stop_cost: *stop_cost,
            report: report.map(Word),
            clearance: clearance.into(),
            limits: (*limits != Limits::default()).then(|| LimitsJson::from(*limits)),
            sampling: sampling.map(SamplingJson::from),
            deadline: *deadline,
            frames: frames.map(FramesJson::from),
            corners: corners.map(Word),
            stop_at_joints: *stop_at_joints,
            path: path.map(Word),
        }
    }
}

impl SceneJson<'_> {
    pub(super) fn into_message(self) -> Result<SceneRequest, Fault> {
        let Self {
            id,
            task,
            free_space,
            body,
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
            limits,
            sampling,
            deadline,
            frames,
            corners,
            stop_at_joints,
            path,
        } = self;
        Ok(SceneRequest {
            id,
            task: task.0,
            free_space: free_space.into(),
            body: body.into_message().map_err(|fault| fault.in_field("body"))?,
            exit: exit.map_or_else(Vec::new, Vec::from),
            start: start.map(|start| start.into_message(task.0)).transpose()?,
            goal: goal.map(Goal::from),
            start_turn: start_turn.map(|Word(turn)| turn),
            reverse,
            turn_in_place,
            min_turn_radius,
            turn_cost,
            stop_cost,
            report: report.map(|Word(report)| report),
            clearance: clearance.into(),
            limits: limits.map_or_else(Limits::default, Limits::from),
            sampling: sampling.map(Sampling::from),
            deadline,
            frames: frames.map(Frames::from),
            corners: corners.map(|Word(corners)| corners),
            stop_at_joints,
            path: path.map(|Word(path)| path),
        })
    }
}

/// Where the body can move, given by channels, by solids, or by both: then the channels say where
/// to travel, and clearance is measured to the solids. Or by the name alone of a free space that
/// the planner knows.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema), schemars(rename = "free_space"))]
#[serde(deny_unknown_fields)]
struct FreeSpaceJson<'a> {
    /// Boxes in which the body can move; at least one.
    #[serde(skip_serializing_if = "Option::is_none")]
    channels: Option<List<'a, AxisBox>>,
    /// Whether the channels are listed in travel order, none skipped. Default: false.
    #[serde(skip_serializing_if = "Option::is_none")]
    in_order: Option<bool>,
    /// What the body must not touch.
    #[serde(skip_serializing_if = "Option::is_none")]
    solids: Option<List<'a, Solid>>,
    /// Where the free space between the solids ends. Required for `drive` with solids but no
    /// channels. Default for assembly tasks: the bounding box of the solids, open on the exit side.
    #[serde(skip_serializing_if = "Option::is_none")]
    bounds: Option<BoxJson>,
    /// The SHA-256 of the free space's canonical outlines. Beside the content it makes the free
    /// space known to the planner; alone it stands for the content.
    #[serde(skip_serializing_if = "Option::is_none")]
    named: Option<DigestJson>,
}

impl<'a> From<&'a FreeSpace> for FreeSpaceJson<'a> {
    fn from(FreeSpace { channels, in_order, solids, bounds, named }: &'a FreeSpace) -> Self {
        Self {
            channels: channels.as_deref().map(List::from),
            in_order: in_order.then_some(true),
            solids: solids.as_deref().map(List::from),
            bounds: bounds.as_ref().map(BoxJson::from),
            named: named.map(DigestJson),
        }
    }
}

impl From<FreeSpaceJson<'_>> for FreeSpace {
    fn from(json: FreeSpaceJson) -> Self {
        let FreeSpaceJson { channels, in_order, solids, bounds, named } = json;
        Self {
            channels: channels.map(Vec::from),
            in_order: in_order.unwrap_or_default(),
            solids: solids.map(Vec::from),
            bounds: bounds.map(Into::into),
            named: named.map(|DigestJson(digest)| digest),
        }
    }
}

/// Something solid.
#[derive(Serialize, Deserialize)]
#[cfg_attr(
    feature = "json-schema",
    derive(schemars::JsonSchema),
    schemars(rename = "solid", transform = super::schema::allow_null_alternatives)
)]
#[serde(rename_all = "snake_case")]
pub(super) enum SolidJson<'a> {
    /// The vertices of a simple polygon, in either sense; at least 3, metres.
    Polygon(List<'a, Vector>),
    /// A box.
    Box(BoxJson),
    /// Half-spaces, whose intersection is a box.
    #[serde(skip_serializing)]
    HalfSpaces(IntersectionJson),
    /// Boxes, whose union is solid; at least one. They may overlap, touch and be apart.
    Boxes(List<'a, AxisBox>),
}

impl<'a> From<&'a Solid> for SolidJson<'a> {
    fn from(solid: &'a Solid) -> Self {
        match solid {
            Solid::Boxes(boxes) => Self::Boxes(boxes.as_slice().into()),
            Solid::Polygon(vertices) => Self::Polygon(vertices.as_slice().into()),
            Solid::Box(sides) => Self::Box(sides.into()),
        }
    }
}

impl Element for Solid {
    type Json<'a> = SolidJson<'a>;

    fn from_json<E: Error>(json: SolidJson) -> Result<Self, E> {
        Ok(match json {
            SolidJson::Polygon(vertices) => Self::Polygon(vertices.into()),
            SolidJson::Box(sides) | SolidJson::HalfSpaces(IntersectionJson(sides)) => {
                Self::Box(sides.into())
            }
            SolidJson::Boxes(boxes) => Self::Boxes(boxes.into()),
        })
    }
}

/// What moves: for assembly tasks a polygon, a box or a union of boxes where it is in the assembled
/// state, for `drive` a footprint.
#[derive(Serialize, Deserialize)]
#[cfg_attr(
    feature = "json-schema",
    derive(schemars::JsonSchema),
    schemars(rename = "body", transform = super::schema::allow_null_alternatives)
)]
#[serde(rename_all = "snake_case")]
enum BodyJson<'a> {
    /// The vertices of a simple polygon, in either sense; at least 3, metres.
    Polygon(List<'a, Vector>),
    /// A box.
    Box(BoxJson),
    /// Half-spaces, whose intersection is a box.
    #[serde(skip_serializing)]
    HalfSpaces(IntersectionJson),
    /// The rectangle that a mobile robot covers.
    Footprint(FootprintJson),
    /// Boxes, whose union moves; at least one. They may overlap, touch and be apart.
    Boxes(List<'a, AxisBox>),
}

impl<'a> From<&'a Body> for BodyJson<'a> {
    fn from(body: &'a Body) -> Self {
        match body {
            Body::Polygon(vertices) => Self::Polygon(vertices.as_slice().into()),
            Body::Box(sides) => Self::Box(sides.into()),
            Body::Footprint(footprint) => Self::Footprint((*footprint).into()),
            Body::Boxes(boxes) => Self::Boxes(boxes.as_slice().into()),
        }
    }
}

impl BodyJson<'_> {
    fn into_message(self) -> Result<Body, Fault> {
        Ok(match self {
            Self::Polygon(vertices) => Body::Polygon(vertices.into()),
            Self::Box(sides) | Self::HalfSpaces(IntersectionJson(sides)) => Body::Box(sides.into()),
            Self::Footprint(footprint) => Body::Footprint(
                footprint.into_message().map_err(|fault| fault.in_field("footprint"))?,
            ),
            Self::Boxes(boxes) => Body::Boxes(boxes.into()),
        })
    }
}

/// The forms of a type of which the message has the same fields.
macro_rules! same_fields {
    ($Json:ident, $Message:ident { $($field:ident),+ }) => {
        impl From<$Message> for $Json {
            fn from($Message { $($field),+ }: $Message) -> Self {
                Self { $($field: $field.into()),+ }
            }
        }

        impl From<$Json> for $Message {
            fn from($Json { $($field),+ }: $Json) -> Self {
                Self { $($field: $field.into()),+ }
            }
        }
    };
}

impl From<Vector> for Point {
    fn from(vector: Vector) -> Self {
        Numbers(vector)
    }
}

impl From<Point> for Vector {
    fn from(point: Point) -> Self {
        point.0
    }
}

/// Where a frame is.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema), schemars(rename = "pose"))]
#[serde(deny_unknown_fields)]
struct PoseJson {
    /// Its origin, metres.
    position: Point,
    /// Radians counter-clockwise from +x; in (x, z) from +x towards +z.
    heading: f64,
}

same_fields!(PoseJson, Pose { position, heading });

/// Where the motion begins.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema), schemars(rename = "start"))]
#[serde(deny_unknown_fields)]
struct StartJson {
    /// The footprint's reference point; a part's displacement, or its frame's origin; metres.
    position: Point,
    /// `drive` only, which requires it: radians counter-clockwise from +x.
    #[serde(skip_serializing_if = "Option::is_none")]
    heading: Option<f64>,
}

impl StartJson {
    fn of(Pose { position, heading }: Pose, task: Task) -> Self {
        let heading = (task == Task::Drive || heading != 0.0).then_some(heading);
        Self { position: Numbers(position), heading }
    }

    fn into_message(self, task: Task) -> Result<Pose, Fault> {
        let missing = || Fault::missing().in_field("heading").in_field("start");
        let heading = match self.heading {
            None if task == Task::Drive => return Err(missing()),
            heading => heading.unwrap_or(0.0),
        };
        Ok(Pose { position: self.position.0, heading })
    }
}

/// Where the parts of an assembly scene stand in the base frame.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema), schemars(rename = "frames"))]
#[serde(deny_unknown_fields)]
struct FramesJson {
    /// The fixed (female) part.
    fixed: PoseJson,
    /// The fixed part at the end of the motion. Default: it stays where it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    fixed_at_end: Option<PoseJson>,
    /// The moving (male) part in the assembled state. Default: its frame is the fixed part's.
    #[serde(skip_serializing_if = "Option::is_none")]
    moving: Option<PoseJson>,
    /// What the samples are given in. Default: `"fixed"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<Word<SampleFrame>>,
}

impl From<Frames> for FramesJson {
    fn from(Frames { fixed, fixed_at_end, moving, samples }: Frames) -> Self {
        Self {
            fixed: fixed.into(),
            fixed_at_end: fixed_at_end.map(PoseJson::from),
            moving: moving.map(PoseJson::from),
            samples: samples.map(Word),
        }
    }
}

impl From<FramesJson> for Frames {
    fn from(FramesJson { fixed, fixed_at_end, moving, samples }: FramesJson) -> Self {
        Self {
            fixed: fixed.into(),
            fixed_at_end: fixed_at_end.map(Pose::from),
            moving: moving.map(Pose::from),
            samples: samples.map(|Word(frame)| frame),
        }
    }
}

/// Where the robot goes.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema), schemars(rename = "goal"))]
#[serde(deny_unknown_fields)]
struct GoalJson {
    /// The footprint's reference point, metres.
    position: Point,
    /// Radians counter-clockwise from +x. Default: the heading with which the robot
    /// arrives.
    #[serde(skip_serializing_if = "Option::is_none")]
    heading: Option<f64>,
}

same_fields!(GoalJson, Goal { position, heading });

/// How fast the body may move; each at least 1e-9 and at most 1e12.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "json-schema", derive(schemars::JsonSchema), schemars(rename = "limits"))]
#[serde(deny_unknown_fields)]
struct LimitsJson {
    /// m/s. Default: 1.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    speed: Option<f64>,
    /// Along the path, m/s². Default: 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    acceleration: Option<f64>,
    /// `drive` only: rad/s. Default: 1.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    yaw_rate: Option<f64>,
    /// `drive` only: while turning in place, rad/s². Default: 1.0.
    #[serde(skip_serializing_if = "Option::is_none")]
    yaw_acceleration: Option<f64>,
    /// `drive` only: across the path, m/s². Default: 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    lateral_acceleration: Option<f64>,
    /// Along the path, m/s³. Default: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    jerk: Option<f64>,
    /// `drive` only: while turning in place, rad/s³. Default: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    yaw_jerk: Option<f64>,
}

same_fields!(
    LimitsJson,
    Limits {
        speed,
        acceleration,
        yaw_rate,
        yaw_acceleration,
        lateral_acceleration,
        jerk,
        yaw_jerk
    }
);

/// Which states of the motion the reply has.
#[derive(Serialize, Deserialize)]
#[cfg_attr(
    feature = "json-schema",
    derive(schemars::JsonSchema),
    schemars(rename = "sampling", transform = super::schema::allow_null_alternatives)
)]
#[serde(rename_all = "snake_case")]
enum SamplingJson {
    /// Seconds from one to the next.
    Period(f64),
    /// Metres of arc length from one to the next; turns in place every 0.05 rad.
    Spacing(f64),
    /// How many, evenly spaced in time.
    Count(u64),
}

impl From<Sampling> for SamplingJson {
    fn from(sampling: Sampling) -> Self {
        match sampling {
            Sampling::Period(period) => Self::Period(period),
            Sampling::Spacing(spacing) => Self::Spacing(spacing),
            Sampling::Count(count) => Self::Count(count),
        }
    }
}

impl From<SamplingJson> for Sampling {
    fn from(json: SamplingJson) -> Self {
        match json {
            SamplingJson::Period(period) => Self::Period(period),
            SamplingJson::Spacing(spacing) => Self::Spacing(spacing),
            SamplingJson::Count(count) => Self::Count(count),
        }
    }
}
