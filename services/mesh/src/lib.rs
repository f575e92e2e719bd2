//! Rectilinear parts from STL files, as unions of boxes.
//!
//! A mesh whose triangles are all parallel to the axes bounds a union of boxes. No voxels are made: the
//! coordinates of its vertices cut space into cells, each of which is inside or outside as a whole, and
//! cells inside are put together to boxes. So the union is the mesh's inside exactly.

mod cells;
mod error;
mod faces;
mod stl;

use std::path::Path;
use std::str::FromStr;

pub use error::MeshError;

/// A box: its least and greatest corner, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// The corner where all coordinates are least.
    pub min: [f64; 3],
    /// The corner where all coordinates are greatest.
    pub max: [f64; 3],
}

impl Block {
    /// The triangles of its sides, two for each, as [`blocks`] reads them.
    pub fn surface(&self) -> [[[f64; 3]; 3]; 12] {
        let mut triangles = [[[0.0; 3]; 3]; 12];
        let sides = (0..3).flat_map(|axis| [(axis, false), (axis, true)]);
        for ((axis, is_upper), pair) in sides.zip(triangles.chunks_exact_mut(2)) {
            let [u, v] = faces::beside(axis);
            let corner = |u_end: &[f64; 3], v_end: &[f64; 3]| {
                let mut corner = if is_upper { self.max } else { self.min };
                (corner[u], corner[v]) = (u_end[u], v_end[v]);
                corner
            };
            let (min, max) = (&self.min, &self.max);
            let [a, c] = [corner(min, min), corner(max, max)];
            let [b, d] = [corner(max, min), corner(min, max)];
            let [b, d] = if is_upper { [b, d] } else { [d, b] };
            pair.copy_from_slice(&[[a, b, c], [a, c, d]]);
        }
        triangles
    }
}

/// What a file's numbers are; STL does not say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// Metres.
    #[default]
    Metre,
    /// Millimetres, as most CAD programs write.
    Millimetre,
    /// Inches.
    Inch,
}

impl FromStr for Unit {
    type Err = MeshError;

    fn from_str(text: &str) -> Result<Self, MeshError> {
        match text {
            "m" => Ok(Self::Metre),
            "mm" => Ok(Self::Millimetre),
            "in" => Ok(Self::Inch),
            _ => Err(MeshError::Unit { unit: text.to_owned() }),
        }
    }
}

/// Reads an STL file ([`from_stl`]).
///
/// # Errors
///
/// If the file can't be read, or as [`from_stl`].
pub fn read(path: &Path, unit: Unit) -> Result<Vec<Block>, MeshError> {
    from_stl(stl::load(path)?, unit)
}

/// The boxes inside a mesh in STL, text or binary. They don't overlap, and are the same for the same inside,
/// however its faces are cut into triangles, as long as the vertices' coordinates are.
///
/// # Errors
///
/// If the bytes are no STL, or as [`blocks`].
pub fn from_stl(bytes: Vec<u8>, unit: Unit) -> Result<Vec<Block>, MeshError> {
    blocks(&stl::triangles(bytes, unit)?)
}

/// The boxes inside a closed mesh. A triangle's corners, seen from outside, go round against the clock.
///
/// # Errors
///
/// If the mesh is not closed, or not parallel to the axes, or cuts space into too many cells.
pub fn blocks(triangles: &[[[f64; 3]; 3]]) -> Result<Vec<Block>, MeshError> {
    let faces = faces::sort(triangles)?;
    cells::inside(&faces)
}
