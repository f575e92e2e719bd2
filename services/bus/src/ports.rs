//! The services' settings, all of them: peers must agree on these exactly.
//!
//! Payloads have the alignment of their cells. To ask for a cache line would have
//! iceoryx2 reserve one for every cell.

use iceoryx2::prelude::{Node, ServiceName, ipc};
use iceoryx2::service::builder::request_response::RequestResponseOpenError;
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};
use schemas::topic;

use crate::headers::{ReplyHeader, RequestHeader, TapHeader};
use crate::server::ServerOptions;

pub(crate) type Plan =
    request_response::PortFactory<ipc::Service, [u64], RequestHeader, [u64], ReplyHeader>;
pub(crate) type Tap = publish_subscribe::PortFactory<ipc::Service, [u64], TapHeader>;
pub(crate) type Bell = event::PortFactory<ipc::Service>;

fn name(name: &str) -> ServiceName {
    ServiceName::new(name).expect("topic names are valid")
}

/// What iceoryx2 said, whichever of its error types it is.
pub(crate) fn said(error: impl std::fmt::Debug) -> String {
    format!("{error:?}")
}

/// Parts of one reply that wait in shared memory for the client to take them.
pub(crate) const REPLY_BUFFER: usize = 8;

/// Parts of one reply that a client holds at a time.
const BORROWED: usize = 2;

/// Messages of the tap that a recorder holds at a time.
const TAP_BORROWED: usize = 2;

pub(crate) fn create_plan(
    node: &Node<ipc::Service>,
    options: &ServerOptions,
) -> Result<Plan, String> {
    node.service_builder(&name(topic::PLAN))
        .request_response::<[u64], [u64]>()
        .request_user_header::<RequestHeader>()
        .response_user_header::<ReplyHeader>()
        // Nothing vanishes silently: a full buffer is the sender's to deal with.
        .enable_safe_overflow_for_requests(false)
        .enable_safe_overflow_for_responses(false)
        .enable_fire_and_forget_requests(false)
        .max_servers(1)
        .max_clients(options.max_clients)
        .max_nodes(options.max_clients + 4)
        .max_active_requests_per_client(options.requests_per_client)
        .max_loaned_requests(1)
        .max_response_buffer_size(REPLY_BUFFER)
        .max_borrowed_responses_per_pending_response(BORROWED)
        .open_or_create()
        .map_err(said)
}

pub(crate) fn open_plan(node: &Node<ipc::Service>) -> Result<Plan, RequestResponseOpenError> {
    node.service_builder(&name(topic::PLAN))
        .request_response::<[u64], [u64]>()
        .request_user_header::<RequestHeader>()
        .response_user_header::<ReplyHeader>()
        .open()
}

pub(crate) fn create_tap(
    node: &Node<ipc::Service>,
    options: &ServerOptions,
) -> Result<Tap, String> {
    node.service_builder(&name(topic::TAP))
        .publish_subscribe::<[u64]>()
        .user_header::<TapHeader>()
        // A slow recorder loses the oldest messages, and counts them; it never slows
        // the planner.
        .enable_safe_overflow(true)
        .max_publishers(1)
        .max_subscribers(options.max_recorders)
        .max_nodes(options.max_recorders + 4)
        .subscriber_max_buffer_size(options.tap_buffer)
        .subscriber_max_borrowed_samples(TAP_BORROWED)
        .history_size(0)
        .open_or_create()
        .map_err(said)
}

pub(crate) fn open_tap(node: &Node<ipc::Service>) -> Result<Tap, String> {
    node.service_builder(&name(topic::TAP))
        .publish_subscribe::<[u64]>()
        .user_header::<TapHeader>()
        .open()
        .map_err(said)
}

/// Clients ring it, the planner listens.
pub(crate) fn create_wake(
    node: &Node<ipc::Service>,
    options: &ServerOptions,
) -> Result<Bell, String> {
    bell(node, topic::WAKE, 1, options.max_clients)
}

/// The planner rings it, clients listen.
pub(crate) fn create_answered(
    node: &Node<ipc::Service>,
    options: &ServerOptions,
) -> Result<Bell, String> {
    bell(node, topic::ANSWERED, options.max_clients, 1)
}

fn bell(
    node: &Node<ipc::Service>,
    topic: &str,
    listeners: usize,
    notifiers: usize,
) -> Result<Bell, String> {
    node.service_builder(&name(topic))
        .event()
        .max_listeners(listeners)
        .max_notifiers(notifiers)
        .max_nodes(listeners + notifiers + 4)
        .open_or_create()
        .map_err(said)
}

pub(crate) fn open_wake(node: &Node<ipc::Service>) -> Result<Bell, String> {
    node.service_builder(&name(topic::WAKE)).event().open().map_err(said)
}

pub(crate) fn open_answered(node: &Node<ipc::Service>) -> Result<Bell, String> {
    node.service_builder(&name(topic::ANSWERED)).event().open().map_err(said)
}

/// The most shared memory that the planner's side can come to use, bytes: every
/// buffer full of the largest messages. What is never used is never taken. What clients
/// take for their requests is theirs to choose, and comes on top.
pub fn most_memory(options: &ServerOptions) -> u64 {
    // iceoryx2's own count: a server may still hold as many requests as it answers.
    let answers = options.max_clients.saturating_mul(2 * options.requests_per_client);
    let reply_parts = answers.saturating_mul(REPLY_BUFFER + BORROWED + 1);
    let tap_messages =
        options.max_recorders.saturating_mul(options.tap_buffer.saturating_add(TAP_BORROWED)) + 1;
    let message = (schemas::wire::PART_CELLS * 8 + 512) as u64;
    (reply_parts as u64).saturating_add(tap_messages as u64).saturating_mul(message)
}
