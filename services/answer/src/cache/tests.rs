use super::*;
use crate::entries::{CacheStats, MOST_ENTRIES};

/// Something that says how much memory it holds.
#[derive(Debug)]
struct Thing {
    made_from: Vec<u64>,
    bytes: usize,
}

impl Cached for Thing {
    fn bytes(&self) -> usize {
        self.bytes
    }
}

/// The cache of a workspace that has its store to itself, or shares it.
struct Alone {
    cache: Cache,
    elsewhere: usize,
}

impl Alone {
    fn new(most_bytes: usize) -> Self {
        Self { cache: Cache::new(Store::new(most_bytes)), elsewhere: 0 }
    }

    fn stats(&self) -> CacheStats {
        self.cache.store.cache_stats()
    }

    fn end_request(&mut self, elsewhere: usize) {
        let mut kept = self.cache.store.lock();
        kept.entries.count_elsewhere(self.elsewhere, elsewhere);
        let _evicted = kept.entries.evict(&mut self.cache.used);
        drop(kept);
        self.cache.used.clear();
        self.elsewhere = elsewhere;
    }
}

/// Caches of two workspaces that share a store.
fn two(store: &Store) -> [Alone; 2] {
    [0, 1].map(|_| Alone { cache: Cache::new(store.clone()), elsewhere: 0 })
}

/// What making a thing takes.
const STEPS: u64 = 10;

/// Looks for what is made from `words`; whether it was there.
#[track_caller]
fn find(Alone { cache, .. }: &mut Alone, words: &[u64], bytes: usize) -> bool {
    let budget = Budget::default();
    let mut made = false;
    cache.content = Content(words.to_vec());
    let thing = cache.get(&budget, || {
        made = true;
        budget.step(STEPS)?;
        Ok::<_, Spent>(Thing { made_from: words.to_vec(), bytes })
    });
    assert_eq!(thing.unwrap().made_from, words);
    !made
}

/// Requests, each of which looks for these things of 1,000 bytes; which were there.
#[track_caller]
fn check(most_bytes: usize, requests: &[&[u64]], there: &[&[bool]]) {
    let mut cache = Alone::new(most_bytes);
    for (request, (things, there)) in requests.iter().zip(there).enumerate() {
        let found: Vec<_> = things.iter().map(|thing| find(&mut cache, &[*thing], 1000)).collect();
        assert_eq!(found, *there, "request {request}");
        cache.end_request(0);
        assert!(cache.stats().bytes <= most_bytes, "{:?}", cache.stats());
    }
}

#[test]
fn the_least_recently_used_goes() {
    check(
        3700,
        &[&[1], &[2], &[3], &[1], &[4], &[1], &[3], &[2]],
        &[&[false], &[false], &[false], &[true], &[false], &[true], &[true], &[false]],
    );
}

#[test]
fn what_a_request_uses_stays_while_it_lasts() {
    let request = &[1, 2, 3, 1, 2, 3][..];
    let anew = &[false, false, false, true, true, true][..];
    check(0, &[request, request], &[anew, anew]);
    check(1500, &[request, &[3, 2, 1]], &[anew, &[true, false, false]]);
}

#[test]
fn larger_than_the_bound_is_not_kept_and_costs_nothing_else_its_place() {
    let mut cache = Alone::new(2500);
    for (word, bytes, there) in
        [(1, 1000, false), (2, 2600, false), (2, 2600, false), (1, 1000, true)]
    {
        assert_eq!(find(&mut cache, &[word], bytes), there, "{word}");
        cache.end_request(0);
    }
}

#[test]
fn memory_elsewhere_counts() {
    let mut cache = Alone::new(2500);
    for word in [1, 2] {
        assert!(!find(&mut cache, &[word], 1000));
    }
    cache.end_request(0);
    assert_eq!(cache.stats().entries, 2);
    cache.end_request(1000);
    assert_eq!(cache.stats().entries, 1);
    cache.end_request(2500);
    assert_eq!((cache.stats().entries, cache.stats().bytes), (0, 0));
}

#[test]
fn what_cannot_be_made_is_not_kept() {
    let mut cache = Alone::new(1 << 20);
    cache.cache.content = Content(vec![1]);
    let failed = cache.cache.get(&Budget::default(), || Err::<Thing, _>(Spent::Stopped));
    assert_eq!(failed.map(|thing| thing.bytes), Err(Spent::Stopped));
    assert!(!find(&mut cache, &[1], 1000));
    assert_eq!(cache.stats().entries, 1);
}

#[test]
fn entries_are_bounded() {
    let mut cache = Alone::new(usize::MAX);
    for word in 0..2 * MOST_ENTRIES as u64 {
        assert!(!find(&mut cache, &[word], 1000));
        cache.end_request(0);
    }
    assert_eq!(cache.stats().entries, MOST_ENTRIES);
    assert!(find(&mut cache, &[MOST_ENTRIES as u64], 1000));
    assert!(!find(&mut cache, &[MOST_ENTRIES as u64 - 1], 1000));
}

