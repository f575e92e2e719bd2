//! A recording in one file or several.

use std::collections::{BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use schemas::message::{Digest, ReplyPart, Request, RequestKey};

use crate::options::Options;
use crate::summary::Summary;
use crate::uploads::Uploads;
use crate::write::{Writer, random};
use crate::write_error::WriteError;

/// When a new file begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Split {
    /// At this size, bytes.
    pub bytes: Option<u64>,
    /// After this time.
    pub time: Option<Duration>,
    /// The most files kept; the oldest are removed.
    pub files: Option<usize>,
}

impl Split {
    /// Whether there is one file only.
    pub fn is_never(self) -> bool {
        self.bytes.is_none() && self.time.is_none()
    }
}

/// Key in the description of the random number that all files of a split recording have.
pub const SERIES_KEY: &str = "series";

/// Key in the description of a file's place among them, from 0.
pub const FILE_KEY: &str = "file";

/// How much longer than asked a file gets, at most, until no request is open: one part in this
/// many.
const PATIENCE: u64 = 10;

/// Writes a recording in one file, or in several that go on counting: `NAME-0000.mcap`,
/// `NAME-0001.mcap` and so on, each readable alone.
///
/// A file ends where no request waits for its reply, if there is such a moment within the last
/// tenth of it.
pub struct Series {
    path: PathBuf,
    options: Options,
    split: Split,
    /// None between two files.
    writer: Option<Writer>,
    begun: Instant,
    /// Counts files.
    index: u64,
    /// Finished files, the oldest first.
    files: VecDeque<PathBuf>,
    removed: u64,
    /// Requests whose reply is not whole yet.
    open: BTreeSet<RequestKey>,
    uploads: Uploads,
    /// The named free spaces that this file has.
    there: BTreeSet<Digest>,
    /// What the finished files hold.
    before: Summary,
    bytes_before: u64,
}

impl Series {
    /// Begins with the first file.
    pub fn create(path: &Path, options: Options, split: Split) -> Result<Self, WriteError> {
        let mut options = options;
        if !split.is_never() {
            let number = random().map_err(|error| std::io::Error::other(error.to_string()))?;
            options.description.insert(SERIES_KEY.to_owned(), format!("{number:032x}"));
        }
        let mut series = Self {
            path: path.to_owned(),
            options,
            split,
            writer: None,
            begun: Instant::now(),
            index: 0,
            files: VecDeque::new(),
            removed: 0,
            open: BTreeSet::new(),
            uploads: Uploads::default(),
            there: BTreeSet::new(),
            before: Summary::default(),
            bytes_before: 0,
        };
        series.begin()?;
        Ok(series)
    }

    /// Where the file with this number is.
    fn file(&self, index: u64) -> PathBuf {
        if self.split.is_never() {
            return self.path.clone();
        }
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let end = self.path.extension().unwrap_or("mcap".as_ref()).to_string_lossy();
        self.path.with_file_name(format!("{stem}-{index:04}.{end}"))
    }

    fn begin(&mut self) -> Result<&mut Writer, WriteError> {
        let mut options = self.options.clone();
        if !self.split.is_never() {
            options.description.insert(FILE_KEY.to_owned(), self.index.to_string());
        }
        let writer = Writer::create(self.file(self.index), options)?;
        self.begun = Instant::now();
        self.there.clear();
        Ok(self.writer.insert(writer))
    }

    /// Ends the file if it is time to.
    fn split(&mut self) -> Result<(), WriteError> {
        let Some(writer) = &self.writer else { return Ok(()) };
        let is_over = |more: u64| {
            let bytes = self.split.bytes.is_some_and(|most| {
                writer.written() + writer.unwritten() >= most.saturating_sub(most / PATIENCE * more)
            });
            let time = self.split.time.is_some_and(|most| {
                self.begun.elapsed() >= most.saturating_sub(most / PATIENCE as u32 * more as u32)
            });
            bytes || time
        };
        if writer.summary().recorded == 0 || !(is_over(0) || self.open.is_empty() && is_over(1)) {
            return Ok(());
        }
        self.end()?;
        self.open.clear();
        self.index += 1;
        let most = self.split.files.unwrap_or(usize::MAX).max(1);
        // The one that begins now counts.
        while self.files.len() >= most {
            let oldest = self.files.pop_front().expect("there is one");
            if let Err(error) = std::fs::remove_file(&oldest)
                && error.kind() != std::io::ErrorKind::NotFound
            {
                return Err(error.into());
            }
            self.removed += 1;
        }
        self.begin().map(drop)
    }

    fn end(&mut self) -> Result<(), WriteError> {
        let Some(writer) = self.writer.take() else { return Ok(()) };
        self.options.first = writer.sequence();
        self.bytes_before += writer.written();
        self.before = self.before.plus(writer.finish()?);
        self.files.push_back(self.file(self.index));
        Ok(())
    }

    fn writer(&mut self) -> Result<&mut Writer, WriteError> {
        self.split()?;
        Ok(self.writer.as_mut().expect("a file is open between its begin and its end"))
    }

    /// Makes free spaces known that were sent before the recording begins.
    pub fn know(&mut self, uploads: Uploads) {
        self.uploads = uploads;
    }

    /// Appends a request; see [`Writer::write_request`]. A file that lacks the free space that the
    /// request names gets it first, if it was recorded before.
    pub fn write_request(&mut self, request: &Request, log_ns: u64) -> Result<(), WriteError> {
        self.split()?;
        self.uploads.note(request);
        let missing = self.uploads.missing(request, &mut self.there);
        let writer = self.writer()?;
        if let Some(upload) = missing {
            writer.write_free_space(&upload, log_ns)?;
        }
        writer.write_request(request, log_ns)?;
        self.open.insert(request.key);
        Ok(())
    }

    /// Appends a part of a reply; see [`Writer::write_reply`].
    pub fn write_reply(&mut self, part: &ReplyPart, log_ns: u64) -> Result<(), WriteError> {
        self.writer()?.write_reply(part, log_ns)?;
        if part.last {
            self.open.remove(&part.key);
        }
        Ok(())
    }

    /// Appends what a planner says of itself; see [`Writer::write_status`].
    pub fn write_status(&mut self, json: &str, log_ns: u64) -> Result<(), WriteError> {
        self.writer()?.write_status(json, log_ns)
    }

    /// Notes that messages are missing here; see [`Writer::lost`].
    pub fn lost(&mut self, count: u64) -> Result<(), WriteError> {
        // Their requests may never be answered here.
        self.open.clear();
        self.writer()?.lost(count);
        Ok(())
    }

    /// Notes how far the planner is, and writes everything so far; see [`Writer::heartbeat`] and
    /// [`Writer::flush`].
    pub fn flush(&mut self, heartbeat: Option<(u64, u64)>) -> Result<(), WriteError> {
        let writer = self.writer()?;
        if let Some((time_ns, waiting)) = heartbeat {
            writer.heartbeat(time_ns, waiting);
        }
        writer.flush()
    }

    /// What all files hold so far.
    pub fn summary(&self) -> Summary {
        let now = self.writer.as_ref().map_or(Summary::default(), Writer::summary);
        self.before.plus(now)
    }

    /// Bytes of all files so far.
    pub fn written(&self) -> u64 {
        self.bytes_before + self.writer.as_ref().map_or(0, Writer::written)
    }

    /// Ends the last file. How many files there are, and how many were removed as the oldest.
    pub fn finish(mut self) -> Result<(Summary, u64, u64), WriteError> {
        self.end()?;
        Ok((self.before, self.index + 1, self.removed))
    }
}
