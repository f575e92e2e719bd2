//! The candidates of the sweep, indexed so that a solid finds those it reaches into.

use super::part::Part;
use crate::budget::{Budget, Cap, Spent};
use crate::geometry::Sign;

const NONE: u32 = u32::MAX;

/// A leaf with more candidates is split.
const MANY: u32 = 16;

/// A tree over the places of the candidates' sides along the axes other than the sweep's.
/// Each node halves the range of one side and knows the box around its candidates. (If all
/// these sides were equal for two candidates, one would contain the other.)
#[derive(Debug, Clone, Default)]
pub(super) struct Candidates<const D: usize> {
    nodes: Vec<Node<D>>,
    /// The first of two unused nodes.
    unused_nodes: u32,
    candidates: Vec<Candidate<D>>,
    unused: u32,
}

#[derive(Debug, Clone, Copy)]
struct Node<const D: usize> {
    around: Part<D>,
    count: u32,
    /// The first candidate of a leaf; otherwise the lower of two adjacent children.
    first: u32,
    /// The side by which the children differ; `None` in a leaf.
    split: Option<Split>,
}

/// Where the range of a side is halved.
#[derive(Debug, Clone, Copy)]
struct Split {
    axis: u16,
    sign: Sign,
    middle: u32,
}

#[derive(Debug, Clone, Copy)]
struct Candidate<const D: usize> {
    part: Part<D>,
    /// The next one in the same leaf, or the next unused one.
    next: u32,
}

impl<const D: usize> Node<D> {
    const EMPTY: Self =
        Self { around: Part { min: [NONE; D], max: [0; D] }, count: 0, first: NONE, split: None };

    fn add(&mut self, part: &Part<D>) {
        self.count += 1;
        self.around = self.around.around(part);
    }
}

impl Split {
    fn is_more<const D: usize>(&self, part: &Part<D>) -> bool {
        part.side(usize::from(self.axis), self.sign) >= self.middle
    }
}

impl<const D: usize> Candidates<D> {
    /// Removes all candidates; the memory is kept.
    pub(super) fn clear(&mut self) {
        self.nodes.clear();
        self.nodes.push(Node::EMPTY);
        self.candidates.clear();
        (self.unused_nodes, self.unused) = (NONE, NONE);
    }

