//! Why a map can't be used.

#[cfg(feature = "pictures")]
use std::{io, path::PathBuf};

/// Why a picture with its YAML can't be used.
#[cfg(feature = "pictures")]
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
    #[error("{}: not a readable PNG, PGM or BMP picture: {cause}", path.display())]
    Picture { path: PathBuf, cause: image::ImageError },
    #[error(
        "{}: none of the picture's {cells} cells is free: no occupancy is less than free_thresh, \
         {free}",
        path.display()
    )]
    NothingFree { path: PathBuf, cells: usize, free: f64 },
    #[error("{}: {cause}", path.display())]
    Grid { path: PathBuf, cause: CellsError },
}

/// Why cells are no map.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum CellsError {
    #[error("the map has {width} x {height} cells, but needs at least 1 x 1")]
    NoCells { width: u64, height: u64 },
    #[error("the map has {width} x {height} = {has} cells, but at most {most} are allowed")]
    TooManyCells { width: u64, height: u64, has: u64, most: u64 },
    #[error("there are {has} cells, but {width} x {height} = {needs} are needed")]
    CellCount { width: u64, height: u64, has: usize, needs: u64 },
    #[error("{field} is {has}, must be {expected}")]
    Field { field: &'static str, expected: &'static str, has: f64 },
    #[error(
        "cells of {resolution} m are too small at the coordinate {farthest} m: their corners \
         round to the same number; move the origin closer to 0"
    )]
    TooFarOut { resolution: f64, farthest: f64 },
    #[error("the walls have {has} corners, but at most {most} are allowed; is the map noise?")]
    TooManyCorners { has: usize, most: usize },
    #[error("none of the map's {cells} cells is free")]
    NothingFree { cells: usize },
}
