//! Writing what was taken.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use recording::{Finished, Options, PartHead, Series, Split, Summary, Uploads, WriteError};
use schemas::codec;
use schemas::message::{Digest, ErrorCode, ReplyPart, Request, Sample};

use crate::progress::Written;
use crate::settings::{Settings, Snapshot};
use crate::size;

/// What the taking thread hands over: messages, and what came between them, in order.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    pub(crate) taken: Vec<Taken>,
    /// The parts of replies, encoded, one after the other.
    pub(crate) parts: Vec<u8>,
}

impl Batch {
    /// Adds a part of a reply whose samples lie elsewhere.
    pub(crate) fn add_part(&mut self, part: &ReplyPart, samples: &[Sample], log_ns: u64) {
        let before = self.parts.len();
        codec::encode_part_into(part, samples, &mut self.parts);
        let bytes = self.parts.len() - before;
        self.taken.push(Taken::Reply { head: PartHead::of(part), bytes, log_ns });
    }

    /// Takes out what it holds, each with the bytes of its part of a reply.
    fn drain(&mut self) -> impl Iterator<Item = (Taken, &[u8])> {
        let mut parts = &self.parts[..];
        self.taken.drain(..).map(move |taken| {
            let Taken::Reply { bytes, .. } = taken else { return (taken, &[][..]) };
            let (part, rest) = parts.split_at(bytes);
            parts = rest;
            (taken, part)
        })
    }

    /// Forgets what it holds, not its memory.
    fn clear(&mut self) {
        self.taken.clear();
        self.parts.clear();
    }
}

/// What came.
#[derive(Debug, Clone)]
pub(crate) enum Taken {
    Request {
        request: Box<Request>,
        log_ns: u64,
    },
    /// A part of a reply, which has so many bytes.
    Reply {
        head: PartHead,
        bytes: usize,
        log_ns: u64,
    },
    /// A request before the recording that made a free space known.
    FreeSpace {
        request: Box<Request>,
    },
    Status {
        json: String,
        log_ns: u64,
    },
    Lost {
        messages: u64,
    },
    /// They are not to be recorded.
    LeftOut {
        messages: u64,
    },
    /// How many messages wait.
    Heartbeat {
        time_ns: u64,
        waiting: u64,
    },
    /// The time, and messages that wait, if that is news.
    Flush {
        heartbeat: Option<(u64, u64)>,
    },
    Snapshot,
}

/// Key in the description of a snapshot that has less than the time asked for.
const SHORTENED_KEY: &str = "shortened";

/// How often the disk is asked how much is free.
const LOOK: Duration = Duration::from_millis(500);

/// Where it goes.
pub(crate) struct Store {
    target: Target,
    folder: PathBuf,
    min_free: Option<u64>,
    looked: Option<Instant>,
    written: Arc<Written>,
}

enum Target {
    Files(Box<Series>),
    Memory(Box<Ring>),
}

