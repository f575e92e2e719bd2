//! How a process ends a request before it is answered.

use std::cell::Cell;
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering, fence};

use planning::budget::StopSignal;
use schemas::message::{ErrorCode, Refusal};

/// The caller is called once in so many looks at the flag, which are 1,024 steps apart: several
/// times in a millisecond.
const LOOKS_PER_CALL: u32 = 8;

/// Why a process ends a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// The request's deadline has passed: what is not answered yet is refused as
    /// `deadline_exceeded`.
    Deadline,
    /// The client has left. The sink reports it when the next part is written.
    ClientLeft,
    /// Somebody else answers the request, from its beginning: nothing more is to be written here.
    /// The sink reports it when the next part is written.
    HandedOver,
    /// The process ends: what is not answered yet is refused as `overloaded`.
    Shutdown,
}

impl StopReason {
    /// What is said of the answers that a request which is ended for it still lacks.
    pub fn refusal(self) -> Refusal {
        match self {
            Self::Shutdown => {
                let message = "the planner is shutting down; send the request again";
                Refusal::new(ErrorCode::Overloaded, message)
            }
            Self::ClientLeft | Self::HandedOver => {
                // Nobody reads it.
                Refusal::new(ErrorCode::DeadlineExceeded, "the client left before the answer")
            }
            Self::Deadline => {
                let message = "the deadline passed before the answer was found; allow more time, \
                               or simplify the scene";
                let field = Some("deadline".to_owned());
                Refusal { field, ..Refusal::new(ErrorCode::DeadlineExceeded, message) }
            }
        }
    }

    const ALL: [Self; 4] = [Self::Deadline, Self::ClientLeft, Self::HandedOver, Self::Shutdown];
}

/// Ends a request that is being answered, from another thread or a signal handler.
///
/// The request looks at the flag at least once in 1,024 steps of its budget, which take less
/// than a millisecond. Answers that are already being written are written to their end, so
/// that every trajectory in a reply is whole. Set once; the first reason stands.
#[derive(Debug, Default)]
pub struct StopFlag {
    stopped: AtomicBool,
    /// 0, or the place of the reason in [`StopReason::ALL`] and 1.
    reason: AtomicU8,
}

impl StopFlag {
    /// A flag that is not set.
    pub const fn new() -> Self {
        Self { stopped: AtomicBool::new(false), reason: AtomicU8::new(0) }
    }

    /// Ends the request. Has no effect if it was ended before.
    pub fn stop(&self, reason: StopReason) {
        let first =
            self.reason.compare_exchange(0, reason as u8 + 1, Ordering::Relaxed, Ordering::Relaxed);
        if first.is_ok() {
            self.stopped.store(true, Ordering::Release);
        }
    }

    /// Why the request was ended, if it was.
    pub fn reason(&self) -> Option<StopReason> {
        if !self.stopped.load(Ordering::Relaxed) {
            return None;
        }
        // The reason was written before the flag.
        fence(Ordering::Acquire);
        let place = usize::from(self.reason.load(Ordering::Relaxed)).checked_sub(1)?;
        StopReason::ALL.get(place).copied()
    }
}

/// What the budget of a request looks at: the flag. Now and then it calls the caller, who may set
/// the flag, or do something else meanwhile.
pub(crate) struct Watched<'a> {
    stop: &'a StopFlag,
    meanwhile: &'a dyn Fn(),
    looks: Cell<u32>,
}

impl<'a> Watched<'a> {
    pub(crate) fn new(stop: &'a StopFlag, meanwhile: &'a dyn Fn()) -> Self {
        Self { stop, meanwhile, looks: Cell::new(0) }
    }
}

impl fmt::Debug for Watched<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Watched").field("stop", self.stop).finish_non_exhaustive()
    }
}

impl StopSignal for Watched<'_> {
    fn is_set(&self) -> bool {
        let looks = self.looks.get().wrapping_add(1);
        self.looks.set(looks);
        if looks.is_multiple_of(LOOKS_PER_CALL) {
            (self.meanwhile)();
        }
        self.stop.stopped.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_reason_stands() {
        for reason in StopReason::ALL {
            let flag = StopFlag::new();
            assert_eq!(flag.reason(), None);
            flag.stop(reason);
            flag.stop(StopReason::Deadline);
            assert_eq!(flag.reason(), Some(reason));
        }
    }
}
