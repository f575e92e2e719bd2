//! Plain memory: the messages as they lie in shared memory.
//!
//! A request is a [`RequestHeader`] and a payload of 64-bit cells; each part of a reply
//! is a [`ReplyHeader`] and such a payload. Cells hold `f64` bit patterns or unsigned
//! integers in the machine's byte order. Every bit pattern of these types is a valid
//! value, so memory written by a hostile or dying peer can be read safely;
//! [`crate::convert`] decides whether it makes sense.
//!
//! [`layout_text`] describes the layout. The type names on the bus carry
//! [`layout_hash`], so peers with different layouts do not connect. A planner serves
//! version [`VERSION`] and, through [`previous`], the version before it.

mod layout;
pub mod previous;

pub use layout::{hash as layout_hash, text as layout_text};

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

/// Version of the layout. A request with another is refused (`unsupported_version`).
pub const VERSION: u32 = 2;

/// In place of the version, where all else is 0: a request that asks for nothing. The planner drops
/// it unanswered, by which a client that leaves learns that its requests before were taken.
pub const FAREWELL: u32 = u32::MAX;

/// Most cells in one part of a reply: 32 KiB. Longer replies are split, so reply size
/// is unlimited while the memory per client stays small.
pub const PART_CELLS: usize = 4_096;

/// Bits of [`RequestHeader::given`]: the optional fields that are present.
pub mod given {
    /// `id`
    pub const ID: u64 = 1;
    /// The channels (their count may be 0).
    pub const CHANNELS: u64 = 1 << 1;
    /// The channels are in travel order.
    pub const IN_ORDER: u64 = 1 << 2;
    /// The solids (their count may be 0).
    pub const SOLIDS: u64 = 1 << 3;
    /// `bounds`
    pub const BOUNDS: u64 = 1 << 4;
    /// `start`
    pub const START: u64 = 1 << 5;
    /// The position of `goal`.
    pub const GOAL: u64 = 1 << 6;
    /// The heading of `goal`.
    pub const GOAL_HEADING: u64 = 1 << 7;
    /// `start_turn`
    pub const START_TURN: u64 = 1 << 8;
    /// `sampling_kind` and `sampling`
    pub const SAMPLING: u64 = 1 << 9;
    /// `deadline`
    pub const DEADLINE: u64 = 1 << 10;
    /// `limits[0]`; the bits of the other limits follow.
    pub const LIMITS: u64 = 1 << 11;
    /// `reverse`, whose value is [`switch::REVERSE`](super::switch::REVERSE).
    pub const REVERSE: u64 = 1 << 16;
    /// `turn_in_place`, whose value is [`switch::TURN_IN_PLACE`](super::switch::TURN_IN_PLACE).
    pub const TURN_IN_PLACE: u64 = 1 << 17;
    /// `min_turn_radius`
    pub const MIN_TURN_RADIUS: u64 = 1 << 18;
    /// `turn_cost`
    pub const TURN_COST: u64 = 1 << 19;
    /// `stop_cost`
    pub const STOP_COST: u64 = 1 << 20;
    /// `report`
    pub const REPORT: u64 = 1 << 21;
    /// `rear`: the footprint's point in the payload is (width, front).
    pub const REAR: u64 = 1 << 22;
    /// `named`
    pub const NAMED: u64 = 1 << 23;
    /// `frames[0]`
    pub const FRAMES: u64 = 1 << 24;
    /// `frames[1]`
    pub const FIXED_AT_END: u64 = 1 << 25;
    /// `frames[2]`
    pub const MOVING: u64 = 1 << 26;
    /// `sample_frame`
    pub const SAMPLE_FRAME: u64 = 1 << 27;
    /// `corners`
    pub const CORNERS: u64 = 1 << 28;
    /// `stop_at_joints`, whose value is
    /// [`switch::STOP_AT_JOINTS`](super::switch::STOP_AT_JOINTS).
    pub const STOP_AT_JOINTS: u64 = 1 << 29;
    /// `jerks[0]`
    pub const JERK: u64 = 1 << 30;
    /// `jerks[1]`
    pub const YAW_JERK: u64 = 1 << 31;
    /// `path`
    pub const PATH: u64 = 1 << 32;
    /// All defined bits.
    pub const ALL: u64 = (PATH << 1) - 1;
}

/// Bits of [`RequestHeader::switches`]: the values of fields that are true or false.
pub mod switch {
    /// `reverse`
    pub const REVERSE: u32 = 1;
    /// `turn_in_place`
    pub const TURN_IN_PLACE: u32 = 1 << 1;
    /// `stop_at_joints`
    pub const STOP_AT_JOINTS: u32 = 1 << 2;
    /// All defined bits.
    pub const ALL: u32 = (STOP_AT_JOINTS << 1) - 1;
}

