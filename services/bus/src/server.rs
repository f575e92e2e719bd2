//! The planner's side: requests in, replies out, part by part.

mod reply;
mod ringer;

pub use reply::{ClientWatch, Incoming, ReplySink};

use std::time::Instant;

use iceoryx2::port::listener::Listener;
use iceoryx2::prelude::{Node, ipc};
use iceoryx2::service::port_factory::server::ServerCreateError;

use crate::cause::Cause;
use crate::domain::{Domain, Tidy};
use crate::error::OpenError;
use crate::headers::{Current, Version};
use crate::options::ServerOptions;
use crate::ports::{self, PlanRequest, PlanServer};
use crate::previous::Previous;
use crate::tap::TapWriter;
use crate::wait::{self, Wait, Woken};
use reply::{Active, Desk, SWEEP, Scratch};
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
    desk: Desk,
    /// Clients open it; a service without a port disappears with its last factory.
    _wake: ports::Bell,
    node: Node<ipc::Service>,
    how: Wait,
    /// The last look for peers that died.
    swept: Instant,
    _tidy: Tidy,
}

impl Server {
    /// Opens the planner's side of a domain.
    pub fn open(domain: &Domain, options: &ServerOptions) -> Result<Self, OpenError> {
        let needs = ports::most_memory(options);
        if let Ok(memory) = rustix::fs::statvfs("/dev/shm") {
            let free = memory.f_bavail.saturating_mul(memory.f_frsize);
            if free < needs {
                return Err(OpenError::SharedMemory { needs, free });
            }
        }
        let node = domain.join("planner")?;
        let failed =
            |what| move |cause: Cause| OpenError::Service { what, domain: domain.clone(), cause };
        const REQUESTS: &str = "the service for requests";
        const WAKE: &str = "the event that wakes the planner";
        const ANSWERED: &str = "the event that wakes clients";
        const TAP: &str = "the tap for recorders";
        let current = ports::create_plan::<Current>(&node, options).map_err(failed(REQUESTS))?;
        let previous = ports::create_plan::<Previous>(&node, options).map_err(failed(REQUESTS))?;
        let wake = ports::create_wake(&node, options).map_err(failed(WAKE))?;
        let answered = ports::create_answered(&node, options).map_err(failed(ANSWERED))?;
        let tap = ports::create_tap(&node, options).map_err(failed(TAP))?;

        let port = |error| match error {
            ServerCreateError::ExceedsMaxSupportedServers => {
                OpenError::AnotherPlanner(domain.clone())
            }
            error => failed(REQUESTS)(error.into()),
        };
        let patience = options.reply.patience;
        let current =
            ports::create_plan_server::<Current>(&current, patience, |all| all).map_err(port)?;
        let previous =
            ports::create_plan_server::<Previous>(&previous, patience, ports::previous_parts)
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
        let desk = Desk {
            ringer: Ringer::new(ringer, options.max_clients),
            tap: TapWriter::create(tap).map_err(failed(TAP))?,
            scratch: Scratch::default(),
            patience,
        };
        Ok(Self {
            previous,
            current,
            previous_first: false,
            bell,
            desk,
            _wake: wake,
            node,
            how: options.wait,
            swept: Instant::now(),
            _tidy: Tidy(domain.clone()),
        })
    }

    /// The next request, if one waits. The tap gets a copy at once.
    pub fn receive(&mut self) -> Option<Incoming<'_>> {
        let current = || take::<Current>(&self.current).map(Active::Current);
        let previous = || take::<Previous>(&self.previous).map(Active::Previous);
        let active = match self.previous_first {
            true => previous().or_else(current),
            false => current().or_else(previous),
        }?;
        self.previous_first = matches!(active, Active::Current(_));
        self.desk.tap.request(&active.header(), active.payload());
        Some(Incoming { active, desk: &mut self.desk, node: &self.node })
    }

    /// Waits for a request or for a signal to end, at most [`wait::NET`].
    pub fn wait(&mut self) -> Woken {
        let (current, previous) = (&self.current, &self.previous);
        let asked =
            || current.has_requests().unwrap_or(true) || previous.has_requests().unwrap_or(true);
        let woken = wait::wait(self.how, self.bell.as_ref(), None, asked);
        self.desk.tap.heartbeat();
        // The dead keep their memory, and a dead recorder keeps the tap busy, until somebody
        // cleans up.
        if self.swept.elapsed() >= SWEEP && !asked() {
            self.node.try_cleanup_dead_nodes();
            self.swept = Instant::now();
        }
        woken
    }

    /// Whether a signal has asked to end; for use under unbroken load.
    pub fn terminated(&self) -> bool {
        wait::terminated()
    }
}

/// The next request of a version.
fn take<V: Version>(port: &PlanServer<V>) -> Option<PlanRequest<V>> {
    port.receive().unwrap_or_else(|error| {
        // A client died half connected; the others go on.
        tracing::warn!(cause = %Cause::from(error), "can't receive from a client");
        None
    })
}
