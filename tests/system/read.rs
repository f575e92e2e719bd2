//! Reading recordings.

use std::path::Path;

use recording::{Message, ReadError, Reader, Record, Summary};
use schemas::message::{Reply, ReplyAssembler, Request};

/// A recording's messages, what it says of itself, and why it ends where it does, if it is
/// not finished.
pub(crate) struct Recording {
    pub(crate) records: Vec<Record>,
    pub(crate) summary: Option<Summary>,
    pub(crate) error: Option<ReadError>,
}

/// Reads all of a recording that can be read.
pub(crate) fn recording(path: &Path) -> Recording {
    let mut reader = Reader::open(path).expect("the recording can be opened");
    let (mut records, mut error) = (Vec::new(), None);
    for record in reader.by_ref() {
        match record {
            Ok(record) => records.push(record),
            Err(found) => error = Some(found),
        }
    }
    Recording { records, summary: reader.summary(), error }
}

impl Recording {
    pub(crate) fn requests(&self) -> Vec<&Request> {
        let requests = self.records.iter().filter_map(|record| match &record.message {
            Message::Request(request) => Some(request),
            Message::Reply(_) => None,
        });
        requests.collect()
    }

    /// The replies that are whole, each put together from its parts. The requests were made one
    /// after another, and some parts may be lost.
    pub(crate) fn replies(&self) -> Vec<Reply> {
        let mut replies = Vec::new();
        let mut assembler = ReplyAssembler::default();
        for record in &self.records {
            match &record.message {
                Message::Request(_) => assembler = ReplyAssembler::default(),
                Message::Reply(part) => {
                    replies.extend(assembler.push(part.clone()).ok().flatten());
                }
            }
        }
        replies
    }
}
