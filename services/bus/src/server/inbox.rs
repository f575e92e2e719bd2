//! Requests as they come, in the current and the previous version of the messages.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::service::port_factory::server::ServerCreateError;
use schemas::wire;

use super::reply::{Active, Desk, Incoming};
use crate::cause::Cause;
use crate::headers::{Current, Version};
use crate::ports::{self, Plan, PlanRequest, PlanServer};
use crate::previous::Previous;

/// Errors in a row after which the others have to wait for another try.
const ERRORS: u32 = 3;

/// The ports for requests.
#[derive(Debug)]
pub(super) struct InboxPorts {
    // Whoever finds a planner of the previous version only takes it for an older one: that port is
    // opened last and closed first.
    previous: PlanServer<Previous>,
    current: PlanServer<Current>,
}

impl InboxPorts {
    pub(super) fn open(
        previous: &Plan<Previous>,
        current: &Plan<Current>,
    ) -> Result<Self, ServerCreateError> {
        let current = ports::create_plan_server::<Current>(current, ports::current_parts)?;
        let previous = ports::create_plan_server::<Previous>(previous, ports::previous_parts)?;
        Ok(Self { previous, current })
    }

    fn numbers(&self) -> [u128; 2] {
        [self.previous.id().value(), self.current.id().value()]
    }
}

/// Where requests arrive.
#[derive(Debug)]
pub(super) struct Inbox {
    /// None if they could not be opened again.
    ports: Option<InboxPorts>,
    /// Whose turn it is, so that neither version starves the other.
    previous_first: bool,
    /// Requests that were taken before it was their turn.
    backlog: VecDeque<Incoming>,
    /// Clients that wait until they may leave.
    farewells: Vec<Active>,
    /// Whether there was a request the last time.
    busy: bool,
    desk: Rc<RefCell<Desk>>,
}

impl Inbox {
    pub(super) fn new(ports: InboxPorts, desk: Rc<RefCell<Desk>>) -> Self {
        let (ports, backlog, farewells) = (Some(ports), VecDeque::new(), Vec::new());
        Self { ports, previous_first: false, backlog, farewells, busy: false, desk }
    }

    /// The numbers of its ports.
    pub(super) fn numbers(&self) -> Vec<u128> {
        self.ports.iter().flat_map(InboxPorts::numbers).collect()
    }

    /// Closes its ports and opens others. What is in shared memory meanwhile is lost.
    pub(super) fn renew(
        &mut self,
        (previous, current): (&Plan<Previous>, &Plan<Current>),
    ) -> Result<(), ServerCreateError> {
        self.farewells.clear();
        self.ports = None;
        self.ports = Some(InboxPorts::open(previous, current)?);
        Ok(())
    }

    /// The next request whose client waits.
    pub(super) fn receive(&mut self) -> Option<Incoming> {
        // What these clients had dropped before is dropped here as well by now.
        self.farewells.clear();
        loop {
            // iceoryx2 looks at its clients in the same order each time, so that the last would
            // wait for ever while the first keep asking: whoever waits now comes before those.
            if self.backlog.is_empty() && self.busy {
                self.take_all();
            }
            let incoming = self.backlog.pop_front().or_else(|| self.take());
            self.busy = incoming.is_some();
            if incoming.as_ref().is_none_or(Incoming::is_waiting) {
                return incoming;
            }
        }
    }

    /// Whether a request waits.
    pub(super) fn has_requests(&self) -> bool {
        let waits = |InboxPorts { previous, current }: &InboxPorts| {
            current.has_requests().unwrap_or(true) || previous.has_requests().unwrap_or(true)
        };
        !self.backlog.is_empty()
            || !self.farewells.is_empty()
            || self.ports.as_ref().is_some_and(waits)
    }

    /// Takes what waits in shared memory, which clients can't make endless: each has a few requests
    /// open at a time.
    pub(super) fn take_all(&mut self) {
        while let Some(incoming) = self.take() {
            self.backlog.push_back(incoming);
        }
    }

    /// Learns which clients have left, and drops their requests.
    pub(super) fn see_who_left(&mut self) {
        if let Some(InboxPorts { previous, current }) = &self.ports {
            // Those that died half connected are of no interest here.
            let _ = (current.update_connections(), previous.update_connections());
        }
        self.backlog.retain(Incoming::is_waiting);
    }

    /// The next request in shared memory.
    fn take(&mut self) -> Option<Incoming> {
        let InboxPorts { previous, current } = self.ports.as_ref()?;
        loop {
            let current = || take::<Current>(current).map(Active::Current);
            let previous = || take::<Previous>(previous).map(Active::Previous);
            let active = match self.previous_first {
                true => previous().or_else(current),
                false => current().or_else(previous),
            }?;
            self.previous_first = matches!(active, Active::Current(_));
            if !is_farewell(&active.header()) {
                return Some(Incoming::new(active, Rc::clone(&self.desk)));
            }
            self.farewells.push(active);
        }
    }
}

/// The next request of a version.
fn take<V: Version>(port: &PlanServer<V>) -> Option<PlanRequest<V>> {
    // A client that died half connected is an error once; the others go on.
    let mut errors = 0;
    while errors < ERRORS {
        match port.receive() {
            Ok(request) => return request,
            Err(error) => {
                tracing::warn!(cause = %Cause::from(error), "can't receive from a client");
                errors += 1;
            }
        }
    }
    None
}

/// Whether a client only wants to know when it may leave: dropping it is the answer.
///
/// Not at once: while requests of a client that has left are held, iceoryx2 0.10 may lose track of
/// them. See [`Server::see_who_left`](super::Server::see_who_left).
fn is_farewell(header: &wire::RequestHeader) -> bool {
    *header == wire::RequestHeader { version: wire::FAREWELL, ..Default::default() }
}
