//! A recording in one file or several.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use schemas::message::{Digest, ErrorCode, ReplyPart, Request, RequestKey};

use crate::options::Options;
use crate::summary::Summary;
use crate::uploads::{Lack, Uploads};
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

/// Key in the description of the requests in files before whose replies go on in this one.
pub const CONTINUES_KEY: &str = "continues";

/// Key in the description of the topics that are recorded, if others are left out.
pub const TOPICS_KEY: &str = "topics";

/// Key at the end of the requests whose replies go on in files after this one.
pub const CONTINUED_KEY: &str = "continued";

/// Key at the end of the names of free spaces that a file's requests have and that nobody could
/// tell: these requests can't be planned again.
const MISSING_KEY: &str = "missing_free_spaces";

/// Requests without a whole reply that are remembered, at most: many times what a planner takes.
/// Those whose clients died never get one.
const MOST_OPEN: usize = 4096;

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
    /// Requests whose reply is not whole yet; none if replies are not recorded.
    open: BTreeMap<RequestKey, Open>,
    has_replies: bool,
    uploads: Uploads,
    /// The named free spaces that this file has.
    there: BTreeSet<Digest>,
    /// Those that its requests name and that are not known; and those of all files.
    missing: BTreeSet<Digest>,
    all_missing: BTreeSet<Digest>,
    /// What the finished files hold.
    before: Summary,
    bytes_before: u64,
}

/// A request whose reply is not whole yet.
struct Open {
    /// The number of its file.
    file: u64,
    /// The free space that it names, if that is not known here; perhaps nobody knows it.
    lacks: Option<Digest>,
}

/// What is to be known of a part of a reply that is encoded already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartHead {
    /// See [`ReplyPart::key`].
    pub key: RequestKey,
    /// See [`ReplyPart::sent_ns`].
    pub sent_ns: u64,
    /// See [`ReplyPart::last`].
    pub last: bool,
    /// Why there is no path, if there is none.
    pub refusal: Option<ErrorCode>,
}

impl PartHead {
    /// That of a part.
    pub fn of(part: &ReplyPart) -> Self {
        let ReplyPart { key, sent_ns, last, .. } = *part;
        let refusal = part.content.as_ref().err().map(|refusal| refusal.code);
        Self { key, sent_ns, last, refusal }
    }
}

