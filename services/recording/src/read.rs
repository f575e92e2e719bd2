//! Reading recordings.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError};
use schemas::message::Request;
use schemas::topic;

use crate::channels::{Channels, Step};
use crate::chunk::{Chunk, Records};
use crate::coverage::Coverage;
use crate::error::{Damage, ReadError};
use crate::fields::{Fields, RECORD_HEAD};
use crate::format::MOST_RECORD_BYTES;
use crate::gaps::Gaps;
use crate::mark::{Mark, Marks};
use crate::options::Compression;
use crate::record::{Aside, Heartbeat, Record};
use crate::summary::{self, Summary};

/// Reads a recording from its beginning, in file order, which is bus order.
///
/// Of recordings by [`Writer`](crate::Writer) it returns messages of chunks whose checksum it has
/// verified, and nothing else. Files that went through other tools are read as well: compressed or
/// not, in chunks or not, with or without checksums; [`Reader::coverage`] tells what was not
/// checked. After the first error it returns nothing more; the messages before are right. Channels
/// with other names, such as those for viewers, are skipped and counted.
///
/// The file is read as a stream; memory is taken for one chunk, and never more than the file
/// has left or a chunk claims to unpack to.
///
/// Damage to a length in an unfinished file can look like a cut. The checksum over the whole
/// file is known only at its end.
pub struct Reader<R: Read = File> {
    input: R,
    linear: LinearReader,
    /// Where the next record begins.
    offset: u64,
    /// Bytes read from the input, and the last eight of them.
    taken: u64,
    tail: [u8; 8],
    profile: String,
    library: String,
    description: BTreeMap<String, String>,
    records: Records,
    channels: Channels,
    gaps: Gaps,
    marks: Marks,
    begin: Option<u64>,
    coverage: Coverage,
    skipped: u64,
    statuses: u64,
    asides: Vec<Aside>,
    keeps_statuses: bool,
    compression: Compression,
    claimed: Option<Summary>,
    notes: BTreeMap<String, String>,
    data_ended: bool,
    done: bool,
}

/// What the outer structure of the file brings next.
enum Outer {
    Header,
    Chunk,
    /// A message outside of a chunk.
    Step(Step),
    End,
}

impl Reader {
    /// Opens the recording at `path`.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, ReadError> {
        let file = File::open(path).map_err(|source| ReadError::Io { offset: 0, source })?;
        Self::new(file)
    }
}

impl<R: Read> Reader<R> {
    /// Reads a recording from `input`, beginning with its header. `input` needs no buffer.
    pub fn new(input: R) -> Result<Self, ReadError> {
        // Chunks are taken whole: `chunk` verifies them before anything of them is used.
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_check_finishes_after_end_magic(true)
            .with_record_length_limit(MOST_RECORD_BYTES);
        let mut reader = Self {
            input,
            linear: LinearReader::new_with_options(options),
            offset: 0,
            taken: 0,
            tail: [0; 8],
            profile: String::new(),
            library: String::new(),
            description: BTreeMap::new(),
            records: Records::default(),
            channels: Channels::default(),
            gaps: Gaps::default(),
            marks: Marks::default(),
            begin: None,
            coverage: Coverage::default(),
            skipped: 0,
            statuses: 0,
            asides: Vec::new(),
            keeps_statuses: false,
            compression: Compression::None,
            claimed: None,
            notes: BTreeMap::new(),
            data_ended: false,
            done: false,
        };
        reader.read_magic()?;
        match reader.advance()? {
            Outer::Header => Ok(reader),
            Outer::Chunk | Outer::Step(_) | Outer::End => {
                let damage = Damage::Misplaced { what: "something else before the header" };
                Err(ReadError::Damaged { offset: MAGIC.len() as u64, damage })
            }
        }
    }

    /// The library that wrote the file.
    pub fn library(&self) -> &str {
        &self.library
    }

