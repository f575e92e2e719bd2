//! Taking messages from the tap.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use bus::{ConnectError, StatusReader, TapEvent, TapMessage, TapReader};
use recording::{Finished, WriteError};

use crate::describe::describe;
use crate::progress::{Progress, Written};
use crate::settings::Settings;
use crate::store::{Store, Taken};

/// How long the recorder sleeps when there is nothing to record. The tap's buffer holds far
/// more messages than arrive meanwhile.
const IDLE: Duration = Duration::from_millis(1);

/// Messages that wait to be written, at most; what comes then stays in the tap.
const QUEUE: usize = 1024;

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
    let (sender, receiver) = sync_channel(QUEUE);
    let storing = std::thread::Builder::new().name("store".into()).spawn(move || {
        for taken in receiver {
            store.store(taken)?;
        }
        store.finish()
    })?;
    let mut taker = Taker {
        settings,
        tap,
        status,
        sender: Some(sender),
        storing,
        requested,
        progress: Progress::new(&settings.output),
        written,
        recorded: 0,
        lost: 0,
        sampled_ns: 0,
        seen: None,
        is_told: false,
    };
    if let Some(about) = about {
        taker.send(Taken::Status { json: about, log_ns: bus::now_ns() });
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
    /// None once the writing thread has ended, which it does by itself only if it failed.
    sender: Option<SyncSender<Taken>>,
    storing: JoinHandle<Result<Finished, WriteError>>,
    /// Whether a signal asks for a snapshot.
    requested: Arc<AtomicBool>,
    progress: Progress,
    written: Arc<Written>,
    recorded: u64,
    lost: u64,
    /// When the recorder last looked how far the planner is, while messages came.
    sampled_ns: u64,
    /// When the planner was last seen; none before the first look.
    seen: Option<Instant>,
    is_told: bool,
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
            while let Some(event) = self.tap.receive() {
                idle = false;
                self.take(event);
                let is_enough =
                    self.settings.max_messages.is_some_and(|most| self.recorded >= most);
                if is_enough || flushed.elapsed() >= self.settings.flush {
                    break;
                }
            }
            if flushed.elapsed() >= self.settings.flush || stop.is_some() && idle {
                // First: what is sent meanwhile counts.
                let time_ns = bus::now_ns();
                let waiting = self.tap.waiting();
                let now = (self.recorded + self.lost, waiting);
                let is_news = beaten.is_none_or(|(at, before)| {
                    at.elapsed() >= EVERY || before != now.0 || waiting > 0
                });
                let heartbeat = is_news.then_some((time_ns, waiting));
                beaten = if is_news { Some((Instant::now(), now.0)) } else { beaten };
                self.send(Taken::Flush { heartbeat });
                flushed = Instant::now();
            }
            while let Some(json) = self.status.as_ref().and_then(StatusReader::receive) {
                self.send(Taken::Status { json, log_ns: bus::now_ns() });
            }
            if self.requested.swap(false, Ordering::Relaxed) {
                self.send(Taken::Snapshot);
            }
            self.progress.show(&self.written);
            if self.sender.is_none() {
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
        let is_enough = self.settings.max_messages.is_some_and(|most| self.recorded >= most);
        if !is_enough {
            self.wait_for_last();
        }
        self.progress.clear();
        drop(self.sender.take());
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
        let is_enough = self.settings.max_messages.is_some_and(|most| self.recorded >= most);
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

    fn take(&mut self, event: TapEvent) {
        let log_ns = bus::now_ns();
        let topics = self.settings.topics;
        match event {
            TapEvent::Message(TapMessage::Request(_)) if !topics.requests => {}
            TapEvent::Message(TapMessage::Reply(_)) if !topics.replies => {}
            TapEvent::Message(message) => {
                self.recorded += 1;
                let is_due = log_ns.saturating_sub(self.sampled_ns) >= SAMPLE_NS;
                let waiting = is_due.then(|| self.tap.waiting());
                self.sampled_ns = if is_due { log_ns } else { self.sampled_ns };
                self.send(Taken::Message { message, log_ns, waiting });
            }
            TapEvent::FreeSpace(request) => self.send(Taken::FreeSpace { request }),
            TapEvent::Lost { messages } => {
                tracing::warn!(messages, "messages lost: they came too fast");
                self.lost += messages;
                self.send(Taken::Lost { messages });
            }
            TapEvent::Restarted => tracing::warn!("the planner was restarted"),
        }
    }

    /// Hands it to the writing thread. While that is behind, the tap keeps what comes.
    fn send(&mut self, taken: Taken) {
        if self.sender.as_ref().is_some_and(|sender| sender.send(taken).is_err()) {
            self.sender = None;
        }
    }

    /// What the planner has counted and not delivered by the end is lost.
    fn wait_for_last(&mut self) {
        let until = Instant::now() + LAST;
        let last = self.tap.announced();
        loop {
            while self.tap.place() < last
                && let Some(event) = self.tap.receive()
            {
                self.take(event);
            }
            let waiting = last.saturating_sub(self.tap.place());
            if waiting == 0 {
                return;
            }
            if Instant::now() >= until {
                tracing::warn!(messages = waiting, "messages lost: they did not come");
                return self.send(Taken::Lost { messages: waiting });
            }
            std::thread::sleep(IDLE);
        }
    }
}
