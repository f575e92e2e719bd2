//! The sequencer: one thread that owns the bus, takes requests in turn and sends their replies.
//!
//! A request is answered here at once as long as that is quick: handing it to a worker takes longer
//! than most answers. One that turns out long is begun anew by a worker (`workers.rs`), whose
//! parts come back here to be sent. Nothing in this thread waits for a client or for a worker.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

use answer::{CacheStats, StopFlag, StopReason, Store, Workspace};
use bus::{Domain, Incoming, ReplyError, Server, Woken};
use configuration::Config;
use schemas::message::{Digest, ErrorCode, Refusal};
use schemas::status::Status;
use schemas::wire::{RequestHeader, given};

use crate::at_once::{Ended, Sink};
use crate::manager::{self, Manager};
use crate::metrics::Latest;
use crate::queue::{Job, QueueLimits, Waiting};
use crate::resume::{Resumed, stop_after};
use crate::statistics::{Counted, Present, Statistics};
use crate::workers::{Outcome, Workers, internal_error};

/// After this many requests without a pause the loop looks after the others in hand.
const WITHOUT_PAUSE: u32 = 8;

/// The memory of requests that are not larger than this is used again, cells.
const KEPT_CELLS: usize = 1 << 17;

/// How long a request is planned here while others wait: about as long as handing it over takes.
const SLICE: Duration = Duration::from_micros(250);

/// How long a request is planned here at most.
const LONGEST: Duration = Duration::from_millis(5);

/// How often clients of requests in hand are looked for, and their deadlines.
const LOOK: Duration = Duration::from_millis(4);

/// How long workers and clients have for what is left when the grace is over.
const LAST_WORDS: Duration = Duration::from_millis(300);

/// How often the status is published, and at most while requests come.
const EVERY: Duration = Duration::from_secs(1);
const ON_CHANGE: Duration = Duration::from_millis(200);

/// What a planner has done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Served {
    /// Requests taken.
    pub requests: u64,
    /// Replies that their client did not take, or that had no client any more.
    pub undelivered: u64,
    /// What the cache did.
    pub cache: CacheStats,
}

/// Serves until a signal asks it to end, and then what is in hand for as long as
/// [`Config::grace`] says.
///
/// # Errors
///
/// If the operating system starts no threads, or ports that wear out can't be opened anew.
pub fn serve(
    (server, domain): (&mut Server, &Domain),
    config: &Config,
    metrics: Option<SocketAddr>,
) -> std::io::Result<Served> {
    let metrics = metrics.map(|address| {
        let latest = Latest::default();
        crate::metrics::serve(address, latest.clone()).map(|()| latest)
    });
    let mut service = Service::start(server, config, metrics.transpose()?)?;
    service.publish();
    tracing::info!(%domain, wait = config.wait.name(), workers = config.workers(), "ready");
    let mut manager = Manager::ready(domain);
    while !service.step()? {
        manager.is_alive();
    }
    Ok(service.end())
}

struct Service<'a> {
    server: &'a mut Server,
    config: &'a Config,
    store: Store,
    workspace: Workspace,
    workers: Workers,
    /// Requests that are not answered in full, by their ticket.
    in_hand: BTreeMap<u64, InHand>,
    /// The last ticket given out.
    last_ticket: u64,
    cells: Vec<u64>,
    statistics: Statistics,
    /// What was last published, and when.
    published: (u64, Instant),
    metrics: Option<Latest>,
    /// Set once the process is asked to end.
    closing: Option<Closing>,
    looked: Instant,
}

/// How a service ends.
#[derive(Debug, Clone, Copy)]
struct Closing {
    /// Whether what is in hand is still planned.
    graceful: bool,
    until: Instant,
}

/// A request that a worker has, or whose reply is still being sent.
#[derive(Debug)]
struct InHand {
    incoming: Incoming,
    taken: Instant,
    stop: Arc<StopFlag>,
    deadline: Option<Instant>,
    /// Whether it still waits for a worker.
    waits: bool,
    /// Whether all parts of its reply are written.
    is_written: bool,
    /// Bytes of its parts that a worker wrote and nobody took.
    unsent: usize,
}

/// How answering here at once ended.
enum AtOnce {
    Written,
    /// A worker goes on after so many parts.
    HandedOver(usize),
    Failed(ReplyError),
}

