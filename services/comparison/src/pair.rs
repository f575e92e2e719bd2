//! Which requests of two recordings belong together.

use std::collections::{BTreeMap, VecDeque};
use std::hash::{DefaultHasher, Hash, Hasher};

use schemas::codec;
use schemas::message::{Request, RequestContent, RequestKey};

/// By what a request is found again in another recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identity {
    /// The scene's id.
    pub id: Option<u64>,
    /// Whose request it is, and the how manieth.
    pub key: RequestKey,
    /// A hash of what it asks, regardless of who asks and when.
    content: [u64; 2],
}

impl From<&Request> for Identity {
    fn from(request: &Request) -> Self {
        let id = match &request.content {
            RequestContent::Scene(scene) => scene.id,
            RequestContent::Unreadable { .. } => None,
        };
        let bytes = codec::encode(&request.content);
        let content = [0_u8, 1].map(|salt| {
            let mut hasher = DefaultHasher::new();
            (salt, &bytes).hash(&mut hasher);
            hasher.finish()
        });
        Self { id, key: request.key, content }
    }
}

/// Which requests of two lists belong together, by their places in the lists.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Pairs {
    /// In the order of the first list.
    pub pairs: Vec<[usize; 2]>,
    /// Those of one list only, in its order.
    pub alone: [Vec<usize>; 2],
}

/// Pairs the requests of two recordings.
///
/// Scenes with ids belong together if their ids are equal. Others do if they are equal, or else
/// the how manieth their clients sent is: clients draw new keys when they start, so the first that
/// appears in one recording is the first of the other. Of several that belong together in the
/// same way, the n-th goes with the n-th; equal scenes are preferred.
pub fn pair(lists: [&[Identity]; 2]) -> Pairs {
    let ranks = lists.map(client_ranks);
    let mut partner: [Vec<Option<usize>>; 2] = lists.map(|list| vec![None; list.len()]);
    let mut join = |key: &dyn Fn(&Identity, usize) -> Option<[u64; 3]>| {
        let free = |list: usize, partner: &[Vec<Option<usize>>; 2]| -> Vec<(usize, [u64; 3])> {
            let unpaired = lists[list].iter().enumerate();
            let unpaired = unpaired.filter(|(at, _)| partner[list][*at].is_none());
            unpaired.filter_map(|(at, it)| Some((at, key(it, list)?))).collect()
        };
        let mut others: BTreeMap<[u64; 3], VecDeque<usize>> = BTreeMap::new();
        for (at, key) in free(1, &partner) {
            others.entry(key).or_default().push_back(at);
        }
        for (at, key) in free(0, &partner) {
            if let Some(other) = others.get_mut(&key).and_then(VecDeque::pop_front) {
                partner[0][at] = Some(other);
                partner[1][other] = Some(at);
            }
        }
    };
    let without_id = |it: &Identity| it.id.is_none();
    join(&|it, _| it.id.map(|id| [id, it.content[0], it.content[1]]));
    join(&|it, _| it.id.map(|id| [id, 0, 0]));
    join(&|it, _| without_id(it).then_some([0, it.content[0], it.content[1]]));
    join(&|it, list| {
        let rank = ranks[list][&it.key.client];
        without_id(it).then_some([rank, it.key.sequence, 0])
    });
    let pairs = partner[0].iter().enumerate().filter_map(|(at, other)| Some([at, (*other)?]));
    let alone = |list: usize| {
        let all = partner[list].iter().enumerate();
        all.filter(|(_, other)| other.is_none()).map(|(at, _)| at).collect()
    };
    Pairs { pairs: pairs.collect(), alone: [alone(0), alone(1)] }
}

/// Clients counted in the order in which they appear.
fn client_ranks(list: &[Identity]) -> BTreeMap<u64, u64> {
    let mut ranks = BTreeMap::new();
    for identity in list {
        let next = ranks.len() as u64;
        ranks.entry(identity.key.client).or_insert(next);
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity(id: Option<u64>, client: u64, sequence: u64, content: u64) -> Identity {
        Identity { id, key: RequestKey { client, sequence }, content: [content, 0] }
    }

    #[track_caller]
    fn check(first: &[Identity], second: &[Identity], pairs: &[[usize; 2]], alone: [&[usize]; 2]) {
        let alone = alone.map(<[usize]>::to_vec);
        assert_eq!(pair([first, second]), Pairs { pairs: pairs.to_vec(), alone });
    }

    #[test]
    fn scenes_with_the_same_id_belong_together() {
        // The other order, another client, changed content.
        let first = [identity(Some(1), 7, 0, 10), identity(Some(2), 7, 1, 20)];
        let second = [identity(Some(2), 9, 0, 21), identity(Some(1), 9, 1, 11)];
        check(&first, &second, &[[0, 1], [1, 0]], [&[], &[]]);
        check(&first, &second[..1], &[[1, 0]], [&[0], &[]]);
        check(&first[..1], &second, &[[0, 1]], [&[], &[0]]);
    }

    #[test]
    fn equal_scenes_are_preferred_among_equal_ids() {
        let first = [identity(Some(1), 7, 0, 10), identity(Some(1), 8, 0, 20)];
        let second = [identity(Some(1), 5, 0, 20), identity(Some(1), 6, 0, 11)];
        check(&first, &second, &[[0, 1], [1, 0]], [&[], &[]]);
    }

    #[test]
    fn scenes_without_id_belong_together_if_they_are_equal() {
        let first = [identity(None, 7, 0, 10), identity(None, 7, 1, 10), identity(None, 7, 2, 30)];
        let second = [identity(None, 9, 0, 30), identity(None, 9, 1, 10)];
        check(&first, &second, &[[0, 1], [2, 0]], [&[1], &[]]);
    }

    #[test]
    fn changed_scenes_without_id_are_found_by_their_place_among_their_clients() {
        let first = [identity(None, 7, 0, 10), identity(None, 8, 0, 20), identity(None, 7, 1, 30)];
        // A request between them is missing: the client's count tells.
        let second = [identity(None, 1, 0, 11), identity(None, 1, 1, 31)];
        check(&first, &second, &[[0, 0], [2, 1]], [&[1], &[]]);
        let second = [identity(None, 1, 0, 10), identity(None, 2, 0, 21), identity(None, 1, 1, 31)];
        check(&first, &second, &[[0, 0], [1, 1], [2, 2]], [&[], &[]]);
    }

    #[test]
    fn scenes_with_and_without_id_are_strangers() {
        let first = [identity(Some(1), 7, 0, 10)];
        check(&first, &[identity(None, 7, 0, 10)], &[], [&[0], &[0]]);
    }

    #[test]
    fn hashes_tell_content_and_not_sender() {
        let request = |client, cells| Request {
            key: RequestKey { client, sequence: 0 },
            sent_ns: client,
            content: RequestContent::Unreadable { header: vec![1], cells },
        };
        let of = |client, cells| Identity::from(&request(client, cells)).content;
        assert_eq!(of(1, vec![2]), of(9, vec![2]));
        assert_ne!(of(1, vec![2]), of(1, vec![3]));
    }
}
