//! A recording's requests with their whole replies.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use recording::{Coverage, Heartbeat, Message, ReadError, Reader, Summary};
use schemas::message::{AssembleError, Reply, ReplyAssembler, ReplyPart, Request, RequestKey};
use thiserror::Error;

/// A request and the reply to it.
#[derive(Debug)]
pub struct Exchange {
    /// Counts the recording's requests, from 0.
    pub index: u64,
    /// What was asked.
    pub request: Request,
    /// What was answered.
    pub reply: Reply,
}

/// A request without its whole reply, or parts of a reply without their request.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Loss {
    /// There is no part of its reply.
    #[error("request {index} ({key}) has no reply")]
    NoReply {
        /// Counts the requests, from 0.
        index: u64,
        /// The request.
        key: RequestKey,
    },
    /// The last part of its reply is missing.
    #[error("the reply to request {index} ({key}) is cut off after {parts} parts")]
    NoEnd {
        /// Counts the requests, from 0.
        index: u64,
        /// The request.
        key: RequestKey,
        /// Parts found.
        parts: u32,
    },
    /// The parts of its reply don't fit together.
    #[error("the reply to request {index} ({key}): {error}")]
    Broken {
        /// Counts the requests, from 0.
        index: u64,
        /// The request.
        key: RequestKey,
        /// What is wrong.
        error: AssembleError,
    },
    /// No request precedes the reply.
    #[error("{parts} parts of a reply to request {key}, which is not in the recording")]
    NoRequest {
        /// The request.
        key: RequestKey,
        /// Parts found.
        parts: u64,
    },
}

/// What else a recording contains.
#[derive(Debug, Default)]
pub struct Contents {
    /// Bytes read.
    pub bytes: u64,
    /// The library that wrote it.
    pub library: String,
    /// Requests.
    pub requests: u64,
    /// Parts of replies.
    pub parts: u64,
    /// Requests with whole replies.
    pub exchanges: u64,
    /// Clients that asked.
    pub clients: BTreeSet<u64>,
    /// When the recorder took the first and the last message; nanoseconds since the Unix epoch.
    pub times_ns: Option<(u64, u64)>,
    /// Requests without whole replies, and replies without requests.
    pub losses: Vec<Loss>,
    /// Messages missing according to sequence numbers, and in how many gaps.
    pub missing: (u64, u64),
    /// The totals that its recorder wrote at the end.
    pub summary: Option<Summary>,
    /// Messages of other channels.
    pub skipped: u64,
    /// How much checksums vouch for.
    pub coverage: Coverage,
    /// The recorder's last sign of life.
    pub heartbeat: Option<Heartbeat>,
    /// What its recorder wrote at the beginning.
    pub description: BTreeMap<String, String>,
    /// Why it could not be read to its end.
    pub error: Option<ReadError>,
}

impl Contents {
    /// Messages that the recorder missed, as far as the recording shows.
    pub fn lost(&self) -> u64 {
        self.missing.0.max(self.summary.map_or(0, |summary| summary.lost))
    }

    /// Messages that the planner had sent before the recorder's last sign of life, and that a
    /// recording without an end does not have.
    pub fn unrecorded(&self) -> u64 {
        let cut = self.heartbeat.filter(|_| self.summary.is_none());
        cut.map_or(0, |beat| beat.announced.saturating_sub(beat.sequence))
    }

    /// Whether anything is missing, a cut end included.
    pub fn is_incomplete(&self) -> bool {
        self.lost() > 0
            || !self.losses.is_empty()
            || self.error.as_ref().is_some_and(ReadError::is_cut)
    }

    /// Why it could not be read, unless it is only cut off.
    pub fn failure(&self) -> Option<&ReadError> {
        self.error.as_ref().filter(|error| !error.is_cut())
    }
}

/// A request that waits for its reply.
struct Pending {
    index: u64,
    request: Request,
    assembler: ReplyAssembler,
    error: Option<AssembleError>,
}

/// Reads the recording at `path`. `each` gets every exchange as soon as its reply is whole,
/// `progress` the number of bytes read so far.
///
/// Memory: requests whose replies are not yet whole, with the parts read.
pub fn read(
    path: &Path,
    mut progress: impl FnMut(u64),
    mut each: impl FnMut(Exchange),
) -> Contents {
    let mut contents = Contents::default();
    let mut reader = match Reader::open(path) {
        Ok(reader) => reader,
        Err(error) => return Contents { error: Some(error), ..contents },
    };
    contents.library = reader.library().to_owned();
    let mut pending = BTreeMap::new();
    let mut orphans = BTreeMap::new();
    while let Some(record) = reader.next() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                contents.error = Some(error);
                break;
            }
        };
        let (first, last) = contents.times_ns.unwrap_or((record.log_ns, record.log_ns));
        contents.times_ns = Some((first.min(record.log_ns), last.max(record.log_ns)));
        match record.message {
            Message::Request(request) => {
                contents.clients.insert(request.key.client);
                let (key, index) = (request.key, contents.requests);
                let assembler = ReplyAssembler::default();
                let begun = Pending { index, request, assembler, error: None };
                // A client may ask again under the same key when no reply comes.
                if let Some(before) = pending.insert(key, begun) {
                    contents.losses.push(before.loss());
                }
                contents.requests += 1;
            }
            Message::Reply(part) => {
                contents.parts += 1;
                let key = part.key;
                let Some(waiting) = pending.get_mut(&key) else {
                    *orphans.entry(key).or_insert(0) += 1;
                    continue;
                };
                let last = part.last;
                let reply = waiting.push(part);
                if !last {
                    continue;
                }
                let waiting = pending.remove(&key).expect("it was just there");
                match reply {
                    Some(reply) => {
                        contents.exchanges += 1;
                        let (index, request) = (waiting.index, waiting.request);
                        each(Exchange { index, request, reply });
                    }
                    None => contents.losses.push(waiting.loss()),
                }
            }
        }
        progress(reader.offset());
    }
    contents.losses.extend(pending.into_values().map(|waiting| waiting.loss()));
    contents.losses.extend(orphans.into_iter().map(|(key, parts)| Loss::NoRequest { key, parts }));
    contents.bytes = reader.offset();
    contents.missing = (reader.lost(), reader.gaps());
    contents.summary = reader.summary();
    contents.skipped = reader.skipped();
    contents.coverage = reader.coverage();
    contents.heartbeat = reader.heartbeat();
    contents.description = reader.description().clone();
    contents
}

impl Pending {
    fn push(&mut self, part: ReplyPart) -> Option<Reply> {
        if self.error.is_some() {
            return None;
        }
        let pushed = self.assembler.push(part);
        pushed.unwrap_or_else(|error| {
            self.assembler = ReplyAssembler::default();
            self.error = Some(error);
            None
        })
    }

    fn loss(self) -> Loss {
        let (index, key) = (self.index, self.request.key);
        match (self.error, self.assembler.parts()) {
            (Some(error), _) => Loss::Broken { index, key, error },
            (None, 0) => Loss::NoReply { index, key },
            (None, parts) => Loss::NoEnd { index, key, parts },
        }
    }
}
