//! Driving among walls at any angle: building floors, and answers on them.

use divan::{Bencher, black_box};
use planning::any_angle::{Abilities, Costs, Errand, Planner, RobotMotion, Wish, drive};
use planning::budget::Budget;
use planning::clearance::rectangle::Footprint;
use planning::driving::{Goal, Pose, StartTurn};
use planning::free_space::floor::Floor;
use planning::free_space::walls::{Wall, Walls};
use planning::geometry::{AxisBox, Vector};

fn main() {
    divan::main();
}

/// Walls in a square room of this width.
fn room(width: f64, outlines: &[Vec<Vector<2>>]) -> Walls<2> {
    let mut walls = Walls::default();
    walls.push_inside(&AxisBox::new([0.0, 0.0].into(), [width, width].into()).expect("a box"));
    for outline in outlines {
        for (index, from) in outline.iter().enumerate() {
            walls.push(Wall { from: *from, to: outline[(index + 1) % outline.len()] });
        }
    }
    walls.index(&Budget::default()).expect("no limits");
    walls
}

/// A rectangle about a point, turned.
fn rectangle(center: [f64; 2], [length, width]: [f64; 2], turn: f64) -> Vec<Vector<2>> {
    let (sin, cos) = libm::sincos(turn);
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[a, b]| {
            let (x, y) = (a * length / 2.0, b * width / 2.0);
            Vector::from([center[0] + cos * x - sin * y, center[1] + sin * x + cos * y])
        })
        .to_vec()
}

/// Pillars of 1 m every 3 m or so, as many on each side.
fn pillars(side: usize) -> (f64, Vec<Vec<Vector<2>>>) {
    let mut state = 7_u64;
    let mut random = move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1_u64 << 24) as f64
    };
    let all = (0..side * side).map(|index| {
        let (column, row) = ((index % side) as f64, (index / side) as f64);
        let center = [3.0 * column + 2.0 + random(), 3.0 * row + 2.0 + random()];
        rectangle(center, [1.0, 1.0], random())
    });
    (3.0 * side as f64 + 2.0, all.collect())
}

/// From one corner of the room to the other; with the floor made anew, or not.
fn cross(bencher: Bencher<'_, '_>, (width, outlines): (f64, Vec<Vec<Vector<2>>>), anew: bool) {
    let walls = room(width, &outlines);
    let budget = Budget::default();
    let kept = Floor::new(&walls, &budget).expect("a floor");
    let mut planner = Planner::default();
    let mut found = RobotMotion::default();
    bencher.bench_local(|| {
        let made;
        let floor = if anew {
            planner.forget();
            made = Floor::new(&walls, &budget).expect("a floor");
            &made
        } else {
            &kept
        };
        let errand = Errand {
            footprint: Footprint::new(0.3, 0.3).expect("a footprint"),
            start: Pose { position: [0.5, 0.5].into(), heading: 0.0 },
            goal: Goal { position: [width - 0.5, width - 0.5].into(), heading: None },
            start_turn: StartTurn::InPlace,
            abilities: Abilities::default(),
            costs: Costs::default(),
            walls: &walls,
            floor,
        };
        drive(&errand, Wish::Gap(0.1), &mut planner, &mut found, &budget).expect("a motion");
        black_box(found.length)
    });
}

#[divan::bench]
fn one_slanted_bar(bencher: Bencher<'_, '_>) {
    cross(bencher, (10.0, vec![rectangle([5.0, 5.0], [6.0, 0.5], 2.4)]), true);
}

#[divan::bench(args = [10, 60])]
fn pillars_first_answer(bencher: Bencher<'_, '_>, side: usize) {
    cross(bencher, pillars(side), true);
}

#[divan::bench(args = [10, 60])]
fn pillars_further_answers(bencher: Bencher<'_, '_>, side: usize) {
    cross(bencher, pillars(side), false);
}

/// Four walls for each pillar.
#[divan::bench(args = [5, 16, 50, 158, 500], sample_count = 5)]
fn floor_of_pillars(bencher: Bencher<'_, '_>, side: usize) {
    let (width, outlines) = pillars(side);
    let walls = room(width, &outlines);
    bencher.bench_local(|| Floor::new(black_box(&walls), &Budget::default()).expect("a floor"));
}
