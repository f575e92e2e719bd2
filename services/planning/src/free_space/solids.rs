//! Channels from solids: the maximal free boxes between them.

use crate::budget::{Budget, Cap, Spent};
use crate::free_space::mouth_of;
use crate::geometry::number::Point;
use crate::geometry::polygon::Polygon;
use crate::geometry::{AxisBox, Direction, HalfSpace, Sign, Vector};
use sweep::Sweep;
use thiserror::Error;

mod axis;
mod candidates;
mod outline;
mod part;
mod sweep;
mod union;

pub use union::UnionInCavity;

/// Why a solid can't be cut into boxes.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SolidsError {
    /// A polygon has an edge that is parallel to no axis.
    #[error("edge {edge} of the polygon, from {} to {}, is slanted", Point(from), Point(to))]
    Slanted {
        /// Index of the first such edge.
        edge: usize,
        /// Its beginning, metres.
        from: Vector<2>,
        /// Its end, metres.
        to: Vector<2>,
    },
    /// The budget ended.
    #[error(transparent)]
    Spent(#[from] Spent),
}

/// Solids, cut into boxes. They may touch, overlap and repeat. Reusable memory.
///
/// It holds `16 D + 4` bytes per box. A search for channels takes `48 D + 40` more, or
/// `67 D + 56` if more than a few sides lie in one place; `8 D` per channel; and `8 D + 4`
/// per candidate, with an index of them (nodes of `8 D + 20` bytes, usually one for every
/// five).
#[derive(Debug, Clone, Default)]
pub struct Solids<const D: usize> {
    boxes: Vec<AxisBox<D>>,
    /// The solid that each box belongs to, by order of addition.
    solids: Vec<u32>,
    count: u32,
    sweep: Sweep<D>,
}

impl<const D: usize> Solids<D> {
    /// Removes all solids; the memory is kept.
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

    /// Adds another box to the solid that was added last.
    pub fn push_more(&mut self, part: AxisBox<D>, budget: &Budget<'_>) -> Result<(), Spent> {
        self.count = self.count.saturating_sub(1);
        self.push_box(part, budget)
    }

    const BYTES_PER_BOX: usize = size_of::<AxisBox<D>>() + size_of::<u32>();

    /// What was added last is one solid. There are fewer boxes than can be counted in 32
    /// bits ([`Cap::Pieces`]), and more solids are not told apart.
    fn count_solid(&mut self) {
        self.solids.resize(self.boxes.len(), self.count);
        self.count = self.count.saturating_add(1);
    }

    /// The solid that reaches deepest into the box from `min` to `max` (which may be a point):
    /// its index by order of addition, the axis along which the shortest move takes the box out
    /// of it, and the length of that move, metres. The first of equals; `None` if no solid
    /// reaches into the box. A polygon counts by the boxes that it was cut into.
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

    /// The bounds for the channels of a cavity that `body` leaves along `exit`:
    /// [`Solids::bounds`], whose side towards the exit is the mouth.
    ///
    /// If the body reaches the mouth or sticks out of it, they end one length of the body beyond
    /// it, since a channel must be larger than the body. The mouth stays where it is.
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

    /// Where a cavity between the solids ends along `exit`: outside it there is none of them.
    pub fn mouth(&self, exit: Direction) -> Option<HalfSpace> {
        Some(mouth_of(&self.bounds()?, exit))
    }

    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        let boxes = self.boxes.capacity() * size_of::<AxisBox<D>>();
        boxes + self.solids.capacity() * size_of::<u32>() + self.sweep.bytes()
    }

    /// Refills `channels` with all maximal free boxes within `bounds` that are larger than
    /// `body` (metres) along every axis, sorted by least, then greatest corner, the first axis
    /// first.
    ///
    /// Exact: coordinates of the solids and of `bounds` are compared, never computed with. Time
    /// grows about as n log n with the number n of solids, of boxes found, and of candidates
    /// dropped on the way. In two dimensions the boxes can be as many as the square of the
    /// solids; they are about as many as the solids if these stand apart evenly.
    ///
    /// ```
    /// use planning::budget::Budget;
    /// use planning::free_space::solids::Solids;
    /// use planning::geometry::AxisBox;
    ///
    /// // A pillar in the middle of a room of 6 m by 4 m leaves four channels.
    /// let (mut solids, budget) = (Solids::default(), Budget::default());
    /// solids.push_box(AxisBox::new([2.0, 1.0].into(), [4.0, 3.0].into())?, &budget)?;
    /// let room = AxisBox::new([0.0, 0.0].into(), [6.0, 4.0].into())?;
    /// let mut channels = Vec::new();
    /// solids.channels(&room, &[0.5, 0.5].into(), &budget, &mut channels)?;
    /// assert_eq!(channels.len(), 4);
    /// // Only those to the left and to the right are wider than 1 m along x and y.
    /// solids.channels(&room, &[1.0, 1.0].into(), &budget, &mut channels)?;
    /// let left = AxisBox::new([0.0, 0.0].into(), [2.0, 4.0].into())?;
    /// let right = AxisBox::new([4.0, 0.0].into(), [6.0, 4.0].into())?;
    /// assert_eq!(channels, [left, right]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
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
    /// Adds a solid polygon whose edges are parallel to the axes, cut into boxes exactly.
    pub fn push_polygon(
        &mut self,
        polygon: &Polygon,
        budget: &Budget<'_>,
    ) -> Result<(), SolidsError> {
        let before = self.boxes.len();
        outline::cut(polygon.vertices(), &mut self.boxes, budget)?;
        budget.hold((self.boxes.len() - before) * Self::BYTES_PER_BOX)?;
        self.count_solid();
        Ok(())
    }
}

#[cfg(test)]
mod tests;
