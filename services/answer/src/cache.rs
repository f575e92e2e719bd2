//! What was made from a free space, kept for later requests over the same one.
//!
//! The cache keeps what is expensive to make: channels and their junctions ([`Graph`]), walls and
//! their index ([`Walls`]), and the free boxes that explain refusals. The key is the whole content
//! that an entry was made from, and a request that finds an entry draws from its budget what
//! making it would have drawn. So the cache changes no reply.
//!
//! Workspaces share the cache. Entries that a request uses stay until it ends, even beyond the
//! bound: its exits and answers share them. Then the least recently used are dropped until the
//! bound holds.

use std::any::Any;
use std::fmt::Debug;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};

use planning::budget::{Budget, Spent};
use planning::free_space::Mouth;
use planning::free_space::graph::Graph;
use planning::free_space::walls::Walls;
use planning::geometry::{AxisBox, HalfSpace, Sign};

use crate::entries::{AnyEntry, ENTRY_BYTES, Entry, Head, Used};
use crate::store::{Hits, Store};

/// A value that can be cached.
pub(crate) trait Cached: Any + Debug + Send + Sync {
    /// Its heap memory, bytes.
    fn bytes(&self) -> usize;
}

impl<const D: usize> Cached for Graph<D> {
    fn bytes(&self) -> usize {
        Graph::bytes(self)
    }
}

impl<const D: usize> Cached for Walls<D> {
    fn bytes(&self) -> usize {
        Walls::bytes(self)
    }
}

/// All maximal free boxes among solids, whatever their size; `None` if they cost too much.
#[derive(Debug)]
pub(crate) struct FreeBoxes<const D: usize>(pub(crate) Option<Vec<AxisBox<D>>>);

impl<const D: usize> Cached for FreeBoxes<D> {
    fn bytes(&self) -> usize {
        self.0.as_ref().map_or(0, |boxes| boxes.capacity() * size_of::<AxisBox<D>>())
    }
}

/// What an entry is, and what it is made from.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Kind {
    /// Junctions of channels.
    Junctions,
    /// Channels between solids, and their junctions.
    SolidsJunctions,
    /// Channels between solids for a union of boxes, and their junctions.
    UnionJunctions,
    /// All free boxes between solids.
    SolidsBoxes,
    /// Walls around channels, up to a mouth.
    ChannelsWalls,
    /// Walls of solids.
    SolidsWalls,
    /// The floor between the walls of channels, or of solids.
    ChannelsFloor,
    SolidsFloor,
}

/// Everything that an entry is made from, as 64-bit words: the key.
#[derive(Debug, Default)]
pub(crate) struct Content(Vec<u64>);

impl Content {
    pub(crate) fn word(&mut self, word: u64) {
        self.0.push(word);
    }

    /// Makes room for so many more words.
    pub(crate) fn reserve(&mut self, words: usize) {
        self.0.reserve(words);
    }

    pub(crate) fn numbers(&mut self, numbers: &[f64]) {
        self.0.extend(numbers.iter().map(|number| number.to_bits()));
    }

    pub(crate) fn boxes<const D: usize>(&mut self, boxes: &[AxisBox<D>]) {
        self.reserve(2 * D * boxes.len());
        for sides in boxes {
            self.numbers(sides.min().as_slice());
            self.numbers(sides.max().as_slice());
        }
    }

    pub(crate) fn mouth<const D: usize>(&mut self, mouth: Option<Mouth<D>>) {
        self.word(u64::from(mouth.is_some()));
        if let Some(Mouth { plane: HalfSpace { side, bound }, channel, reach }) = mouth {
            self.word((side.axis as u64) << 1 | u64::from(side.sign == Sign::Positive));
            self.numbers(&[bound, reach]);
            self.boxes(&[channel]);
        }
    }
}

/// Words written and compared per step of the budget.
const WORDS_PER_STEP: u64 = 16;

/// A workspace's access to the cache.
#[derive(Debug)]
pub(crate) struct Cache {
    store: Store,
    /// The key being looked up.
    content: Content,
    pub(crate) used: Used,
    last: Last,
    /// Look-ups of this workspace that found an entry.
    hits: Arc<Hits>,
}

/// The entry that a workspace used last. If nothing has changed since, it is still the most
/// recently used of all, so to use it again changes nothing and needs no lock.
#[derive(Debug)]
struct Last {
    /// Changes so far.
    changes: Arc<AtomicU64>,
    /// As many as there were then.
    at: u64,
    /// Weak, so that what it holds is freed when others evict it.
    entry: Option<Weak<dyn AnyEntry>>,
}

