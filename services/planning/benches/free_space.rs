//! From solids to channels, from channels to a graph, from a graph to a route, in
//! memory that is used again.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use planning::budget::Budget;
use planning::clearance::rectangle::Footprint;
use planning::disassembly::{self, Gap, disassemble};
use planning::driving::{
    self, CornerGaps, Drive, Goal, Pose, StartTurn, corners_of, drive, limits,
};
use planning::free_space::graph::Graph;
use planning::free_space::solids::Solids;
use planning::free_space::walls::{Complement, Walls};
use planning::free_space::{Chain, End};
use planning::geometry::polygon::Polygon;
use planning::geometry::{AxisBox, Direction, Sign, Vector};
use planning::route::{self, BodyMover, Judgement, Mover, Router};

#[path = "../src/section_4.rs"]
mod section_4;
use section_4::{CHANNELS, FEMALE, MALE};

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
    let (channels, male) = (CHANNELS.map(|[min, max]| space(min, max)), space(MALE[0], MALE[1]));
    let (mut graph, mut router) = (Graph::default(), Router::default());
    bencher.bench_local(|| {
        graph.build(black_box(&channels), &Budget::default()).expect("a graph");
        let body = BodyMover::new(&male, Gap::Uniform(0.2), End::Exit(UP));
        router.find(&graph, &mut body.expect("a body"), &Budget::default()).expect("a route");
        router.length()
    });
}

#[divan::bench(sample_count = 10, args = SIZES)]
fn graph(bencher: Bencher<'_, '_>, count: usize) {
    let (channels, mut graph) = (streets(count), Graph::default());
    bencher
        .counter(ItemsCount::new(channels.len()))
        .bench_local(|| graph.build(black_box(&channels), &Budget::default()).expect("a graph"));
}

#[divan::bench(sample_count = 10, args = SIZES)]
fn route_to_the_mouth(bencher: Bencher<'_, '_>, count: usize) {
    let body = BodyMover::new(&space([-0.5; 2], [0.5; 2]), Gap::Uniform(0.2), End::Exit(UP));
    route(bencher, &streets(count), body.expect("a body"));
}

#[divan::bench(sample_count = 10, args = SIZES)]
fn route_of_a_robot_to_the_far_corner(bencher: Bencher<'_, '_>, count: usize) {
    let channels = streets(count);
    let goal = channels[channels.len() - 1].center();
    route(
        bencher,
        &channels,
        route::RobotMover::new(Vector::zeros(), goal, Vector::repeat(1.5), (1.0, 0.2)),
    );
}

fn route(bencher: Bencher<'_, '_>, channels: &[AxisBox<2>], mut mover: impl Mover<2>) {
    let (mut graph, mut router) = (Graph::default(), Router::default());
    graph.build(channels, &Budget::default()).expect("a graph");
    bencher.counter(ItemsCount::new(channels.len())).bench_local(|| {
        router.find(&graph, black_box(&mut mover), &Budget::default()).expect("a route");
        router.length()
    });
}

#[divan::bench(sample_count = 5, args = SIZES)]
fn channels_between_blocks(bencher: Bencher<'_, '_>, count: usize) {
    let (blocks, bounds) = blocks::<2>(count);
    between(bencher, &blocks, &bounds);
}

#[divan::bench(sample_count = 5, args = [100, 1_000, 10_000])]
fn channels_between_blocks_in_three_dimensions(bencher: Bencher<'_, '_>, count: usize) {
    let (blocks, bounds) = blocks::<3>(count);
    between(bencher, &blocks, &bounds);
}

fn between<const D: usize>(bencher: Bencher<'_, '_>, blocks: &[AxisBox<D>], bounds: &AxisBox<D>) {
    let (mut solids, mut channels) = (Solids::default(), Vec::new());
    blocks.iter().for_each(|block| solids.push_box(*block, &Budget::default()).unwrap());
    let body = Vector::repeat(1.5);
    solids.channels(bounds, &body, &Budget::default(), &mut channels).expect("channels");
    bencher.counter(ItemsCount::new(channels.len())).bench_local(|| {
        solids
            .channels(bounds, black_box(&body), &Budget::default(), &mut channels)
            .expect("channels");
    });
}

