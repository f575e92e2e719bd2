//! A client's side: ask, and take the reply part by part.

use std::time::{Duration, Instant};

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{AllocationStrategy, Node, PortFactory, PortName, ipc};
use schemas::convert::{self, Malformed};
use schemas::message::{
    AssembleError, Refusal, Reply, ReplyAssembler, ReplyPart, RequestKey, SceneRequest,
};
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
    /// The planner died or left.
    #[error("the planner is gone")]
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

/// Asks a planner.
#[derive(Debug)]
pub struct Client {
    port: Port,
    ringer: Notifier<ipc::Service>,
    wake: ports::Bell,
    /// None where this client polls.
    bell: Option<Listener<ipc::Service>>,
    how: Wait,
    key: RequestKey,
    cells: Vec<u64>,
    node: Node<ipc::Service>,
    _tidy: Tidy,
}

impl Client {
    /// Connects to the planner of a domain.
    pub fn connect(domain: &Domain, how: Wait) -> Result<Self, ConnectError> {
        let node = domain.join("client")?;
        let absent = |cause| ConnectError::NoPlanner { domain: domain.clone(), cause };
        let full = |cause| ConnectError::Full { domain: domain.clone(), cause };
        let plan = ports::open_plan(&node).map_err(absent)?;
        let wake = ports::open_wake(&node).map_err(absent)?;
        let answered = ports::open_answered(&node).map_err(absent)?;
        // What died keeps its places until somebody clears it away.
        node.try_cleanup_dead_nodes();
        if plan.dynamic_config().number_of_servers() == 0 {
            return Err(absent("a planner was there, but has left".to_owned()));
        }
        let nonce = getrandom::u64().map_err(|error| full(error.to_string()))?;
        let port = plan
            .client_builder()
            .initial_max_slice_len(1024)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .create()
            .map_err(|error| full(ports::said(error)))?;
        // Replies to an earlier client in this place may still come. Request ids start
        // at 0 in every client, so those replies would look like ours; `accept` drops them
        // by their key, and different ids keep most of them from coming at all.
        for _ in 0..nonce % 256 {
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
            key: RequestKey { client: nonce, sequence: 0 },
            cells: Vec::new(),
            node,
            _tidy: Tidy(domain.clone()),
        })
    }

    /// Sends a request.
    pub fn send(&mut self, scene: &SceneRequest) -> Result<Pending<'_>, CallError> {
        self.cells.clear();
        let header = convert::write_scene(scene, self.key, crate::now_ns(), &mut self.cells)
            .map_err(CallError::Scene)?;
        let cells = std::mem::take(&mut self.cells);
        let sent = self.send_raw(header, &cells);
        self.cells = cells;
        let (awaited, key) = sent?;
        Ok(Pending { awaited, key, client: self })
    }

    /// Sends memory as it is, for clients that write requests themselves: the key and the
    /// wish to be woken are filled in.
    pub fn send_cells(
        &mut self,
        header: schemas::wire::RequestHeader,
        cells: &[u64],
    ) -> Result<Pending<'_>, CallError> {
        let (awaited, key) = self.send_raw(header, cells)?;
        Ok(Pending { awaited, key, client: self })
    }

    fn send_raw(
        &mut self,
        mut header: schemas::wire::RequestHeader,
        cells: &[u64],
    ) -> Result<(Awaited, RequestKey), CallError> {
        let key = self.key;
        self.key.sequence += 1;
        (header.client, header.sequence) = (key.client, key.sequence);
        header.wake = self.bell.is_some().into();
        let failed = |error: &dyn std::fmt::Debug| CallError::Send(ports::said(error));
        let mut request =
            self.port.loan_slice_uninit(cells.len()).map_err(|error| failed(&error))?;
        request.user_header_mut().0 = header;
        let awaited = request.write_from_slice(cells).send().map_err(|error| failed(&error))?;
        if self.wake.dynamic_config().number_of_listeners() > 0 {
            self.ringer.notify().map_err(|error| failed(&error))?;
        }
        Ok((awaited, key))
    }

    /// Sends a request and waits for the whole reply. When the planner dies, waits for
    /// another and asks again.
    pub fn call(&mut self, scene: &SceneRequest, limit: Duration) -> Result<Reply, CallError> {
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
            if wait::terminated(&self.node) {
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
                Err(error) => return Err(CallError::Send(ports::said(error))),
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
            let Client { node, bell, how, .. } = self.client;
            let woken =
                wait::wait(*how, node, bell.as_ref(), Some(until), || self.awaited.has_response());
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
