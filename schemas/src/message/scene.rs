//! The scene request, from which the planner plans.
//!
//! The serde derives are the recorded form ([`crate::codec`]): the order of fields and
//! variants is fixed. JSON has types of its own ([`crate::json`]).

use serde::{Deserialize, Serialize};

use super::{Digest, Vector, named};

/// A scene to plan in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneRequest {
    /// Echoed in the reply.
    pub id: Option<u64>,
    /// What to plan.
    pub task: Task,
    /// Where the body can move.
    pub free_space: FreeSpace,
    /// What moves.
    pub body: Body,
    /// Assembly tasks: ways out of the part to try; `+z` if empty.
    pub exit: Vec<Direction>,
    /// Where the motion begins. Assembly tasks: the displacement from the assembled state or, with
    /// frames, where the moving part's frame is; by default where the task says.
    pub start: Option<Pose>,
    /// Where it ends, likewise.
    pub goal: Option<Goal>,
    /// Driving: how the robot takes up its first heading; by default in place.
    pub start_turn: Option<StartTurn>,
    /// Driving: whether the robot may drive backwards; by default not.
    pub reverse: Option<bool>,
    /// Driving: whether the robot can turn in place; by default it can.
    pub turn_in_place: Option<bool>,
    /// Driving: the least radius of the reference point's path, metres; by default any.
    pub min_turn_radius: Option<f64>,
    /// Driving: the length that a radian turned in place is worth, metres; by default a quarter of the
    /// robot's length.
    pub turn_cost: Option<f64>,
    /// Driving: the length that a stop is worth, metres; by default a tenth of the robot's
    /// length.
    pub stop_cost: Option<f64>,
    /// What the reply says of each trajectory.
    pub report: Option<Report>,
    /// The clearance gaps to plan with.
    pub clearance: ClearanceWish,
    /// How fast the body may move.
    pub limits: Limits,
    /// Where the motion is sampled; by default every 0.02 s.
    pub sampling: Option<Sampling>,
    /// Seconds from arrival within which the answer is useful.
    pub deadline: Option<f64>,
    /// Assembly tasks: where the parts stand in the base frame.
    pub frames: Option<Frames>,
    /// How the body passes from one straight leg to the next; by default sharp for parts, arcs for
    /// robots.
    pub corners: Option<Corners>,
    /// Driving: whether the robot stops wherever a leg meets another of a different curvature.
    pub stop_at_joints: Option<bool>,
    /// Assembly tasks through channels in travel order: which way through them; by default that of
    /// the rules.
    pub path: Option<PathChoice>,
}

impl SceneRequest {
    /// The same scene with nothing of its free space but the name.
    pub fn with_name_alone(&self) -> Self {
        let Self { body, exit, clearance, .. } = self;
        let named = self.free_space.named;
        Self {
            free_space: FreeSpace { named, ..FreeSpace::default() },
            body: body.clone(),
            exit: exit.clone(),
            clearance: clearance.clone(),
            ..*self
        }
    }

    /// A scene with nothing in it, to read another into.
    pub fn empty() -> Self {
        Self {
            id: None,
            task: Task::Disassemble,
            free_space: FreeSpace::default(),
            body: Body::Polygon(Vec::new()),
            exit: Vec::new(),
            start: None,
            goal: None,
            start_turn: None,
            reverse: None,
            turn_in_place: None,
            min_turn_radius: None,
            turn_cost: None,
            stop_cost: None,
            report: None,
            clearance: ClearanceWish::Safest,
            limits: Limits::default(),
            sampling: None,
            deadline: None,
            frames: None,
            corners: None,
            stop_at_joints: None,
            path: None,
        }
    }
}

named! {
/// What to plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Task {
    /// The body moves from the assembled state out of the part (paper, section 3).
    Disassemble = "disassemble",
    /// The exact reverse of `disassemble`.
    Assemble = "assemble",
    /// A rectangular mobile robot drives through corridors (paper, section 5).
    Drive = "drive",
}
}

/// Where the body can move: by channels, by solids, by both, or by a name alone.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FreeSpace {
    /// The channels.
    pub channels: Option<Vec<AxisBox>>,
    /// Whether the channels are listed in travel order, none skipped.
    pub in_order: bool,
    /// What the body must not touch.
    pub solids: Option<Vec<Solid>>,
    /// Where the free space between the solids ends.
    pub bounds: Option<AxisBox>,
    /// Its name. Beside the content it makes the free space known to the planner; alone it stands
    /// for a free space that the planner knows.
    pub named: Option<Digest>,
}

/// A box with sides parallel to the axes; metres.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct AxisBox {
    /// The corner with the least coordinates.
    pub min: Vector,
    /// The corner with the greatest coordinates.
    pub max: Vector,
}

/// Something solid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Solid {
    /// A simple polygon by its vertices, in either sense; metres.
    Polygon(Vec<Vector>),
    /// A box.
    Box(AxisBox),
    /// The union of boxes, at least one. They may overlap, touch and be apart.
    Boxes(Vec<AxisBox>),
}

/// What moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Body {
    /// A simple polygon where it is in the assembled state; metres.
    Polygon(Vec<Vector>),
    /// A box where it is in the assembled state.
    Box(AxisBox),
    /// The mobile robot.
    Footprint(Footprint),
    /// The union of boxes where they are in the assembled state, at least one: they may overlap,
    /// touch and be apart, and move together.
    Boxes(Vec<AxisBox>),
}