#[divan::bench(sample_count = 3, args = [100, 10_000, 1_000_000])]
fn channels_in_a_comb(bencher: Bencher<'_, '_>, vertices: usize) {
    let comb = Polygon::new(comb(vertices), &Budget::default()).expect("a polygon");
    let (mut solids, mut channels) = (Solids::default(), Vec::new());
    bencher.bench_local(|| {
        solids.clear();
        solids.push_polygon(black_box(&comb), &Budget::default()).expect("a solid");
        let bounds = solids.bounds().expect("a solid");
        let body = Vector::repeat(1.5);
        solids.channels(&bounds, &body, &Budget::default(), &mut channels).expect("channels");
        channels.len()
    });
}

/// The boundary of the union of all streets, made anew and indexed.
#[divan::bench(sample_count = 10, args = SIZES)]
fn walls_of_streets(bencher: Bencher<'_, '_>, count: usize) {
    walls(bencher, &streets(count));
}

/// The same along one way, up and to the right by turns.
#[divan::bench(sample_count = 10, args = SIZES)]
fn walls_of_a_chain(bencher: Bencher<'_, '_>, count: usize) {
    let corner = |index: usize| [index.div_ceil(2), index / 2].map(|steps| steps as f64 * 5.0);
    let corridor = |index| corridor(corner(index), corner(index + 1), 2.0);
    walls(bencher, &(0..count).map(corridor).collect::<Vec<_>>());
}

fn walls(bencher: Bencher<'_, '_>, channels: &[AxisBox<2>]) {
    let (mut walls, mut memory) = (Walls::default(), Complement::default());
    bencher.counter(ItemsCount::new(channels.len())).bench_local(|| {
        walls.set_complement(black_box(channels), None, &mut memory, &Budget::default()).unwrap();
        walls.as_slice().len()
    });
}

/// Around the line between two points, metres.
fn corridor(from: [f64; 2], to: [f64; 2], width: f64) -> AxisBox<2> {
    let (from, to, half) = (Vector::from(from), Vector::from(to), Vector::repeat(width / 2.0));
    AxisBox::new(from.inf(&to) - half, from.sup(&to) + half).expect("a corridor")
}

/// A robot's scene, given as solids.
struct Floor {
    solids: Vec<AxisBox<2>>,
    bounds: AxisBox<2>,
    footprint: Footprint,
    gap: f64,
    start: Pose,
    goal: Goal,
}

