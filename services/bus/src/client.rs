//! A client's side: ask, and take the reply part by part.

use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{AllocationStrategy, Node, PortFactory, PortName, ipc};
use iceoryx2::service::builder::request_response::RequestResponseOpenError;
use schemas::convert::{self, Malformed};
use schemas::message::{
    AssembleError, Refusal, Reply, ReplyAssembler, ReplyPart, RequestKey, SceneRequest,
};
use schemas::topic;
use thiserror::Error;

use crate::domain::{Domain, DomainError};
use crate::headers::{ReplyHeader, RequestHeader};
use crate::ports;
use crate::server::Tidy;
use crate::wait::{self, Wait, Woken};

/// Why there is no connection to a planner.
#[derive(Debug, Error)]
pub enum ConnectError {
    /// The domain can't be joined.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// No planner is there.
    #[error("no planner runs in domain {domain} (start one with `planner`): {cause}")]
    NoPlanner {
        /// The domain.
        domain: Domain,
        /// What iceoryx2 says.
        cause: String,
    },
    /// The planner there is of another version.
    #[error(
        "the planner in domain {domain} does not speak layout {layout:016x}, as this client does"
    )]
    OtherLayout {
        /// The domain.
        domain: Domain,
        /// This client's layout; see [`topic::layout_hash`].
        layout: u64,
    },
    /// The operating system has no random numbers.
    #[error("can't draw a nonce: {0}")]
    Random(String),
    /// All places are taken.
    #[error("domain {domain} takes no more like this one: {cause}")]
    Full {
        /// The domain.
        domain: Domain,
        /// What iceoryx2 says.
        cause: String,
    },
}

/// Why a request has no reply.
#[derive(Debug, Error)]
pub enum CallError {
    /// The request can't be said on the bus.
    #[error("{}", .0.message)]
    Scene(Refusal),
    /// It could not be sent.
    #[error("could not send the request: {0}")]
    Send(String),
    /// What came could not be taken from shared memory.
    #[error("could not receive the reply: {0}")]
    Receive(String),
    /// The planner died, left, or gave the reply up because nobody took it.
    #[error("the planner is gone or has given the reply up")]
    PlannerGone,
    /// No reply came in time.
    #[error("no reply within {waited:?} (limit {limit:?})")]
    TimedOut {
        /// How long was waited.
        waited: Duration,
        /// How long was to be waited.
        limit: Duration,
    },
    /// The planner wrote no reply.
    #[error("the reply can't be read: {0}")]
    Malformed(#[from] Malformed),
    /// Parts of the reply are missing.
    #[error("the reply is not complete: {0}")]
    Incomplete(#[from] AssembleError),
    /// SIGINT or SIGTERM came.
    #[error("interrupted")]
    Interrupted,
}

type Port = iceoryx2::port::client::Client<ipc::Service, [u64], RequestHeader, [u64], ReplyHeader>;
type Awaited = PendingResponse<ipc::Service, [u64], RequestHeader, [u64], ReplyHeader>;

/// How many first request ids there are for clients to choose from.
const FIRST_IDS: u64 = 1024;

/// Asks a planner.
#[derive(Debug)]
pub struct Client {
    port: Port,
    ringer: Notifier<ipc::Service>,
    wake: ports::Bell,
    /// None where this client polls.
    bell: Option<Listener<ipc::Service>>,
    how: Wait,
    nonce: u64,
    sequence: Cell<u64>,
    cells: RefCell<Vec<u64>>,
    node: Node<ipc::Service>,
    _tidy: Tidy,
}

impl Client {
    /// Connects to the planner of a domain.
    pub fn connect(domain: &Domain, how: Wait) -> Result<Self, ConnectError> {
        let nonce = getrandom::u64().map_err(|error| ConnectError::Random(error.to_string()))?;
        Self::connect_as(domain, how, nonce)
    }

    fn connect_as(domain: &Domain, how: Wait, nonce: u64) -> Result<Self, ConnectError> {
        let node = domain.join("client")?;
        let absent = |cause| ConnectError::NoPlanner { domain: domain.clone(), cause };
        let full = |cause| ConnectError::Full { domain: domain.clone(), cause };
        let plan = ports::open_plan(&node).map_err(|error| match error {
            RequestResponseOpenError::IncompatibleRequestOrResponseType => {
                ConnectError::OtherLayout { domain: domain.clone(), layout: topic::layout_hash() }
            }
            error => absent(ports::said(error)),
        })?;
        let wake = ports::open_wake(&node).map_err(absent)?;
        let answered = ports::open_answered(&node).map_err(absent)?;
        if plan.dynamic_config().number_of_servers() == 0 {
            return Err(absent("a planner was there, but has left".to_owned()));
        }
        let port = plan
            .client_builder()
            .initial_max_slice_len(1024)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .create()
            .map_err(|error| full(ports::said(error)))?;
        // What is left to do for an earlier client in this place can still reach ours: the
        // replies, and the end of the request. Both go by the request's id, which starts at 0
        // in every client. `accept` drops the replies by their key; different ids keep
        // most of both from coming at all.
        for _ in 0..nonce % FIRST_IDS {
            drop(port.loan_slice_uninit(0));
        }
        let ringer = wake.notifier_builder().create().map_err(|error| full(ports::said(error)))?;
        let name = PortName::new(&format!("{nonce:016x}")).expect("16 digits are a name");
        let bell = match how {
            Wait::Poll => None,
            Wait::Event | Wait::Hybrid => Some(
                answered
                    .listener_builder()
                    .name(&name)
                    .create()
                    .map_err(|error| full(ports::said(error)))?,
            ),
        };
        Ok(Self {
            port,
            ringer,
            wake,
            bell,
            how,
            nonce,
            sequence: Cell::new(0),
            cells: RefCell::default(),
            node,
            _tidy: Tidy(domain.clone()),
        })
    }

    /// Sends a request. As many as the planner allows can be open at a time.
    pub fn send(&self, scene: &SceneRequest) -> Result<Pending<'_>, CallError> {
        let mut cells = self.cells.borrow_mut();
        cells.clear();
        let header = convert::write_scene(scene, self.next_key(), crate::now_ns(), &mut cells)
            .map_err(CallError::Scene)?;
        self.send_cells(header, &cells)
    }

    /// Sends memory as it is, for clients that write requests themselves: the key and the
    /// wish to be woken are filled in.
    pub fn send_cells(
        &self,
        mut header: schemas::wire::RequestHeader,
        cells: &[u64],
    ) -> Result<Pending<'_>, CallError> {
        let key = self.next_key();
        self.sequence.set(key.sequence + 1);
        (header.client, header.sequence) = (key.client, key.sequence);
        header.wake = self.bell.is_some().into();
        let mut request = self
            .port
            .loan_slice_uninit(cells.len())
            .map_err(|error| CallError::Send(ports::said(error)))?;
        request.user_header_mut().0 = header;
        let awaited = request
            .write_from_slice(cells)
            .send()
            .map_err(|error| CallError::Send(ports::said(error)))?;
        if self.wake.dynamic_config().number_of_listeners() > 0
            && let Err(error) = self.ringer.notify()
        {
            // The request is sent; a sleeping planner looks for itself before long.
            tracing::debug!(?error, "could not ring");
        }
        Ok(Pending { awaited, key, client: self })
    }

