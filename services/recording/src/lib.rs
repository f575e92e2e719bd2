//! Recordings: all traffic between clients and planner, in bus order, as MCAP files.
//!
//! A recording has the profile `planning` and two channels, `/planner/request` and
//! `/planner/reply`, whose messages are [`schemas::codec`]'s bytes; the schema records
//! describe these in words. Messages lie in uncompressed chunks, each with a checksum.
//! [`Writer`] cuts a chunk at every [`Writer::flush`], so that a killed recorder loses
//! what came since the last one and nothing before it. [`Reader`] returns no message
//! whose checksum it has not verified, and [`recover`] copies what is whole in a file
//! that is not.
//!
//! Tools for MCAP read these files; this is the only crate that names the `mcap` crate.

mod chunk;
mod read;
mod recover;
#[cfg(test)]
mod tests;
mod write;

use std::time::Duration;

pub use read::{Damage, Message, ReadError, Reader, Record};
pub use recover::{RecoverError, Recovered, recover};
pub use write::{Options, WriteError, Writer};

/// How often a recorder calls [`Writer::flush`] unless told otherwise: what a killed
/// recorder loses at most.
pub const FLUSH_INTERVAL: Duration = Duration::from_millis(250);

/// A chunk that has this many bytes is closed before the next message, flushed or not. So
/// the largest chunk has this many bytes and one message; the writer holds that much.
pub const CHUNK_BYTES: u64 = 1 << 20;

/// The largest message, bytes: what the codec decodes. (A part of a reply has some
/// 130 KiB, a request with 100,000 channels 6.5 MB.)
pub const MOST_MESSAGE_BYTES: usize = schemas::codec::MOST_BYTES;

/// The longest record that is read. Lengths are what damage makes dangerous: one flipped
/// bit can claim 2^56 bytes. Below this limit memory is taken only for bytes that the
/// file really has.
const MOST_RECORD_BYTES: usize = MOST_MESSAGE_BYTES + (2 << 20);

/// Name of the metadata record that [`Writer::finish`] writes.
const SUMMARY_NAME: &str = "clearway.recording";

/// What a recording says of itself at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Summary {
    /// Messages in the file.
    pub recorded: u64,
    /// Messages that the recorder knows it missed.
    pub lost: u64,
    /// How often messages in a row were missed.
    pub gaps: u64,
}

/// The channels of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Topic {
    Request,
    Reply,
}

impl Topic {
    const ALL: [Self; 2] = [Self::Request, Self::Reply];

    fn name(self) -> &'static str {
        match self {
            Self::Request => schemas::topic::REQUEST,
            Self::Reply => schemas::topic::REPLY,
        }
    }

    fn schema_name(self) -> &'static str {
        match self {
            Self::Request => "clearway.Request",
            Self::Reply => "clearway.ReplyPart",
        }
    }

    fn schema(self) -> &'static str {
        match self {
            Self::Request => schemas::codec::REQUEST_SCHEMA,
            Self::Reply => schemas::codec::REPLY_SCHEMA,
        }
    }
}