    /// What it holds of its memory, bytes.
    pub(super) fn held(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.candidates)
    }

    /// The memory that it holds, bytes.
    pub(super) fn bytes(&self) -> usize {
        let candidates = self.candidates.capacity() * size_of::<Candidate<D>>();
        self.nodes.capacity() * size_of::<Node<D>>() + candidates
    }

    /// Adds a part of `bounds`, unless there are already [`Cap::Channels`].
    pub(super) fn insert(
        &mut self,
        part: Part<D>,
        bounds: &Part<D>,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let candidate = self.store(part, budget)?;
        // The least and the greatest place of each side.
        let mut least = Part { min: bounds.min, max: bounds.min };
        let mut greatest = Part { min: bounds.max, max: bounds.max };
        let mut node = 0;
        loop {
            self.nodes[node].add(&part);
            let Some(split) = self.nodes[node].split else { break };
            let axis = usize::from(split.axis);
            let more = split.is_more(&part);
            let range = if more { &mut least } else { &mut greatest };
            *range.side_mut(axis, split.sign) = split.middle;
            node = self.nodes[node].first as usize + usize::from(more);
        }
        self.link(node, candidate);
        if self.nodes[node].count > MANY {
            self.split(node, &least, &greatest);
        }
        budget.step(1)
    }

    /// Moves to `taken` all candidates that a solid reaches into; returns how many nodes and
    /// candidates were looked at.
    pub(super) fn take(&mut self, solid: &Part<D>, taken: &mut Vec<Part<D>>) -> usize {
        self.take_from(0, solid, taken)
    }

    fn store(&mut self, part: Part<D>, budget: &Budget<'_>) -> Result<u32, Spent> {
        let candidate = Candidate { part, next: NONE };
        if let Some(unused) = self.candidates.get_mut(self.unused as usize) {
            let index = self.unused;
            self.unused = unused.next;
            *unused = candidate;
            return Ok(index);
        }
        budget.check(Cap::Channels, self.candidates.len() + 1)?;
        let most = Spent::Limit { cap: Cap::Channels, most: NONE.into() };
        let index = u32::try_from(self.candidates.len()).ok().filter(|index| *index != NONE);
        self.candidates.push(candidate);
        index.ok_or(most)
    }

    /// Links a candidate, already counted, into a leaf.
    fn link(&mut self, leaf: usize, candidate: u32) {
        self.candidates[candidate as usize].next = self.nodes[leaf].first;
        self.nodes[leaf].first = candidate;
    }

    /// Halves the longest range.
    fn split(&mut self, leaf: usize, least: &Part<D>, greatest: &Part<D>) {
        let across = 0..D - 1;
        let sides = across.flat_map(|axis| [(axis, Sign::Negative), (axis, Sign::Positive)]);
        let range =
            |(axis, sign): &(usize, Sign)| greatest.side(*axis, *sign) - least.side(*axis, *sign);
        let longest = sides.max_by_key(range);
        let Some((axis, sign)) = longest.filter(|side| range(side) > 1) else { return };
        let middle = least.side(axis, sign).midpoint(greatest.side(axis, sign));
        let split = Split { axis: axis as u16, sign, middle };

        let children = match self.nodes.get(self.unused_nodes as usize) {
            Some(unused) => std::mem::replace(&mut self.unused_nodes, unused.first) as usize,
            None => {
                self.nodes.extend([Node::EMPTY; 2]);
                self.nodes.len() - 2
            }
        };
        self.nodes[children..children + 2].fill(Node::EMPTY);
        let first = children as u32;
        let mut at = std::mem::replace(&mut self.nodes[leaf].first, first);
        self.nodes[leaf].split = Some(split);
        while at != NONE {
            let Candidate { part, next } = self.candidates[at as usize];
            let child = children + usize::from(split.is_more(&part));
            self.nodes[child].add(&part);
            self.link(child, at);
            at = next;
        }
    }

    fn take_from(&mut self, node: usize, solid: &Part<D>, taken: &mut Vec<Part<D>>) -> usize {
        let Node { around, first, split, .. } = self.nodes[node];
        if !(0..D).all(|axis| solid.overlaps(&around, axis)) {
            return 1;
        }
        if split.is_none() {
            return 1 + self.take_from_leaf(node, solid, taken);
        }
        let children = first as usize;
        let steps = self.take_from(children, solid, taken);
        let steps = steps + self.take_from(children + 1, solid, taken);
        let [less, more] = [self.nodes[children], self.nodes[children + 1]];
        let this = &mut self.nodes[node];
        (this.count, this.around) = (less.count + more.count, less.around.around(&more.around));
        if this.count == 0 {
            *this = Node::EMPTY;
            self.nodes[children].first = self.unused_nodes;
            self.unused_nodes = first;
        }
        1 + steps
    }

    fn take_from_leaf(&mut self, leaf: usize, solid: &Part<D>, taken: &mut Vec<Part<D>>) -> usize {
        let mut at = self.nodes[leaf].first;
        self.nodes[leaf] = Node::EMPTY;
        let mut steps = 0;
        while at != NONE {
            steps += 1;
            let Candidate { part, next } = self.candidates[at as usize];
            if (0..D).all(|axis| solid.overlaps(&part, axis)) {
                taken.push(part);
                self.candidates[at as usize].next = std::mem::replace(&mut self.unused, at);
            } else {
                self.nodes[leaf].add(&part);
                self.link(leaf, at);
            }
            at = next;
        }
        steps
    }

    #[cfg(test)]
    pub(super) fn memory() -> [usize; 2] {
        [size_of::<Candidate<D>>(), size_of::<Node<D>>()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::Allowance;
    use proptest::prelude::*;

    const EDGE: u32 = 40;

    fn parts(most: usize) -> impl Strategy<Value = Vec<Part<3>>> {
        let corner = proptest::array::uniform3(0..EDGE - 8);
        let size = proptest::array::uniform3(1..=8_u32);
        let part = (corner, size).prop_map(|(min, size)| {
            let max = std::array::from_fn(|axis| min[axis] + size[axis]);
            Part { min, max }
        });
        proptest::collection::vec(part, 0..most)
    }

    proptest! {
        /// Some are added and some taken, by turns, more often than there is room for.
        #[test]
        fn exactly_those_reached_into_are_taken(rounds in proptest::collection::vec((parts(150), parts(9)), 1..4)) {
            let bounds = Part { min: [0; 3], max: [EDGE; 3] };
            let mut candidates = Candidates::default();
            let (mut expected, mut taken) = (Vec::new(), Vec::new());
            candidates.clear();
            let budget = Budget::new(Allowance { channels: 200, ..Allowance::NONE });
            for (parts, solids) in &rounds {
                for part in parts {
                    let room = expected.len() < 200;
                    prop_assert_eq!(candidates.insert(*part, &bounds, &budget).is_ok(), room);
                    expected.extend(room.then_some(*part));
                }
                for solid in solids {
                    let reached = |part: &Part<3>| (0..3).all(|axis| solid.overlaps(part, axis));
                    let (mut hit, kept): (Vec<_>, Vec<_>) = expected.into_iter().partition(reached);
                    expected = kept;
                    taken.clear();
                    candidates.take(solid, &mut taken);
                    hit.sort_unstable();
                    taken.sort_unstable();
                    prop_assert_eq!(&taken, &hit);
                }
            }
            taken.clear();
            candidates.take(&bounds, &mut taken);
            prop_assert_eq!(taken.len(), expected.len());
            prop_assert_eq!(candidates.nodes[0].count, 0);
            prop_assert!(candidates.nodes[0].split.is_none());
        }
    }
}