impl<'a> Service<'a> {
    fn start(
        server: &'a mut Server,
        config: &'a Config,
        metrics: Option<Latest>,
    ) -> std::io::Result<Self> {
        let store = Store::new(config.cache);
        let limits = QueueLimits { requests: config.queue, bytes: config.queue_bytes };
        let planning = (config.caps, &store);
        let workers = Workers::start(config.workers(), limits, planning, &server.waker())?;
        Ok(Self {
            server,
            config,
            workspace: Workspace::sharing(config.caps, &store),
            store,
            workers,
            in_hand: BTreeMap::new(),
            last_ticket: 0,
            cells: Vec::new(),
            statistics: Statistics::new(),
            published: (0, Instant::now()),
            metrics,
            closing: None,
            looked: Instant::now(),
        })
    }

    /// Does what there is to do, and waits for more. Whether the service has ended.
    fn step(&mut self) -> std::io::Result<bool> {
        self.hear_workers();
        let mut taken = 0;
        while taken < WITHOUT_PAUSE
            && let Some(incoming) = self.receive()
        {
            self.take(incoming);
            taken += 1;
        }
        if !self.in_hand.is_empty() {
            self.look_after();
        }
        self.publish_if_due();
        if self.in_hand.is_empty() && self.closing.is_none() {
            self.server.forget_lost_clients().map_err(std::io::Error::other)?;
        }
        if self.closing.is_none() && self.server.terminated() {
            let grace = Duration::from_secs_f64(self.config.grace);
            tracing::info!(in_hand = self.in_hand.len(), ?grace, "ending");
            manager::stopping();
            self.closing = Some(Closing { graceful: true, until: Instant::now() + grace });
        }
        match self.closing {
            Some(_) if self.in_hand.is_empty() => return Ok(true),
            Some(Closing { graceful, until }) if Instant::now() >= until => {
                if !graceful {
                    return Ok(true);
                }
                self.refuse_all();
                let until = Instant::now() + LAST_WORDS;
                self.closing = Some(Closing { graceful: false, until });
            }
            Some(_) => self.server.rest(self.next_look()),
            None if taken == WITHOUT_PAUSE => {}
            None => {
                let until = (!self.in_hand.is_empty()).then(|| self.next_look());
                if self.server.wait(until) == Woken::Look && self.in_hand.is_empty() {
                    self.server.watch_nobody();
                }
            }
        }
        Ok(false)
    }

    /// The next request. Those of clients that have left are given up before; see
    /// [`Server::see_who_left`].
    fn receive(&mut self) -> Option<Incoming> {
        self.server.see_who_left();
        let gone = self.in_hand.iter().filter(|(_, request)| !request.incoming.is_waiting());
        let gone: Vec<_> = gone.map(|(ticket, _)| *ticket).collect();
        gone.into_iter().for_each(|ticket| self.give_up(ticket, &ReplyError::Gone));
        self.server.receive()
    }

    /// Once a second, and when something has changed.
    fn publish_if_due(&mut self) {
        let (requests, published) = self.published;
        let changed = requests != self.statistics.requests || !self.in_hand.is_empty();
        if published.elapsed() >= if changed { ON_CHANGE } else { EVERY } {
            self.publish();
        }
    }

    fn publish(&mut self) {
        let status = self.statistics.status(&Present {
            load: self.workers.load(),
            workers: self.config.workers(),
            queue: self.config.queue,
            cache: self.store.cache_stats(),
        });
        let status = Status { config: self.config.to_json(), ..status };
        self.server.publish_status(&status.to_json());
        if let Some(latest) = &self.metrics {
            latest.set(status);
        }
        self.published = (self.statistics.requests, Instant::now());
    }

    /// When to look after what is in hand.
    fn next_look(&self) -> Instant {
        let tries = self.in_hand.values().filter_map(|request| request.incoming.next_try());
        // Those that have passed wait for a worker only.
        let is_due = |request: &&InHand| request.stop.reason().is_none() && !request.is_written;
        let due = self.in_hand.values().filter(is_due);
        let deadlines = due.filter_map(|request| request.deadline);
        tries.chain(deadlines).fold(Instant::now() + LOOK, Instant::min)
    }

