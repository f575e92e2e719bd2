//! Peers of version 1, by iceoryx2's own ports: names and types as they were released.

use std::time::{Duration, Instant};

use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::{event, request_response};
use schemas::convert;
use schemas::message::{ReplyPart, RequestKey, SceneRequest};
use schemas::wire;

use crate::support::*;

#[derive(Debug, Default, Clone, Copy, ZeroCopySend)]
#[repr(C)]
#[type_name("clearway::RequestHeader#35c7081f0ebf6be2")]
pub(crate) struct OldRequest([[u64; 17]; 2]);

#[derive(Debug, Default, Clone, Copy, ZeroCopySend)]
#[repr(C)]
#[type_name("clearway::ReplyHeader#35c7081f0ebf6be2")]
pub(crate) struct OldReply([u64; 19]);

type Plan = request_response::PortFactory<ipc::Service, [u64], OldRequest, [u64], OldReply>;
type Builder = iceoryx2::service::builder::request_response::Builder<
    [u64],
    OldRequest,
    [u64],
    OldReply,
    ipc::Service,
>;

fn plan(node: &Node<ipc::Service>) -> Builder {
    node.service_builder(&"clearway/plan".try_into().unwrap())
        .request_response::<[u64], [u64]>()
        .request_user_header::<OldRequest>()
        .response_user_header::<OldReply>()
}

fn bell(
    node: &Node<ipc::Service>,
    name: &str,
) -> iceoryx2::service::builder::event::Builder<ipc::Service> {
    node.service_builder(&name.try_into().unwrap()).event()
}

/// A planner of version 1 that answers nothing.
pub(crate) struct OldPlanner {
    _server: Server<ipc::Service, [u64], OldRequest, [u64], OldReply>,
    _bells: [event::PortFactory<ipc::Service>; 2],
    _node: Node<ipc::Service>,
}

impl OldPlanner {
    /// With the default settings of version 1.
    pub(crate) fn start(node: Node<ipc::Service>) -> Self {
        let service: Plan = plan(&node)
            .enable_safe_overflow_for_requests(false)
            .enable_safe_overflow_for_responses(false)
            .enable_fire_and_forget_requests(false)
            .max_servers(1)
            .max_clients(32)
            .max_nodes(36)
            .max_active_requests_per_client(4)
            .max_loaned_requests(1)
            .max_response_buffer_size(8)
            .max_borrowed_responses_per_pending_response(2)
            .create()
            .unwrap();
        let bells = [("clearway/wake", 1, 32), ("clearway/answered", 32, 1)].map(
            |(name, listeners, notifiers)| {
                let bell = bell(&node, name).max_listeners(listeners).max_notifiers(notifiers);
                bell.max_nodes(37).create().unwrap()
            },
        );
        let server = service.server_builder().initial_max_slice_len(64).create().unwrap();
        Self { _server: server, _bells: bells, _node: node }
    }
}

/// A client of version 1 that sleeps until it is woken.
pub(crate) struct OldClient {
    port: Client<ipc::Service, [u64], OldRequest, [u64], OldReply>,
    ringer: Notifier<ipc::Service>,
    bell: Listener<ipc::Service>,
    nonce: u64,
    _node: Node<ipc::Service>,
}

/// What an old client gets: header and payload.
pub(crate) type OldPart = (wire::ReplyHeader, Vec<u64>);

pub(crate) type Pending =
    iceoryx2::pending_response::PendingResponse<ipc::Service, [u64], OldRequest, [u64], OldReply>;

impl OldClient {
    pub(crate) fn connect(node: Node<ipc::Service>, nonce: u64) -> Self {
        let service = plan(&node).open().unwrap();
        assert_eq!(service.dynamic_config().number_of_servers(), 1);
        let port = service
            .client_builder()
            .initial_max_slice_len(1024)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .create()
            .unwrap();
        let wake = bell(&node, "clearway/wake").open().unwrap();
        let answered = bell(&node, "clearway/answered").open().unwrap();
        let name = PortName::new(&format!("{nonce:016x}")).unwrap();
        Self {
            port,
            ringer: wake.notifier_builder().create().unwrap(),
            bell: answered.listener_builder().name(&name).create().unwrap(),
            nonce,
            _node: node,
        }
    }

    /// Sends memory as it is, but for the nonce and the wish to be woken.
    pub(crate) fn send(&self, mut header: wire::RequestHeader, cells: &[u64]) -> Pending {
        (header.client, header.wake) = (self.nonce, 1);
        let mut request = self.port.loan_slice_uninit(cells.len()).unwrap();
        let words: [u64; 34] = header_words(&header);
        let (first, second) = words.split_at(17);
        request.user_header_mut().0 = [first.try_into().unwrap(), second.try_into().unwrap()];
        let pending = request.write_from_slice(cells).send().unwrap();
        self.ringer.notify().unwrap();
        pending
    }

    /// Sends a scene.
    pub(crate) fn ask(&self, scene: &SceneRequest) -> Pending {
        let (key, mut cells) = (RequestKey { client: self.nonce, sequence: 0 }, Vec::new());
        let mut header = convert::write_scene(scene, key, 5, &mut cells).unwrap();
        header.version = 1;
        self.send(header, &cells)
    }

    /// The next part of a reply.
    pub(crate) fn receive(&self, pending: &Pending) -> OldPart {
        let until = Instant::now() + LONG;
        loop {
            if let Some(part) = pending.receive().unwrap() {
                return (header_of(part.user_header().0), part.payload().to_vec());
            }
            assert!(Instant::now() < until, "no reply");
            while self.bell.try_wait(|_| {}).unwrap() != 0 {}
            if !pending.has_response() {
                self.bell.timed_wait(|_| {}, Duration::from_millis(100)).unwrap();
            }
        }
    }

    /// The one part of a reply that is a trajectory, which has the same form in version 2.
    pub(crate) fn call(&self, scene: &SceneRequest) -> ReplyPart {
        let pending = self.ask(scene);
        let mut whole: Option<ReplyPart> = None;
        loop {
            let (header, cells) = self.receive(&pending);
            assert_eq!((header.version, header.kind), (1, 0));
            let header = wire::ReplyHeader { version: wire::VERSION, ..header };
            let part = convert::read_part(&header, &cells).unwrap();
            assert_eq!(part.key.client, self.nonce);
            let last = part.last;
            match &mut whole {
                None => whole = Some(part),
                Some(whole) => {
                    let (so_far, more) = (whole.content.as_mut().unwrap(), part.content.unwrap());
                    so_far.samples.extend(more.samples);
                }
            }
            if last {
                return whole.unwrap();
            }
        }
    }
}

fn header_words(header: &wire::RequestHeader) -> [u64; 34] {
    let words: &[u64] = bytemuck::cast_slice(bytemuck::bytes_of(header));
    words[..34].try_into().unwrap()
}

/// What a header of version 1 says, as the current version has it.
fn header_of(old: [u64; 19]) -> wire::ReplyHeader {
    let mut header = wire::ReplyHeader::default();
    bytemuck::cast_slice_mut(bytemuck::bytes_of_mut(&mut header))[..19].copy_from_slice(&old);
    header
}