/// Against a list that does the same, slowly, for two workspaces in any order.
#[test]
fn it_does_as_a_plain_list_does() {
    let bound = 12_000;
    let mut caches = two(&Store::new(bound));
    let mut hits = 0;
    // Newest first.
    let mut list: Vec<u64> = Vec::new();
    let mut state = 1_u64;
    for _ in 0..5000 {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        // Often the same as before.
        let word = (state >> 60 & state >> 56) + 1;
        let cache = &mut caches[(state >> 40) as usize % 2];
        let there = list.contains(&word);
        hits += u64::from(there);
        list.retain(|other| *other != word);
        list.insert(0, word);
        assert_eq!(find(cache, &[word], 1000), there);
        cache.end_request(0);
        let each = cache.stats().bytes / cache.stats().entries;
        assert!(each >= 1000 + ENTRY_BYTES);
        list.truncate(bound / each);
        assert_eq!(cache.stats().entries, list.len());
        assert_eq!(cache.stats().hits, hits);
    }
}

#[test]
fn what_is_found_costs_what_making_it_did_once_a_request() {
    let mut cache = Alone::new(1 << 20);
    let drawn = |cache: &mut Alone, times: usize| {
        let budget = Budget::default();
        for _ in 0..times {
            cache.cache.content = Content(vec![7]);
            let made = cache.cache.get(&budget, || {
                budget.step(STEPS)?;
                budget.hold(1000)?;
                Ok::<_, Spent>(Thing { made_from: Vec::new(), bytes: 1000 })
            });
            made.unwrap();
        }
        cache.end_request(0);
        (budget.drawn(planning::budget::Cap::Steps), budget.drawn(planning::budget::Cap::Bytes))
    };
    let made = drawn(&mut cache, 1);
    assert_eq!(made.0, STEPS);
    assert_eq!(drawn(&mut cache, 1), made, "found");
    assert_eq!(drawn(&mut cache, 3), made, "found three times");
    assert_eq!(cache.stats().misses, 1);
}

#[test]
fn caches_of_one_store_share_what_they_make() {
    let store = Store::new(1 << 20);
    let [mut one, mut other] = two(&store);
    assert!(!find(&mut one, &[1], 1000));
    assert!(find(&mut other, &[1], 1000), "while the first is in use");
    one.end_request(0);
    other.end_request(0);
    assert_eq!(store.cache_stats().entries, 1);
}

/// What one request uses stays for it, though requests beside it drive it out of the cache.
#[test]
fn what_others_evict_stays_with_the_request_that_uses_it() {
    let store = Store::new(1500);
    let [mut one, mut other] = two(&store);
    assert!(!find(&mut one, &[1], 1000));
    for word in 2..6 {
        assert!(!find(&mut other, &[word], 1000));
        other.end_request(0);
    }
    assert!(find(&mut one, &[1], 1000), "found without drawing twice");
    one.end_request(0);
    assert!(!find(&mut one, &[1], 1000));
}

/// Whether the entry is found without a lock.
fn is_last(Alone { cache, .. }: &Alone, word: u64) -> bool {
    cache.last.find(&[word]).is_some()
}

#[test]
fn the_entry_used_last_of_all_is_found_without_a_lock() {
    let [mut one, mut other] = two(&Store::new(1 << 20));
    assert!(!find(&mut one, &[1], 1000));
    one.end_request(0);
    assert!(is_last(&one, 1) && !is_last(&one, 2) && !is_last(&other, 1));
    assert!(find(&mut other, &[1], 1000));
    other.end_request(0);
    assert!(is_last(&one, 1) && is_last(&other, 1), "another used the same");
    assert!(!find(&mut other, &[2], 1000));
    other.end_request(0);
    assert!(!is_last(&one, 1) && is_last(&other, 2), "another used one more");
    assert!(find(&mut one, &[1], 1000));
    one.end_request(0);
    assert!(is_last(&one, 1) && !is_last(&other, 2), "another changed the order");
}

#[test]
fn what_others_evict_is_freed() {
    let [mut one, mut other] = two(&Store::new(1500));
    assert!(!find(&mut one, &[1], 1000));
    one.end_request(0);
    let entry = one.cache.last.entry.clone().expect("it was used");
    assert!(entry.upgrade().is_some());
    assert!(!find(&mut other, &[2], 1000));
    other.end_request(0);
    assert!(entry.upgrade().is_none());
    assert!(!find(&mut one, &[1], 1000));
}

#[test]
fn threads_count_every_look_up_and_keep_the_bound() {
    const LOOK_UPS: u64 = 20_000;
    let bound = 4000;
    let store = Store::new(bound);
    let seeded = two(&store).into_iter().zip([1, 2]);
    let found: u64 = std::thread::scope(|scope| {
        let threads: Vec<_> = seeded
            .map(|(mut cache, seed)| {
                scope.spawn(move || {
                    let mut state: u64 = seed;
                    let mut found = 0;
                    for _ in 0..LOOK_UPS {
                        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                        let word = state >> 61 & state >> 58 & state >> 55;
                        found += u64::from(find(&mut cache, &[word], 1000));
                        cache.end_request(0);
                    }
                    cache.cache.leave(0);
                    found
                })
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).sum()
    });
    let stats = store.cache_stats();
    assert_eq!((stats.hits, stats.misses), (found, 2 * LOOK_UPS - found));
    assert!(found > LOOK_UPS && stats.misses > 100, "{stats:?}");
    assert!(stats.bytes <= bound && stats.entries > 0, "{stats:?}");
}
