//! Why a mesh is no union of boxes.

use std::io;

/// Why a mesh is no union of boxes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The file can't be read.
    #[error("can't be read: {0}")]
    Read(#[source] io::Error),
    /// The file is too long.
    #[error("longer than {most} bytes, the most for a mesh")]
    TooLong {
        /// The most bytes.
        most: u64,
    },
    /// The bytes are no STL.
    #[error("no STL: {0}")]
    Format(#[source] io::Error),
    /// No such unit.
    #[error("unit must be \"m\", \"mm\" or \"in\", not {unit:?}")]
    Unit {
        /// What stands there.
        unit: String,
    },
    /// A vertex is not finite.
    #[error("triangle {triangle} has a non-finite vertex")]
    NonFinite {
        /// Which, from 0.
        triangle: usize,
    },
    /// A face is not parallel to the axes.
    #[error(
        "triangle {triangle} is not parallel to the axes (it lies between {least:?} and {greatest:?}): \
         only rectilinear meshes are unions of boxes"
    )]
    Slanted {
        /// Which, from 0.
        triangle: usize,
        /// Its least coordinates, metres.
        least: [f64; 3],
        /// Its greatest.
        greatest: [f64; 3],
    },
    /// There is a hole, or a face that is turned over.
    #[error(
        "the mesh is not closed near {near:?}: a face is missing there, or faces the wrong way"
    )]
    Open {
        /// About where, metres.
        near: [f64; 3],
    },
    /// Nothing is inside.
    #[error("the mesh has no inside")]
    Empty,
    /// The vertices cut space too finely.
    #[error(
        "the mesh's {} x {} x {} different coordinates make more than {most} cells",
        counts[0], counts[1], counts[2]
    )]
    TooFine {
        /// Different coordinates along each axis.
        counts: [usize; 3],
        /// The most cells.
        most: usize,
    },
}
