//! Meshes in STL.

use mesh::{Block, Unit};

/// The bytes of an STL file.
pub fn mesh(bytes: &[u8]) {
    match mesh::from_stl(bytes.to_vec(), Unit::Millimetre) {
        Err(error) => assert!(!error.to_string().is_empty()),
        Ok(blocks) => check(&blocks),
    }
}

/// Boxes have an inside, and none overlaps another.
fn check(blocks: &[Block]) {
    assert!(!blocks.is_empty());
    for (index, block) in blocks.iter().enumerate() {
        let ordered =
            |axis: usize| block.min[axis].is_finite() && block.min[axis] < block.max[axis];
        assert!((0..3).all(ordered), "{block:?}");
        let others = blocks[..index].iter().take(100);
        for other in others {
            let meets = |axis: usize| {
                block.min[axis].max(other.min[axis]) < block.max[axis].min(other.max[axis])
            };
            assert!(!(0..3).all(meets), "{block:?} overlaps {other:?}");
        }
    }
}
