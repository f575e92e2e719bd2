//! Writing recordings.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use mcap::McapError;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use schemas::message::{ReplyPart, Request};
use schemas::status::Status;
use schemas::{codec, topic};

use crate::file::NewFile;
use crate::format::{
    MESSAGE_HEAD, MOST_MESSAGE_BYTES, MOST_STATUS_BYTES, STATUS_SCHEMA, Topic, VERSION_KEY,
};
use crate::mark::{self, Mark};
use crate::options::{Compression, Options};
use crate::record::{Aside, Foreign};
use crate::summary::{self, DESCRIPTION_NAME, SUMMARY_NAME, Summary};
use crate::write_error::WriteError;

/// Writes a recording.
///
/// Call [`flush`](Self::flush) on a timer ([`crate::FLUSH_INTERVAL`]): it closes the chunk,
/// so that readers find everything written before, even if this process is killed later.
/// [`finish`](Self::finish) ends the file; dropping the writer does too, but without
/// [`Summary`] and without reporting errors.
///
/// A file is `NAME.part` until it is finished, locked against other recorders, and watched: one
/// that is removed, moved or cut meanwhile is an error.
///
/// An output error is final for the file: all later calls return it again.
///
/// Memory: the open chunk ([`Options::chunk_bytes`] and one message), the largest message encoded,
/// and some 400 bytes for each chunk so far, as the index is written at the end.
pub struct Writer<W: Write = NewFile> {
    state: State<W>,
    /// What ends the output itself.
    end: fn(W) -> Result<(), WriteError>,
    channels: [u16; 2],
    free_space_channel: u16,
    status_channel: u16,
    /// Channels of others that were copied.
    foreign: Vec<(Arc<Foreign>, u16)>,
    /// Statuses so far.
    statuses: u32,
    /// The message being encoded.
    bytes: Vec<u8>,
    /// Bytes of the open chunk, and of the largest that is not closed.
    chunk: u64,
    chunk_bytes: u64,
    /// Bytes that left the format writer.
    written: Arc<AtomicU64>,
    /// The last mark.
    mark: Mark,
    /// Whether it says nothing new that nothing was written since.
    is_marked: bool,
    /// The last time known; nanoseconds since the Unix epoch.
    time_ns: u64,
    /// When the recorder last looked how far the planner is, and the number of the message that it
    /// was to send next.
    announced: Option<(u64, u64)>,
    /// Messages on the bus so far, lost ones included.
    sequence: u64,
    /// Whether the message before was lost.
    in_gap: bool,
    summary: Summary,
    /// What is written beside it.
    notes: BTreeMap<String, String>,
}

/// A channel for programs that know nothing of planning, such as viewers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ForeignChannel<'a> {
    /// Its name.
    pub topic: &'a str,
    /// Of its messages, such as `json` or `protobuf`.
    pub encoding: &'a str,
    /// The name of its messages' schema.
    pub schema: &'a str,
    /// How the schema is written, such as `jsonschema` or `protobuf`.
    pub schema_encoding: &'a str,
    /// The schema.
    pub schema_data: &'a [u8],
}

/// A channel that was added to a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ForeignChannelId(u16);

enum State<W: Write> {
    Open(Box<mcap::Writer<NoSeek<Counted<W>>>>),
    Failed(WriteError),
}

impl Writer {
    /// Creates the file at `path`, with its channels and no messages. An existing file is
    /// left alone unless `options` say otherwise.
    pub fn create(path: impl AsRef<Path>, options: Options) -> Result<Self, WriteError> {
        Self::create_beside(None, path.as_ref(), options)
    }

    /// The same, and leaves the file `input` (device and inode) alone whatever its name.
    pub(crate) fn create_beside(
        input: Option<(u64, u64)>,
        path: &Path,
        options: Options,
    ) -> Result<Self, WriteError> {
        let file = NewFile::create(path, options.overwrite, options.sync, input)?;
        let part = file.part().map(Path::to_owned);
        // A file without a beginning is no recording; with one, it is an empty one.
        Self::begin(file, options, NewFile::commit).inspect_err(|_| {
            if let Some(part) = part {
                let _ = std::fs::remove_file(part);
            }
        })
    }
}

impl<W: Write> Writer<W> {
    /// Begins a recording on `output`.
    pub fn new(output: W, options: Options) -> Result<Self, WriteError> {
        Self::begin(output, options, |mut output| Ok(output.flush()?))
    }

