//! Boxes and solids whose coordinates are ranks: what the sweep compares.

use crate::geometry::Sign;

pub(super) const SIGNS: [Sign; 2] = [Sign::Negative, Sign::Positive];

/// A box, by the ranks of its coordinates. Ordered as the channels of a reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Part<const D: usize> {
    pub(super) min: [u32; D],
    pub(super) max: [u32; D],
}

impl<const D: usize> Part<D> {
    pub(super) fn side(&self, axis: usize, sign: Sign) -> u32 {
        match sign {
            Sign::Negative => self.min[axis],
            Sign::Positive => self.max[axis],
        }
    }

    pub(super) fn side_mut(&mut self, axis: usize, sign: Sign) -> &mut u32 {
        match sign {
            Sign::Negative => &mut self.min[axis],
            Sign::Positive => &mut self.max[axis],
        }
    }

    /// The smallest box around both.
    pub(super) fn around(&self, other: &Self) -> Self {
        Self {
            min: std::array::from_fn(|axis| self.min[axis].min(other.min[axis])),
            max: std::array::from_fn(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    /// A hash of its coordinates, independent of their order.
    pub(super) fn shuffled(&self) -> u64 {
        // The mixing steps of the SplitMix64 generator.
        self.min.iter().chain(&self.max).fold(0, |hash: u64, rank| {
            let mixed = (hash ^ u64::from(*rank)).wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (mixed ^ mixed >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
            mixed ^ mixed >> 31
        })
    }

    pub(super) fn overlaps(&self, other: &Self, axis: usize) -> bool {
        self.min[axis] < other.max[axis] && other.min[axis] < self.max[axis]
    }
}

/// A solid within the bounds. Ordered as the sweep takes them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct RankedSolid<const D: usize> {
    /// Where it begins along the sweep, then a shuffled number: if solids that begin
    /// together came in spatial order, each would be compared with all the later ones.
    pub(super) turn: u64,
    pub(super) part: Part<D>,
}
