//! A request being answered.

use std::os::fd::RawFd;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bus::CallError;
use schemas::message::ErrorCode;

use crate::error::{Error, Refused};
use crate::gather::Gatherer;
use crate::pool::Pool;
use crate::reply::Reply;
use crate::scene::Scene;

/// A request being answered. Dropping it cancels it.
#[derive(Debug)]
pub struct Pending {
    /// None once it is done.
    open: Option<Open>,
    pool: Arc<Pool>,
    scene: Scene,
    gatherer: Gatherer,
    /// Whether the free space itself was sent.
    is_whole: bool,
}

#[derive(Debug)]
struct Open {
    // Dropped in this order.
    sent: bus::Pending,
    connection: bus::Client,
}

impl Pending {
    pub(crate) fn new(
        sent: bus::Pending,
        connection: bus::Client,
        scene: &Scene,
        pool: &Arc<Pool>,
    ) -> Self {
        Self {
            open: Some(Open { sent, connection }),
            pool: Arc::clone(pool),
            scene: scene.clone(),
            gatherer: Gatherer::default(),
            is_whole: std::ptr::eq(scene.shortest(), scene.whole()),
        }
    }

    /// The reply, if it is there. To be called until it is, or an error; not after that.
    ///
    /// # Panics
    ///
    /// If it has already returned a reply or an error.
    pub fn poll(&mut self) -> Result<Option<Reply>, Error> {
        self.go_on(None, |sent| sent.loan())
    }

    /// The same, but no longer than until `until`, however fast parts come.
    pub(crate) fn poll_until(&mut self, until: Instant) -> Result<Option<Reply>, Error> {
        self.go_on(Some(until), |sent| sent.loan())
    }

    /// Waits for the reply, at most so long. When the time is over
    /// ([`CallError::TimedOut`]), it can be called again.
    ///
    /// # Panics
    ///
    /// As [`Pending::poll`].
    pub fn wait(&mut self, limit: Duration) -> Result<Reply, Error> {
        let begin = Instant::now();
        let until = begin + limit;
        loop {
            match self.go_on(Some(until), |sent| sent.wait_loan(until).map(Some)) {
                Ok(Some(reply)) => return Ok(reply),
                // It was sent again, or parts come so fast that nothing else ended this.
                Ok(None) if Instant::now() < until => {}
                Ok(None) | Err(Error::Call(CallError::TimedOut { .. })) => {
                    return Err(CallError::TimedOut { waited: begin.elapsed(), limit }.into());
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Takes what is there or what `next` waits for, but none after `until` when one was taken.
    fn go_on(
        &mut self,
        until: Option<Instant>,
        next: impl Fn(&mut bus::Pending) -> Result<Option<bus::Loan>, CallError>,
    ) -> Result<Option<Reply>, Error> {
        let reply = loop {
            let Open { sent, connection } = self.open.as_mut().expect("the reply was not taken");
            let most_loans = connection.most_loans();
            let taken = next(sent).and_then(|loan| match loan {
                Some(loan) => self.gatherer.push(loan, most_loans).map(|reply| (true, reply)),
                None => Ok((false, None)),
            });
            match taken {
                Ok((_, Some(reply))) => break reply,
                Ok((true, None)) if until.is_none_or(|until| Instant::now() < until) => {}
                Ok((_, None)) => return Ok(None),
                // The end of an earlier client's request can end this one: nobody saw it.
                Err(CallError::GivenUp) if self.gatherer.is_empty() => {
                    self.send_again()?;
                    return Ok(None);
                }
                Err(error @ (CallError::TimedOut { .. } | CallError::Interrupted)) => {
                    return Err(error.into());
                }
                Err(error) => {
                    // The next request finds out on a new connection what is the matter.
                    self.open = None;
                    return Err(error.into());
                }
            }
        };
        let is_unknown = |refused: &Refused| refused.code() == ErrorCode::UnknownFreeSpace;
        if !self.is_whole && reply.as_ref().is_err_and(is_unknown) {
            self.is_whole = true;
            self.send_again()?;
            return Ok(None);
        }
        self.close();
        Ok(Some(reply?))
    }

    fn send_again(&mut self) -> Result<(), Error> {
        self.gatherer = Gatherer::default();
        let Some(Open { sent, connection }) = self.open.take() else { return Ok(()) };
        drop(sent);
        let message = if self.is_whole { self.scene.whole() } else { self.scene.shortest() };
        let sent = connection.send_cells(message.header, &message.cells)?;
        self.open = Some(Open { sent, connection });
        Ok(())
    }

    /// Gives the connection back.
    fn close(&mut self) {
        if let Some(Open { sent, connection }) = self.open.take() {
            drop(sent);
            self.pool.put(connection);
        }
    }

    /// Whether a reply can still come: none was returned, nor an error but that of the time.
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// Prepares for waiting in an event loop: to be called *before* a last [`Pending::poll`]. What
    /// comes after that makes [`Pending::bell`] readable. As rings can be lost and planners can
    /// die, poll every [`Pending::NET`] anyway.
    pub fn silence(&self) {
        if let Some(open) = &self.open {
            open.sent.silence();
        }
    }

    /// A file descriptor that can be read when it is time to [`Pending::poll`]; none for a client
    /// that polls all the time, or if the request is done. It is open as long as this.
    pub fn bell(&self) -> Option<RawFd> {
        self.open.as_ref()?.sent.bell()
    }

    /// The longest time to wait for the bell.
    pub const NET: Duration = bus::wait::NET;
}

impl Drop for Pending {
    fn drop(&mut self) {
        self.close();
    }
}
