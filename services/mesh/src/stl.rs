//! Triangles from STL files.

use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;

use crate::Unit;
use crate::error::MeshError;

/// Bytes of the longest file that is read; bounds the memory.
const MOST_BYTES: u64 = 64 << 20;

/// What a binary file has before its triangles, and for each of them.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// The bytes of a file.
pub(crate) fn load(path: &Path) -> Result<Vec<u8>, MeshError> {
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(MeshError::Read)?;
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(MeshError::Read)?;
    match bytes.len() as u64 {
        0..=MOST_BYTES => Ok(bytes),
        _ => Err(MeshError::TooLong { most: MOST_BYTES }),
    }
}

/// The corners of all triangles, metres.
pub(crate) fn triangles(mut bytes: Vec<u8>, unit: Unit) -> Result<Vec<[[f64; 3]; 3]>, MeshError> {
    tell_apart(&mut bytes);
    let mut bytes = Cursor::new(bytes);
    let triangles = stl_io::create_stl_reader(&mut bytes).map_err(MeshError::Format)?;
    let corner = |vertex: stl_io::Vertex| vertex.0.map(|number| metres(number, unit));
    triangles
        .map(|triangle| Ok(triangle.map_err(MeshError::Format)?.vertices.map(corner)))
        .collect()
}

/// The reader takes a file for text if it begins with `solid` and a blank. There are binary files that do,
/// and text files without a name.
fn tell_apart(bytes: &mut Vec<u8>) {
    let count = bytes.get(HEADER - 4..HEADER).and_then(|count| count.try_into().ok());
    let expected = count.map(|count| HEADER + TRIANGLE * u32::from_le_bytes(count) as usize);
    if expected == Some(bytes.len()) {
        bytes[0] = 0;
    } else if bytes.starts_with(b"solid") && bytes.get(5).is_some_and(u8::is_ascii_whitespace) {
        bytes.insert(5, b' ');
    }
}

/// A number in metres. It means the shortest decimal fraction that it is nearest to in 32 bits: 0.1, which is
/// another number in 64 bits; and 30.7 mm are 0.0307 m.
fn metres(number: f32, unit: Unit) -> f64 {
    let written = |digits: &str, exponent: i32| format!("{digits}e{exponent}").parse().ok();
    let text = format!("{number:e}");
    let parts = text
        .split_once('e')
        .and_then(|(digits, exponent)| Some((digits, exponent.parse::<i32>().ok()?)));
    let meant = parts.and_then(|(digits, exponent)| match unit {
        Unit::Metre => written(digits, exponent),
        Unit::Millimetre => written(digits, exponent - 3),
        Unit::Inch => written(digits, exponent).map(|inches: f64| inches * 0.0254),
    });
    // What is not finite has no exponent.
    meant.unwrap_or(f64::from(number))
}
