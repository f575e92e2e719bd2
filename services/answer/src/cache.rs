//! What requests over the same free space have in common, kept from one to the next.
//!
//! Kept is what takes long to make: the junctions of channels ([`Graph`]), be they given in any
//! order or made from solids, and walls with their index ([`Walls`]), be they the surfaces of solids
//! or the complement of channels. Each is kept beside the content that it was made from, all of it,
//! and given out for equal content only; the hash only finds it. So the cache changes
//! no reply.
//!
//! What a request uses stays until the request ends, so that its exits and answers share it however
//! small the bound is. Then what was used least recently goes until the bound holds.

use std::any::Any;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::mem;
use std::sync::Arc;

use planning::budget::{Budget, Cost};
use planning::free_space::graph::Graph;
use planning::free_space::walls::Walls;
use planning::geometry::AxisBox;

/// More entries than these are small ones, which are made again as fast as found.
const MOST_ENTRIES: usize = 4096;

/// What was found among what a workspace keeps from one request to the next, and what it holds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CacheStats {
    /// How often something was there.
    pub hits: u64,
    /// How often something had to be made.
    pub misses: u64,
    /// How many things it holds.
    pub entries: usize,
    /// The memory that they take, bytes.
    pub bytes: usize,
}

/// What can be kept.
pub(super) trait Keep: Any + Default + Send + Sync {
    /// The memory that it holds.
    fn bytes(&self) -> usize;
}

impl<const D: usize> Keep for Graph<D> {
    fn bytes(&self) -> usize {
        Graph::bytes(self)
    }
}

impl<const D: usize> Keep for Walls<D> {
    fn bytes(&self) -> usize {
        Walls::bytes(self)
    }
}

/// What is made from the content that follows.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    /// Channels and their junctions.
    Junctions,
    /// Solids, and the junctions of the channels that they leave.
    SolidsJunctions,
    /// Channels up to a mouth, and the walls around them.
    ChannelsWalls,
    /// Solids, and the walls that they are.
    SolidsWalls,
}

/// All that something is made from, in words.
#[derive(Debug, Default)]
pub(super) struct Content(Vec<u64>);

impl Content {
    pub(super) fn word(&mut self, word: u64) {
        self.0.push(word);
    }

    pub(super) fn numbers(&mut self, numbers: &[f64]) {
        self.0.extend(numbers.iter().map(|number| number.to_bits()));
    }

    pub(super) fn boxes<const D: usize>(&mut self, boxes: &[AxisBox<D>]) {
        self.0.reserve(2 * D * boxes.len());
        for sides in boxes {
            self.numbers(sides.min().as_slice());
            self.numbers(sides.max().as_slice());
        }
    }

    /// Two words at a time, by folded multiplication.
    fn hash(&self) -> u64 {
        let mut hash = SEEDS[0] ^ self.0.len() as u64;
        for pair in self.0.chunks(2) {
            let second = pair.get(1).copied().unwrap_or_default();
            let product = u128::from(hash ^ pair[0]) * u128::from(SEEDS[1] ^ second);
            hash = product as u64 ^ (product >> 64) as u64;
        }
        hash
    }
}

/// So many words are described, hashed and compared in the time of a step.
const WORDS_PER_STEP: u64 = 4;

const SEEDS: [u64; 2] = [0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7344];

/// Least recently used, bounded in bytes.
#[derive(Debug)]
pub(super) struct Cache {
    most_bytes: usize,
    /// Counts requests.
    request: u64,
    /// Of what is looked for.
    content: Content,
    /// Where a content with this hash is. Of several with one hash only the last is kept.
    places: HashMap<u64, usize, BuildHasherDefault<AsItIs>>,
    /// A ring from the least to the most recently used, which [`END`] closes.
    entries: Vec<Entry>,
    /// Places of `entries` that are in no ring.
    vacant: Vec<usize>,
    stats: CacheStats,
}

/// The entry that is none: before the oldest and behind the newest.
const END: usize = 0;

#[derive(Debug, Default)]
struct Entry {
    older: usize,
    newer: usize,
    hash: u64,
    memory: Memory,
    bytes: usize,
    /// The last that used it.
    request: u64,
    /// What making it drew from the budget of the request that it was made for. A request that
    /// finds it draws the same, once, so that its reply does not depend on what was kept.
    cost: Cost,
}

/// What is kept, beside what it was made from.
#[derive(Debug, Default)]
struct Memory {
    content: Vec<u64>,
    made: Option<Arc<dyn Any + Send + Sync>>,
}

impl Cache {
    /// An empty one, that holds at most so many bytes from one request to the next.
    pub(super) fn new(most_bytes: usize) -> Self {
        Self {
            most_bytes,
            request: 0,
            content: Content::default(),
            places: HashMap::default(),
            entries: vec![Entry::default()],
            vacant: Vec::new(),
            stats: CacheStats::default(),
        }
    }

    pub(super) fn stats(&self) -> CacheStats {
        self.stats
    }

    /// Begins to say what [`Cache::get`] is to look for.
    pub(super) fn describe(&mut self, kind: Kind, dimension: usize) -> &mut Content {
        self.content.0.clear();
        self.content.word((kind as u64) << 8 | dimension as u64);
        &mut self.content
    }

