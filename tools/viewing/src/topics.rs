//! Messages for viewers, and what they are.

use foxglove::Encode;

/// A message for viewers.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewMessage {
    /// Where it belongs.
    pub topic: String,
    /// What it is.
    pub kind: Kind,
    /// When it is shown; nanoseconds since the Unix epoch.
    pub log_ns: u64,
    /// The message.
    pub bytes: Vec<u8>,
}

/// What a message is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Walls, bodies, paths, the places of least clearance: `foxglove.SceneUpdate`.
    Scene,
    /// The poses of a motion: `foxglove.PosesInFrame`.
    Path,
    /// Where the body is: `foxglove.FrameTransforms`.
    Transforms,
    /// A floor plan: `foxglove.Grid`.
    Grid,
    /// Numbers of a sample: JSON.
    Motion,
    /// Numbers of a request and its answers: JSON.
    Request,
}

/// A message of a published kind.
pub(crate) fn encoded<M: Encode>(
    topic: impl Into<String>,
    kind: Kind,
    log_ns: u64,
    message: &M,
) -> ViewMessage {
    let mut bytes = Vec::with_capacity(message.encoded_len().unwrap_or(0));
    assert!(message.encode(&mut bytes).is_ok(), "memory does not refuse bytes");
    ViewMessage { topic: topic.into(), kind, log_ns, bytes }
}
