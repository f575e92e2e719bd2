//! Threads that plan.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use answer::{Caps, StopFlag, StopReason, Store, Workspace};
use bus::Waker;
use schemas::convert::{CellWriter, PartSink};
use schemas::message::{ErrorCode, Refusal};
use schemas::wire::ReplyHeader;

use crate::queue::{Job, Queue, QueueLimits, Waiting};
use crate::resume::{Resumed, stop_after};
use crate::turns::Turns;

/// How long a request has its turn while others wait for one.
const SLICE: Duration = Duration::from_millis(5);

/// How many requests share a worker, taking turns; further ones wait until one of them is done.
pub(crate) const SHARING: usize = 4;

/// How long threads have to end; what still runs then ends with the process.
const LEAVE: Duration = Duration::from_millis(500);

/// What a worker tells.
#[derive(Debug)]
pub(crate) struct Told {
    pub(crate) ticket: u64,
    pub(crate) what: Outcome,
}

#[derive(Debug)]
pub(crate) enum Outcome {
    /// The request is being planned.
    Begun,
    /// A part of the reply.
    Part(Box<ReplyHeader>, Vec<u64>),
    /// There are no more parts.
    Done,
}

/// A fixed number of threads, and the requests that wait for one.
#[derive(Debug)]
pub(crate) struct Workers {
    shared: Arc<Shared>,
    told: Receiver<Told>,
    threads: Vec<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
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

impl Workers {
    /// Starts threads that plan `count` requests at a time. They wake the server when they have
    /// something to tell.
    pub(crate) fn start(
        count: usize,
        limits: QueueLimits,
        (caps, store): (Caps, &Store),
        waker: &Waker,
    ) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
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
        });
        let (tell, told) = channel();
        let mut workers = Self { shared, told, threads: Vec::new() };
        for number in 0..count * SHARING {
            let shared = Arc::clone(&workers.shared);
            let teller = Teller { tell: tell.clone(), waker: waker.clone() };
            let store = store.clone();
            let run = move || shared.run(caps, &store, &teller);
            let thread = thread::Builder::new().name(format!("worker {number}"));
            workers.threads.push(thread.spawn(run)?);
        }
        Ok(workers)
    }

    /// Gives a request to the next thread that is free, or gives it back with what waits already,
    /// if that is too much. A request whose reply has begun is always taken.
    pub(crate) fn add(&self, job: Job) -> Result<(), (Job, Waiting)> {
        let mut state = self.shared.lock();
        let bytes = size_of_val(job.cells.as_slice());
        // What a free thread is about to take does not wait.
        let free = self.threads.len().saturating_sub(state.planning);
        let QueueLimits { requests, bytes: most } = self.shared.limits;
        let limits = QueueLimits { requests: requests + free, bytes: most };
        if job.written == 0 && !state.queue.has_room(bytes, limits) {
            return Err((job, state.queue.waiting()));
        }
        state.queue.push(job);
        drop(state);
        self.shared.work.notify_one();
        Ok(())
    }

    /// Stops a request, whether it waits or is planned. Returns it if it had not begun.
    pub(crate) fn stop(&self, ticket: u64, stop: &StopFlag, reason: StopReason) -> Option<Job> {
        stop.stop(reason);
        let waited = self.shared.lock().queue.remove(ticket);
        self.shared.turn.notify_all();
        waited
    }

    /// What a thread has to tell, if any has.
    pub(crate) fn told(&self) -> Option<Told> {
        self.told.try_recv().ok()
    }

    /// So many bytes of parts are gone.
    pub(crate) fn free(&self, bytes: usize) {
        if bytes > 0 {
            let mut state = self.shared.lock();
            let was_full = state.unsent > self.shared.limits.bytes;
            state.unsent = state.unsent.saturating_sub(bytes);
            drop(state);
            if was_full {
                self.shared.turn.notify_all();
            }
        }
    }

    pub(crate) fn load(&self) -> Load {
        let state = self.shared.lock();
        let State { queue, unsent, planning, .. } = &*state;
        Load { waiting: queue.waiting(), planning: *planning, unsent: *unsent }
    }
}

