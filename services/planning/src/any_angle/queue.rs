//! What a search looks at next.

use std::cmp::Ordering;

/// An entry of a [`BinaryHeap`](std::collections::BinaryHeap), which gives the least first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Queued {
    /// The least that a way through it can be, metres.
    pub(super) least: f64,
    /// What it is about; of ties the least comes first.
    pub(super) index: usize,
}

impl Ord for Queued {
    fn cmp(&self, other: &Self) -> Ordering {
        other.least.total_cmp(&self.least).then(other.index.cmp(&self.index))
    }
}

impl PartialOrd for Queued {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Queued {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Queued {}
