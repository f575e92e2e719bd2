//! Messages as bytes, for recordings: bincode, little-endian, integers of fixed width.
//!
//! This is the only file that names the codec. It is pinned (its development has
//! ended; see `deny.toml`), and its form is canonical and simple enough for any
//! language: [`REQUEST_SCHEMA`] and [`REPLY_SCHEMA`] describe it in words and
//! stand in every recording.

use bincode::config::{Configuration, Fixint, Limit, LittleEndian};
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

/// The layout of `/planner/request` messages, in words.
pub const REQUEST_SCHEMA: &str = include_str!("codec/request.txt");
/// The layout of `/planner/reply` messages, in words.
pub const REPLY_SCHEMA: &str = include_str!("codec/reply.txt");

/// The most bytes of a message. What a message announces reserves next to nothing
/// (1 MiB at a time); memory is taken for what is there.
pub const MOST_BYTES: usize = 256 << 20;

/// Why bytes are not a message.
#[derive(Debug, Error)]
pub enum DecodeError {
    /// They break off or hold impossible values.
    #[error("{0}")]
    Malformed(String),
    /// There are more bytes than the message has.
    #[error("the message has {used} bytes, but {given} were given")]
    TrailingBytes {
        /// Bytes of the message.
        used: usize,
        /// Bytes given.
        given: usize,
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

/// `message` as bytes.
pub fn encode<T: Serialize>(message: &T) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode_into(message, &mut bytes);
    bytes
}

/// The message that `bytes` are, all of them.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, DecodeError> {
    let (message, used) = bincode::serde::borrow_decode_from_slice(bytes, configuration())
        .map_err(|error| DecodeError::Malformed(error.to_string()))?;
    if used == bytes.len() {
        Ok(message)
    } else {
        Err(DecodeError::TrailingBytes { used, given: bytes.len() })
    }
}
