//! The planner's side: requests in, replies out, part by part.

mod copy;
mod deaths;
mod reply;
mod ringer;
mod waker;

pub use reply::{ClientWatch, Incoming, ReplySink};
pub use waker::Waker;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::os::fd::AsFd;
use std::rc::Rc;
use std::time::{Duration, Instant};

use iceoryx2::port::listener::Listener;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{CallbackProgression, PortFactory, ipc};
use iceoryx2::service::port_factory::server::ServerCreateError;
use schemas::message::Digest;
use schemas::wire;

use crate::cause::Cause;
use crate::domain::Domain;
use crate::error::OpenError;
use crate::headers::{Current, UserHeader, Version};
use crate::ledger::Ledger;
use crate::member::Member;
use crate::memory;
use crate::options::ServerOptions;
use crate::ports::{self, PlanRequest, PlanServer};
use crate::presence::Visitor;
use crate::previous::Previous;
use crate::status::StatusWriter;
use crate::tap::TapWriter;
use crate::wait::{self, Wait, Woken};
use deaths::Deaths;
use reply::{Active, Desk};
use ringer::Ringer;

/// Takes requests and answers them, in the current and the previous version of the messages.
///
/// Dropping it leaves the domain.
///
/// ```
/// use bus::{Client, Domain, Server, ServerOptions, Wait};
/// use schemas::convert;
/// use schemas::message::{ErrorCode, Refusal, SceneRequest};
/// use schemas::wire::{ReplyHeader, VERSION};
///
/// let domain = Domain::new(&format!("server-doc-{}", std::process::id()))?;
/// let options = ServerOptions { max_clients: 2, max_recorders: 1, ..ServerOptions::default() };
/// let mut server = Server::open(&domain, &options)?;
///
/// let client = Client::connect(&domain, Wait::Poll)?;
/// let mut pending = client.send(&SceneRequest::empty())?;
///
/// // The planner's part: take the request, and refuse it.
/// let mut incoming = server.receive().expect("a request");
/// let request = incoming.header();
/// let (client, sequence) = (request.client, request.sequence);
/// let mut header = ReplyHeader { version: VERSION, client, sequence, ..Default::default() };
/// let refusal = Refusal::new(ErrorCode::NoRoute, "there are no channels");
/// convert::write_refusal(&refusal, &mut header, true, &mut incoming.reply())?;
/// incoming.finish()?;
///
/// let reply = pending.wait(std::time::Instant::now() + std::time::Duration::from_secs(5))?;
/// assert_eq!(reply.answers.unwrap_err().code, ErrorCode::NoRoute);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Server {
    // Fields are dropped in this order. Whoever finds a planner of the previous version
    // only takes it for an older one: that port is opened last and closed first.
    previous: PlanServer<Previous>,
    current: PlanServer<Current>,
    /// Whose turn it is, so that neither version starves the other.
    previous_first: bool,
    /// None if the planner polls.
    bell: Option<Listener<ipc::Service>>,
    plans: (ports::Plan<Previous>, ports::Plan<Current>),
    /// Requests that were taken before it was their turn.
    backlog: VecDeque<Incoming>,
    /// Whether there was a request the last time.
    busy: bool,
    desk: Rc<RefCell<Desk>>,
    waker: Waker,
    deaths: Deaths,
    status: StatusWriter,
    /// Clients open it; a service without a port disappears with its last factory.
    _wake: ports::Bell,
    node: Member,
    how: Wait,
    /// The last look for peers that died, and whether it is time for another.
    swept: Instant,
    sweep_due: bool,
}

