//! The traveller: its place, its end, and the room that it needs.

use crate::free_space::End;
use crate::geometry::{AxisBox, Vector};

/// A body or robot that needs a route: where it is, where it goes, and the room that it needs
/// in a junction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Traveller<const D: usize> {
    /// Its least and greatest corner at the start, metres; may be equal.
    pub(super) least: Vector<D>,
    pub(super) greatest: Vector<D>,
    /// A junction must be larger than this along every axis, metres (condition 2.5).
    pub(super) needs: Vector<D>,
    /// Its gap along every axis, metres, less than half of what is left (condition 3.1).
    pub(super) gap: Vector<D>,
    pub(super) end: End<D>,
}

impl<const D: usize> Traveller<D> {
    /// Its centre at the start, metres.
    pub(super) fn center(&self) -> Vector<D> {
        (self.least + self.greatest) / 2.0
    }

    /// Whether it passes a junction of this extent along an axis by (2.5) and, for the gap, by
    /// (3.1).
    pub(super) fn fits_along(&self, axis: usize, extent: f64) -> bool {
        extent > self.needs[axis] && self.gap[axis] < (extent - self.needs[axis]) / 2.0
    }

    pub(super) fn fits(&self, junction: &AxisBox<D>) -> bool {
        let size = junction.size();
        (0..D).all(|axis| self.fits_along(axis, size[axis]))
    }

    /// The extent that a junction must exceed along an axis, without and with the gap, metres.
    pub(super) fn needs_along(&self, axis: usize) -> (f64, f64) {
        (self.needs[axis], self.needs[axis] + 2.0 * self.gap[axis])
    }

    /// The gap along an axis, metres; 0 if it depends on the junction.
    pub(super) fn gap_along(&self, axis: usize) -> f64 {
        self.gap[axis]
    }
}
