//! A client's side: ask, and take the reply part by part.

use std::cell::{Cell, RefCell};
use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::RequestSendError;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{AllocationStrategy, CallbackProgression, PortFactory, PortName, ipc};
use schemas::convert;
use schemas::message::{
    ErrorCode, Refusal, Reply, ReplyAssembler, ReplyPart, RequestKey, SceneRequest,
};
use schemas::wire;

use crate::cause::Cause;
use crate::clock::now_ns;
use crate::connect;
use crate::domain::Domain;
use crate::error::{CallError, ConnectError};
use crate::headers::{Current, ReplyHeader, RequestHeader, UserHeader};
use crate::member::Member;
use crate::memory;
use crate::ports;
use crate::presence::Visitor;
use crate::process::Process;
use crate::wait::{self, Wait, Woken};

type Port = iceoryx2::port::client::Client<ipc::Service, [u64], RequestHeader, [u64], ReplyHeader>;
type Awaited = PendingResponse<ipc::Service, [u64], RequestHeader, [u64], ReplyHeader>;

/// How long a planner that ends takes from its last reply to its end, mostly.
const ENDING: Duration = Duration::from_millis(50);

/// How long a client that leaves waits until its last requests are taken.
const FAREWELL: Duration = Duration::from_secs(1);

/// How long the places of clients that died stay taken while a planner lives, mostly.
const CLEARED: Duration = Duration::from_secs(3);

/// The longest request that every client has memory for from the start, cells.
pub(crate) const SURE: usize = 1024;

/// How often a client that waits for a planner looks for one.
const LOOK: Duration = Duration::from_millis(20);

/// The number of first request ids that clients choose from.
const FIRST_IDS: u64 = 1024;

/// Asks a planner.
///
/// ```no_run
/// use std::time::Duration;
///
/// use bus::{Client, Domain, Wait};
/// use schemas::json;
///
/// let scene = std::fs::read_to_string("recordings/scenes/driving.json")?;
/// let scene = json::read_scene(&scene).map_err(|unreadable| unreadable.refusal.message)?;
/// let client = Client::connect(&Domain::default(), Wait::Hybrid)?;
/// let reply = client.call(&scene, Duration::from_secs(10))?;
/// println!("{}", json::reply_to_json(&reply));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Client {
    port: Port,
    /// Requests that the planner lets it have open.
    most_open: usize,
    ringer: Notifier<ipc::Service>,
    wake: ports::Bell,
    /// None if this client polls.
    bell: Option<Listener<ipc::Service>>,
    how: Wait,
    nonce: u64,
    sequence: Cell<u64>,
    cells: RefCell<Vec<u64>>,
    /// Whether a request was dropped that the planner may not have taken yet.
    dropped: Cell<bool>,
    plan: ports::Plan<Current>,
    /// The planner's process, if it can be watched.
    planner: RefCell<Option<Process>>,
    node: Member,
}

impl Client {
    /// Connects to the planner of a domain.
    pub fn connect(domain: &Domain, how: Wait) -> Result<Self, ConnectError> {
        let nonce = getrandom::u64().map_err(|error| ConnectError::Random(error.to_string()))?;
        let until = Instant::now() + CLEARED;
        // Who has a place may have died, and may be cleared away between two looks.
        let mut had_dead = true;
        loop {
            match Self::connect_as(domain, how, nonce) {
                Err(ConnectError::Full { .. }) if had_dead && Instant::now() < until => {
                    had_dead = domain.has_dead();
                    std::thread::sleep(LOOK);
                }
                done => return done,
            }
        }
    }

