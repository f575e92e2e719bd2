//! Where a point lies on a floor.

use super::{Face, Floor, NONE};
use crate::budget::{Budget, Spent};
use crate::geometry::Vector;
use crate::geometry::orientation::{Side, side_of_line};

/// Steps of the budget that looking at a face takes.
const STEPS_PER_FACE: u64 = 2;

/// What can be reached from a point without crossing a wall.
#[derive(Debug)]
pub(crate) struct Reach {
    /// How many faces.
    pub(crate) faces: usize,
    /// The walls around them, by their ends.
    pub(crate) border: Vec<[u32; 2]>,
}

impl Floor {
    /// The faces that a point lies in or on the boundary of: one as a rule, two on an edge, all
    /// around a vertex. None outside.
    pub(crate) fn faces_around(
        &self,
        point: &Vector<2>,
        budget: &Budget<'_>,
    ) -> Result<Vec<u32>, Spent> {
        let Some(face) = self.face_of(point, budget)? else { return Ok(Vec::new()) };
        let mut faces = vec![face];
        let mut next = 0;
        while let Some(index) = faces.get(next).copied() {
            budget.step(STEPS_PER_FACE)?;
            let face = self.face(index);
            for edge in 0..3 {
                let across = face.across[edge];
                if across != NONE
                    && self.side_of_edge(face, edge, point) == Side::On
                    && !faces.contains(&across)
                    && self.holds(across, point)
                {
                    faces.push(across);
                }
            }
            next += 1;
        }
        Ok(faces)
    }

    /// What can be reached from a point without crossing a wall.
    pub(crate) fn reachable(&self, point: &Vector<2>, budget: &Budget<'_>) -> Result<Reach, Spent> {
        let mut reached = self.faces_around(point, budget)?;
        budget.step(self.faces.len() as u64 / 64)?;
        let mut known = vec![false; self.faces.len()];
        for face in &reached {
            known[*face as usize] = true;
        }
        let mut border = Vec::new();
        let mut next = 0;
        while let Some(index) = reached.get(next).copied() {
            budget.step(STEPS_PER_FACE)?;
            let face = self.face(index);
            for edge in 0..3 {
                match face.beyond(edge) {
                    None => border.push([edge, (edge + 1) % 3].map(|at| face.vertices[at])),
                    Some(beyond) => {
                        if !std::mem::replace(&mut known[beyond as usize], true) {
                            reached.push(beyond);
                        }
                    }
                }
            }
            next += 1;
        }
        Ok(Reach { faces: reached.len(), border })
    }

    /// A face that holds a point: found by walking towards it, or by looking at all.
    fn face_of(&self, point: &Vector<2>, budget: &Budget<'_>) -> Result<Option<u32>, Spent> {
        let mut at = self.nearest_of_some(point);
        let mut from = NONE;
        // A walk in a constrained triangulation may go in circles.
        let most = 64 + 8 * self.faces.len().isqrt();
        for _ in 0..most {
            budget.step(STEPS_PER_FACE)?;
            let face = self.face(at);
            let leads_there = |edge: &usize| {
                face.across[*edge] != from && self.side_of_edge(face, *edge, point) == Side::Right
            };
            match (0..3).find(leads_there) {
                Some(edge) if face.across[edge] == NONE => break,
                Some(edge) => (from, at) = (at, face.across[edge]),
                None if self.holds(at, point) => return Ok(Some(at)),
                None => break,
            }
        }
        budget.step(STEPS_PER_FACE * self.faces.len() as u64)?;
        let count = u32::try_from(self.faces.len()).unwrap_or(NONE);
        Ok((0..count).find(|face| self.holds(*face, point)))
    }

    /// The face whose first vertex is nearest to the point, of the root of their number.
    fn nearest_of_some(&self, point: &Vector<2>) -> u32 {
        let stride = self.faces.len().isqrt().max(1);
        let apart =
            |face: &usize| (self.vertex(self.faces[*face].vertices[0]) - point).norm_squared();
        let some = (0..self.faces.len()).step_by(stride);
        let nearest = some.min_by(|a, b| apart(a).total_cmp(&apart(b)));
        nearest.and_then(|face| u32::try_from(face).ok()).unwrap_or(0)
    }

    fn side_of_edge(&self, face: &Face, edge: usize, point: &Vector<2>) -> Side {
        let [from, to] = [edge, (edge + 1) % 3].map(|index| self.vertex(face.vertices[index]));
        side_of_line(&from, &to, point)
    }

    fn holds(&self, face: u32, point: &Vector<2>) -> bool {
        let face = self.face(face);
        (0..3).all(|edge| self.side_of_edge(face, edge, point) != Side::Right)
    }
}