    fn begin(
        output: W,
        options: Options,
        end: fn(W) -> Result<(), WriteError>,
    ) -> Result<Self, WriteError> {
        let Options { overwrite: _, sync: _, compression, chunk_bytes, description, .. } = options;
        let Options { first, announced, id, .. } = options;
        let id = match id {
            Some(id) => id,
            None => random().map_err(|error| io::Error::other(error.to_string()))?,
        };
        let written = Arc::new(AtomicU64::new(0));
        let output = Counted { output, written: Arc::clone(&written) };
        let mut writer = mcap::WriteOptions::new()
            .profile(topic::PROFILE)
            .library(concat!("clearway recording ", env!("CARGO_PKG_VERSION")))
            .compression(compression.method())
            .compression_level(u32::from(compression == Compression::Zstd))
            .compression_threads(0)
            // Chunks are closed here, each behind a mark.
            .chunk_size(None)
            // They are put together in memory and written whole: the file never holds
            // the placeholder lengths of an open chunk.
            .disable_seeking(true)
            .create(NoSeek::new(output))?;
        let mut description = description;
        description.insert("id".to_owned(), format!("{id:032x}"));
        writer.write_metadata(&Metadata {
            name: DESCRIPTION_NAME.into(),
            metadata: summary::with_checksum(description),
        })?;
        let (time_ns, next) = announced.unwrap_or((0, first));
        let mark = Mark {
            id,
            number: 0,
            offset: written.load(Ordering::Relaxed),
            time_ns,
            sequence: first,
            announced: next.max(first),
            recorded: 0,
        };
        writer.write_private_record(mark::OPCODE, &mark.to_bytes(), Default::default())?;
        let mut channels = [0; 2];
        let version = BTreeMap::from([(VERSION_KEY.to_owned(), codec::VERSION.to_string())]);
        for (topic, channel) in Topic::ALL.into_iter().zip(&mut channels) {
            let data = topic.schema().as_bytes();
            let schema = writer.add_schema(topic.schema_name(), topic::ENCODING, data)?;
            *channel = writer.add_channel(schema, topic.name(), topic::ENCODING, &version)?;
        }
        let of_requests = Topic::Request;
        let schema = of_requests.schema().as_bytes();
        let schema = writer.add_schema(of_requests.schema_name(), topic::ENCODING, schema)?;
        let free_space_channel =
            writer.add_channel(schema, topic::FREE_SPACE, topic::ENCODING, &version)?;
        let schema = Status::schema();
        let schema = writer.add_schema(STATUS_SCHEMA, "jsonschema", schema.as_bytes())?;
        let status_channel = writer.add_channel(schema, topic::STATUS, "json", &BTreeMap::new())?;
        let mut writer = Self {
            state: State::Open(Box::new(writer)),
            end,
            channels,
            free_space_channel,
            status_channel,
            foreign: Vec::new(),
            statuses: 0,
            bytes: Vec::new(),
            chunk: 0,
            chunk_bytes,
            written,
            mark,
            is_marked: false,
            time_ns: 0,
            announced,
            sequence: first,
            in_gap: false,
            summary: Summary::default(),
            notes: BTreeMap::new(),
        };
        // In a chunk of their own: damage to messages does not take them along.
        writer.flush()?;
        Ok(writer)
    }

    /// Appends a request that the recorder took at `log_ns`, nanoseconds since the Unix
    /// epoch. Messages are appended in bus order.
    pub fn write_request(&mut self, request: &Request, log_ns: u64) -> Result<(), WriteError> {
        let mut bytes = std::mem::take(&mut self.bytes);
        bytes.clear();
        codec::encode_into(request, &mut bytes);
        let written = self.append(Topic::Request, request.sent_ns, &bytes, log_ns);
        self.bytes = bytes;
        written
    }

    /// Appends a part of a reply that the recorder took at `log_ns`, nanoseconds since
    /// the Unix epoch. Messages are appended in bus order.
    pub fn write_reply(&mut self, part: &ReplyPart, log_ns: u64) -> Result<(), WriteError> {
        let samples = part.content.as_ref().map_or(&[][..], |trajectory| &trajectory.samples);
        let mut bytes = std::mem::take(&mut self.bytes);
        bytes.clear();
        codec::encode_part_into(part, samples, &mut bytes);
        let written = self.write_encoded_reply(part.sent_ns, &bytes, log_ns);
        self.bytes = bytes;
        written
    }

    /// The same for one that is encoded already ([`codec::encode_part_into`]).
    pub fn write_encoded_reply(
        &mut self,
        sent_ns: u64,
        part: &[u8],
        log_ns: u64,
    ) -> Result<(), WriteError> {
        self.append(Topic::Reply, sent_ns, part, log_ns)
    }

