//! Recovering what can be vouched for of a damaged file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use mcap::records::op;
use thiserror::Error;

use crate::channels::{Channels, Step};
use crate::chunk::{Chunk, Records};
use crate::coverage::Coverage;
use crate::error::ReadError;
use crate::fields::RECORD_HEAD;
use crate::format::MOST_RECORD_BYTES;
use crate::gaps::Gaps;
use crate::options::Options;
use crate::parts::{self, Dropped, Part, Parts};
use crate::read::Reader;
use crate::record::{Aside, Heartbeat, Message, Record};
use crate::source::Source;
use crate::summary::Summary;
use crate::write::Writer;
use crate::write_error::WriteError;

/// Key in the description of a recovered recording that holds messages for which no checksum
/// vouches: how many parts of the old file they are from.
const UNVERIFIED_KEY: &str = "unverified_parts";

/// What [`recover`] found.
#[derive(Debug)]
pub struct Recovered {
    /// The new file's summary. `lost` counts the messages missing before, between and, as far as
    /// the old file tells, after those recovered.
    pub summary: Summary,
    /// Messages that could not be decoded, or whose channel's description is damaged.
    pub unreadable: u64,
    /// Messages for which no checksum vouches.
    pub unverified: u64,
    /// Messages of other channels, copied as they were.
    pub others: u64,
    /// Parts of the old file that were not used, or only because they were asked for.
    pub dropped: Vec<Dropped>,
    /// What was wrong with the old file, if anything.
    pub reason: Option<ReadError>,
    /// The recorder's last sign of life.
    pub heartbeat: Option<Heartbeat>,
}

impl Recovered {
    /// Whether anything is known to be missing or not verified.
    pub fn is_incomplete(&self) -> bool {
        self.summary.lost > 0
            || self.unreadable > 0
            || self.unverified > 0
            || !self.dropped.is_empty()
    }
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

/// Copies all messages of the cut or damaged recording `from` that a checksum vouches for into a
/// new, finished recording `to`, in the newest version, in the order in which they were recorded.
///
/// Nothing is taken from a damaged or cut chunk, unless `unverified` asks for what can be decoded;
/// the new file's description says so.
pub fn recover(
    from: &Path,
    to: &Path,
    unverified: bool,
    options: Options,
) -> Result<Recovered, RecoverError> {
    let failed = |source| RecoverError::Read { path: from.to_owned(), source };
    let io = |source| failed(ReadError::Io { offset: 0, source });
    let file = File::open(from).map_err(io)?;
    let old = file.metadata().map_err(io)?;
    if std::fs::metadata(to).is_ok_and(|new| (new.dev(), new.ino()) == (old.dev(), old.ino())) {
        return Err(RecoverError::SameFile { path: to.to_owned() });
    }
    let input = Some((old.dev(), old.ino()));
    let create = |options| Writer::create_beside(input, to, options);
    match salvage(file, unverified, options, create) {
        Err(Problem::Read(source)) => Err(failed(source)),
        Err(Problem::Write(error)) => Err(error.into()),
        Ok(None) => Err(RecoverError::Nothing { path: from.to_owned() }),
        Ok(Some(recovered)) => Ok(recovered),
    }
}

#[derive(Debug)]
pub(crate) enum Problem {
    Read(ReadError),
    Write(WriteError),
}

impl From<ReadError> for Problem {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}

impl From<WriteError> for Problem {
    fn from(error: WriteError) -> Self {
        Self::Write(error)
    }
}

/// What a reader makes of a file.
struct Survey {
    reason: Option<ReadError>,
    claimed: Option<Summary>,
    description: BTreeMap<String, String>,
    notes: BTreeMap<String, String>,
    coverage: Coverage,
}

fn survey(input: impl Read) -> Result<Survey, ReadError> {
    let mut survey = Survey {
        reason: None,
        claimed: None,
        description: BTreeMap::new(),
        notes: BTreeMap::new(),
        coverage: Coverage::default(),
    };
    match Reader::new(input) {
        Ok(mut reader) => {
            survey.reason = reader.by_ref().find_map(Result::err);
            survey.claimed = reader.summary();
            survey.description = reader.description().clone();
            survey.notes = reader.notes().clone();
            survey.coverage = reader.coverage();
        }
        Err(error) => survey.reason = Some(error),
    }
    match survey.reason {
        Some(error @ (ReadError::Io { .. } | ReadError::NotPlanning { .. })) => Err(error),
        _ => Ok(survey),
    }
}

/// Copies what can be had of `input` into the recording that `create` makes if there is anything.
pub(crate) fn salvage<R: Read + Seek, W: Write>(
    mut input: R,
    unverified: bool,
    options: Options,
    create: impl FnOnce(Options) -> Result<Writer<W>, WriteError>,
) -> Result<Option<Recovered>, Problem> {
    let survey = survey(&mut input)?;
    let mut source = Source::new(input)?;
    let mut found = parts::find(&mut source, unverified)?;
    if survey.reason.is_none() && survey.coverage.is_whole() {
        // The checksum over the whole file vouches for what has none of its own.
        found.parts.iter_mut().for_each(|part| part.is_checked = true);
        found.dropped.clear();
    }
    let guessed = found.parts.iter().filter(|part| !part.is_checked).count();
    let mut description = survey.description;
    description.remove("id");
    description.extend(options.description.clone());
    if unverified && guessed > 0 {
        description.insert(UNVERIFIED_KEY.to_owned(), guessed.to_string());
    }
    let first = found.marks.map_or(0, |(first, _)| first.sequence);
    let options = Options { description, first, ..options };
    let mut copy = Copy::new(&found, first);
    let mut make = Some(|| create(options));
    let mut writer = None;
    for part in &found.parts {
        if part.is_checked || unverified {
            copy.part(part, &mut source, &mut writer, &mut make)?;
        }
    }
    let Some(mut writer) = writer else { return Ok(None) };
    if let Some((_, last)) = found.marks {
        writer.lost(copy.gaps.up_to(last.sequence as u32));
    }
    // Losses after the last message have left no other trace in files without marks.
    let claimed = survey.claimed.map_or(0, |summary| summary.lost);
    writer.lost(claimed.saturating_sub(writer.summary().lost));
    writer.leave_out(survey.claimed.map_or(0, |summary| summary.left_out));
    for (name, value) in survey.notes {
        writer.note_at_end(&name, value);
    }
    let Copy { unreadable, unverified, others, .. } = copy;
    Ok(Some(Recovered {
        summary: writer.finish()?,
        unreadable,
        unverified,
        others,
        heartbeat: found.marks.map(|(_, last)| last.into()),
        dropped: found.dropped,
        reason: survey.reason,
    }))
}

/// Copies messages.
struct Copy {
    channels: Channels,
    records: Records,
    gaps: Gaps,
    unreadable: u64,
    unverified: u64,
    others: u64,
    /// What stood before the first message.
    before: Vec<Aside>,
}

impl Copy {
    fn new(found: &Parts, first: u64) -> Self {
        let mut channels = Channels::default();
        channels.keeps_foreign = true;
        for (opcode, body) in &found.definitions {
            // What is wrong with them shows at the messages.
            let _ = channels.take(*opcode, body, 0);
        }
        let mut gaps = Gaps::default();
        gaps.begin(first);
        let records = Records::default();
        let (others, before) = (0, Vec::new());
        Self { channels, records, gaps, unreadable: 0, unverified: 0, others, before }
    }

