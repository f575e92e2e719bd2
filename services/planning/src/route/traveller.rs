//! Who looks for a route, and how it moves.

use super::label::Label;
use super::{Search, Translating};
use crate::free_space::{Corner, End};
use crate::geometry::{AxisBox, Vector};
use std::fmt;

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

/// A step of the search: where it leads.
#[derive(Debug, Clone, Copy)]
pub struct Step<S> {
    pub(super) state: S,
    /// Length of the whole way there, metres.
    pub(super) length: f64,
    /// No way that begins so and leads to the end is shorter, metres.
    pub(super) estimate: f64,
}

/// How a traveller moves from junction to junction.
pub trait Motion<const D: usize> {
    /// Where the traveller is after a step.
    type State: Copy + fmt::Debug;

    /// Who moves.
    fn traveller(&self) -> &Traveller<D>;

    /// A motion much like this one by which a route is found quickly.
    fn outline(&self) -> Option<Translating<D>> {
        None
    }

    /// The steps from a label (`NONE`: from the start) into a junction, as far as they
    /// can be part of a shortest way.
    fn enter(
        &self,
        search: &Search<'_, D>,
        labels: &[Label<Self::State>],
        from: u32,
        corner: &Corner<D>,
    ) -> [Option<Step<Self::State>>; 2];

    /// The length of the whole way if the last step is from this label, out of the last
    /// channel or to the goal, metres.
    fn finish(
        &self,
        search: &Search<'_, D>,
        labels: &[Label<Self::State>],
        from: u32,
    ) -> Option<f64>;

    /// Compares a new label with those of the same slot, which begin with its `next`: marks
    /// what is useless beside it; whether it is of use itself. Counts the labels looked at.
    fn compare(
        &self,
        labels: &mut [Label<Self::State>],
        new: &Label<Self::State>,
        looks: &mut usize,
    ) -> bool;

    /// Rules out what blocks a route that ends with the label `last` (see
    /// [`super::Judgement::Blocked`]); false if there is nothing to rule out.
    fn avoid(
        &mut self,
        _labels: &[Label<Self::State>],
        _last: u32,
        _junction: Option<usize>,
    ) -> bool {
        false
    }
}
