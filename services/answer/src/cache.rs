//! What was made from a free space, kept for later requests over the same one.
//!
//! The cache keeps what is expensive to make: channels and their junctions ([`Graph`]), walls and
//! their index ([`Walls`]), and the free boxes that explain refusals. The key is the whole content
//! that an entry was made from, and a request that finds an entry draws from its budget what
//! making it would have drawn. So the cache changes no reply.
//!
//! Entries that a request uses stay until it ends, even beyond the bound: its exits and answers
//! share them. Then the least recently used are dropped until the bound holds.

use std::any::Any;
use std::sync::Arc;

use foldhash::fast::FixedState;
use hashlink::LinkedHashMap;
use planning::budget::{Budget, Cost, Spent};
use planning::free_space::graph::Graph;
use planning::free_space::walls::Walls;
use planning::geometry::{AxisBox, HalfSpace, Sign};

/// The bytes may allow more entries, but ones so small are made as fast as they are found.
const MOST_ENTRIES: usize = 4096;

/// Hits, misses and size of a workspace's cache.
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

/// A value that can be cached.
pub(crate) trait Cached: Any + Send + Sync {
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

    pub(crate) fn numbers(&mut self, numbers: &[f64]) {
        self.0.extend(numbers.iter().map(|number| number.to_bits()));
    }

    pub(crate) fn boxes<const D: usize>(&mut self, boxes: &[AxisBox<D>]) {
        self.0.reserve(2 * D * boxes.len());
        for sides in boxes {
            self.numbers(sides.min().as_slice());
            self.numbers(sides.max().as_slice());
        }
    }

    pub(crate) fn mouth(&mut self, mouth: Option<HalfSpace>) {
        self.word(u64::from(mouth.is_some()));
        if let Some(HalfSpace { side, bound }) = mouth {
            self.word((side.axis as u64) << 1 | u64::from(side.sign == Sign::Positive));
            self.numbers(&[bound]);
        }
    }
}

/// Words written and compared per step of the budget.
const WORDS_PER_STEP: u64 = 16;

/// An LRU cache bounded in bytes.
#[derive(Debug)]
pub(crate) struct Cache {
    most_bytes: usize,
    /// The number of the request.
    request: u64,
    /// The key being looked up.
    content: Content,
    /// By content, from the least to the most recently used.
    entries: LinkedHashMap<Box<[u64]>, Entry, FixedState>,
    /// The most entries since the map last shrank.
    most_entries: usize,
    stats: CacheStats,
}

#[derive(Debug)]
struct Entry {
    made: Arc<dyn Any + Send + Sync>,
    bytes: usize,
    /// The last request that used it.
    request: u64,
    /// What making it drew from the budget. A request that finds it draws the same, once.
    cost: Cost,
}

/// Memory of the map per entry: a node with two links, and two slots of its table.
const ENTRY_BYTES: usize =
    size_of::<Box<[u64]>>() + size_of::<Entry>() + 2 * size_of::<usize>() + 2 * 9;

impl Cache {
    /// An empty cache that holds at most `most_bytes` from one request to the next.
    pub(crate) fn new(most_bytes: usize) -> Self {
        Self {
            most_bytes,
            request: 0,
            content: Content::default(),
            entries: LinkedHashMap::with_hasher(FixedState::default()),
            most_entries: 0,
            stats: CacheStats::default(),
        }
    }

    pub(crate) fn stats(&self) -> CacheStats {
        self.stats
    }

    /// Memory of the key's buffer, bytes.
    pub(crate) fn content_bytes(&self) -> usize {
        self.content.0.capacity() * size_of::<u64>()
    }

    /// Frees the key's buffer.
    pub(crate) fn release_content(&mut self) {
        self.content = Content::default();
    }

    /// The bound, bytes.
    pub(crate) fn most_bytes(&self) -> usize {
        self.most_bytes
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
    ) -> Result<Arc<T>, E> {
        budget.step(self.content.0.len() as u64 / WORDS_PER_STEP)?;
        if let Some(made) = self.find(budget) {
            self.stats.hits += 1;
            return Ok(made);
        }
        self.stats.misses += 1;
        let (made, cost) = budget.measure(|| {
            budget.hold(size_of_val::<[u64]>(&self.content.0) + ENTRY_BYTES)?;
            make()
        });
        let made = Arc::new(made?);
        let content: Box<[u64]> = self.content.0.as_slice().into();
        let bytes = size_of_val::<[u64]>(&content) + size_of::<T>() + made.bytes() + ENTRY_BYTES;
        let entry = Entry { made: made.clone(), bytes, request: self.request, cost };
        self.stats.bytes += bytes;
        if let Some(replaced) = self.entries.insert(content, entry) {
            self.stats.bytes -= replaced.bytes;
        }
        self.most_entries = self.most_entries.max(self.entries.len());
        self.stats.entries = self.entries.len();
        Ok(made)
    }

    /// The cached entry, if the budget would be enough to make it.
    fn find<T: Cached>(&mut self, budget: &Budget<'_>) -> Option<Arc<T>> {
        let content = self.content.0.as_slice();
        // Most often it is the last one used.
        let last = self.entries.iter_mut().next_back();
        let entry = match last.filter(|(last, _)| ***last == *content) {
            Some((_, entry)) => entry,
            None => self.entries.to_back(content)?,
        };
        let made = Arc::downcast(entry.made.clone()).ok()?;
        if entry.request != self.request && !budget.repeat(&entry.cost) {
            return None;
        }
        entry.request = self.request;
        Some(made)
    }

    /// Drops entries until they fit the bound less `elsewhere` bytes.
    pub(crate) fn end_request(&mut self, elsewhere: usize) {
        let most = self.most_bytes.saturating_sub(elsewhere);
        // An entry that is too large by itself should not evict the others.
        let request = self.request;
        let used = self.entries.iter().rev().map(|(_, entry)| entry);
        let mut used = used.take_while(|entry| entry.request == request);
        if used.any(|entry| entry.bytes > most) {
            self.entries.retain(|_, entry| entry.bytes <= most);
            self.stats.bytes = self.entries.iter().map(|(_, entry)| entry.bytes).sum();
        }
        while self.stats.bytes > most || self.entries.len() > MOST_ENTRIES {
            let Some((_, entry)) = self.entries.pop_front() else { break };
            self.stats.bytes -= entry.bytes;
        }
        if self.most_entries > 2 * self.entries.len() {
            self.entries.shrink_to_fit();
            self.most_entries = self.entries.len();
        }
        self.stats.entries = self.entries.len();
        self.request += 1;
    }
}

#[cfg(test)]
mod tests;
