//! What a recording holds.

use schemas::message::{ReplyPart, Request};

/// A recorded message.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "moved once, from the reader to its caller")]
pub enum Message {
    /// From `/planner/request`.
    Request(Request),
    /// From `/planner/reply`.
    Reply(ReplyPart),
}

/// A recorded message with its time stamps.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// What was sent.
    pub message: Message,
    /// When the recorder took it; nanoseconds since the Unix epoch.
    pub log_ns: u64,
    /// When it was sent; nanoseconds since the Unix epoch.
    pub publish_ns: u64,
    /// Counts the bus's messages, those that the recorder missed included; wraps around.
    pub sequence: u32,
}
