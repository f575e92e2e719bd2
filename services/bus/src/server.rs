//! The planner's side: requests in, replies out, part by part.

use std::time::{Duration, Instant};

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::{ListenerKey, Notifier};
use iceoryx2::port::{BackpressureAction, SendError};
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, CallbackProgression, Node, ipc};
use iceoryx2::service::port_factory::server::ServerCreateError;
use schemas::convert::{CellWriter, PartSink};
use schemas::wire;
use thiserror::Error;

use crate::domain::{Domain, DomainError};
use crate::headers::{ReplyHeader, RequestHeader};
use crate::ports;
use crate::tap::TapWriter;
use crate::wait::{self, Wait, Woken};

/// Sizes of the planner's side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ServerOptions {
    /// Clients at a time.
    pub max_clients: usize,
    /// Requests that one client can have open.
    pub requests_per_client: usize,
    /// Recorders at a time.
    pub max_recorders: usize,
    /// Messages that wait for a slow recorder before the oldest are lost.
    pub tap_buffer: usize,
    /// How the planner waits for requests.
    pub wait: Wait,
    /// How replies deal with slow clients.
    pub reply: ReplyOptions,
}

impl Default for ServerOptions {
    fn default() -> Self {
        Self {
            max_clients: 32,
            requests_per_client: 4,
            max_recorders: 2,
            tap_buffer: 1024,
            wait: Wait::Hybrid,
            reply: ReplyOptions::default(),
        }
    }
}

/// How replies deal with slow clients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReplyOptions {
    /// How long a part waits for a client whose buffer is full before the rest of
    /// that reply is given up. It bounds how long a client that is frozen or dead
    /// can hold up the others.
    pub patience: Duration,
}

impl Default for ReplyOptions {
    fn default() -> Self {
        Self { patience: Duration::from_millis(100) }
    }
}

/// Why the planner's side can't be opened.
#[derive(Debug, Error)]
pub enum OpenError {
    /// The domain can't be joined.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// Somebody else answers requests there.
    #[error("another planner serves domain {0}")]
    AnotherPlanner(Domain),
    /// Shared memory is too small: it would only be noticed as a SIGBUS.
    #[error(
        "/dev/shm has {free} bytes free, but these settings can come to need {needs}; \
         lower max_clients, requests_per_client, max_recorders or tap_buffer, or enlarge it"
    )]
    SharedMemory {
        /// Bytes needed in the worst case.
        needs: u64,
        /// Bytes free.
        free: u64,
    },
    /// A service can't be opened; other settings or another version may run there.
    #[error("can't open {what} in domain {domain}: {cause}")]
    Service {
        /// Which port.
        what: &'static str,
        /// The domain.
        domain: Domain,
        /// What iceoryx2 says.
        cause: String,
    },
}

type Port = iceoryx2::port::server::Server<ipc::Service, [u64], RequestHeader, [u64], ReplyHeader>;
type Active = ActiveRequest<ipc::Service, [u64], RequestHeader, [u64], ReplyHeader>;

/// Takes requests and answers them.
///
/// Dropping it leaves the domain; fields are dropped in this order.
#[derive(Debug)]
pub struct Server {
    port: Port,
    /// None where the planner polls.
    bell: Option<Listener<ipc::Service>>,
    ringer: Ringer,
    tap: TapWriter,
    /// A service without a port is gone when its last factory is, and clients open it.
    _wake: ports::Bell,
    node: Node<ipc::Service>,
    how: Wait,
    patience: Duration,
    /// When it was last looked for peers that died.
    swept: Instant,
    _tidy: Tidy,
}

/// How often an idle planner looks for peers that died: about 0.1 ms for each that lives.
const SWEEP: Duration = Duration::from_secs(1);

/// Tidies up the domain when everything else is gone.
#[derive(Debug)]
pub(crate) struct Tidy(pub(crate) Domain);

