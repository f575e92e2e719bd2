//! Messages as bytes, for recordings: bincode, little-endian, integers of fixed width.
//!
//! The encoding is canonical and simple enough to read in any language. A recording
//! identifies its messages by schema name ([`REQUEST_NAME`], [`REPLY_NAME`]) and version
//! number ([`VERSION`]); [`REQUEST_SCHEMA`] and [`REPLY_SCHEMA`] describe them to people
//! and are never compared. The rules:
//!
//! - Any change to the bytes is a new version.
//! - A reader reads its own version and every version before it. Versions 1 and 2 are frozen in
//!   `codec/version_1.rs` and `codec/version_2.rs`; whoever changes a message freezes the version before there,
//!   in a module of its own.
//! - A reader refuses a later version and names both numbers.
//! - A writer writes the newest version only.
//!
//! This is the only file that names the `bincode` crate, which is pinned (its development
//! has ended; see `deny.toml`).

mod version_1;
mod version_2;

use bincode::config::{Configuration, Fixint, Limit, LittleEndian};
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use crate::message::{ReplyPart, Request, Sample, Trajectory};

/// Version of recorded messages.
pub const VERSION: u32 = 3;

/// Schema name of `/planner/request` messages.
pub const REQUEST_NAME: &str = "clearway.Request";
/// Schema name of `/planner/reply` messages.
pub const REPLY_NAME: &str = "clearway.ReplyPart";

/// `/planner/request` messages in words.
pub const REQUEST_SCHEMA: &str = include_str!("codec/request.txt");
/// `/planner/reply` messages in words.
pub const REPLY_SCHEMA: &str = include_str!("codec/reply.txt");

/// Most bytes of a message. An announced length reserves little (1 MiB at a time); memory
/// is taken for bytes that are there.
pub const MOST_BYTES: usize = 256 << 20;

/// Why bytes are not a message.
#[derive(Debug, Error)]
pub enum DecodeError {
    /// They break off or hold impossible values.
    #[error("{0}")]
    Malformed(String),
    /// There are more bytes than the message has.
    #[error("the message ends after {used} of {given} bytes")]
    TrailingBytes {
        /// Bytes of the message.
        used: usize,
        /// Bytes given.
        given: usize,
    },
    /// This version is unknown.
    #[error("the message has version {found}; versions 1 to {newest} are supported")]
    Version {
        /// Its version.
        found: u32,
        /// The newest version that can be read.
        newest: u32,
    },
}

fn configuration() -> Configuration<LittleEndian, Fixint, Limit<MOST_BYTES>> {
    bincode::config::standard().with_fixed_int_encoding().with_limit::<MOST_BYTES>()
}

/// Appends `message` to `bytes`.
pub fn encode_into<T: Serialize>(message: &T, bytes: &mut Vec<u8>) {
    bincode::serde::encode_into_std_write(message, bytes, configuration())
        .expect("messages have no maps of unknown length, and a Vec takes any number of bytes");
}

/// The same for a part of a reply whose samples lie elsewhere, perhaps where the planner wrote them:
/// `samples` take the place of its own, which are not looked at. They are copied as they are.
pub fn encode_part_into(part: &ReplyPart, samples: &[Sample], bytes: &mut Vec<u8>) {
    let Ok(trajectory) = &part.content else { return encode_into(part, bytes) };
    let ReplyPart { key, id, sent_ns, part, last, answer, answers, content: _ } = part;
    let Trajectory {
        dimension,
        gaps_per_junction,
        exit,
        length,
        bound,
        complete,
        duration,
        clearance,
        free_clearance,
        gaps,
        route,
        channels,
        legs,
        samples: _,
        exceeds,
        stops,
    } = trajectory;
    // Fields are encoded one after the other, whatever they are in.
    let of_part = (key, id, sent_ns, part, last, answer, answers);
    let is_refusal = 0_u32;
    let of_path = (dimension, gaps_per_junction, exit, length, bound, complete);
    let more = (duration, clearance, free_clearance, gaps, route, channels, legs);
    encode_into(&(of_part, is_refusal, of_path, more, samples.len() as u64), bytes);
    if cfg!(target_endian = "little") {
        bytes.extend_from_slice(bytemuck::cast_slice(samples));
    } else {
        samples.iter().for_each(|sample| encode_into(sample, bytes));
    }
    encode_into(&(exceeds, stops), bytes);
}

/// `message` as bytes.
pub fn encode<T: Serialize>(message: &T) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode_into(message, &mut bytes);
    bytes
}

/// The message encoded in `bytes`, all of them, in the newest version.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, DecodeError> {
    let (message, used) = bincode::serde::borrow_decode_from_slice(bytes, configuration())
        .map_err(|error| DecodeError::Malformed(error.to_string()))?;
    if used == bytes.len() {
        Ok(message)
    } else {
        Err(DecodeError::TrailingBytes { used, given: bytes.len() })
    }
}

/// A request recorded in `version`.
pub fn decode_request(version: u32, bytes: &[u8]) -> Result<Request, DecodeError> {
    match version {
        1 => version_1::request(bytes),
        2 => version_2::request(bytes),
        VERSION => decode(bytes),
        found => Err(DecodeError::Version { found, newest: VERSION }),
    }
}

/// A part of a reply recorded in `version`.
pub fn decode_reply(version: u32, bytes: &[u8]) -> Result<ReplyPart, DecodeError> {
    match version {
        1 => version_1::reply(bytes),
        2 => version_2::reply(bytes),
        VERSION => decode(bytes),
        found => Err(DecodeError::Version { found, newest: VERSION }),
    }
}
