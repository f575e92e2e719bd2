//! Which channels meet: the graph that a route is looked for in.

use crate::geometry::AxisBox;
use crate::geometry::box_tree::BoxTree;
use thiserror::Error;

/// Channels in any order, and for each those that it has a junction with.
///
/// It depends on nothing but the channels, so that it can be kept for other
/// bodies, gaps, starts and exits in the same free space. It holds `20 + 34 D`
/// bytes per channel and 8 per junction.
#[derive(Debug, Clone, Default)]
pub struct Graph<const D: usize> {
    channels: Vec<AxisBox<D>>,
    tree: BoxTree<D>,
    /// Where each channel's neighbours begin, and where the last one's end.
    begins: Vec<u32>,
    neighbours: Vec<u32>,
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
        channels + self.tree.bytes() + numbers * size_of::<u32>()
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
    pub(super) fn slots(&self, channel: usize) -> std::ops::Range<usize> {
        self.begins[channel] as usize..self.begins[channel + 1] as usize
    }

    pub(super) fn neighbour_at(&self, slot: usize) -> usize {
        self.neighbours[slot] as usize
    }

    /// How many slots there are.
    pub(super) fn slot_count(&self) -> usize {
        self.neighbours.len()
    }

    pub(super) fn tree(&self) -> &BoxTree<D> {
        &self.tree
    }

    fn clear(&mut self) {
        self.channels.clear();
        self.tree.clear();
        self.begins.clear();
        self.neighbours.clear();
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
        self.begins.push(0);
        for (index, channel) in channels.iter().enumerate() {
            let begin = self.neighbours.len();
            let neighbours = &mut self.neighbours;
            // Every junction is found from both sides.
            let most = 2 * most_junctions;
            self.tree.visit(&channel.min(), &channel.max(), 0.0, |other| {
                if other != index && channel.intersection(&channels[other]).is_some() {
                    neighbours.push(other as u32);
                }
                if neighbours.len() > most { -1.0 } else { 0.0 }
            });
            if neighbours.len() > most {
                let has = most_junctions + 1;
                return Err(GraphError::TooManyJunctions { has, most: most_junctions });
            }
            neighbours[begin..].sort_unstable();
            self.begins.push(neighbours.len() as u32);
        }
        Ok(())
    }
}
