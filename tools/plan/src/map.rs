//! Floor plans: an occupancy grid in the ROS map server's form, a picture with its
//! YAML, as the free space of `drive` scenes.
//!
//! A cell is free where the map server would say so, and solid otherwise: what is
//! unknown is not free. Cells are squares of `resolution` metres with sides parallel to
//! the axes; `origin` is the lower left corner of the picture's lower left pixel, so the
//! picture's last row has the least y.
//!
//! | `mode` | a cell is free when |
//! |---|---|
//! | `trinary` (default), `scale` | its occupancy is less than `free_thresh`; in `scale`, where it is opaque as well |
//! | `raw` | its shade (of 255, whatever `negate` says) is a percentage less than `free_thresh` |
//!
//! Occupancy is `(255 - shade) / 255`, with `negate` `shade / 255`, where shade is the mean
//! of red, green and blue, and in `trinary` of alpha as well where there is one. Pictures
//! with 16 bits are not rounded to 8 first.

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
use frame::Frame;
use grid::Grid;

/// The greatest number of cells that is read, 8192 x 8192: bounds the memory while reading to
/// 0.6 GB for the worst kind of picture (16 bits, with alpha), 0.13 GB for grey ones.
pub const MOST_CELLS: u64 = 1 << 26;

/// The greatest number of boxes that a map's solids may need. Walls of a whole building
/// need thousands; a map that needs more than this is noise.
pub const MOST_BOXES: usize = 1 << 20;

/// Why a map can't be used.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum MapError {
    #[error("can't read {}: {cause}", path.display())]
    Read { path: PathBuf, cause: io::Error },
    #[error("{}: not YAML: {cause}", path.display())]
    NotYaml { path: PathBuf, cause: String },
    #[error("{}: {field} is missing", path.display())]
    Missing { path: PathBuf, field: &'static str },
    #[error("{}: {field} must be {expected}, not {has}", path.display())]
    Field { path: PathBuf, field: &'static str, expected: &'static str, has: String },
    #[error(
        "{}: free_thresh is {free}, greater than occupied_thresh, {occupied}",
        path.display()
    )]
    Thresholds { path: PathBuf, free: f64, occupied: f64 },
    #[error(
        "{}: origin: the map is turned by a yaw of {yaw} rad; the sides of free space are \
         parallel to the axes, so the yaw must be 0",
        path.display()
    )]
    Turned { path: PathBuf, yaw: f64 },
    #[error(
        "{}: origin: cells of {resolution} m can't be told apart as far out as {farthest} m",
        path.display()
    )]
    TooFarOut { path: PathBuf, resolution: f64, farthest: f64 },
    #[error("{}: not a PNG or PGM picture that can be read: {cause}", path.display())]
    Picture { path: PathBuf, cause: image::ImageError },
    #[error("{}: the picture has {width} x {height} cells", path.display())]
    NoCells { path: PathBuf, width: u32, height: u32 },
    #[error(
        "{}: the picture has {width} x {height} = {has} cells, at most {most} are read",
        path.display()
    )]
    TooManyCells { path: PathBuf, width: u32, height: u32, has: u64, most: u64 },
    #[error(
        "{}: the map's solids need {has} boxes, at most {most} are sent; is it noise?",
        path.display()
    )]
    TooManyBoxes { path: PathBuf, has: usize, most: usize },
    #[error(
        "{}: none of the picture's {cells} cells is free; free_thresh is {free}",
        path.display()
    )]
    NothingFree { path: PathBuf, cells: usize, free: f64 },
}

/// Reads a map's YAML and the picture it names (relative to the YAML).
///
/// The solids are boxes that don't overlap and together are exactly the cells that aren't
/// free, the bounds are the picture's. The same index of a cell's side always gives the
/// same coordinate, `origin + index * resolution` rounded once, so boxes that touch
/// do so exactly.
pub fn read(path: &Path) -> Result<FreeSpace, MapError> {
    let text = fs::read_to_string(path)
        .map_err(|cause| MapError::Read { path: path.to_owned(), cause })?;
    let description = Description::read(path, &text)?;
    let grid = Grid::read(path, &description)?;
    let (width, height) = (grid.width, grid.height);
    let frame = Frame::new(path, &description, width, height)?;
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
    let bounds = frame.place(&boxes::Cells { x: [0, width], y: [0, height] });
    Ok(FreeSpace { channels: None, in_order: false, solids: Some(solids), bounds: Some(bounds) })
}
