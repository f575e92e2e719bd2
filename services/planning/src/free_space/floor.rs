//! A floor: free space among walls at any angle.
//!
//! The walls are triangulated (constrained Delaunay, crate `spade`, exact predicates). A face is a
//! channel, the edge between two faces a junction. What is free is what can be reached without
//! crossing a wall, so overlapping, touching and coincident solids need no union: where walls
//! cross, the triangulation has a vertex of its own, which is rounded and stands for topology
//! only. Distances are measured to the walls as they were given.

use thiserror::Error;

use super::walls::{Wall, Walls};
use crate::budget::{Budget, Spent};
use crate::geometry::Vector;
use crate::geometry::orientation::{Side, side_of_line};

mod corner;
mod locate;
mod triangulate;

pub(crate) use corner::Reflex;

/// Stands for no face, vertex or edge.
pub(crate) const NONE: u32 = u32::MAX;

/// A triangle of the floor, counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Face {
    /// Indices of its vertices.
    pub(crate) vertices: [u32; 3],
    /// The face across the edge from vertex `i` to vertex `i + 1`, whether or not a wall is
    /// between; `NONE` outside the hull.
    pub(crate) across: [u32; 3],
    /// Whether that edge is (part of) a wall.
    pub(crate) is_wall: [bool; 3],
}

impl Face {
    /// The face on the other side of an edge that is no wall.
    pub(crate) fn beyond(&self, edge: usize) -> Option<u32> {
        (!self.is_wall[edge] && self.across[edge] != NONE).then_some(self.across[edge])
    }

    /// Which of its edges leads to `face`.
    pub(crate) fn edge_to(&self, face: u32) -> Option<usize> {
        self.across.iter().position(|across| *across == face)
    }

    /// Which of its vertices `vertex` is.
    pub(crate) fn index_of(&self, vertex: u32) -> Option<usize> {
        self.vertices.iter().position(|other| *other == vertex)
    }
}

/// Free space among walls at any angle.
#[derive(Debug, Clone, Default)]
pub struct Floor {
    /// Positions of the vertices, metres: the ends of walls, then the places where walls cross.
    vertices: Vec<Vector<2>>,
    faces: Vec<Face>,
    /// A face at each vertex.
    face_at: Vec<u32>,
    /// The corner at each vertex that a robot can turn about.
    corners: Vec<Option<Reflex>>,
    /// Width of the box around everything, and the greatest coordinate; metres.
    extent: f64,
    farthest: f64,
}

/// Why walls can't be made a floor.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum FloorError {
    /// There is no wall, or all walls lie on one line.
    #[error("the walls enclose nothing")]
    Empty,
    /// The budget has been spent.
    #[error(transparent)]
    Spent(#[from] Spent),
}

impl Floor {
    /// Triangulates the space among walls, in the order of n log n for n walls and their
    /// crossings.
    pub fn new(walls: &Walls<2>, budget: &Budget<'_>) -> Result<Self, FloorError> {
        let mut floor = triangulate::triangulate(walls.as_slice(), budget)?;
        corner::find(&mut floor, budget)?;
        Ok(floor)
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.vertices.capacity() * size_of::<Vector<2>>()
            + self.faces.capacity() * size_of::<Face>()
            + self.face_at.capacity() * size_of::<u32>()
            + self.corners.capacity() * size_of::<Option<Reflex>>()
    }

    /// Calls `each` with the other end of every wall that ends at a vertex.
    pub(crate) fn walls_at(&self, vertex: u32, mut each: impl FnMut(u32)) {
        let first = self.face_at[vertex as usize];
        if first == NONE {
            return;
        }
        // Around the vertex to the left; where all there is ends, the rest to the right.
        for turn in [2, 0] {
            let mut index = first;
            loop {
                let face = self.face(index);
                let Some(at) = face.index_of(vertex) else { return };
                let side = (at + turn) % 3;
                if face.is_wall[side] {
                    each(face.vertices[(at + if turn == 2 { 2 } else { 1 }) % 3]);
                }
                match face.across[side] {
                    next if next == first => return,
                    NONE => break,
                    next => index = next,
                }
            }
        }
    }

    /// The triangles, as their corners in metres; free or not.
    pub fn triangles(&self) -> impl Iterator<Item = [Vector<2>; 3]> + '_ {
        self.faces.iter().map(|face| face.vertices.map(|vertex| self.vertex(vertex)))
    }

    /// How far a computed distance may be off by rounding, metres: positions have an error that
    /// grows with their coordinates.
    pub fn rounding(&self) -> f64 {
        16.0 * f64::EPSILON * self.farthest + 1e-12 * self.extent
    }

    /// Width of the box around all walls, metres.
    pub(crate) fn extent(&self) -> f64 {
        self.extent
    }

    pub(crate) fn vertex(&self, index: u32) -> Vector<2> {
        self.vertices[index as usize]
    }

    pub(crate) fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    pub(crate) fn face_count(&self) -> usize {
        self.faces.len()
    }

    pub(crate) fn face(&self, index: u32) -> &Face {
        &self.faces[index as usize]
    }

    pub(crate) fn corner(&self, vertex: u32) -> Option<&Reflex> {
        self.corners[vertex as usize].as_ref()
    }

    /// On which side of the line between two vertices a vertex lies.
    pub(crate) fn side(&self, from: &Vector<2>, to: u32, point: u32) -> Side {
        side_of_line(from, &self.vertices[to as usize], &self.vertices[point as usize])
    }
}

#[cfg(test)]
mod tests;