    fn take(&mut self, mut incoming: Incoming) {
        self.statistics.requests += 1;
        let taken = Instant::now();
        let header = incoming.header();
        if let Some(name) = header.names_only() {
            crate::shown::show(self.server, &self.store, Digest(name));
        }
        let caps = &self.config.caps;
        // Don't even copy what is too large.
        let readable = caps.check_cells(incoming.cells()).and_then(|()| {
            incoming
                .copy(caps.cells, &mut self.cells)
                .map_err(|error| Refusal::new(ErrorCode::InvalidScene, error.to_string()))
        });
        if let Err(refusal) = readable {
            return self.refuse(incoming, taken, &refusal);
        }
        if self.closing.is_some() {
            return self.refuse(incoming, taken, &StopReason::Shutdown.refusal());
        }
        let deadline = deadline(&header);
        let waits_in_line = self
            .in_hand
            .values()
            .any(|other| other.waits && other.incoming.header().client == header.client);
        let answered = match waits_in_line {
            // The requests of a client begin in order.
            true => AtOnce::HandedOver(0),
            false => self.answer_at_once(&mut incoming, &header, deadline),
        };
        match answered {
            AtOnce::HandedOver(written) => self.hand_over(incoming, taken, deadline, written),
            AtOnce::Written => self.sent(incoming, taken),
            AtOnce::Failed(error) => self.undelivered(&header, &error),
        }
        self.cells.clear();
        self.cells.shrink_to(KEPT_CELLS);
    }

    /// Answers a request in this thread, unless it takes too long.
    fn answer_at_once(
        &mut self,
        incoming: &mut Incoming,
        header: &RequestHeader,
        deadline: Option<Instant>,
    ) -> AtOnce {
        let Self { server, workspace, cells, in_hand, statistics, .. } = self;
        let (stop, begun, alone) = (StopFlag::new(), Instant::now(), in_hand.is_empty());
        let (sink, client) = incoming.reply_to_client();
        let meanwhile = || {
            let now = Instant::now();
            let took = now.duration_since(begun);
            if deadline.is_some_and(|deadline| now >= deadline) {
                stop.stop(StopReason::Deadline);
            } else if !client.is_waiting() {
                stop.stop(StopReason::ClientLeft);
            } else if took >= LONGEST || took >= SLICE && (!alone || server.has_work()) {
                stop.stop(StopReason::HandedOver);
            }
        };
        let sink = Counted { sink, statistics };
        let mut sink = Sink { sink, stop: &stop, meanwhile: &meanwhile };
        let answered = catch_unwind(AssertUnwindSafe(|| {
            workspace.answer_while(header, cells, (&stop, &meanwhile), &mut sink)
        }));
        let written = sink.sink.sink.written();
        match answered {
            Ok(Ok(())) => AtOnce::Written,
            Ok(Err(Ended::HandedOver | Ended::Failed(ReplyError::Full))) => {
                AtOnce::HandedOver(written)
            }
            Ok(Err(Ended::Failed(error))) => AtOnce::Failed(error),
            Err(_) => match self.refuse_defect(incoming, header) {
                Ok(()) => AtOnce::Written,
                Err(error) => AtOnce::Failed(error),
            },
        }
    }

    /// Refuses a request that brings out a defect, which must not take the service with it.
    fn refuse_defect(
        &mut self,
        incoming: &mut Incoming,
        header: &RequestHeader,
    ) -> Result<(), ReplyError> {
        self.workspace = Workspace::sharing(self.config.caps, &self.store);
        let mut sink = Counted { sink: incoming.reply(), statistics: &mut self.statistics };
        Workspace::refuse(header, &internal_error(), &mut sink)
    }

    /// Gives a request to a worker, or refuses it if too many wait.
    fn hand_over(
        &mut self,
        incoming: Incoming,
        taken: Instant,
        deadline: Option<Instant>,
        written: usize,
    ) {
        let header = incoming.header();
        let ticket = self.ticket();
        let stop = Arc::new(StopFlag::new());
        let cells = std::mem::take(&mut self.cells);
        let job = Job { ticket, header, cells, stop: Arc::clone(&stop), deadline, written };
        if let Err((job, waiting)) = self.workers.add(job) {
            self.cells = job.cells;
            let refusal = self.overloaded(waiting);
            return self.refuse(incoming, taken, &refusal);
        }
        self.server.watch(&incoming);
        let request =
            InHand { incoming, taken, stop, deadline, waits: true, is_written: false, unsent: 0 };
        self.in_hand.insert(ticket, request);
    }

