//! Free spaces that were sent with a name, so that later requests need only the name.

use std::sync::Arc;

use foldhash::fast::FixedState;
use hashlink::LinkedHashMap;
use schemas::message::{Digest, FreeSpace};

use crate::scene;

/// The free spaces used last, bounded in bytes.
///
/// A request that gives a name alone is answered as if it carried the free space itself, byte for
/// byte, unless the name is not known.
#[derive(Debug)]
pub(crate) struct Uploads {
    most_bytes: usize,
    bytes: usize,
    /// From the least to the most recently used.
    known: LinkedHashMap<Digest, Arc<FreeSpace>, FixedState>,
}

impl Uploads {
    pub(crate) fn new(most_bytes: usize) -> Self {
        let known = LinkedHashMap::with_hasher(FixedState::default());
        Self { most_bytes, bytes: 0, known }
    }

    /// The memory that they take, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes
    }

    /// The free space of this name, which is used now.
    pub(crate) fn find(&mut self, name: Digest) -> Option<Arc<FreeSpace>> {
        self.known.to_back(&name).cloned()
    }

    /// Keeps a free space, and drops the least recently used ones until the bound holds.
    pub(crate) fn insert(&mut self, name: Digest, free_space: Arc<FreeSpace>) {
        let bytes = scene::free_space_bytes(&free_space);
        if bytes <= self.most_bytes {
            if let Some(before) = self.known.insert(name, free_space) {
                self.bytes -= scene::free_space_bytes(&before);
            }
            self.bytes += bytes;
        }
        while self.bytes > self.most_bytes {
            let Some((_, oldest)) = self.known.pop_front() else { break };
            self.bytes -= scene::free_space_bytes(&oldest);
        }
    }
}
