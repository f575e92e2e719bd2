//! Channels from solids: the maximal boxes of what they leave free.

use crate::budget::{Budget, Cap, Spent};
use crate::geometry::polygon::Polygon;
use crate::geometry::{AxisBox, Direction, Sign, Vector};
use sweep::Sweep;
use thiserror::Error;

mod axis;
mod candidates;
mod outline;
mod part;
mod sweep;

/// Why a solid can't be cut into boxes.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SolidsError {
    /// A polygon has slanted edges, and the tolerance is not a positive number.
    #[error("the tolerance {tolerance} m for slanted edges is not greater than {least} m")]
    ToleranceNotPositive {
        /// The tolerance given, metres.
        tolerance: f64,
        /// It must be greater than this, metres.
        least: f64,
    },
    /// The budget ended.
    #[error(transparent)]
    Spent(#[from] Spent),
}

/// Solids, cut into boxes. Reusable memory.
///
/// They may touch, overlap, and be given twice. It holds `16 D + 4` bytes per box; from
/// looking for channels `48 D + 40` more, or `67 D + 56` where more than a few sides lie
/// in one place; `8 D` per channel; and `8 D + 4` per box considered at one time besides
/// an index of them (nodes of `8 D + 20` bytes, as a rule one for every five boxes).
#[derive(Debug, Clone, Default)]
pub struct Solids<const D: usize> {
    boxes: Vec<AxisBox<D>>,
    /// Which solid each box is of, in the order in which they were added.
    solids: Vec<u32>,
    count: u32,
    sweep: Sweep<D>,
}

impl<const D: usize> Solids<D> {
    /// Forgets all solids, keeping the memory.
    pub fn clear(&mut self) {
        self.boxes.clear();
        self.solids.clear();
        self.count = 0;
    }

    /// The boxes that the solids were cut into.
    pub fn boxes(&self) -> &[AxisBox<D>] {
        &self.boxes
    }

    /// Adds a solid box. Its memory is left taken from the budget.
    pub fn push_box(&mut self, solid: AxisBox<D>, budget: &Budget<'_>) -> Result<(), Spent> {
        budget.check(Cap::Pieces, self.boxes.len() + 1)?;
        budget.hold(Self::BYTES_PER_BOX)?;
        self.boxes.push(solid);
        self.count_solid();
        Ok(())
    }

    const BYTES_PER_BOX: usize = size_of::<AxisBox<D>>() + size_of::<u32>();

    /// What was added last is one solid. There are fewer boxes than can be counted in 32
    /// bits ([`Cap::Pieces`]), and more solids are not told apart.
    fn count_solid(&mut self) {
        self.solids.resize(self.boxes.len(), self.count);
        self.count = self.count.saturating_add(1);
    }

    /// The solid that reaches deepest into the box from `min` to `max` (a point, if they are the
    /// same): its index in the order in which solids were added, the axis along which the
    /// box would have to be moved least to be out of it, and by how much (metres). The first
    /// of equals; `None` if none reaches into it.
    ///
    /// Of a polygon this is the deepest of the boxes that it was cut into.
    pub fn deepest(&self, min: &Vector<D>, max: &Vector<D>) -> Option<(usize, usize, f64)> {
        let mut deepest: Option<(usize, usize, f64)> = None;
        for (solid, index) in self.boxes.iter().zip(&self.solids) {
            let mut least = (0, f64::INFINITY);
            for axis in 0..D {
                let depth = (max[axis] - solid.min()[axis]).min(solid.max()[axis] - min[axis]);
                if depth < least.1 {
                    least = (axis, depth);
                }
            }
            let (axis, depth) = least;
            if depth > 0.0 && deepest.is_none_or(|(_, _, most)| depth > most) {
                deepest = Some((*index as usize, axis, depth));
            }
        }
        deepest
    }

    /// The smallest box around all solids; `None` without any.
    pub fn bounds(&self) -> Option<AxisBox<D>> {
        let corners = self.boxes.iter().map(|solid| (solid.min(), solid.max()));
        let (min, max) = corners.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))?;
        AxisBox::new(min, max).ok()
    }

    /// Where to look for the channels of a cavity from which `body` is to be taken
    /// along `exit`: [`Solids::bounds`], whose side towards the exit is the mouth.
    ///
    /// A body that reaches the mouth or sticks out of it moves the mouth out, to
    /// one length of the body beyond it: a channel must be larger than the body.
    pub fn cavity(&self, body: &AxisBox<D>, exit: Direction) -> Option<AxisBox<D>> {
        let bounds = self.bounds()?;
        let (mut min, mut max) = (bounds.min(), bounds.max());
        let axis = exit.axis;
        let length = body.size()[axis];
        match exit.sign {
            Sign::Positive if body.max()[axis] >= max[axis] => {
                max[axis] = body.max()[axis] + length
            }
            Sign::Negative if body.min()[axis] <= min[axis] => {
                min[axis] = body.min()[axis] - length
            }
            _ => {}
        }
        AxisBox::new(min, max).ok()
    }

    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        let boxes = self.boxes.capacity() * size_of::<AxisBox<D>>();
        boxes + self.solids.capacity() * size_of::<u32>() + self.sweep.bytes()
    }

    /// Refills `channels` with all maximal boxes of the part of `bounds` that the
    /// solids leave free, as far as they are larger than `body` (metres) on every
    /// axis; sorted by their least, then their greatest corner, the first axis
    /// first.
    ///
    /// Exact: only coordinates of the solids and of `bounds` are used, and they are
    /// only compared. The time grows about as n log n with the number n of solids
    /// and of boxes found or cut short on the way. These can be as many as the
    /// square of the solids in two dimensions and are near as many as the solids
    /// where these stand apart evenly.
    pub fn channels(
        &mut self,
        bounds: &AxisBox<D>,
        body: &Vector<D>,
        budget: &Budget<'_>,
        channels: &mut Vec<AxisBox<D>>,
    ) -> Result<(), Spent> {
        channels.clear();
        budget.check(Cap::Pieces, self.boxes.len())?;
        self.sweep.run(&self.boxes, bounds, body, budget, channels)
    }
}

impl Solids<2> {
    /// Adds a solid polygon, exactly where its edges are parallel to the axes.
    ///
    /// A slanted edge is replaced by steps outside of it, so that what is left
    /// free is free indeed. What they take lies within `tolerance` (metres) of the
    /// edge, measured along the axis to which the edge is closer to being across.
    pub fn push_polygon(
        &mut self,
        polygon: &Polygon,
        tolerance: f64,
        budget: &Budget<'_>,
    ) -> Result<(), SolidsError> {
        let before = self.boxes.len();
        outline::cut(polygon.vertices(), tolerance, &mut self.boxes, budget)?;
        budget.hold((self.boxes.len() - before) * Self::BYTES_PER_BOX)?;
        self.count_solid();
        Ok(())
    }
}

#[cfg(test)]
mod tests;
