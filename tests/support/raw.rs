//! A peer that writes what it likes into its shared memory, by iceoryx2 alone.

use std::ptr::NonNull;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use bus::Domain;
use bytemuck::bytes_of_mut;
use fastrand::Rng;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{
    AllocationStrategy, Config, FilePath, Node, NodeBuilder, SemanticString, ZeroCopySend, ipc,
};
use schemas::convert::write_scene;
use schemas::message::{RequestKey, SceneRequest};
use schemas::{topic, wire};

mod planner;

pub use planner::{Lie, RawPlanner};

macro_rules! header {
    ($name:ident, $plain:ty, $type_name:literal, $hash:expr) => {
        #[derive(Debug, Default, Clone, Copy)]
        #[repr(transparent)]
        struct $name($plain);

        #[expect(unsafe_code, reason = "vouches for plain memory: repr(C), no pointers, Pod")]
        // SAFETY: a transparent wrapper of a `Pod` type that is `repr(C)`.
        unsafe impl ZeroCopySend for $name {
            unsafe fn type_name() -> &'static str {
                static NAME: LazyLock<String> =
                    LazyLock::new(|| format!("clearway::{}#{:016x}", $type_name, $hash));
                &NAME
            }
        }
    };
}

header!(Request, wire::RequestHeader, "RequestHeader", wire::layout_hash());
header!(Reply, wire::ReplyHeader, "ReplyHeader", wire::layout_hash());
// The same in a layout that differs.
header!(OtherRequest, wire::RequestHeader, "RequestHeader", !wire::layout_hash());
header!(OtherReply, wire::ReplyHeader, "ReplyHeader", !wire::layout_hash());

/// The library's own fields of a request (its `service/header/request_response.rs`), in cells of
/// 8 bytes: node and client (two each), channel, request, count of elements, and one more.
pub type OwnFields = [u64; 8];

/// Where among [`OwnFields`] the channel is.
pub const CHANNEL: usize = 4;

/// Where among [`OwnFields`] the count of elements is.
pub const ELEMENTS: usize = 6;

/// A client that nothing keeps from writing nonsense.
#[derive(Debug)]
pub struct RawClient {
    port: Client<ipc::Service, [u64], Request, [u64], Reply>,
    bell: Notifier<ipc::Service>,
    _node: Node<ipc::Service>,
}

/// A request as it lies in memory.
#[derive(Debug, Clone, Default)]
pub struct Memory {
    /// The header.
    pub header: wire::RequestHeader,
    /// The payload.
    pub cells: Vec<u64>,
}

impl RawClient {
    /// Connects, if there is a planner with a place for a client.
    pub fn connect(domain: &Domain) -> Option<Self> {
        let settings = domain.root().ok()?.join(format!("{}.toml", domain.name()));
        let settings = FilePath::new(settings.as_os_str().as_encoded_bytes()).ok()?;
        let mut config = Config::from_file(&settings).ok()?;
        // The planner does that, with more care.
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
        let node = NodeBuilder::new().config(&config).create::<ipc::Service>().ok()?;
        let service = node
            .service_builder(&topic::PLAN.try_into().ok()?)
            .request_response::<[u64], [u64]>()
            .request_user_header::<Request>()
            .response_user_header::<Reply>()
            .open()
            .ok()?;
        let port = service
            .client_builder()
            .initial_max_slice_len(1024)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .create()
            .ok()?;
        let wake = node.service_builder(&topic::WAKE.try_into().ok()?).event().open().ok()?;
        let bell = wake.notifier_builder().create().ok()?;
        Some(Self { port, bell, _node: node })
    }

    /// Sends a request, after `spoil` has had the library's own fields of it. None if too many
    /// are open or memory has run out.
    pub fn send(&self, memory: &Memory, spoil: impl FnOnce(&mut OwnFields)) -> Option<RawPending> {
        let Memory { header, cells } = memory;
        let request = self.port.loan_slice_uninit(cells.len()).ok()?;
        let mut request = request.write_from_slice(cells);
        request.user_header_mut().0 = *header;
        let payload = NonNull::from(request.payload_mut()).cast();
        let own = std::ptr::from_ref(request.header()).cast_mut().cast::<OwnFields>();
        #[expect(unsafe_code, reason = "a peer can write what it likes into its own memory")]
        // SAFETY: the header is 64 bytes of memory that this process has mapped to write, and
        // nothing here reads it meanwhile.
        unsafe {
            let mut fields = own.read();
            spoil(&mut fields);
            own.write(fields);
        }
        let awaited = request.send().ok()?;
        let _ = self.bell.notify();
        Some(RawPending { awaited, payload, cells: cells.len() })
    }
}

