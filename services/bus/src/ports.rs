//! All settings of the services, on which peers must agree.
//!
//! Payloads have the alignment of their cells: with that of a cache line, iceoryx2 would
//! reserve a line for every cell.

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::BackpressureAction;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, Node, ServiceName, ipc};
use iceoryx2::service::Service;
use iceoryx2::service::port_factory::server::ServerCreateError;
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};
use schemas::{topic, wire};

use crate::cause::Cause;
use crate::headers::{TapHeader, Version};
use crate::options::ServerOptions;

/// The planning service in a version of the messages, and its ends.
pub(crate) type Plan<V, S = ipc::Service> =
    request_response::PortFactory<S, [u64], <V as Version>::Request, [u64], <V as Version>::Reply>;
pub(crate) type PlanServer<V> =
    Server<ipc::Service, [u64], <V as Version>::Request, [u64], <V as Version>::Reply>;
pub(crate) type PlanRequest<V> =
    ActiveRequest<ipc::Service, [u64], <V as Version>::Request, [u64], <V as Version>::Reply>;
pub(crate) type Tap = publish_subscribe::PortFactory<ipc::Service, [u64], TapHeader>;
pub(crate) type Bell<S = ipc::Service> = event::PortFactory<S>;

fn name(name: &str) -> ServiceName {
    ServiceName::new(name).expect("topic names are valid")
}

/// Parts of one reply that wait in shared memory for the client to take them.
pub(crate) const REPLY_BUFFER: usize = 4;

/// Parts of one reply that a client holds at a time: those it keeps where they lie, and the one
/// that it takes next.
const BORROWED: usize = 8;

/// For so many of those there is memory from the start, which is enough for clients that keep
/// [`kept`] parts, of all their replies together. A part that finds none waits.
const HELD: usize = 2;

/// Parts of replies that a client of this planner can keep, with room to take others.
pub(crate) const fn kept(borrowed: usize) -> usize {
    borrowed.saturating_sub(1)
}

/// Parts of one reply that the planner writes at a time.
const LOANED: usize = 1;

/// Messages of the tap that a recorder holds at a time.
const TAP_BORROWED: usize = 2;

pub(crate) fn create_plan<V: Version>(
    node: &Node<ipc::Service>,
    options: &ServerOptions,
) -> Result<Plan<V>, Cause> {
    let created = node
        .service_builder(&name(V::PLAN))
        .request_response::<[u64], [u64]>()
        .request_user_header::<V::Request>()
        .response_user_header::<V::Reply>()
        // Nothing vanishes silently: the sender deals with a full buffer.
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
        .map_err(Cause::from);
    or_as_it_is(created, || open_plan::<V, _>(node))
}

/// A service that programs still have open, from a planner with smaller settings, is served as it
/// is: they would lose their connection otherwise.
fn or_as_it_is<T>(
    created: Result<T, Cause>,
    open: impl FnOnce() -> Result<T, Cause>,
) -> Result<T, Cause> {
    match created {
        Err(Cause::Smaller) => open(),
        created => created,
    }
}

pub(crate) fn open_plan<V: Version, S: Service>(node: &Node<S>) -> Result<Plan<V, S>, Cause> {
    node.service_builder(&name(V::PLAN))
        .request_response::<[u64], [u64]>()
        .request_user_header::<V::Request>()
        .response_user_header::<V::Reply>()
        .open()
        .map_err(Cause::from)
}

/// The planner's end of a planning service. `parts` makes the number of reply parts in
/// memory from the number that all clients together can hold.
pub(crate) fn create_plan_server<V: Version>(
    plan: &Plan<V>,
    parts: fn(usize) -> usize,
) -> Result<PlanServer<V>, ServerCreateError> {
    plan.server_builder()
        .initial_max_slice_len(wire::PART_CELLS)
        .allocation_strategy(AllocationStrategy::Static)
        .override_response_preallocation(parts)
        .max_loaned_responses_per_request(LOANED)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        // The planner does not wait: it keeps the part and tries again later.
        .set_backpressure_handler(|_| BackpressureAction::DiscardDataAndFail)
        .create()
}

pub(crate) fn create_tap(node: &Node<ipc::Service>, options: &ServerOptions) -> Result<Tap, Cause> {
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
        .map_err(Cause::from)
}

