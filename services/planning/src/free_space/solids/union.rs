//! Channels for a body that is a union of boxes.
//!
//! At the displacement `d` the box `B` of the body overlaps the box `S` of a solid if and only if `d`
//! is inside of `S - B`, which is a box as well. So the displacements that are free are what a union
//! of boxes leaves, and the maximal boxes in that are found as for a body that is one box. They are
//! given as the boxes in which the body's bounds can be: each is larger than these by how far the
//! body can move.

use super::Solids;
use crate::budget::{Budget, Cap, Held, Spent};
use crate::free_space::mouth_of;
use crate::geometry::{AxisBox, Direction, HalfSpace, Sign, Vector};

/// Pairs of boxes in one step.
const PAIRS_PER_STEP: u64 = 4;

/// A body of several boxes in its cavity.
#[derive(Debug, Clone, Copy)]
pub struct UnionInCavity<'a, const D: usize> {
    /// The boxes of the body in the assembled state.
    pub boxes: &'a [AxisBox<D>],
    /// The smallest box around them.
    pub around: AxisBox<D>,
    /// What the body does not leave but through the mouth.
    pub bounds: AxisBox<D>,
    /// Where it leaves them.
    pub exit: Direction,
}

impl<const D: usize> UnionInCavity<'_, D> {
    fn mouth(&self) -> HalfSpace {
        mouth_of(&self.bounds, self.exit)
    }

    /// The displacements that matter: the body is not out, or just out, and not wholly beside the
    /// bounds. None where it is beyond the bounds from the start.
    fn range(&self) -> Option<AxisBox<D>> {
        let (min, max) = (self.bounds.min(), self.bounds.max());
        let (least, greatest) = (self.around.min(), self.around.max());
        let (mut low, mut high) = (min - greatest, max - least);
        let HalfSpace { side, bound } = self.mouth();
        let axis = side.axis;
        // A body that sticks out of the mouth, or is out, goes on by no more than its length.
        let length = self.around.size()[axis];
        match self.exit.sign {
            Sign::Positive => {
                low[axis] = min[axis] - least[axis];
                high[axis] = (bound - least[axis]).max(length);
            }
            Sign::Negative => {
                low[axis] = (bound - greatest[axis]).min(-length);
                high[axis] = max[axis] - greatest[axis];
            }
        }
        AxisBox::new(low, high).ok()
    }

    /// The displacements in `range` at which a box of the body is beside the bounds and not beyond the
    /// mouth.
    fn beside<'r>(
        &'r self,
        range: &'r AxisBox<D>,
    ) -> impl Iterator<Item = AxisBox<D>> + use<'r, D> {
        let HalfSpace { side, bound } = self.mouth();
        let across = (0..D).filter(move |axis| *axis != side.axis);
        let sides = across.flat_map(|axis| [(axis, Sign::Negative), (axis, Sign::Positive)]);
        sides.flat_map(move |(axis, sign)| {
            self.boxes.iter().filter_map(move |part| {
                let (mut min, mut max) = (range.min(), range.max());
                match side.sign {
                    Sign::Negative => max[side.axis] = bound - part.min()[side.axis],
                    Sign::Positive => min[side.axis] = bound - part.max()[side.axis],
                }
                match sign {
                    Sign::Negative => max[axis] = self.bounds.min()[axis] - part.min()[axis],
                    Sign::Positive => min[axis] = self.bounds.max()[axis] - part.max()[axis],
                }
                AxisBox::new(min, max).ok()
            })
        })
    }

    /// The displacements at which the two boxes overlap.
    fn overlapping(solid: &AxisBox<D>, part: &AxisBox<D>) -> Option<AxisBox<D>> {
        AxisBox::new(solid.min() - part.max(), solid.max() - part.min()).ok()
    }

    /// Where the body's bounds can be as far as channels are made; `None` where rounding leaves
    /// nothing of it.
    pub fn room(&self) -> Option<AxisBox<D>> {
        self.swept(&self.range()?)
    }

    /// The coordinate along which a box of the body reaches farthest out of the bounds before the
    /// mouth, where it does, and where the bounds end, metres.
    pub fn outside(&self) -> Option<(usize, f64, f64)> {
        let (min, max) = (self.bounds.min(), self.bounds.max());
        let mouth = self.mouth();
        let mut farthest: Option<(f64, (usize, f64, f64))> = None;
        for part in self.boxes {
            let [least, greatest] = [part.min(), part.max()].map(|corner| mouth.nearest(corner));
            let axis = mouth.side.axis;
            if least[axis] == greatest[axis] {
                continue; // Beyond the mouth.
            }
            for axis in 0..D {
                for (outside, side, end) in [
                    (min[axis] - least[axis], least[axis], min[axis]),
                    (greatest[axis] - max[axis], greatest[axis], max[axis]),
                ] {
                    if outside > farthest.map_or(0.0, |(most, _)| most) {
                        farthest = Some((outside, (axis, side, end)));
                    }
                }
            }
        }
        farthest.map(|(_, outside)| outside)
    }

    /// Where the body's bounds are at the displacements of a box.
    fn swept(&self, displacements: &AxisBox<D>) -> Option<AxisBox<D>> {
        let (least, greatest) = (self.around.min(), self.around.max());
        AxisBox::new(displacements.min() + least, displacements.max() + greatest).ok()
    }
}

impl<const D: usize> Solids<D> {
    /// Refills `channels` with all maximal boxes in which the bounds of a body of several boxes can
    /// be while none of its boxes overlaps a solid, or the outside of the cavity before its mouth; in
    /// the order of [`Solids::channels`].
    ///
    /// Exact but for the rounding of a difference and of a sum: the boxes of displacements are the
    /// maximal ones.
    pub fn channels_for_union(
        &mut self,
        body: &UnionInCavity<'_, D>,
        budget: &Budget<'_>,
        channels: &mut Vec<AxisBox<D>>,
    ) -> Result<(), Spent> {
        channels.clear();
        let Some(range) = body.range() else { return Ok(()) };
        let pairs = (self.boxes.len() + 2 * (D - 1)).saturating_mul(body.boxes.len());
        budget.check(Cap::Pieces, pairs)?;
        budget.step(pairs as u64 / PAIRS_PER_STEP)?;
        let _held = Held::new(budget, pairs.saturating_mul(size_of::<AxisBox<D>>()))?;
        let mut taken: Vec<AxisBox<D>> = Vec::with_capacity(pairs);
        for solid in &self.boxes {
            let parts = body.boxes.iter();
            taken.extend(parts.filter_map(|part| UnionInCavity::overlapping(solid, part)));
        }
        taken.extend(body.beside(&range));
        self.sweep.run(&taken, &range, &Vector::zeros(), budget, channels)?;
        channels.iter_mut().for_each(|displacements| {
            *displacements = body.swept(displacements).unwrap_or(*displacements);
        });
        Ok(())
    }

    /// The solid into which one of these boxes reaches deepest, as [`Solids::deepest`] says it.
    pub fn deepest_of(
        &self,
        boxes: &[AxisBox<D>],
        budget: &Budget<'_>,
    ) -> Result<Option<(usize, usize, f64)>, Spent> {
        budget.step((self.boxes.len().saturating_mul(boxes.len())) as u64 / PAIRS_PER_STEP)?;
        let depths = boxes.iter().filter_map(|part| self.deepest(&part.min(), &part.max()));
        Ok(depths.reduce(|a, b| if b.2 > a.2 { b } else { a }))
    }
}
