//! Connections that go from request to request.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use bus::{CallError, Domain, Origin, Wait};

use crate::error::Error;

/// How a client connects and waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ClientOptions {
    /// How it waits for replies; by default it spins for 50 µs, then sleeps.
    pub wait: Wait,
    /// How long it waits for a planner that is not there yet; by default not at all.
    pub patience: Duration,
}

/// The connections of a client that nobody uses.
#[derive(Debug)]
pub(crate) struct Pool {
    domain: Domain,
    options: ClientOptions,
    idle: Mutex<Vec<bus::Client>>,
    /// How many of those are kept.
    kept: AtomicUsize,
    origin: Origin,
}

impl Pool {
    pub(crate) fn new(
        domain: &Domain,
        options: ClientOptions,
        first: bus::Client,
        kept: usize,
    ) -> Self {
        Self {
            domain: domain.clone(),
            options,
            idle: Mutex::new(vec![first]),
            kept: AtomicUsize::new(kept),
            origin: Origin::new(),
        }
    }

    pub(crate) fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Keeps at least so many connections from now on.
    pub(crate) fn keep(&self, count: usize) {
        self.kept.fetch_max(count, Ordering::Relaxed);
    }

    pub(crate) fn has_idle(&self) -> bool {
        !self.idle.lock().unwrap_or_else(PoisonError::into_inner).is_empty()
    }

    /// A connection that nobody uses.
    pub(crate) fn take(&self) -> Result<bus::Client, Error> {
        if self.origin.is_forked() {
            return Err(CallError::Forked.into());
        }
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(connection) = idle.pop() {
            return Ok(connection);
        }
        drop(idle);
        let ClientOptions { wait, patience } = self.options;
        Ok(bus::Client::connect_within(&self.domain, wait, patience)?)
    }

    /// Keeps a connection for the next request.
    pub(crate) fn put(&self, connection: bus::Client) {
        if self.origin.is_forked() {
            return;
        }
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        if idle.len() < self.kept.load(Ordering::Relaxed) {
            idle.push(connection);
        }
    }
}
