//! Ranks of the coordinates along an axis, and the sides of solids at each rank.

use super::part::{Part, RankedSolid};
use crate::geometry::Sign;

/// Coordinates along an axis are compared by rank: the greater one has the greater rank,
/// equal ones have the same.
#[derive(Debug, Clone, Default)]
pub(super) struct Axis {
    /// The coordinate of each rank, metres.
    coordinates: Vec<f64>,
    /// The solids whose least side lies at each rank.
    least: Sides,
    greatest: Sides,
}

#[derive(Debug, Clone, Default)]
struct Sides {
    /// Where the solids of each rank begin, and where those of the last one end.
    begins: Vec<u32>,
    solids: Vec<u32>,
}

impl Axis {
    /// Ranks the extents of the solids and, last, of the bounds. Calls `ranked` with the index
    /// of each extent, which of its ends, and the rank of that end.
    pub(super) fn rank(
        &mut self,
        extents: impl Iterator<Item = (f64, f64)>,
        ends: &mut Vec<(f64, u32)>,
        mut ranked: impl FnMut(usize, Sign, u32),
    ) {
        ends.clear();
        for (index, (least, greatest)) in (0..).zip(extents) {
            ends.extend([(least, 2 * index), (greatest, 2 * index + 1)]);
        }
        ends.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        self.coordinates.clear();
        for (coordinate, end) in &*ends {
            if self.coordinates.last() != Some(coordinate) {
                self.coordinates.push(*coordinate);
            }
            let sign = if end % 2 == 0 { Sign::Negative } else { Sign::Positive };
            ranked((end / 2) as usize, sign, self.coordinates.len() as u32 - 1);
        }
    }

    /// Sorts the sides of the solids by rank; returns the most at one rank.
    pub(super) fn sort_sides<const D: usize>(
        &mut self,
        solids: &[RankedSolid<D>],
        axis: usize,
    ) -> usize {
        let ranks = self.coordinates.len();
        let least = self.least.sort(ranks, solids, |part| part.min[axis]);
        least.max(self.greatest.sort(ranks, solids, |part| part.max[axis]))
    }

    #[cfg(test)]
    pub(super) fn memory(&self) -> usize {
        let sides = [&self.least, &self.greatest];
        let sides = sides.map(|sides| size_of_val(&*sides.begins) + size_of_val(&*sides.solids));
        size_of_val(&*self.coordinates) + sides.iter().sum::<usize>()
    }

    /// The memory that it holds, bytes.
    pub(super) fn bytes(&self) -> usize {
        let sides = [&self.least, &self.greatest];
        let numbers = sides.map(|sides| sides.begins.capacity() + sides.solids.capacity());
        let coordinates = self.coordinates.capacity() * size_of::<f64>();
        coordinates + numbers.iter().sum::<usize>() * size_of::<u32>()
    }

    /// The coordinate of a rank, metres.
    pub(super) fn at(&self, rank: u32) -> f64 {
        self.coordinates[rank as usize]
    }

    /// The solids whose facing side is at the rank of a part's side, in ascending order.
    pub(super) fn facing(&self, sign: Sign, rank: u32) -> &[u32] {
        // The greatest side of a part meets the least side of a solid.
        let sides = match sign {
            Sign::Negative => &self.greatest,
            Sign::Positive => &self.least,
        };
        let [begin, end] = [0, 1].map(|next| sides.begins[rank as usize + next] as usize);
        &sides.solids[begin..end]
    }
}

impl Sides {
    fn sort<const D: usize>(
        &mut self,
        ranks: usize,
        solids: &[RankedSolid<D>],
        rank: impl Fn(&Part<D>) -> u32,
    ) -> usize {
        self.begins.clear();
        self.begins.resize(ranks + 1, 0);
        solids.iter().for_each(|solid| self.begins[rank(&solid.part) as usize] += 1);
        let most = self.begins.iter().max().map_or(0, |most| *most as usize);
        let mut end = 0;
        for begin in &mut self.begins {
            end += *begin;
            *begin = end;
        }
        // Filled in backwards, from the end of each rank's range.
        self.solids.clear();
        self.solids.resize(solids.len(), 0);
        for (index, solid) in solids.iter().enumerate().rev() {
            let place = &mut self.begins[rank(&solid.part) as usize];
            *place -= 1;
            self.solids[*place as usize] = index as u32;
        }
        most
    }
}
