//! How a traveller moves from junction to junction.

use super::label::Label;
use super::search::Search;
use super::traveller::Traveller;
use crate::budget::Spent;
use crate::free_space::Junction;
use std::fmt;

/// A step of the search.
#[derive(Debug, Clone, Copy)]
pub struct SearchStep<S> {
    pub(super) state: S,
    /// Length of the way until there, metres.
    pub(super) length: f64,
    /// A lower bound on the length of any way to the end that begins so, metres.
    pub(super) estimate: f64,
}

/// How a traveller moves from junction to junction.
pub trait Mover<const D: usize> {
    /// Where the traveller is after a step.
    type State: Copy + fmt::Debug;

    /// Who moves.
    fn traveller(&self) -> &Traveller<D>;

    /// If straight lines from junction to junction resemble this motion, so that they find a
    /// route quickly: how far they pass from the corners, metres.
    fn outline(&self) -> Option<f64> {
        None
    }

    /// The steps from a label (`NONE` for the start) into a junction that can be part of a
    /// shortest way.
    fn enter(
        &self,
        search: &Search<'_, D>,
        labels: &[Label<Self::State>],
        from: u32,
        junction: &Junction<D>,
    ) -> Result<[Option<SearchStep<Self::State>>; 2], Spent>;

    /// The length of the way that ends with a step from this label out of the last channel or
    /// to the goal, metres.
    fn finish(
        &self,
        search: &Search<'_, D>,
        labels: &[Label<Self::State>],
        from: u32,
    ) -> Result<Option<f64>, Spent>;

    /// Compares a new label with those of the same slot, beginning with its `next`. Marks those
    /// that it makes useless; returns whether it is useful itself. Counts the comparisons.
    fn compare(
        &self,
        labels: &mut [Label<Self::State>],
        new: &Label<Self::State>,
        looks: &mut usize,
    ) -> bool;

    /// Rules out what blocks a route that ends with the label `last` (see
    /// [`super::Judgement::Blocked`]); false if nothing can be ruled out.
    fn avoid(
        &mut self,
        _labels: &[Label<Self::State>],
        _last: u32,
        _junction: Option<usize>,
    ) -> bool {
        false
    }
}
