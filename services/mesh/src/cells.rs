//! The cells between planes: which are inside, and the boxes that they make.

use crate::Block;
use crate::error::MeshError;
use crate::faces::{Faces, beside};

/// The most cells that are looked at, and the most that faces cover; bounds time and memory.
const MOST: usize = 1 << 24;

/// Cells in a grid whose steps are those between planes.
struct Grid<'a> {
    planes: &'a [Vec<f64>; 3],
    /// Cells along each axis.
    counts: [usize; 3],
}

impl Grid<'_> {
    fn index(&self, cell: [usize; 3]) -> usize {
        (cell[0] * self.counts[1] + cell[1]) * self.counts[2] + cell[2]
    }

    fn middle(&self, axis: usize, cell: usize) -> f64 {
        let planes = &self.planes[axis];
        planes[cell] / 2.0 + planes[cell + 1] / 2.0
    }

    fn center(&self, cell: [usize; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.middle(axis, cell[axis]))
    }
}

/// The boxes inside.
pub(crate) fn inside(faces: &Faces) -> Result<Vec<Block>, MeshError> {
    let planes = &faces.planes;
    let counts = [0, 1, 2].map(|axis| planes[axis].len().saturating_sub(1));
    let too_fine = || MeshError::TooFine { counts: counts.map(|count| count + 1), most: MOST };
    let cells = counts.iter().try_fold(1_usize, |cells, count| cells.checked_mul(*count));
    let cells = cells.filter(|cells| *cells <= MOST).ok_or_else(too_fine)?;
    let grid = Grid { planes, counts };
    let mut left = MOST;
    let mut inside: Option<Vec<bool>> = None;
    // Seen along each axis the same cells must be inside.
    for axis in 0..3 {
        let seen = along(axis, faces, &grid, cells, &mut left)?.ok_or_else(too_fine)?;
        if let Some(first) = &inside {
            let differs = first.iter().zip(&seen).position(|(one, other)| one != other);
            if let Some(index) = differs {
                return Err(MeshError::Open { near: grid.center(cell_at(index, &counts)) });
            }
        }
        inside = Some(seen);
    }
    let mut inside = inside.unwrap_or_default();
    if !inside.contains(&true) {
        return Err(MeshError::Empty);
    }
    Ok(put_together(&mut inside, &grid))
}

fn cell_at(index: usize, counts: &[usize; 3]) -> [usize; 3] {
    let row = index / counts[2];
    [row / counts[1], row % counts[1], index % counts[2]]
}

/// Which cells are inside, going through the faces across an axis; none if they cover more than `left` cells.
fn along(
    axis: usize,
    faces: &Faces,
    grid: &Grid<'_>,
    cells: usize,
    left: &mut usize,
) -> Result<Option<Vec<bool>>, MeshError> {
    let [u, v] = beside(axis);
    // How many times the mesh is entered, less how many times it is left, before each cell.
    let mut entered = vec![0_i32; cells];
    // The same at the last plane, behind all cells.
    let mut behind = vec![0_i32; grid.counts[u] * grid.counts[v]];
    for face in &faces.across[axis] {
        let [[first_u, last_u], [first_v, last_v]] = face.extent();
        let covered = (last_u - first_u) * (last_v - first_v);
        match left.checked_sub(covered) {
            Some(rest) => *left = rest,
            None => return Ok(None),
        }
        let change = if face.opens { 1 } else { -1 };
        for at_u in first_u..last_u {
            for at_v in first_v..last_v {
                if !face.has([grid.middle(u, at_u), grid.middle(v, at_v)]) {
                    continue;
                }
                if face.plane == grid.counts[axis] {
                    behind[at_u * grid.counts[v] + at_v] += change;
                } else {
                    let mut cell = [0; 3];
                    (cell[axis], cell[u], cell[v]) = (face.plane, at_u, at_v);
                    entered[grid.index(cell)] += change;
                }
            }
        }
    }
    let mut inside = vec![false; cells];
    for at_u in 0..grid.counts[u] {
        for at_v in 0..grid.counts[v] {
            let mut within = 0;
            let mut cell = [0; 3];
            (cell[u], cell[v]) = (at_u, at_v);
            for at in 0..grid.counts[axis] {
                cell[axis] = at;
                within += entered[grid.index(cell)];
                inside[grid.index(cell)] = within != 0;
            }
            if within + behind[at_u * grid.counts[v] + at_v] != 0 {
                return Err(MeshError::Open { near: grid.center(cell) });
            }
        }
    }
    Ok(Some(inside))
}

/// Boxes that cover the cells inside, each once: as long as they can be along the last axis, then along the
/// others.
fn put_together(inside: &mut [bool], grid: &Grid<'_>) -> Vec<Block> {
    let counts = grid.counts;
    let mut blocks = Vec::new();
    for index in 0..inside.len() {
        if !inside[index] {
            continue;
        }
        let first = cell_at(index, &counts);
        let mut last = first.map(|at| at + 1);
        for axis in [2, 1, 0] {
            while last[axis] < counts[axis] {
                let (mut from, mut to) = (first, last);
                (from[axis], to[axis]) = (last[axis], last[axis] + 1);
                if !cells_of(from, to).all(|cell| inside[grid.index(cell)]) {
                    break;
                }
                last[axis] += 1;
            }
        }
        cells_of(first, last).for_each(|cell| inside[grid.index(cell)] = false);
        let corner = |cell: [usize; 3]| [0, 1, 2].map(|axis| grid.planes[axis][cell[axis]]);
        blocks.push(Block { min: corner(first), max: corner(last) });
    }
    blocks
}

fn cells_of(first: [usize; 3], last: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let along = move |axis: usize| first[axis]..last[axis];
    along(0).flat_map(move |x| along(1).flat_map(move |y| along(2).map(move |z| [x, y, z])))
}
