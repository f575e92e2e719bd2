//! What the cache holds, for all workspaces together.

use std::any::Any;
use std::sync::Arc;

use foldhash::fast::FixedState;
use hashlink::LinkedHashMap;
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
    entries: LinkedHashMap<Arc<[u64]>, Entry, FixedState>,
    /// The most entries since the map last shrank.
    most_entries: usize,
    stats: CacheStats,
}

/// What is cached.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) made: Arc<dyn Any + Send + Sync>,
    pub(crate) bytes: usize,
    /// What making it drew from the budget. A request that finds it draws the same, once.
    pub(crate) cost: Cost,
}

/// Memory of the map per entry: a node with two links, and two slots of its table.
pub(crate) const ENTRY_BYTES: usize =
    size_of::<Arc<[u64]>>() + size_of::<Entry>() + 2 * size_of::<usize>() + 2 * 9;

impl Entries {
    /// An empty cache that holds at most `most_bytes` from one request to the next.
    pub(crate) fn new(most_bytes: usize) -> Self {
        Self {
            most_bytes,
            elsewhere: 0,
            entries: LinkedHashMap::with_hasher(FixedState::default()),
            most_entries: 0,
            stats: CacheStats::default(),
        }
    }

    pub(crate) fn stats(&self) -> CacheStats {
        self.stats
    }

    /// Memory elsewhere that counts against the bound was `before` and is `now`.
    pub(crate) fn count_elsewhere(&mut self, before: usize, now: usize) {
        self.elsewhere = self.elsewhere.saturating_sub(before) + now;
    }

    /// The entry made from this content, which is used now.
    pub(crate) fn find(&mut self, content: &[u64]) -> Option<(Arc<[u64]>, Entry)> {
        // Most often it is the last one used.
        let last = self.entries.iter().next_back();
        if let Some((key, entry)) = last.filter(|(last, _)| ***last == *content) {
            return Some((Arc::clone(key), entry.clone()));
        }
        self.entries.to_back(content)?;
        let (key, entry) = self.entries.iter().next_back()?;
        Some((Arc::clone(key), entry.clone()))
    }

    pub(crate) fn insert(&mut self, content: Arc<[u64]>, entry: Entry) {
        self.stats.bytes += entry.bytes;
        if let Some(replaced) = self.entries.insert(content, entry) {
            self.stats.bytes -= replaced.bytes;
        }
        self.most_entries = self.most_entries.max(self.entries.len());
        self.stats.entries = self.entries.len();
    }

    /// Takes out what no longer fits the bound, after a request that used `used`.
    pub(crate) fn evict(&mut self, used: &mut Used) -> Evicted {
        let most = self.most_bytes.saturating_sub(self.elsewhere);
        let mut evicted = Vec::new();
        // An entry that is too large by itself should not evict the others.
        for (content, _) in used.entries.iter().filter(|(_, entry)| entry.bytes > most) {
            evicted.extend(self.entries.remove(content));
        }
        let too_large: usize = evicted.iter().map(|entry| entry.bytes).sum();
        self.stats.bytes -= too_large;
        while self.stats.bytes > most || self.entries.len() > MOST_ENTRIES {
            let Some((_, entry)) = self.entries.pop_front() else { break };
            self.stats.bytes -= entry.bytes;
            evicted.push(entry);
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
pub(crate) struct Evicted(#[expect(dead_code, reason = "only dropped")] Vec<Entry>);

/// What a request has found or made so far. It stays until the request ends, whatever others do
/// to the cache meanwhile.
#[derive(Debug, Default)]
pub(crate) struct Used {
    entries: Vec<(Arc<[u64]>, Entry)>,
    pub(crate) misses: u64,
}

impl Used {
    /// Whether all was there: the cache has not grown.
    pub(crate) fn was_there(&self) -> bool {
        self.misses == 0
    }

    pub(crate) fn add(&mut self, content: Arc<[u64]>, entry: Entry) {
        self.entries.push((content, entry));
    }

    pub(crate) fn find(&self, content: &[u64]) -> Option<&Entry> {
        let mut latest_first = self.entries.iter().rev();
        Some(&latest_first.find(|(used, _)| **used == *content)?.1)
    }

    /// The request has ended.
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
    }
}
