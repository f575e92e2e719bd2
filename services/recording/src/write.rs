//! Writing recordings.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::McapError;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use schemas::message::{ReplyPart, Request};
use schemas::{codec, topic};
use thiserror::Error;

use crate::format::{CHUNK_BYTES, MOST_MESSAGE_BYTES, Topic, VERSION_KEY};
use crate::summary::{SUMMARY_NAME, Summary};

/// How a recording is created.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// Whether an existing file is replaced.
    pub overwrite: bool,
}

/// Why a recording can't be written.
#[derive(Debug, Clone, Error)]
pub enum WriteError {
    /// The file exists already.
    #[error("{} exists already and is not overwritten", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
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
        let source = match error {
            McapError::Io(source) => source,
            other => io::Error::other(other),
        };
        Self::Output { source: Arc::new(source) }
    }
}

/// Writes a recording.
///
/// Call [`flush`](Self::flush) on a timer ([`crate::FLUSH_INTERVAL`]): it closes the chunk,
/// so that readers find everything written before, even if this process is killed later.
/// [`finish`](Self::finish) ends the file; dropping the writer does too, but without
/// [`Summary`] and without reporting errors.
///
/// An output error is final for the file: all later calls return it again.
///
/// Memory: the open chunk ([`CHUNK_BYTES`] and one message), the largest message encoded,
/// and some 400 bytes for each chunk so far, as the index is written at the end.
pub struct Writer<W: Write = BufWriter<File>> {
    state: State<W>,
    channels: [u16; 2],
    /// The message being encoded.
    bytes: Vec<u8>,
    /// Messages on the bus so far, lost ones included.
    sequence: u64,
    /// Whether the message before was lost.
    in_gap: bool,
    summary: Summary,
}

enum State<W: Write> {
    Open(Box<mcap::Writer<NoSeek<W>>>),
    Failed(WriteError),
}

impl Writer {
    /// Creates the file at `path`, with its channels and no messages. An existing file is
    /// left alone unless `options` say otherwise.
    pub fn create(path: impl AsRef<Path>, options: Options) -> Result<Self, WriteError> {
        let path = path.as_ref();
        let mut open = OpenOptions::new();
        open.write(true);
        if options.overwrite {
            open.create(true).truncate(true);
        } else {
            open.create_new(true);
        }
        let file = open.open(path).map_err(|error| {
            let path = path.to_owned();
            if error.kind() == io::ErrorKind::AlreadyExists {
                WriteError::Exists { path }
            } else {
                WriteError::Create { path, source: Arc::new(error) }
            }
        })?;
        Self::new(BufWriter::with_capacity(64 << 10, file))
    }
}

impl<W: Write> Writer<W> {
    /// Begins a recording on `output`.
    pub fn new(output: W) -> Result<Self, WriteError> {
        let mut writer = mcap::WriteOptions::new()
            .profile(topic::PROFILE)
            .library(concat!("clearway recording ", env!("CARGO_PKG_VERSION")))
            .compression(None)
            .chunk_size(Some(CHUNK_BYTES))
            // Chunks are put together in memory and written whole: the file never holds
            // the placeholder lengths of an open chunk.
            .disable_seeking(true)
            .create(NoSeek::new(output))?;
        let mut channels = [0; 2];
        let version = BTreeMap::from([(VERSION_KEY.to_owned(), codec::VERSION.to_string())]);
        for (topic, channel) in Topic::ALL.into_iter().zip(&mut channels) {
            let data = topic.schema().as_bytes();
            let schema = writer.add_schema(topic.schema_name(), topic::ENCODING, data)?;
            *channel = writer.add_channel(schema, topic.name(), topic::ENCODING, &version)?;
        }
        // In a chunk of their own: damage to messages does not take them along.
        writer.flush()?;
        Ok(Self {
            state: State::Open(Box::new(writer)),
            channels,
            bytes: Vec::new(),
            sequence: 0,
            in_gap: false,
            summary: Summary::default(),
        })
    }

    /// Appends a request that the recorder took at `log_ns`, nanoseconds since the Unix
    /// epoch. Messages are appended in bus order.
    pub fn write_request(&mut self, request: &Request, log_ns: u64) -> Result<(), WriteError> {
        self.bytes.clear();
        codec::encode_into(request, &mut self.bytes);
        self.append(Topic::Request, request.sent_ns, log_ns)
    }

    /// Appends a part of a reply that the recorder took at `log_ns`, nanoseconds since
    /// the Unix epoch. Messages are appended in bus order.
    pub fn write_reply(&mut self, part: &ReplyPart, log_ns: u64) -> Result<(), WriteError> {
        self.bytes.clear();
        codec::encode_into(part, &mut self.bytes);
        self.append(Topic::Reply, part.sent_ns, log_ns)
    }

    fn append(&mut self, topic: Topic, sent_ns: u64, log_ns: u64) -> Result<(), WriteError> {
        let bytes = self.bytes.len();
        if bytes > MOST_MESSAGE_BYTES {
            self.lost(1);
            return Err(WriteError::TooLarge { bytes, most: MOST_MESSAGE_BYTES });
        }
        let header = MessageHeader {
            channel_id: self.channels[topic as usize],
            // MCAP has 32 bits for it: it wraps around.
            sequence: self.sequence as u32,
            log_time: log_ns,
            publish_time: sent_ns,
        };
        let message = &self.bytes;
        self.state.run(|writer| writer.write_to_known_channel(&header, message))?;
        self.sequence += 1;
        self.summary.recorded += 1;
        self.in_gap = false;
        Ok(())
    }

    /// Notes that `count` messages are missing here. The next message's `sequence` skips
    /// them, so the gap shows in the file.
    pub fn lost(&mut self, count: u64) {
        if count > 0 {
            self.sequence += count;
            self.summary.lost += count;
            self.summary.gaps += u64::from(!self.in_gap);
            self.in_gap = true;
        }
    }

    /// What the file holds so far.
    pub fn summary(&self) -> Summary {
        self.summary
    }

    /// Closes the chunk and hands everything written so far to the operating system, where
    /// it outlives this process (but not a power cut). Without new messages, writes nothing.
    pub fn flush(&mut self) -> Result<(), WriteError> {
        self.state.run(|writer| writer.flush())
    }

    /// Writes the summary and the index, and ends the file.
    pub fn finish(mut self) -> Result<Summary, WriteError> {
        let summary = self.summary;
        self.state.run(|writer| {
            writer.write_metadata(&Metadata {
                name: SUMMARY_NAME.into(),
                metadata: summary.to_metadata(),
            })?;
            writer.finish().map(drop)
        })?;
        let State::Open(writer) = self.state else { unreachable!("a failure returned above") };
        let flushed = writer.into_inner().into_inner().flush();
        flushed.map_err(|source| WriteError::Output { source: Arc::new(source) })?;
        Ok(summary)
    }
}

impl<W: Write> State<W> {
    /// Runs `operation`, unless one before it failed.
    ///
    /// After a failure the `mcap` writer can return `Ok` for messages that are lost, and
    /// its drop would go on writing: it is taken apart instead.
    fn run(
        &mut self,
        operation: impl FnOnce(&mut mcap::Writer<NoSeek<W>>) -> Result<(), McapError>,
    ) -> Result<(), WriteError> {
        match self {
            Self::Failed(error) => Err(error.clone()),
            Self::Open(writer) => operation(writer).map_err(|error| {
                let error = WriteError::from(error);
                let before = std::mem::replace(self, Self::Failed(error.clone()));
                if let Self::Open(writer) = before {
                    drop(writer.into_inner());
                }
                error
            }),
        }
    }
}
