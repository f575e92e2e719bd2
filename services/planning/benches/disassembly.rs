//! Disassembly planning from a checked request, in memory that is used again.

use divan::{Bencher, black_box};
use planning::budget::Budget;
use planning::clearance::Clearance;
use planning::clearance::translating::{Body, clearance_body_legs};
use planning::disassembly::{DisassemblyPath, Gap, disassemble};
use planning::free_space::walls::{Complement, Walls};
use planning::free_space::{Chain, End};
use planning::geometry::polygon::Polygon;
use planning::geometry::{AxisBox, Direction, Sign, Vector};

#[path = "../src/section_4.rs"]
mod section_4;
use section_4::{CHANNELS, FEMALE, MALE};

fn main() {
    divan::main();
}

struct Scene {
    channels: Vec<AxisBox<2>>,
    body: AxisBox<2>,
    exit: Direction,
}

fn space(min: [f64; 2], max: [f64; 2]) -> AxisBox<2> {
    AxisBox::new(min.into(), max.into()).expect("a box")
}

/// Section 4 of the paper.
fn section_4() -> Scene {
    Scene {
        channels: CHANNELS.map(|[min, max]| space(min, max)).to_vec(),
        body: space(MALE[0], MALE[1]),
        exit: Direction { axis: 1, sign: Sign::Positive },
    }
}

fn female() -> Polygon {
    Polygon::new(FEMALE.map(Vector::from).to_vec(), &Budget::default()).expect("a polygon")
}

/// Stairs of `count` channels, up and to the right by turns.
fn stairs(count: usize) -> Scene {
    let mut from = [0.0_f64, 0.0];
    let channels = (0..count).map(|index| {
        let mut to = from;
        to[1 - index % 2] += 5.0;
        let channel = space([from[0] - 1.0, from[1] - 1.0], [to[0] + 1.0, to[1] + 1.0]);
        from = to;
        channel
    });
    let channels = channels.collect();
    let exit = Direction { axis: 1 - (count - 1) % 2, sign: Sign::Positive };
    Scene { channels, body: space([-0.5, -0.75], [0.5, 0.75]), exit }
}

#[derive(Default)]
struct Memory {
    chain: Chain<2>,
    path: DisassemblyPath<2>,
    walls: Walls<2>,
    complement: Complement<2>,
    each: Vec<Clearance<2>>,
}

impl Memory {
    fn rules(&mut self, scene: &Scene) -> f64 {
        let end = End::Exit(scene.exit);
        self.chain
            .build(&scene.channels, &scene.body.center(), end, &Budget::default())
            .expect("a chain");
        disassemble(
            &self.chain,
            &scene.body,
            Gap::Uniform(0.2),
            &mut self.path,
            &Budget::default(),
        )
        .expect("a path");
        self.path.length()
    }

    fn clearance(&mut self, scene: &Scene) -> f64 {
        let body = Body::from_box(&scene.body);
        let legs = self.path.legs();
        clearance_body_legs(&body, &self.walls, legs, &mut self.each, &Budget::default())
            .expect("no limit")
            .expect("there are walls")
            .value
    }

    fn complement(&mut self) {
        let Self { chain, walls, complement, .. } = self;
        walls
            .set_complement(
                chain.channels(),
                chain.mouth_and_channel(0.0),
                complement,
                &Budget::default(),
            )
            .expect("no limit");
    }
}

#[divan::bench]
fn section_4_rules(bencher: Bencher<'_, '_>) {
    let (scene, mut memory) = (section_4(), Memory::default());
    bencher.bench_local(|| memory.rules(black_box(&scene)));
}

#[divan::bench]
fn section_4_with_clearance_to_the_channels(bencher: Bencher<'_, '_>) {
    let (scene, mut memory) = (section_4(), Memory::default());
    bencher.bench_local(|| {
        let scene = black_box(&scene);
        let length = memory.rules(scene);
        memory.complement();
        (length, memory.clearance(scene))
    });
}

#[divan::bench]
fn section_4_with_clearance_to_the_female_part(bencher: Bencher<'_, '_>) {
    let (scene, female, mut memory) = (section_4(), female(), Memory::default());
    bencher.bench_local(|| {
        let scene = black_box(&scene);
        let length = memory.rules(scene);
        memory.walls.clear();
        memory.walls.push_polygon(black_box(&female));
        (length, memory.clearance(scene))
    });
}

#[divan::bench(sample_count = 20, args = [10, 100, 1_000, 10_000, 100_000])]
fn chain_rules(bencher: Bencher<'_, '_>, channels: usize) {
    let (scene, mut memory) = (stairs(channels), Memory::default());
    bencher.bench_local(|| memory.rules(black_box(&scene)));
}

#[divan::bench(sample_count = 20, args = [10, 100, 1_000, 10_000, 100_000])]
fn chain_walls(bencher: Bencher<'_, '_>, channels: usize) {
    let (scene, mut memory) = (stairs(channels), Memory::default());
    memory.rules(&scene);
    bencher.bench_local(|| memory.complement());
}

#[divan::bench(sample_count = 20, args = [10, 100, 1_000, 10_000, 100_000])]
fn chain_clearance(bencher: Bencher<'_, '_>, channels: usize) {
    let (scene, mut memory) = (stairs(channels), Memory::default());
    memory.rules(&scene);
    memory.complement();
    bencher.bench_local(|| memory.clearance(black_box(&scene)));
}