    fn ticket(&mut self) -> u64 {
        self.last_ticket += 1;
        self.last_ticket
    }

    fn overloaded(&self, Waiting { requests, bytes }: Waiting) -> Refusal {
        let Config { queue, queue_bytes, .. } = self.config;
        let message = format!(
            "{requests} requests of {bytes} bytes are waiting; the planner lets {queue} wait \
             (`queue`), of {queue_bytes} bytes (`queue_bytes`): send this one again later"
        );
        let (has, most) = (Some(requests as f64), Some(*queue as f64));
        Refusal { has, most, ..Refusal::new(ErrorCode::Overloaded, message) }
    }

    /// Takes what the workers have to tell.
    fn hear_workers(&mut self) {
        while let Some(told) = self.workers.told() {
            let Some(request) = self.in_hand.get_mut(&told.ticket) else {
                // Given up meanwhile.
                if let Outcome::Part(_, cells) = told.what {
                    self.workers.free(size_of_val(cells.as_slice()));
                }
                continue;
            };
            match told.what {
                Outcome::Begun => request.waits = false,
                Outcome::Part(header, cells) => {
                    request.is_written = header.last != 0;
                    self.statistics.count_part(&header, cells.first().copied());
                    request.unsent += size_of_val(cells.as_slice());
                    if let Err(error) = request.incoming.push(*header, cells) {
                        self.give_up(told.ticket, &error);
                    }
                }
                Outcome::Done => request.is_written = true,
            }
        }
    }

    /// Sends what there is room for now, and gives up what nobody waits for or what took too long.
    fn look_after(&mut self) {
        let now = Instant::now();
        let look = now.duration_since(self.looked) >= LOOK;
        if look {
            self.looked = now;
        }
        let mut ended = Vec::new();
        for (ticket, request) in &mut self.in_hand {
            let is_sent = request.is_written && !request.incoming.is_held_up();
            let sent = match request.incoming.next_try() {
                _ if look && !is_sent && !request.incoming.is_waiting() => Err(ReplyError::Gone),
                Some(next) if now < next => Ok(request.incoming.unsent()),
                _ => request.incoming.flush(),
            };
            match sent {
                Ok(left) => {
                    // What is sent at once has no bytes here.
                    let gone = request.unsent.saturating_sub(left);
                    request.unsent -= gone;
                    self.workers.free(gone);
                    if left == 0 && request.is_written {
                        ended.push((*ticket, None));
                    } else if request.deadline.is_some_and(|deadline| now >= deadline)
                        && !request.is_written
                        && request.stop.reason().is_none()
                    {
                        ended.push((*ticket, Some(Late)));
                    }
                }
                Err(error) => ended.push((*ticket, Some(Failed(error)))),
            }
        }
        for (ticket, why) in ended {
            match why {
                None => self.done(ticket),
                Some(Late) => self.too_late(ticket),
                Some(Failed(error)) => self.give_up(ticket, &error),
            }
        }
    }

    /// A request's deadline has passed.
    fn too_late(&mut self, ticket: u64) {
        let Some(request) = self.in_hand.get(&ticket) else { return };
        // A worker that plans it says so in its reply.
        let Some(job) = self.workers.stop(ticket, &request.stop, StopReason::Deadline) else {
            return;
        };
        if let Some(request) = self.in_hand.remove(&ticket) {
            if job.written > 0 {
                return self.refuse_rest(request, &job, StopReason::Deadline);
            }
            let field = Some("deadline".to_owned());
            let message = "the deadline passed before planning began: the planner is busy; allow \
                           more time";
            let refusal = Refusal::new(ErrorCode::DeadlineExceeded, message);
            self.refuse(request.incoming, request.taken, &Refusal { field, ..refusal });
        }
    }

