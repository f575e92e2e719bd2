//! Reading recordings.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError};
use schemas::topic;

use crate::chunk::{self, Channels, Gaps, Records, Step};
use crate::error::{Damage, ReadError};
use crate::fields::{Fields, RECORD_HEAD};
use crate::format::MOST_RECORD_BYTES;
use crate::record::Record;
use crate::summary::Summary;

/// Reads a recording from its beginning, in file order, which is bus order.
///
/// It returns messages of chunks whose checksum it has verified, and nothing else. After the
/// first error it returns nothing more; the messages before are right. Channels with other
/// names, such as those for viewers, are skipped and counted.
///
/// The file is read as a stream; memory is taken for one chunk, and never more than the file
/// has left.
///
/// Damage to a length in an unfinished file can look like a cut. The checksum over the whole
/// file, which shows that no chunk is missing, is known only at its end.
pub struct Reader<R: Read = File> {
    input: R,
    linear: LinearReader,
    /// Where the next record begins.
    offset: u64,
    /// Bytes read from the input, and the last eight of them.
    taken: u64,
    tail: [u8; 8],
    library: String,
    records: Records,
    channels: Channels,
    gaps: Gaps,
    skipped: u64,
    claimed: Option<Summary>,
    data_ended: bool,
    done: bool,
}

/// What the outer structure of the file brings next.
enum Outer {
    Header,
    Chunk,
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
        // Chunks are taken whole (and verified in `chunk`): the reader would also yield
        // messages that stand outside of them, for which no checksum vouches, and chunks
        // that name none.
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
            library: String::new(),
            records: Records::default(),
            channels: Channels::default(),
            gaps: Gaps::default(),
            skipped: 0,
            claimed: None,
            data_ended: false,
            done: false,
        };
        reader.read_magic()?;
        match reader.advance()? {
            Outer::Header => Ok(reader),
            Outer::Chunk | Outer::End => {
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

    /// Messages of other channels skipped so far.
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
            let damaged = |damage| Err(ReadError::Damaged { offset, damage });
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
            self.offset += (RECORD_HEAD + body.len()) as u64;
            let first = offset == MAGIC.len() as u64;
            match opcode {
                op::HEADER if first => {
                    let mut fields = Fields(body);
                    let (Some(profile), Some(library)) = (fields.text(), fields.text()) else {
                        return damaged(Damage::Broken { what: "the header" });
                    };
                    if profile != topic::PROFILE {
                        let (found, expected) = (profile.to_owned(), topic::PROFILE);
                        return Err(ReadError::Profile { found, expected });
                    }
                    self.library = library.to_owned();
                    return Ok(Outer::Header);
                }
                _ if first => {
                    let what = "something else before the header";
                    return damaged(Damage::Misplaced { what });
                }
                op::HEADER => return damaged(Damage::Misplaced { what: "a header" }),
                op::MESSAGE => {
                    let what = "a message outside of a chunk";
                    return damaged(Damage::Misplaced { what });
                }
                op::CHUNK if self.data_ended => {
                    let what = "a chunk in the summary";
                    return damaged(Damage::Misplaced { what });
                }
                op::CHUNK => {
                    let (begin, records) = match chunk::verify(body) {
                        Ok(verified) => verified,
                        Err(damage) => return damaged(damage),
                    };
                    self.records.fill(records, offset + (RECORD_HEAD + begin) as u64);
                    return Ok(Outer::Chunk);
                }
                op::METADATA if !self.data_ended => {
                    self.claimed = Summary::parse(body).or(self.claimed);
                }
                op::DATA_END => self.data_ended = true,
                _ => {}
            }
        }
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
            while let Some(step) = self.records.next(&mut self.channels) {
                match step? {
                    Step::Record(record) => {
                        self.gaps.before(record.sequence);
                        return Ok(Some(*record));
                    }
                    Step::Skipped => self.skipped += 1,
                    Step::Other => {}
                }
            }
            if let Outer::End = self.advance()? {
                return Ok(None);
            }
        }
    }
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
