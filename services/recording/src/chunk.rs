//! Chunks: their records, decompressed and verified.

use std::io::Read;

use crate::channels::{Channels, Step};
use crate::error::{Damage, ReadError};
use crate::fields::Fields;
use crate::format::MOST_RECORD_BYTES;
use crate::options::Compression;

/// The header of a chunk, and what is behind it.
pub(crate) struct Chunk<'a> {
    /// Where its data begin in the record's body.
    pub(crate) begin: usize,
    /// The checksum of its records; 0 means that it has none.
    checksum: u32,
    /// Bytes of its records.
    records: u64,
    compression: &'a str,
    data: &'a [u8],
}

impl<'a> Chunk<'a> {
    /// Reads the body of a chunk record.
    pub(crate) fn parse(body: &'a [u8]) -> Result<Self, Damage> {
        let mut fields = Fields(body);
        let broken = || Damage::Broken { what: "a chunk's header" };
        let _times = fields.bytes(16).ok_or_else(broken)?;
        let records = fields.u64().ok_or_else(broken)?;
        let checksum = fields.u32().ok_or_else(broken)?;
        let compression = fields.text().ok_or_else(broken)?;
        let claimed = fields.u64().ok_or_else(broken)?;
        let begin = body.len() - fields.0.len();
        let given = fields.0.len() as u64;
        // By the specification records may be longer than their fields.
        let data = usize::try_from(claimed).ok().and_then(|claimed| fields.bytes(claimed));
        let data = data.ok_or(Damage::ChunkLength { claimed, given })?;
        Ok(Self { begin, checksum, records, compression, data })
    }

    /// Whether it names a checksum. By the specification it need not.
    pub(crate) fn has_checksum(&self) -> bool {
        self.checksum != 0
    }

    /// How its records are compressed.
    pub(crate) fn compression(&self) -> Compression {
        match self.compression {
            "lz4" => Compression::Lz4,
            "zstd" => Compression::Zstd,
            // Others are refused when they are unpacked.
            _ => Compression::None,
        }
    }

    fn is_compressed(&self) -> bool {
        !self.compression.is_empty()
    }

    /// Takes its records out and compares their checksum, if it has one.
    fn unpack(&self, bytes: &mut Vec<u8>) -> Result<(), Damage> {
        bytes.clear();
        let most = MOST_RECORD_BYTES as u64;
        if self.records > most {
            return Err(Damage::ChunkSize { claimed: self.records, most });
        }
        // Memory is taken as records come, and never more than they claim.
        let mut limit = |unpacking: &mut dyn Read| {
            unpacking.take(self.records + 1).read_to_end(bytes).map(drop)
        };
        let unpacked = match self.compression {
            "" => limit(&mut &*self.data),
            "zstd" => zstd::stream::read::Decoder::with_buffer(self.data)
                .and_then(|mut decoder| limit(&mut decoder)),
            "lz4" => lz4::Decoder::new(self.data).and_then(|mut decoder| {
                limit(&mut decoder)?;
                decoder.finish().1
            }),
            method => return Err(Damage::Compression { method: method.to_owned() }),
        };
        unpacked.map_err(|error| Damage::Unpack { reason: error.to_string() })?;
        let given = bytes.len() as u64;
        if given != self.records {
            return Err(Damage::ChunkLength { claimed: self.records, given });
        }
        let (saved, calculated) = (self.checksum, crc32fast::hash(bytes));
        if self.has_checksum() && saved != calculated {
            return Err(Damage::Checksum { of: "a chunk", saved, calculated });
        }
        Ok(())
    }
}

/// The records of a verified chunk, one after the other.
#[derive(Default)]
pub(crate) struct Records {
    /// All of them.
    bytes: Vec<u8>,
    /// Where the next begins.
    at: usize,
    /// Where in the file they begin.
    offset: u64,
    is_compressed: bool,
}

impl Records {
    /// Goes on with those of the chunk whose record's body begins at byte `offset`. Those of a
    /// damaged chunk can be looked at as well.
    pub(crate) fn fill(&mut self, chunk: &Chunk, offset: u64) -> Result<(), Damage> {
        self.at = 0;
        self.offset = offset + chunk.begin as u64;
        self.is_compressed = chunk.is_compressed();
        chunk.unpack(&mut self.bytes)
    }

    /// The next record. Records can be read on after an error, too.
    pub(crate) fn next(&mut self, channels: &mut Channels) -> Option<Result<Step, ReadError>> {
        let mut fields = Fields(&self.bytes[self.at..]);
        if fields.0.is_empty() {
            return None;
        }
        // Compressed records have no place in the file but their chunk's.
        let offset = self.offset + if self.is_compressed { 0 } else { self.at as u64 };
        let Some((opcode, body)) = fields.record() else {
            self.at = self.bytes.len();
            let damage = Damage::Broken { what: "the last record of a chunk" };
            return Some(Err(ReadError::Damaged { offset, damage }));
        };
        self.at = self.bytes.len() - fields.0.len();
        Some(channels.take(opcode, body, offset))
    }
}
