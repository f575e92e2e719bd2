//! Connections to a planner, and requests over them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bus::{CallError, Domain};

use crate::error::Error;
use crate::pending::Pending;
use crate::pool::{ClientOptions, Pool};
use crate::reply::Reply;
use crate::scene::Scene;

/// Connections kept for further requests, and requests of [`Client::plan_many`] open at a time.
const KEPT: usize = 4;

/// How long one of several open requests is looked after before the others have their turn.
const LOOK: Duration = Duration::from_millis(2);

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

impl Client {
    /// Connects to the planner of a domain.
    pub fn connect(domain: &Domain) -> Result<Self, Error> {
        Self::connect_with(domain, ClientOptions::default())
    }

    /// The same with options.
    pub fn connect_with(domain: &Domain, options: ClientOptions) -> Result<Self, Error> {
        bus::leave_signals_alone();
        let first = bus::Client::connect_within(domain, options.wait, options.patience)?;
        Ok(Self { pool: Arc::new(Pool::new(domain, options, first, KEPT)) })
    }

    /// Connects in advance, so that `count` requests can be open at a time. Connecting takes
    /// milliseconds, in which nobody takes what comes for open requests; a planner drops a reply of
    /// which nothing is taken for a second (`patience`).
    pub fn reserve(&self, count: usize) -> Result<(), Error> {
        let mut taken = Vec::with_capacity(count);
        for _ in 0..count {
            taken.push(self.pool.take()?);
        }
        self.pool.keep(count);
        taken.into_iter().for_each(|connection| self.pool.put(connection));
        Ok(())
    }

    /// Whether a connection is free, so that [`Client::start`] need not connect.
    pub fn is_ready(&self) -> bool {
        self.pool.has_idle()
    }

    /// The domain.
    pub fn domain(&self) -> &Domain {
        self.pool.domain()
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
    /// each, from when it is sent.
    pub fn plan_many(&self, scenes: &[Scene], limit: Duration) -> Vec<Result<Reply, Error>> {
        self.plan_many_while(scenes, limit, Duration::MAX, || true)
    }

    /// The same, asking `go_on` once in so long; when it says no, the rest is cancelled
    /// ([`CallError::Interrupted`]).
    pub fn plan_many_while(
        &self,
        scenes: &[Scene],
        limit: Duration,
        every: Duration,
        mut go_on: impl FnMut() -> bool,
    ) -> Vec<Result<Reply, Error>> {
        let mut replies: Vec<_> = scenes.iter().map(|_| None).collect();
        let mut open: Vec<(usize, Instant, Pending)> = Vec::with_capacity(KEPT);
        let mut waiting = scenes.iter().enumerate();
        let mut asked = Instant::now();
        let most = KEPT.min(scenes.len());
        // Where there are not so many places, one request at a time says why.
        let most = if self.reserve(most).is_ok() { most } else { 1 };
        loop {
            while open.len() < most
                && let Some((place, scene)) = waiting.next()
            {
                match self.start(scene) {
                    Ok(pending) => open.push((place, Instant::now(), pending)),
                    Err(error) => replies[place] = Some(Err(error)),
                }
            }
            if open.is_empty() {
                break;
            }
            // The planner drops a reply that is not taken for too long, so all are looked after.
            for index in (0..open.len()).rev() {
                let (place, begin, pending) = &mut open[index];
                let taken = match index {
                    0 => pending.wait(LOOK.min(limit)).map(Some),
                    _ => pending.poll_until(Instant::now() + LOOK),
                };
                let waited = begin.elapsed();
                let done = match taken {
                    Ok(None) | Err(Error::Call(CallError::TimedOut { .. })) => {
                        (waited >= limit).then(|| Err(CallError::TimedOut { waited, limit }.into()))
                    }
                    done => done.transpose(),
                };
                if done.is_some() {
                    replies[*place] = done;
                    open.swap_remove(index);
                }
            }
            if asked.elapsed() >= every {
                asked = Instant::now();
                if !go_on() {
                    break;
                }
            }
        }
        let interrupted = || Err(CallError::Interrupted.into());
        replies.into_iter().map(|reply| reply.unwrap_or_else(interrupted)).collect()
    }

    /// Sends a scene. Dropping what is returned cancels the request.
    pub fn start(&self, scene: &Scene) -> Result<Pending, Error> {
        let connection = self.pool.take()?;
        let sent = connection.send_cells(scene.shortest().header, &scene.shortest().cells)?;
        Ok(Pending::new(sent, connection, scene, &self.pool))
    }
}