    fn next_key(&self) -> RequestKey {
        RequestKey { client: self.nonce, sequence: self.sequence.get() }
    }

    /// Sends a request and waits for the whole reply. When the planner dies, waits for
    /// another and asks again.
    pub fn call(&self, scene: &SceneRequest, limit: Duration) -> Result<Reply, CallError> {
        let begin = Instant::now();
        let until = begin + limit;
        loop {
            let mut pending = self.send(scene)?;
            match pending.wait(until) {
                Err(CallError::PlannerGone) if Instant::now() < until => {
                    drop(pending);
                    self.node.try_cleanup_dead_nodes();
                    std::thread::sleep(Duration::from_millis(20));
                }
                Err(CallError::TimedOut { .. }) => {
                    return Err(CallError::TimedOut { waited: begin.elapsed(), limit });
                }
                done => return done,
            }
            if wait::terminated() {
                return Err(CallError::Interrupted);
            }
        }
    }
}

/// A request that is being answered. Dropped, the planner stops sending.
#[derive(Debug)]
pub struct Pending<'a> {
    awaited: Awaited,
    key: RequestKey,
    client: &'a Client,
}

impl Pending<'_> {
    /// The request's key.
    pub fn key(&self) -> RequestKey {
        self.key
    }

    /// The next part of the reply as it lies in shared memory, if one is there: `take`
    /// sees its header and payload. Parts of other requests are dropped.
    pub fn receive<T>(
        &self,
        mut take: impl FnMut(&schemas::wire::ReplyHeader, &[u64]) -> T,
    ) -> Result<Option<T>, CallError> {
        // Asked before looking: only "nothing, and was not connected" means gone.
        let connected = self.awaited.is_connected();
        loop {
            match self.awaited.receive() {
                Ok(Some(part)) => {
                    let header = &part.user_header().0;
                    if self.accept(header) {
                        return Ok(Some(take(header, part.payload())));
                    }
                    tracing::debug!(
                        client = header.client,
                        sequence = header.sequence,
                        "dropped a reply to somebody else"
                    );
                }
                Ok(None) if connected => return Ok(None),
                Ok(None) => return Err(CallError::PlannerGone),
                Err(error) => return Err(CallError::Receive(ports::said(error))),
            }
        }
    }

    /// Whether a part answers this request.
    fn accept(&self, header: &schemas::wire::ReplyHeader) -> bool {
        self.key == RequestKey { client: header.client, sequence: header.sequence }
    }

    /// Waits for the next part, at most until `until`.
    pub fn wait_part(&mut self, until: Instant) -> Result<ReplyPart, CallError> {
        let begin = Instant::now();
        loop {
            if let Some(part) = self.receive(convert::read_part)? {
                return Ok(part?);
            }
            let now = Instant::now();
            if now >= until {
                // A planner that was killed counts as connected until it is cleared away.
                self.client.node.try_cleanup_dead_nodes();
                if !self.awaited.is_connected() {
                    return Err(CallError::PlannerGone);
                }
                let waited = now - begin;
                return Err(CallError::TimedOut { waited, limit: until - begin });
            }
            let Client { bell, how, .. } = self.client;
            let woken =
                wait::wait(*how, bell.as_ref(), Some(until), || self.awaited.has_response());
            if woken == Woken::Terminate {
                return Err(CallError::Interrupted);
            }
            if now.elapsed() >= wait::NET {
                self.client.node.try_cleanup_dead_nodes();
            }
        }
    }

    /// Waits for the whole reply, at most until `until`.
    pub fn wait(&mut self, until: Instant) -> Result<Reply, CallError> {
        let mut assembler = ReplyAssembler::default();
        loop {
            if let Some(reply) = assembler.push(self.wait_part(until)?)? {
                return Ok(reply);
            }
        }
    }
}

#[cfg(test)]
mod tests;
