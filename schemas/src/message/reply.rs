//! The reply: trajectories, or why there are none.

use std::fmt;

use serde::de::Visitor;
use serde::{Deserialize, Deserializer, Serialize};

use super::{AxisBox, Direction, RequestKey, Sample, Vector, named};

/// A whole reply, put together from its parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Reply {
    /// The request's key.
    pub key: RequestKey,
    /// The request's id.
    pub id: Option<u64>,
    /// An answer for each clearance asked for, or why the whole request is refused.
    pub answers: Result<Vec<Answer>, Refusal>,
}

/// The answer for one clearance asked for.
pub type Answer = Result<Trajectory, Refusal>;

/// One bus message of a reply: what `/planner/reply` records. Long replies have
/// several; the lists of a trajectory continue from part to part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReplyPart {
    /// The request's key.
    pub key: RequestKey,
    /// The request's id.
    pub id: Option<u64>,
    /// When the planner sent it.
    pub sent_ns: u64,
    /// Counts the parts of this reply, from 0.
    pub part: u32,
    /// Whether this is the reply's last part.
    pub last: bool,
    /// Which answer it belongs to, from 0.
    pub answer: u32,
    /// How many answers the reply has; 0 if the whole request is refused.
    pub answers: u32,
    /// The answer, or what this part has of it.
    pub content: Answer,
}

/// A planned and sampled motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trajectory {
    /// How many coordinates positions have: 2 or 3.
    pub dimension: u32,
    /// How many gaps `gaps` has for each junction: the dimension for assembly tasks, 1 for driving.
    pub gaps_per_junction: u32,
    /// The way out that was taken, if the request gave several.
    pub exit: Option<Direction>,
    /// Arc length, metres.
    pub length: f64,
    /// Length of the shortest curve of the reference point that keeps the same free clearance,
    /// metres: no drive is shorter.
    pub bound: Option<f64>,
    /// Whether the search ended by itself and not because the budget was spent.
    pub complete: bool,
    /// Seconds.
    pub duration: f64,
    /// How close the body comes to the walls.
    pub clearance: Clearance,
    /// Distance that the body keeps from all walls but those that it is closer to at the start or
    /// the goal, metres; infinite where there are no walls.
    pub free_clearance: Option<f64>,
    /// The gaps used, junction by junction in travel order; metres.
    pub gaps: Vec<f64>,
    /// Indices of the channels travelled, in travel order.
    pub route: Vec<u64>,
    /// The channels, if the planner made them.
    pub channels: Vec<AxisBox>,
    /// The pieces of the path.
    pub legs: Vec<Leg>,
    /// States of the motion, times strictly increasing.
    pub samples: Vec<Sample>,
    /// The limit that the motion does not obey, if the request asks how corners are passed or for
    /// a full report.
    pub exceeds: Option<Exceeds>,
    /// If the request asks for smooth corners: at how many joints of legs the body stops because no
    /// smooth corner fits. Turns in place and changes between driving forwards and backwards don't
    /// count.
    pub stops: Option<u64>,
}

/// A limit that a motion does not obey.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Exceeds {
    /// The limit.
    pub limit: ExceededLimit,
    /// At how many joints of legs.
    pub joints: u64,
    /// The greatest jump there of what the limit bounds the rate of, rad/s.
    pub jump: f64,
}

named! {
/// A limit that a motion may not obey.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ExceededLimit {
    /// The yaw rate jumps where the curvature does.
    YawAcceleration = "yaw_acceleration",
}
}

/// A trajectory with nothing in it, complete.
impl Default for Trajectory {
    fn default() -> Self {
        Self {
            dimension: 0,
            gaps_per_junction: 0,
            exit: None,
            length: 0.0,
            bound: None,
            complete: true,
            duration: 0.0,
            clearance: Clearance::default(),
            free_clearance: None,
            gaps: Vec::new(),
            route: Vec::new(),
            channels: Vec::new(),
            legs: Vec::new(),
            samples: Vec::new(),
            exceeds: None,
            stops: None,
        }
    }
}

