//! Which channels meet: the graph that routes are searched in.

use crate::budget::{Budget, Cap, Held, Spent};
use crate::geometry::AxisBox;
use crate::geometry::box_tree::BoxTree;

/// Channels in any order and their neighbours, with which they have junctions.
///
/// It depends on the channels only, so it can be kept for other bodies, gaps, starts and
/// exits in the same free space. It holds `20 + 35 D` bytes per channel and 16 per junction.
#[derive(Debug, Clone, Default)]
pub struct Graph<const D: usize> {
    channels: Vec<AxisBox<D>>,
    tree: BoxTree<D>,
    /// Where the neighbours of each channel begin, and where those of the last one end.
    begins: Vec<u32>,
    neighbours: Vec<u32>,
    /// Both channels of every junction; used while building.
    pairs: Vec<[u32; 2]>,
}

/// Channels and junctions are counted in 32 bits; some values are reserved.
const MOST: usize = u32::MAX as usize / 2 - 1;

/// The pair, and a neighbour for each of the two.
const BYTES_PER_JUNCTION: usize = size_of::<[u32; 2]>() + 2 * size_of::<u32>();

impl<const D: usize> Graph<D> {
    /// Finds all junctions, that is, all pairs of channels whose interiors meet
    /// (equation 2.4), no more than [`Cap::Junctions`]. Built again and again in the same
    /// memory, which is left taken from the budget; empty after an error.
    ///
    /// Takes n log n for n channels and junctions.
    pub fn build(&mut self, channels: &[AxisBox<D>], budget: &Budget<'_>) -> Result<(), Spent> {
        self.clear();
        let result = self.try_build(channels, budget);
        if result.is_err() {
            self.clear();
        }
        result
    }

    /// The channels, as they were given.
    pub fn channels(&self) -> &[AxisBox<D>] {
        &self.channels
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let channels = self.channels.capacity() * size_of::<AxisBox<D>>();
        let numbers = self.begins.capacity() + self.neighbours.capacity();
        let pairs = self.pairs.capacity() * size_of::<[u32; 2]>();
        channels + self.tree.bytes() + numbers * size_of::<u32>() + pairs
    }

    /// The number of junctions.
    pub fn junctions(&self) -> usize {
        self.neighbours.len() / 2
    }

    /// The neighbours of `channel`, in ascending order.
    pub fn neighbours(&self, channel: usize) -> impl Iterator<Item = usize> {
        self.slots(channel).map(|slot| self.neighbours[slot] as usize)
    }

    /// The slots of a channel: the places of its neighbours in the list of all.
    pub(crate) fn slots(&self, channel: usize) -> std::ops::Range<usize> {
        self.begins[channel] as usize..self.begins[channel + 1] as usize
    }

    pub(crate) fn neighbour_at(&self, slot: usize) -> usize {
        self.neighbours[slot] as usize
    }

    /// The number of slots.
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

    fn try_build(&mut self, channels: &[AxisBox<D>], budget: &Budget<'_>) -> Result<(), Spent> {
        if channels.len() > MOST {
            return Err(Spent::Limit { cap: Cap::Channels, most: MOST as u64 });
        }
        let per_channel = size_of::<AxisBox<D>>() + size_of::<u32>();
        let for_channels = channels.len() * per_channel + BoxTree::<D>::bytes_for(channels.len());
        let held = Held::new(budget, for_channels)?;
        self.channels.extend_from_slice(channels);
        let bounds = |index: usize| (channels[index].min(), channels[index].max());
        self.tree.build(channels.len(), bounds, budget)?;
        let Self { tree, pairs, begins, neighbours, .. } = self;
        let mut for_junctions = Held::new(budget, 0)?;
        tree.pairs(budget, |one, other| {
            pairs.push([one as u32, other as u32]);
            let has = pairs.len();
            budget.check(Cap::Junctions, has)?;
            if has > MOST {
                return Err(Spent::Limit { cap: Cap::Junctions, most: MOST as u64 });
            }
            if has.is_power_of_two() {
                for_junctions.resize(2 * has * BYTES_PER_JUNCTION)?;
            }
            Ok(())
        })?;
        let has = pairs.len();
        budget.step(has as u64)?;
        for_junctions.resize(has * BYTES_PER_JUNCTION)?;
        for_junctions.keep();
        held.keep();
        begins.resize(channels.len() + 1, 0);
        pairs.as_flattened().iter().for_each(|channel| begins[*channel as usize] += 1);
        let mut end = 0;
        for begin in &mut *begins {
            end += *begin;
            *begin = end;
        }
        // Neighbours are filled in backwards, from the end of each channel's range.
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
