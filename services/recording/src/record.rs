//! What a recording holds.

use std::collections::BTreeMap;
use std::sync::Arc;

use schemas::message::{ReplyPart, Request};

use crate::mark::Mark;

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

/// What a recording holds beside the bus's messages that are numbered.
#[derive(Debug, Clone, PartialEq)]
pub enum Aside {
    /// A request before the recording that had made a free space known to which a later one refers.
    FreeSpace {
        /// The request.
        request: Box<Request>,
        /// When the recorder took it; nanoseconds since the Unix epoch.
        log_ns: u64,
    },
    /// What the planner said of itself.
    Status {
        /// A JSON object.
        json: String,
        /// When the recorder took it; nanoseconds since the Unix epoch.
        log_ns: u64,
    },
    /// A message of a channel that is not ours, such as those for viewers.
    Foreign {
        /// Its channel.
        channel: Arc<Foreign>,
        /// The message.
        message: Vec<u8>,
        /// Its number in its channel, if it has one.
        sequence: u32,
        /// When it was recorded; nanoseconds since the Unix epoch.
        log_ns: u64,
        /// When it was sent; nanoseconds since the Unix epoch.
        publish_ns: u64,
    },
}

/// A channel of others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Foreign {
    /// Its name.
    pub topic: String,
    /// Of its messages, such as `json` or `protobuf`.
    pub encoding: String,
    /// What else it says.
    pub metadata: BTreeMap<String, String>,
    /// The schema of its messages, if they have one: name, encoding and data.
    pub schema: Option<(String, String, Vec<u8>)>,
}

/// A recorder's sign of life, in the recording at each flush.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Heartbeat {
    /// When; nanoseconds since the Unix epoch.
    pub time_ns: u64,
    /// Messages recorded or lost until then.
    pub sequence: u64,
    /// Messages that the planner had sent until then, as far as the recorder knew: those beyond
    /// `sequence` are not in a file that ends here.
    pub announced: u64,
    /// Messages in the file until then.
    pub recorded: u64,
}

impl From<Mark> for Heartbeat {
    fn from(mark: Mark) -> Self {
        let Mark { id: _, number: _, offset: _, time_ns, sequence, announced, recorded } = mark;
        Self { time_ns, sequence, announced, recorded }
    }
}
