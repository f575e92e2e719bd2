//! A client's side: ask, and take the reply part by part.

mod loan;
mod pending;

pub use loan::Loan;
pub use pending::Pending;

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use iceoryx2::port::client::RequestSendError;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{
    AllocationStrategy, CallbackProgression, PortFactory, PortName, ipc_threadsafe,
};
use schemas::convert;
use schemas::message::{ErrorCode, Refusal, Reply, RequestKey, SceneRequest};
use schemas::wire;

use crate::cause::Cause;
use crate::clock::now_ns;
use crate::connect;
use crate::domain::Domain;
use crate::error::{CallError, ConnectError};
use crate::fork::OwnedHere;
use crate::headers::{Current, ReplyHeader, RequestHeader, UserHeader};
use crate::member::Member;
use crate::memory;
use crate::ports;
use crate::presence::Visitor;
use crate::process::Process;
use crate::wait::{self, Wait};
use loan::Response;
use pending::Awaited;

/// Clients, and what they lend, may go from thread to thread.
type Shared = ipc_threadsafe::Service;
type Port = iceoryx2::port::client::Client<Shared, [u64], RequestHeader, [u64], ReplyHeader>;

/// How long a planner that ends takes from its last reply to its end, mostly.
const ENDING: Duration = Duration::from_millis(50);

/// How long a planner's ports may be closed while it lives.
const REOPENING: Duration = Duration::from_secs(1);

/// How long a client that leaves waits until its last requests are taken.
const LEAVING: Duration = Duration::from_secs(3);

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
///
/// It can be used by several threads; while one waits for a reply, though, another can miss a
/// wake-up and look up to [`wait::NET`] too late. For speed, give each thread a client of its own.
#[derive(Debug)]
pub struct Client {
    connection: Arc<OwnedHere<Connection>>,
}

