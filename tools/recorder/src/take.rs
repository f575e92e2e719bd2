//! Taking messages from the tap.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use bus::{ConnectError, StatusReader, TapEvent, TapMessage, TapReader};
use recording::{Finished, WriteError};
use schemas::message::Sample;

use crate::describe::describe;
use crate::progress::{Progress, Written};
use crate::settings::{Settings, Topics};
use crate::store::{Batch, Store, Taken};

/// How long the recorder sleeps when there is nothing to record. The tap's buffer holds far
/// more messages than arrive meanwhile.
const IDLE: Duration = Duration::from_millis(1);

/// Bytes of parts, or messages, at which a batch is handed over.
const BATCH_BYTES: usize = 256 << 10;
const BATCH_MESSAGES: usize = 1024;

/// How long messages wait for others, at most, while none come; nanoseconds.
const BATCH_NS: u64 = 10_000_000;

/// Batches that wait to be written, at most; what comes then stays in the tap.
const QUEUE: usize = 128;

/// How long a planner that ends is given until another takes over, as when a supervisor starts it
/// again.
const TAKE_OVER: Duration = Duration::from_secs(2);

/// How long the planner is given to introduce itself; it says something ten times a second.
const INTRODUCTION: Duration = Duration::from_millis(500);

/// How often the recorder looks whether the planner is there, and says that it is alive.
const EVERY: Duration = Duration::from_secs(1);

/// How often it looks how far the planner is while messages come, nanoseconds.
const SAMPLE_NS: u64 = 1_000_000;

/// How long at the end messages are waited for that the planner has counted and is sending.
const LAST: Duration = Duration::from_millis(50);

/// Why there is no recording, or an incomplete one.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The planner's tap could not be connected to.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A signal can't be waited for, or a thread not started.
    #[error("the system refuses: {0}")]
    System(#[from] std::io::Error),
}

/// Why a recording has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndReason {
    /// A signal came.
    Signal,
    /// All that was asked for is recorded.
    Complete,
    /// The planner is gone.
    NoPlanner,
    /// The disk is nearly full.
    NoSpace {
        /// Bytes free.
        free: u64,
        /// Bytes that are to stay free.
        least: u64,
    },
}

/// A recording that has ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ended {
    /// What it holds; its files are the snapshots, if there are any.
    pub finished: Finished,
    /// Why.
    pub end: EndReason,
}

/// Records until a signal asks to end, or what was asked for is done; then finishes the file.
pub fn run(settings: &Settings) -> Result<Ended, Failure> {
    // Alone in the domain, it leaves nothing behind.
    let tap = connect(settings).inspect_err(|_| settings.domain.tidy())?;
    let status = StatusReader::connect(&settings.domain).ok().filter(|_| settings.topics.statuses);
    // The planner's last status, which has its settings, comes with its next sign of life.
    let about = status.as_ref().and_then(|status| status.wait(INTRODUCTION));
    let requested = Arc::new(AtomicBool::new(false));
    if settings.snapshot.is_some() {
        signal_hook::flag::register(signal_hook::consts::SIGUSR1, Arc::clone(&requested))?;
    }
    let written = Arc::new(Written::default());
    let description = describe(settings, about.as_deref());
    let mut store = Store::create(settings, description, Arc::clone(&written))?;
    tracing::info!(output = %settings.output.display(), "recording");
    let (sender, receiver) = sync_channel::<Batch>(QUEUE);
    let (give_back, empty) = channel();
    let storing = std::thread::Builder::new().name("store".into()).spawn(move || {
        for mut batch in receiver {
            store.store(&mut batch)?;
            // Nobody needs its memory in the end.
            let _ = give_back.send(batch);
        }
        store.finish()
    })?;
    let mut taker = Taker {
        settings,
        tap,
        status,
        out: Out {
            topics: settings.topics,
            batch: Batch::default(),
            begun_ns: 0,
            sender: Some(sender),
            empty,
            recorded: 0,
            lost: 0,
            left_out: 0,
        },
        storing,
        requested,
        progress: Progress::new(&settings.output),
        written,
        sampled_ns: 0,
        seen: None,
        is_told: false,
    };
    if let Some(about) = about {
        taker.out.push(Taken::Status { json: about, log_ns: bus::now_ns() });
    }
    taker.run()
}

fn connect(settings: &Settings) -> Result<TapReader, ConnectError> {
    let until = Instant::now() + settings.wait;
    let mut told = false;
    loop {
        match TapReader::connect(&settings.domain) {
            Err(ConnectError::NoPlanner { .. }) if Instant::now() < until && !bus::terminated() => {
                if !told {
                    tracing::info!(domain = %settings.domain, "waiting for a planner");
                    told = true;
                }
                std::thread::sleep(Duration::from_millis(50));
            }
            done => return done,
        }
    }
}

