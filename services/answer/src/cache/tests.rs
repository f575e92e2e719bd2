use std::convert::Infallible;

use planning::budget::{Cap, Limits, Spent};

use super::*;

/// Something that says how much memory it holds.
#[derive(Debug, Default)]
struct Thing {
    made_from: Vec<u64>,
    bytes: usize,
}

impl Keep for Thing {
    fn bytes(&self) -> usize {
        self.bytes
    }
}

/// Looks for what is made from `words`; whether it was there.
#[track_caller]
fn find(cache: &mut Cache, words: &[u64], bytes: usize) -> bool {
    let mut made = false;
    cache.content = Content(words.to_vec());
    let Ok(thing) = cache.get(&Budget::default(), |thing: &mut Thing| {
        made = true;
        *thing = Thing { made_from: words.to_vec(), bytes };
        Ok::<_, Infallible>(())
    });
    assert_eq!(thing.made_from, words);
    !made
}

/// Requests, each of which looks for these things of 1,000 bytes; which were there.
#[track_caller]
fn check(most_bytes: usize, requests: &[&[u64]], there: &[&[bool]]) {
    let mut cache = Cache::new(most_bytes);
    for (request, (things, there)) in requests.iter().zip(there).enumerate() {
        let found: Vec<_> = things.iter().map(|thing| find(&mut cache, &[*thing], 1000)).collect();
        assert_eq!(found, *there, "request {request}");
        cache.end_request();
        assert!(cache.stats().bytes <= most_bytes, "{:?}", cache.stats());
    }
}

#[test]
fn the_least_recently_used_goes() {
    check(
        3500,
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
    let mut cache = Cache::new(2500);
    for (word, bytes, there) in
        [(1, 1000, false), (2, 2600, false), (2, 2600, false), (1, 1000, true)]
    {
        assert_eq!(find(&mut cache, &[word], bytes), there, "{word}");
        cache.end_request();
    }
}

#[test]
fn collision_is_a_miss() {
    // The first word makes the hash zero, whatever the second is.
    let zero = SEEDS[0] ^ 2;
    let (one, other) = ([zero, 1], [zero, 2]);
    assert_eq!(Content(one.to_vec()).hash(), Content(other.to_vec()).hash());
    let mut cache = Cache::new(1 << 20);
    for (words, there) in [(one, false), (one, true), (other, false), (other, true), (one, false)] {
        assert_eq!(find(&mut cache, &words, 1000), there);
        cache.end_request();
    }
    assert_eq!(cache.stats().entries, 1);
}

#[test]
fn what_cannot_be_made_is_not_kept() {
    let mut cache = Cache::new(1 << 20);
    cache.content = Content(vec![1]);
    let failed = cache.get(&Budget::default(), |_: &mut Thing| Err("too large"));
    assert_eq!(failed.map(|thing| thing.bytes), Err("too large"));
    assert!(!find(&mut cache, &[1], 1000));
    assert_eq!(cache.stats().entries, 1);
}

#[test]
fn what_is_there_costs_as_much_as_when_it_was_made() {
    let limits = Limits { steps: 1000, bytes: 500, ..Limits::NONE };
    let mut cache = Cache::new(1 << 20);
    // So many times in one request, after so many other steps: what it drew.
    let request = |cache: &mut Cache, times: usize, steps: u64| -> Result<[u64; 2], Spent> {
        let budget = Budget::new(limits);
        budget.step(steps)?;
        for _ in 0..times {
            cache.content = Content(vec![7]);
            cache.get(&budget, |_: &mut Thing| {
                budget.step(600)?;
                budget.hold(400)?;
                budget.release(300);
                Ok::<_, Spent>(())
            })?;
        }
        cache.end_request();
        Ok([Cap::Steps, Cap::Bytes].map(|cap| budget.drawn(cap)))
    };
    let made = request(&mut cache, 1, 0);
    assert_eq!(made, Ok([601, 100]));
    assert_eq!((request(&mut cache, 1, 0), cache.stats().hits), (made, 1));
    // Within one request it is made but once.
    assert_eq!((request(&mut cache, 2, 0), cache.stats().hits), (Ok([602, 100]), 3));
    // A request that could not have made it does not get it either.
    let spent = Spent::Limit { cap: Cap::Steps, most: 1000 };
    assert_eq!((request(&mut cache, 1, 500), cache.stats().hits), (Err(spent), 3));
    assert_eq!(request(&mut Cache::new(0), 1, 500), Err(spent));
}

#[test]
fn entries_are_bounded_and_their_memory_used_again() {
    let mut cache = Cache::new(usize::MAX);
    for word in 0..2 * MOST_ENTRIES as u64 {
        assert!(!find(&mut cache, &[word], 1000));
        cache.end_request();
    }
    assert_eq!(cache.stats().entries, MOST_ENTRIES);
    assert_eq!(cache.entries.len(), MOST_ENTRIES + 1);
    assert!(find(&mut cache, &[MOST_ENTRIES as u64], 1000));
    assert!(!find(&mut cache, &[MOST_ENTRIES as u64 - 1], 1000));
}

/// Against a list that does the same, slowly.
#[test]
fn it_does_as_a_plain_list_does() {
    let bound = 12_000;
    let mut cache = Cache::new(bound);
    let entry = 1000 + size_of::<Entry>();
    // Newest first.
    let mut list: Vec<u64> = Vec::new();
    let mut state = 1_u64;
    for _ in 0..5000 {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let word = (state >> 60) + 1;
        let there = list.contains(&word);
        list.retain(|other| *other != word);
        list.insert(0, word);
        assert_eq!(find(&mut cache, &[word], 1000), there);
        cache.end_request();
        let each = cache.stats().bytes / cache.stats().entries;
        assert!(each >= entry);
        list.truncate(bound / each);
        assert_eq!(cache.stats().entries, list.len());
    }
}
