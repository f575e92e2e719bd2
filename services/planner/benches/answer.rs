//! What an answer costs without the bus: from a request's cells to its reply's, checked,
//! planned, measured and sampled.
//!
//! `cargo bench -p planner --bench answer`

use std::convert::Infallible;

use planner::Workspace;
use schemas::convert::{CellWriter, PartSink, write_scene};
use schemas::json::read_scene;
use schemas::message::{
    AxisBox, Body, ClearanceWish, Footprint, FreeSpace, Gap, Goal, Pose, RequestKey, Sampling,
    SceneRequest, Task,
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
    let mut cells = Vec::new();
    let header: RequestHeader =
        write_scene(scene, RequestKey::default(), 0, &mut cells).expect("one dimension");
    let mut workspace = Workspace::default();
    let mut memory = Memory(vec![0; PART_CELLS]);
    bencher.bench_local(|| {
        let Ok(()) = workspace.answer(&header, &cells, &mut memory);
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
        body: Body::Footprint(Footprint { width: 1.0, length: 1.5 }),
        start: Some(Pose { position: [1.5, 1.5].into(), heading: std::f64::consts::FRAC_PI_2 }),
        goal: Some(Goal { position: [middle(0), middle(1)].into(), heading: None }),
        clearance: ClearanceWish::Gap(Gap::Uniform(0.6)),
        sampling: Some(Sampling::Count(samples)),
        ..SceneRequest::empty()
    }
}
