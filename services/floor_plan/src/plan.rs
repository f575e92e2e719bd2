//! A map that has been read.

use schemas::message::{AxisBox, FreeSpace, Solid, Vector};

use crate::MOST_CORNERS;
use crate::border;
use crate::error::CellsError;
use crate::frame::MapFrame;
use crate::grid::{OccupancyGrid, UnknownCells};
use crate::outlines::{self, Outlines, SharedVertices};

/// A map that has been read.
#[derive(Debug, Clone)]
pub struct FloorPlan {
    grid: OccupancyGrid,
    frame: MapFrame,
    free_threshold: f64,
    outlines: Outlines,
}

impl FloorPlan {
    /// A map of cells with occupancies, as in ROS' `nav_msgs/OccupancyGrid`: percentages, of which
    /// those from 0 to `free_most` are free and greater ones occupied; what is no percentage (-1)
    /// is unknown. `origin` is `[x, y, yaw]`, as in [`crate`].
    pub fn from_occupancy(
        cells: &[i8],
        [width, height]: [u32; 2],
        resolution: f64,
        origin: [f64; 3],
        free_most: u8,
        unknown: UnknownCells,
    ) -> Result<Self, CellsError> {
        if !(resolution > 0.0 && resolution.is_finite()) {
            let expected = "a number of metres greater than 0";
            return Err(CellsError::Field { field: "resolution", expected, has: resolution });
        }
        if let Some(has) = origin.into_iter().find(|coordinate| !coordinate.is_finite()) {
            return Err(CellsError::Field { field: "origin", expected: "finite", has });
        }
        if free_most > 99 {
            let (expected, has) = ("a percentage from 0 to 99", f64::from(free_most));
            return Err(CellsError::Field { field: "free_most", expected, has });
        }
        let grid = OccupancyGrid::from_occupancy(cells, [width.into(), height.into()], free_most)?;
        Self::new(grid, resolution, origin, f64::from(free_most) / 100.0, unknown)
    }

    pub(crate) fn new(
        grid: OccupancyGrid,
        resolution: f64,
        origin: [f64; 3],
        free_threshold: f64,
        unknown: UnknownCells,
    ) -> Result<Self, CellsError> {
        let size = [grid.width(), grid.height()];
        let frame = MapFrame::new(resolution, origin, size)?;
        let solid = grid.solid(unknown == UnknownCells::Free);
        let cells = size[0] * size[1];
        if solid.len() == cells {
            return Err(CellsError::NothingFree { cells });
        }
        let shared = match frame.is_turned() {
            true => SharedVertices::Kept,
            false => SharedVertices::Dropped,
        };
        let outlines = outlines::trace(&solid, size, shared, MOST_CORNERS)
            .map_err(|has| CellsError::TooManyCorners { has, most: MOST_CORNERS })?;
        Ok(Self { grid, frame, free_threshold, outlines })
    }

    /// What the cells are.
    pub fn grid(&self) -> &OccupancyGrid {
        &self.grid
    }

    /// Where they are.
    pub fn frame(&self) -> &MapFrame {
        &self.frame
    }

    /// The greatest occupancy that is free, or the map's `free_thresh`, which is not.
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
