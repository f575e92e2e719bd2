//! From solids to channels, from channels to a graph, from a graph to a route, in
//! memory that is used again.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use planning::disassembly::Gap;
use planning::free_space::End;
use planning::free_space::graph::Graph;
use planning::free_space::route::{Driving, Motion, Router, Translating};
use planning::free_space::solids::{Caps, Solids};
use planning::geometry::polygon::Polygon;
use planning::geometry::{AxisBox, Direction, Sign, Vector};

fn main() {
    divan::main();
}

const SIZES: [usize; 4] = [100, 1_000, 10_000, 100_000];

const UP: Direction = Direction { axis: 1, sign: Sign::Positive };

fn space<const D: usize>(min: [f64; D], max: [f64; D]) -> AxisBox<D> {
    AxisBox::new(min.into(), max.into()).expect("a box")
}

/// Corridors four crossings long, laid like bricks, both ways: each meets four
/// others. The last one up is the only one that reaches the mouth.
fn streets(count: usize) -> Vec<AxisBox<2>> {
    let lines = ((count * 2) as f64).sqrt() as usize / 4 * 4;
    let at = |line: usize| line as f64 * 10.0;
    let mut channels = Vec::new();
    for line in 0..lines {
        let offset = line * 2 % 4;
        let mut begin = 0;
        while begin < lines {
            let end = (begin + 4 - (begin + offset) % 4).min(lines) - 1;
            let far = if end == lines - 1 && line == lines - 1 { 5.0 } else { 0.0 };
            channels
                .push(space([at(begin) - 1.0, at(line) - 1.0], [at(end) + 1.0, at(line) + 1.0]));
            channels.push(space(
                [at(line) - 1.0, at(begin) - 1.0],
                [at(line) + 1.0, at(end) + 1.0 + far],
            ));
            begin = end + 1;
        }
    }
    channels
}

/// Blocks of uneven size on a square, apart from each other.
fn blocks<const D: usize>(count: usize) -> (Vec<AxisBox<D>>, AxisBox<D>) {
    let side = libm::ceil(libm::pow(count as f64, 1.0 / D as f64)) as usize;
    // A fixed sequence of numbers in [0, 1).
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f64 / (1_u64 << 24) as f64
    };
    let solids = (0..count).map(|index| {
        let mut rest = index;
        let mut min = [0.0; D];
        let mut max = [0.0; D];
        for axis in 0..D {
            let cell = (rest % side) as f64 * 10.0;
            rest /= side;
            min[axis] = cell + 1.0 + 2.0 * next();
            max[axis] = cell + 9.0 - 2.0 * next();
        }
        space(min, max)
    });
    let all = space([0.0; D], [side as f64 * 10.0; D]);
    (solids.collect(), all)
}

/// A comb of `count` vertices.
fn comb(count: usize) -> Vec<Vector<2>> {
    let mut vertices = Vec::new();
    for tooth in 0..count / 4 {
        let x = tooth as f64 * 4.0;
        let low = 1.0 + (tooth % 7) as f64;
        vertices.extend([[x, low], [x + 2.0, low], [x + 2.0, 20.0], [x + 4.0, 20.0]]);
    }
    let end = vertices[vertices.len() - 1][0];
    vertices.extend([[end, 0.0], [0.0, 0.0]]);
    vertices.into_iter().map(Vector::from).collect()
}

#[divan::bench]
fn section_4(bencher: Bencher<'_, '_>) {
    let channels =
        [space([1., 2.], [5., 7.]), space([1., 2.], [7., 6.]), space([4., 1.], [7., 6.])];
    let male = space([4.5, 1.01], [6.99, 4.0]);
    let (mut graph, mut router) = (Graph::default(), Router::default());
    bencher.bench_local(|| {
        graph.build(black_box(&channels), 100).expect("a graph");
        let body = Translating::new(&male, Gap::Uniform(0.2), End::Exit(UP));
        router.find(&graph, &mut body.expect("a body"), 1_000).expect("a route");
        router.length()
    });
}

#[divan::bench(sample_count = 10, args = SIZES)]
fn graph(bencher: Bencher<'_, '_>, count: usize) {
    let (channels, mut graph) = (streets(count), Graph::default());
    bencher
        .counter(ItemsCount::new(channels.len()))
        .bench_local(|| graph.build(black_box(&channels), usize::MAX).expect("a graph"));
}

#[divan::bench(sample_count = 10, args = SIZES)]
fn route_to_the_mouth(bencher: Bencher<'_, '_>, count: usize) {
    let body = Translating::new(&space([-0.5; 2], [0.5; 2]), Gap::Uniform(0.2), End::Exit(UP));
    route(bencher, &streets(count), body.expect("a body"));
}

#[divan::bench(sample_count = 10, args = SIZES)]
fn route_of_a_robot_to_the_far_corner(bencher: Bencher<'_, '_>, count: usize) {
    let channels = streets(count);
    let goal = channels[channels.len() - 1].center();
    route(bencher, &channels, Driving::new(Vector::zeros(), goal, Vector::repeat(1.5), 0.7));
}

fn route(bencher: Bencher<'_, '_>, channels: &[AxisBox<2>], mut motion: impl Motion<2>) {
    let (mut graph, mut router) = (Graph::default(), Router::default());
    graph.build(channels, usize::MAX).expect("a graph");
    bencher.counter(ItemsCount::new(channels.len())).bench_local(|| {
        router.find(&graph, black_box(&mut motion), usize::MAX).expect("a route");
        router.length()
    });
}

#[divan::bench(sample_count = 5, args = SIZES)]
fn channels_between_blocks(bencher: Bencher<'_, '_>, count: usize) {
    let (blocks, bounds) = blocks::<2>(count);
    between(bencher, &blocks, &bounds);
}

#[divan::bench(sample_count = 5, args = [100, 1_000])]
fn channels_between_blocks_in_three_dimensions(bencher: Bencher<'_, '_>, count: usize) {
    let (blocks, bounds) = blocks::<3>(count);
    between(bencher, &blocks, &bounds);
}

fn between<const D: usize>(bencher: Bencher<'_, '_>, blocks: &[AxisBox<D>], bounds: &AxisBox<D>) {
    let (mut solids, mut channels) = (Solids::default(), Vec::new());
    blocks.iter().for_each(|block| solids.push_box(*block));
    let body = Vector::repeat(1.5);
    let caps = Caps { channels: 1 << 24, steps: usize::MAX, ..Caps::default() };
    solids.channels(bounds, &body, &caps, &mut channels).expect("channels");
    bencher.counter(ItemsCount::new(channels.len())).bench_local(|| {
        solids.channels(bounds, black_box(&body), &caps, &mut channels).expect("channels");
    });
}

#[divan::bench(sample_count = 3, args = [100, 10_000, 1_000_000])]
fn channels_in_a_comb(bencher: Bencher<'_, '_>, vertices: usize) {
    let comb = Polygon::new(comb(vertices)).expect("a polygon");
    let (mut solids, mut channels) = (Solids::default(), Vec::new());
    bencher.bench_local(|| {
        solids.clear();
        solids.push_polygon(black_box(&comb), 0.1, &Caps::default()).expect("a solid");
        let bounds = solids.bounds().expect("a solid");
        let body = Vector::repeat(1.5);
        solids.channels(&bounds, &body, &Caps::default(), &mut channels).expect("channels");
        channels.len()
    });
}
