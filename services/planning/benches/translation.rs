//! Parts of any shape among solids of any shape.

use std::f64::consts::TAU;

use divan::Bencher;
use planning::budget::Budget;
use planning::clearance::translating::Body;
use planning::free_space::walls::Walls;
use planning::geometry::polygon::Polygon;
use planning::geometry::{AxisBox, Direction, Sign, Vector};
use planning::translation::{Cavity, Demand, MovedPart};

fn main() {
    divan::main();
}

/// A polygon with so many vertices about `center`: on two circles in turn, which are the same for a
/// convex one.
fn star(center: [f64; 2], vertices: usize, radii: [f64; 2]) -> Polygon {
    let vertex = |at: usize| {
        let (sin, cos) = libm::sincos(TAU * at as f64 / vertices as f64 + 0.1);
        let radius = radii[at % 2];
        Vector::from([center[0] + radius * cos, center[1] + radius * sin])
    };
    Polygon::new((0..vertices).map(vertex).collect(), &Budget::default()).expect("simple")
}

/// Solids in a tray, and the way out of it for a part below all of them.
struct Tray {
    solids: Vec<Polygon>,
    /// Its inner width and its height.
    size: [f64; 2],
}

impl Tray {
    /// Rows of stars with twenty vertices each, every other row shifted by half their distance.
    fn of_stars(rows: usize, columns: usize) -> Self {
        let center = |row: usize, column: usize| {
            let shift = if row.is_multiple_of(2) { 0.0 } else { 1.5 };
            [3.0 * column as f64 + shift, 4.0 + 3.0 * row as f64]
        };
        let stars = (0..rows).flat_map(|row| (0..columns).map(move |column| center(row, column)));
        Self {
            solids: stars.map(|center| star(center, 20, [0.9, 0.5])).collect(),
            size: [3.0 * columns as f64 + 3.0, 5.0 + 3.0 * rows as f64],
        }
    }

    /// Four rough discs with 250 vertices each.
    fn of_rough_discs() -> Self {
        let centers = [[6.0, 6.0], [15.5, 6.0], [10.75, 14.5], [20.25, 14.5]];
        Self {
            solids: centers.into_iter().map(|center| star(center, 250, [4.0, 3.8])).collect(),
            size: [33.0, 20.0],
        }
    }

    fn walls(&self) -> (Walls<2>, AxisBox<2>) {
        let [width, height] = self.size;
        let right = width - 2.0;
        let space =
            |min: [f64; 2], max: [f64; 2]| AxisBox::new(min.into(), max.into()).expect("a box");
        let mut walls = Walls::default();
        self.solids.iter().for_each(|solid| walls.push_polygon(solid));
        for (min, max) in [
            ([-3.0, -1.0], [right + 1.0, 0.0]),
            ([-3.0, 0.0], [-2.0, height]),
            ([right, 0.0], [right + 1.0, height]),
        ] {
            walls.push_box(&space(min, max));
        }
        walls.index(&Budget::default()).expect("no limit");
        (walls, space([-3.0, -1.0], [right + 1.0, height]))
    }
}

fn plan(bencher: Bencher, tray: &Tray, part: &Polygon, wish: Demand<2>) {
    let (walls, bounds) = tray.walls();
    let exit = Direction { axis: 1, sign: Sign::Positive };
    let body = Body::from_polygon(part);
    bencher.bench(|| {
        let budget = Budget::default();
        let part = MovedPart::new(&body, &budget).expect("no limit");
        let cavity = Cavity { part: &part, walls: &walls, bounds, exit };
        cavity.plan(wish, &budget).expect("there is a way").len()
    });
}

const CONVEX: [f64; 2] = [0.6, 0.6];
const NOTCHED: [f64; 2] = [0.6, 0.45];

fn gap() -> Demand<2> {
    Demand::Gap([0.05, 0.05].into())
}

/// 1,000 vertices on 50 solids.
#[divan::bench(args = [20, 100])]
fn convex_part_among_small_solids(bencher: Bencher, vertices: usize) {
    let part = star([14.0, 1.0], vertices, CONVEX);
    plan(bencher, &Tray::of_stars(5, 10), &part, gap());
}

#[divan::bench(args = [20, 100])]
fn notched_part_among_small_solids(bencher: Bencher, vertices: usize) {
    let part = star([14.0, 1.0], vertices, NOTCHED);
    plan(bencher, &Tray::of_stars(5, 10), &part, gap());
}

/// 1,000 vertices on 4 solids.
#[divan::bench(args = [20, 100])]
fn convex_part_among_large_solids(bencher: Bencher, vertices: usize) {
    let part = star([10.6, 1.0], vertices, CONVEX);
    plan(bencher, &Tray::of_rough_discs(), &part, gap());
}

#[divan::bench(args = [20, 100])]
fn notched_part_among_large_solids(bencher: Bencher, vertices: usize) {
    let part = star([10.6, 1.0], vertices, NOTCHED);
    plan(bencher, &Tray::of_rough_discs(), &part, gap());
}

/// Ten columns of stars, up to 100,000 vertices.
#[divan::bench(args = [1_000, 10_000, 100_000], sample_count = 10)]
fn box_part(bencher: Bencher, vertices: usize) {
    let part = star([14.0, 1.0], 4, [0.5, 0.5]);
    plan(bencher, &Tray::of_stars(5, vertices / 100), &part, gap());
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn safest_of_a_notched_part_of_20_vertices_among_small_solids(bencher: Bencher) {
    plan(bencher, &Tray::of_stars(5, 10), &star([14.0, 1.0], 20, NOTCHED), Demand::Part(1.0));
}

#[divan::bench]
fn cutting_a_part_of_100_vertices(bencher: Bencher) {
    let part = star([0.0, 0.0], 100, NOTCHED);
    let body = Body::from_polygon(&part);
    bencher.bench(|| MovedPart::new(&body, &Budget::default()).expect("no limit"));
}