/// How close the body comes to the walls, and where.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Clearance {
    /// Exact least distance over the whole motion, metres.
    pub value: f64,
    /// Arc length where it is met, metres.
    pub at: f64,
    /// The wall point that is that close, metres.
    pub wall: Vector,
}

/// One piece of a path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Leg {
    /// The curve that the body's reference point follows.
    pub curve: Curve,
    /// Arc length, metres.
    pub length: f64,
    /// Least distance to the walls on it, metres: exact, but on a clothoid certified from below.
    pub clearance: f64,
    /// The junction it leads to or turns in, counted from 0 in travel order.
    pub junction: Option<u64>,
    /// The paper's rule that chose it.
    pub rule: Option<Rule>,
    /// Whether the robot drives it backwards: a line, an arc or a clothoid.
    pub reverse: bool,
    /// How it was found.
    pub rung: Option<Rung>,
}

impl Leg {
    /// A leg driven forwards, without junction, rule and rung.
    pub fn new(curve: Curve, length: f64, clearance: f64) -> Self {
        let (junction, rule, rung) = (None, None, None);
        Self { curve, length, clearance, junction, rule, reverse: false, rung }
    }
}

/// The curve of a leg. Metres; radians counter-clockwise from +x.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Curve {
    /// A straight segment.
    Line {
        /// Where it begins.
        from: Vector,
        /// Where it ends.
        to: Vector,
        /// Heading at its end.
        heading: f64,
        /// Signed angle turned on the way; 0 unless the robot turns while moving.
        turned: f64,
    },
    /// A part of a circle, the heading tangent to it, or opposite to that in reverse.
    Arc {
        /// Centre.
        center: Vector,
        /// Radius.
        radius: f64,
        /// Angle from the centre to the arriving point.
        start_angle: f64,
        /// Signed angle run through, positive to the left.
        sweep: f64,
    },
    /// A turn in place.
    Turn {
        /// Where.
        position: Vector,
        /// Heading before.
        from_heading: f64,
        /// Heading after.
        to_heading: f64,
        /// Signed angle turned, positive to the left.
        sweep: f64,
    },
    /// A curve whose curvature changes evenly with its arc length, the heading tangent to it, or
    /// opposite to that in reverse.
    Clothoid {
        /// Where it begins.
        from: Vector,
        /// Where it ends.
        to: Vector,
        /// Heading where it begins.
        from_heading: f64,
        /// Heading where it ends.
        to_heading: f64,
        /// Radians turned per metre travelled, where it begins and where it ends; positive to the
        /// left.
        curvatures: [f64; 2],
        /// Arc length; that of the leg.
        length: f64,
    },
}

named! {
/// The kinds of curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CurveKind {
    /// A straight line.
    Line = "line",
    /// A part of a circle, the heading tangent to it, or opposite to that in reverse.
    Arc = "arc",
    /// A turn in place.
    Turn = "turn",
    /// A curve whose curvature changes evenly with its arc length, the heading tangent to it, or
    /// opposite to that in reverse.
    Clothoid = "clothoid",
}
}

impl Curve {
    /// Which kind of curve it is.
    pub fn kind(&self) -> CurveKind {
        match self {
            Self::Line { .. } => CurveKind::Line,
            Self::Arc { .. } => CurveKind::Arc,
            Self::Turn { .. } => CurveKind::Turn,
            Self::Clothoid { .. } => CurveKind::Clothoid,
        }
    }
}

named! {
/// How a leg was found: the rungs of a ladder, climbed until the robot fits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Rung {
    /// On the shortest path around the corners, at the gap asked for.
    Taut = "taut",
    /// With another radius at the corners where the robot would not fit.
    Radius = "radius",
    /// By lining up: straight legs between turns in place.
    Aligned = "aligned",
    /// With legs in reverse.
    Reverse = "reverse",
    /// By a search over positions and headings.
    Lattice = "lattice",
}
}

/// A rule of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rule {
    /// 1: part assembly, 2: mobile robot.
    pub table: u16,
    /// Its number in the table, from 1.
    pub number: u16,
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "table {}, rule {}", self.table, self.number)
    }
}