    fn append(
        &mut self,
        topic: Topic,
        sent_ns: u64,
        message: &[u8],
        log_ns: u64,
    ) -> Result<(), WriteError> {
        let bytes = message.len();
        if bytes > MOST_MESSAGE_BYTES {
            self.lost(1);
            return Err(WriteError::TooLarge { bytes, most: MOST_MESSAGE_BYTES });
        }
        if self.chunk >= self.chunk_bytes {
            self.mark()?;
        }
        let header = MessageHeader {
            channel_id: self.channels[topic as usize],
            // MCAP has 32 bits for it: it wraps around.
            sequence: self.sequence as u32,
            log_time: log_ns,
            publish_time: sent_ns,
        };
        self.state.run(|writer| writer.write_to_known_channel(&header, message))?;
        self.chunk += (MESSAGE_HEAD + bytes) as u64;
        self.time_ns = log_ns;
        self.is_marked = false;
        self.sequence += 1;
        self.summary.recorded += 1;
        self.in_gap = false;
        Ok(())
    }

    /// Appends a request that made a free space known to which later ones refer, and which this file
    /// does not have. It is none of the bus's messages that are numbered.
    pub fn write_free_space(&mut self, request: &Request, log_ns: u64) -> Result<(), WriteError> {
        let mut bytes = std::mem::take(&mut self.bytes);
        bytes.clear();
        codec::encode_into(request, &mut bytes);
        let header = MessageHeader {
            channel_id: self.free_space_channel,
            sequence: 0,
            log_time: log_ns,
            publish_time: request.sent_ns,
        };
        let written = self.append_beside(&header, &bytes, MOST_MESSAGE_BYTES);
        self.bytes = bytes;
        written
    }

    /// Appends what a planner says of itself, a JSON object, that the recorder took at `log_ns`.
    /// It is none of the bus's messages that are numbered.
    pub fn write_status(&mut self, json: &str, log_ns: u64) -> Result<(), WriteError> {
        let header = MessageHeader {
            channel_id: self.status_channel,
            sequence: self.statuses,
            log_time: log_ns,
            publish_time: log_ns,
        };
        self.append_beside(&header, json.as_bytes(), MOST_STATUS_BYTES)?;
        self.statuses = self.statuses.wrapping_add(1);
        Ok(())
    }

    /// Appends what stood beside the messages of another recording.
    pub fn write_aside(&mut self, aside: &Aside) -> Result<(), WriteError> {
        match aside {
            Aside::FreeSpace { request, log_ns } => self.write_free_space(request, *log_ns),
            Aside::Status { json, log_ns } => self.write_status(json, *log_ns),
            Aside::Foreign { channel, message, sequence, log_ns, publish_ns } => {
                let header = MessageHeader {
                    channel_id: self.foreign_channel(channel)?,
                    sequence: *sequence,
                    log_time: *log_ns,
                    publish_time: *publish_ns,
                };
                self.append_beside(&header, message, MOST_MESSAGE_BYTES)
            }
        }
    }

    /// The number of a channel of others here.
    fn foreign_channel(&mut self, channel: &Arc<Foreign>) -> Result<u16, WriteError> {
        let known = self.foreign.iter().find(|(known, _)| Arc::ptr_eq(known, channel));
        if let Some((_, id)) = known {
            return Ok(*id);
        }
        let Foreign { topic, encoding, metadata, schema } = &**channel;
        let mut id = 0;
        self.state.run(|writer| {
            let schema = match schema {
                Some((name, encoding, data)) => writer.add_schema(name, encoding, data)?,
                None => 0,
            };
            id = writer.add_channel(schema, topic, encoding, metadata)?;
            Ok(())
        })?;
        self.foreign.push((Arc::clone(channel), id));
        Ok(id)
    }

    /// Adds a channel for programs that know nothing of planning. Readers of recordings skip it.
    pub fn add_channel(
        &mut self,
        channel: &ForeignChannel,
    ) -> Result<ForeignChannelId, WriteError> {
        let ForeignChannel { topic, encoding, schema, schema_encoding, schema_data } = channel;
        let mut id = 0;
        self.state.run(|writer| {
            let schema = writer.add_schema(schema, schema_encoding, schema_data)?;
            id = writer.add_channel(schema, topic, encoding, &BTreeMap::new())?;
            Ok(())
        })?;
        Ok(ForeignChannelId(id))
    }

    /// Appends a message to a channel that was added, with its time in nanoseconds since the Unix
    /// epoch. It is none of the bus's messages that are numbered.
    pub fn write_foreign(
        &mut self,
        channel: ForeignChannelId,
        message: &[u8],
        log_ns: u64,
    ) -> Result<(), WriteError> {
        let header = MessageHeader {
            channel_id: channel.0,
            sequence: 0,
            log_time: log_ns,
            publish_time: log_ns,
        };
        self.append_beside(&header, message, MOST_MESSAGE_BYTES)
    }

