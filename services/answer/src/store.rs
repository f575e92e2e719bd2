//! What is kept from one request to the next, by all workspaces together.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use schemas::message::{Digest, FreeSpace};

use crate::entries::{CacheStats, Entries};
use crate::uploads::Uploads;

/// Each kind of buffer, and uploads, may keep this fraction (1/4) of the bound.
pub(crate) const SHARE: usize = 4;

/// What is kept for later requests: what was made from free spaces, and free spaces by their
/// name. Clones are the same store, and [`Workspace`](crate::Workspace)s on several threads can
/// share it. It changes no reply, but that the name of a free space is known to all of them.
#[derive(Debug, Clone)]
pub struct Store(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    kept: Mutex<Kept>,
    most_bytes: usize,
    workspaces: AtomicUsize,
}

/// Look-ups of a workspace that found an entry; only it counts them. On a cache line of its own,
/// for they count at every request.
#[derive(Debug, Default)]
#[repr(align(64))]
pub(crate) struct Hits(AtomicU64);

impl Hits {
    pub(crate) fn count(&self) {
        self.0.store(self.0.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
    }
}

#[derive(Debug)]
pub(crate) struct Kept {
    pub(crate) entries: Entries,
    pub(crate) uploads: Uploads,
    /// Of each workspace.
    hits: Vec<Arc<Hits>>,
    /// Of workspaces that are gone.
    hits_before: u64,
}

impl Store {
    /// A store that keeps at most `bytes` from one request to the next, the buffers of its
    /// workspaces included.
    pub fn new(bytes: usize) -> Self {
        Self::with_uploads(bytes, bytes / SHARE)
    }

    /// The same, with a bound of its own for named free spaces, bytes.
    pub(crate) fn with_uploads(bytes: usize, uploads: usize) -> Self {
        let kept = Kept {
            entries: Entries::new(bytes),
            uploads: Uploads::new(uploads),
            hits: Vec::new(),
            hits_before: 0,
        };
        Self(Arc::new(Shared {
            kept: Mutex::new(kept),
            most_bytes: bytes,
            workspaces: AtomicUsize::new(0),
        }))
    }

    /// Statistics of the cache since the store was made.
    pub fn cache_stats(&self) -> CacheStats {
        let kept = self.lock();
        let hits = kept.hits.iter().map(|hits| hits.0.load(Ordering::Relaxed)).sum::<u64>();
        CacheStats { hits: kept.hits_before + hits, ..kept.entries.stats() }
    }

    /// The free space that is known by this name, which it has beside its content.
    pub fn named(&self, name: Digest) -> Option<Arc<FreeSpace>> {
        self.lock().uploads.find(name)
    }

    /// What each workspace may keep of each kind of buffer, bytes.
    pub(crate) fn most_of_a_buffer(&self) -> usize {
        let workspaces = self.0.workspaces.load(Ordering::Relaxed).max(1);
        self.0.most_bytes / (SHARE * workspaces)
    }

    /// Another workspace keeps its hits here.
    pub(crate) fn join(&self) -> Arc<Hits> {
        self.0.workspaces.fetch_add(1, Ordering::Relaxed);
        let hits = Arc::<Hits>::default();
        self.lock().hits.push(Arc::clone(&hits));
        hits
    }

    /// A workspace with these hits that kept `bytes` of its own is gone.
    pub(crate) fn leave(&self, hits: &Arc<Hits>, bytes: usize) {
        self.0.workspaces.fetch_sub(1, Ordering::Relaxed);
        let mut kept = self.lock();
        kept.entries.count_elsewhere(bytes, 0);
        kept.hits.retain(|kept| !Arc::ptr_eq(kept, hits));
        kept.hits_before += hits.0.load(Ordering::Relaxed);
    }

    pub(crate) fn lock(&self) -> MutexGuard<'_, Kept> {
        // A panic while it was locked leaves at worst an entry more or less.
        self.0.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
