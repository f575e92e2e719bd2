//! What the planner says of itself: text that it publishes now and then, the last of which whoever
//! comes sees at once.

use std::time::{Duration, Instant};

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{AllocationStrategy, ipc};

use crate::cause::Cause;
use crate::connect;
use crate::domain::Domain;
use crate::error::ConnectError;
use crate::member::Member;
use crate::memory;
use crate::ports;
use crate::presence::Visitor;
use crate::wait;

/// The planner's end.
#[derive(Debug)]
pub(crate) struct StatusWriter {
    port: Publisher<ipc::Service, [u8], ()>,
}

impl StatusWriter {
    pub(crate) fn create(service: &ports::StatusService) -> Result<Self, Cause> {
        let port = service
            .publisher_builder()
            .initial_max_slice_len(ports::STATUS_BYTES)
            .allocation_strategy(AllocationStrategy::Static)
            .max_loaned_samples(1)
            .create()
            .map_err(Cause::from)?;
        Ok(Self { port })
    }

    /// Gives those who have come since the last text that text.
    pub(crate) fn show(&self) {
        // Whoever can't be reached now is tried again with the next.
        let _ = self.port.update_connections();
    }

    pub(crate) fn publish(&self, text: &str) -> Result<(), Cause> {
        let text = &text.as_bytes()[..text.floor_char_boundary(ports::STATUS_BYTES)];
        let sample = self.port.loan_slice_uninit(text.len()).map_err(Cause::from)?;
        sample.write_from_slice(text).send().map_err(Cause::from)?;
        Ok(())
    }
}

/// Sees what a planner says of itself.
#[derive(Debug)]
pub struct StatusReader {
    port: Subscriber<ipc::Service, [u8], ()>,
    /// Stays in the domain for as long as the port is open.
    _node: Member,
}

impl StatusReader {
    /// Listens to the planner of a domain.
    pub fn connect(domain: &Domain) -> Result<Self, ConnectError> {
        let node = domain.join(Visitor::WATCHER)?;
        let failed = |cause| connect::failed(&node, domain, connect::STATUS, cause);
        let service = ports::open_status(&node).map_err(failed)?;
        memory::check_room(memory::CONNECTION)?;
        let port = service.subscriber_builder().create();
        let port = port.map_err(|error| match error.into() {
            Cause::Full => connect::full(domain, connect::WATCHERS, ports::WATCHERS),
            cause => failed(cause),
        })?;
        Ok(Self { port, _node: node })
    }

    /// The next text, if there is one.
    pub fn receive(&self) -> Option<String> {
        let sample = self.port.receive().ok()??;
        String::from_utf8(sample.payload().to_vec()).ok()
    }

    /// Waits for the next text, at most so long and until a signal comes.
    pub fn wait(&self, limit: Duration) -> Option<String> {
        let until = Instant::now() + limit;
        loop {
            if let Some(text) = self.receive() {
                return Some(text);
            }
            if Instant::now() >= until || wait::terminated() {
                return None;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}