    /// What was made from the content described, or is made from it now, in memory that may
    /// hold something else.
    pub(super) fn get<T: Keep, E>(
        &mut self,
        budget: &Budget<'_>,
        make: impl FnOnce(&mut T) -> Result<(), E>,
    ) -> Result<Arc<T>, E> {
        // Looking takes time, too. Where there is none left, `make` says so.
        let words = self.content.0.len() as u64;
        if budget.step(1 + words / WORDS_PER_STEP).is_ok()
            && let Some(made) = self.look(budget)
        {
            return Ok(made);
        }
        let hash = self.content.hash();
        if let Some(at) = self.places.get(&hash).copied() {
            self.forget(at);
        }
        self.stats.misses += 1;
        let Memory { mut content, made } = self.spare();
        let made = made.and_then(|made| Arc::downcast(made).ok());
        let mut made: Arc<T> = made.filter(|made| Arc::strong_count(made) == 1).unwrap_or_default();
        let (result, cost) =
            budget.measure(|| make(Arc::get_mut(&mut made).expect("it is nobody else's")));
        result?;
        content.clear();
        content.extend_from_slice(&self.content.0);
        self.keep(hash, Memory { content, made: Some(made.clone()) }, made.bytes(), cost);
        Ok(made)
    }

    /// What was made from the content described, if it is there.
    fn look<T: Keep>(&mut self, budget: &Budget<'_>) -> Option<Arc<T>> {
        // Most often it is the same as last.
        let last = self.found(self.entries[END].older, budget);
        last.or_else(|| {
            let at = self.places.get(&self.content.hash()).copied()?;
            self.found(at, budget)
        })
    }

    /// What an entry keeps, if it is what is looked for and the budget is enough to make it.
    fn found<T: Keep>(&mut self, at: usize, budget: &Budget<'_>) -> Option<Arc<T>> {
        let entry = &mut self.entries[at];
        if entry.memory.content != self.content.0 {
            return None;
        }
        let made = Arc::downcast(entry.memory.made.clone()?).ok()?;
        if entry.request != self.request && !budget.repeat(&entry.cost) {
            return None;
        }
        entry.request = self.request;
        self.stats.hits += 1;
        self.unlink(at);
        self.link(at);
        Some(made)
    }

    /// Forgets what is too much, now that a request has ended.
    pub(super) fn end_request(&mut self) {
        // What is larger than the bound by itself is no reason to forget anything else.
        let mut at = self.entries[END].older;
        while at != END && self.entries[at].request == self.request {
            let older = self.entries[at].older;
            if self.entries[at].bytes > self.most_bytes {
                self.forget(at);
            }
            at = older;
        }
        while self.stats.bytes > self.most_bytes {
            self.forget(self.entries[END].newer);
        }
        self.request += 1;
    }

    /// The memory of the entry that has to go for the next one, if there is one and it is not
    /// much larger than the next one will be.
    fn spare(&mut self) -> Memory {
        let oldest = self.entries[END].newer;
        if self.stats.entries < MOST_ENTRIES || self.entries[oldest].request == self.request {
            return Memory::default();
        }
        let memory = self.forget(oldest);
        let fits = memory.content.len() <= 2 * self.content.0.len();
        if fits { memory } else { Memory::default() }
    }

    fn keep(&mut self, hash: u64, memory: Memory, bytes: usize, cost: Cost) {
        let at = self.vacant.pop().unwrap_or(self.entries.len());
        if at == self.entries.len() {
            self.entries.push(Entry::default());
        }
        let bytes = bytes + memory.content.capacity() * size_of::<u64>() + size_of::<Entry>();
        let request = self.request;
        self.entries[at] = Entry { hash, memory, bytes, request, cost, ..Entry::default() };
        self.link(at);
        self.places.insert(hash, at);
        self.stats.entries += 1;
        self.stats.bytes += bytes;
    }

    fn forget(&mut self, at: usize) -> Memory {
        self.unlink(at);
        self.vacant.push(at);
        let entry = &mut self.entries[at];
        self.places.remove(&entry.hash);
        self.stats.entries -= 1;
        self.stats.bytes -= entry.bytes;
        mem::take(&mut entry.memory)
    }

    /// Puts an entry behind the newest.
    fn link(&mut self, at: usize) {
        let newest = self.entries[END].older;
        (self.entries[at].older, self.entries[at].newer) = (newest, END);
        self.entries[newest].newer = at;
        self.entries[END].older = at;
    }

    fn unlink(&mut self, at: usize) {
        let Entry { older, newer, .. } = self.entries[at];
        self.entries[older].newer = newer;
        self.entries[newer].older = older;
    }
}

/// The hasher of what is a hash already.
#[derive(Debug, Default)]
struct AsItIs(u64);

impl Hasher for AsItIs {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, _: &[u8]) {
        unreachable!("only whole words are hashed");
    }

    fn write_u64(&mut self, hash: u64) {
        self.0 = hash;
    }
}

#[cfg(test)]
mod tests;