struct Taker<'a> {
    settings: &'a Settings,
    tap: TapReader,
    status: Option<StatusReader>,
    out: Out,
    storing: JoinHandle<Result<Finished, WriteError>>,
    /// Whether a signal asks for a snapshot.
    requested: Arc<AtomicBool>,
    progress: Progress,
    written: Arc<Written>,
    /// When the recorder last looked how far the planner is, while messages came.
    sampled_ns: u64,
    /// When the planner was last seen; none before the first look.
    seen: Option<Instant>,
    is_told: bool,
}

/// What goes to the writing thread.
struct Out {
    topics: Topics,
    batch: Batch,
    /// When its first message came, nanoseconds since the Unix epoch.
    begun_ns: u64,
    /// None once the writing thread has ended, which it does by itself only if it failed.
    sender: Option<SyncSender<Batch>>,
    /// Batches that it has written.
    empty: Receiver<Batch>,
    recorded: u64,
    lost: u64,
    left_out: u64,
}

impl Out {
    /// Takes in an event, with the samples of a part of a reply. Whether it is a message that is
    /// recorded.
    fn take(&mut self, event: TapEvent, samples: &[Sample], log_ns: u64) -> bool {
        match event {
            TapEvent::Message(TapMessage::Request(_)) if !self.topics.requests => self.leave_out(),
            TapEvent::Message(TapMessage::Reply(_)) if !self.topics.replies => self.leave_out(),
            TapEvent::Message(message) => {
                self.recorded += 1;
                self.begin(log_ns);
                match message {
                    TapMessage::Request(request) => {
                        self.batch.taken.push(Taken::Request { request: request.into(), log_ns });
                    }
                    TapMessage::Reply(part) => self.batch.add_part(&part, samples, log_ns),
                }
                return true;
            }
            TapEvent::FreeSpace(request) => self.push(Taken::FreeSpace { request: request.into() }),
            TapEvent::Lost { messages } => {
                tracing::warn!(messages, "messages lost: they came too fast");
                self.lost += messages;
                self.push(Taken::Lost { messages });
            }
            TapEvent::Restarted => tracing::warn!("the planner was restarted"),
        }
        false
    }

    fn begin(&mut self, now_ns: u64) {
        if self.batch.taken.is_empty() {
            self.begun_ns = now_ns;
        }
    }

    /// A message is not to be recorded.
    fn leave_out(&mut self) {
        self.left_out += 1;
        match self.batch.taken.last_mut() {
            Some(Taken::LeftOut { messages }) => *messages += 1,
            _ => self.push(Taken::LeftOut { messages: 1 }),
        }
    }

    fn push(&mut self, taken: Taken) {
        self.begin(bus::now_ns());
        self.batch.taken.push(taken);
    }

    /// Hands the batch over if it is large enough, or, while nothing comes, old enough.
    fn hand_over_in_time(&mut self, is_idle: bool) {
        let Batch { taken, parts } = &self.batch;
        let is_large = parts.len() >= BATCH_BYTES || taken.len() >= BATCH_MESSAGES;
        let is_old = || bus::now_ns().saturating_sub(self.begun_ns) >= BATCH_NS;
        if is_large || is_idle && !taken.is_empty() && is_old() {
            self.hand_over();
        }
    }

    /// Hands what came to the writing thread. While that is behind, the tap keeps what comes.
    fn hand_over(&mut self) {
        // More than one are left of a time when it was behind.
        let empty = self.empty.try_iter().last().unwrap_or_default();
        let batch = std::mem::replace(&mut self.batch, empty);
        if self.sender.as_ref().is_some_and(|sender| sender.send(batch).is_err()) {
            self.sender = None;
        }
    }
}

