//! A recording's requests with their whole replies.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use recording::{
    CONTINUED_KEY, CONTINUES_KEY, Coverage, FILE_KEY, Heartbeat, Message, ReadError, Reader,
    Record, SERIES_KEY, Summary,
};
use schemas::message::{
    AssembleError, Digest, ErrorCode, Reply, ReplyAssembler, ReplyPart, Request, RequestContent,
    RequestKey, SceneRequest,
};
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
    /// Requests before the recording that had made free spaces known to which requests up to this
    /// one refer.
    pub uploads: Vec<Request>,
}

/// A request with its reply, if that is whole.
#[derive(Debug)]
pub struct Asked {
    /// Counts the recording's requests, from 0.
    pub index: u64,
    /// What was asked.
    pub request: Request,
    /// What was answered.
    pub reply: Option<Reply>,
    /// When the last part of the reply was sent; nanoseconds since the Unix epoch.
    pub replied_ns: Option<u64>,
    /// Whether it was planned with a free space that the request only names and that the recording
    /// does not have.
    pub lacks_free_space: bool,
    /// Requests before the recording that had made free spaces known to which requests up to this
    /// one refer.
    pub uploads: Vec<Request>,
}

impl Asked {
    fn without_reply(index: u64, request: Request) -> Self {
        let (reply, replied_ns, lacks_free_space, uploads) = (None, None, false, Vec::new());
        Self { index, request, reply, replied_ns, lacks_free_space, uploads }
    }
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
    /// The request is in another file of the recording.
    #[error("{parts} parts of a reply to request {key}, which is in a file before this one")]
    RequestBefore {
        /// The request.
        key: RequestKey,
        /// Parts found.
        parts: u64,
    },
    /// The reply, or its end, is in another file of the recording.
    #[error(
        "the reply to request {index} ({key}) goes on in a file after this one; {parts} parts are here"
    )]
    ReplyAfter {
        /// Counts the requests, from 0.
        index: u64,
        /// The request.
        key: RequestKey,
        /// Parts found.
        parts: u32,
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
    /// Free spaces that answered requests name and that it does not have, and how many requests.
    pub missing_free_spaces: BTreeMap<Digest, u64>,
    /// Messages missing according to sequence numbers, and in how many gaps.
    pub missing: (u64, u64),
    /// The totals that its recorder wrote at the end.
    pub summary: Option<Summary>,
    /// Messages of other channels.
    pub skipped: u64,
    /// Statuses of the planner.
    pub statuses: u64,
    /// How much checksums vouch for.
    pub coverage: Coverage,
    /// The recorder's last sign of life.
    pub heartbeat: Option<Heartbeat>,
    /// The number of the message after the last one that was read.
    pub next_number: Option<u64>,
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
        let next = |beat: &Heartbeat| self.next_number.unwrap_or(0).max(beat.sequence);
        cut.map_or(0, |beat| beat.announced.saturating_sub(next(&beat)))
    }

    /// Whether anything is missing, a cut end included.
    pub fn is_incomplete(&self) -> bool {
        self.lost() > 0
            || !self.missing_free_spaces.is_empty()
            || !self.losses.is_empty()
            || self.error.as_ref().is_some_and(ReadError::is_cut)
    }

    /// Whether nothing of it could be read because of the system: it is not there, or a folder.
    pub fn is_unopened(&self) -> bool {
        self.bytes == 0 && matches!(self.error, Some(ReadError::Io { offset: 0, .. }))
    }

    /// What is missing of exchanges, in words.
    pub fn incomplete(&self) -> impl Iterator<Item = String> {
        let missing = self.missing_free_spaces.iter().map(|(name, requests)| {
            format!(
                "free space {name} is not in the recording: {requests} of its requests can't be \
                 planned again"
            )
        });
        self.losses.iter().map(ToString::to_string).chain(missing)
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
    /// The free space that it names, if nobody has told it.
    lacks: Option<Digest>,
}

/// What the recorder wrote at the beginning of the recording at `path`, if that can be read.
pub fn description(path: &Path) -> BTreeMap<String, String> {
    let Ok(mut reader) = Reader::open(path) else { return BTreeMap::new() };
    // It stands before the first message.
    let _ = reader.next();
    reader.description().clone()
}

/// Puts together the files of `paths` that are one recording and follow each other in it.
pub fn recordings(paths: &[PathBuf]) -> Vec<Vec<PathBuf>> {
    let mut recordings: Vec<Vec<PathBuf>> = Vec::new();
    let mut last: Option<(String, u64)> = None;
    for path in paths {
        let description = description(path);
        let file = description.get(FILE_KEY).and_then(|file| file.parse::<u64>().ok());
        let place = description.get(SERIES_KEY).cloned().zip(file);
        match (recordings.last_mut(), &place) {
            // One that is missing between them shows by the messages that it had.
            (Some(before), Some((series, file)))
                if last.as_ref().is_some_and(|(same, index)| same == series && index < file) =>
            {
                before.push(path.clone());
            }
            _ => recordings.push(vec![path.clone()]),
        }
        last = place;
    }
    recordings
}

