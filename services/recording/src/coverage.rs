//! How much of a recording checksums vouch for.

use std::fmt;

/// How much of a recording checksums vouch for.
///
/// MCAP leaves them to the writer: a chunk may have none, and neither has a message outside of a
/// chunk. A checksum over the whole file, which may be at its end, covers all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Coverage {
    /// Bytes of chunks and messages read so far.
    pub bytes: u64,
    /// How many of them a checksum covers.
    pub checked: u64,
}

impl Coverage {
    /// Whether checksums cover all.
    pub fn is_whole(self) -> bool {
        self.checked == self.bytes
    }

    pub(crate) fn add(&mut self, bytes: usize, checked: bool) {
        self.bytes += bytes as u64;
        self.checked += if checked { bytes as u64 } else { 0 };
    }
}

/// Such as `all bytes are covered by checksums`.
impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { bytes, checked } = *self;
        if self.is_whole() {
            f.write_str("all bytes are covered by checksums")
        } else {
            write!(f, "no checksum covers {} of {bytes} bytes of messages", bytes - checked)
        }
    }
}
