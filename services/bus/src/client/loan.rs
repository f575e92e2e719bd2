//! Parts of a reply where the planner wrote them.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use iceoryx2::prelude::ipc_threadsafe;
use schemas::wire;

use crate::fork::OwnedHere;
use crate::headers::{ReplyHeader, UserHeader};
use crate::member::Member;

pub(super) type Response =
    iceoryx2::response::Response<ipc_threadsafe::Service, [u64], ReplyHeader>;

/// A part of a reply, in shared memory until it is dropped, even if the client and the planner are
/// gone by then.
///
/// A client can keep [`Client::most_loans`](crate::Client::most_loans); one more is there to take
/// further parts with.
#[derive(Debug)]
pub struct Loan {
    // Dropped in this order.
    response: OwnedHere<Response>,
    alive: Alive,
    /// The memory is that of a member of the domain.
    _node: Arc<OwnedHere<Member<ipc_threadsafe::Service>>>,
}

#[expect(unsafe_code, reason = "iceoryx2 vouches for sending only")]
// SAFETY: through a reference it can only be read, and nobody writes to it until it is dropped.
unsafe impl Sync for Loan {}

impl Loan {
    pub(super) fn new(
        response: Response,
        alive: &Arc<AtomicUsize>,
        node: &Arc<OwnedHere<Member<ipc_threadsafe::Service>>>,
    ) -> Self {
        let (response, alive) = (OwnedHere::new(response), Alive::new(alive));
        Self { response, alive, _node: Arc::clone(node) }
    }

    /// Its header.
    pub fn header(&self) -> &wire::ReplyHeader {
        self.response.user_header().plain()
    }

    /// Its payload.
    pub fn cells(&self) -> &[u64] {
        self.response.payload()
    }

    /// How many of its client's loans are alive, this one included.
    pub fn alive(&self) -> usize {
        self.alive.0.load(Ordering::Relaxed)
    }
}

/// Counts loans.
#[derive(Debug)]
struct Alive(Arc<AtomicUsize>);

impl Alive {
    fn new(count: &Arc<AtomicUsize>) -> Self {
        count.fetch_add(1, Ordering::Relaxed);
        Self(Arc::clone(count))
    }
}

impl Drop for Alive {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}
