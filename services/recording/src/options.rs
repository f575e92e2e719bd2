//! How a recording is written.

use std::collections::BTreeMap;

use crate::format::CHUNK_BYTES;

/// How a recording is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Whether an existing file is replaced.
    pub overwrite: bool,
    /// How chunks are compressed.
    pub compression: Compression,
    /// A chunk of this size is closed before the next message.
    pub chunk_bytes: u64,
    /// Whether each flush waits until the disk has it, so that it outlives a power cut.
    pub sync: bool,
    /// What is written at the beginning about the recording; names and values.
    pub description: BTreeMap<String, String>,
    /// The number of the first message: a recording in several files goes on counting.
    pub first: u64,
    /// When the recorder last looked how far the planner is (nanoseconds since the Unix epoch), and
    /// the number of the message that it was to send next.
    pub announced: Option<(u64, u64)>,
    /// The recording's number; by default a random one.
    pub id: Option<u128>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            overwrite: false,
            compression: Compression::None,
            chunk_bytes: CHUNK_BYTES,
            sync: false,
            description: BTreeMap::new(),
            first: 0,
            announced: None,
            id: None,
        }
    }
}

impl Options {
    /// Those that replace an existing file.
    pub fn overwriting() -> Self {
        Self { overwrite: true, ..Self::default() }
    }
}

/// How chunks are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Compression {
    /// Not at all.
    #[default]
    None,
    /// LZ4: quick.
    Lz4,
    /// Zstandard at its level 1: smaller.
    Zstd,
}

impl Compression {
    pub(crate) fn method(self) -> Option<mcap::Compression> {
        match self {
            Self::None => None,
            Self::Lz4 => Some(mcap::Compression::Lz4),
            Self::Zstd => Some(mcap::Compression::Zstd),
        }
    }
}
