//! Settings of the planner's side.

use std::time::Duration;

use crate::wait::Wait;

/// Sizes of the planner's side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ServerOptions {
    /// Clients at a time, of all versions together.
    pub max_clients: usize,
    /// Requests that one client can have open.
    pub requests_per_client: usize,
    /// Recorders at a time.
    pub max_recorders: usize,
    /// Messages kept for a slow recorder before the oldest are lost.
    pub tap_buffer: usize,
    /// Whether all of the memory is taken at the start, so that none can lack later.
    pub reserve: bool,
    /// How the planner waits for requests.
    pub wait: Wait,
    /// How replies deal with slow clients.
    pub reply: ReplyOptions,
}

impl Default for ServerOptions {
    fn default() -> Self {
        Self {
            max_clients: 64,
            requests_per_client: 2,
            max_recorders: 2,
            tap_buffer: 768,
            reserve: false,
            wait: Wait::Hybrid,
            reply: ReplyOptions::default(),
        }
    }
}

/// How replies deal with slow clients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReplyOptions {
    /// How long a part waits for a client whose buffer is full before the rest of the reply
    /// is given up. It holds up nobody else.
    pub patience: Duration,
}

impl Default for ReplyOptions {
    fn default() -> Self {
        Self { patience: Duration::from_secs(1) }
    }
}