/// Bits of [`ReplyHeader::given`].
pub mod reported {
    /// `id`
    pub const ID: u32 = 1;
    /// `bound`
    pub const BOUND: u32 = 1 << 1;
    /// `free_clearance`
    pub const FREE_CLEARANCE: u32 = 1 << 2;
    /// The search for the trajectory ended before it was complete.
    pub const INCOMPLETE: u32 = 1 << 3;
    /// `exceeds`, `exceeds_joints` and `exceeds_jump`
    pub const EXCEEDS: u32 = 1 << 4;
    /// `stops`
    pub const STOPS: u32 = 1 << 5;
    /// All defined bits.
    pub const ALL: u32 = (STOPS << 1) - 1;
}

/// Bits of a refusal's `present` cell: the optional fields that are present.
pub mod present {
    /// `junction`
    pub const JUNCTION: u64 = 1;
    /// `axis`
    pub const AXIS: u64 = 1 << 1;
    /// `needs`; the bits of `has`, `least`, `most` and `heading` follow.
    pub const NUMBERS: u64 = 1 << 2;
    /// `field`
    pub const FIELD: u64 = 1 << 7;
    /// `setting`
    pub const SETTING: u64 = 1 << 8;
    /// All defined bits.
    pub const ALL: u64 = (SETTING << 1) - 1;
}

/// Start of every request: who asks, and the fixed-size part of the scene.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RequestHeader {
    /// [`VERSION`]
    pub version: u32,
    /// How many coordinates points have: 2 or 3.
    pub dimension: u32,
    /// The client's nonce.
    pub client: u64,
    /// Counts the client's requests.
    pub sequence: u64,
    /// When it was sent, nanoseconds since the Unix epoch.
    pub sent_ns: u64,
    /// See [`given`].
    pub given: u64,
    /// Echoed in the reply.
    pub id: u64,
    /// 0 disassemble, 1 assemble, 2 drive.
    pub task: u32,
    /// 0 in place, 1 while moving.
    pub start_turn: u32,
    /// 0 period (s), 1 spacing (m), 2 count.
    pub sampling_kind: u32,
    /// 0 polygon, 1 box, 2 footprint.
    pub body_kind: u32,
    /// 0 one choice, 1 each choice, 2 a curve.
    pub wish_kind: u32,
    /// Directions in the payload.
    pub exits: u32,
    /// 1: the client sleeps and must be woken; 0: it polls.
    pub wake: u32,
    /// Code of the way through channels in travel order.
    pub path: u32,
    /// A period or spacing as `f64` bits, or a count.
    pub sampling: u64,
    /// Speed, acceleration, yaw rate, yaw acceleration, lateral acceleration; SI.
    pub limits: [f64; 5],
    /// Seconds from arrival.
    pub deadline: f64,
    /// x, y (m) and heading (rad); in three dimensions x, y, z.
    pub start: [f64; 3],
    /// x, y (m) and heading (rad); in three dimensions x, y, z.
    pub goal: [f64; 3],
    /// Least corner, then greatest corner, `dimension` coordinates each; metres.
    pub bounds: [f64; 6],
    /// Points of a curve.
    pub curve: u64,
    /// Choices in the payload.
    pub choices: u64,
    /// Points of the body in the payload: vertices, 2 corners of each box, or 1 (width, length).
    pub body_points: u64,
    /// Channels in the payload.
    pub channels: u64,
    /// Solids in the payload.
    pub solids: u64,
    /// See [`switch`].
    pub switches: u32,
    /// 0 full.
    pub report: u32,
    /// Least radius of the reference point's path, metres.
    pub min_turn_radius: f64,
    /// Metres per radian turned in place.
    pub turn_cost: f64,
    /// Metres per stop.
    pub stop_cost: f64,
    /// From the reference point back to the footprint's end, metres.
    pub rear: f64,
    /// SHA-256 of the free space.
    pub named: [u8; 32],
    /// The fixed part, the fixed part at the end, the moving part: each `dimension` coordinates
    /// (m), zeros, and at last the heading (rad).
    pub frames: [f64; 12],
    /// 0 fixed, 1 base.
    pub sample_frame: u32,
    /// 0 sharp, 1 arc.
    pub corners: u32,
    /// Jerk (m/s³) and yaw jerk (rad/s³).
    pub jerks: [f64; 2],
}

impl RequestHeader {
    /// The name of its free space, if it has no more of that than its name.
    pub fn names_only(&self) -> Option<[u8; 32]> {
        let content = given::CHANNELS | given::SOLIDS | given::BOUNDS;
        (self.given & (given::NAMED | content) == given::NAMED).then_some(self.named)
    }
}

