//! Compares two recordings.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;

use schemas::codec;
use schemas::message::{Reply, Request, RequestKey};

use crate::compare::{Outcome, Tolerance, compare};
use crate::exchanges::{self, Contents};

/// How the replies of two recordings compare.
#[derive(Debug)]
pub struct Compared {
    /// What is in each.
    pub contents: [Contents; 2],
    /// The requests that both have, in the order of the first.
    pub pairs: Vec<Pair>,
    /// Requests that only one of them has.
    pub alone: [Vec<RequestKey>; 2],
}

/// A request in both recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// The request in each: clients draw new keys when they start.
    pub keys: [RequestKey; 2],
    /// How the replies compare.
    pub outcome: Outcome,
}

/// Compares the recordings `first` and `second`. Requests are paired by content: the n-th of
/// several equal requests in the first with the n-th in the second. `progress` is told how
/// many bytes of the recording at hand have been read.
///
/// Memory: all of the second recording.
pub fn diff(
    [first, second]: [&Path; 2],
    tolerance: Tolerance,
    mut progress: impl FnMut(u64),
) -> Compared {
    let mut others: BTreeMap<Vec<u8>, VecDeque<Reply>> = BTreeMap::new();
    let second = exchanges::read(second, &mut progress, |exchange| {
        others.entry(question(&exchange.request)).or_default().push_back(exchange.reply);
    });
    let (mut pairs, mut alone) = (Vec::new(), [Vec::new(), Vec::new()]);
    let first = exchanges::read(first, &mut progress, |exchange| {
        let replies = others.get_mut(&question(&exchange.request));
        let Some(mut other) = replies.and_then(VecDeque::pop_front) else {
            alone[0].push(exchange.reply.key);
            return;
        };
        let keys = [exchange.reply.key, other.key];
        other.key = exchange.reply.key;
        pairs.push(Pair { keys, outcome: compare(&exchange.reply, &other, tolerance) });
    });
    alone[1].extend(others.into_values().flatten().map(|reply| reply.key));
    alone[1].sort();
    Compared { contents: [first, second], pairs, alone }
}

/// What a request asks, regardless of who asks and when.
fn question(request: &Request) -> Vec<u8> {
    codec::encode(&request.content)
}
