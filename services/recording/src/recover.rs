//! Recovering the intact messages of a damaged file.

use std::fs::File;
use std::io::{self, Read};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use mcap::records::op;
use thiserror::Error;

use crate::chunk::{self, Channels, Gaps, Records, Step};
use crate::error::ReadError;
use crate::fields::RECORD_HEAD;
use crate::format::MOST_RECORD_BYTES;
use crate::read::{Reader, retry};
use crate::record::Message;
use crate::summary::Summary;
use crate::write::{Options, WriteError, Writer};

/// What [`recover`] found.
#[derive(Debug)]
pub struct Recovered {
    /// The new file's summary. `lost` counts the messages missing before and between those
    /// recovered; how many a cut file lost at its end is unknown.
    pub summary: Summary,
    /// Messages that could not be decoded, or whose channel's description is damaged.
    pub unreadable: u64,
    /// Messages of other channels, which were not copied.
    pub skipped: u64,
    /// What was wrong with the old file, if anything.
    pub reason: Option<ReadError>,
}

/// Why nothing was recovered.
#[derive(Debug, Error)]
pub enum RecoverError {
    /// The old file can't be read at all.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: ReadError,
    },
    /// It has no intact message; no new file was made.
    #[error("{}: no intact chunk of messages found", path.display())]
    Nothing {
        /// The file.
        path: PathBuf,
    },
    /// Old and new file are the same.
    #[error("{} is both input and output; choose another output", path.display())]
    SameFile {
        /// The file.
        path: PathBuf,
    },
    /// The new file can't be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Copies all intact messages of the cut or damaged recording `from` into a new, finished
/// recording `to`, in the newest version.
///
/// A chunk is intact if its checksum is right, wherever it is in the file; damage between
/// two chunks is skipped. Nothing is taken from a damaged or cut chunk, as nothing vouches
/// for its messages.
pub fn recover(from: &Path, to: &Path, options: Options) -> Result<Recovered, RecoverError> {
    let failed = |source| RecoverError::Read { path: from.to_owned(), source };
    let (reason, claimed) = match Reader::open(from) {
        Ok(mut reader) => {
            let reason = reader.by_ref().find_map(Result::err);
            (reason, reader.summary())
        }
        Err(error @ ReadError::Io { .. }) => return Err(failed(error)),
        Err(error) => (Some(error), None),
    };
    if let Some(error @ ReadError::Io { .. }) = reason {
        return Err(failed(error));
    }
    let io = |source| failed(ReadError::Io { offset: 0, source });
    let input = File::open(from).map_err(io)?;
    let old = input.metadata().map_err(io)?;
    if std::fs::metadata(to).is_ok_and(|new| (new.dev(), new.ino()) == (old.dev(), old.ino())) {
        return Err(RecoverError::SameFile { path: to.to_owned() });
    }

    let mut writer = None;
    let found = salvage(input, &mut writer, || Writer::create(to, options));
    let mut found = match found {
        Err(Trouble::Read(source)) => return Err(failed(source)),
        Err(Trouble::Write(error)) => return Err(error.into()),
        Ok(found) => found,
    };
    let Some(mut writer) = writer else {
        return Err(RecoverError::Nothing { path: from.to_owned() });
    };
    // Losses after the last message have left no other trace.
    let claimed = claimed.map_or(0, |summary| summary.lost);
    writer.lost(claimed.saturating_sub(writer.summary().lost));
    found.summary = writer.finish()?;
    Ok(Recovered { reason, ..found })
}

enum Trouble {
    Read(ReadError),
    Write(WriteError),
}

