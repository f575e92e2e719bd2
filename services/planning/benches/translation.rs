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

/// Fifty stars of twenty vertices each in a tray; the part below all of them.
fn scene(part: &Polygon) -> (Walls<2>, MovedPart, AxisBox<2>) {
    let budget = Budget::default();
    let mut walls = Walls::default();
    for row in 0..5 {
        for column in 0..10 {
            let shift = if row % 2 == 0 { 0.0 } else { 1.5 };
            let center = [3.0 * f64::from(column) + shift, 4.0 + 3.0 * f64::from(row)];
            walls.push_polygon(&star(center, 20, [0.9, 0.5]));
        }
    }
    let space = |min: [f64; 2], max: [f64; 2]| AxisBox::new(min.into(), max.into()).expect("a box");
    for side in
        [([-3.0, -1.0], [32.0, 0.0]), ([-3.0, 0.0], [-2.0, 20.0]), ([31.0, 0.0], [32.0, 20.0])]
    {
        walls.push_box(&space(side.0, side.1));
    }
    walls.index(&budget).expect("no limit");
    let part = MovedPart::new(&Body::from_polygon(part), &budget).expect("no limit");
    (walls, part, space([-3.0, -1.0], [32.0, 20.0]))
}

fn plan(bencher: Bencher, part: &Polygon, wish: Demand<2>) {
    let (walls, part, bounds) = scene(part);
    let exit = Direction { axis: 1, sign: Sign::Positive };
    let cavity = Cavity { part: &part, walls: &walls, bounds, exit };
    bencher.bench(|| cavity.plan(wish, &Budget::default()).expect("there is a way").len());
}

const CONVEX: [f64; 2] = [0.6, 0.6];
const NOTCHED: [f64; 2] = [0.6, 0.45];

#[divan::bench(sample_count = 5, sample_size = 1)]
fn convex_part_of_100_vertices_among_1000(bencher: Bencher) {
    plan(bencher, &star([14.0, 1.0], 100, CONVEX), Demand::Gap([0.05, 0.05].into()));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn notched_part_of_100_vertices_among_1000(bencher: Bencher) {
    plan(bencher, &star([14.0, 1.0], 100, NOTCHED), Demand::Gap([0.05, 0.05].into()));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn notched_part_of_20_vertices_among_1000(bencher: Bencher) {
    plan(bencher, &star([14.0, 1.0], 20, NOTCHED), Demand::Gap([0.05, 0.05].into()));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn safest_of_a_part_of_20_vertices_among_1000(bencher: Bencher) {
    plan(bencher, &star([14.0, 1.0], 20, NOTCHED), Demand::Part(1.0));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn cutting_a_part_of_100_vertices(bencher: Bencher) {
    let part = star([0.0, 0.0], 100, NOTCHED);
    let body = Body::from_polygon(&part);
    bencher.bench(|| MovedPart::new(&body, &Budget::default()).expect("no limit"));
}