impl Drop for Tidy {
    fn drop(&mut self) {
        self.0.tidy();
    }
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
        let failed = |what| move |cause| OpenError::Service { what, domain: domain.clone(), cause };
        let plan = ports::create_plan(&node, options).map_err(failed("the request port"))?;
        let wake = ports::create_wake(&node, options).map_err(failed("the wake-up bell"))?;
        let answered = ports::create_answered(&node, options).map_err(failed("the reply bell"))?;
        let tap = ports::create_tap(&node, options).map_err(failed("the tap"))?;

        let patience = options.reply.patience;
        let port = plan
            .server_builder()
            .initial_max_slice_len(wire::PART_CELLS)
            .allocation_strategy(AllocationStrategy::Static)
            .max_loaned_responses_per_request(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .set_backpressure_handler(move |waiting| {
                if waiting.elapsed_time < patience {
                    BackpressureAction::Retry
                } else {
                    BackpressureAction::DiscardDataAndFail
                }
            })
            .create();
        let port = match port {
            Ok(port) => port,
            Err(ServerCreateError::ExceedsMaxSupportedServers) => {
                return Err(OpenError::AnotherPlanner(domain.clone()));
            }
            Err(error) => return Err(failed("the request port")(ports::said(error))),
        };
        let bell = match options.wait {
            Wait::Poll => None,
            Wait::Event | Wait::Hybrid => Some(
                wake.listener_builder()
                    .create()
                    .map_err(|error| failed("the wake-up bell")(ports::said(error)))?,
            ),
        };
        let ringer = answered
            .notifier_builder()
            .create()
            .map_err(|error| failed("the reply bell")(ports::said(error)))?;
        let ringer = Ringer { port: ringer, known: Vec::with_capacity(options.max_clients) };
        let tap = TapWriter::create(tap).map_err(failed("the tap"))?;
        Ok(Self {
            port,
            bell,
            ringer,
            tap,
            _wake: wake,
            node,
            how: options.wait,
            patience,
            swept: Instant::now(),
            _tidy: Tidy(domain.clone()),
        })
    }

    /// The next request, if one waits. It goes over the tap at once.
    pub fn receive(&mut self) -> Option<Incoming<'_>> {
        match self.port.receive() {
            Ok(Some(active)) => {
                self.tap.request(&active.user_header().0, active.payload());
                Some(Incoming {
                    active,
                    ringer: &mut self.ringer,
                    tap: &mut self.tap,
                    patience: self.patience,
                })
            }
            Ok(None) => None,
            Err(error) => {
                // A client that died half connected; the others go on.
                tracing::warn!(?error, "could not receive");
                None
            }
        }
    }

    /// Waits for a request or a signal to end, at most [`wait::NET`].
    pub fn wait(&mut self) -> Woken {
        let port = &self.port;
        let asked = || port.has_requests().unwrap_or(true);
        let woken = wait::wait(self.how, self.bell.as_ref(), None, asked);
        self.tap.heartbeat();
        // What died keeps its memory, and a recorder the tap busy, until somebody clears it away.
        if self.swept.elapsed() >= SWEEP && !asked() {
            self.node.try_cleanup_dead_nodes();
            self.swept = Instant::now();
        }
        woken
    }

    /// Whether SIGINT or SIGTERM has asked to end; for use under unbroken load.
    pub fn terminated(&self) -> bool {
        wait::terminated()
    }
}

/// A request that waits for its answer.
#[derive(Debug)]
pub struct Incoming<'a> {
    active: Active,
    ringer: &'a mut Ringer,
    tap: &'a mut TapWriter,
    patience: Duration,
}

impl Incoming<'_> {
    /// Copies the request out of shared memory, where its sender could still change it.
    pub fn copy(&self, cells: &mut Vec<u64>) -> wire::RequestHeader {
        cells.clear();
        cells.extend_from_slice(self.active.payload());
        self.active.user_header().0
    }

    /// The request's header.
    pub fn header(&self) -> wire::RequestHeader {
        self.active.user_header().0
    }

    /// How many cells the request's payload has.
    pub fn cells(&self) -> usize {
        self.active.payload().len()
    }

    /// Where the answer goes.
    pub fn reply(&mut self) -> ReplySink<'_> {
        let header = &self.active.user_header().0;
        ReplySink {
            wake: (header.wake != 0).then_some(header.client),
            active: &self.active,
            ringer: self.ringer,
            tap: self.tap,
            patience: self.patience,
        }
    }
}

