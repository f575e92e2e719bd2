//! Connections to a planner, and requests over them.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bus::{CallError, Domain, Origin, Wait};

use crate::error::Error;
use crate::pending::Pending;
use crate::reply::Reply;
use crate::scene::Scene;

/// Connections kept for further requests, and requests of [`Client::plan_many`] open at a time.
const KEPT: usize = 4;

/// Asks the planner of a domain.
///
/// Threads can share a client: each open request has a connection of its own, which is kept for the
/// next one, and takes one of the planner's places (`max_clients`). Signals are left to the program.
///
/// A planner that is started again is found by the next request. After a fork, the child needs a
/// client of its own.
#[derive(Debug, Clone)]
pub struct Client {
    pool: Arc<Pool>,
}

/// How a client connects and waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ClientOptions {
    /// How it waits for replies; by default it spins for 50 µs, then sleeps.
    pub wait: Wait,
    /// How long it waits for a planner that is not there yet; by default not at all.
    pub patience: Duration,
}

#[derive(Debug)]
pub(crate) struct Pool {
    domain: Domain,
    options: ClientOptions,
    idle: Mutex<Vec<bus::Client>>,
    origin: Origin,
}

impl Client {
    /// Connects to the planner of a domain.
    pub fn connect(domain: &Domain) -> Result<Self, Error> {
        Self::connect_with(domain, ClientOptions::default())
    }

    /// The same with options.
    pub fn connect_with(domain: &Domain, options: ClientOptions) -> Result<Self, Error> {
        bus::leave_signals_alone();
        let first = bus::Client::connect_within(domain, options.wait, options.patience)?;
        let idle = Mutex::new(vec![first]);
        let pool = Pool { domain: domain.clone(), options, idle, origin: Origin::new() };
        Ok(Self { pool: Arc::new(pool) })
    }

    /// The domain.
    pub fn domain(&self) -> &Domain {
        &self.pool.domain
    }

    /// Plans a scene. If no reply comes within `limit`, the request is cancelled.
    ///
    /// # Errors
    ///
    /// [`Error::Refused`] if the request as a whole is refused. Of several answers, each is a
    /// trajectory or a refusal ([`Reply::answers`]).
    pub fn plan(&self, scene: &Scene, limit: Duration) -> Result<Reply, Error> {
        self.start(scene)?.wait(limit)
    }

    /// Plans several scenes, a few at a time. Replies are in the order of the scenes; `limit` is for
    /// each.
    pub fn plan_many(&self, scenes: &[Scene], limit: Duration) -> Vec<Result<Reply, Error>> {
        let mut open = VecDeque::with_capacity(KEPT);
        let mut replies = Vec::with_capacity(scenes.len());
        let wait = |pending: Result<Pending, Error>| pending?.wait(limit);
        for scene in scenes {
            if open.len() == KEPT {
                replies.extend(open.pop_front().map(wait));
            }
            open.push_back(self.start(scene));
        }
        replies.extend(open.into_iter().map(wait));
        replies
    }

    /// Sends a scene. Dropping what is returned cancels the request.
    pub fn start(&self, scene: &Scene) -> Result<Pending, Error> {
        let connection = self.pool.take()?;
        let sent = connection.send_cells(scene.shortest().header, &scene.shortest().cells)?;
        Ok(Pending::new(sent, connection, scene, &self.pool))
    }
}

impl Pool {
    /// A connection that nobody uses.
    fn take(&self) -> Result<bus::Client, Error> {
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
        if idle.len() < KEPT {
            idle.push(connection);
        }
    }
}
