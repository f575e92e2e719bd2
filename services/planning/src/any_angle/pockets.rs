//! Pockets: parts of a floor that a disc leaves only the way it came in.
//!
//! A shortest path between places outside of a pocket hardly enters it. Between two crossings of
//! the pocket's gate, where it can't go straight, only what is before the gate is in the way: so
//! it stays within a radius of the gate, and what it turns about within two.

use crate::budget::{Budget, Spent};
use crate::free_space::floor::{Floor, NONE};

/// So many faces are looked at in the time of a step.
const FACES_PER_STEP: u64 = 2;

/// A face that is in no pocket.
const OPEN: u8 = 3;

/// Which faces are in pockets, for a disc.
#[derive(Debug, Default)]
pub(super) struct Pockets {
    /// By which edge a face in a pocket is left, or [`OPEN`].
    out: Vec<u8>,
    /// Faces opened for a search, and by which edges they were left.
    opened: Vec<(u32, u8)>,
}

impl Pockets {
    /// The memory that it holds, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.out.capacity() + self.opened.capacity() * size_of::<(u32, u8)>()
    }

    /// The steps that finding pockets takes.
    pub(super) fn steps(floor: &Floor) -> u64 {
        floor.face_count() as u64 / FACES_PER_STEP
    }

    /// Finds the pockets of a disc that can't cross an edge shorter than `width`, metres.
    pub(super) fn find(floor: &Floor, width: f64) -> Self {
        // For each face, a bit for each edge that leads on.
        let mut ways: Vec<u8> = Vec::with_capacity(floor.face_count());
        let mut ends = Vec::new();
        let least = if width > 0.0 { width * width } else { 0.0 };
        for index in 0..floor.face_count() as u32 {
            let face = floor.face(index);
            let corners = face.vertices.map(|vertex| floor.vertex(vertex));
            let is_way = |edge: &usize| {
                face.beyond(*edge).is_some()
                    && (corners[(*edge + 1) % 3] - corners[*edge]).norm_squared() >= least
            };
            let open = (0..3).filter(is_way).fold(0, |ways, edge| ways | 1 << edge);
            ways.push(open);
            if open.count_ones() == 1 {
                ends.push(index);
            }
        }
        let mut out = vec![OPEN; floor.face_count()];
        while let Some(index) = ends.pop() {
            // The last of a part that is all pocket stays open.
            let edge = ways[index as usize].trailing_zeros() as usize;
            let Some(next) = floor.face(index).across.get(edge).copied() else { continue };
            out[index as usize] = edge as u8;
            ways[index as usize] = 0;
            let Some(back) = floor.face(next).edge_to(index) else { continue };
            ways[next as usize] &= !(1 << back);
            if ways[next as usize].count_ones() == 1 {
                ends.push(next);
            }
        }
        Self { out, opened: Vec::new() }
    }

    /// Opens the ways out from some faces, and closes those opened before.
    pub(super) fn open_from(
        &mut self,
        floor: &Floor,
        faces: &[u32],
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        for (face, edge) in self.opened.drain(..).rev() {
            self.out[face as usize] = edge;
        }
        for face in faces {
            let mut index = *face;
            while self.out[index as usize] != OPEN {
                budget.step(1)?;
                let edge = std::mem::replace(&mut self.out[index as usize], OPEN);
                self.opened.push((index, edge));
                index = floor.face(index).across[usize::from(edge)];
            }
        }
        Ok(())
    }

    /// The gate of the pocket that a face is in: the edge, counted from 3 times a face's index;
    /// `NONE` if it is in none.
    pub(super) fn gate(&self, floor: &Floor, face: u32, budget: &Budget<'_>) -> Result<u32, Spent> {
        let (mut gate, mut index) = (NONE, face);
        loop {
            let edge = self.out[index as usize];
            if edge == OPEN {
                return Ok(gate);
            }
            budget.step(1)?;
            gate = 3 * index + u32::from(edge);
            index = floor.face(index).across[usize::from(edge)];
        }
    }

    /// The gate beyond an edge by which a face is entered, if `before` was the gate before.
    pub(super) fn gate_beyond(&self, face: u32, edge: u8, before: u32) -> u32 {
        match self.out[face as usize] {
            OPEN => NONE,
            out if before == NONE && out == edge => 3 * face + u32::from(edge),
            _ => before,
        }
    }
}
