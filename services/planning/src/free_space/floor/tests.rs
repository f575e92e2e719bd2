//! Floors of walls that cross, touch and overlap.

use proptest::prelude::*;

use super::Floor;
use crate::budget::Budget;
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::Vector;

fn walls(outlines: &[Vec<[f64; 2]>], turn: f64, far: f64) -> Walls<2> {
    let (sin, cos) = libm::sincos(turn);
    let place = |[x, y]: [f64; 2]| Vector::from([cos * x - sin * y + far, sin * x + cos * y - far]);
    let mut walls = Walls::default();
    for outline in outlines {
        for (index, from) in outline.iter().enumerate() {
            let to = outline[(index + 1) % outline.len()];
            walls.push(Wall { from: place(*from), to: place(to) });
        }
    }
    walls.index(&Budget::default()).unwrap();
    walls
}

fn rectangle([left, low]: [f64; 2], [right, high]: [f64; 2]) -> Vec<[f64; 2]> {
    vec![[left, low], [right, low], [right, high], [left, high]]
}

/// How many faces are reached from a point of the scene.
fn reached(outlines: &[Vec<[f64; 2]>], at: [f64; 2], turn: f64, far: f64) -> usize {
    let floor = Floor::new(&walls(outlines, turn, far), &Budget::default()).unwrap();
    let (sin, cos) = libm::sincos(turn);
    let [x, y] = at;
    let at = Vector::from([cos * x - sin * y + far, sin * x + cos * y - far]);
    floor.reachable(&at, &Budget::default()).unwrap().faces
}

/// Two blocks in the corners of a room, whose sides lie on those of the room, but for rounding.
#[test]
fn walls_that_all_but_coincide_are_one() {
    let bay = [
        rectangle([0.0, 0.0], [10.0, 5.0]),
        rectangle([0.0, 0.0], [4.65, 2.0]),
        rectangle([5.35, 0.0], [10.0, 2.0]),
    ];
    let expected = reached(&bay, [5.0, 3.0], 0.0, 0.0);
    for degrees in 1..90 {
        for far in [0.0, 1e3, 1e6] {
            let turn = f64::from(degrees).to_radians();
            let faces = reached(&bay, [5.0, 3.0], turn, far);
            assert!(faces.abs_diff(expected) <= 4, "{degrees} {far}: {faces} {expected}");
        }
    }
}

proptest! {
    /// Rectangles on a coarse grid share corners and parts of sides; turned and moved, they do so
    /// but for rounding. No floor fails, and none leaks.
    #[test]
    fn turned_grids_of_rectangles_make_a_floor(
        corners in prop::collection::vec(
            (prop::array::uniform2(0..7u8), prop::array::uniform2(1..4u8)), 1..12),
        turn in 0.0..6.3f64,
        far in prop_oneof![Just(0.0), Just(1e6)],
    ) {
        let mut outlines = vec![rectangle([-1.0, -1.0], [11.0, 11.0]), rectangle([-2.0, -2.0], [12.0, 12.0])];
        for ([x, y], [width, height]) in corners {
            let (x, y) = (f64::from(x), f64::from(y));
            outlines.push(rectangle([x, y], [x + f64::from(width), y + f64::from(height)]));
        }
        let floor = Floor::new(&walls(&outlines, turn, far), &Budget::default()).unwrap();
        let outside = reached(&outlines, [-1.5, -1.5], turn, far);
        // The ring between the two outer rectangles, whatever is inside.
        prop_assert!((8..=16).contains(&outside), "{outside} of {}", floor.triangles().count());
    }
}