impl Server {
    /// Opens the planner's side of a domain.
    pub fn open(domain: &Domain, options: &ServerOptions) -> Result<Self, OpenError> {
        let node = domain.join(Visitor::PLANNER)?;
        let patience = Instant::now() + TAKE_OVER;
        // The memory of one that has just died comes free.
        while let Err(shortage) = memory::check_room(ports::most_memory(options)) {
            if ports::open_plan::<Current, _>(&node).is_ok_and(|plan| is_served(&plan)) {
                return Err(OpenError::AnotherPlanner(domain.clone()));
            }
            if Instant::now() >= patience {
                return Err(shortage.into());
            }
            std::thread::sleep(Duration::from_millis(5));
            node.sweep();
        }
        let failed =
            |what| move |cause: Cause| OpenError::Service { what, domain: domain.clone(), cause };
        const REQUESTS: &str = "the service for requests";
        const WAKE: &str = "the event that wakes the planner";
        const ANSWERED: &str = "the event that wakes clients";
        const TAP: &str = "the tap for recorders";
        const STATUS: &str = "the planner's status";
        let current_plan =
            ports::create_plan::<Current>(&node, options).map_err(failed(REQUESTS))?;
        let previous_plan =
            ports::create_plan::<Previous>(&node, options).map_err(failed(REQUESTS))?;
        let wake = ports::create_wake(&node, options).map_err(failed(WAKE))?;
        let answered = ports::create_answered(&node, options).map_err(failed(ANSWERED))?;
        let tap = ports::create_tap(&node, options).map_err(failed(TAP))?;

        let status = ports::create_status(&node).map_err(failed(STATUS))?;
        let port = |error| match error {
            ServerCreateError::ExceedsMaxSupportedServers => {
                OpenError::AnotherPlanner(domain.clone())
            }
            error => failed(REQUESTS)(error.into()),
        };
        let current = loop {
            match ports::create_plan_server::<Current>(&current_plan, ports::current_parts) {
                // The one before may be dying just now.
                Err(ServerCreateError::ExceedsMaxSupportedServers) if Instant::now() < patience => {
                    std::thread::sleep(Duration::from_millis(5));
                    node.sweep();
                }
                done => break done.map_err(port)?,
            }
        };
        let previous = ports::create_plan_server::<Previous>(&previous_plan, ports::previous_parts)
            .map_err(port)?;
        let bell = match options.wait {
            Wait::Poll => None,
            Wait::Event | Wait::Hybrid => {
                let listener = wake.listener_builder().create();
                Some(listener.map_err(|error| failed(WAKE)(error.into()))?)
            }
        };
        let ringer = answered.notifier_builder().create();
        let ringer = ringer.map_err(|error| failed(ANSWERED)(error.into()))?;
        let ledger = Ledger::create(&node.directory());
        let ledger = ledger.map_err(|error| OpenError::System(error.to_string()))?;
        let desk = Desk {
            ringer: Ringer::new(ringer, options.max_clients),
            tap: TapWriter::create(tap, ledger).map_err(failed(TAP))?,
            patience: options.reply.patience,
            old: Vec::new(),
            spare: reply::Spare::default(),
        };
        let waker = Waker::new().map_err(|error| OpenError::System(error.to_string()))?;
        let status = StatusWriter::create(&status).map_err(failed(STATUS))?;
        if options.reserve {
            node.take_memory()?;
        }
        Ok(Self {
            previous,
            current,
            previous_first: false,
            bell,
            plans: (previous_plan, current_plan),
            backlog: VecDeque::new(),
            busy: false,
            status,
            desk: Rc::new(RefCell::new(desk)),
            waker,
            deaths: Deaths::default(),
            _wake: wake,
            node,
            how: options.wait,
            swept: Instant::now(),
            sweep_due: false,
        })
    }

    /// The next request, if one waits.
    ///
    /// Requests whose clients have left are to be dropped before: see [`Server::see_who_left`].
    pub fn receive(&mut self) -> Option<Incoming> {
        if self.sweep_due {
            self.sweep();
        }
        loop {
            // iceoryx2 looks at its clients in the same order each time, so that the last would
            // wait for ever while the first keep asking: whoever waits now comes before those.
            if self.backlog.is_empty() && self.busy {
                self.take_all();
            }
            let incoming = self.backlog.pop_front().or_else(|| self.take());
            self.busy = incoming.is_some();
            if incoming.as_ref().is_none_or(Incoming::is_waiting) {
                return incoming;
            }
        }
    }

    /// Takes what waits in shared memory, which clients can't make endless: each has a few requests
    /// open at a time.
    fn take_all(&mut self) {
        while let Some(incoming) = self.take() {
            self.backlog.push_back(incoming);
        }
    }

    /// The next request in shared memory.
    fn take(&mut self) -> Option<Incoming> {
        let current = || take::<Current>(&self.current).map(Active::Current);
        let previous = || take::<Previous>(&self.previous).map(Active::Previous);
        let active = match self.previous_first {
            true => previous().or_else(current),
            false => current().or_else(previous),
        }?;
        self.previous_first = matches!(active, Active::Current(_));
        Some(Incoming::new(active, Rc::clone(&self.desk)))
    }

    /// Learns which clients have left: [`Incoming::is_waiting`] is false for theirs then.
    ///
    /// While such a request is held, iceoryx2 0.10 can't forget its client; and where it forgets
    /// two others meanwhile, it loses track of that one, whose memory stays mapped for good.
    pub fn see_who_left(&mut self) {
        // Those that died half connected are of no interest here.
        let _ = (self.current.update_connections(), self.previous.update_connections());
        self.backlog.retain(Incoming::is_waiting);
    }

    /// Whether a request waits, or another thread has woken this server.
    pub fn has_work(&self) -> bool {
        let has_requests = || {
            self.current.has_requests().unwrap_or(true)
                || self.previous.has_requests().unwrap_or(true)
        };
        self.waker.is_woken() || !self.backlog.is_empty() || has_requests()
    }