    /// Refuses the answers that a reply which was begun here still lacks.
    fn refuse_rest(&mut self, mut request: InHand, job: &Job, reason: StopReason) {
        let (stop, left) = (StopFlag::new(), Cell::new(job.written));
        let meanwhile = || {
            stop_after(&left, reason, &stop);
        };
        let sink = request.incoming.reply();
        let sink = Counted { sink, statistics: &mut self.statistics };
        let mut sink = Resumed { sink, left: &left };
        let workspace = &mut self.workspace;
        let answered = catch_unwind(AssertUnwindSafe(|| {
            workspace.answer_while(&job.header, &job.cells, (&stop, &meanwhile), &mut sink)
        }));
        let answered =
            answered.unwrap_or_else(|_| self.refuse_defect(&mut request.incoming, &job.header));
        match answered {
            Ok(()) => self.sent(request.incoming, request.taken),
            Err(error) => self.undelivered(&job.header, &error),
        }
    }

    /// A reply can't be sent.
    fn give_up(&mut self, ticket: u64, error: &ReplyError) {
        let Some(request) = self.in_hand.remove(&ticket) else { return };
        self.workers.stop(ticket, &request.stop, StopReason::ClientLeft);
        self.workers.free(request.unsent);
        self.undelivered(&request.incoming.header(), error);
    }

    fn done(&mut self, ticket: u64) {
        if let Some(request) = self.in_hand.remove(&ticket) {
            self.workers.free(request.unsent);
            self.answered(&request.incoming, request.taken);
        }
    }

    /// All parts of a reply are written; some may wait for their client.
    fn sent(&mut self, incoming: Incoming, taken: Instant) {
        if !incoming.is_held_up() {
            return self.answered(&incoming, taken);
        }
        let ticket = self.ticket();
        let request = InHand {
            incoming,
            taken,
            stop: Arc::default(),
            deadline: None,
            waits: false,
            is_written: true,
            unsent: 0,
        };
        self.in_hand.insert(ticket, request);
    }

    fn refuse(&mut self, mut incoming: Incoming, taken: Instant, refusal: &Refusal) {
        let header = incoming.header();
        let mut sink = Counted { sink: incoming.reply(), statistics: &mut self.statistics };
        match Workspace::refuse(&header, refusal, &mut sink) {
            Ok(()) => self.sent(incoming, taken),
            Err(error) => self.undelivered(&header, &error),
        }
    }

    fn undelivered(&mut self, header: &RequestHeader, error: &ReplyError) {
        self.statistics.undelivered += 1;
        let RequestHeader { client, sequence, .. } = header;
        tracing::warn!(client, sequence, %error, "the client did not take its reply");
    }

    /// Refuses what waits, and stops what is being planned: the workers refuse the rest of it.
    fn refuse_all(&mut self) {
        let tickets: Vec<_> = self.in_hand.keys().copied().collect();
        for ticket in tickets {
            let stop = Arc::clone(&self.in_hand[&ticket].stop);
            let reason = StopReason::Shutdown;
            let Some(job) = self.workers.stop(ticket, &stop, reason) else { continue };
            match self.in_hand.remove(&ticket) {
                Some(request) if job.written > 0 => self.refuse_rest(request, &job, reason),
                Some(request) => self.refuse(request.incoming, request.taken, &reason.refusal()),
                None => {}
            }
        }
    }

    /// Says what was done.
    fn end(self) -> Served {
        let undelivered = self.statistics.undelivered + self.in_hand.len() as u64;
        let requests = self.statistics.requests;
        Served { requests, undelivered, cache: self.store.cache_stats() }
    }

    fn answered(&mut self, incoming: &Incoming, taken: Instant) {
        let took = taken.elapsed();
        self.statistics.count_answered(took);
        let RequestHeader { client, sequence, .. } = incoming.header();
        tracing::debug!(client, sequence, ?took, "answered");
    }
}

/// Why a request in hand ends before its reply does.
enum Why {
    Late,
    Failed(ReplyError),
}

use Why::{Failed, Late};

/// When a request that has just arrived is to be answered. What is no possible deadline is
/// refused when the request is read.
fn deadline(header: &RequestHeader) -> Option<Instant> {
    if header.given & given::DEADLINE == 0 {
        return None;
    }
    let left = Duration::try_from_secs_f64(header.deadline).ok().filter(|left| !left.is_zero())?;
    Instant::now().checked_add(left)
}
