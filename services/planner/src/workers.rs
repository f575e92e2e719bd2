//! Threads that plan.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use answer::{Caps, StopFlag, StopReason, Store, Workspace};
use bus::Waker;
use schemas::convert::{CellWriter, PartSink};
use schemas::message::{ErrorCode, Refusal};
use schemas::wire::ReplyHeader;

use crate::desk::{Desk, Load, Turn};
use crate::queue::{Job, QueueLimits, Waiting};
use crate::resume::{Resumed, stop_after};

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
    desk: Arc<Desk>,
    told: Receiver<Told>,
    threads: Vec<JoinHandle<()>>,
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
        let desk = Arc::new(Desk::new(count, limits));
        let (tell, told) = channel();
        let mut workers = Self { desk, told, threads: Vec::new() };
        for number in 0..count * SHARING {
            let desk = Arc::clone(&workers.desk);
            let teller = Teller { tell: tell.clone(), waker: waker.clone() };
            let store = store.clone();
            let run = move || run(&desk, caps, &store, &teller);
            let thread = thread::Builder::new().name(format!("worker {number}"));
            workers.threads.push(thread.spawn(run)?);
        }
        Ok(workers)
    }

    /// See [`Desk::add`].
    pub(crate) fn add(&self, job: Job) -> Result<(), (Job, Waiting)> {
        self.desk.add(job, self.threads.len())
    }

    /// See [`Desk::stop`].
    pub(crate) fn stop(&self, ticket: u64, stop: &StopFlag, reason: StopReason) -> Option<Job> {
        self.desk.stop(ticket, stop, reason)
    }

    /// What a thread has to tell, if any has.
    pub(crate) fn told(&self) -> Option<Told> {
        self.told.try_recv().ok()
    }

    /// See [`Desk::free`].
    pub(crate) fn free(&self, bytes: usize) {
        self.desk.free(bytes);
    }

    pub(crate) fn load(&self) -> Load {
        self.desk.load()
    }
}

impl Drop for Workers {
    fn drop(&mut self) {
        self.desk.end();
        let until = Instant::now() + LEAVE;
        while Instant::now() < until && self.threads.iter().any(|thread| !thread.is_finished()) {
            thread::sleep(Duration::from_millis(1));
        }
    }
}

fn run(desk: &Desk, caps: Caps, store: &Store, teller: &Teller) {
    let mut workspace = Workspace::sharing(caps, store);
    while let Some(job) = desk.next() {
        teller.tell(job.ticket, Outcome::Begun);
        let turn = Turn::take(desk, &job.stop);
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
        desk.done();
        teller.tell(job.ticket, Outcome::Done);
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
