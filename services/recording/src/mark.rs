//! Marks: what a recorder writes before each chunk, so that its own are known among all bytes.

use crate::error::Damage;
use crate::fields::Fields;

/// Opcode of the record; MCAP leaves those from 0x80 to applications, and readers skip them.
pub(crate) const OPCODE: u8 = 0xc1;

/// Bytes of the record's body.
pub(crate) const BYTES: usize = 76;

const TAG: [u8; 8] = *b"clearway";

/// Stands before each chunk, and where the recorder has flushed.
///
/// It carries the random number of its recording: nothing inside a message can pass for a chunk
/// of the same file. And it says how far the recorder and the planner had come, so that a reader
/// knows what a killed recorder has lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Mark {
    /// The recording's random number.
    pub(crate) id: u128,
    /// Counts the file's marks, from 0.
    pub(crate) number: u64,
    /// Where in the file it begins.
    pub(crate) offset: u64,
    /// When it was written; nanoseconds since the Unix epoch.
    pub(crate) time_ns: u64,
    /// The number of the next message: those before are in the file, or counted as lost.
    pub(crate) sequence: u64,
    /// The number of the message that the planner was to send next, as far as was known.
    pub(crate) announced: u64,
    /// Messages in the file.
    pub(crate) recorded: u64,
}

impl Mark {
    pub(crate) fn to_bytes(self) -> [u8; BYTES] {
        let Self { id, number, offset, time_ns, sequence, announced, recorded } = self;
        let mut bytes = [0; BYTES];
        bytes[..8].copy_from_slice(&TAG);
        bytes[8..24].copy_from_slice(&id.to_le_bytes());
        let numbers = [number, offset, time_ns, sequence, announced, recorded];
        for (number, place) in numbers.into_iter().zip(bytes[24..72].chunks_exact_mut(8)) {
            place.copy_from_slice(&number.to_le_bytes());
        }
        let checksum = crc32fast::hash(&bytes[..72]);
        bytes[72..].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }

    /// Reads a record; none if it is another program's.
    pub(crate) fn parse(opcode: u8, body: &[u8]) -> Option<Result<Self, Damage>> {
        if opcode != OPCODE || !body.starts_with(&TAG) || body.len() != BYTES {
            return None;
        }
        let mut fields = Fields(&body[8..]);
        let id = u128::from_le_bytes(fields.array()?);
        let mut number = || fields.u64();
        let mark = Self {
            id,
            number: number()?,
            offset: number()?,
            time_ns: number()?,
            sequence: number()?,
            announced: number()?,
            recorded: number()?,
        };
        let (saved, calculated) = (fields.u32()?, crc32fast::hash(&body[..72]));
        Some(if saved == calculated {
            Ok(mark)
        } else {
            Err(Damage::Checksum { of: "a mark", saved, calculated })
        })
    }

    /// What every mark of a recording begins with, its record's opcode and length included.
    pub(crate) fn beginning(id: u128) -> [u8; 33] {
        let mut bytes = [0; 33];
        bytes[0] = OPCODE;
        bytes[1..9].copy_from_slice(&(BYTES as u64).to_le_bytes());
        bytes[9..17].copy_from_slice(&TAG);
        bytes[17..].copy_from_slice(&id.to_le_bytes());
        bytes
    }
}

/// Follows the marks of a file.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Marks {
    /// The last one; none in files of other programs, and of our version 1.
    pub(crate) last: Option<Mark>,
    /// Whether it is the record just read.
    is_here: bool,
}

impl Marks {
    /// Takes in the mark at byte `offset`.
    pub(crate) fn take(&mut self, mark: Mark, offset: u64) -> Result<(), Damage> {
        let expected = self.last.map_or(0, |last| last.number + 1);
        if let Some(last) = self.last
            && last.id != mark.id
        {
            return Err(Damage::Stranger { found: mark.id, expected: last.id });
        }
        if mark.number != expected {
            return Err(Damage::Order { found: mark.number, expected });
        }
        if mark.offset != offset {
            return Err(Damage::Moved { written: mark.offset });
        }
        (self.last, self.is_here) = (Some(mark), true);
        Ok(())
    }

    /// Whether a record other than a mark may be here.
    pub(crate) fn pass(&mut self, is_chunk: bool) -> Result<(), Damage> {
        let here = std::mem::replace(&mut self.is_here, false);
        if is_chunk && self.last.is_some() && !here {
            return Err(Damage::Misplaced { what: "a chunk without the mark before it" });
        }
        Ok(())
    }
}
