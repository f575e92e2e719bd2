//! Writing what was taken.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use bus::TapMessage;
use recording::{Options, Series, Split, Summary, Uploads, WriteError};
use schemas::message::ErrorCode;

use crate::progress::Written;
use crate::settings::{Settings, Snapshot};

/// What the taking thread hands over.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "nearly all are messages")]
pub(crate) enum Taken {
    Message {
        message: TapMessage,
        log_ns: u64,
    },
    Status {
        json: String,
        log_ns: u64,
    },
    Lost {
        messages: u64,
    },
    /// The time, and messages that wait, if that is news.
    Flush {
        heartbeat: Option<(u64, u64)>,
    },
    Snapshot,
}

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
            first: 0,
            id: None,
        };
        let target = match &settings.snapshot {
            None => {
                Target::Files(Box::new(Series::create(&settings.output, options, settings.split)?))
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

    pub(crate) fn store(&mut self, taken: Taken) -> Result<(), WriteError> {
        let is_flush = matches!(taken, Taken::Flush { .. });
        match &mut self.target {
            Target::Files(series) => into_files(series, taken)?,
            Target::Memory(ring) => ring.keep(taken)?,
        }
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

    pub(crate) fn finish(self) -> Result<(Summary, u64, u64), WriteError> {
        match self.target {
            Target::Files(series) => series.finish(),
            Target::Memory(ring) => Ok((ring.stored, ring.files, 0)),
        }
    }
}

fn into_files(series: &mut Series, taken: Taken) -> Result<(), WriteError> {
    let written = match taken {
        Taken::Message { message: TapMessage::Request(request), log_ns } => {
            series.write_request(&request, log_ns)
        }
        Taken::Message { message: TapMessage::Reply(part), log_ns } => {
            series.write_reply(&part, log_ns)
        }
        Taken::Status { json, log_ns } => series.write_status(&json, log_ns),
        Taken::Lost { messages } => series.lost(messages),
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
    on: Vec<ErrorCode>,
    kept: VecDeque<(Instant, Taken)>,
    uploads: Uploads,
    /// Whether requests are recorded.
    has_requests: bool,
    /// A refusal asks for a snapshot.
    is_due: bool,
    /// What all snapshots hold, and how many there are.
    stored: Summary,
    files: u64,
    bytes_written: u64,
}

impl Ring {
    fn new(path: &Path, options: Options, snapshot: &Snapshot, has_requests: bool) -> Self {
        Self {
            path: path.to_owned(),
            options,
            time: snapshot.time,
            on: snapshot.on.clone(),
            kept: VecDeque::new(),
            uploads: Uploads::default(),
            has_requests,
            is_due: false,
            stored: Summary::default(),
            files: 0,
            bytes_written: 0,
        }
    }

    fn summary(&self) -> Summary {
        self.stored
    }

    fn keep(&mut self, taken: Taken) -> Result<(), WriteError> {
        let now = Instant::now();
        while self.kept.front().is_some_and(|(when, _)| now - *when > self.time) {
            self.kept.pop_front();
        }
        match taken {
            Taken::Snapshot => return self.write(),
            Taken::Flush { .. } => {
                // At a flush, so that several refusals at once are one snapshot.
                return if std::mem::take(&mut self.is_due) { self.write() } else { Ok(()) };
            }
            Taken::Message { message: TapMessage::Reply(ref part), .. } => {
                let refusal = part.content.as_ref().err();
                self.is_due |= refusal.is_some_and(|refusal| self.on.contains(&refusal.code));
            }
            Taken::Message { message: TapMessage::Request(ref request), .. } => {
                self.uploads.note(request);
            }
            Taken::Status { .. } | Taken::Lost { .. } => {}
        }
        self.kept.push_back((now, taken));
        Ok(())
    }

    /// Writes what is kept into a file of its own.
    fn write(&mut self) -> Result<(), WriteError> {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let end = self.path.extension().unwrap_or("mcap".as_ref()).to_string_lossy();
        let path = self.path.with_file_name(format!("{stem}-{:04}.{end}", self.files));
        let mut series = Series::create(&path, self.options.clone(), Split::default())?;
        series.know(self.uploads.clone());
        let mut asked = BTreeSet::new();
        for (_, taken) in self.kept.drain(..) {
            match &taken {
                Taken::Message { message: TapMessage::Request(request), .. } => {
                    asked.insert(request.key);
                }
                // Its request came before the time that is kept.
                Taken::Message { message: TapMessage::Reply(part), .. }
                    if self.has_requests && !asked.contains(&part.key) =>
                {
                    continue;
                }
                _ => {}
            }
            into_files(&mut series, taken)?;
        }
        self.bytes_written += series.written();
        let (summary, ..) = series.finish()?;
        self.stored = self.stored.plus(summary);
        self.files += 1;
        tracing::info!(output = %path.display(), messages = summary.recorded, "snapshot");
        Ok(())
    }
}
