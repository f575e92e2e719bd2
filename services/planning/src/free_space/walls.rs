//! Walls: what a body must not touch.

use std::ops::Range;

use crate::budget::{Budget, Spent};
use crate::geometry::box_tree::{BoxTree, distance_squared_box_box};
use crate::geometry::distance::distance_point_segment;
use crate::geometry::polygon::{self, Polygon};
use crate::geometry::{AxisBox, Sign, Vector};

mod complement;
mod free;

pub use complement::Complement;

/// Up to this many walls there is no index: checking them all is faster.
const FEW: usize = 64;

/// Walls compared in one step, where there is no index.
const WALLS_PER_STEP: u64 = 2;

/// Solids passed over in one step.
const SOLIDS_PER_STEP: u64 = 8;

/// A flat piece of wall, metres: in two dimensions the segment from `from` to `to`, in three
/// the axis-parallel rectangle between these opposite corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall<const D: usize> {
    /// One end, or the corner with the least coordinates.
    pub from: Vector<D>,
    /// The other end, or the corner with the greatest coordinates.
    pub to: Vector<D>,
}

impl<const D: usize> Wall<D> {
    /// The least and the greatest corner of the smallest box around it.
    pub fn bounds(&self) -> (Vector<D>, Vector<D>) {
        (self.from.inf(&self.to), self.from.sup(&self.to))
    }

    /// Whether it is perpendicular to an axis; in three dimensions all walls are.
    pub fn is_axis_parallel(&self) -> bool {
        (0..D).any(|axis| self.from[axis] == self.to[axis])
    }
}

/// A solid whose surface is among the walls.
#[derive(Debug, Clone, Copy)]
struct SolidSurface<const D: usize> {
    bounds: AxisBox<D>,
    /// The solid that it is the surface of, or of a part of, by order of addition.
    solid: usize,
    /// The index of its first wall, and their number.
    walls: (usize, usize),
    /// Whether it fills its bounds.
    is_box: bool,
}

/// All walls of a scene. Reusable memory: 320 bytes per channel of a chain in two dimensions.
///
/// Call [`Walls::index`] after the last addition. Without it searches give the same results,
/// only slower.
#[derive(Debug, Clone, Default)]
pub struct Walls<const D: usize> {
    walls: Vec<Wall<D>>,
    solids: Vec<SolidSurface<D>>,
    tree: BoxTree<D>,
}

impl<const D: usize> Walls<D> {
    /// Removes all walls; the memory is kept.
    pub fn clear(&mut self) {
        self.walls.clear();
        self.solids.clear();
        self.tree.clear();
    }

    /// Adds a wall.
    pub fn push(&mut self, wall: Wall<D>) {
        self.tree.clear();
        self.walls.push(wall);
    }

    /// Adds the sides of a solid box.
    pub fn push_box(&mut self, solid: &AxisBox<D>) {
        self.push_box_of(solid, self.next_solid());
    }

    /// Adds the sides of another box of the solid that was added last.
    pub fn push_more(&mut self, part: &AxisBox<D>) {
        self.push_box_of(part, self.next_solid().saturating_sub(1));
    }

    fn next_solid(&self) -> usize {
        self.solids.last().map_or(0, |last| last.solid + 1)
    }

    fn push_box_of(&mut self, solid: &AxisBox<D>, number: usize) {
        let first = self.walls.len();
        for axis in 0..D {
            for sign in [Sign::Negative, Sign::Positive] {
                let (mut from, mut to) = (solid.min(), solid.max());
                match sign {
                    Sign::Negative => to[axis] = from[axis],
                    Sign::Positive => from[axis] = to[axis],
                }
                self.push(Wall { from, to });
            }
        }
        let walls = (first, 2 * D);
        self.solids.push(SolidSurface { bounds: *solid, solid: number, walls, is_box: true });
    }

    /// Builds the index that makes searches among many walls fast; to be called after the
    /// last addition. Allocates only for more walls than ever before.
    ///
    /// The memory of all walls is left taken from the budget.
    pub fn index(&mut self, budget: &Budget<'_>) -> Result<(), Spent> {
        let Self { walls, solids, tree } = self;
        budget.hold(size_of_val(&**walls) + size_of_val(&**solids))?;
        if walls.len() > FEW {
            budget.hold(BoxTree::<D>::bytes_for(walls.len()))?;
            tree.build(walls.len(), |index| walls[index].bounds(), budget)?;
        }
        Ok(())
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let walls = self.walls.capacity() * size_of::<Wall<D>>();
        walls + self.solids.capacity() * size_of::<SolidSurface<D>>() + self.tree.bytes()
    }