impl Taker<'_> {
    fn run(mut self) -> Result<Ended, Failure> {
        let begin = Instant::now();
        let mut flushed = Instant::now();
        let mut looked = Instant::now();
        let mut beaten: Option<(Instant, u64)> = None;
        let end = loop {
            // Asked before receiving, so that messages sent before the signal are recorded.
            let stop = self.is_time(begin);
            let mut idle = true;
            while self.take() {
                idle = false;
                self.out.hand_over_in_time(false);
                let is_enough =
                    self.settings.max_messages.is_some_and(|most| self.out.recorded >= most);
                if is_enough || flushed.elapsed() >= self.settings.flush {
                    break;
                }
            }
            if flushed.elapsed() >= self.settings.flush || stop.is_some() && idle {
                // First: what is sent meanwhile counts.
                let time_ns = bus::now_ns();
                let waiting = self.tap.waiting();
                let now = (self.out.recorded + self.out.lost + self.out.left_out, waiting);
                let is_news = beaten.is_none_or(|(at, before)| {
                    at.elapsed() >= EVERY || before != now.0 || waiting > 0
                });
                let heartbeat = is_news.then_some((time_ns, waiting));
                beaten = if is_news { Some((Instant::now(), now.0)) } else { beaten };
                self.out.push(Taken::Flush { heartbeat });
                self.out.hand_over();
                flushed = Instant::now();
            }
            while let Some(json) = self.status.as_ref().and_then(StatusReader::receive) {
                self.out.push(Taken::Status { json, log_ns: bus::now_ns() });
            }
            if self.requested.swap(false, Ordering::Relaxed) {
                self.out.push(Taken::Snapshot);
                self.out.hand_over();
            }
            self.out.hand_over_in_time(idle);
            self.progress.show(&self.written);
            if self.out.sender.is_none() {
                break EndReason::Complete;
            }
            if looked.elapsed() >= EVERY {
                looked = Instant::now();
                self.look();
            }
            match self.reason(stop) {
                Some(end @ EndReason::Complete) if self.settings.max_messages.is_some() => {
                    break end;
                }
                Some(end) if idle => break end,
                _ if idle => std::thread::sleep(IDLE),
                _ => {}
            }
        };
        let is_enough = self.settings.max_messages.is_some_and(|most| self.out.recorded >= most);
        if !is_enough {
            self.wait_for_last();
        }
        self.progress.clear();
        self.out.hand_over();
        drop(self.out.sender.take());
        let stored = self.storing.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        Ok(Ended { finished: stored?, end })
    }

    /// Whether the time is up, or a signal has come.
    fn is_time(&self, begin: Instant) -> Option<EndReason> {
        if self.tap.terminated() {
            return Some(EndReason::Signal);
        }
        let is_over = self.settings.duration.is_some_and(|most| begin.elapsed() >= most);
        is_over.then_some(EndReason::Complete)
    }

    /// Why to end now, if anything asks to.
    fn reason(&self, stop: Option<EndReason>) -> Option<EndReason> {
        let is_enough = self.settings.max_messages.is_some_and(|most| self.out.recorded >= most);
        if is_enough {
            return Some(EndReason::Complete);
        }
        if self.written.is_full.load(Ordering::Relaxed) {
            let free = self.written.free.load(Ordering::Relaxed);
            return Some(EndReason::NoSpace { free, least: self.settings.min_free.unwrap_or(0) });
        }
        stop.or_else(|| {
            (self.is_told && self.settings.exit_with_planner).then_some(EndReason::NoPlanner)
        })
    }

    /// Looks whether the planner is there, and says so when that changes.
    fn look(&mut self) {
        if self.tap.sees_planner() {
            if self.is_told {
                tracing::info!("a planner is there again");
            }
            (self.seen, self.is_told) = (Some(Instant::now()), false);
        } else if !self.is_told && self.seen.is_none_or(|seen| seen.elapsed() >= TAKE_OVER) {
            tracing::warn!(domain = %self.settings.domain, "the planner is gone");
            self.is_told = true;
        }
    }

    /// Takes what comes next, if anything does.
    fn take(&mut self) -> bool {
        let (tap, out) = (&mut self.tap, &mut self.out);
        let taken = tap.receive_in_place(|event, samples| {
            let log_ns = bus::now_ns();
            out.take(event, samples, log_ns).then_some(log_ns)
        });
        let Some(recorded) = taken else { return false };
        if let Some(time_ns) = recorded
            && time_ns.saturating_sub(self.sampled_ns) >= SAMPLE_NS
        {
            self.sampled_ns = time_ns;
            self.out.push(Taken::Heartbeat { time_ns, waiting: self.tap.waiting() });
        }
        true
    }

    /// What the planner has counted and not delivered by the end is lost.
    fn wait_for_last(&mut self) {
        let until = Instant::now() + LAST;
        let last = self.tap.announced();
        loop {
            while self.tap.place() < last && self.take() {
                self.out.hand_over_in_time(false);
            }
            let waiting = last.saturating_sub(self.tap.place());
            if waiting == 0 {
                return;
            }
            if Instant::now() >= until {
                tracing::warn!(messages = waiting, "messages lost: they did not come");
                return self.out.push(Taken::Lost { messages: waiting });
            }
            std::thread::sleep(IDLE);
        }
    }
}
