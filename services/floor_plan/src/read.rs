//! Maps from files.

use std::fs;
use std::path::Path;

use crate::description::Description;
use crate::error::{CellsError, MapError};
use crate::grid::UnknownCells;
use crate::picture;
use crate::plan::FloorPlan;

/// Reads a map's YAML and the picture it names (relative to the YAML).
pub fn read(path: &Path, unknown: UnknownCells) -> Result<FloorPlan, MapError> {
    let text = fs::read_to_string(path)
        .map_err(|cause| MapError::Read { path: path.to_owned(), cause })?;
    let description = Description::read(path, &text)?;
    let grid = picture::read(&description)?;
    let Description { resolution, origin, free, .. } = description;
    FloorPlan::new(grid, resolution, origin, free, unknown).map_err(|cause| {
        let path = path.to_owned();
        match cause {
            CellsError::NothingFree { cells } => MapError::NothingFree { path, cells, free },
            cause => MapError::Grid { path, cause },
        }
    })
}