/// What a client shares with its requests.
#[derive(Debug)]
struct Connection {
    port: Port,
    /// Requests that the planner lets it have open.
    most_open: usize,
    /// Parts of replies that it can keep.
    most_loans: usize,
    loans: Arc<AtomicUsize>,
    ringer: Notifier<Shared>,
    wake: ports::Bell<Shared>,
    /// None if this client polls.
    bell: Option<Listener<Shared>>,
    how: Wait,
    nonce: u64,
    sequence: AtomicU64,
    cells: Mutex<Vec<u64>>,
    /// Whether a request was dropped that the planner may not have taken yet.
    dropped: AtomicBool,
    plan: ports::Plan<Current, Shared>,
    /// The planner's process, if it can be watched.
    planner: Mutex<Option<Arc<Process>>>,
    node: Arc<OwnedHere<Member<Shared>>>,
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
        let node = domain.join_with::<Shared>(Visitor::CLIENT)?;
        let failed = |cause| connect::failed(&node, domain, connect::REQUESTS, cause);
        let plan = ports::open_plan::<Current, _>(&node).map_err(failed)?;
        let wake = ports::open_wake(&node).map_err(failed)?;
        let answered = ports::open_answered(&node).map_err(failed)?;
        if plan.dynamic_config().number_of_servers() == 0 {
            return Err(failed(Cause::Absent));
        }
        let settings = plan.static_config();
        let (most_clients, most_open) =
            (settings.max_clients(), settings.max_active_requests_per_client());
        let most_loans = ports::kept(settings.max_borrowed_responses_per_pending_response());
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
        let connection = Connection {
            port,
            most_open,
            most_loans,
            loans: Arc::default(),
            ringer,
            wake,
            bell,
            how,
            nonce,
            sequence: AtomicU64::new(0),
            cells: Mutex::default(),
            dropped: AtomicBool::new(false),
            planner: Mutex::new(planner_of(&plan).map(Arc::new)),
            plan,
            node: Arc::new(OwnedHere::new(node)),
        };
        Ok(Self { connection: Arc::new(OwnedHere::new(connection)) })
    }

    /// How many [`Loan`]s this client can keep at a time.
    pub fn most_loans(&self) -> usize {
        self.connection.most_loans
    }

    /// Sends a request. The planner limits how many can be open at a time.
    pub fn send(&self, scene: &SceneRequest) -> Result<Pending, CallError> {
        self.connection.check_here()?;
        let mut cells = lock(&self.connection.cells);
        cells.clear();
        let header = convert::write_scene(scene, RequestKey::default(), now_ns(), &mut cells)
            .map_err(CallError::Scene)?;
        self.send_cells(header, &cells)
    }

    /// Sends memory as it is, for clients that write requests themselves; fills in the key
    /// and whether to wake this client.
    pub fn send_cells(
        &self,
        mut header: wire::RequestHeader,
        cells: &[u64],
    ) -> Result<Pending, CallError> {
        self.connection.check_here()?;
        let Connection { port, bell, nonce, most_open, .. } = &**self.connection;
        let sequence = self.connection.sequence.fetch_add(1, Ordering::Relaxed);
        let key = RequestKey { client: *nonce, sequence };
        (header.client, header.sequence) = (key.client, key.sequence);
        header.wake = bell.is_some().into();
        let is_large = cells.len() > SURE;
        if is_large {
            memory::check_room(memory::MANAGEMENT + size_of_val(cells) as u64)?;
        }
        let mut request =
            port.loan_slice_uninit(cells.len()).map_err(|error| CallError::Send(error.into()))?;
        if is_large {
            memory::take_slice(request.payload_mut())?;
        }
        request.user_header_mut().set(header);
        let awaited = request.write_from_slice(cells).send().map_err(|error| match error {
            RequestSendError::ExceedsMaxActiveRequests => {
                CallError::TooManyRequests { most: *most_open }
            }
            error => CallError::Send(error.into()),
        })?;
        self.connection.ring();
        Ok(Pending::new(awaited, key, &self.connection))
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

impl OwnedHere<Connection> {
    /// Fails in a process forked from the one that connected.
    fn check_here(&self) -> Result<(), CallError> {
        if self.is_copy() { Err(CallError::Forked) } else { Ok(()) }
    }
}

impl Connection {
    /// Wakes the planner if it sleeps.
    fn ring(&self) {
        if self.wake.dynamic_config().number_of_listeners() > 0
            && let Err(error) = self.ringer.notify()
        {
            // The request is sent; a sleeping planner looks before long.
            tracing::debug!(?error, "can't ring");
        }
    }

    fn planner(&self) -> Option<Arc<Process>> {
        lock(&self.planner).clone()
    }

    fn set_planner(&self, planner: Option<Process>) {
        *lock(&self.planner) = planner.map(Arc::new);
    }

    fn has_planner_ended(&self) -> bool {
        self.planner().is_some_and(|planner| planner.has_ended())
    }

    /// A request was dropped before its reply was whole.
    fn note_dropped(&self) {
        self.dropped.store(true, Ordering::Relaxed);
    }

    /// Asks the planner to drop this once it has dropped all that was sent before, if there is room.
    fn say_farewell(&self) -> Option<Awaited> {
        let mut request = self.port.loan_slice_uninit(0).ok()?;
        let header = wire::RequestHeader { version: wire::FAREWELL, ..Default::default() };
        request.user_header_mut().set(header);
        let farewell = request.write_from_slice(&[]).send().ok()?;
        self.ring();
        Some(farewell)
    }

    /// Why a reply ends before it is whole.
    fn lost(&self) -> CallError {
        let begun = Instant::now();
        let mut was_closed = false;
        loop {
            // One that ends gives up what it has first.
            if self.has_planner_ended() {
                return CallError::PlannerLost;
            }
            let is_closed = self.plan.dynamic_config().number_of_servers() == 0;
            // It may be opening its ports anew, and is alive if its process is known.
            let limit = if is_closed && self.planner().is_some() { REOPENING } else { ENDING };
            match is_closed {
                false if was_closed => return CallError::GivenUp,
                _ if begun.elapsed() < limit => {}
                true => return CallError::PlannerLost,
                false => return CallError::GivenUp,
            }
            was_closed = is_closed;
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Drop for Connection {
    /// Leaves when the planner has taken what was sent and dropped, if it does so soon. Requests
    /// of a client that is gone keep its memory mapped in the planner for good, by a fault of
    /// iceoryx2 0.10.
    fn drop(&mut self) {
        if !self.dropped.load(Ordering::Relaxed) {
            return;
        }
        // Another than the last reply came from may serve by now, and have it.
        let planner = planner_of(&self.plan);
        let until = Instant::now() + LEAVING;
        let goes_on = || {
            let has_ended = planner.as_ref().is_some_and(Process::has_ended);
            Instant::now() < until && !has_ended
        };
        // What was dropped takes its place until the planner has seen it.
        let mut farewell = self.say_farewell();
        while farewell.is_none() && goes_on() {
            std::thread::sleep(Duration::from_micros(200));
            farewell = self.say_farewell();
        }
        while farewell.as_ref().is_some_and(Awaited::is_connected) && goes_on() {
            std::thread::sleep(Duration::from_micros(200));
        }
    }
}

/// What is locked here is whole at any time.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The process of the planner that serves these requests.
fn planner_of(plan: &ports::Plan<Current, Shared>) -> Option<Process> {
    let mut node = None;
    plan.dynamic_config().list_servers(|server| {
        node = Some(server.node_id);
        CallbackProgression::Continue
    });
    Process::of(node?)
}

#[cfg(test)]
mod tests;
