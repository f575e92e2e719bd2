//! Meshes as files, and what is inside them.

use std::collections::BTreeSet;
use std::io::Write;

use mesh::{Block, MeshError, Unit, blocks, read};
use proptest::prelude::*;

type Corners = [[f64; 3]; 3];
type Cell = [i32; 3];

/// The two triangles of a box's side across `axis`, cut along either diagonal.
fn side(block: &Block, axis: usize, upper: bool, flipped: bool) -> [Corners; 2] {
    let at = 4 * axis + 2 * usize::from(upper);
    let [[a, b, c], [_, _, d]] = [block.surface()[at], block.surface()[at + 1]];
    if flipped { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] }
}

fn block(min: [f64; 3], max: [f64; 3]) -> Block {
    Block { min, max }
}

fn volume(blocks: &[Block]) -> f64 {
    let volume =
        |block: &Block| (0..3).map(|axis| block.max[axis] - block.min[axis]).product::<f64>();
    blocks.iter().map(volume).sum()
}

#[test]
fn a_box_is_one_box() {
    let whole = block([-1.0, 0.0, 2.0], [1.5, 0.25, 7.0]);
    assert_eq!(blocks(&whole.surface()).unwrap(), [whole]);
}

#[test]
fn shells_that_overlap_are_one_union() {
    let [one, other] = [block([0.0; 3], [2.0; 3]), block([1.0; 3], [3.0; 3])];
    let union = blocks(&[one.surface(), other.surface()].concat()).unwrap();
    assert_eq!(volume(&union), 8.0 + 8.0 - 1.0);
}

#[test]
fn a_shell_turned_inwards_is_a_cavity() {
    let hole = block([1.0; 3], [2.0; 3]).surface().into_iter().map(|[a, b, c]| [a, c, b]);
    let hollow: Vec<_> = block([0.0; 3], [3.0; 3]).surface().into_iter().chain(hole).collect();
    assert_eq!(volume(&blocks(&hollow).unwrap()), 26.0);
}

