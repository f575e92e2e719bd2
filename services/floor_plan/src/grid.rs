//! Which cells of a map are what.

use crate::MOST_CELLS;
use crate::cells::CellSet;
use crate::error::CellsError;

/// Whether a robot may drive where nothing is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UnknownCells {
    /// It must not: unknown cells are as solid as walls.
    #[default]
    Occupied,
    /// It may.
    Free,
}

/// What the map server would call a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellState {
    /// Nothing there.
    Free,
    /// Something there, or likely.
    Occupied,
    /// Never seen.
    Unknown,
}

/// The cells of a map, by column from the least x and row from the least y (in the picture:
/// from its lower left corner).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OccupancyGrid {
    width: usize,
    height: usize,
    occupied: CellSet,
    unknown: CellSet,
    grey: CellSet,
}

impl OccupancyGrid {
    /// A grid of free cells.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let set = CellSet::new(width, height);
        Self { width, height, occupied: set.clone(), unknown: set.clone(), grey: set }
    }

    /// A grid of percentages; see [`crate::FloorPlan::from_occupancy`].
    pub(crate) fn from_occupancy(
        cells: &[i8],
        [width, height]: [u64; 2],
        free_most: u8,
    ) -> Result<Self, CellsError> {
        Self::check_size(width, height)?;
        if cells.len() as u64 != width * height {
            let (has, needs) = (cells.len(), width * height);
            return Err(CellsError::CellCount { width, height, has, needs });
        }
        let width = width as usize;
        let mut grid = Self::new(width, height as usize);
        for (y, row) in cells.chunks_exact(width).enumerate() {
            let [occupied, unknown, _] = grid.rows_mut(y);
            for (x, cell) in row.iter().enumerate() {
                match u8::try_from(*cell) {
                    Ok(percent) if percent <= free_most => {}
                    Ok(0..=100) => occupied[x / 64] |= 1 << (x % 64),
                    _ => unknown[x / 64] |= 1 << (x % 64),
                }
            }
        }
        Ok(grid)
    }

    /// Whether a map may have this size.
    pub(crate) fn check_size(width: u64, height: u64) -> Result<(), CellsError> {
        if width == 0 || height == 0 {
            return Err(CellsError::NoCells { width, height });
        }
        let has = width * height;
        if has > MOST_CELLS {
            return Err(CellsError::TooManyCells { width, height, has, most: MOST_CELLS });
        }
        Ok(())
    }

    /// How many columns there are.
    pub fn width(&self) -> usize {
        self.width
    }

    /// How many rows there are.
    pub fn height(&self) -> usize {
        self.height
    }

    /// What a cell is; `None` outside the picture.
    pub fn cell(&self, x: usize, y: usize) -> Option<CellState> {
        (x < self.width && y < self.height).then(|| {
            match (self.occupied.contains(x, y), self.unknown.contains(x, y)) {
                (true, _) => CellState::Occupied,
                (_, true) => CellState::Unknown,
                _ => CellState::Free,
            }
        })
    }

    /// Whether a cell is free although its occupancy is 0.196 or more: where `free_thresh` is
    /// what the map server's own tools write, it would be unknown.
    pub fn is_grey(&self, x: usize, y: usize) -> bool {
        y < self.height && self.grey.contains(x, y)
    }

    /// Whether any cell is free although grey.
    pub fn has_grey(&self) -> bool {
        !self.grey.is_empty()
    }

    /// The cells that are not free; unknown ones are if `unknown_is_free`.
    pub(crate) fn solid(&self, unknown_is_free: bool) -> CellSet {
        let mut solid = self.occupied.clone();
        if !unknown_is_free {
            for y in 0..self.height {
                let unknown = self.unknown.row(y);
                solid.row_mut(y).iter_mut().zip(unknown).for_each(|(word, more)| *word |= more);
            }
        }
        solid
    }

    /// The unknown cells.
    pub(crate) fn unknown(&self) -> &CellSet {
        &self.unknown
    }

    /// The sets' rows at `y`: occupied, unknown, grey.
    pub(crate) fn rows_mut(&mut self, y: usize) -> [&mut [u64]; 3] {
        [self.occupied.row_mut(y), self.unknown.row_mut(y), self.grey.row_mut(y)]
    }
}