/// Copies the messages of all whole chunks of `input` into a writer that is created when
/// the first chunk is found.
fn salvage<W: io::Write>(
    input: impl Read,
    writer: &mut Option<Writer<W>>,
    create: impl Fn() -> Result<Writer<W>, WriteError>,
) -> Result<Recovered, Trouble> {
    let mut window = Window { input, bytes: Vec::new(), start: 0 };
    let (mut records, mut channels) = (Records::default(), Channels::default());
    let mut gaps = Gaps::default();
    let (mut unreadable, mut skipped) = (0, 0);
    let mut at = 0;
    while let Some(chunk) = window.find_chunk(&mut at).map_err(Trouble::Read)? {
        let Ok((begin, inside)) = chunk::verify(&chunk[RECORD_HEAD..]) else {
            at += 1;
            continue;
        };
        records.fill(inside, at + (RECORD_HEAD + begin) as u64);
        at += chunk.len() as u64;
        while let Some(step) = records.next(&mut channels) {
            let record = match step {
                Ok(Step::Record(record)) => record,
                Ok(Step::Skipped) => {
                    skipped += 1;
                    continue;
                }
                Ok(Step::Other) => continue,
                Err(_) => {
                    unreadable += 1;
                    continue;
                }
            };
            let writer = match writer {
                Some(writer) => writer,
                None => writer.insert(create().map_err(Trouble::Write)?),
            };
            writer.lost(gaps.before(record.sequence));
            let written = match &record.message {
                Message::Request(request) => writer.write_request(request, record.log_ns),
                Message::Reply(part) => writer.write_reply(part, record.log_ns),
            };
            written.map_err(Trouble::Write)?;
        }
    }
    Ok(Recovered { summary: Summary::default(), unreadable, skipped, reason: None })
}

/// Whether anything of `input` could be saved to `output`.
#[cfg(test)]
pub(crate) fn salvage_into<W: io::Write>(input: impl Read, output: W) -> bool {
    let (mut writer, output) = (None, std::cell::Cell::new(Some(output)));
    let create = || Writer::new(output.take().expect("one file is made"));
    assert!(salvage(input, &mut writer, create).is_ok());
    writer.is_some_and(|writer| writer.finish().is_ok())
}

/// A piece of a file that moves forward through it.
struct Window<R> {
    input: R,
    bytes: Vec<u8>,
    /// Where in the file `bytes` begin.
    start: u64,
}

/// A chunk's record up to its data, uncompressed.
const CHUNK_HEAD: usize = RECORD_HEAD + 40;

impl<R: Read> Window<R> {
    /// `count` bytes from `at` on, unless the file ends before.
    fn get(&mut self, at: u64, count: usize) -> Result<Option<&[u8]>, ReadError> {
        let mut from = (at - self.start) as usize;
        while self.bytes.len() < from + count {
            // In long strides, as all that is left moves to the front.
            if from > 1 << 20 {
                self.bytes.drain(..from);
                (self.start, from) = (at, 0);
            }
            let filled = self.bytes.len();
            self.bytes.resize(filled + (256 << 10), 0);
            let read = retry(|| self.input.read(&mut self.bytes[filled..]));
            self.bytes.truncate(filled + *read.as_ref().unwrap_or(&0));
            let offset = self.start + filled as u64;
            if read.map_err(|source| ReadError::Io { offset, source })? == 0 {
                return Ok(None);
            }
        }
        Ok(Some(&self.bytes[from..from + count]))
    }

    /// The next record from `at` on that looks like a chunk of ours; `at` moves to it.
    fn find_chunk(&mut self, at: &mut u64) -> Result<Option<&[u8]>, ReadError> {
        let length = loop {
            let Some(head) = self.get(*at, CHUNK_HEAD)? else { return Ok(None) };
            if let Some(length) = chunk_length(head)
                && self.get(*at, length)?.is_some()
            {
                break length;
            }
            *at += 1;
        };
        self.get(*at, length)
    }
}

/// How long the record is that begins with `head`, if it looks like a chunk of ours: not
/// compressed, its three lengths in agreement.
fn chunk_length(head: &[u8]) -> Option<usize> {
    let number = |at: usize| u64::from_le_bytes(head[at..at + 8].try_into().expect("8 bytes"));
    if head[0] != op::CHUNK || head[RECORD_HEAD + 28..RECORD_HEAD + 32] != [0; 4] {
        return None;
    }
    let (record, uncompressed, compressed) = (number(1), number(25), number(41));
    let agree = uncompressed == compressed && record.checked_sub(40) == Some(compressed);
    let length = usize::try_from(record).ok().filter(|length| *length <= MOST_RECORD_BYTES)?;
    agree.then_some(RECORD_HEAD + length)
}
