//! What the body must not touch.

use crate::geometry::Vector;

/// A flat piece of wall: in two dimensions the segment from `from` to `to`, in
/// three the axis-parallel rectangle between these opposite corners. Metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall<const D: usize> {
    /// One end, or the corner with the least coordinates.
    pub from: Vector<D>,
    /// The other end, or the corner with the greatest coordinates.
    pub to: Vector<D>,
}

/// All walls of a scene.
#[derive(Debug, Clone, Default)]
pub struct Walls<const D: usize> {
    walls: Vec<Wall<D>>,
}

impl<const D: usize> Walls<D> {
    /// Forgets all walls, keeping the memory.
    pub fn clear(&mut self) {
        self.walls.clear();
    }

    /// Adds a wall.
    pub fn push(&mut self, wall: Wall<D>) {
        self.walls.push(wall);
    }

    /// All walls, in the order in which they were added.
    pub fn as_slice(&self) -> &[Wall<D>] {
        &self.walls
    }

    /// Calls `visit` with (at least) every wall that comes closer than `reach`
    /// to the box from `min` to `max`, in the order of [`Walls::as_slice`].
    pub fn near(
        &self,
        min: &Vector<D>,
        max: &Vector<D>,
        reach: f64,
        mut visit: impl FnMut(usize, &Wall<D>),
    ) {
        for (index, wall) in self.walls.iter().enumerate() {
            let apart = (0..D).any(|axis| {
                wall.from[axis].max(wall.to[axis]) < min[axis] - reach
                    || wall.from[axis].min(wall.to[axis]) > max[axis] + reach
            });
            if !apart {
                visit(index, wall);
            }
        }
    }
}