impl Floor {
    /// All is solid within 1 m around `free`, but for that.
    fn around(free: &[AxisBox<2>], start: [f64; 2], goal: [f64; 2]) -> Self {
        let union = free.iter().map(|free| (free.min(), free.max()));
        let (min, max) = union.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1))).expect("free space");
        let (min, max) = (min - Vector::repeat(1.0), max + Vector::repeat(1.0));
        let lines = [0, 1].map(|axis| {
            let sides = free.iter().flat_map(|free| [free.min()[axis], free.max()[axis]]);
            let mut lines: Vec<_> = sides.chain([min[axis], max[axis]]).collect();
            lines.sort_unstable_by(f64::total_cmp);
            lines.dedup();
            lines
        });
        let mut solids = Vec::new();
        for row in lines[1].windows(2) {
            // What is solid in this row, up to where free space or the floor ends it.
            let mut begin = min[0];
            for x in lines[0].windows(2) {
                let cell = space([x[0], row[0]], [x[1], row[1]]);
                if free.iter().any(|free| free.contains(&cell)) {
                    solids.extend(AxisBox::new([begin, row[0]].into(), [x[0], row[1]].into()));
                    begin = x[1];
                }
            }
            solids.extend(AxisBox::new([begin, row[0]].into(), [max[0], row[1]].into()));
        }
        Self {
            solids,
            bounds: AxisBox::new(min, max).expect("a floor"),
            footprint: Footprint::new(0.6, 0.9).expect("a footprint"),
            gap: 0.2,
            start: Pose { position: start.into(), heading: std::f64::consts::FRAC_PI_2 },
            goal: Goal { position: goal.into(), heading: None },
        }
    }

    /// Corridors 3 m wide along a way that begins upwards.
    fn along(way: &[[f64; 2]]) -> Self {
        let free: Vec<_> = way.windows(2).map(|ends| corridor(ends[0], ends[1], 3.0)).collect();
        Self::around(&free, way[0], way[way.len() - 1])
    }

    fn l_turn() -> Self {
        Self::along(&[[0., 0.], [0., 10.], [10., 10.]])
    }

    fn zigzag() -> Self {
        let corner = |index: usize| [index / 2, index.div_ceil(2)].map(|steps| steps as f64 * 8.0);
        Self::along(&(0..=6).map(corner).collect::<Vec<_>>())
    }

    /// Up and down by turns, two turns at every end: 20.
    fn serpentine() -> Self {
        let corner = |index: usize| {
            let up = !index.div_ceil(2).is_multiple_of(2);
            [(index / 2) as f64 * 5.0, if up { 12.0 } else { 0.0 }]
        };
        Self::along(&(0..=21).map(corner).collect::<Vec<_>>())
    }

    /// The floor of recordings/scenes/office.yaml: corridors, four rooms with doors, a pillar.
    fn office() -> Self {
        let free = [
            ([0.7, 3.9], [0.7, 8.6]),
            ([0.7, 19.3], [5.4, 8.6]),
            ([16.1, 19.3], [5.4, 13.3]),
            ([0.7, 7.9], [8.8, 13.3]),
            ([4.6, 6.2], [8.6, 8.8]),
            ([8.1, 15.9], [8.8, 13.3]),
            ([11.0, 12.6], [8.6, 8.8]),
            ([4.1, 10.0], [0.7, 5.2]),
            ([7.0, 8.6], [5.2, 5.4]),
            ([10.2, 19.3], [0.7, 5.2]),
            ([13.0, 14.6], [5.2, 5.4]),
        ];
        let free = free.map(|(x, y)| space([x[0], y[0]], [x[1], y[1]]));
        let mut floor = Self::around(&free, [2.3, 2.0], [17.6, 12.0]);
        floor.solids.push(space([14.0, 11.0], [14.6, 11.6]));
        floor
    }
}

impl Floor {
    /// `side * side` pillars of half a metre, four metres apart and a little out of line.
    fn pillars(side: usize) -> Self {
        let width = 4.0 * side as f64 + 2.0;
        let pillar = |index: usize| {
            let (i, j) = (index / side, index % side);
            let x = 4.0 * i as f64 + 2.0 + 0.13 * ((i * 7 + j * 3) % 5) as f64;
            let y = 4.0 * j as f64 + 2.0 + 0.11 * ((i * 5 + j * 11) % 7) as f64;
            space([x, y], [x + 0.5, y + 0.5])
        };
        Self {
            solids: (0..side * side).map(pillar).collect(),
            bounds: space([0.0; 2], [width; 2]),
            footprint: Footprint::new(0.6, 0.9).expect("a footprint"),
            gap: 0.2,
            start: Pose { position: [1.0, 1.0].into(), heading: 0.0 },
            goal: Goal { position: [width - 1.2, width - 1.0].into(), heading: None },
        }
    }
}

/// All that is made from a floor, in memory that is used again.
#[derive(Default)]
struct Planner {
    solids: Solids<2>,
    channels: Vec<AxisBox<2>>,
    graph: Graph<2>,
    router: Router<2, route::RobotMover>,
    travelled: Vec<AxisBox<2>>,
    chain: Chain<2>,
    corners: Vec<driving::Corner>,
    walls: Walls<2>,
    path: driving::DrivingPath,
}

