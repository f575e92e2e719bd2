//! Compares two recordings.

use std::collections::BTreeMap;
use std::path::PathBuf;

use schemas::message::{Reply, RequestKey};

use crate::check::Counts;
use crate::compare::{Comparison, compare};
use crate::exchanges::{self, Contents, Exchange};
use crate::pair::{Identity, pair};
use crate::tolerance::Tolerance;

/// How the replies of two recordings compare.
#[derive(Debug)]
pub struct Compared {
    /// What is in each.
    pub contents: [Contents; 2],
    /// The requests that both have, in the order of the first.
    pub pairs: Vec<Pair>,
    /// Requests that only one of them has, in its order.
    pub alone: [Vec<RequestKey>; 2],
}

impl Compared {
    /// How many pairs compare in which way.
    pub fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        self.pairs.iter().for_each(|pair| counts.add(&pair.comparison));
        counts
    }
}

/// A request in both recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Its place in each, from 0.
    pub indices: [u64; 2],
    /// The request in each: clients draw new keys when they start.
    pub keys: [RequestKey; 2],
    /// The scene's id.
    pub id: Option<u64>,
    /// How the replies compare.
    pub comparison: Comparison,
}

/// The requests of a recording, in its order.
#[derive(Default)]
struct Requests(BTreeMap<u64, Identity>);

impl Requests {
    fn add(&mut self, exchange: &Exchange) {
        self.0.insert(exchange.index, Identity::from(&exchange.request));
    }

    fn indices(&self) -> Vec<u64> {
        self.0.keys().copied().collect()
    }

    fn identities(&self) -> Vec<Identity> {
        self.0.values().copied().collect()
    }
}

/// Compares the recordings `first` and `second`, each of one file or more; their requests are paired by [`pair`]. `progress`
/// is told how many bytes of the recording at hand have been read, `each` gets every pair with the
/// exchange of the first recording and the reply of the second.
///
/// The first recording is read twice. Memory: the replies of the second.
pub fn diff(
    [first, second]: [&[PathBuf]; 2],
    tolerance: &Tolerance,
    mut progress: impl FnMut(u64),
    mut each: impl FnMut(&Pair, &Exchange, &Reply),
) -> Compared {
    let mut requests = [Requests::default(), Requests::default()];
    let mut replies: BTreeMap<u64, Reply> = BTreeMap::new();
    let contents = [
        exchanges::read_all(first, &mut progress, |exchange| requests[0].add(&exchange)),
        exchanges::read_all(second, &mut progress, |exchange| {
            requests[1].add(&exchange);
            replies.insert(exchange.index, exchange.reply);
        }),
    ];
    let identities = requests.each_ref().map(Requests::identities);
    let indices = requests.each_ref().map(Requests::indices);
    let paired = pair([&identities[0], &identities[1]]);
    let partner: BTreeMap<u64, u64> =
        paired.pairs.iter().map(|[one, other]| (indices[0][*one], indices[1][*other])).collect();
    let mut pairs = Vec::with_capacity(partner.len());
    exchanges::read_all(first, &mut progress, |exchange| {
        let Some(other) = partner.get(&exchange.index) else { return };
        let Some(mut reply) = replies.remove(other) else { return };
        let (key, other_key) = (exchange.reply.key, reply.key);
        let id = requests[0].0.get(&exchange.index).and_then(|identity| identity.id);
        reply.key = key;
        let comparison = compare(&exchange.reply, &reply, tolerance);
        let indices = [exchange.index, *other];
        let pair = Pair { indices, keys: [key, other_key], id, comparison };
        each(&pair, &exchange, &reply);
        pairs.push(pair);
    });
    pairs.sort_by_key(|pair| pair.indices[0]);
    let alone = [0, 1]
        .map(|list: usize| paired.alone[list].iter().map(|at| identities[list][*at].key).collect());
    Compared { contents, pairs, alone }
}