    /// Appends a message that is none of the bus's.
    fn append_beside(
        &mut self,
        header: &MessageHeader,
        message: &[u8],
        most: usize,
    ) -> Result<(), WriteError> {
        let bytes = message.len();
        if bytes > most {
            return Err(WriteError::TooLarge { bytes, most });
        }
        if self.chunk >= self.chunk_bytes {
            self.mark()?;
        }
        self.state.run(|writer| writer.write_to_known_channel(header, message))?;
        self.chunk += (MESSAGE_HEAD + bytes) as u64;
        (self.time_ns, self.is_marked) = (header.log_time, false);
        Ok(())
    }

    /// Bytes of the open chunk, which are not in the file yet.
    pub fn unwritten(&self) -> u64 {
        self.chunk
    }

    /// Closes the chunk and writes the mark behind it, which says how far the recording is.
    fn mark(&mut self) -> Result<(), WriteError> {
        if self.is_marked {
            return Ok(());
        }
        let written = Arc::clone(&self.written);
        let before = self.mark;
        let (time_ns, announced) = self.announced.unwrap_or((self.time_ns, 0));
        let mut mark = Mark {
            id: before.id,
            number: before.number + 1,
            offset: 0,
            time_ns,
            sequence: self.sequence,
            // What came since was sent.
            announced: announced.max(self.sequence),
            recorded: self.summary.recorded,
        };
        self.state.run(|writer| {
            writer.flush()?;
            mark.offset = written.load(Ordering::Relaxed);
            writer.write_private_record(mark::OPCODE, &mark.to_bytes(), Default::default())
        })?;
        (self.mark, self.is_marked, self.chunk) = (mark, true, 0);
        Ok(())
    }

    /// Notes how many messages the planner has sent by `time_ns` (nanoseconds since the Unix
    /// epoch) that have not come here yet. All marks from now on say so; the next flush writes one,
    /// even if nothing else is new.
    pub fn heartbeat(&mut self, time_ns: u64, waiting: u64) {
        self.announced = Some((time_ns, self.sequence.saturating_add(waiting)));
        self.is_marked = false;
    }

    /// Notes what is written beside the totals at the end.
    pub fn note_at_end(&mut self, name: &str, value: String) {
        self.notes.insert(name.to_owned(), value);
    }

    /// Bytes of the file so far, without the open chunk.
    pub fn written(&self) -> u64 {
        self.written.load(Ordering::Relaxed)
    }

    /// The number of the next message.
    pub fn sequence(&self) -> u64 {
        self.sequence
    }

    /// Notes that `count` messages are missing here. The next message's `sequence` skips
    /// them, so the gap shows in the file.
    pub fn lost(&mut self, count: u64) {
        if count > 0 {
            self.sequence += count;
            self.summary.lost += count;
            self.summary.gaps += u64::from(!self.in_gap);
            self.is_marked = false;
            self.in_gap = true;
        }
    }

    /// Notes that `count` messages are not recorded by wish. They have no place in the sequence.
    pub fn leave_out(&mut self, count: u64) {
        self.summary.left_out += count;
    }

    /// What the file holds so far.
    pub fn summary(&self) -> Summary {
        self.summary
    }

    /// Closes the chunk and hands everything written so far to the operating system, where
    /// it outlives this process (a power cut only with [`Options::sync`]). Without anything new,
    /// writes nothing.
    pub fn flush(&mut self) -> Result<(), WriteError> {
        self.mark()?;
        self.state.run(|writer| writer.flush())
    }

    /// Writes the summary and the index, and ends the file.
    pub fn finish(mut self) -> Result<Summary, WriteError> {
        let summary = self.summary;
        self.mark()?;
        let mut metadata = std::mem::take(&mut self.notes);
        metadata.append(&mut summary.to_metadata());
        self.state.run(|writer| {
            writer.write_metadata(&Metadata { name: SUMMARY_NAME.into(), metadata })?;
            writer.finish().map(drop)
        })?;
        let State::Open(writer) = self.state else { unreachable!("a failure returned above") };
        (self.end)(writer.into_inner().into_inner().output)?;
        Ok(summary)
    }
}

/// A random number.
pub(crate) fn random() -> Result<u128, getrandom::Error> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)?;
    Ok(u128::from_le_bytes(bytes))
}

/// Counts what goes through it.
struct Counted<W> {
    output: W,
    written: Arc<AtomicU64>,
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = self.output.write(bytes)?;
        self.written.fetch_add(taken as u64, Ordering::Relaxed);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}

impl<W: Write> State<W> {
    /// Runs `operation`, unless one before it failed.
    ///
    /// After a failure the `mcap` writer can return `Ok` for messages that are lost, and
    /// its drop would go on writing: it is taken apart instead.
    fn run(
        &mut self,
        operation: impl FnOnce(&mut mcap::Writer<NoSeek<Counted<W>>>) -> Result<(), McapError>,
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