pub(crate) fn open_tap(node: &Node<ipc::Service>) -> Result<Tap, Cause> {
    node.service_builder(&name(topic::TAP))
        .publish_subscribe::<[u64]>()
        .user_header::<TapHeader>()
        .open()
        .map_err(Cause::from)
}

pub(crate) type StatusService = publish_subscribe::PortFactory<ipc::Service, [u8], ()>;

/// The longest status, bytes.
pub(crate) const STATUS_BYTES: usize = 4096;

/// Readers of the status at a time.
pub(crate) const WATCHERS: usize = 16;

pub(crate) fn create_status(node: &Node<ipc::Service>) -> Result<StatusService, Cause> {
    node.service_builder(&name(topic::STATUS))
        .publish_subscribe::<[u8]>()
        .enable_safe_overflow(true)
        .max_publishers(1)
        .max_subscribers(WATCHERS)
        .max_nodes(WATCHERS + 4)
        .subscriber_max_buffer_size(1)
        .subscriber_max_borrowed_samples(1)
        .history_size(1)
        .open_or_create()
        .map_err(Cause::from)
}

pub(crate) fn open_status(node: &Node<ipc::Service>) -> Result<StatusService, Cause> {
    node.service_builder(&name(topic::STATUS))
        .publish_subscribe::<[u8]>()
        .open()
        .map_err(Cause::from)
}

/// Clients ring it, the planner listens.
pub(crate) fn create_wake(
    node: &Node<ipc::Service>,
    options: &ServerOptions,
) -> Result<Bell, Cause> {
    bell(node, topic::WAKE, 1, options.max_clients)
}

/// The planner rings it, clients listen.
pub(crate) fn create_answered(
    node: &Node<ipc::Service>,
    options: &ServerOptions,
) -> Result<Bell, Cause> {
    bell(node, topic::ANSWERED, options.max_clients, 1)
}

fn bell(
    node: &Node<ipc::Service>,
    topic: &str,
    listeners: usize,
    notifiers: usize,
) -> Result<Bell, Cause> {
    let created = node
        .service_builder(&name(topic))
        .event()
        .max_listeners(listeners)
        .max_notifiers(notifiers)
        .max_nodes(listeners + notifiers + 4)
        .open_or_create()
        .map_err(Cause::from);
    let open = || node.service_builder(&name(topic)).event().open().map_err(Cause::from);
    or_as_it_is(created, open)
}

pub(crate) fn open_wake<S: Service>(node: &Node<S>) -> Result<Bell<S>, Cause> {
    node.service_builder(&name(topic::WAKE)).event().open().map_err(Cause::from)
}

pub(crate) fn open_answered<S: Service>(node: &Node<S>) -> Result<Bell<S>, Cause> {
    node.service_builder(&name(topic::ANSWERED)).event().open().map_err(Cause::from)
}

/// Reply parts in memory: `all` counts those that clients could hold.
pub(crate) fn current_parts(all: usize) -> usize {
    all / (REPLY_BUFFER + BORROWED + LOANED) * (REPLY_BUFFER + HELD + LOANED)
}

/// Reply parts in memory for clients of the previous version: as all of them share the
/// places of `max_clients` with those of the current one, an eighth of what they could
/// hold, and always what one client can. A part that finds none waits.
pub(crate) fn previous_parts(all: usize) -> usize {
    (current_parts(all) / 8).max(REPLY_BUFFER + BORROWED + LOANED)
}

/// The most shared memory that the planner's side can come to use, bytes: every buffer full
/// of the largest messages. What is never used is never taken. Clients choose what they
/// take for their requests; that comes on top.
pub fn most_memory(options: &ServerOptions) -> u64 {
    // iceoryx2's own count: a server may still hold as many requests as it answers.
    let answers = options.max_clients.saturating_mul(2 * options.requests_per_client);
    let parts = answers.saturating_mul(REPLY_BUFFER + BORROWED + LOANED);
    let tap_messages =
        options.max_recorders.saturating_mul(options.tap_buffer.saturating_add(TAP_BORROWED)) + 1;
    let message = (wire::PART_CELLS * 8 + 512) as u64;
    let messages =
        current_parts(parts).saturating_add(previous_parts(parts)).saturating_add(tap_messages);
    let statuses = (2 * WATCHERS + 2) * (STATUS_BYTES + 512);
    (messages as u64).saturating_mul(message).saturating_add(statuses as u64)
}