impl Store {
    pub(crate) fn create(
        settings: &Settings,
        description: BTreeMap<String, String>,
        written: Arc<Written>,
    ) -> Result<Self, WriteError> {
        let options = Options {
            overwrite: settings.overwrite,
            compression: settings.compression,
            chunk_bytes: settings.chunk_bytes,
            sync: settings.sync,
            description,
            ..Options::default()
        };
        let target = match &settings.snapshot {
            None => {
                let mut series = Series::create(&settings.output, options, settings.split)?;
                if !settings.topics.replies {
                    series.expect_no_replies();
                }
                Target::Files(Box::new(series))
            }
            Some(snapshot) => Target::Memory(Box::new(Ring::new(
                &settings.output,
                options,
                snapshot,
                settings.topics.requests,
            ))),
        };
        let folder = settings.output.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).to_owned();
        let mut store = Self { target, folder, min_free: settings.min_free, looked: None, written };
        store.report();
        Ok(store)
    }

    /// Stores what a batch holds, and empties it.
    pub(crate) fn store(&mut self, batch: &mut Batch) -> Result<(), WriteError> {
        let mut is_flush = false;
        for (taken, part) in batch.drain() {
            is_flush |= matches!(taken, Taken::Flush { .. });
            match &mut self.target {
                Target::Files(series) => into_files(series, taken, part)?,
                Target::Memory(ring) => ring.keep(taken, part)?,
            }
        }
        batch.clear();
        if is_flush {
            self.report();
        }
        Ok(())
    }

    /// Tells how far it is.
    fn report(&mut self) {
        let (summary, bytes) = match &self.target {
            Target::Files(series) => (series.summary(), series.written()),
            Target::Memory(ring) => (ring.summary(), ring.bytes_written),
        };
        self.written.messages.store(summary.recorded, Ordering::Relaxed);
        self.written.lost.store(summary.lost, Ordering::Relaxed);
        self.written.bytes.store(bytes, Ordering::Relaxed);
        if self.looked.is_some_and(|looked| looked.elapsed() < LOOK) {
            return;
        }
        self.looked = Some(Instant::now());
        let Ok(disk) = rustix::fs::statvfs(&self.folder) else { return };
        let free = disk.f_bavail.saturating_mul(disk.f_frsize);
        self.written.free.store(free, Ordering::Relaxed);
        let is_full = self.min_free.is_some_and(|least| free < least);
        self.written.is_full.store(is_full, Ordering::Relaxed);
    }

    pub(crate) fn finish(self) -> Result<Finished, WriteError> {
        match self.target {
            Target::Files(series) => series.finish(),
            Target::Memory(ring) => Ok(Finished {
                summary: ring.stored,
                files: ring.files,
                removed: 0,
                missing: ring.missing,
            }),
        }
    }
}

/// `part` is the part of a reply.
fn into_files(series: &mut Series, taken: Taken, part: &[u8]) -> Result<(), WriteError> {
    let written = match taken {
        Taken::Request { request, log_ns } => series.write_request(&request, log_ns),
        Taken::Reply { head, bytes: _, log_ns } => series.write_encoded_reply(&head, part, log_ns),
        Taken::Heartbeat { time_ns, waiting } => {
            series.heartbeat(time_ns, waiting);
            Ok(())
        }
        Taken::FreeSpace { request } => {
            series.know_one(&request);
            Ok(())
        }
        Taken::Status { json, log_ns } => series.write_status(&json, log_ns),
        Taken::Lost { messages } => series.lost(messages),
        Taken::LeftOut { messages } => series.leave_out(messages),
        Taken::Flush { heartbeat } => series.flush(heartbeat),
        Taken::Snapshot => Ok(()),
    };
    match written {
        // The writer counts it as lost; recording goes on.
        Err(error @ WriteError::TooLarge { .. }) => {
            tracing::warn!(%error, "message lost");
            Ok(())
        }
        done => done,
    }
}

/// The last messages, in memory.
struct Ring {
    path: PathBuf,
    options: Options,
    time: Duration,
    most_bytes: u64,
    on: Vec<ErrorCode>,
    kept: VecDeque<Kept>,
    bytes: u64,
    /// When the last message came that had to go before its time.
    cut: Option<Instant>,
    /// Where messages are measured.
    scratch: Vec<u8>,
    uploads: Uploads,
    /// Whether requests are recorded.
    has_requests: bool,
    /// A refusal asks for a snapshot.
    is_due: bool,
    /// What all snapshots hold, and how many there are.
    stored: Summary,
    files: u64,
    bytes_written: u64,
    /// Free spaces that none of them has.
    missing: BTreeSet<Digest>,
}

/// Something kept in memory.
struct Kept {
    when: Instant,
    bytes: u64,
    taken: Taken,
    /// The part of a reply, encoded.
    part: Box<[u8]>,
}

impl Ring {
    fn new(path: &Path, options: Options, snapshot: &Snapshot, has_requests: bool) -> Self {
        Self {
            path: path.to_owned(),
            options,
            time: snapshot.time,
            most_bytes: snapshot.most_bytes,
            on: snapshot.on.clone(),
            kept: VecDeque::new(),
            bytes: 0,
            cut: None,
            scratch: Vec::new(),
            uploads: Uploads::default(),
            has_requests,
            is_due: false,
            stored: Summary::default(),
            files: 0,
            bytes_written: 0,
            missing: BTreeSet::new(),
        }
    }

    fn summary(&self) -> Summary {
        self.stored
    }