/// A recording that has ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finished {
    /// What all files hold.
    pub summary: Summary,
    /// How many files there are.
    pub files: u64,
    /// How many of them were removed as the oldest.
    pub removed: u64,
    /// Free spaces that requests name and that the recording does not have.
    pub missing: BTreeSet<Digest>,
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
            open: BTreeMap::new(),
            has_replies: true,
            uploads: Uploads::default(),
            there: BTreeSet::new(),
            missing: BTreeSet::new(),
            all_missing: BTreeSet::new(),
            before: Summary::default(),
            bytes_before: 0,
        };
        series.writer = Some(series.create_file("")?);
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

    /// Begins the file with the present number.
    fn create_file(&self, continues: &str) -> Result<Writer, WriteError> {
        let mut options = self.options.clone();
        if !self.split.is_never() {
            options.description.insert(FILE_KEY.to_owned(), self.index.to_string());
        }
        if !continues.is_empty() {
            options.description.insert(CONTINUES_KEY.to_owned(), continues.to_owned());
        }
        Writer::create(self.file(self.index), options)
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
        // Those of files before may have lost their client.
        let is_quiet = || self.open.values().all(|open| open.file < self.index);
        if writer.summary().recorded == 0 || !(is_over(0) || is_over(1) && is_quiet()) {
            return Ok(());
        }
        let open = self.open.keys().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        self.options.first = writer.sequence();
        self.index += 1;
        // Before the last one is finished: a recorder that is killed leaves a file that shows it.
        let next = self.create_file(&open);
        self.end(self.index - 1, &open)?;
        self.writer = Some(next?);
        self.begun = Instant::now();
        self.there.clear();
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
        Ok(())
    }

    /// Finishes a file; the replies to the requests in `continued` go on in the next.
    fn end(&mut self, index: u64, continued: &str) -> Result<(), WriteError> {
        let Some(mut writer) = self.writer.take() else { return Ok(()) };
        if !continued.is_empty() {
            writer.note_at_end(CONTINUED_KEY, continued.to_owned());
        }
        if !self.missing.is_empty() {
            let names = self.missing.iter().map(ToString::to_string).collect::<Vec<_>>();
            writer.note_at_end(MISSING_KEY, names.join(" "));
            self.all_missing.append(&mut self.missing);
        }
        self.bytes_before += writer.written();
        self.before = self.before.plus(writer.finish()?);
        self.files.push_back(self.file(index));
        Ok(())
    }

    fn writer(&mut self) -> Result<&mut Writer, WriteError> {
        self.split()?;
        Ok(self.writer.as_mut().expect("a file is open between its begin and its end"))
    }

    /// No replies come.
    pub fn expect_no_replies(&mut self) {
        self.has_replies = false;
    }

    /// Makes free spaces known that were sent before the recording begins.
    pub fn know(&mut self, uploads: Uploads) {
        self.uploads = uploads;
    }

    /// The same for one, by the request that made it known.
    pub fn know_one(&mut self, upload: &Request) {
        self.uploads.note(upload);
    }

    /// Appends a request; see [`Writer::write_request`]. A file that lacks the free space that the
    /// request names gets it first, if that is known.
    pub fn write_request(&mut self, request: &Request, log_ns: u64) -> Result<(), WriteError> {
        self.split()?;
        let lack = self.uploads.lack(request, &mut self.there);
        let file = self.index;
        let writer = self.writer()?;
        if let Lack::Upload(upload) = &lack {
            writer.write_free_space(upload, log_ns)?;
        }
        writer.write_request(request, log_ns)?;
        let lacks = if let Lack::Unknown(name) = lack { Some(name) } else { None };
        if self.has_replies {
            self.open.insert(request.key, Open { file, lacks });
        }
        if self.open.len() > MOST_OPEN {
            self.open.pop_first();
        }
        Ok(())
    }

    /// Appends a part of a reply; see [`Writer::write_reply`].
    pub fn write_reply(&mut self, part: &ReplyPart, log_ns: u64) -> Result<(), WriteError> {
        self.writer()?.write_reply(part, log_ns)?;
        self.note_reply(&PartHead::of(part));
        Ok(())
    }

    /// The same for one that is encoded already; see [`Writer::write_encoded_reply`].
    pub fn write_encoded_reply(
        &mut self,
        head: &PartHead,
        part: &[u8],
        log_ns: u64,
    ) -> Result<(), WriteError> {
        self.writer()?.write_encoded_reply(head.sent_ns, part, log_ns)?;
        self.note_reply(head);
        Ok(())
    }

    fn note_reply(&mut self, head: &PartHead) {
        let lacks = self.open.get_mut(&head.key).and_then(|open| open.lacks.take());
        // What the planner does not know either is not missing.
        let is_known = head.refusal != Some(ErrorCode::UnknownFreeSpace);
        self.missing.extend(lacks.filter(|_| is_known));
        if head.last {
            self.open.remove(&head.key);
        }
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

    /// Notes that messages are not recorded by wish; see [`Writer::leave_out`].
    pub fn leave_out(&mut self, count: u64) -> Result<(), WriteError> {
        self.writer()?.leave_out(count);
        Ok(())
    }

    /// Notes how far the planner is; see [`Writer::heartbeat`].
    pub fn heartbeat(&mut self, time_ns: u64, waiting: u64) {
        if let Some(writer) = &mut self.writer {
            writer.heartbeat(time_ns, waiting);
            self.options.announced = Some((time_ns, writer.sequence().saturating_add(waiting)));
        }
    }

    /// Notes how far the planner is, and writes everything so far; see [`Writer::heartbeat`] and
    /// [`Writer::flush`].
    pub fn flush(&mut self, heartbeat: Option<(u64, u64)>) -> Result<(), WriteError> {
        self.split()?;
        if let Some((time_ns, waiting)) = heartbeat {
            self.heartbeat(time_ns, waiting);
        }
        self.writer()?.flush()
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

    /// Ends the last file.
    pub fn finish(mut self) -> Result<Finished, WriteError> {
        self.end(self.index, "")?;
        let Self { before: summary, index, removed, all_missing: missing, .. } = self;
        Ok(Finished { summary, files: index + 1, removed, missing })
    }
}
