//! Waking clients.

use iceoryx2::port::notifier::{ListenerKey, Notifier};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{CallbackProgression, ipc};

/// Rings the bells of clients: a client's listener has its nonce for a name.
#[derive(Debug)]
pub(super) struct Ringer {
    port: Notifier<ipc::Service>,
    /// Bells rung before. Looking for one is slow, and iceoryx2 logs a long warning for
    /// every bell of a killed client on the way.
    known: Vec<(u64, ListenerKey)>,
}

impl Ringer {
    pub(super) fn new(port: Notifier<ipc::Service>, clients: usize) -> Self {
        Self { port, known: Vec::with_capacity(clients) }
    }

    /// Lets go of the bells of clients that have left.
    pub(super) fn forget_gone(&self) {
        if let Err(error) = self.port.update_connections() {
            tracing::debug!(?error, "can't let go of bells");
        }
    }

    /// Whether there was a bell to ring.
    pub(super) fn ring(&mut self, client: u64) -> bool {
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
        // Clients that have left stay in the list until then.
        if self.known.len() == self.known.capacity() {
            self.known.clear();
        }
        self.known.push((client, key));
        true
    }
}
