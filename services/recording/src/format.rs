//! What every recording has in common.

use std::time::Duration;

use schemas::{codec, topic};

/// How often a recorder calls [`Writer::flush`](crate::Writer::flush) unless told
/// otherwise: the most that a killed recorder loses.
pub const FLUSH_INTERVAL: Duration = Duration::from_millis(250);

/// A chunk of this size is closed before the next message, flushed or not. So the largest
/// chunk has this many bytes and one message; the writer holds that much.
pub const CHUNK_BYTES: u64 = 1 << 20;

/// The largest message, bytes. (A part of a reply has some 130 KiB, a request with
/// 100,000 channels 6.5 MB.)
pub const MOST_MESSAGE_BYTES: usize = codec::MOST_BYTES;

/// Bytes of a message's record in front of the message.
pub(crate) const MESSAGE_HEAD: usize = 9 + 22;

/// The longest status, bytes.
pub(crate) const MOST_STATUS_BYTES: usize = 1 << 20;

/// Name of the schema of statuses.
pub(crate) const STATUS_SCHEMA: &str = "clearway.Status";

/// The longest record that is read. One flipped bit in a length can claim 2^56 bytes;
/// below this limit memory is taken only for bytes that the file really has.
pub(crate) const MOST_RECORD_BYTES: usize = MOST_MESSAGE_BYTES + (2 << 20);

/// Key in a channel's metadata of its messages' version, a decimal number. Version 1 was
/// written without it.
pub(crate) const VERSION_KEY: &str = "schema_version";

/// The channels of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Topic {
    Request,
    Reply,
}

impl Topic {
    pub(crate) const ALL: [Self; 2] = [Self::Request, Self::Reply];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Request => topic::REQUEST,
            Self::Reply => topic::REPLY,
        }
    }

    pub(crate) fn schema_name(self) -> &'static str {
        match self {
            Self::Request => codec::REQUEST_NAME,
            Self::Reply => codec::REPLY_NAME,
        }
    }

    /// The schema's description, for people.
    pub(crate) fn schema(self) -> &'static str {
        match self {
            Self::Request => codec::REQUEST_SCHEMA,
            Self::Reply => codec::REPLY_SCHEMA,
        }
    }
}