/// Why there is no trajectory, and what would have to change.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Refusal {
    /// What kind of refusal.
    pub code: ErrorCode,
    /// For people, with the numbers.
    #[serde(deserialize_with = "text")]
    pub message: String,
    /// The field of the request that is at fault, as a path.
    #[serde(deserialize_with = "optional_text")]
    pub field: Option<String>,
    /// The junction (corner) concerned, counted in travel order.
    pub junction: Option<u64>,
    /// The axis concerned, as the index in [`Axis::ALL`].
    pub axis: Option<u32>,
    /// What would be needed.
    pub needs: Option<f64>,
    /// What there is.
    pub has: Option<f64>,
    /// The bound below, itself excluded.
    pub least: Option<f64>,
    /// The bound above.
    pub most: Option<f64>,
    /// The heading that would be free, radians.
    pub heading: Option<f64>,
    /// The setting of the planner's configuration whose limit was met, such as
    /// `caps.route_steps`.
    #[serde(deserialize_with = "optional_text")]
    pub setting: Option<String>,
}

impl Refusal {
    /// A refusal with a message and no numbers yet.
    pub fn new(code: ErrorCode, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
            field: None,
            junction: None,
            axis: None,
            needs: None,
            has: None,
            least: None,
            most: None,
            heading: None,
            setting: None,
        }
    }

    /// An `invalid_scene` refusal that names the field at fault.
    pub fn invalid(field: impl Into<String>, message: impl Into<String>) -> Self {
        Self { field: Some(field.into()), ..Self::new(ErrorCode::InvalidScene, message) }
    }
}

/// A text that is copied from the bytes that hold it: for a `String` the codec allocates
/// whatever length is announced.
struct Text(String);

impl<'de> Deserialize<'de> for Text {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TextVisitor;

        impl Visitor<'_> for TextVisitor {
            type Value = Text;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a text")
            }

            fn visit_str<E>(self, text: &str) -> Result<Text, E> {
                Ok(Text(text.to_owned()))
            }
        }

        deserializer.deserialize_str(TextVisitor)
    }
}

pub(crate) fn text<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    Text::deserialize(deserializer).map(|Text(text)| text)
}

pub(crate) fn optional_text<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<String>, D::Error> {
    Ok(Option::deserialize(deserializer)?.map(|Text(text)| text))
}

named! {
/// The axes of the scene's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Axis {
    /// Along x.
    X = "x",
    /// Along y.
    Y = "y",
    /// Along z.
    Z = "z",
}
}

named! {
/// Why a request, or one of its answers, is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ErrorCode {
    /// The request does not describe a scene that can be planned; `field` says where.
    InvalidScene = "invalid_scene",
    /// The planner does not know the request's version of the wire layout.
    UnsupportedVersion = "unsupported_version",
    /// At the start the body is not inside the free space.
    BodyOutsideFreeSpace = "body_outside_free_space",
    /// At the goal the body would not be inside the free space.
    GoalOutsideFreeSpace = "goal_outside_free_space",
    /// The channels do not connect start and end.
    NoRoute = "no_route",
    /// The body does not fit through a junction of two channels (equation 2.5).
    JunctionTooSmall = "junction_too_small",
    /// A clearance gap is outside its bounds (equation 3.1).
    GapOutOfRange = "gap_out_of_range",
    /// There is no tangent between two guiding circles.
    CornersTooClose = "corners_too_close",
    /// There is no room for the robot to turn in place.
    TurnBlocked = "turn_blocked",
    /// The body would touch a wall.
    WallInTheWay = "wall_in_the_way",
    /// The trajectory would have more samples than the planner allows.
    TooManySamples = "too_many_samples",
    /// The deadline passed before the answer was ready.
    DeadlineExceeded = "deadline_exceeded",
    /// Too many requests are waiting.
    Overloaded = "overloaded",
    /// The planner failed; this is a bug.
    Internal = "internal",
    /// Answering would take more time or memory than the planner allows.
    TooCostly = "too_costly",
    /// The planner knows no free space of this name; send its content once more, with the name.
    UnknownFreeSpace = "unknown_free_space",
}
}