    /// All walls, in the order of addition.
    pub fn as_slice(&self) -> &[Wall<D>] {
        &self.walls
    }

    /// Calls `visit` with at least every wall within `reach` of the box from `min` to `max`:
    /// up to 64 walls in the order of [`Walls::as_slice`], more in an order that depends on
    /// the walls only.
    pub fn near(
        &self,
        min: &Vector<D>,
        max: &Vector<D>,
        reach: f64,
        budget: &Budget<'_>,
        mut visit: impl FnMut(usize, &Wall<D>),
    ) -> Result<(), Spent> {
        if !self.tree.is_empty() {
            return self.tree.visit(min, max, reach, budget, |index| {
                visit(index, &self.walls[index]);
                reach
            });
        }
        budget.step(1 + self.walls.len() as u64 / WALLS_PER_STEP)?;
        for (index, wall) in self.walls.iter().enumerate() {
            let (low, high) = wall.bounds();
            if distance_squared_box_box((&low, &high), (min, max)) <= reach * reach {
                visit(index, wall);
            }
        }
        Ok(())
    }

    /// Calls `visit` with at least every wall within `reach` of a segment, until it returns
    /// false; in an order that depends on the walls only.
    pub(crate) fn near_line(
        &self,
        segment: (&Vector<D>, &Vector<D>),
        reach: f64,
        budget: &Budget<'_>,
        mut visit: impl FnMut(usize, &Wall<D>) -> bool,
    ) -> Result<(), Spent> {
        if !self.tree.is_empty() {
            let visit = |index: usize| visit(index, &self.walls[index]);
            return self.tree.visit_along(segment, reach, budget, visit);
        }
        budget.step(self.walls.len() as u64)?;
        let margin = Vector::repeat(reach);
        let low = segment.0.inf(segment.1) - margin;
        let high = segment.0.sup(segment.1) + margin;
        for (index, wall) in self.walls.iter().enumerate() {
            let (min, max) = wall.bounds();
            let is_far = (0..D).any(|axis| max[axis] < low[axis] || high[axis] < min[axis]);
            if !is_far && !visit(index, wall) {
                break;
            }
        }
        Ok(())
    }

    /// Calls `visit` once with at least every wall that is as near to the box from `min` to
    /// `max` as the distance that `visit` returned last.
    pub fn nearest(
        &self,
        min: &Vector<D>,
        max: &Vector<D>,
        budget: &Budget<'_>,
        mut visit: impl FnMut(usize, &Wall<D>) -> f64,
    ) -> Result<(), Spent> {
        if !self.tree.is_empty() {
            let visit = |index| visit(index, &self.walls[index]);
            return self.tree.visit(min, max, f64::INFINITY, budget, visit);
        }
        budget.step(1 + self.walls.len() as u64 / WALLS_PER_STEP)?;
        // The nearest of the few first, then those still in reach.
        let (few, more) = self.walls.split_at(self.walls.len().min(FEW));
        let mut distances = [0.0; FEW];
        let mut first = 0;
        for (index, wall) in few.iter().enumerate() {
            let (low, high) = wall.bounds();
            distances[index] = distance_squared_box_box((&low, &high), (min, max));
            if distances[index] < distances[first] {
                first = index;
            }
        }
        let Some(wall) = few.get(first) else { return Ok(()) };
        let mut reach = visit(first, wall);
        for (index, wall) in few.iter().enumerate() {
            if index != first && reach >= 0.0 && distances[index] <= reach * reach {
                reach = visit(index, wall);
            }
        }
        for (index, wall) in more.iter().enumerate() {
            if reach >= 0.0 {
                reach = visit(FEW + index, wall);
            }
        }
        Ok(())
    }

    /// The index of the first wall of a solid that has `point` inside, if there is one.
    pub fn solid_around(
        &self,
        point: &Vector<D>,
        budget: &Budget<'_>,
    ) -> Result<Option<usize>, Spent> {
        budget.step(1 + self.solids.len() as u64 / SOLIDS_PER_STEP)?;
        for solid in &self.solids {
            let (min, max) = (solid.bounds.min(), solid.bounds.max());
            if !(0..D).all(|axis| min[axis] < point[axis] && point[axis] < max[axis]) {
                continue;
            }
            let (first, count) = solid.walls;
            let edges = self.walls[first..first + count].iter();
            let edges = edges.map(|wall| (planar(&wall.from), planar(&wall.to)));
            budget.step(count as u64)?;
            if solid.is_box || polygon::contains(edges, &planar(point)) {
                return Ok(Some(first));
            }
        }
        Ok(None)
    }