    /// Wakes this server from another thread.
    pub fn waker(&self) -> Waker {
        self.waker.clone()
    }

    /// Waits for a request, for the waker or for a signal to end, at most until `until` and at
    /// most [`wait::NET`].
    pub fn wait(&mut self, until: Option<Instant>) -> Woken {
        let others = std::iter::once(self.waker.as_fd()).chain(self.deaths.processes());
        let woken = wait::wait(self.how, (self.bell.as_ref(), others), until, || self.has_work());
        let died = self.deaths.any();
        self.waker.reset();
        self.beat();
        self.sweep_due |= died || self.swept.elapsed() >= SWEEP;
        woken
    }

    /// Recorders see that the planner is alive, and its last status.
    fn beat(&self) {
        if self.desk.borrow_mut().tap.heartbeat() {
            self.status.show();
        }
    }

    /// Waits for the waker only, whatever signals have come, at most until `until`.
    pub fn rest(&mut self, until: Instant) {
        let most = until.saturating_duration_since(Instant::now()).min(wait::NET);
        wait::sleep_for(&self.waker, most);
        self.waker.reset();
        self.beat();
    }

    /// From now on a wait ends at once when the client of this request dies, if its process can be
    /// watched from here; otherwise its death is noticed within a second.
    pub fn watch(&mut self, incoming: &Incoming) {
        let client = incoming.client_id();
        let deaths = &mut self.deaths;
        let (previous, current) = &self.plans;
        let mut watch = |id, node| match id == client {
            true => {
                deaths.watch(node);
                CallbackProgression::Stop
            }
            false => CallbackProgression::Continue,
        };
        current.dynamic_config().list_clients(|client| watch(client.client_id, client.node_id));
        previous.dynamic_config().list_clients(|client| watch(client.client_id, client.node_id));
    }

    /// Whether a recorder has not been shown the free space of this name.
    pub fn recorders_lack(&self, name: Digest) -> bool {
        self.desk.borrow_mut().tap.lacks(name)
    }

    /// Shows recorders a request that would make the free space of this name known, before one
    /// that only names it.
    pub fn show_free_space(&self, name: Digest, header: &wire::RequestHeader, cells: &[u64]) {
        self.desk.borrow_mut().tap.show(name, header, cells);
    }

    /// Publishes what the planner says of itself; whoever comes later sees the last of it.
    pub fn publish_status(&self, text: &str) {
        if let Err(cause) = self.status.publish(text) {
            tracing::warn!(%cause, "can't publish the status");
        }
    }

    /// Nobody waits for a reply any more.
    pub fn watch_nobody(&mut self) {
        self.deaths.clear();
    }

    /// Clears away the peers that died. The dead keep their memory, and a dead recorder keeps the
    /// tap busy, until somebody does.
    pub fn sweep(&mut self) {
        if self.node.has_dead() {
            // What iceoryx2 0.10 finds of a client that is gone, it never gives back.
            self.take_all();
        }
        self.node.sweep();
        self.deaths.forget_dead();
        self.desk.borrow().ringer.forget_gone();
        (self.swept, self.sweep_due) = (Instant::now(), false);
    }

    /// Whether a signal has asked to end; for use under unbroken load.
    pub fn terminated(&self) -> bool {
        wait::terminated()
    }
}

/// How long a planner that was killed counts as being there, at most.
const TAKE_OVER: Duration = Duration::from_millis(300);

/// How often a planner looks for peers that died: about 0.1 ms for each that lives.
const SWEEP: Duration = Duration::from_secs(1);

/// Errors in a row after which the others have to wait for another try.
const ERRORS: u32 = 3;

/// Whether a planner serves.
fn is_served(plan: &ports::Plan<Current>) -> bool {
    plan.dynamic_config().number_of_servers() > 0
}

/// The next request of a version.
fn take<V: Version>(port: &PlanServer<V>) -> Option<PlanRequest<V>> {
    // A client that died half connected is an error once; the others go on.
    let mut errors = 0;
    while errors < ERRORS {
        match port.receive() {
            // Dropping it is the answer.
            Ok(Some(request)) if is_farewell(&V::upgrade(request.user_header().plain())) => {}
            Ok(request) => return request,
            Err(error) => {
                tracing::warn!(cause = %Cause::from(error), "can't receive from a client");
                errors += 1;
            }
        }
    }
    None
}

/// Whether a client only wants to know that its requests before were taken.
fn is_farewell(header: &wire::RequestHeader) -> bool {
    *header == wire::RequestHeader { version: wire::FAREWELL, ..Default::default() }
}
