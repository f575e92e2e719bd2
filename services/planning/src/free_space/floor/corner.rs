//! Corners that a path can turn about: reflex vertices of the free space.

use super::{Floor, NONE};
use crate::budget::{Budget, Spent};
use crate::geometry::Vector;
use crate::geometry::orientation::{Side, side_of_line};

/// Steps of the budget that a vertex takes.
const STEPS_PER_VERTEX: u64 = 10;

/// A reflex vertex: the free space around it spans more than half a turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reflex {
    /// The first face of the free sector, counter-clockwise; its edge at the vertex is a wall.
    pub(crate) first: u32,
    /// The directions from the vertex to the centres of discs that touch it and no wall beside
    /// it, from the first to the last counter-clockwise: less than half a turn, unit vectors.
    pub(crate) normals: [Vector<2>; 2],
}

/// Finds the corners of all vertices.
pub(super) fn find(floor: &mut Floor, budget: &Budget<'_>) -> Result<(), Spent> {
    budget.step(STEPS_PER_VERTEX * floor.vertices.len() as u64)?;
    let corners = (0..floor.vertices.len()).map(|vertex| {
        let first = floor.face_at[vertex];
        if first == NONE { None } else { reflex(floor, u32::try_from(vertex).ok()?, first) }
    });
    floor.corners = corners.collect();
    Ok(())
}

/// The free sector of more than half a turn at a vertex, if there is one.
fn reflex(floor: &Floor, vertex: u32, at: u32) -> Option<Reflex> {
    // Back clockwise to a wall. Around a vertex without walls there is none.
    let mut first = at;
    loop {
        let face = floor.face(first);
        let index = face.index_of(vertex)?;
        if face.is_wall[index] || face.across[index] == NONE {
            break;
        }
        first = face.across[index];
        if first == at {
            return None;
        }
    }
    // Around, sector by sector.
    let (mut sector, mut face) = (first, first);
    let around = |face: u32, index: usize| floor.face(face).vertices[(index + 1) % 3];
    loop {
        let here = floor.face(face);
        let index = here.index_of(vertex)?;
        let edge = (index + 2) % 3;
        let next = here.across[edge];
        if here.is_wall[edge] || next == NONE {
            let from = around(sector, floor.face(sector).index_of(vertex)?);
            if let Some(corner) = corner(floor, vertex, sector, [from, here.vertices[edge]]) {
                return Some(corner);
            }
            sector = next;
        }
        if next == NONE || next == first {
            return None;
        }
        face = next;
    }
}

/// The corner of the sector from one wall counter-clockwise to another, given by their other
/// ends.
fn corner(floor: &Floor, vertex: u32, first: u32, ends: [u32; 2]) -> Option<Reflex> {
    let at = floor.vertex(vertex);
    let is_more_than_half = ends[0] == ends[1]
        || side_of_line(&at, &floor.vertex(ends[0]), &floor.vertex(ends[1])) == Side::Right;
    let [from, to] = ends.map(|end| {
        let way = floor.vertex(end) - at;
        way / way.norm()
    });
    let normals = [Vector::from([-from.y, from.x]), Vector::from([to.y, -to.x])];
    is_more_than_half.then_some(Reflex { first, normals })
}
