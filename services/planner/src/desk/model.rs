//! All orders in which the sequencer and two threads can meet, up to a number of preemptions. A thread
//! that nobody wakes any more is a deadlock, which the model checker reports.
//!
//! `cargo test -p clearway-planner --features loom model`

use std::sync::Arc as Plain;
use std::sync::atomic::{AtomicUsize, Ordering};

use loom::sync::Arc;
use loom::thread;
use schemas::wire::RequestHeader;

use super::*;

const LIMITS: QueueLimits = QueueLimits { requests: 4, bytes: 64 };

fn job(ticket: u64) -> Job {
    Job {
        ticket,
        header: RequestHeader { client: ticket, ..RequestHeader::default() },
        cells: vec![0],
        stop: Plain::default(),
        deadline: None,
        written: 0,
    }
}

/// Goes through the orders with at most two preemptions.
fn model(check: impl Fn() + Sync + Send + 'static) {
    let mut builder = loom::model::Builder::new();
    builder.preemption_bound = Some(2);
    builder.max_branches = 10_000;
    builder.check(check);
}

/// What threads have planned, and how many do now: the model's own, so that they are interrupted while
/// they do.
#[derive(Default)]
struct Seen {
    planned: AtomicUsize,
    now: loom::sync::atomic::AtomicUsize,
}

impl Seen {
    /// Plans for a while, if it has its turn.
    fn plan(&self, turn: &Turn<'_>) {
        if turn.has_one.get() {
            assert_eq!(self.now.fetch_add(1, Ordering::SeqCst), 0, "two plan in one turn");
            self.now.fetch_sub(1, Ordering::SeqCst);
        }
    }
}

/// A thread that plans until there is nothing more: each request passes its turn on once, and has a
/// part of so many bytes.
fn plan(desk: &Desk, seen: &Seen, bytes: usize) {
    while let Some(job) = desk.next() {
        let turn = Turn::take(desk, &job.stop);
        seen.plan(&turn);
        turn.share(turn.since.get() + SLICE);
        seen.plan(&turn);
        if bytes > 0 {
            turn.make_room(bytes);
        }
        drop(turn);
        desk.done();
        seen.planned.fetch_add(1, Ordering::SeqCst);
    }
}

/// Two threads of which one plans at a time.
struct Planners {
    desk: Arc<Desk>,
    seen: Plain<Seen>,
    threads: [thread::JoinHandle<()>; 2],
}

impl Planners {
    /// Parts of requests have so many bytes.
    fn new(bytes: usize) -> Self {
        let desk = Arc::new(Desk::new(1, LIMITS));
        let seen = Plain::new(Seen::default());
        let threads = [(); 2].map(|()| {
            let (desk, seen) = (Arc::clone(&desk), Plain::clone(&seen));
            thread::spawn(move || plan(&desk, &seen, bytes))
        });
        Self { desk, seen, threads }
    }

    /// Ends when so many requests have been planned.
    fn end_after(self, planned: usize) -> Arc<Desk> {
        while self.seen.planned.load(Ordering::SeqCst) < planned {
            thread::yield_now();
        }
        self.desk.end();
        for thread in self.threads {
            thread.join().unwrap();
        }
        self.desk
    }
}

/// Two threads of which one plans at a time, and a sequencer that adds two requests and ends when both
/// are planned.
#[test]
fn everything_is_planned_in_turns() {
    model(|| {
        let planners = Planners::new(0);
        let desk = &planners.desk;
        desk.add(job(1), 2).unwrap();
        desk.add(job(2), 2).unwrap();
        let desk = planners.end_after(2);
        let load = desk.load();
        assert_eq!((load.waiting, load.planning), (Waiting::default(), 0));
        assert_eq!(desk.lock().turns.ask(), None, "the turn is free again");
    });
}

/// A request is stopped at any moment: it is given back or planned, never both, and holds nobody up.
#[test]
fn a_request_is_stopped_or_planned() {
    model(|| {
        let planners = Planners::new(0);
        let desk = &planners.desk;
        let second = job(2);
        let stop = Plain::clone(&second.stop);
        desk.add(job(1), 2).unwrap();
        desk.add(second, 2).unwrap();
        let given_back = usize::from(desk.stop(2, &stop, StopReason::ClientLeft).is_some());
        let seen = Plain::clone(&planners.seen);
        planners.end_after(2 - given_back);
        assert_eq!(seen.planned.load(Ordering::SeqCst) + given_back, 2);
    });
}

/// A thread that waits for room for its part lets the other have the turn, and goes on when parts are
/// sent.
#[test]
fn who_waits_for_room_goes_on_when_there_is_some() {
    model(|| {
        let planners = Planners::new(40);
        let desk = &planners.desk;
        desk.add(job(1), 2).unwrap();
        desk.add(job(2), 2).unwrap();
        // Both parts do not fit at once.
        let mut sent = 0;
        while sent < 2 {
            if desk.load().unsent >= 40 {
                desk.free(40);
                sent += 1;
            }
            thread::yield_now();
        }
        let desk = planners.end_after(2);
        assert_eq!(desk.load().unsent, 0);
    });
}