    /// The solid to which a wall belongs, counted in the order of addition.
    pub fn solid_of(&self, wall: usize) -> Option<usize> {
        self.surface_of(wall).map(|surface| surface.solid)
    }

    /// The surface of the solid, or of the part of one, to which a wall belongs.
    fn surface_of(&self, wall: usize) -> Option<&SolidSurface<D>> {
        let after = self.solids.partition_point(|surface| surface.walls.0 <= wall);
        let surface = &self.solids[after.checked_sub(1)?];
        let (first, count) = surface.walls;
        (wall < first + count).then_some(surface)
    }

    /// All walls of the surface to which a wall belongs, in the order of its outline unless it is a box.
    pub(crate) fn walls_beside(&self, wall: usize) -> Option<Range<usize>> {
        let (first, count) = self.surface_of(wall)?.walls;
        Some(first..first + count)
    }

    /// The box to whose surface a wall belongs, if it was added as one.
    pub(crate) fn box_of(&self, wall: usize) -> Option<&AxisBox<D>> {
        let surface = self.surface_of(wall)?;
        surface.is_box.then_some(&surface.bounds)
    }

    /// The smallest box around all walls; `None` without any.
    pub fn bounds(&self) -> Option<AxisBox<D>> {
        let corners = self.walls.iter().map(Wall::bounds);
        let (min, max) = corners.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))?;
        AxisBox::new(min, max).ok()
    }

    /// Whether the interior of `space` is free: no wall passes through it, and it is not
    /// inside a solid. It may touch walls, to within rounding (some 1e-14 of the coordinates).
    pub fn is_free(&self, space: &AxisBox<D>, budget: &Budget<'_>) -> Result<bool, Spent> {
        let mut free = true;
        self.nearest(&space.min(), &space.max(), budget, |_, wall| {
            free &= !free::passes_through(wall, space);
            // Only walls that touch the box can pass through it.
            if free { 0.0 } else { -1.0 }
        })?;
        // No wall passes through it, so it is inside a solid wholly or not at all.
        Ok(free && self.solid_around(&space.center(), budget)?.is_none())
    }
}

impl Walls<2> {
    /// Which solid has `point` inside, counted in the order of addition, and how far its nearest
    /// wall is, metres.
    pub fn depth_in_solid(
        &self,
        point: &Vector<2>,
        budget: &Budget<'_>,
    ) -> Result<Option<(usize, f64)>, Spent> {
        let Some(first) = self.solid_around(point, budget)? else { return Ok(None) };
        let surface = self.solids.iter().find(|solid| solid.walls.0 == first);
        let Some(SolidSurface { solid, walls: (first, count), .. }) = surface else {
            return Ok(None);
        };
        let (solid, first, count) = (*solid, *first, *count);
        budget.step(count as u64)?;
        let walls = self.walls[first..first + count].iter();
        let distances = walls.map(|wall| distance_point_segment(point, (&wall.from, &wall.to)));
        Ok(Some((solid, distances.fold(f64::INFINITY, f64::min))))
    }

    /// Adds the sides of a box whose inside is free.
    pub fn push_inside(&mut self, bounds: &AxisBox<2>) {
        let (min, max) = (bounds.min(), bounds.max());
        let (right, left) = (Vector::from([max.x, min.y]), Vector::from([min.x, max.y]));
        for (from, to) in [(min, right), (right, max), (max, left), (left, min)] {
            self.push(Wall { from, to });
        }
    }

    /// Adds the edges of a solid polygon.
    pub fn push_polygon(&mut self, solid: &Polygon) {
        let first = self.walls.len();
        for (from, to) in polygon::edges(solid.vertices()) {
            self.push(Wall { from, to });
        }
        let walls = (first, self.walls.len() - first);
        let (bounds, number) = (*solid.bounds(), self.next_solid());
        self.solids.push(SolidSurface { bounds, solid: number, walls, is_box: false });
    }
}

/// The first two coordinates.
pub(crate) fn planar<const D: usize>(point: &Vector<D>) -> Vector<2> {
    Vector::from([point[0], point[1]])
}

#[cfg(test)]
mod tests;