    /// How far the file is read, bytes.
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// What its recorder wrote at the beginning: names and values.
    pub fn description(&self) -> &BTreeMap<String, String> {
        &self.description
    }

    /// The random number of the recording, if a [`Writer`](crate::Writer) of version 2 or later
    /// wrote it; known once the first message is read.
    pub fn id(&self) -> Option<u128> {
        self.marks.last.map(|mark| mark.id)
    }

    /// The number of its first message, known with [`Self::id`]: a recording in several files goes
    /// on counting.
    pub fn begin(&self) -> Option<u64> {
        self.begin
    }

    /// The recorder's last sign of life so far.
    pub fn heartbeat(&self) -> Option<Heartbeat> {
        self.marks.last.map(Heartbeat::from)
    }

    /// The number of the message after those read so far, lost ones included; known with
    /// [`Self::id`].
    pub fn next_number(&self) -> Option<u64> {
        self.marks.last.map(|mark| self.gaps.next_near(mark.sequence))
    }

    /// What its recorder wrote at the end beside the totals, known with [`Self::summary`]: names and
    /// values.
    pub fn notes(&self) -> &BTreeMap<String, String> {
        &self.notes
    }

    /// How much of what was read checksums vouch for; final once the last message is read.
    pub fn coverage(&self) -> Coverage {
        self.coverage
    }

    /// Channels of others that were skipped, and their messages so far.
    pub fn others(&self) -> impl Iterator<Item = (&str, u64)> {
        self.channels.others()
    }

    /// Takes the requests that had made free spaces known to which the messages read last refer, and
    /// which were sent before this file began.
    pub fn take_free_spaces(&mut self) -> Vec<Request> {
        let free_space = |aside| match aside {
            Aside::FreeSpace { request, .. } => Some(*request),
            Aside::Status { .. } | Aside::Foreign { .. } => None,
        };
        self.take_asides().into_iter().filter_map(free_space).collect()
    }

    /// From now on, [`Self::take_asides`] has statuses as well.
    pub fn keep_statuses(&mut self) {
        self.keeps_statuses = true;
    }

    /// From now on, [`Self::take_asides`] has messages of other channels as well.
    pub fn keep_foreign(&mut self) {
        self.channels.keeps_foreign = true;
    }

    /// Takes what stood between the messages read so far, in its order.
    pub fn take_asides(&mut self) -> Vec<Aside> {
        std::mem::take(&mut self.asides)
    }

    /// How chunks are compressed, by the last one read.
    pub fn compression(&self) -> Compression {
        self.compression
    }

    /// Statuses of the planner so far.
    pub fn statuses(&self) -> u64 {
        self.statuses
    }

    /// Messages of other channels so far.
    pub fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Messages missing before and between those read so far, by their sequence numbers.
    pub fn lost(&self) -> u64 {
        self.gaps.lost
    }

    /// Runs of missing messages.
    pub fn gaps(&self) -> u64 {
        self.gaps.gaps
    }

    /// The recording's own summary; known once the last message is read, if the recorder
    /// finished the file.
    pub fn summary(&self) -> Option<Summary> {
        self.claimed.filter(|_| self.data_ended)
    }

    fn read_magic(&mut self) -> Result<(), ReadError> {
        let mut begin = Vec::with_capacity(MAGIC.len());
        (&mut self.input)
            .take(MAGIC.len() as u64)
            .read_to_end(&mut begin)
            .map_err(|source| ReadError::Io { offset: 0, source })?;
        if !MAGIC.starts_with(&begin) {
            return Err(ReadError::NotMcap { found: begin });
        }
        if begin.len() < MAGIC.len() {
            return Err(ReadError::Cut { offset: 0, end: begin.len() as u64 });
        }
        self.linear.insert(begin.len()).copy_from_slice(&begin);
        self.linear.notify_read(begin.len());
        self.taken = MAGIC.len() as u64;
        self.offset = self.taken;
        Ok(())
    }