/// Reads the recording at `path`. `each` gets every exchange as soon as its reply is whole, if it
/// can be planned again: see [`Contents::missing_free_spaces`]. `progress` gets the number of bytes
/// read so far.
///
/// Memory: requests whose replies are not yet whole, with the parts read.
pub fn read(path: &Path, progress: impl FnMut(u64), each: impl FnMut(Exchange)) -> Contents {
    read_all(std::slice::from_ref(&path), progress, each)
}

/// Reads a recording in several files, in their order; see [`read`].
pub fn read_all(
    paths: &[impl AsRef<Path>],
    progress: impl FnMut(u64),
    mut each: impl FnMut(Exchange),
) -> Contents {
    // They wait for the next request that has its whole reply.
    let mut before = Vec::new();
    read_asked(paths, progress, |asked| {
        let Asked { index, request, reply, replied_ns: _, lacks_free_space, uploads } = asked;
        before.extend(uploads);
        if let Some(reply) = reply.filter(|_| !lacks_free_space) {
            each(Exchange { index, request, reply, uploads: std::mem::take(&mut before) });
        }
        ControlFlow::Continue(())
    })
}

/// Reads a recording in several files until `each` has seen enough; it gets every request: as soon
/// as the reply is whole, and those whose replies are not whole as soon as that is certain.
///
/// Memory: requests whose replies are not yet whole, with the parts read.
pub fn read_asked(
    paths: &[impl AsRef<Path>],
    mut progress: impl FnMut(u64),
    mut each: impl FnMut(Asked) -> ControlFlow<()>,
) -> Contents {
    let mut contents = Contents::default();
    let mut open = Open::default();
    let mut flow = ControlFlow::Continue(());
    for (index, path) in paths.iter().enumerate() {
        let is_last = index + 1 == paths.len();
        flow = open.read(path.as_ref(), is_last, &mut contents, &mut progress, &mut each);
        if contents.failure().is_some() || flow.is_break() {
            break;
        }
    }
    // Whoever has seen enough has not seen what is missing.
    if flow.is_continue() {
        let Open { pending, orphans, continues, continued, .. } = open;
        for waiting in pending.into_values() {
            let is_after = continued.contains(&waiting.request.key.to_string());
            let asked = match is_after && waiting.error.is_none() {
                true => waiting.answered_after(&mut contents.losses),
                false => waiting.unanswered(&mut contents.losses),
            };
            if flow.is_continue() {
                flow = each(asked);
            }
        }
        let orphans = orphans.into_iter();
        contents.losses.extend(orphans.map(
            |(key, parts)| match continues.contains(&key.to_string()) {
                true => Loss::RequestBefore { key, parts },
                false => Loss::NoRequest { key, parts },
            },
        ));
    }
    contents
}

/// What waits for its end.
#[derive(Default)]
struct Open {
    pending: BTreeMap<RequestKey, Pending>,
    orphans: BTreeMap<RequestKey, u64>,
    /// Requests whose replies begin, or go on, in another file than they are in, by what files say.
    continues: BTreeSet<String>,
    continued: BTreeSet<String>,
    /// The free spaces that are there.
    known: BTreeSet<Digest>,
    /// Not handed on yet.
    uploads: Vec<Request>,
    /// The number of the message that comes next, by the file before.
    next: Option<u64>,
}

impl Open {
    /// Reads one file of a recording.
    fn read(
        &mut self,
        path: &Path,
        is_last: bool,
        contents: &mut Contents,
        progress: &mut impl FnMut(u64),
        each: &mut impl FnMut(Asked) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut flow = ControlFlow::Continue(());
        let bytes_before = contents.bytes;
        let mut reader = match Reader::open(path) {
            Ok(reader) => reader,
            Err(error) => {
                contents.error = Some(error);
                return flow;
            }
        };
        while flow.is_continue()
            && let Some(record) = reader.next()
        {
            for upload in reader.take_free_spaces() {
                self.know(&upload);
                self.uploads.push(upload);
            }
            match record {
                Ok(record) => flow = self.take(record, contents, each),
                Err(error) => {
                    contents.error = Some(error);
                    break;
                }
            }
            progress(bytes_before + reader.offset());
        }
        let between = self.next.zip(reader.begin());
        let between = between.map_or(0, |(next, begin)| begin.saturating_sub(next));
        self.next = reader.next_number();
        let keys = |text: Option<&String>| {
            let keys = text.into_iter().flat_map(|keys| keys.split(' '));
            keys.map(str::to_owned).collect::<Vec<_>>()
        };
        self.continues.extend(keys(reader.description().get(CONTINUES_KEY)));
        self.continued.extend(keys(reader.notes().get(CONTINUED_KEY)));
        contents.bytes += reader.offset();
        contents.library = reader.library().to_owned();
        contents.missing.0 += reader.lost() + between;
        contents.missing.1 += reader.gaps() + u64::from(between > 0);
        let all = contents.summary.filter(|_| bytes_before > 0).unwrap_or_default();
        // One that is cut in the middle of a series has no end.
        let has_end = bytes_before == 0 || contents.summary.is_some();
        contents.summary = reader.summary().filter(|_| has_end).map(|own| own.plus(all));
        contents.skipped += reader.skipped();
        contents.statuses += reader.statuses();
        let Coverage { bytes, checked } = reader.coverage();
        contents.coverage.bytes += bytes;
        contents.coverage.checked += checked;
        if contents.description.is_empty() {
            contents.description = reader.description().clone();
        }
        if is_last || contents.error.is_some() {
            contents.heartbeat = reader.heartbeat();
            contents.next_number = reader.next_number();
        }
        flow
    }

