//! Where the sequencer and the threads that plan meet: the queue, the turns, and the parts that wait to
//! be sent, under one lock.
//!
//! With the feature `loom` its locks are those of a model checker, which goes through the orders in which
//! threads can meet here (`desk/model.rs`).

use std::cell::Cell;
use std::time::{Duration, Instant};

use answer::{StopFlag, StopReason};
#[cfg(feature = "loom")]
use loom::sync::{Condvar, Mutex, MutexGuard};
use std::sync::PoisonError;
#[cfg(not(feature = "loom"))]
use std::sync::{Condvar, Mutex, MutexGuard};

use crate::queue::{Job, Queue, QueueLimits, Waiting};
use crate::turns::{Place, Turns};

/// How long a request has its turn while others wait for one.
pub(crate) const SLICE: Duration = Duration::from_millis(5);

#[derive(Debug)]
pub(crate) struct Desk {
    state: Mutex<State>,
    /// There is a request to plan, or none will come any more.
    work: Condvar,
    /// Somebody's turn has come, or a request is stopped, or there is room for parts.
    turn: Condvar,
    limits: QueueLimits,
}

#[derive(Debug)]
struct State {
    queue: Queue,
    turns: Turns,
    /// Bytes of parts that no client has taken yet.
    unsent: usize,
    planning: usize,
    ended: bool,
}

/// What the threads are doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Load {
    pub(crate) waiting: Waiting,
    pub(crate) planning: usize,
    pub(crate) unsent: usize,
}

impl Desk {
    /// For threads of which `count` plan at a time.
    pub(crate) fn new(count: usize, limits: QueueLimits) -> Self {
        Self {
            state: Mutex::new(State {
                queue: Queue::default(),
                turns: Turns::new(count),
                unsent: 0,
                planning: 0,
                ended: false,
            }),
            work: Condvar::new(),
            turn: Condvar::new(),
            limits,
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // Nothing that is done under the lock panics half way.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives a request to the next of `threads` that is free, or gives it back with what waits already,
    /// if that is too much. A request whose reply has begun is always taken.
    pub(crate) fn add(&self, job: Job, threads: usize) -> Result<(), (Job, Waiting)> {
        let mut state = self.lock();
        let bytes = size_of_val(job.cells.as_slice());
        // What a free thread is about to take does not wait.
        let free = threads.saturating_sub(state.planning);
        let QueueLimits { requests, bytes: most } = self.limits;
        let limits = QueueLimits { requests: requests + free, bytes: most };
        if job.written == 0 && !state.queue.has_room(bytes, limits) {
            return Err((job, state.queue.waiting()));
        }
        state.queue.push(job);
        drop(state);
        self.work.notify_one();
        Ok(())
    }

    /// Stops a request, whether it waits or is planned. Returns it if it had not begun.
    pub(crate) fn stop(&self, ticket: u64, stop: &StopFlag, reason: StopReason) -> Option<Job> {
        stop.stop(reason);
        let waited = self.lock().queue.remove(ticket);
        self.turn.notify_all();
        waited
    }

    /// So many bytes of parts are gone.
    pub(crate) fn free(&self, bytes: usize) {
        if bytes > 0 {
            let mut state = self.lock();
            let was_full = state.unsent > self.limits.bytes;
            state.unsent = state.unsent.saturating_sub(bytes);
            drop(state);
            if was_full {
                self.turn.notify_all();
            }
        }
    }

    pub(crate) fn load(&self) -> Load {
        let state = self.lock();
        let State { queue, unsent, planning, .. } = &*state;
        Load { waiting: queue.waiting(), planning: *planning, unsent: *unsent }
    }

    /// No requests will come any more.
    pub(crate) fn end(&self) {
        self.lock().ended = true;
        self.work.notify_all();
        self.turn.notify_all();
    }

    /// The next request, or none any more.
    pub(crate) fn next(&self) -> Option<Job> {
        let mut state = self.lock();
        loop {
            if state.ended {
                return None;
            }
            if let Some(job) = state.queue.pop() {
                state.planning += 1;
                return Some(job);
            }
            state = self.work.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// A request is planned no longer.
    pub(crate) fn done(&self) {
        self.lock().planning -= 1;
    }
}

/// A request's turn to be planned.
pub(crate) struct Turn<'a> {
    desk: &'a Desk,
    stop: &'a StopFlag,
    since: Cell<Instant>,
    /// A request that is stopped goes on without one: it ends at once.
    has_one: Cell<bool>,
}

impl<'a> Turn<'a> {
    /// Waits for a turn.
    pub(crate) fn take(desk: &'a Desk, stop: &'a StopFlag) -> Self {
        let turn = Self { desk, stop, since: Cell::new(Instant::now()), has_one: Cell::new(false) };
        turn.line_up(desk.lock(), Turns::ask);
        turn
    }

    /// Lets others have their turn, if it is time to.
    pub(crate) fn share(&self, now: Instant) {
        if self.has_one.get() && now.duration_since(self.since.get()) >= SLICE {
            self.line_up(self.desk.lock(), Turns::pass_on);
        }
    }

    fn line_up(
        &self,
        mut state: MutexGuard<'_, State>,
        ask: impl FnOnce(&mut Turns) -> Option<Place>,
    ) {
        self.has_one.set(true);
        if let Some(place) = ask(&mut state.turns) {
            // Whoever is first in the line may have got a turn.
            self.desk.turn.notify_all();
            while state.turns.waits(place) && self.stop.reason().is_none() {
                state = self.desk.turn.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
            self.has_one.set(!state.turns.leave(place));
        }
        self.since.set(Instant::now());
    }

    fn give_back(&self) {
        if self.has_one.take() {
            self.desk.lock().turns.give_back();
            self.desk.turn.notify_all();
        }
    }

    /// Counts the bytes of a part, and waits while too many parts lie about; without a turn
    /// meanwhile.
    pub(crate) fn make_room(&self, bytes: usize) {
        let mut state = self.desk.lock();
        state.unsent += bytes;
        if state.unsent <= self.desk.limits.bytes {
            return;
        }
        drop(state);
        self.give_back();
        let mut state = self.desk.lock();
        // One reply alone can be larger than the bound.
        while state.unsent > self.desk.limits.bytes.max(bytes) && self.stop.reason().is_none() {
            state = self.desk.turn.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        self.line_up(state, Turns::ask);
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        self.give_back();
    }
}

#[cfg(all(test, feature = "loom"))]
mod model;