impl Drop for Workers {
    fn drop(&mut self) {
        self.shared.lock().ended = true;
        self.shared.work.notify_all();
        self.shared.turn.notify_all();
        let until = Instant::now() + LEAVE;
        while Instant::now() < until && self.threads.iter().any(|thread| !thread.is_finished()) {
            thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // Nothing that is done under the lock panics half way.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self, caps: Caps, store: &Store, teller: &Teller) {
        let mut workspace = Workspace::sharing(caps, store);
        while let Some(job) = self.next() {
            teller.tell(job.ticket, Outcome::Begun);
            let turn = Turn::take(self, &job.stop);
            let answered = catch_unwind(AssertUnwindSafe(|| {
                answer(&mut workspace, &job, &turn, teller);
            }));
            if answered.is_err() {
                // A defect in planning must not take the service with it.
                workspace = Workspace::sharing(caps, store);
                let mut sink = Parts { job: &job, turn: &turn, teller };
                let (Ok(()) | Err(Unwanted)) =
                    Workspace::refuse(&job.header, &internal_error(), &mut sink);
            }
            drop(turn);
            self.lock().planning -= 1;
            teller.tell(job.ticket, Outcome::Done);
        }
    }

    /// The next request, or none any more.
    fn next(&self) -> Option<Job> {
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
}

fn answer(workspace: &mut Workspace, job: &Job, turn: &Turn<'_>, teller: &Teller) {
    let (stop, left) = (StopFlag::new(), Cell::new(job.written));
    let meanwhile = || {
        let now = Instant::now();
        if job.deadline.is_some_and(|deadline| now >= deadline) {
            job.stop.stop(StopReason::Deadline);
        }
        let reason = job.stop.reason();
        if !reason.is_some_and(|reason| stop_after(&left, reason, &stop)) {
            turn.share(now);
        }
    };
    meanwhile();
    let mut sink = Resumed { sink: Parts { job, turn, teller }, left: &left };
    let (Ok(()) | Err(Unwanted)) =
        workspace.answer_while(&job.header, &job.cells, (&stop, &meanwhile), &mut sink);
}

pub(crate) fn internal_error() -> Refusal {
    let message = "internal error while planning this request; please report it (other requests \
                   are served)";
    Refusal::new(ErrorCode::Internal, message)
}

/// A request's turn to be planned.
struct Turn<'a> {
    shared: &'a Shared,
    stop: &'a StopFlag,
    since: Cell<Instant>,
    /// A request that is stopped goes on without one: it ends at once.
    has_one: Cell<bool>,
}

impl<'a> Turn<'a> {
    /// Waits for a turn.
    fn take(shared: &'a Shared, stop: &'a StopFlag) -> Self {
        let turn =
            Self { shared, stop, since: Cell::new(Instant::now()), has_one: Cell::new(false) };
        turn.line_up(shared.lock(), Turns::ask);
        turn
    }

    /// Lets others have their turn, if it is time to.
    fn share(&self, now: Instant) {
        if self.has_one.get() && now.duration_since(self.since.get()) >= SLICE {
            self.line_up(self.shared.lock(), Turns::pass_on);
        }
    }

    fn line_up(
        &self,
        mut state: MutexGuard<'_, State>,
        ask: impl FnOnce(&mut Turns) -> Option<crate::turns::Place>,
    ) {
        self.has_one.set(true);
        if let Some(place) = ask(&mut state.turns) {
            // Whoever is first in the line may have got a turn.
            self.shared.turn.notify_all();
            while state.turns.waits(place) && self.stop.reason().is_none() {
                state = self.shared.turn.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
            self.has_one.set(!state.turns.leave(place));
        }
        self.since.set(Instant::now());
    }

    fn give_back(&self) {
        if self.has_one.take() {
            self.shared.lock().turns.give_back();
            self.shared.turn.notify_all();
        }
    }

    /// Counts the bytes of a part, and waits while too many parts lie about; without a turn
    /// meanwhile.
    fn make_room(&self, bytes: usize) {
        let mut state = self.shared.lock();
        state.unsent += bytes;
        if state.unsent <= self.shared.limits.bytes {
            return;
        }
        drop(state);
        self.give_back();
        let mut state = self.shared.lock();
        // One reply alone can be larger than the bound.
        while state.unsent > self.shared.limits.bytes.max(bytes) && self.stop.reason().is_none() {
            state = self.shared.turn.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        self.line_up(state, Turns::ask);
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        self.give_back();
    }
}

/// Tells the sequencer.
#[derive(Debug)]
struct Teller {
    tell: Sender<Told>,
    waker: Waker,
}

impl Teller {
    fn tell(&self, ticket: u64, what: Outcome) {
        // Nobody listens any more when the process ends.
        if self.tell.send(Told { ticket, what }).is_ok() {
            self.waker.wake();
        }
    }
}

/// Writes the parts of a reply into memory of their own.
struct Parts<'a> {
    job: &'a Job,
    turn: &'a Turn<'a>,
    teller: &'a Teller,
}

/// Nobody wants the reply any more.
#[derive(Debug)]
struct Unwanted;

impl PartSink for Parts<'_> {
    type Error = Unwanted;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Unwanted> {
        if self.job.stop.reason() == Some(StopReason::ClientLeft) {
            return Err(Unwanted);
        }
        let mut memory = vec![0; cells];
        fill(&mut CellWriter::new(&mut memory));
        self.turn.make_room(size_of_val(memory.as_slice()));
        self.teller.tell(self.job.ticket, Outcome::Part(Box::new(*header), memory));
        Ok(())
    }
}