    /// The same, as soon as a planner has started, which may take so long. A signal that asks to
    /// end ends the waiting.
    pub fn connect_within(
        domain: &Domain,
        how: Wait,
        limit: Duration,
    ) -> Result<Self, ConnectError> {
        let until = Instant::now() + limit;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match Self::connect(domain, how) {
                Err(ConnectError::NoPlanner { .. }) if !left.is_zero() && !wait::terminated() => {
                    std::thread::sleep(left.min(LOOK));
                }
                done => return done,
            }
        }
    }

    fn connect_as(domain: &Domain, how: Wait, nonce: u64) -> Result<Self, ConnectError> {
        let node = domain.join(Visitor::CLIENT)?;
        let failed = |cause| connect::failed(&node, domain, connect::REQUESTS, cause);
        let plan = ports::open_plan::<Current>(&node).map_err(failed)?;
        let wake = ports::open_wake(&node).map_err(failed)?;
        let answered = ports::open_answered(&node).map_err(failed)?;
        if plan.dynamic_config().number_of_servers() == 0 {
            return Err(failed(Cause::Absent));
        }
        let (most_clients, most_open) = {
            let settings = plan.static_config();
            (settings.max_clients(), settings.max_active_requests_per_client())
        };
        let full = |cause| match cause {
            Cause::Full => connect::full(domain, connect::CLIENTS, most_clients),
            cause => failed(cause),
        };
        memory::check_room(memory::CONNECTION + memory::OPEN_REQUEST * most_open as u64)?;
        let port = plan
            .client_builder()
            .initial_max_slice_len(SURE)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .create()
            .map_err(|error| full(error.into()))?;
        node.take_memory_of(port.id().value())?;
        // Replies to an earlier client in this place, and the end of its request, can still
        // reach this one: both go by the request's id, which starts at 0 in every client.
        // `accept` drops the replies by their key; different ids keep most of both away.
        for _ in 0..nonce % FIRST_IDS {
            drop(port.loan_slice_uninit(0));
        }
        let ringer = wake.notifier_builder().create().map_err(|error| full(error.into()))?;
        let name = PortName::new(&format!("{nonce:016x}")).expect("16 digits are a name");
        let bell = match how {
            Wait::Poll => None,
            Wait::Event | Wait::Hybrid => Some(
                answered
                    .listener_builder()
                    .name(&name)
                    .create()
                    .map_err(|error| full(error.into()))?,
            ),
        };
        Ok(Self {
            port,
            most_open,
            ringer,
            wake,
            bell,
            how,
            nonce,
            sequence: Cell::new(0),
            cells: RefCell::default(),
            dropped: Cell::new(false),
            planner: RefCell::new(planner_of(&plan)),
            plan,
            node,
        })
    }

    /// Sends a request. The planner limits how many can be open at a time.
    pub fn send(&self, scene: &SceneRequest) -> Result<Pending<'_>, CallError> {
        let mut cells = self.cells.borrow_mut();
        cells.clear();
        let header = convert::write_scene(scene, self.next_key(), now_ns(), &mut cells)
            .map_err(CallError::Scene)?;
        self.send_cells(header, &cells)
    }

    /// Sends memory as it is, for clients that write requests themselves; fills in the key
    /// and whether to wake this client.
    pub fn send_cells(
        &self,
        mut header: wire::RequestHeader,
        cells: &[u64],
    ) -> Result<Pending<'_>, CallError> {
        let key = self.next_key();
        self.sequence.set(key.sequence + 1);
        (header.client, header.sequence) = (key.client, key.sequence);
        header.wake = self.bell.is_some().into();
        let is_large = cells.len() > SURE;
        if is_large {
            memory::check_room(memory::MANAGEMENT + size_of_val(cells) as u64)?;
        }
        let mut request = self
            .port
            .loan_slice_uninit(cells.len())
            .map_err(|error| CallError::Send(error.into()))?;
        if is_large {
            memory::take_slice(request.payload_mut())?;
        }
        request.user_header_mut().set(header);
        let awaited = request.write_from_slice(cells).send().map_err(|error| match error {
            RequestSendError::ExceedsMaxActiveRequests => {
                CallError::TooManyRequests { most: self.most_open }
            }
            error => CallError::Send(error.into()),
        })?;
        self.ring();
        Ok(Pending { awaited, key, client: self, has_last: Cell::new(false) })
    }

    /// Wakes the planner if it sleeps.
    fn ring(&self) {
        if self.wake.dynamic_config().number_of_listeners() > 0
            && let Err(error) = self.ringer.notify()
        {
            // The request is sent; a sleeping planner looks before long.
            tracing::debug!(?error, "can't ring");
        }
    }

    /// Why a reply ends before it is whole.
    fn lost(&self) -> CallError {
        let is_gone = || {
            let has_ended = self.planner.borrow().as_ref().is_some_and(Process::has_ended);
            has_ended || self.plan.dynamic_config().number_of_servers() == 0
        };
        // One that ends gives up what it has first.
        let until = Instant::now() + ENDING;
        while !is_gone() {
            if Instant::now() >= until {
                return CallError::GivenUp;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        CallError::PlannerLost
    }

    fn next_key(&self) -> RequestKey {
        RequestKey { client: self.nonce, sequence: self.sequence.get() }
    }

    /// Sends a request and waits for the whole reply.
    ///
    /// A request whose planner was lost is not sent again: it may be the cause.
    pub fn call(&self, scene: &SceneRequest, limit: Duration) -> Result<Reply, CallError> {
        let (begin, until) = (Instant::now(), Instant::now() + limit);
        loop {
            let mut pending = self.send(scene)?;
            let mut parts = 0;
            match pending.wait_for_all(until, &mut parts) {
                // The end of an earlier client's request can end this one: nobody saw it.
                Err(CallError::GivenUp) if parts == 0 && Instant::now() < until => {}
                Err(CallError::TimedOut { .. }) => {
                    return Err(CallError::TimedOut { waited: begin.elapsed(), limit });
                }
                done => return done,
            }
        }
    }

    /// The same for a scene whose free space has its name beside it
    /// ([`FreeSpace::digest`](schemas::message::FreeSpace::digest)): the name is sent alone, and the
    /// free space itself only to a planner that does not know it.
    pub fn call_named(&self, scene: &SceneRequest, limit: Duration) -> Result<Reply, CallError> {
        let begin = Instant::now();
        let reply = self.call(&scene.with_name_alone(), limit)?;
        let is_unknown = |refusal: &Refusal| refusal.code == ErrorCode::UnknownFreeSpace;
        if !reply.answers.as_ref().is_err_and(is_unknown) {
            return Ok(reply);
        }
        self.call(scene, limit.saturating_sub(begin.elapsed()))
    }
}

impl Drop for Client {
    /// Leaves when the planner has taken what was sent and dropped, if it does so soon. Requests
    /// of a client that is gone keep its memory mapped in the planner for good, by a fault of
    /// iceoryx2 0.10.
    fn drop(&mut self) {
        if !self.dropped.get() {
            return;
        }
        let Ok(mut request) = self.port.loan_slice_uninit(0) else { return };
        let header = wire::RequestHeader { version: wire::FAREWELL, ..Default::default() };
        request.user_header_mut().set(header);
        let Ok(farewell) = request.write_from_slice(&[]).send() else { return };
        self.ring();
        let until = Instant::now() + FAREWELL;
        let has_ended = || self.planner.borrow().as_ref().is_some_and(Process::has_ended);
        while farewell.is_connected() && Instant::now() < until && !has_ended() {
            std::thread::sleep(Duration::from_micros(200));
        }
    }
}

/// The process of the planner that serves these requests.
fn planner_of(plan: &ports::Plan<Current>) -> Option<Process> {
    let mut node = None;
    plan.dynamic_config().list_servers(|server| {
        node = Some(server.node_id);
        CallbackProgression::Continue
    });
    Process::of(node?)
}

/// A request being answered. Dropping it stops the planner from planning and sending.
#[derive(Debug)]
pub struct Pending<'a> {
    awaited: Awaited,
    key: RequestKey,
    client: &'a Client,
    /// Whether the last part of the reply has come.
    has_last: Cell<bool>,
}