    fn keep(&mut self, taken: Taken, part: &[u8]) -> Result<(), WriteError> {
        let now = Instant::now();
        while self.kept.front().is_some_and(|kept| now - kept.when > self.time) {
            self.forget_oldest();
        }
        match taken {
            Taken::Snapshot => return self.write(),
            Taken::Flush { .. } => {
                // At a flush, so that several refusals at once are one snapshot.
                return if std::mem::take(&mut self.is_due) { self.write() } else { Ok(()) };
            }
            Taken::Reply { head, .. } => {
                self.is_due |= head.refusal.is_some_and(|code| self.on.contains(&code));
            }
            Taken::Request { ref request, .. } => {
                self.uploads.note(request);
            }
            Taken::FreeSpace { ref request } => {
                self.uploads.note(request);
                return Ok(());
            }
            // It is about files.
            Taken::Heartbeat { .. } => return Ok(()),
            Taken::Status { .. } | Taken::Lost { .. } | Taken::LeftOut { .. } => {}
        }
        let bytes = self.size(&taken);
        self.kept.push_back(Kept { when: now, bytes, taken, part: part.into() });
        self.bytes += bytes;
        while self.bytes > self.most_bytes {
            if self.cut.is_none() {
                let (most, time) = (size::text(self.most_bytes), self.time);
                tracing::warn!(
                    "the messages of {time:?} take more than {most}; the oldest go first"
                );
            }
            self.cut = self.forget_oldest();
        }
        Ok(())
    }

    /// Forgets the oldest, and says when that came.
    fn forget_oldest(&mut self) -> Option<Instant> {
        let Kept { when, bytes, .. } = self.kept.pop_front()?;
        self.bytes -= bytes;
        Some(when)
    }

    /// The memory that it takes, bytes: itself, and its lists, which take as much as they do in a
    /// file.
    fn size(&mut self, taken: &Taken) -> u64 {
        self.scratch.clear();
        let more = match taken {
            Taken::Request { request, .. } => {
                codec::encode_into(&**request, &mut self.scratch);
                self.scratch.len() + size_of::<Request>()
            }
            Taken::Reply { bytes, .. } => *bytes,
            Taken::Status { json, .. } => json.len(),
            _ => 0,
        };
        (size_of::<Kept>() + more) as u64
    }

    /// What a snapshot that is shorter than asked for says of itself.
    fn shortened(&self) -> Option<String> {
        let cut = self.cut.filter(|cut| cut.elapsed() <= self.time)?;
        let has = self.kept.front().map_or(Duration::ZERO, |kept| kept.when.elapsed());
        let (most, time) = (size::text(self.most_bytes), self.time);
        let (has, cut) = (has.as_secs_f64(), cut.elapsed().as_secs_f64());
        Some(format!("{has:.3} s of {time:?}: what came {cut:.3} s ago took it beyond {most}"))
    }

    /// Writes what is kept into a file of its own.
    fn write(&mut self) -> Result<(), WriteError> {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let end = self.path.extension().unwrap_or("mcap".as_ref()).to_string_lossy();
        let path = self.path.with_file_name(format!("{stem}-{:04}.{end}", self.files));
        let mut options = self.options.clone();
        if let Some(shortened) = self.shortened() {
            tracing::warn!(output = %path.display(), "the snapshot has {shortened}");
            options.description.insert(SHORTENED_KEY.to_owned(), shortened);
        }
        let mut series = Series::create(&path, options, Split::default())?;
        series.know(self.uploads.clone());
        let mut asked = BTreeSet::new();
        (self.bytes, self.cut) = (0, None);
        for Kept { taken, part, .. } in self.kept.drain(..) {
            match &taken {
                Taken::Request { request, .. } => {
                    asked.insert(request.key);
                }
                // Its request came before the time that is kept.
                Taken::Reply { head, .. } if self.has_requests && !asked.contains(&head.key) => {
                    continue;
                }
                _ => {}
            }
            into_files(&mut series, taken, &part)?;
        }
        self.bytes_written += series.written();
        let Finished { summary, mut missing, .. } = series.finish()?;
        self.missing.append(&mut missing);
        self.stored = self.stored.plus(summary);
        self.files += 1;
        tracing::info!(output = %path.display(), messages = summary.recorded, "snapshot");
        Ok(())
    }
}
