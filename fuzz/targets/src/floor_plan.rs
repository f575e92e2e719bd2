//! Floor plans in the form of the ROS map server.

use std::fs;

use floor_plan::{CellState, FloorPlan, UnknownCells};
use schemas::message::{Solid, Vector};
use tempfile::TempDir;

/// The first line of every YAML file here: nothing else is to be opened.
const IMAGE: &[u8] = b"image: map.pgm\n";

/// A map's YAML without its image's name, a zero byte, and its image.
pub fn floor_plan(bytes: &[u8]) {
    let zero = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    let (yaml, picture) = bytes.split_at(zero);
    if yaml.windows(5).any(|word| word == b"image") {
        return;
    }
    thread_local! {
        static FOLDER: TempDir = TempDir::new().expect("the system has room for files");
    }
    FOLDER.with(|folder| {
        let path = folder.path().join("map.yaml");
        fs::write(&path, [IMAGE, yaml].concat()).expect("the folder takes files");
        let picture = picture.get(1..).unwrap_or_default();
        fs::write(folder.path().join("map.pgm"), picture).expect("the folder takes files");
        for unknown in [UnknownCells::Occupied, UnknownCells::Free] {
            match floor_plan::read(&path, unknown) {
                Err(error) => assert!(!error.to_string().is_empty()),
                Ok(plan) => check(&plan),
            }
        }
    });
}

/// A map fills its bounds: free cells and solids have its area together.
fn check(plan: &FloorPlan) {
    let free_space = plan.free_space();
    let bounds = free_space.bounds.expect("a map has bounds");
    let (min, max) = (bounds.min.padded(), bounds.max.padded());
    let finite = |i: usize| min[i].is_finite() && max[i].is_finite() && min[i] < max[i];
    assert!(finite(0) && finite(1), "{bounds:?}");
    for solid in free_space.solids.iter().flatten() {
        let Solid::Polygon(vertices) = solid else { panic!("{solid:?} is not an outline") };
        assert!(vertices.len() >= 3, "{vertices:?}");
        for vertex in vertices.iter().map(Vector::padded) {
            let within = |i: usize| min[i] <= vertex[i] && vertex[i] <= max[i];
            assert!(within(0) && within(1), "{vertex:?} is not in {bounds:?}");
        }
    }
    let (width, height) = (plan.grid().width(), plan.grid().height());
    if width * height > 1 << 20 {
        return;
    }
    // In cells, which is exact.
    let twice: i64 = plan.outlines().iter().map(twice_area).sum();
    let state = |cell: usize| plan.grid().cell(cell % width, cell / width);
    let count = |of| (0..width * height).filter(|cell| state(*cell) == Some(of)).count() as i64;
    let occupied = count(CellState::Occupied);
    let either = [occupied, occupied + count(CellState::Unknown)];
    assert!(twice % 2 == 0 && either.contains(&(twice / 2)), "{twice} is twice one of {either:?}");
}

fn twice_area(outline: &[[u32; 2]]) -> i64 {
    let sides = outline.iter().zip(outline.iter().cycle().skip(1));
    let cross = |(a, b): (&[u32; 2], &[u32; 2])| {
        let [a, b] = [a, b].map(|corner| corner.map(i64::from));
        a[0] * b[1] - b[0] * a[1]
    };
    sides.map(cross).sum()
}