impl Planner {
    /// Channels, junctions, the shortest route, the path by the rules, its clearance to
    /// the solids: nothing but memory is kept from the time before.
    fn drive(&mut self, floor: &Floor) -> f64 {
        let Floor { footprint, gap, start, goal, .. } = *floor;
        self.solids.clear();
        self.walls.clear();
        for solid in &floor.solids {
            self.solids.push_box(*solid, &Budget::default()).unwrap();
            self.walls.push_box(solid);
        }
        self.walls.index(&Budget::default()).unwrap();
        let least = Vector::repeat(footprint.width());
        self.solids
            .channels(&floor.bounds, &least, &Budget::default(), &mut self.channels)
            .expect("channels");
        self.graph.build(&self.channels, &Budget::default()).expect("a graph");
        let needs = Vector::repeat(limits::outer_radius(&footprint, gap));
        let sides = (footprint.width(), gap);
        let mut robot = route::RobotMover::new(start.position, goal.position, needs, sides);
        let Self { channels, graph, router, travelled, chain, corners, walls, path, .. } = self;
        let found =
            router.find_judged(graph, Some(walls), &mut robot, &Budget::default(), |route, _| {
                travelled.clear();
                travelled.extend(route.iter().map(|channel| channels[*channel]));
                chain
                    .build(travelled, &start.position, End::Goal(goal.position), &Budget::default())
                    .expect("a chain");
                corners_of(chain, corners);
                let task = Drive {
                    footprint,
                    start,
                    goal,
                    start_turn: StartTurn::InPlace,
                    first: travelled[0],
                    last: travelled[travelled.len() - 1],
                    corners,
                    walls,
                };
                match drive(&task, CornerGaps::Uniform(gap), path, &Budget::default()) {
                    Ok(()) => {
                        Ok(Judgement::Accepted { length: path.length(), value: path.length() })
                    }
                    Err(error) => Judgement::of_refusal(&error, path.legs()),
                }
            });
        found.expect("a route")
    }
}

#[divan::bench(args = ["l_turn", "zigzag of 5", "serpentine of 20", "office"])]
fn drive_from_solids(bencher: Bencher<'_, '_>, name: &str) {
    let (floor, turns) = match name {
        "l_turn" => (Floor::l_turn(), 1),
        "zigzag of 5" => (Floor::zigzag(), 5),
        "serpentine of 20" => (Floor::serpentine(), 20),
        _ => (Floor::office(), 2),
    };
    let mut planner = Planner::default();
    planner.drive(&floor);
    assert_eq!(planner.corners.len(), turns);
    bencher.bench_local(|| planner.drive(black_box(&floor)));
}

#[divan::bench(sample_count = 10, args = [3, 5, 10, 20])]
fn drive_from_pillars(bencher: Bencher<'_, '_>, side: usize) {
    let (floor, mut planner) = (Floor::pillars(side), Planner::default());
    bencher.bench_local(|| planner.drive(black_box(&floor)));
}

#[divan::bench]
fn section_4_from_the_female_part(bencher: Bencher<'_, '_>) {
    let female =
        Polygon::new(FEMALE.map(Vector::from).to_vec(), &Budget::default()).expect("a polygon");
    let male = space(MALE[0], MALE[1]);
    let (mut planner, mut router) = (Planner::default(), Router::default());
    let (mut path, gap) = (disassembly::DisassemblyPath::default(), Gap::Uniform(0.2));
    bencher.bench_local(|| {
        let Planner { solids, channels, graph, travelled, chain, .. } = &mut planner;
        solids.clear();
        solids.push_polygon(black_box(&female), &Budget::default()).expect("a solid");
        let cavity = solids.cavity(&male, UP).expect("a cavity");
        solids.channels(&cavity, &male.size(), &Budget::default(), channels).expect("channels");
        graph.build(channels, &Budget::default()).expect("a graph");
        let mut body = BodyMover::new(&male, gap, End::Exit(UP)).expect("a body");
        router.find(graph, &mut body, &Budget::default()).expect("a route");
        travelled.clear();
        travelled.extend(router.route().iter().map(|channel| channels[*channel]));
        chain.build(travelled, &male.center(), End::Exit(UP), &Budget::default()).expect("a chain");
        disassemble(chain, &male, gap, &mut path, &Budget::default()).expect("a path");
        path.length()
    });
}
