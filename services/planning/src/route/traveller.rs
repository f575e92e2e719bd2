//! Who looks for a route.

use crate::free_space::End;
use crate::geometry::{AxisBox, Vector};

/// Something that is to find its way: where it is, where it is to go, and the room
/// it needs in a junction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Traveller<const D: usize> {
    /// Its corners where it starts, metres; they may be the same.
    pub(super) least: Vector<D>,
    pub(super) greatest: Vector<D>,
    /// A junction must be larger on every axis, metres (condition 2.5).
    pub(super) needs: Vector<D>,
    /// The gap must be less than half of what is left then, metres (condition 3.1).
    pub(super) gap: Vector<D>,
    pub(super) end: End<D>,
}

impl<const D: usize> Traveller<D> {
    /// Its middle where it starts, metres.
    pub(super) fn center(&self) -> Vector<D> {
        (self.least + self.greatest) / 2.0
    }

    /// What it is refused for along an axis of a junction of this extent: too small
    /// by (2.5), or by (3.1) for the gap.
    pub(super) fn fits_along(&self, axis: usize, extent: f64) -> bool {
        extent > self.needs[axis] && self.gap[axis] < (extent - self.needs[axis]) / 2.0
    }

    pub(super) fn fits(&self, junction: &AxisBox<D>) -> bool {
        let size = junction.size();
        (0..D).all(|axis| self.fits_along(axis, size[axis]))
    }

    /// The extent that a junction must exceed along an axis, without and with the
    /// gap asked for, metres.
    pub(super) fn needs_along(&self, axis: usize) -> (f64, f64) {
        (self.needs[axis], self.needs[axis] + 2.0 * self.gap[axis])
    }

    /// The gap asked for along an axis; 0 where it depends on the junction.
    pub(super) fn gap_along(&self, axis: usize) -> f64 {
        self.gap[axis]
    }
}
