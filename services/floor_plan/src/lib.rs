//! Floor plans as free space: occupancy grids in the ROS map server's format, a picture and
//! its YAML.
//!
//! A cell is a square of `resolution` metres. `origin` is `[x, y, yaw]`: the lower left corner
//! of the picture's lower left pixel, about which the picture is turned counter-clockwise by
//! yaw (radians). Within 1e-9 of a multiple of a quarter turn, yaw is that multiple.
//!
//! Each cell is free, occupied or unknown, as the map server's `loadMapFromFile` would have it:
//!
//! | `mode` | free | unknown |
//! |---|---|---|
//! | `trinary` (default) | occupancy less than `free_thresh` | from `free_thresh` to `occupied_thresh` |
//! | `scale` | the same, and opaque | not opaque |
//! | `raw` | shade (of 255) less than `free_thresh` percent | shade over 100 |
//!
//! All others are occupied; so are shades between the thresholds in `scale` and `raw`, which
//! stand for a chance of being occupied. Occupancy is `(255 - shade) / 255`, with `negate`
//! `shade / 255`; `raw` disregards `negate`. Shade is the mean of red, green and blue, in
//! `trinary` also of alpha, if any. Pictures with 16 bits are not rounded to 8 first.
//!
//! [`FloorPlan::from_occupancy`] takes cells with occupancies instead of a picture; without the
//! feature `pictures` there is nothing else.
//!
//! Unknown cells count as occupied unless [`UnknownCells::Free`] says otherwise.

mod border;
mod cells;
#[cfg(feature = "pictures")]
mod description;
mod error;
mod frame;
mod grid;
mod outlines;
#[cfg(feature = "pictures")]
mod picture;
mod plan;
#[cfg(feature = "pictures")]
mod read;

pub use error::CellsError;
#[cfg(feature = "pictures")]
pub use error::MapError;
pub use frame::MapFrame;
pub use grid::{CellState, OccupancyGrid, UnknownCells};
pub use outlines::Outlines;
pub use plan::FloorPlan;
#[cfg(feature = "pictures")]
pub use read::read;

/// The most cells of a map, 10,000 x 10,000. Reading a grey picture takes about a byte a cell,
/// other pictures up to 8.
pub const MOST_CELLS: u64 = 100_000_000;

/// The most corners of a map's walls. A whole building has tens of thousands.
pub const MOST_CORNERS: usize = 1 << 22;
