//! The map that comes with the project, `recordings/scenes/office.yaml`: how it is drawn, and
//! what it becomes.

use std::fs;
use std::path::{Path, PathBuf};

use floor_plan::{CellState, FloorPlan, UnknownCells};
use schemas::message::AxisBox;

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../recordings/scenes")
}

/// An office floor, 20 m x 14 m in cells of 0.1 m, in the map server's shades: a corridor
/// of two corners, 3.2 m wide, and four rooms with doors of 1.6 m, a pillar in one of them.
///
/// ```text
///   +-------------------+----------------+-------+
///   | north west        | north east  #  |       |
///   +----     ----------+------    ------+       |
///   |                                            |
///   |       +-----     -----+-----    -----------+
///   |       | south west    | south east         |
///   +-------+---------------+--------------------+
/// ```
fn draw() -> Vec<u8> {
    const WIDTH: usize = 200;
    const HEIGHT: usize = 140;
    const UNKNOWN: u8 = 205;
    const WALL: u8 = 0;
    const FREE: u8 = 254;
    // From the lower left corner of the map, in cells: x, then y.
    let rectangles = [
        (UNKNOWN, [0, 200], [0, 140]),
        // The outer walls with all that is within, then what is not wall.
        (WALL, [5, 195], [5, 135]),
        (FREE, [7, 39], [7, 86]),      // corridor, west
        (FREE, [7, 193], [54, 86]),    // corridor, from west to east
        (FREE, [161, 193], [54, 133]), // corridor, east
        (FREE, [7, 79], [88, 133]),    // room, north west
        (FREE, [46, 62], [86, 88]),    // and its door
        (FREE, [81, 159], [88, 133]),  // room, north east
        (FREE, [110, 126], [86, 88]),
        (FREE, [41, 100], [7, 52]), // room, south west
        (FREE, [70, 86], [52, 54]),
        (FREE, [102, 193], [7, 52]), // room, south east
        (FREE, [130, 146], [52, 54]),
        (WALL, [140, 146], [110, 116]), // pillar, north east
    ];
    let mut cells = vec![0; WIDTH * HEIGHT];
    for (shade, [left, right], [low, high]) in rectangles {
        // Pictures begin at the top.
        for row in cells.chunks_exact_mut(WIDTH).rev().take(high).skip(low) {
            row[left..right].fill(shade);
        }
    }
    let mut picture = format!("P5\n{WIDTH} {HEIGHT}\n255\n").into_bytes();
    picture.append(&mut cells);
    picture
}

#[test]
fn the_picture_is_what_is_drawn_here() {
    let shipped = fs::read(scenes().join("office.pgm")).unwrap_or_default();
    if shipped != draw() {
        let drawn = Path::new(env!("CARGO_TARGET_TMPDIR")).join("office.pgm");
        fs::write(&drawn, draw()).unwrap();
        panic!("recordings/scenes/office.pgm is out of date; it should be {}", drawn.display());
    }
}

fn office() -> FloorPlan {
    floor_plan::read(&scenes().join("office.yaml"), UnknownCells::Occupied).unwrap()
}

#[test]
fn solids_are_where_walls_are_drawn_and_nothing_is_known() {
    let office = office();
    let bounds = office.free_space().bounds.unwrap();
    assert_eq!(bounds, AxisBox { min: [-1.0, -2.0].into(), max: [19.0, 12.0].into() });
    let state = |x: f64, y: f64| {
        let [x, y] = office.frame().locate([x - 1.0, y - 2.0]);
        office.grid().cell(x as usize, y as usize).unwrap()
    };
    assert_eq!(state(0.25, 7.05), CellState::Unknown);
    for (x, y, what) in [(0.65, 7.05, "wall"), (14.25, 11.25, "pillar")] {
        assert_eq!(state(x, y), CellState::Occupied, "{what}");
    }
    for (x, y, what) in [(2.25, 1.05, "corridor"), (5.45, 8.75, "door"), (13.05, 12.05, "room")] {
        assert_eq!(state(x, y), CellState::Free, "{what}");
    }
    // South and north are not mixed up: here is a door above, none below.
    assert_eq!(state(5.45, 5.25), CellState::Occupied);
}

#[test]
fn the_floor_is_few_vertices() {
    let office = office();
    // The pillar, and the ring of walls in two: 48 corners, and 4 more where it is cut.
    assert_eq!((office.outlines().count(), office.outlines().vertices()), (3, 52));
}