    /// Goes on to the next header, chunk or end.
    fn advance(&mut self) -> Result<Outer, ReadError> {
        loop {
            let offset = self.offset;
            let damaged = |damage| ReadError::Damaged { offset, damage };
            let (opcode, body) = match self.linear.next_event() {
                None => return Ok(Outer::End),
                Some(Err(error)) => return Err(self.explain(error)),
                Some(Ok(LinearReadEvent::ReadRequest(bytes))) => {
                    // Bounded steps: the file has to have what a length claims.
                    let bytes = bytes.clamp(64 << 10, 1 << 20);
                    let buffer = self.linear.insert(bytes);
                    let read = retry(|| self.input.read(&mut buffer[..bytes]))
                        .map_err(|source| ReadError::Io { offset: self.taken, source })?;
                    self.taken += read as u64;
                    let new = &buffer[read.saturating_sub(8)..read];
                    self.tail.rotate_left(new.len());
                    self.tail[8 - new.len()..].copy_from_slice(new);
                    self.linear.notify_read(read);
                    continue;
                }
                Some(Ok(LinearReadEvent::Record { opcode, data })) => (opcode, data),
            };
            let bytes = RECORD_HEAD + body.len();
            self.offset += bytes as u64;
            if offset == MAGIC.len() as u64 {
                let what = "something else before the header";
                let header = match opcode {
                    op::HEADER => header(body).ok_or(Damage::Broken { what: "the header" }),
                    _ => Err(Damage::Misplaced { what }),
                };
                (self.profile, self.library) = header.map_err(damaged)?;
                return Ok(Outer::Header);
            }
            if let Some(mark) = Mark::parse(opcode, body).filter(|_| !self.data_ended) {
                let taken = mark.and_then(|mark| self.take_mark(mark, offset));
                taken.map_err(damaged)?;
                continue;
            }
            self.marks.pass(opcode == op::CHUNK).map_err(damaged)?;
            match opcode {
                op::HEADER => return Err(damaged(Damage::Misplaced { what: "a header" })),
                op::CHUNK | op::MESSAGE if self.data_ended => {
                    return Err(damaged(Damage::Misplaced { what: "messages in the index" }));
                }
                op::MESSAGE if self.marks.last.is_some() => {
                    return Err(damaged(Damage::Misplaced {
                        what: "a message outside of a chunk",
                    }));
                }
                op::CHUNK => {
                    let chunk = Chunk::parse(body).map_err(damaged)?;
                    let checked = chunk.has_checksum();
                    if !checked && self.marks.last.is_some() {
                        return Err(damaged(Damage::NoChecksum));
                    }
                    let at = offset + RECORD_HEAD as u64;
                    self.records.fill(&chunk, at).map_err(damaged)?;
                    self.compression = chunk.compression();
                    self.coverage.add(bytes, checked);
                    return Ok(Outer::Chunk);
                }
                op::SCHEMA | op::CHANNEL | op::MESSAGE if !self.data_ended => {
                    let step = self.channels.take(opcode, body, offset)?;
                    if opcode == op::MESSAGE {
                        self.coverage.add(bytes, false);
                        return Ok(Outer::Step(step));
                    }
                }
                op::METADATA if !self.data_ended => {
                    if let Some((summary, notes)) = Summary::parse(body) {
                        (self.claimed, self.notes) = (Some(summary), notes);
                    }
                    if let Some(description) = summary::description(body) {
                        self.description = description.map_err(damaged)?;
                    }
                }
                op::DATA_END => {
                    self.data_ended = true;
                    // A checksum over all; the format reader has compared it.
                    if Fields(body).u32().is_some_and(|checksum| checksum != 0) {
                        self.coverage.checked = self.coverage.bytes;
                    }
                }
                _ => {}
            }
        }
    }

