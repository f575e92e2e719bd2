//! Requests as futures, for any executor.

use std::os::fd::{BorrowedFd, OwnedFd, RawFd};
use std::pin::Pin;
use std::sync::{Mutex, OnceLock, PoisonError};
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};

use bus::CallError;
use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec, eventfd};

use crate::client::Client;
use crate::error::Error;
use crate::pending::Pending;
use crate::reply::Reply;
use crate::scene::Scene;

/// A request being answered, as a future. Dropping it cancels the request.
#[derive(Debug)]
#[must_use = "it is cancelled if it is dropped"]
pub struct Planning {
    /// None once it is done.
    pending: Option<Result<Pending, Error>>,
    begin: Instant,
    limit: Duration,
}

impl Client {
    /// Plans a scene, as [`Client::plan`] does. The request is sent at once.
    ///
    /// One thread, shared by all, watches the bells of those who wait, and wakes their tasks; no
    /// particular executor is needed.
    pub fn plan_async(&self, scene: &Scene, limit: Duration) -> Planning {
        Planning { pending: Some(self.start(scene)), begin: Instant::now(), limit }
    }
}

impl Future for Planning {
    type Output = Result<Reply, Error>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let Self { begin, limit, .. } = *self;
        let mut pending = match self.pending.take().expect("it is not done") {
            Ok(pending) => pending,
            Err(error) => return Poll::Ready(Err(error)),
        };
        pending.silence();
        match pending.poll() {
            Ok(Some(reply)) => return Poll::Ready(Ok(reply)),
            Err(error) => return Poll::Ready(Err(error)),
            Ok(None) => {}
        }
        let now = Instant::now();
        let until = begin + limit;
        if now >= until {
            return Poll::Ready(Err(CallError::TimedOut { waited: now - begin, limit }.into()));
        }
        match pending.bell() {
            Some(bell) => Watcher::get().watch(Watched {
                bell,
                until: until.min(now + Pending::NET),
                waker: context.waker().clone(),
            }),
            None => context.waker().wake_by_ref(),
        }
        self.pending = Some(Ok(pending));
        Poll::Pending
    }
}

/// Watches bells in a thread of its own.
#[derive(Debug)]
struct Watcher {
    new: Mutex<Vec<Watched>>,
    /// Can be read when something new is to be watched.
    doorbell: OwnedFd,
}

/// A task to be woken when a bell rings, or at a time.
#[derive(Debug)]
struct Watched {
    /// If its request was dropped meanwhile, it may be closed or another file's: the task, if it is
    /// still there, is woken in vain.
    bell: RawFd,
    until: Instant,
    waker: Waker,
}

impl Watcher {
    fn get() -> &'static Self {
        static WATCHER: OnceLock<Watcher> = OnceLock::new();
        static STARTED: OnceLock<()> = OnceLock::new();
        let watcher = WATCHER.get_or_init(|| Self {
            new: Mutex::default(),
            doorbell: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)
                .expect("the system has room for a file descriptor"),
        });
        STARTED.get_or_init(|| {
            let name = "clearway".to_owned();
            let thread = std::thread::Builder::new().name(name).spawn(|| watcher.run());
            thread.expect("the system has room for a thread");
        });
        watcher
    }

    fn watch(&self, watched: Watched) {
        self.new.lock().unwrap_or_else(PoisonError::into_inner).push(watched);
        // A counter at its end can be read as well.
        let _ = rustix::io::write(&self.doorbell, &1u64.to_ne_bytes());
    }

    fn run(&self) {
        let mut all: Vec<Watched> = Vec::new();
        loop {
            all.append(&mut self.new.lock().unwrap_or_else(PoisonError::into_inner));
            let now = Instant::now();
            let first = all.iter().map(|watched| watched.until).min();
            let most = first.map(|first| first.saturating_duration_since(now));
            let most = most.and_then(|most| Timespec::try_from(most).ok());
            let bells = all.iter().map(|watched| {
                #[expect(unsafe_code, reason = "the owner may close it meanwhile, see `Watched`")]
                // SAFETY: it is only polled, which on a closed descriptor is an event, no access.
                let bell = unsafe { BorrowedFd::borrow_raw(watched.bell) };
                PollFd::from_borrowed_fd(bell, PollFlags::IN)
            });
            let doorbell = PollFd::new(&self.doorbell, PollFlags::IN);
            let mut polled: Vec<_> = std::iter::once(doorbell).chain(bells).collect();
            // Interrupted or not, what rang or is due is woken.
            let _ = rustix::event::poll(&mut polled, most.as_ref());
            let rang: Vec<_> = polled.iter().map(|bell| !bell.revents().is_empty()).collect();
            drop(polled);
            if rang[0] {
                let _ = rustix::io::read(&self.doorbell, &mut [0; 8]);
            }
            let now = Instant::now();
            let mut rang = rang.into_iter().skip(1);
            all.retain(|watched| {
                let is_due = rang.next().unwrap_or(false) || watched.until <= now;
                if is_due {
                    watched.waker.wake_by_ref();
                }
                !is_due
            });
        }
    }
}