    fn part<R: Read + Seek, W: Write>(
        &mut self,
        part: &Part,
        source: &mut Source<R>,
        writer: &mut Option<Writer<W>>,
        make: &mut Option<impl FnOnce() -> Result<Writer<W>, WriteError>>,
    ) -> Result<(), Problem> {
        let Some((opcode, _)) = source.head(part.offset)? else { return Ok(()) };
        let Some(body) = source.body(part.offset, MOST_RECORD_BYTES)? else { return Ok(()) };
        let mut message = None;
        match opcode {
            op::MESSAGE => message = Some(self.channels.take(opcode, body, part.offset)),
            _ => {
                let Ok(chunk) = Chunk::parse(body) else { return Ok(()) };
                let filled = self.records.fill(&chunk, part.offset + RECORD_HEAD as u64);
                if filled.is_err() && part.is_checked {
                    return Ok(());
                }
            }
        }
        loop {
            let step = match message.take() {
                Some(step) => step,
                None if opcode == op::MESSAGE => return Ok(()),
                None => match self.records.next(&mut self.channels) {
                    Some(step) => step,
                    None => return Ok(()),
                },
            };
            match step {
                Ok(Step::Record(record)) if self.fits(part, &record) => {
                    let writer = self.begun(writer, make)?;
                    self.unverified += u64::from(!part.is_checked);
                    writer.lost(self.gaps.before(record.sequence));
                    match &record.message {
                        Message::Request(request) => {
                            writer.write_request(request, record.log_ns)?;
                        }
                        Message::Reply(reply) => writer.write_reply(reply, record.log_ns)?,
                    }
                }
                Ok(Step::Aside(aside)) => {
                    self.others += u64::from(matches!(aside, Aside::Foreign { .. }));
                    // It stands before the request that refers to it.
                    let is_needed = matches!(aside, Aside::FreeSpace { .. });
                    match writer {
                        Some(writer) => writer.write_aside(&aside)?,
                        None if is_needed => self.begun(writer, make)?.write_aside(&aside)?,
                        None => self.before.push(aside),
                    }
                }
                Ok(Step::Skipped | Step::Other) => {}
                Ok(Step::Record(_)) | Err(_) => self.unreadable += 1,
            }
        }
    }

    /// The new recording, which begins with what stood before the first message.
    fn begun<'a, W: Write>(
        &mut self,
        writer: &'a mut Option<Writer<W>>,
        make: &mut Option<impl FnOnce() -> Result<Writer<W>, WriteError>>,
    ) -> Result<&'a mut Writer<W>, WriteError> {
        if let Some(make) = make.take() {
            let writer = writer.insert(make()?);
            self.before.drain(..).try_for_each(|aside| writer.write_aside(&aside))?;
        }
        Ok(writer.as_mut().expect("it is made once"))
    }

    /// Whether a message of a damaged chunk has a number that the marks allow.
    fn fits(&self, part: &Part, record: &Record) -> bool {
        let Some((from, to)) = part.sequences.filter(|_| !part.is_checked) else { return true };
        let place = u64::from(record.sequence.wrapping_sub(from as u32));
        place < to - from && !self.gaps.is_past(record.sequence)
    }
}
