//! Reading a floor plan of 4000 x 4000 cells (200 m x 200 m at 5 cm), from the files to
//! outlines: as an architect draws it, and as a robot's scans do, with ragged walls.
//! `examples/outline.rs` measures any map.

use std::fs;
use std::path::PathBuf;

use divan::Bencher;
use floor_plan::UnknownCells;
use tempfile::TempDir;

const SIDE: usize = 4000;

fn main() {
    for ragged in [false, true] {
        let (_folder, path) = floor(ragged);
        let plan = floor_plan::read(&path, UnknownCells::Occupied).expect("a map");
        let (count, vertices) = (plan.outlines().count(), plan.outlines().vertices());
        let name = if ragged { "ragged" } else { "drawn" };
        println!("{name}: {count} outlines with {vertices} vertices");
    }
    divan::main();
}

/// 30 x 30 rooms of 6 m with walls of 20 cm and doors of 1 m on all sides, every third
/// with a pillar, in the middle of nothing known.
fn floor(ragged: bool) -> (TempDir, PathBuf) {
    const ROOM: usize = 120;
    const ROOMS: usize = 30;
    let margin = (SIDE - ROOM * ROOMS) / 2;
    let mut state = 1u64;
    let mut thicker = || {
        // A coin (Knuth's MMIX generator): ragged walls are a cell thicker here and there.
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        usize::from(ragged && state >> 63 == 1)
    };
    let mut picture = format!("P5\n{SIDE} {SIDE}\n255\n").into_bytes();
    for y in 0..SIDE {
        for x in 0..SIDE {
            let within = |c: usize| (margin..SIDE - margin).contains(&c);
            let (u, v) = (x.wrapping_sub(margin), y.wrapping_sub(margin));
            let (room_x, room_y, u, v) = (u / ROOM, v / ROOM, u % ROOM, v % ROOM);
            let door = |along: usize| (50..70).contains(&along);
            let wall = 4 + thicker();
            let pillar =
                (room_x + room_y) % 3 == 0 && (80..90).contains(&u) && (30..40).contains(&v);
            picture.push(match () {
                () if !within(x) || !within(y) => 205,
                () if (u < wall && !door(v)) || (v < wall && !door(u)) || pillar => 0,
                () => 254,
            });
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("floor.yaml");
    fs::write(folder.path().join("floor.pgm"), picture).expect("room for a picture");
    let yaml = "image: floor.pgm\nresolution: 0.05\norigin: [-100, -100, 0]\nnegate: 0\n\
                occupied_thresh: 0.65\nfree_thresh: 0.196\n";
    fs::write(&path, yaml).expect("room for a text");
    (folder, path)
}

#[divan::bench(args = [false, true])]
fn read(bencher: Bencher, ragged: bool) {
    let (_folder, path) = floor(ragged);
    let read = || floor_plan::read(&path, UnknownCells::Occupied).expect("a map");
    bencher.bench_local(read);
}