impl Pending<'_> {
    /// The request's key.
    pub fn key(&self) -> RequestKey {
        self.key
    }

    /// The next part of the reply where it lies in shared memory, if one is there: `take`
    /// sees its header and payload. Parts of other replies are dropped.
    pub fn receive<T>(
        &self,
        mut take: impl FnMut(&wire::ReplyHeader, &[u64]) -> T,
    ) -> Result<Option<T>, CallError> {
        // Ask before looking: only "nothing there, and was not connected" means gone.
        let connected = self.awaited.is_connected();
        loop {
            match self.awaited.receive() {
                Ok(Some(part)) => {
                    let header = part.user_header().plain();
                    if self.accept(header) {
                        self.has_last.set(header.last != 0);
                        return Ok(Some(take(header, part.payload())));
                    }
                    tracing::debug!(
                        client = header.client,
                        sequence = header.sequence,
                        "dropped a reply to another client"
                    );
                }
                Ok(None) if connected => return Ok(None),
                Ok(None) => return Err(self.client.lost()),
                Err(error) => return Err(CallError::Receive(error.into())),
            }
        }
    }

    /// Whether a part answers this request.
    fn accept(&self, header: &wire::ReplyHeader) -> bool {
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
                self.client.node.sweep();
                if !self.awaited.is_connected() {
                    return Err(self.client.lost());
                }
                let waited = now - begin;
                return Err(CallError::TimedOut { waited, limit: until - begin });
            }
            let Client { bell, how, planner, plan, node, .. } = self.client;
            let process = planner.borrow();
            let others = process.iter().map(AsFd::as_fd);
            let has_response = || self.awaited.has_response();
            let woken = wait::wait(*how, (bell.as_ref(), others), Some(until), has_response);
            if woken == Woken::Terminate {
                return Err(CallError::Interrupted);
            }
            if has_response() {
                continue;
            }
            let has_ended = process.as_ref().is_some_and(Process::has_ended);
            drop(process);
            if has_ended || now.elapsed() >= wait::NET {
                node.sweep();
            }
            if has_ended && self.awaited.is_connected() {
                // Another serves this request, or somebody else is clearing the dead one away.
                planner.replace(planner_of(plan));
                std::thread::sleep(Duration::from_millis(1));
            }
        }
    }

    /// Waits for the whole reply, at most until `until`.
    pub fn wait(&mut self, until: Instant) -> Result<Reply, CallError> {
        self.wait_for_all(until, &mut 0)
    }

    /// The same, and counts the parts.
    fn wait_for_all(&mut self, until: Instant, parts: &mut usize) -> Result<Reply, CallError> {
        let mut assembler = ReplyAssembler::default();
        loop {
            let part = self.wait_part(until)?;
            *parts += 1;
            if let Some(reply) = assembler.push(part)? {
                return Ok(reply);
            }
        }
    }
}

impl Drop for Pending<'_> {
    fn drop(&mut self) {
        // The next request in this place needs the room.
        while let Ok(Some(_)) = self.awaited.receive() {}
        if !self.has_last.get() {
            self.client.dropped.set(true);
        }
    }
}

#[cfg(test)]
mod tests;