/// Start of every part of a reply.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ReplyHeader {
    /// [`VERSION`]
    pub version: u32,
    /// How many coordinates points have: 2 or 3.
    pub dimension: u32,
    /// The request's client nonce.
    pub client: u64,
    /// The request's sequence number.
    pub sequence: u64,
    /// When it was sent, nanoseconds since the Unix epoch.
    pub sent_ns: u64,
    /// The request's id.
    pub id: u64,
    /// See [`reported`].
    pub given: u32,
    /// 1 for the last part.
    pub last: u32,
    /// Counts the parts, from 0.
    pub part: u32,
    /// 0 a trajectory, 1 a refusal.
    pub kind: u32,
    /// The answer this part belongs to, from 0.
    pub answer: u32,
    /// How many answers there are; 0: the whole request is refused.
    pub answers: u32,
    /// The exit taken: 0 not named, else 1 + its direction code.
    pub exit: u32,
    /// Gaps for each junction.
    pub gaps_per_junction: u32,
    /// Arc length, metres.
    pub length: f64,
    /// Seconds.
    pub duration: f64,
    /// Least distance to the walls, metres.
    pub clearance: f64,
    /// Arc length where that is, metres.
    pub clearance_at: f64,
    /// The wall point there, metres.
    pub wall: [f64; 3],
    /// Gap values in this part.
    pub gaps: u32,
    /// Channel indices in this part.
    pub route: u32,
    /// Channels in this part.
    pub channels: u32,
    /// Legs in this part.
    pub legs: u32,
    /// Samples in this part.
    pub samples: u32,
    /// Cells of a refusal in this part.
    pub refusal: u32,
    /// Length of the shortest curve with the same free clearance, metres.
    pub bound: f64,
    /// Free clearance, metres.
    pub free_clearance: f64,
    /// 0 yaw acceleration.
    pub exceeds: u32,
    /// At how many joints.
    pub exceeds_joints: u32,
    /// The greatest jump there, rad/s.
    pub exceeds_jump: f64,
    /// At how many joints the body stops because no smooth corner fits.
    pub stops: u64,
}

/// A leg of a path in a reply's payload.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Leg {
    /// 0 line, 1 arc, 2 turn, 3 clothoid.
    pub kind: u16,
    /// 0 for none, otherwise 1 + its code.
    pub rung: u8,
    /// 1: driven backwards; otherwise 0.
    pub reverse: u8,
    /// Table of the rule, 0 for none.
    pub table: u16,
    /// Number of the rule in it.
    pub number: u16,
    /// The junction, counted in travel order; `u64::MAX` for none.
    pub junction: u64,
    /// Arc length, metres.
    pub length: f64,
    /// Least distance to the walls, metres.
    pub clearance: f64,
    /// Line, clothoid: from. Arc: centre. Turn: position. Metres.
    pub point: [f64; 3],
    /// Line, clothoid: to. Metres.
    pub to: [f64; 3],
    /// Arc: radius, metres. Clothoid: curvature at its start, rad/m.
    pub radius: f64,
    /// Arc: start angle. Turn, clothoid: heading before. Radians.
    pub start: f64,
    /// Line: heading at its end. Turn, clothoid: heading after. Radians.
    pub heading: f64,
    /// Arc, turn: signed angle run through. Line: signed angle turned on the way. Radians. Clothoid:
    /// curvature at its end, rad/m.
    pub sweep: f64,
}

/// A state of the motion: the rigid transform of the body as the request gave it
/// (assembly tasks: the displacement from the assembled state; driving: the pose
/// of the footprint's reference point) and its rate of change.
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct Sample {
    /// Seconds from the beginning of the motion.
    pub t: f64,
    /// Metres; unused coordinates are 0.
    pub position: [f64; 3],
    /// Radians counter-clockwise from +x, in (-pi, pi].
    pub heading: f64,
    /// Metres per second.
    pub velocity: [f64; 3],
    /// Radians per second.
    pub yaw_rate: f64,
}

/// Cells that a [`Leg`] takes.
pub const LEG_CELLS: usize = size_of::<Leg>() / 8;

/// Cells that a [`Sample`] takes.
pub const SAMPLE_CELLS: usize = size_of::<Sample>() / 8;

/// Start of every message on the planner's tap.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct TapHeader {
    /// Number of the bus message; a gap is a loss. A heartbeat carries the number of the
    /// next message.
    pub sequence: u64,
    /// When the planner took (request) or sent (reply) the message, nanoseconds
    /// since the Unix epoch.
    pub time_ns: u64,
    /// 0 a request, 1 a part of a reply, 2 a heartbeat. The payload of a heartbeat, if it has one, is
    /// a request that makes a free space known which the next request names.
    pub kind: u32,
    /// Long messages are cut into pieces with the same sequence number: bit 0 is set on
    /// the last piece, the bits above it number the pieces from 0.
    pub piece: u32,
}