/// A request that its sender can still write to.
#[derive(Debug)]
pub struct RawPending {
    awaited: PendingResponse<ipc::Service, [u64], Request, [u64], Reply>,
    payload: NonNull<u64>,
    cells: usize,
}

/// How a reply ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// With its last part.
    Whole,
    /// The planner drops the request before.
    Dropped,
    /// Not in time.
    Open,
}

impl RawPending {
    /// Writes into the payload while others may read it.
    pub fn scribble(&self, rng: &mut Rng) {
        if self.cells == 0 {
            return;
        }
        let at = rng.usize(..self.cells);
        #[expect(unsafe_code, reason = "a peer can write what it likes into its own memory")]
        // SAFETY: within the payload, which this process has mapped to write for as long as the
        // request is open, and which is aligned for its cells.
        let cell = unsafe { AtomicU64::from_ptr(self.payload.add(at).as_ptr()) };
        cell.store(odd_cell(rng), Ordering::Relaxed);
    }

    /// Takes what comes, and does `meanwhile` while nothing does.
    pub fn end(&self, limit: Duration, mut meanwhile: impl FnMut()) -> End {
        let until = Instant::now() + limit;
        loop {
            let connected = self.awaited.is_connected();
            match self.awaited.receive() {
                Ok(Some(part)) if part.user_header().0.last != 0 => return End::Whole,
                Ok(Some(_)) => {}
                Ok(None) if !connected => return End::Dropped,
                _ if Instant::now() >= until => return End::Open,
                _ => {
                    meanwhile();
                    std::thread::yield_now();
                }
            }
        }
    }
}

impl Memory {
    /// A scene's.
    pub fn of(scene: &SceneRequest) -> Self {
        let mut cells = Vec::new();
        let header = write_scene(scene, RequestKey::default(), 0, &mut cells);
        Self { header: header.expect("it can be written"), cells }
    }

    /// What a faulty program makes of it.
    pub fn spoil(&mut self, rng: &mut Rng) {
        match rng.u8(..8) {
            // Nothing is right but the version, without which nobody looks at the rest.
            0 => {
                rng.fill(bytes_of_mut(&mut self.header));
                self.header.version = wire::VERSION;
                self.cells = (0..rng.usize(..64)).map(|_| rng.u64(..)).collect();
            }
            1..4 => {
                let bytes = bytes_of_mut(&mut self.header);
                for _ in 0..=rng.u8(..4) {
                    bytes[rng.usize(..bytes.len())] ^= 1 << rng.u8(..8);
                }
            }
            4..6 => {
                for _ in 0..=rng.u8(..4) {
                    if let Some(cell) = rng.choice(&mut self.cells) {
                        *cell = odd_cell(rng);
                    }
                }
            }
            6 => {
                self.cells.resize(rng.usize(..=2 * self.cells.len()), odd_cell(rng));
            }
            _ => {
                let counts = [
                    &mut self.header.choices,
                    &mut self.header.body_points,
                    &mut self.header.channels,
                    &mut self.header.solids,
                    &mut self.header.sampling,
                ];
                **rng.choice(counts).as_mut().expect("five") = odd_cell(rng);
            }
        }
    }
}

/// A number that programs stumble over.
fn odd_cell(rng: &mut Rng) -> u64 {
    match rng.u8(..6) {
        0 => rng.u64(..),
        1 => f64::NAN.to_bits(),
        2 => f64::INFINITY.to_bits(),
        3 => u64::MAX >> rng.u8(..64),
        4 => (1e300 * (rng.f64() - 0.5)).to_bits(),
        _ => (20.0 * (rng.f64() - 0.5)).to_bits(),
    }
}
