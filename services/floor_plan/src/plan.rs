//! A map that has been read.

use std::fs;
use std::path::Path;

use schemas::message::{AxisBox, FreeSpace, Solid, Vector};

use crate::border;
use crate::description::{Description, UnknownCells};
use crate::error::MapError;
use crate::frame::MapFrame;
use crate::grid::OccupancyGrid;
use crate::outlines::{self, Outlines, SharedVertices};
use crate::picture;
use crate::{MOST_CELLS, MOST_CORNERS};

/// A map that has been read.
#[derive(Debug, Clone)]
pub struct FloorPlan {
    grid: OccupancyGrid,
    frame: MapFrame,
    free_threshold: f64,
    outlines: Outlines,
}

impl FloorPlan {
    pub(crate) fn read(path: &Path, unknown: UnknownCells) -> Result<Self, MapError> {
        let text = fs::read_to_string(path)
            .map_err(|cause| MapError::Read { path: path.to_owned(), cause })?;
        let description = Description::read(path, &text)?;
        let grid = picture::read(&description, MOST_CELLS)?;
        let size = [grid.width(), grid.height()];
        let frame = MapFrame::new(path, &description, size)?;
        let solid = grid.solid(unknown == UnknownCells::Free);
        let cells = size[0] * size[1];
        if solid.len() == cells {
            let free = description.free;
            return Err(MapError::NothingFree { path: path.to_owned(), cells, free });
        }
        let shared = match frame.is_turned() {
            true => SharedVertices::Kept,
            false => SharedVertices::Dropped,
        };
        let outlines = outlines::trace(&solid, size, shared, MOST_CORNERS).map_err(|has| {
            MapError::TooManyCorners { path: path.to_owned(), has, most: MOST_CORNERS }
        })?;
        Ok(Self { grid, frame, free_threshold: description.free, outlines })
    }

    /// What the cells are.
    pub fn grid(&self) -> &OccupancyGrid {
        &self.grid
    }

    /// Where they are.
    pub fn frame(&self) -> &MapFrame {
        &self.frame
    }

    /// The map's `free_thresh`.
    pub fn free_threshold(&self) -> f64 {
        self.free_threshold
    }

    /// Simple polygons that together are exactly the cells that are not free, in cells.
    pub fn outlines(&self) -> &Outlines {
        &self.outlines
    }

    /// The free space in metres. Solids are the outlines. The bounds are the picture's; around
    /// a turned picture they are the least box, and what lies between is solid, too.
    ///
    /// A corner of cells always has the same coordinates, so outlines that touch do so exactly.
    pub fn free_space(&self) -> FreeSpace {
        let size = [self.grid.width() as u32, self.grid.height() as u32];
        let mut solids = self.solids(&self.outlines);
        let (min, max) = self.frame.extent(size);
        if self.frame.is_turned() {
            let sides = border::sides(size, &self.outlines);
            let between = border::between(&self.frame, &sides, [min, max]);
            let polygon = |vertices: Vec<[f64; 2]>| vertices.into_iter().map(Vector::from);
            solids.extend(between.map(|vertices| Solid::Polygon(polygon(vertices).collect())));
        }
        let bounds = Some(AxisBox { min: min.into(), max: max.into() });
        FreeSpace { solids: Some(solids), bounds, ..FreeSpace::default() }
    }

    /// The cells that nothing is known of, as polygons in metres: for pictures. Empty if they
    /// have too many corners.
    pub fn unknown(&self) -> Vec<Solid> {
        let size = [self.grid.width(), self.grid.height()];
        let unknown = self.grid.unknown();
        let outlines = outlines::trace(unknown, size, SharedVertices::Dropped, MOST_CORNERS);
        outlines.map(|outlines| self.solids(&outlines)).unwrap_or_default()
    }

    fn solids(&self, outlines: &Outlines) -> Vec<Solid> {
        let place = |corner: &[u32; 2]| Vector::from(self.frame.place(*corner));
        let solid = |outline: &[[u32; 2]]| Solid::Polygon(outline.iter().map(place).collect());
        outlines.iter().map(solid).collect()
    }
}
