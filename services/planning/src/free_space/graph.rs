//! Which channels meet: the graph that a route is looked for in.

use crate::geometry::AxisBox;
use crate::geometry::box_tree::BoxTree;
use thiserror::Error;

/// Channels in any order, and for each those that it has a junction with.
///
/// It depends on nothing but the channels, so that it can be kept for other
/// bodies, gaps, starts and exits in the same free space. It holds `20 + 35 D`
/// bytes per channel and 16 per junction.
#[derive(Debug, Clone, Default)]
pub struct Graph<const D: usize> {
    channels: Vec<AxisBox<D>>,
    tree: BoxTree<D>,
    /// Where each channel's neighbours begin, and where the last one's end.
    begins: Vec<u32>,
    neighbours: Vec<u32>,
    /// Both channels of every junction, while the graph is built.
    pairs: Vec<[u32; 2]>,
}

/// Why channels do not make a graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum GraphError {
    /// More junctions than allowed.
    #[error("the channels have at least {has} junctions, at most {most} are allowed")]
    TooManyJunctions {
        /// How many there are at least.
        has: usize,
        /// How many are allowed.
        most: usize,
    },
    /// More channels than can be counted.
    #[error("there are {has} channels, at most {most} are allowed")]
    TooManyChannels {
        /// How many there are.
        has: usize,
        /// How many are allowed.
        most: usize,
    },
}

/// Channels and junctions are counted in 32 bits, some values being reserved.
const MOST: usize = u32::MAX as usize / 2 - 1;

impl<const D: usize> Graph<D> {
    /// Finds all junctions, that is, all pairs of channels whose interiors meet
    /// (equation 2.4), unless there are more than `most_junctions`. Built again and
    /// again in the same memory; empty after an error.
    ///
    /// Takes n log n for n channels and junctions.
    pub fn build(
        &mut self,
        channels: &[AxisBox<D>],
        most_junctions: usize,
    ) -> Result<(), GraphError> {
        self.clear();
        let result = self.try_build(channels, most_junctions.min(MOST));
        if result.is_err() {
            self.clear();
        }
        result
    }

    /// The channels, as they were given.
    pub fn channels(&self) -> &[AxisBox<D>] {
        &self.channels
    }

    /// The memory that it holds.
    pub fn bytes(&self) -> usize {
        let channels = self.channels.capacity() * size_of::<AxisBox<D>>();
        let numbers = self.begins.capacity() + self.neighbours.capacity();
        let pairs = self.pairs.capacity() * size_of::<[u32; 2]>();
        channels + self.tree.bytes() + numbers * size_of::<u32>() + pairs
    }

    /// How many junctions there are.
    pub fn junctions(&self) -> usize {
        self.neighbours.len() / 2
    }

    /// The channels that `channel` has a junction with, in ascending order.
    pub fn neighbours(&self, channel: usize) -> impl Iterator<Item = usize> {
        self.slots(channel).map(|slot| self.neighbours[slot] as usize)
    }

    /// The places of a channel's neighbours in the list of all.
    pub(crate) fn slots(&self, channel: usize) -> std::ops::Range<usize> {
        self.begins[channel] as usize..self.begins[channel + 1] as usize
    }

    pub(crate) fn neighbour_at(&self, slot: usize) -> usize {
        self.neighbours[slot] as usize
    }

    /// How many slots there are.
    pub(crate) fn slot_count(&self) -> usize {
        self.neighbours.len()
    }

    pub(crate) fn tree(&self) -> &BoxTree<D> {
        &self.tree
    }

    fn clear(&mut self) {
        self.channels.clear();
        self.tree.clear();
        self.begins.clear();
        self.neighbours.clear();
        self.pairs.clear();
    }

    fn try_build(
        &mut self,
        channels: &[AxisBox<D>],
        most_junctions: usize,
    ) -> Result<(), GraphError> {
        if channels.len() > MOST {
            return Err(GraphError::TooManyChannels { has: channels.len(), most: MOST });
        }
        self.channels.extend_from_slice(channels);
        self.tree.build(channels.len(), |index| (channels[index].min(), channels[index].max()));
        let Self { tree, pairs, begins, neighbours, .. } = self;
        tree.pairs(|one, other| {
            pairs.push([one as u32, other as u32]);
            pairs.len() <= most_junctions
        });
        let has = pairs.len();
        if has > most_junctions {
            return Err(GraphError::TooManyJunctions { has, most: most_junctions });
        }
        begins.resize(channels.len() + 1, 0);
        pairs.as_flattened().iter().for_each(|channel| begins[*channel as usize] += 1);
        let mut end = 0;
        for begin in &mut *begins {
            end += *begin;
            *begin = end;
        }
        // Each channel's neighbours are filled in from their end down to their begin.
        neighbours.resize(2 * has, 0);
        for [one, other] in &*pairs {
            for (channel, neighbour) in [(one, other), (other, one)] {
                let place = &mut begins[*channel as usize];
                *place -= 1;
                neighbours[*place as usize] = *neighbour;
            }
        }
        for part in begins.windows(2) {
            neighbours[part[0] as usize..part[1] as usize].sort_unstable();
        }
        Ok(())
    }
}

#[cfg(test)]
pub(crate) mod tests;
