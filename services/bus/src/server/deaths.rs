//! Clients whose end is to be noticed at once.

use std::os::fd::{AsFd, BorrowedFd};

use iceoryx2::identifiers::UniqueNodeId;

use crate::process::Process;

/// The processes of clients that wait for a reply.
#[derive(Debug, Default)]
pub(super) struct Deaths(Vec<(UniqueNodeId, Process)>);

impl Deaths {
    pub(super) fn watch(&mut self, node: UniqueNodeId) {
        if self.0.iter().any(|(watched, _)| *watched == node) {
            return;
        }
        self.0.extend(Process::of(node).map(|process| (node, process)));
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Each can be read when its process has ended.
    pub(super) fn processes(&self) -> impl Iterator<Item = BorrowedFd<'_>> {
        self.0.iter().map(|(_, process)| process.as_fd())
    }

    /// Whether any of them has ended.
    pub(super) fn any(&self) -> bool {
        self.0.iter().any(|(_, process)| process.has_ended())
    }

    /// Watches only those that live on.
    pub(super) fn forget_dead(&mut self) {
        self.0.retain(|(_, process)| !process.has_ended());
    }
}