    fn take_mark(&mut self, mark: Mark, offset: u64) -> Result<(), Damage> {
        let is_first = self.marks.last.is_none();
        self.marks.take(mark, offset)?;
        if is_first {
            self.begin = Some(mark.sequence);
            self.gaps.begin(mark.sequence);
            return Ok(());
        }
        let sequence = mark.sequence as u32;
        if self.gaps.is_past(sequence) {
            let (read, found) = (self.gaps.next_near(mark.sequence), mark.sequence);
            return Err(Damage::Count { read, found });
        }
        self.gaps.up_to(sequence);
        Ok(())
    }

    /// An error of the format reader as one of ours.
    fn explain(&self, error: McapError) -> ReadError {
        let of = |of, saved, calculated| Damage::Checksum { of, saved, calculated };
        let damage = match error {
            McapError::UnexpectedEof if self.tail[..] != *MAGIC || self.taken <= 8 => {
                return ReadError::Cut { offset: self.offset, end: self.taken };
            }
            McapError::UnexpectedEof => Damage::BeyondEnd,
            McapError::RecordTooLarge { opcode, len } => {
                Damage::TooLong { kind: opcode, claimed: len, most: MOST_RECORD_BYTES as u64 }
            }
            McapError::BadDataCrc { saved, calculated } => of("all data", saved, calculated),
            McapError::BadSummaryCrc { saved, calculated } => of("the index", saved, calculated),
            McapError::BytesAfterEndMagic => Damage::Misplaced { what: "bytes after the end" },
            McapError::BadMagic => Damage::Broken { what: "the end mark" },
            McapError::Parse(_) => Damage::Broken { what: "the index" },
            other => Damage::Other(other.to_string()),
        };
        ReadError::Damaged { offset: self.offset, damage }
    }

    fn try_next(&mut self) -> Result<Option<Record>, ReadError> {
        loop {
            let step = match self.records.next(&mut self.channels) {
                Some(step) => step?,
                None => match self.advance()? {
                    Outer::Step(step) => step,
                    Outer::Header | Outer::Chunk => continue,
                    Outer::End => return self.check_end().map(|()| None),
                },
            };
            match step {
                Step::Record(record) => {
                    self.gaps.before(record.sequence);
                    return Ok(Some(*record));
                }
                Step::Aside(aside) => {
                    let is_status = matches!(aside, Aside::Status { .. });
                    self.statuses += u64::from(is_status);
                    self.skipped += u64::from(matches!(aside, Aside::Foreign { .. }));
                    if !is_status || self.keeps_statuses {
                        self.asides.push(aside);
                    }
                }
                Step::Skipped => self.skipped += 1,
                Step::Other => {}
            }
        }
    }

    /// A whole file that is not of a planner is no recording.
    fn check_end(&self) -> Result<(), ReadError> {
        if self.profile == topic::PROFILE || self.channels.has_ours() {
            return Ok(());
        }
        let mut holds: Vec<_> = self
            .others()
            .take(MOST_NAMED)
            .map(|(topic, messages)| format!("{messages} messages of {topic}"))
            .collect();
        match self.others().count() {
            0 => holds.push("no messages".to_owned()),
            all if all > MOST_NAMED => holds.push(format!("{} more channels", all - MOST_NAMED)),
            _ => {}
        }
        Err(ReadError::NotPlanning { profile: self.profile.clone(), holds: holds.join(", ") })
    }
}

/// Channels of others that an error names.
const MOST_NAMED: usize = 5;

/// Profile and library.
fn header(body: &[u8]) -> Option<(String, String)> {
    let mut fields = Fields(body);
    Some((fields.text()?.to_owned(), fields.text()?.to_owned()))
}

impl<R: Read> Iterator for Reader<R> {
    type Item = Result<Record, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.done {
            return None;
        }
        let next = self.try_next().transpose();
        self.done = !matches!(next, Some(Ok(_)));
        next
    }
}

/// Reads again where a signal came between.
pub(crate) fn retry(mut read: impl FnMut() -> io::Result<usize>) -> io::Result<usize> {
    loop {
        match read() {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            result => return result,
        }
    }
}