/// Streams a reply into shared memory.
#[derive(Debug)]
pub struct ReplySink<'a> {
    active: &'a Active,
    ringer: &'a mut Ringer,
    tap: &'a mut TapWriter,
    patience: Duration,
    wake: Option<u64>,
}

/// Why the rest of a reply can't be sent. Nobody but its client is concerned.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ReplyError {
    /// The client has dropped its request, or left, or another came in its place.
    #[error("the client of the request is gone")]
    Gone,
    /// The client did not take the parts before.
    #[error("the client took no part of its reply for {patience:?}")]
    Slow {
        /// How long was waited.
        patience: Duration,
    },
    /// The bus refused.
    #[error("could not send the reply: {0}")]
    Bus(String),
}

impl PartSink for ReplySink<'_> {
    type Error = ReplyError;

    fn part(
        &mut self,
        header: &wire::ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), ReplyError> {
        // A closed channel takes parts and drops them without a word.
        if !self.active.is_connected() {
            return Err(ReplyError::Gone);
        }
        let bus = |error| ReplyError::Bus(ports::said(error));
        let mut response =
            self.active.loan_slice_uninit(cells).map_err(|error| bus(error.into()))?;
        let header = wire::ReplyHeader { sent_ns: crate::now_ns(), ..*header };
        response.user_header_mut().0 = header;
        let payload = response.payload_mut();
        #[expect(unsafe_code, reason = "loaned memory is written where it will be read")]
        // SAFETY: the memory is mapped from the operating system, which hands it out
        // initialised, and every bit pattern is a u64. All of it is written below.
        let payload = unsafe { &mut *(payload as *mut [_] as *mut [u64]) };
        let mut writer = CellWriter::new(payload);
        fill(&mut writer);
        assert_eq!(writer.filled(), cells, "a part is written in full");
        #[expect(unsafe_code, reason = "loaned memory is written where it will be read")]
        // SAFETY: all cells are written, as just checked.
        let response = unsafe { response.assume_init() };
        self.tap.reply(&header, response.payload());
        response.send().map_err(|error| match error {
            SendError::UnableToDeliver => ReplyError::Slow { patience: self.patience },
            error => bus(error),
        })?;
        if let Some(client) = self.wake
            && !self.ringer.ring(client)
        {
            self.wake = None;
        }
        Ok(())
    }
}

/// Rings the bells of clients: a client's listener has its nonce for a name.
#[derive(Debug)]
struct Ringer {
    port: Notifier<ipc::Service>,
    /// Bells rung before. To look for one is slow, and iceoryx2 logs a long warning for
    /// every bell of a client that was killed on the way.
    known: Vec<(u64, ListenerKey)>,
}

impl Ringer {
    /// Whether there was a bell to ring.
    fn ring(&mut self, client: u64) -> bool {
        if let Some(at) = self.known.iter().position(|(known, _)| *known == client) {
            if self.port.notify_single_listener(&self.known[at].1).is_ok() {
                return true;
            }
            self.known.swap_remove(at);
        }
        let mut found = None;
        self.port.for_each_listener(|bell, listener| {
            if u64::from_str_radix(listener.listener_name.as_str(), 16) != Ok(client) {
                return CallbackProgression::Continue;
            }
            found = bell.notify().is_ok().then(|| bell.listener_key());
            CallbackProgression::Stop
        });
        let Some(key) = found else {
            tracing::debug!(client, "could not ring");
            return false;
        };
        // Who has left is in the list until then.
        if self.known.len() == self.known.capacity() {
            self.known.clear();
        }
        self.known.push((client, key));
        true
    }
}
