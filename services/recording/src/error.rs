//! Why a recording can't be read.

use std::io;

use schemas::codec::DecodeError;
use thiserror::Error;

/// Why a recording can't be read, or not any further.
#[derive(Debug, Error)]
pub enum ReadError {
    /// Reading the file failed.
    #[error("can't read at byte {offset}: {source}")]
    Io {
        /// Where in the file.
        offset: u64,
        /// What the system says.
        source: io::Error,
    },
    /// It is not an MCAP file.
    #[error("not an MCAP file: it begins with the bytes {found:02x?}")]
    NotMcap {
        /// Its first bytes, at most 8.
        found: Vec<u8>,
    },
    /// It is a whole MCAP file, but none of a planner.
    #[error("no recording of planning: an MCAP file of profile {profile:?} with {holds}")]
    NotPlanning {
        /// The file's profile.
        profile: String,
        /// Its channels, in words.
        holds: String,
    },
    /// A channel has the name of one of ours but holds something else.
    #[error("byte {offset}: the {what} of {topic} is {found:?}, expected {expected:?}")]
    Channel {
        /// Where in the file.
        offset: u64,
        /// The channel.
        topic: &'static str,
        /// What differs.
        what: &'static str,
        /// How it begins in the file.
        found: String,
        /// What it should be.
        expected: String,
    },
    /// Its messages are of a version that this program does not know.
    #[error(
        "byte {offset}: {topic} holds {schema} version {found}, this program reads versions 1 to {newest}"
    )]
    Version {
        /// Where in the file.
        offset: u64,
        /// The channel.
        topic: &'static str,
        /// The schema's name.
        schema: &'static str,
        /// The file's version.
        found: u32,
        /// The newest version that can be read.
        newest: u32,
    },
    /// The file was not finished, as when its recorder was killed. All messages before
    /// `offset` were read.
    #[error("the recording is cut: it ends at byte {end}, inside the record at byte {offset}")]
    Cut {
        /// Where the first record begins that is not whole.
        offset: u64,
        /// Where the file ends.
        end: u64,
    },
    /// Its bytes are not what was written. All messages before `offset` were read.
    #[error("the recording is damaged at byte {offset}: {damage}")]
    Damaged {
        /// Where the damaged record begins.
        offset: u64,
        /// What is wrong with it.
        damage: Damage,
    },
    /// A message's bytes are as they were written, but can't be decoded.
    #[error("byte {offset}: message {sequence} of {topic} can't be decoded: {source}")]
    Message {
        /// Where its record begins.
        offset: u64,
        /// Its channel.
        topic: &'static str,
        /// Its number.
        sequence: u32,
        /// Why not.
        source: DecodeError,
    },
}

impl ReadError {
    /// Whether the file just ends early and everything before its end is in order.
    pub fn is_cut(&self) -> bool {
        matches!(self, Self::Cut { .. })
    }
}

/// What is wrong with bytes of a recording.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Damage {
    /// A checksum is not that of the bytes.
    #[error("the checksum of {of} is {saved:08x}, its bytes have {calculated:08x}")]
    Checksum {
        /// What the checksum is of.
        of: &'static str,
        /// The file's.
        saved: u32,
        /// That of the bytes.
        calculated: u32,
    },
    /// A record claims to be longer than any can be.
    #[error("a record of kind {kind:#04x} claims {claimed} bytes, the most is {most}")]
    TooLong {
        /// Its opcode.
        kind: u8,
        /// Bytes claimed.
        claimed: u64,
        /// Bytes allowed.
        most: u64,
    },
    /// A record runs past the end of a finished file.
    #[error("a record claims more bytes than the file has left")]
    BeyondEnd,
    /// A chunk and its header disagree about its size.
    #[error("a chunk claims {claimed} bytes of records, it has {given}")]
    ChunkLength {
        /// Bytes claimed.
        claimed: u64,
        /// Bytes given.
        given: u64,
    },
    /// A record is too short for its fields.
    #[error("{what} breaks off")]
    Broken {
        /// What it is.
        what: &'static str,
    },
    /// A chunk claims to unpack to more than any can.
    #[error("a chunk claims {claimed} bytes of records, the most is {most}")]
    ChunkSize {
        /// Bytes claimed.
        claimed: u64,
        /// Bytes allowed.
        most: u64,
    },
    /// A chunk's data do not unpack.
    #[error("a chunk can't be unpacked: {reason}")]
    Unpack {
        /// What the method says.
        reason: String,
    },
    /// A chunk is compressed in a way that is not of MCAP.
    #[error("a chunk is compressed with {method:?}; \"lz4\" and \"zstd\" can be read")]
    Compression {
        /// The method's name.
        method: String,
    },
    /// No checksum vouches for it.
    #[error("no checksum covers {what}")]
    Unchecked {
        /// What it is.
        what: &'static str,
    },
    /// Records can't be followed any further.
    #[error("{bytes} bytes from here on are no records")]
    Lost {
        /// Bytes up to the end of the file.
        bytes: u64,
    },
    /// A checksum is missing where the recorder writes one.
    #[error("a chunk has no checksum, although its recorder writes one")]
    NoChecksum,
    /// A part of the file is not where it was written.
    #[error("what is here was written at byte {written}")]
    Moved {
        /// Where it was written.
        written: u64,
    },
    /// A part of another recording is in the file.
    #[error("what is here belongs to recording {found:032x}, this one is {expected:032x}")]
    Stranger {
        /// The other recording.
        found: u128,
        /// This one.
        expected: u128,
    },
    /// A part of the file is missing, or there twice.
    #[error("part {found} of the recording is here, where part {expected} should be")]
    Order {
        /// The part's number.
        found: u64,
        /// The number expected.
        expected: u64,
    },
    /// A part of the file does not say how it goes on from the one before.
    #[error("messages up to {found} were recorded before this, but up to {read} are here")]
    Count {
        /// Messages counted here.
        read: u64,
        /// Messages that the recorder had counted.
        found: u64,
    },
    /// A record is where it may not be.
    #[error("unexpected record: {what}")]
    Misplaced {
        /// What it is.
        what: &'static str,
    },
    /// A message names a channel that the file does not define.
    #[error("a message belongs to channel {channel}, which the file does not define")]
    UnknownChannel {
        /// The channel's number.
        channel: u16,
    },
    /// A number is defined twice.
    #[error("{what} {id} is defined twice, differently")]
    Redefined {
        /// What it is.
        what: &'static str,
        /// Its number.
        id: u16,
    },
    /// Anything else that the format forbids.
    #[error("{0}")]
    Other(String),
}