/// The rectangle that a mobile robot covers; metres. The reference point, whose poses the
/// request and the reply give, is in the middle of its width.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Footprint {
    /// The reference point is the centre.
    Centered {
        /// Across the heading.
        width: f64,
        /// Along the heading.
        length: f64,
    },
    /// The reference point is anywhere between the ends.
    Offset {
        /// Across the heading.
        width: f64,
        /// From the reference point to the front end.
        front: f64,
        /// From the reference point to the rear end.
        rear: f64,
    },
}

impl Footprint {
    /// Across the heading, metres.
    pub fn width(&self) -> f64 {
        match *self {
            Self::Centered { width, .. } | Self::Offset { width, .. } => width,
        }
    }

    /// From the reference point to the front end, metres.
    pub fn front(&self) -> f64 {
        match *self {
            Self::Centered { length, .. } => length / 2.0,
            Self::Offset { front, .. } => front,
        }
    }

    /// From the reference point to the rear end, metres.
    pub fn rear(&self) -> f64 {
        match *self {
            Self::Centered { length, .. } => length / 2.0,
            Self::Offset { rear, .. } => rear,
        }
    }
}

named! {
/// What the reply says of each trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Report {
    /// Everything, for channels in travel order too.
    Full = "full",
}
}

named! {
/// A direction along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Direction {
    /// Towards greater x.
    PlusX = "+x",
    /// Towards smaller x.
    MinusX = "-x",
    /// Towards greater y.
    PlusY = "+y",
    /// Towards smaller y.
    MinusY = "-y",
    /// Towards greater z.
    PlusZ = "+z",
    /// Towards smaller z.
    MinusZ = "-z",
}
}

/// Where the robot stands, or where a part's frame is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// The footprint's reference point, or the frame's origin, metres.
    pub position: Vector,
    /// Radians counter-clockwise from +x; in (x, z) from +x towards +z.
    pub heading: f64,
}

/// Where the robot goes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Goal {
    /// The footprint's reference point, metres.
    pub position: Vector,
    /// Radians counter-clockwise from +x; by default the heading with which it arrives.
    pub heading: Option<f64>,
}

named! {
/// How the robot takes up its first heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum StartTurn {
    /// It turns in place before it drives.
    InPlace = "in_place",
    /// It turns on the way to the first arriving point, as in the paper.
    WhileMoving = "while_moving",
}
}

/// A clearance gap: one number for all axes, or one per axis (equation 3.1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Gap {
    /// The same along every axis; metres.
    Uniform(f64),
    /// One number per axis; metres.
    PerAxis(Vector),
}

/// The gaps of one of several answers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Choice {
    /// The same at every junction.
    Gap(Gap),
    /// One per junction, in travel order.
    Gaps(Vec<Gap>),
    /// The gap that leaves the greatest clearance.
    Safest,
    /// Driving: the shortest motion with at least this free clearance, metres.
    AtLeast(f64),
}

/// The clearance gaps to plan with: for one answer, or for several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ClearanceWish {
    /// The same gap at every junction.
    Gap(Gap),
    /// One gap per junction, in travel order.
    Gaps(Vec<Gap>),
    /// The gap that leaves the greatest clearance.
    Safest,
    /// An answer to each of these.
    Each(Vec<Choice>),
    /// This many answers, without samples, from the shortest path to the safest.
    Curve(u64),
    /// Driving: the shortest motion with at least this free clearance, metres.
    AtLeast(f64),
}

/// Where the parts of an assembly scene stand in the base frame. Channels, solids and the exit are
/// in the fixed part's frame, the body in the moving part's (paper, section 4).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Frames {
    /// The fixed (female) part.
    pub fixed: Pose,
    /// The fixed part at the end of the motion, if it does not stay where it is.
    pub fixed_at_end: Option<Pose>,
    /// The moving (male) part in the assembled state; by default where the fixed part is then.
    pub moving: Option<Pose>,
    /// What the samples are given in; by default as displacements.
    pub samples: Option<SampleFrame>,
}

named! {
/// What the samples of an assembly task are given in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum SampleFrame {
    /// The fixed part's frame: displacements from the assembled state.
    Fixed = "fixed",
    /// The base frame: poses of the moving part's frame.
    Base = "base",
}
}

named! {
/// How the body passes from one straight leg to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Corners {
    /// It stops at every way-point.
    Sharp = "sharp",
    /// Along arcs.
    Arc = "arc",
    /// Along curves of continuous curvature.
    Smooth = "smooth",
}
}

named! {
/// Which way a part takes through channels in travel order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum PathChoice {
    /// By the rules of Table 1.
    Rules = "rules",
    /// The shortest that keeps the gap.
    Shortest = "shortest",
}
}

/// How fast the body may move; a limit that is not given has its default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Limits {
    /// m/s; default 1.0.
    pub speed: Option<f64>,
    /// Along the path, m/s²; default 0.5.
    pub acceleration: Option<f64>,
    /// rad/s; default 1.0.
    pub yaw_rate: Option<f64>,
    /// While turning in place, rad/s²; default 1.0.
    pub yaw_acceleration: Option<f64>,
    /// Across the path, m/s²; default 0.5.
    pub lateral_acceleration: Option<f64>,
    /// Along the path, m/s³; by default there is none.
    pub jerk: Option<f64>,
    /// While turning in place, rad/s³; by default there is none.
    pub yaw_jerk: Option<f64>,
}

/// Where the motion is sampled. The ends of all legs are always samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Sampling {
    /// A sample every this many seconds.
    Period(f64),
    /// A sample every this many metres of arc length.
    Spacing(f64),
    /// This many samples, evenly spaced in time.
    Count(u64),
}
