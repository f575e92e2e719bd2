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
use std::sync::Arc;

use planning::budget::{Budget, Spent};
use planning::free_space::graph::Graph;
use planning::free_space::walls::Walls;
use planning::geometry::{AxisBox, HalfSpace, Sign};

use crate::entries::{ENTRY_BYTES, Entry, Used};
use crate::store::Store;

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

/// A workspace's access to the cache.
#[derive(Debug)]
pub(crate) struct Cache {
    store: Store,
    /// The key being looked up.
    content: Content,
    pub(crate) used: Used,
}

impl Cache {
    pub(crate) fn new(store: Store) -> Self {
        Self { store, content: Content::default(), used: Used::default() }
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
    ) -> Result<Arc<T>, E> {
        budget.step(self.content.0.len() as u64 / WORDS_PER_STEP)?;
        if let Some(made) = self.find(budget) {
            self.store.count_hits(1);
            return Ok(made);
        }
        self.used.misses += 1;
        let (made, cost) = budget.measure(|| {
            budget.hold(size_of_val::<[u64]>(&self.content.0) + ENTRY_BYTES)?;
            make()
        });
        let made = Arc::new(made?);
        let content: Arc<[u64]> = self.content.0.as_slice().into();
        let bytes = size_of_val::<[u64]>(&content) + size_of::<T>() + made.bytes() + ENTRY_BYTES;
        let entry = Entry { made: made.clone(), bytes, cost };
        self.used.add(Arc::clone(&content), entry.clone());
        self.store.lock().entries.insert(content, entry);
        Ok(made)
    }

    /// The entry, if this request has used it already; or if it is cached and the budget would be
    /// enough to make it.
    fn find<T: Cached>(&mut self, budget: &Budget<'_>) -> Option<Arc<T>> {
        let content = self.content.0.as_slice();
        if let Some(entry) = self.used.find(content) {
            return Arc::downcast(entry.made.clone()).ok();
        }
        let (content, entry) = self.store.lock().entries.find(content)?;
        let made = Arc::downcast(entry.made.clone()).ok()?;
        if !budget.repeat(&entry.cost) {
            return None;
        }
        self.used.add(content, entry);
        Some(made)
    }
}

#[cfg(test)]
mod tests;