    /// Notes the free space of a request, if it carries one with its right name.
    fn know(&mut self, request: &Request) {
        let RequestContent::Scene(SceneRequest { free_space, .. }) = &request.content else {
            return;
        };
        if let Some(name) = free_space.named.filter(|_| !free_space.is_name_only())
            && !self.known.contains(&name)
            && free_space.digest() == name
        {
            self.known.insert(name);
        }
    }

    /// The free space that a request names, if it is not there.
    fn lack(&self, request: &Request) -> Option<Digest> {
        let RequestContent::Scene(SceneRequest { free_space, .. }) = &request.content else {
            return None;
        };
        let name = free_space.named.filter(|_| free_space.is_name_only());
        name.filter(|name| !self.known.contains(name))
    }

    fn take(
        &mut self,
        record: Record,
        contents: &mut Contents,
        each: &mut impl FnMut(Asked) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (first, last) = contents.times_ns.unwrap_or((record.log_ns, record.log_ns));
        contents.times_ns = Some((first.min(record.log_ns), last.max(record.log_ns)));
        match record.message {
            Message::Request(request) => {
                contents.clients.insert(request.key.client);
                let (key, index) = (request.key, contents.requests);
                let assembler = ReplyAssembler::default();
                self.know(&request);
                let lacks = self.lack(&request);
                let begun = Pending { index, request, assembler, error: None, lacks };
                // A client may ask again under the same key when no reply comes.
                let before = self.pending.insert(key, begun);
                contents.requests += 1;
                if let Some(before) = before {
                    return each(before.unanswered(&mut contents.losses));
                }
            }
            Message::Reply(part) => {
                contents.parts += 1;
                let key = part.key;
                let Some(waiting) = self.pending.get_mut(&key) else {
                    *self.orphans.entry(key).or_insert(0) += 1;
                    return ControlFlow::Continue(());
                };
                let (last, sent_ns) = (part.last, part.sent_ns);
                let reply = waiting.push(part);
                if !last {
                    return ControlFlow::Continue(());
                }
                let waiting = self.pending.remove(&key).expect("it was just there");
                return each(match reply {
                    Some(reply) => {
                        contents.exchanges += 1;
                        let Pending { index, request, lacks, .. } = waiting;
                        let (replied_ns, uploads) =
                            (Some(sent_ns), std::mem::take(&mut self.uploads));
                        // What the planner did not know either is not missing.
                        let is_refused = reply
                            .answers
                            .as_ref()
                            .is_err_and(|refusal| refusal.code == ErrorCode::UnknownFreeSpace);
                        let lacks = lacks.filter(|_| !is_refused);
                        if let Some(name) = lacks {
                            *contents.missing_free_spaces.entry(name).or_insert(0) += 1;
                        }
                        let lacks_free_space = lacks.is_some();
                        let reply = Some(reply);
                        Asked { index, request, reply, replied_ns, lacks_free_space, uploads }
                    }
                    None => waiting.unanswered(&mut contents.losses),
                });
            }
        }
        ControlFlow::Continue(())
    }
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

    /// The request alone, with what is missing noted among `losses`.
    fn unanswered(self, losses: &mut Vec<Loss>) -> Asked {
        let Self { index, request, assembler, error, lacks: _ } = self;
        let key = request.key;
        losses.push(match (error, assembler.parts()) {
            (Some(error), _) => Loss::Broken { index, key, error },
            (None, 0) => Loss::NoReply { index, key },
            (None, parts) => Loss::NoEnd { index, key, parts },
        });
        Asked::without_reply(index, request)
    }

    /// The same where the reply ends in another file.
    fn answered_after(self, losses: &mut Vec<Loss>) -> Asked {
        let Self { index, request, assembler, .. } = self;
        let (key, parts) = (request.key, assembler.parts());
        losses.push(Loss::ReplyAfter { index, key, parts });
        Asked::without_reply(index, request)
    }
}
