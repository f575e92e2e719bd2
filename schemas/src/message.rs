//! Messages as owned values: requests, replies and their parts.

mod assemble;
mod digest;
mod name;
mod named;
mod reply;
mod scene;
mod vector;

pub use assemble::{AssembleError, ReplyAssembler};
pub use digest::{Digest, NotADigest};
pub use reply::{
    Answer, Axis, Clearance, Curve, CurveKind, ErrorCode, ExceededLimit, Exceeds, Leg, Refusal,
    Reply, ReplyPart, Rule, Rung, Trajectory,
};
pub(crate) use reply::{optional_text, text};
pub use scene::{
    AxisBox, Body, Choice, ClearanceWish, Corners, Direction, Footprint, Frames, FreeSpace, Gap,
    Goal, Limits, PathChoice, Pose, Report, SampleFrame, Sampling, SceneRequest, Solid, StartTurn,
    Task,
};
pub use vector::Vector;

pub(crate) use named::{Named, named};

pub use crate::wire::Sample;

use serde::{Deserialize, Serialize};

/// Ties a reply to its request among those of all clients.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
pub struct RequestKey {
    /// The client's nonce, drawn when it starts.
    pub client: u64,
    /// Counts the client's requests.
    pub sequence: u64,
}

impl std::fmt::Display for RequestKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:016x}/{}", self.client, self.sequence)
    }
}

/// A request as it was sent; recorded on `/planner/request`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Its key; the replies carry the same.
    pub key: RequestKey,
    /// When the client sent it.
    pub sent_ns: u64,
    /// What it asks for.
    pub content: RequestContent,
}

/// What a request asks for, if it can be read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(clippy::large_enum_variant, reason = "nearly every request is a scene")]
pub enum RequestContent {
    /// A scene to plan.
    Scene(SceneRequest),
    /// Memory that is not a scene, kept as it arrived: the header's words, then the payload's.
    Unreadable {
        /// [`crate::wire::RequestHeader`] as 64-bit words.
        header: Vec<u64>,
        /// The payload's words.
        cells: Vec<u64>,
    },
}
