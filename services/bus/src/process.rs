//! Learning at once that a peer has died.

use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::prelude::ipc;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, pidfd_open};

/// The process of a node.
///
/// Where it can't be watched, as in another container, a sweep finds its end. Where its number is
/// that of a stranger here, the stranger's end only makes a sweep come early.
#[derive(Debug)]
pub(crate) struct Process(OwnedFd);

impl Process {
    /// The process of this node, if it can be watched.
    pub(crate) fn of(node: UniqueNodeId) -> Option<Self> {
        let number = node.pid::<ipc::Service>().ok()?;
        pidfd_open(Pid::from_raw(number.value())?, PidfdFlags::empty()).ok().map(Self)
    }

    pub(crate) fn has_ended(&self) -> bool {
        let now = Timespec { tv_sec: 0, tv_nsec: 0 };
        poll(&mut [PollFd::new(self, PollFlags::IN)], Some(&now)).is_ok_and(|ended| ended > 0)
    }
}

impl AsFd for Process {
    /// It can be read once the process has ended.
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}