#[test]
fn what_is_no_union_of_boxes_is_refused() {
    let whole = block([0.0; 3], [1.0, 2.0, 3.0]).surface();
    let open = blocks(&whole[1..]);
    assert!(matches!(open, Err(MeshError::Open { .. })), "{open:?}");
    let mut turned = whole;
    turned[4].swap(0, 1);
    let turned = blocks(&turned);
    assert!(matches!(turned, Err(MeshError::Open { .. })), "{turned:?}");
    let mut slanted = whole;
    slanted[3][0][0] += 0.5;
    slanted[3][0][1] += 0.25;
    slanted[3][0][2] += 0.25;
    let slanted = blocks(&slanted);
    assert!(matches!(slanted, Err(MeshError::Slanted { triangle: 3, .. })), "{slanted:?}");
    assert!(matches!(blocks(&[]), Err(MeshError::Empty)));
    // A prism on a triangle whose slanted side is missing.
    let prism = [
        [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
        [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
    ];
    let prism = [&prism[..], &side(&block([0.0; 3], [1.0; 3]), 0, false, false)].concat();
    assert!(matches!(blocks(&prism), Err(MeshError::Open { .. })));
    let endless = [[[0.0, 0.0, f64::NAN]; 3]];
    assert!(matches!(blocks(&endless), Err(MeshError::NonFinite { triangle: 0 })));
}

#[test]
fn too_many_cells_are_refused() {
    let steps: Vec<_> =
        (0..300).map(f64::from).flat_map(|at| block([at; 3], [at + 0.5; 3]).surface()).collect();
    let refused = blocks(&steps).unwrap_err();
    assert!(matches!(refused, MeshError::TooFine { counts: [600, 600, 600], .. }), "{refused}");
}

fn write(triangles: &[Corners], name: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let vertex = |corner: [f64; 3]| stl_io::Vertex::new(corner.map(|number| number as f32));
    let normal = stl_io::Normal::new([0.0; 3]);
    let triangle = |corners: &Corners| stl_io::Triangle { normal, vertices: corners.map(vertex) };
    let triangles: Vec<_> = triangles.iter().map(triangle).collect();
    let mut file = std::fs::File::create(&path).unwrap();
    if name.starts_with("text") {
        writeln!(file, "solid").unwrap();
        for triangle in &triangles {
            writeln!(file, " facet normal 0 0 0\n  outer loop").unwrap();
            for stl_io::Vector([x, y, z]) in triangle.vertices {
                writeln!(file, "   vertex {x} {y} {z}").unwrap();
            }
            writeln!(file, "  endloop\n endfacet").unwrap();
        }
        writeln!(file, "endsolid").unwrap();
    } else {
        stl_io::write_stl(&mut file, triangles.iter()).unwrap();
    }
    (folder, path)
}

/// 0.1 is not 0.1 in 32 bits; the number meant is.
#[test]
fn files_mean_the_decimal_numbers_that_were_written() {
    let drawn = block([0.0; 3], [12.5, 0.1, 30.7]);
    for name in ["text.stl", "binary.stl"] {
        let (_folder, path) = write(&drawn.surface(), name);
        assert_eq!(read(&path, Unit::Metre).unwrap(), [drawn], "{name}");
        let millimetres = block([0.0; 3], [0.0125, 0.0001, 0.0307]);
        assert_eq!(read(&path, Unit::Millimetre).unwrap(), [millimetres], "{name}");
    }
}

#[test]
fn a_binary_file_may_begin_as_text_does() {
    let drawn = block([0.0; 3], [1.0; 3]);
    let (_folder, path) = write(&drawn.surface(), "binary.stl");
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[..6].copy_from_slice(b"solid ");
    std::fs::write(&path, &bytes).unwrap();
    assert_eq!(read(&path, Unit::Metre).unwrap(), [drawn]);
    // Cut short, it is neither.
    std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    assert!(matches!(read(&path, Unit::Metre), Err(MeshError::Format(_))));
    for bytes in [&b""[..], b"solid", b"solid x\n facet", b"\0\xff"] {
        std::fs::write(&path, bytes).unwrap();
        assert!(matches!(read(&path, Unit::Metre), Err(MeshError::Format(_))), "{bytes:?}");
    }
    let missing = path.with_extension("gone");
    assert!(matches!(read(&missing, Unit::Metre), Err(MeshError::Read(_))));
}

proptest! {
    /// Of any set of unit cells, the boxes are exactly those cells, whatever diagonals its faces have.
    #[test]
    fn boxes_fill_the_inside(
        cells in prop::collection::btree_set(prop::array::uniform3(0..5_i32), 1..40),
        flips in any::<u64>(),
    ) {
        let at = |cell: &Cell| block(cell.map(f64::from), cell.map(|at| f64::from(at + 1)));
        let mut triangles = Vec::new();
        for cell in &cells {
            for (axis, upper) in [0, 1, 2].into_iter().flat_map(|axis| [(axis, false), (axis, true)]) {
                let mut beyond = *cell;
                beyond[axis] += if upper { 1 } else { -1 };
                if !cells.contains(&beyond) {
                    let flipped = flips >> (triangles.len() % 64) & 1 == 1;
                    triangles.extend(side(&at(cell), axis, upper, flipped));
                }
            }
        }
        let found = blocks(&triangles).unwrap();
        prop_assert_eq!(volume(&found), cells.len() as f64);
        let mut covered = BTreeSet::new();
        for block in &found {
            let ends = [0, 1, 2].map(|axis| (block.min[axis] as i32, block.max[axis] as i32));
            for x in ends[0].0..ends[0].1 {
                for y in ends[1].0..ends[1].1 {
                    covered.extend((ends[2].0..ends[2].1).map(|z| [x, y, z]));
                }
            }
        }
        prop_assert_eq!(&covered, &cells);
        // With any one triangle less, it is open.
        let missing = flips as usize % triangles.len();
        triangles.remove(missing);
        let open = blocks(&triangles);
        prop_assert!(matches!(open, Err(MeshError::Open { .. })), "{:?}", open);
    }
}
