//! What to record, and where.

use std::path::PathBuf;
use std::time::Duration;

use bus::Domain;
use recording::{Compression, FLUSH_INTERVAL, Split};
use schemas::message::ErrorCode;

/// What to record, and where.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The file to write.
    pub output: PathBuf,
    /// The planner's domain.
    pub domain: Domain,
    /// Whether to replace an existing file.
    pub overwrite: bool,
    /// How long to record; `None`: until a signal.
    pub duration: Option<Duration>,
    /// How many messages to record; `None`: no end.
    pub max_messages: Option<u64>,
    /// How much may be lost if the recorder is killed.
    pub flush: Duration,
    /// Whether each flush waits for the disk.
    pub sync: bool,
    /// How long to wait for a planner to come up.
    pub wait: Duration,
    /// Whether to end when the planner is gone.
    pub exit_with_planner: bool,
    /// What is recorded.
    pub topics: Topics,
    /// How chunks are compressed.
    pub compression: Compression,
    /// The size of chunks, bytes.
    pub chunk_bytes: u64,
    /// When a new file begins.
    pub split: Split,
    /// Recording ends before the disk has less than this left, bytes.
    pub min_free: Option<u64>,
    /// Whether only what came just before some event is written.
    pub snapshot: Option<Snapshot>,
    /// What is written about the recording at its beginning: the command line.
    pub command: String,
}

impl Settings {
    /// Records all of a domain's traffic to a file until a signal.
    pub fn new(output: PathBuf, domain: Domain) -> Self {
        Self {
            output,
            domain,
            overwrite: false,
            duration: None,
            max_messages: None,
            flush: FLUSH_INTERVAL,
            sync: false,
            wait: Duration::from_secs(10),
            exit_with_planner: false,
            topics: Topics::default(),
            compression: Compression::None,
            chunk_bytes: recording::CHUNK_BYTES,
            split: Split::default(),
            min_free: None,
            snapshot: None,
            command: std::env::args().collect::<Vec<_>>().join(" "),
        }
    }
}

/// A part of the traffic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Topic {
    /// Requests.
    Request,
    /// Parts of replies.
    Reply,
    /// What the planner says of itself.
    Status,
}

/// What is recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Topics {
    /// Requests.
    pub requests: bool,
    /// Parts of replies.
    pub replies: bool,
    /// What the planner says of itself.
    pub statuses: bool,
}

impl Default for Topics {
    fn default() -> Self {
        Self { requests: true, replies: true, statuses: true }
    }
}

impl FromIterator<Topic> for Topics {
    fn from_iter<I: IntoIterator<Item = Topic>>(topics: I) -> Self {
        let mut all = Self { requests: false, replies: false, statuses: false };
        for topic in topics {
            match topic {
                Topic::Request => all.requests = true,
                Topic::Reply => all.replies = true,
                Topic::Status => all.statuses = true,
            }
        }
        all
    }
}

impl std::fmt::Display for Topics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { requests, replies, statuses } = *self;
        let all = [(requests, "request"), (replies, "reply"), (statuses, "status")];
        let names: Vec<_> = all.into_iter().filter_map(|(is, name)| is.then_some(name)).collect();
        f.write_str(&names.join(","))
    }
}

/// What is kept in memory and written on an event.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Snapshot {
    /// How long messages are kept.
    pub time: Duration,
    /// The most memory that they take, bytes; beyond, the oldest go first.
    pub most_bytes: u64,
    /// The refusals that have it written, beside SIGUSR1.
    pub on: Vec<ErrorCode>,
}
