//! Driving: legs, clearance and the safest gap of corridors with many corners.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use planning::budget::Budget;
use planning::clearance::rectangle::Footprint;
use planning::driving::{
    Corner, CornerGaps, Drive, DrivingPath, Goal, Pose, StartTurn, corners_of, drive, route, safest,
};
use planning::free_space::walls::{Complement, Walls};
use planning::free_space::{Chain, End};
use planning::geometry::{AxisBox, Vector};
use std::f64::consts::FRAC_PI_2;

fn main() {
    divan::main();
}

struct Scene {
    channels: Vec<AxisBox<2>>,
    corners: Vec<Corner>,
    walls: Walls<2>,
    start: Pose,
    goal: Goal,
}

/// Corridors 3 m wide: S-turns and U-turns in turn, two up for one down.
fn serpentine(corners: usize) -> Scene {
    // The range of each corridor across its axis; even ones run along y.
    let mut across = vec![[0.0, 3.0]];
    let mut before: [f64; 2] = [0.0, 3.0];
    for corner in 0..corners {
        let low = if corner % 6 == 4 { before[0] - 9.0 } else { before[1] + 6.0 };
        before = across[corner];
        across.push([low, low + 3.0]);
    }
    let hull = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    let mut channels = Vec::new();
    for (index, own) in across.iter().enumerate() {
        let behind = if index == 0 { [0.0, 3.0] } else { across[index - 1] };
        let ahead = across.get(index + 1).copied().unwrap_or([behind[0] + 9.0, behind[1] + 9.0]);
        let along = hull(behind, ahead);
        let (x, y) = if index % 2 == 0 { (*own, along) } else { (along, *own) };
        let channel = AxisBox::new(Vector::from([x[0], y[0]]), Vector::from([x[1], y[1]]));
        channels.push(channel.expect("a channel"));
    }
    let start = Pose { position: Vector::from([1.4, 1.5]), heading: FRAC_PI_2 };
    let last = across[corners].map(|end| end + 1.5)[0];
    let end = across[corners - 1][0] + 10.0;
    let goal = if corners.is_multiple_of(2) { [last, end] } else { [end, last] };
    let goal = Goal { position: Vector::from(goal), heading: None };
    let mut chain = Chain::default();
    chain
        .build(&channels, &start.position, End::Goal(goal.position), &Budget::default())
        .expect("a chain");
    let mut corners = Vec::new();
    corners_of(&chain, &mut corners);
    let mut walls = Walls::default();
    walls
        .set_complement(&channels, None, &mut Complement::default(), &Budget::default())
        .expect("no limit");
    Scene { channels, corners, walls, start, goal }
}

impl Scene {
    fn task(&self) -> Drive<'_> {
        Drive {
            footprint: Footprint::new(1.0, 1.5).expect("a footprint"),
            start: self.start,
            goal: self.goal,
            start_turn: StartTurn::InPlace,
            first: self.channels[0],
            last: self.channels[self.channels.len() - 1],
            corners: &self.corners,
            walls: &self.walls,
        }
    }
}

#[divan::bench(args = [10, 20, 100, 1000, 10_000])]
fn legs(bencher: Bencher<'_, '_>, corners: usize) {
    let scene = serpentine(corners);
    let mut path = DrivingPath::default();
    bencher.counter(ItemsCount::new(corners)).bench_local(|| {
        route(black_box(&scene.task()), CornerGaps::Uniform(0.6), &mut path, &Budget::default())
            .expect("a way");
        path.length()
    });
}

#[divan::bench(args = [10, 20, 100, 1000, 10_000])]
fn legs_and_clearance(bencher: Bencher<'_, '_>, corners: usize) {
    let scene = serpentine(corners);
    let mut path = DrivingPath::default();
    bencher.counter(ItemsCount::new(corners)).bench_local(|| {
        drive(black_box(&scene.task()), CornerGaps::Uniform(0.6), &mut path, &Budget::default())
            .expect("a way");
        path.clearance()
    });
}

#[divan::bench(args = [20, 10_000])]
fn safest_gap(bencher: Bencher<'_, '_>, corners: usize) {
    let scene = serpentine(corners);
    let mut path = DrivingPath::default();
    bencher.counter(ItemsCount::new(corners)).bench_local(|| {
        safest(black_box(&scene.task()), &mut path, &Budget::default()).expect("a way")
    });
}

/// A wall beside the way: the gap has no closed form and is searched.
#[divan::bench]
fn safest_gap_beside_a_pillar(bencher: Bencher<'_, '_>) {
    let mut scene = serpentine(20);
    let [x, y] = [scene.corners[0].point.x, scene.corners[0].point.y];
    scene.walls.push_box(
        &AxisBox::new(Vector::from([x - 1.9, y + 1.9]), Vector::from([x - 1.8, y + 2.0]))
            .expect("a pillar"),
    );
    scene.walls.index(&Budget::default()).expect("no limit");
    let mut path = DrivingPath::default();
    bencher.bench_local(|| {
        safest(black_box(&scene.task()), &mut path, &Budget::default()).expect("a way")
    });
}
