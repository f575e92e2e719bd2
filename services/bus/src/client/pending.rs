//! A request being answered.

use std::cell::Cell;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, RawFd};
use std::sync::Arc;
use std::time::{Duration, Instant};

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::prelude::{FileDescriptorBased, PayloadHeader, ipc_threadsafe};
use schemas::convert;
use schemas::message::{Reply, ReplyAssembler, ReplyPart, RequestKey};
use schemas::wire;

use super::{Connection, Loan, Response, planner_of};
use crate::error::CallError;
use crate::fork::OwnedHere;
use crate::headers::{ReplyHeader, RequestHeader, UserHeader};
use crate::process::Process;
use crate::wait::{self, Woken};

pub(super) type Awaited =
    PendingResponse<ipc_threadsafe::Service, [u64], RequestHeader, [u64], ReplyHeader>;

/// A request being answered. Dropping it stops the planner from planning and sending.
#[derive(Debug)]
pub struct Pending {
    // Dropped in this order.
    pub(super) awaited: OwnedHere<Awaited>,
    key: RequestKey,
    connection: Arc<OwnedHere<Connection>>,
    /// Whether the last part of the reply has come.
    has_last: Cell<bool>,
}

impl Pending {
    pub(super) fn new(
        awaited: Awaited,
        key: RequestKey,
        connection: &Arc<OwnedHere<Connection>>,
    ) -> Self {
        let (awaited, connection) = (OwnedHere::new(awaited), Arc::clone(connection));
        Self { awaited, key, connection, has_last: Cell::new(false) }
    }

    /// The request's key.
    pub fn key(&self) -> RequestKey {
        self.key
    }

    /// The next part of the reply where it lies in shared memory, if one is there: `take`
    /// sees its header and payload. Parts of other replies are dropped.
    pub fn receive<T>(
        &self,
        mut take: impl FnMut(&wire::ReplyHeader, &[u64]) -> T,
    ) -> Result<Option<T>, CallError> {
        let part = self.response()?;
        Ok(part.map(|part| take(part.user_header().plain(), part.payload())))
    }

    /// The next part of the reply, if one is there, to keep.
    pub fn loan(&self) -> Result<Option<Loan>, CallError> {
        let Connection { loans, node, .. } = &**self.connection;
        Ok(self.response()?.map(|response| Loan::new(response, loans, node)))
    }

    fn response(&self) -> Result<Option<Response>, CallError> {
        self.connection.check_here()?;
        // Ask before looking: only "nothing there, and was not connected" means gone.
        let connected = self.awaited.is_connected();
        loop {
            match self.awaited.receive() {
                Ok(Some(part)) => {
                    let header = part.user_header().plain();
                    if self.accept(header) {
                        // The payload is as long as its sender says, whatever there is.
                        let claimed = part.header().number_of_elements();
                        if claimed > wire::PART_CELLS as u64 {
                            return Err(CallError::LongPart { claimed, most: wire::PART_CELLS });
                        }
                        self.has_last.set(header.last != 0);
                        return Ok(Some(part));
                    }
                    tracing::debug!(
                        client = header.client,
                        sequence = header.sequence,
                        "dropped a reply to another client"
                    );
                }
                Ok(None) if connected => return Ok(None),
                Ok(None) => return Err(self.connection.lost()),
                Err(error) => return Err(CallError::Receive(error.into())),
            }
        }
    }

    /// Whether a part answers this request.
    pub(super) fn accept(&self, header: &wire::ReplyHeader) -> bool {
        self.key == RequestKey { client: header.client, sequence: header.sequence }
    }

    /// Waits for the next part, at most until `until`.
    pub fn wait_part(&mut self, until: Instant) -> Result<ReplyPart, CallError> {
        Ok(self.wait_for(until, |pending| pending.receive(convert::read_part))??)
    }

    /// The same to keep.
    pub fn wait_loan(&mut self, until: Instant) -> Result<Loan, CallError> {
        self.wait_for(until, |pending| pending.loan())
    }

    fn wait_for<T>(
        &mut self,
        until: Instant,
        look: impl Fn(&Self) -> Result<Option<T>, CallError>,
    ) -> Result<T, CallError> {
        let begin = Instant::now();
        loop {
            if let Some(part) = look(self)? {
                return Ok(part);
            }
            let now = Instant::now();
            if now >= until {
                // A planner that was killed counts as connected until it is cleared away.
                self.connection.node.sweep();
                if !self.awaited.is_connected() {
                    return Err(self.connection.lost());
                }
                let waited = now - begin;
                return Err(CallError::TimedOut { waited, limit: until - begin });
            }
            let Connection { bell, how, .. } = &**self.connection;
            let planner = self.connection.planner();
            let others = planner.iter().map(|planner| planner.as_fd());
            let has_response = || self.awaited.has_response();
            let woken = wait::wait(*how, (bell.as_ref(), others), Some(until), has_response);
            if woken == Woken::Terminate {
                return Err(CallError::Interrupted);
            }
            if !has_response() {
                self.look_after_planner(planner.as_deref(), now.elapsed() >= wait::NET);
            }
        }
    }

    /// Finds out whether the planner has died, if it looks so or it is time to.
    fn look_after_planner(&self, planner: Option<&Process>, is_due: bool) {
        let has_ended = planner.is_some_and(Process::has_ended);
        if has_ended || is_due {
            self.connection.node.sweep();
        }
        if has_ended && self.awaited.is_connected() {
            // Another serves this request, or somebody else is clearing the dead one away.
            self.connection.set_planner(planner_of(&self.connection.plan));
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Waits for the whole reply, at most until `until`.
    pub fn wait(&mut self, until: Instant) -> Result<Reply, CallError> {
        self.wait_for_all(until, &mut 0)
    }

    /// The same, and counts the parts.
    pub(super) fn wait_for_all(
        &mut self,
        until: Instant,
        parts: &mut usize,
    ) -> Result<Reply, CallError> {
        let mut assembler = ReplyAssembler::default();
        let begin = Instant::now();
        loop {
            let part = self.wait_part(until)?;
            *parts += 1;
            if let Some(reply) = assembler.push(part)? {
                return Ok(reply);
            }
            // Parts can come so fast that there is always one.
            let now = Instant::now();
            if now >= until {
                return Err(CallError::TimedOut { waited: now - begin, limit: until - begin });
            }
        }
    }

    /// Prepares for waiting elsewhere, by an event loop: to be called *before* a last look for
    /// parts. A part that comes after that, or that has come since the last call, makes
    /// [`Pending::bell`] readable. As rings can be lost and planners can die, look every
    /// [`wait::NET`] anyway.
    pub fn silence(&self) {
        if let Some(bell) = &self.connection.bell
            && !self.connection.is_copy()
        {
            wait::silence(bell);
            let planner = self.connection.planner();
            self.look_after_planner(planner.as_deref(), false);
        }
    }

    /// A file descriptor that can be read when there is something to look for, unless the client
    /// polls. It stays open as long as the client.
    pub fn bell(&self) -> Option<RawFd> {
        let bell = self.connection.bell.as_ref()?;
        #[expect(unsafe_code, reason = "iceoryx2 lends its file descriptor as a number only")]
        // SAFETY: it stays open as long as the listener, which is borrowed here.
        let bell = unsafe { BorrowedFd::borrow_raw(bell.file_descriptor().native_handle()) };
        Some(bell.as_raw_fd())
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        if self.awaited.is_copy() {
            return;
        }
        // The next request in this place needs the room.
        while let Ok(Some(_)) = self.awaited.receive() {}
        if !self.has_last.get() {
            self.connection.note_dropped();
        }
    }
}
