//! Copies of recordings, message by message.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use comparison::describe::counted;
use comparison::named::NamedFreeSpaces;
use indicatif::ProgressBar;
use program::warn;
use recording::{
    Aside, Compression, Message, ReadError, Reader, Record, Summary, WriteError, Writer,
};
use schemas::message::{ReplyPart, Request, RequestKey};

use crate::findings::Findings;
use crate::reading::progress;

/// A recording read message by message, and what is missing between them.
pub(crate) struct Messages {
    reader: Reader,
    /// Messages missing so far.
    lost: u64,
    bar: ProgressBar,
    /// Why it could not be read to its end.
    pub(crate) error: Option<ReadError>,
}

impl Messages {
    pub(crate) fn open(path: &Path) -> Result<Self, ReadError> {
        let mut reader = Reader::open(path)?;
        reader.keep_statuses();
        Ok(Self { reader, lost: 0, bar: progress(path), error: None })
    }

    /// The next message, and how many are missing before it.
    pub(crate) fn next(&mut self) -> Option<(Record, u64)> {
        match self.reader.next()? {
            Ok(record) => {
                self.bar.set_position(self.reader.offset());
                let before = std::mem::replace(&mut self.lost, self.reader.lost());
                Some((record, self.lost - before))
            }
            Err(error) => {
                self.error = Some(error);
                None
            }
        }
    }

    /// What its recorder wrote at the beginning: it says under which caps replies were planned.
    pub(crate) fn description(&self) -> BTreeMap<String, String> {
        self.reader.description().clone()
    }

    /// Its random number, as far as it is known; see [`Self::begin`].
    pub(crate) fn id(&self) -> Option<u128> {
        self.reader.id()
    }

    /// The number of its first message, known once that is read: a file in a series goes on
    /// counting.
    pub(crate) fn begin(&self) -> Option<u64> {
        self.reader.begin()
    }

    /// The number of the message that would come next, as far as it is read.
    pub(crate) fn sequence(&self) -> Option<u64> {
        self.reader.heartbeat().map(|beat| beat.sequence)
    }

    /// How it is compressed, as far as it is read.
    pub(crate) fn compression(&self) -> Compression {
        self.reader.compression()
    }

    /// What stood beside the messages read up to now: free spaces and statuses.
    pub(crate) fn asides(&mut self) -> Vec<Aside> {
        self.reader.take_asides()
    }

    /// Messages missing after the last one read, as the recorder says.
    pub(crate) fn lost_at_end(&self) -> u64 {
        let claimed = self.reader.summary().map_or(0, |summary| summary.lost);
        claimed.saturating_sub(self.lost)
    }

    /// From now on, [`Self::asides`] has messages of other channels as well.
    pub(crate) fn keep_others(&mut self) {
        self.reader.keep_foreign();
    }

    /// Messages that were not to be recorded, known once everything has been read.
    pub(crate) fn left_out(&self) -> u64 {
        self.reader.summary().map_or(0, |summary| summary.left_out)
    }

    /// Messages of other channels so far.
    pub(crate) fn others(&self) -> u64 {
        self.reader.skipped()
    }

    /// Tells what was wrong, once everything has been read; returns how many messages are missing
    /// at the end.
    pub(crate) fn end(self, path: &Path, findings: &mut Findings) -> u64 {
        self.bar.finish_and_clear();
        if let Some(error) = &self.error {
            warn(format_args!("{}: {error}", path.display()));
            findings.loss |= error.is_cut();
            findings.failure |= !error.is_cut();
        }
        self.lost_at_end()
    }
}

/// A recording being written.
pub(crate) type Output = Writer;

/// Writes one message as it was.
pub(crate) fn write(output: &mut Output, record: &Record) -> Result<(), WriteError> {
    match &record.message {
        Message::Request(request) => output.write_request(request, record.log_ns),
        Message::Reply(part) => output.write_reply(part, record.log_ns),
    }
}

/// Removes a recording that was begun and not finished; what had its name before stays.
pub(crate) fn discard(path: &Path) {
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    // The error that led here counts.
    _ = std::fs::remove_file(part);
}

/// Some of the requests of a recording, with all parts of their replies.
pub(crate) struct Picked<'a> {
    wanted: &'a dyn Fn(u64, &Request) -> bool,
    named: NamedFreeSpaces,
    requests: u64,
    /// Requests picked whose replies go on.
    open: BTreeSet<RequestKey>,
}

impl<'a> Picked<'a> {
    /// Those for which `wanted` holds of their number, from 0, and what they ask.
    pub(crate) fn new(wanted: &'a dyn Fn(u64, &Request) -> bool) -> Self {
        Self { wanted, named: NamedFreeSpaces::default(), requests: 0, open: BTreeSet::new() }
    }

    /// Learns free spaces that requests only name.
    pub(crate) fn learn(&mut self, asides: Vec<Aside>) {
        for aside in asides {
            if let Aside::FreeSpace { mut request, .. } = aside {
                self.named.resolve(&mut request);
            }
        }
    }

    /// The message, if it is picked. A request gets the free space that it names.
    pub(crate) fn pick(&mut self, mut record: Record) -> Option<Record> {
        let picked = match &mut record.message {
            Message::Request(request) => {
                self.named.resolve(request);
                let picked = (self.wanted)(self.requests, request);
                self.requests += 1;
                match picked {
                    true => self.open.insert(request.key),
                    // The same key asked anew: parts that follow are for this request.
                    false => self.open.remove(&request.key),
                };
                picked
            }
            Message::Reply(ReplyPart { key, last, .. }) => match last {
                true => self.open.remove(key),
                false => self.open.contains(key),
            },
        };
        picked.then_some(record)
    }
}

/// What became of messages of other channels, for people; nothing where there are none.
pub(crate) fn of_others(messages: u64, became: &str) -> String {
    match messages {
        0 => String::new(),
        _ => format!(", {} of other channels {became}", counted(messages, "message")),
    }
}

/// What was written, for people.
pub(crate) fn written(path: &Path, requests: u64, summary: Summary) -> String {
    let Summary { recorded, lost, gaps: _, left_out: _ } = summary;
    let missing = match lost {
        0 => String::new(),
        1 => ", 1 message is missing".to_owned(),
        lost => format!(", {lost} messages are missing"),
    };
    let (requests, recorded) = (counted(requests, "request"), counted(recorded, "message"));
    format!("{}: {requests}, {recorded}{missing}", path.display())
}
