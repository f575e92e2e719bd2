//! Memory that is used again from one motion to the next.

use super::lattice::LatticeMemory;
use super::taut::TautSearch;

/// Memory that is used again from one motion to the next.
#[derive(Debug, Default)]
pub struct Planner {
    pub(super) taut: TautSearch,
    /// For bounds, which are of another radius each.
    pub(super) bounds: TautSearch,
    /// Corners with a radius of their own, metres.
    pub(super) radii: Vec<(u32, f64)>,
    pub(super) lattice: LatticeMemory,
}

impl Planner {
    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        let radii = self.radii.capacity() * size_of::<(u32, f64)>();
        self.taut.bytes() + self.bounds.bytes() + self.lattice.bytes() + radii
    }

    /// To be called before it is used with another floor.
    pub fn forget(&mut self) {
        self.taut.forget();
        self.bounds.forget();
    }
}
