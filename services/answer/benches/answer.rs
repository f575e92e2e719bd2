//! What an answer costs without the bus: from a request's cells to its reply's, checked,
//! planned, measured and sampled.
//!
//! `cargo bench -p clearway-answer --bench answer`

use std::convert::Infallible;

use answer::{Caps, StopFlag, Workspace};
use schemas::convert::{CellWriter, PartSink, write_scene};
use schemas::json::read_scene;
use schemas::message::{
    AxisBox, Body, ClearanceWish, Footprint, FreeSpace, Gap, Goal, Pose, RequestKey, Sampling,
    SceneRequest, Solid, Task,
};
use schemas::wire::{PART_CELLS, ReplyHeader, RequestHeader};

fn main() {
    divan::main();
}

/// Memory that every part is written to, as shared memory would be.
struct Memory(Vec<u64>);

impl PartSink for Memory {
    type Error = Infallible;

    fn part(
        &mut self,
        _: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Infallible> {
        fill(&mut CellWriter::new(&mut self.0[..cells]));
        Ok(())
    }
}

fn bench(bencher: divan::Bencher, scene: &SceneRequest) {
    bench_by_turns(bencher, &[scene], Workspace::default());
}

fn bench_by_turns(bencher: divan::Bencher, scenes: &[&SceneRequest], mut workspace: Workspace) {
    let request = |scene: &&SceneRequest| -> (RequestHeader, Vec<u64>) {
        let mut cells = Vec::new();
        let header = write_scene(scene, RequestKey::default(), 0, &mut cells);
        (header.expect("one dimension"), cells)
    };
    let requests: Vec<_> = scenes.iter().map(request).collect();
    let mut turns = requests.iter().cycle();
    let (mut memory, stop) = (Memory(vec![0; PART_CELLS]), StopFlag::new());
    bencher.bench_local(|| {
        let (header, cells) = turns.next().expect("at least one");
        let Ok(()) = workspace.answer(header, cells, &stop, &mut memory);
        memory.0[0]
    });
}

/// Section 4 at gap 0.2, walls from the channels.
#[divan::bench(args = [2, 1_000])]
fn section_4(bencher: divan::Bencher, samples: u64) {
    bench(bencher, &section_4_scene(samples));
}

fn section_4_scene(samples: u64) -> SceneRequest {
    let text = include_str!("../../../recordings/scenes/disassemble-channels.json");
    SceneRequest {
        sampling: Some(Sampling::Count(samples)),
        ..read_scene(text).expect("the project's own scene")
    }
}

/// A staircase of corridors 3 m wide, gap 0.6.
#[divan::bench(args = [(1, 1_000), (20, 2), (20, 1_000), (1_000, 2)])]
fn driving(bencher: divan::Bencher, (corners, samples): (usize, u64)) {
    bench(bencher, &staircase(corners, samples));
}

fn staircase(corners: usize, samples: u64) -> SceneRequest {
    let step = 10.0;
    let channel = |index: usize| {
        // Up, right, up, ...: every channel begins where the one before it ends.
        let (ups, rights) = (index.div_ceil(2) as f64, (index / 2) as f64);
        let (x, y) = (rights * step, ups * step);
        match index % 2 {
            0 => AxisBox { min: [x, y].into(), max: [x + 3.0, y + step + 3.0].into() },
            _ => AxisBox { min: [x, y].into(), max: [x + step + 3.0, y + 3.0].into() },
        }
    };
    let channels: Vec<_> = (0..=corners).map(channel).collect();
    let last = &channels[corners];
    let middle = |axis: usize| {
        let (min, max) = (last.min.as_slice()[axis], last.max.as_slice()[axis]);
        if (axis == 0) == (corners % 2 == 1) { max - 1.5 } else { (min + max) / 2.0 }
    };
    SceneRequest {
        task: Task::Drive,
        free_space: FreeSpace {
            in_order: true,
            channels: Some(channels.clone()),
            ..FreeSpace::default()
        },
        body: Body::Footprint(Footprint::Centered { width: 1.0, length: 1.5 }),
        start: Some(Pose { position: [1.5, 1.5].into(), heading: std::f64::consts::FRAC_PI_2 }),
        goal: Some(Goal { position: [middle(0), middle(1)].into(), heading: None }),
        clearance: ClearanceWish::Gap(Gap::Uniform(0.6)),
        sampling: Some(Sampling::Count(samples)),
        ..SceneRequest::empty()
    }
}

/// Two fields of pillars by turns, channels made from the solids; with a cache and without.
#[divan::bench(args = [(10, true), (10, false), (30, true), (30, false)])]
fn solids_by_turns(bencher: divan::Bencher, (rows, cached): (usize, bool)) {
    let [one, other] = [0.0, 0.5].map(|shift| pillars(rows, shift));
    let workspace = Workspace::new(Caps::default(), if cached { 256 << 20 } else { 0 });
    bench_by_turns(bencher, &[&one, &other], workspace);
}

/// Pillars 1 m wide, 2 m apart, `rows` by `rows` of them, between which a body moves up.
fn pillars(rows: usize, shift: f64) -> SceneRequest {
    let pillar = |index: usize| {
        let (x, z) = ((index % rows) as f64 * 3.0, (index / rows) as f64 * 3.0 + shift);
        Solid::Box(AxisBox { min: [x, z].into(), max: [x + 1.0, z + 1.0].into() })
    };
    SceneRequest {
        free_space: FreeSpace {
            solids: Some((0..rows * rows).map(pillar).collect()),
            ..FreeSpace::default()
        },
        body: Body::Box(AxisBox { min: [1.5, 0.5].into(), max: [2.5, 0.9].into() }),
        clearance: ClearanceWish::Safest,
        sampling: Some(Sampling::Count(2)),
        ..SceneRequest::empty()
    }
}
