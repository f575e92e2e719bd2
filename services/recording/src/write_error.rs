//! Why a recording can't be written.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use mcap::McapError;
use thiserror::Error;

/// Why a recording can't be written.
#[derive(Debug, Clone, Error)]
pub enum WriteError {
    /// The file exists already.
    #[error("{} exists already and is not overwritten", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// Another recorder is writing it.
    #[error("another program is recording to {}", path.display())]
    Locked {
        /// The unfinished file.
        path: PathBuf,
    },
    /// A recorder that was killed has left it unfinished.
    #[error(
        "{} is left of a recording that was not finished: `replay recover` finishes it, --overwrite \
         replaces it",
        path.display()
    )]
    Unfinished {
        /// The unfinished file.
        path: PathBuf,
    },
    /// The file is no longer what was written. This is final.
    #[error("{}: {trouble}; what was recorded since is lost", path.display())]
    File {
        /// The unfinished file.
        path: PathBuf,
        /// What happened to it.
        trouble: Trouble,
    },
    /// The file can't be created.
    #[error("can't create {}: {source}", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: Arc<io::Error>,
    },
    /// Writing failed. This is final: the file is intact up to the last flush, and nothing
    /// is written after it.
    #[error("can't write the recording: {source}")]
    Output {
        /// What the system says.
        source: Arc<io::Error>,
    },
    /// The message is larger than readers accept. It is not written and counts as lost;
    /// later ones are written.
    #[error("a message has {bytes} bytes, the most that can be recorded is {most}")]
    TooLarge {
        /// Bytes of the message.
        bytes: usize,
        /// Bytes allowed.
        most: usize,
    },
}

impl From<McapError> for WriteError {
    fn from(error: McapError) -> Self {
        match error {
            McapError::Io(source) => source.into(),
            other => io::Error::other(other).into(),
        }
    }
}

impl From<io::Error> for WriteError {
    fn from(source: io::Error) -> Self {
        // What the file noticed itself.
        match source.downcast::<Self>() {
            Ok(error) => error,
            Err(source) => Self::Output { source: Arc::new(source) },
        }
    }
}

/// What happened to a file that is being written.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Trouble {
    /// It has no name any more.
    #[error("the file was removed, moved or replaced while it was being written")]
    Gone,
    /// Somebody has cut it.
    #[error("{written} bytes were written, but the file has {found}")]
    Size {
        /// Bytes written.
        written: u64,
        /// Bytes on the disk.
        found: u64,
    },
}
