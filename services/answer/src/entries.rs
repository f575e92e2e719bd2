//! What the cache holds, for all workspaces together.

use std::any::Any;
use std::borrow::Borrow;
use std::fmt::Debug;
use std::hash::{Hash, Hasher};
use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use foldhash::fast::FixedState;
use hashlink::LinkedHashSet;
use planning::budget::Cost;

/// The bytes may allow more entries, but ones so small are made as fast as they are found.
pub(crate) const MOST_ENTRIES: usize = 4096;

/// Hits, misses and size of the cache.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CacheStats {
    /// Look-ups that found an entry.
    pub hits: u64,
    /// Look-ups that had to make it.
    pub misses: u64,
    /// Entries held.
    pub entries: usize,
    /// Their memory, bytes.
    pub bytes: usize,
}

/// What all workspaces keep together: an LRU cache bounded in bytes.
#[derive(Debug)]
pub(crate) struct Entries {
    most_bytes: usize,
    /// Memory of the workspaces and of uploads, which counts against the bound.
    elsewhere: usize,
    /// By content, from the least to the most recently used.
    entries: LinkedHashSet<ByContent, FixedState>,
    /// The most entries since the set last shrank.
    most_entries: usize,
    /// Changes of the order and of what is in it. While there is none, the entry used last is
    /// still the last, which can be told without a lock.
    changes: Arc<AtomicU64>,
    stats: CacheStats,
}

/// What is cached.
#[derive(Debug)]
pub(crate) struct Entry<T> {
    pub(crate) head: Head,
    pub(crate) made: T,
}

/// What is known of an entry of any kind.
#[derive(Debug)]
pub(crate) struct Head {
    /// What it is made from: the key.
    pub(crate) content: Box<[u64]>,
    pub(crate) bytes: usize,
    /// What making it drew from the budget. A request that finds it draws the same, once.
    pub(crate) cost: Cost,
}

impl<T> Deref for Entry<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.made
    }
}

/// An entry of any kind.
pub(crate) trait AnyEntry: Any + Debug + Send + Sync {
    fn head(&self) -> &Head;
}

impl<T: Any + Debug + Send + Sync> AnyEntry for Entry<T> {
    fn head(&self) -> &Head {
        &self.head
    }
}

/// An entry as the set finds it.
#[derive(Debug)]
struct ByContent(Arc<dyn AnyEntry>);

impl Borrow<[u64]> for ByContent {
    fn borrow(&self) -> &[u64] {
        &self.0.head().content
    }
}

impl Hash for ByContent {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.head().content.hash(state);
    }
}

impl PartialEq for ByContent {
    fn eq(&self, other: &Self) -> bool {
        self.0.head().content == other.0.head().content
    }
}

impl Eq for ByContent {}

/// Memory per entry: what is known of it, and in the set a node with two links and two slots of
/// its table.
pub(crate) const ENTRY_BYTES: usize =
    size_of::<Head>() + size_of::<ByContent>() + 2 * size_of::<usize>() + 2 * 9;

impl Entries {
    /// An empty cache that holds at most `most_bytes` from one request to the next.
    pub(crate) fn new(most_bytes: usize) -> Self {
        Self {
            most_bytes,
            elsewhere: 0,
            entries: LinkedHashSet::with_hasher(FixedState::default()),
            most_entries: 0,
            changes: Arc::default(),
            stats: CacheStats::default(),
        }
    }

    /// The count of changes, to be read without a lock.
    pub(crate) fn changes(&self) -> &Arc<AtomicU64> {
        &self.changes
    }

    fn count_change(&self) {
        self.changes.fetch_add(1, Ordering::Release);
    }

    pub(crate) fn stats(&self) -> CacheStats {
        self.stats
    }

    /// Memory elsewhere that counts against the bound was `before` and is `now`.
    pub(crate) fn count_elsewhere(&mut self, before: usize, now: usize) {
        self.elsewhere = self.elsewhere.saturating_sub(before) + now;
    }

    /// The entry made from this content, which is used now.
    pub(crate) fn find(&mut self, content: &[u64]) -> Option<Arc<dyn AnyEntry>> {
        // Most often it is the last one used.
        let ByContent(last) = self.entries.back()?;
        if *last.head().content == *content {
            return Some(Arc::clone(last));
        }
        if !self.entries.to_back(content) {
            return None;
        }
        self.count_change();
        self.entries.back().map(|ByContent(entry)| Arc::clone(entry))
    }

    /// Keeps an entry that is used now; unless it is too large by itself, which is at once left to
    /// the request that made it. Whether it is kept.
    pub(crate) fn insert(&mut self, entry: &Arc<dyn AnyEntry>) -> bool {
        let Head { content, bytes, .. } = entry.head();
        if *bytes > self.most() {
            return false;
        }
        self.stats.bytes += bytes;
        if let Some(ByContent(replaced)) = self.entries.replace(ByContent(Arc::clone(entry))) {
            // Two made it at a time.
            self.stats.bytes -= replaced.head().bytes;
            self.entries.to_back(&**content);
        }
        self.count_change();
        self.most_entries = self.most_entries.max(self.entries.len());
        self.stats.entries = self.entries.len();
        true
    }

    /// The most that entries may take, bytes.
    fn most(&self) -> usize {
        self.most_bytes.saturating_sub(self.elsewhere)
    }

    /// Takes out what no longer fits the bound, after a request that used `used`.
    pub(crate) fn evict(&mut self, used: &mut Used) -> Evicted {
        let most = self.most();
        let mut evicted = Vec::new();
        // An entry that is too large by itself by now should not evict the others.
        for head in used.entries.iter().map(|entry| entry.head()).filter(|head| head.bytes > most) {
            evicted.extend(self.entries.take(&*head.content));
        }
        let too_large: usize = evicted.iter().map(|ByContent(entry)| entry.head().bytes).sum();
        self.stats.bytes -= too_large;
        while self.stats.bytes > most || self.entries.len() > MOST_ENTRIES {
            let Some(oldest) = self.entries.pop_front() else { break };
            self.stats.bytes -= oldest.0.head().bytes;
            evicted.push(oldest);
        }
        if !evicted.is_empty() {
            self.count_change();
        }
        if self.most_entries > 2 * self.entries.len() {
            self.entries.shrink_to_fit();
            self.most_entries = self.entries.len();
        }
        self.stats.entries = self.entries.len();
        self.stats.misses += std::mem::take(&mut used.misses);
        Evicted(evicted)
    }
}

/// Entries to be freed, best not while others wait for the cache.
#[must_use]
pub(crate) struct Evicted(#[expect(dead_code, reason = "only dropped")] Vec<ByContent>);

/// What a request has found or made so far. It stays until the request ends, whatever others do
/// to the cache meanwhile.
#[derive(Debug, Default)]
pub(crate) struct Used {
    entries: Vec<Arc<dyn AnyEntry>>,
    pub(crate) misses: u64,
}

impl Used {
    /// Whether all was there: the cache has not grown.
    pub(crate) fn was_there(&self) -> bool {
        self.misses == 0
    }

    pub(crate) fn add(&mut self, entry: Arc<dyn AnyEntry>) {
        self.entries.push(entry);
    }

    pub(crate) fn find(&self, content: &[u64]) -> Option<&Arc<dyn AnyEntry>> {
        self.entries.iter().rev().find(|used| *used.head().content == *content)
    }

    /// The request has ended.
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
    }
}
