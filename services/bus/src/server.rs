//! The planner's side: requests in, replies out, part by part.

mod copy;
mod deaths;
mod inbox;
mod reply;
mod ringer;
mod waker;

pub use reply::{ClientWatch, Incoming, ReplySink};
pub use waker::Waker;

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::os::fd::AsFd;
use std::rc::Rc;
use std::time::{Duration, Instant};

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::{CallbackProgression, PortFactory, ipc};
use iceoryx2::service::port_factory::server::ServerCreateError;
use schemas::message::Digest;
use schemas::wire;

use crate::cause::Cause;
use crate::domain::Domain;
use crate::error::OpenError;
use crate::headers::Current;
use crate::ledger::Ledger;
use crate::member::Member;
use crate::memory;
use crate::options::ServerOptions;
use crate::ports;
use crate::presence::Visitor;
use crate::previous::Previous;
use crate::status::StatusWriter;
use crate::tap::TapWriter;
use crate::wait::{self, Wait, Woken};
use deaths::Deaths;
use inbox::{Inbox, InboxPorts};
use reply::Desk;
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
    // Fields are dropped in this order.
    inbox: Inbox,
    /// None if the planner polls.
    bell: Option<Listener<ipc::Service>>,
    plans: (ports::Plan<Previous>, ports::Plan<Current>),
    desk: Rc<RefCell<Desk>>,
    waker: Waker,
    deaths: Deaths,
    status: StatusWriter,
    /// Clients open it; a service without a port disappears with its last factory.
    _wake: ports::Bell,
    node: Member,
    how: Wait,
    /// Whether all memory is taken from the start.
    reserve: bool,
    /// When it was last counted how many clients are lost, and how many were.
    counted: Instant,
    lost: usize,
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
        let inbox = loop {
            match InboxPorts::open(&previous_plan, &current_plan) {
                // The one before may be dying just now.
                Err(ServerCreateError::ExceedsMaxSupportedServers) if Instant::now() < patience => {
                    std::thread::sleep(Duration::from_millis(5));
                    node.sweep();
                }
                done => break done.map_err(|error| no_port(domain, error))?,
            }
        };
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
        let desk = Rc::new(RefCell::new(desk));
        let waker = Waker::new().map_err(|error| OpenError::System(error.to_string()))?;
        let status = StatusWriter::create(&status).map_err(failed(STATUS))?;
        if options.reserve {
            node.take_memory()?;
        }
        let settings = current_plan.static_config();
        if settings.max_clients() < options.max_clients
            || settings.max_active_requests_per_client() < options.requests_per_client
        {
            tracing::warn!(
                "programs are still connected from before, to a planner with smaller settings \
                 (max_clients, requests_per_client); these stay as they were until all have left"
            );
        }
        Ok(Self {
            inbox: Inbox::new(inbox, Rc::clone(&desk)),
            bell,
            plans: (previous_plan, current_plan),
            status,
            desk,
            waker,
            deaths: Deaths::default(),
            _wake: wake,
            node,
            how: options.wait,
            reserve: options.reserve,
            counted: Instant::now(),
            lost: 0,
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
        self.inbox.receive()
    }

    /// Clears away the peers that died, if it is time, and learns which clients have left:
    /// [`Incoming::is_waiting`] is false for theirs then.
    ///
    /// While such a request is held, iceoryx2 0.10 can't forget its client; and where it forgets
    /// two others meanwhile, it loses track of that one, whose memory stays mapped for good.
    pub fn see_who_left(&mut self) {
        if self.sweep_due {
            self.sweep();
        }
        self.inbox.see_who_left();
    }

    /// Whether a request waits, or another thread has woken this server.
    pub fn has_work(&self) -> bool {
        self.waker.is_woken() || self.inbox.has_requests()
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
        // What iceoryx2 0.10 finds of a client that is gone, it never gives back.
        self.node.sweep_after(|| self.inbox.take_all());
        self.deaths.forget_dead();
        self.desk.borrow().ringer.forget_gone();
        (self.swept, self.sweep_due) = (Instant::now(), false);
    }

    /// Opens its ports anew where iceoryx2 0.10 has lost many clients: it keeps the memory and the
    /// descriptors of those that left when it knew them and had not looked at their last requests.
    ///
    /// Only for use while nothing is in hand. It happens while no client is connected, or where so many
    /// are lost that it can't wait; a request that comes while the ports are closed is given up.
    pub fn forget_lost_clients(&mut self) -> Result<(), OpenError> {
        if self.counted.elapsed() < COUNT || self.inbox.has_requests() {
            return Ok(());
        }
        let (clients, lost) = self.count_clients();
        let before = std::mem::replace(&mut self.lost, lost);
        self.counted = Instant::now();
        // Those that have just left are forgotten by the next time.
        let enough = if clients == 0 { MANY_LOST } else { MOST_LOST };
        if before.min(lost) < enough {
            return Ok(());
        }
        tracing::warn!(lost, "opening the ports anew: clients that left are still connected");
        let (previous, current) = &self.plans;
        let renewed = self.inbox.renew((previous, current));
        renewed.map_err(|error| no_port(self.node.domain(), error))?;
        if self.reserve {
            self.node.take_memory()?;
        }
        Ok(())
    }

    /// How many clients are connected, and how many others still have connections.
    fn count_clients(&self) -> (usize, usize) {
        let mut clients = BTreeSet::new();
        let mut note = |client: u128| {
            clients.insert(client);
            CallbackProgression::Continue
        };
        let (previous, current) = &self.plans;
        current.dynamic_config().list_clients(|client| note(client.client_id.value()));
        previous.dynamic_config().list_clients(|client| note(client.client_id.value()));
        let ours = self.inbox.numbers();
        let connections = self.node.connections();
        let lost = connections.filter(|(from, to)| ours.contains(to) && !clients.contains(from));
        (clients.len(), lost.count())
    }

    /// Whether a signal has asked to end; for use under unbroken load.
    pub fn terminated(&self) -> bool {
        wait::terminated()
    }
}

/// How long a planner that was killed counts as being there, at most.
const TAKE_OVER: Duration = Duration::from_millis(300);

/// How often a planner counts the clients that iceoryx2 has lost; how many are many, and how many too
/// many: half of what it keeps.
const COUNT: Duration = Duration::from_secs(2);
const MANY_LOST: usize = 32;
const MOST_LOST: usize = 512;

/// How often a planner looks for peers that died: about 0.1 ms for each that lives.
const SWEEP: Duration = Duration::from_secs(1);

const REQUESTS: &str = "the service for requests";

/// Why there is no port for requests.
fn no_port(domain: &Domain, error: ServerCreateError) -> OpenError {
    let domain = domain.clone();
    match error {
        ServerCreateError::ExceedsMaxSupportedServers => OpenError::AnotherPlanner(domain),
        error => OpenError::Service { what: REQUESTS, domain, cause: error.into() },
    }
}

/// Whether a planner serves.
fn is_served(plan: &ports::Plan<Current>) -> bool {
    plan.dynamic_config().number_of_servers() > 0
}
