//! Floor plans as the free space of `drive` scenes: occupancy grids in the ROS map server's
//! format, a picture and its YAML.
//!
//! A cell is free if the map server would call it free, and solid otherwise: unknown is not
//! free. Cells are squares of `resolution` metres with sides parallel to the axes; `origin` is
//! the lower left corner of the picture's lower left pixel, so the picture's last row has the
//! least y.
//!
//! | `mode` | a cell is free when |
//! |---|---|
//! | `trinary` (default), `scale` | its occupancy is less than `free_thresh`; in `scale`, only if it is opaque |
//! | `raw` | its shade (of 255, whatever `negate` says) is a percentage less than `free_thresh` |
//!
//! Occupancy is `(255 - shade) / 255`, with `negate` `shade / 255`, where shade is the mean
//! of red, green and blue, in `trinary` also of alpha, if any. Pictures with 16 bits are not
//! rounded to 8 first.

use std::path::{Path, PathBuf};
use std::{fs, io};

use schemas::message::FreeSpace;

mod boxes;
mod description;
mod frame;
mod grid;
mod scene;

pub use scene::read_scene;

use description::Description;
use frame::MapFrame;
use grid::OccupancyGrid;

/// The most cells of a map, 8192 x 8192. This bounds memory while reading to 0.6 GB for the
/// largest kind of picture (16 bits, with alpha), 0.13 GB for grey ones.
pub const MOST_CELLS: u64 = 1 << 26;

/// The most boxes of a map's solids. The walls of a whole building need thousands; a map that
/// needs more than this is noise.
pub const MOST_BOXES: usize = 1 << 20;

/// Why a map can't be used.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum MapError {
    #[error("can't read {}: {cause}", path.display())]
    Read { path: PathBuf, cause: io::Error },
    #[error("{}: invalid YAML: {cause}", path.display())]
    NotYaml { path: PathBuf, cause: String },
    #[error("{}: {field} is missing", path.display())]
    Missing { path: PathBuf, field: &'static str },
    #[error("{}: {field} must be {expected}, not {has}", path.display())]
    Field { path: PathBuf, field: &'static str, expected: &'static str, has: String },
    #[error(
        "{}: free_thresh {free} must not exceed occupied_thresh {occupied}",
        path.display()
    )]
    Thresholds { path: PathBuf, free: f64, occupied: f64 },
    #[error(
        "{}: origin has a yaw of {yaw} rad, but it must be 0: cells must be parallel to the axes",
        path.display()
    )]
    Turned { path: PathBuf, yaw: f64 },
    #[error(
        "{}: cells of {resolution} m are too small at the coordinate {farthest} m: their corners \
         round to the same number; move the origin closer to 0",
        path.display()
    )]
    TooFarOut { path: PathBuf, resolution: f64, farthest: f64 },
    #[error("{}: not a readable PNG or PGM picture: {cause}", path.display())]
    Picture { path: PathBuf, cause: image::ImageError },
    #[error("{}: the picture has {width} x {height} cells, but needs at least 1 x 1", path.display())]
    NoCells { path: PathBuf, width: u32, height: u32 },
    #[error(
        "{}: the picture has {width} x {height} = {has} cells, but at most {most} are allowed",
        path.display()
    )]
    TooManyCells { path: PathBuf, width: u32, height: u32, has: u64, most: u64 },
    #[error(
        "{}: the map's solids need {has} boxes, but at most {most} are allowed; is the map noise?",
        path.display()
    )]
    TooManyBoxes { path: PathBuf, has: usize, most: usize },
    #[error(
        "{}: none of the picture's {cells} cells is free: no occupancy is less than free_thresh, \
         {free}",
        path.display()
    )]
    NothingFree { path: PathBuf, cells: usize, free: f64 },
}

/// Reads a map's YAML and the picture it names (relative to the YAML).
///
/// The solids are boxes that don't overlap and together are exactly the cells that aren't
/// free; the bounds are the picture's. A cell's side at an index always has the same
/// coordinate, `origin + index * resolution` rounded once, so boxes that touch do so exactly.
pub fn read(path: &Path) -> Result<FreeSpace, MapError> {
    let text = fs::read_to_string(path)
        .map_err(|cause| MapError::Read { path: path.to_owned(), cause })?;
    let description = Description::read(path, &text)?;
    let grid = OccupancyGrid::read(path, &description)?;
    let (width, height) = (grid.width, grid.height);
    let frame = MapFrame::new(path, &description, width, height)?;
    let mut boxes = boxes::Boxes::of(grid);
    let mut solids = Vec::new();
    solids.extend(boxes.by_ref().take(MOST_BOXES).map(|cells| frame.solid(&cells)));
    match boxes.count() {
        0 => {}
        more => {
            let (has, most) = (solids.len() + more, MOST_BOXES);
            return Err(MapError::TooManyBoxes { path: path.to_owned(), has, most });
        }
    }
    let bounds = frame.place(&boxes::CellRange { x: [0, width], y: [0, height] });
    Ok(FreeSpace { solids: Some(solids), bounds: Some(bounds), ..FreeSpace::default() })
}