impl Last {
    fn find(&self, content: &[u64]) -> Option<Arc<dyn AnyEntry>> {
        if self.changes.load(Ordering::Acquire) != self.at {
            return None;
        }
        self.entry.as_ref()?.upgrade().filter(|entry| *entry.head().content == *content)
    }

    /// Remembers the entry that is the most recently used now, while the store is locked.
    fn remember(&mut self, entry: &Arc<dyn AnyEntry>) {
        self.at = self.changes.load(Ordering::Relaxed);
        if self
            .entry
            .as_ref()
            .is_none_or(|last| !std::ptr::addr_eq(last.as_ptr(), Arc::as_ptr(entry)))
        {
            self.entry = Some(Arc::downgrade(entry));
        }
    }
}

impl Cache {
    pub(crate) fn new(store: Store) -> Self {
        let hits = store.join();
        let changes = Arc::clone(store.lock().entries.changes());
        let last = Last { changes, at: 0, entry: None };
        Self { store, content: Content::default(), used: Used::default(), last, hits }
    }

    /// The workspace, which kept `bytes` of its own, is gone.
    pub(crate) fn leave(&self, bytes: usize) {
        self.store.leave(&self.hits, bytes);
    }

    /// Memory of the key's buffer, bytes.
    pub(crate) fn content_bytes(&self) -> usize {
        self.content.0.capacity() * size_of::<u64>()
    }

    /// Frees the key's buffer.
    pub(crate) fn release_content(&mut self) {
        self.content = Content::default();
    }

    /// Begins the key that [`Cache::get`] looks up.
    pub(crate) fn describe(&mut self, kind: Kind, dimension: usize) -> &mut Content {
        self.content.0.clear();
        self.content.word((kind as u64) << 8 | dimension as u64);
        &mut self.content
    }

    /// Changes the key to another kind of entry from the same content.
    pub(crate) fn describe_again(&mut self, kind: Kind, dimension: usize) {
        if let Some(word) = self.content.0.first_mut() {
            *word = (kind as u64) << 8 | dimension as u64;
        }
    }

    /// The entry with the key described, made now if it is not cached.
    pub(crate) fn get<T: Cached, E: From<Spent>>(
        &mut self,
        budget: &Budget<'_>,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<Arc<Entry<T>>, E> {
        budget.step(self.content.0.len() as u64 / WORDS_PER_STEP)?;
        if let Some(entry) = self.find(budget).and_then(of_kind) {
            self.hits.count();
            return Ok(entry);
        }
        self.used.misses += 1;
        let (made, cost) = budget.measure(|| {
            budget.hold(size_of_val::<[u64]>(&self.content.0) + ENTRY_BYTES)?;
            make()
        });
        let made = made?;
        let content: Box<[u64]> = self.content.0.as_slice().into();
        let bytes = size_of_val::<[u64]>(&content) + size_of::<T>() + made.bytes() + ENTRY_BYTES;
        let made = Arc::new(Entry { head: Head { content, bytes, cost }, made });
        let entry: Arc<dyn AnyEntry> = made.clone();
        let mut kept = self.store.lock();
        if kept.entries.insert(&entry) {
            self.last.remember(&entry);
        }
        drop(kept);
        self.used.add(entry);
        Ok(made)
    }

    /// The entry, if this request has used it already; or if it is cached and the budget would be
    /// enough to make it.
    fn find(&mut self, budget: &Budget<'_>) -> Option<Arc<dyn AnyEntry>> {
        let content = self.content.0.as_slice();
        if let Some(entry) = self.used.find(content) {
            return Some(Arc::clone(entry));
        }
        let entry = match self.last.find(content) {
            Some(entry) => entry,
            None => {
                let mut kept = self.store.lock();
                let entry = kept.entries.find(content)?;
                self.last.remember(&entry);
                entry
            }
        };
        if !budget.repeat(&entry.head().cost) {
            return None;
        }
        self.used.add(Arc::clone(&entry));
        Some(entry)
    }
}

/// The entry, if it is of the kind that its key says.
fn of_kind<T: Cached>(entry: Arc<dyn AnyEntry>) -> Option<Arc<Entry<T>>> {
    let entry: Arc<dyn Any + Send + Sync> = entry;
    Arc::downcast(entry).ok()
}

#[cfg(test)]
mod tests;
