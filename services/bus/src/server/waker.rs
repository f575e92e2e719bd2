//! Waking a server that waits, from other threads.

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rustix::event::{EventfdFlags, eventfd};

/// Wakes the server that it is from.
#[derive(Debug, Clone)]
pub struct Waker(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    woken: AtomicBool,
    bell: OwnedFd,
}

impl Waker {
    pub(super) fn new() -> std::io::Result<Self> {
        let bell = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?;
        Ok(Self(Arc::new(Shared { woken: AtomicBool::new(false), bell })))
    }

    /// The next or present wait of the server ends at once.
    pub fn wake(&self) {
        if !self.0.woken.swap(true, Ordering::Release) {
            // It can only be full, which wakes as well.
            let _ = rustix::io::write(&self.0.bell, &1_u64.to_ne_bytes());
        }
    }

    pub(super) fn is_woken(&self) -> bool {
        self.0.woken.load(Ordering::Acquire)
    }

    /// From now on it is not woken. What was done before [`Waker::wake`] is seen.
    pub(super) fn reset(&self) {
        if self.is_woken() {
            // What is done between the two is seen as well: whoever resets looks afterwards.
            let _ = rustix::io::read(&self.0.bell, &mut [0_u8; 8]);
            self.0.woken.store(false, Ordering::Release);
        }
    }
}

impl AsFd for Waker {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.bell.as_fd()
    }
}
