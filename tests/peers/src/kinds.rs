//! Random scenes of the kinds that people have. A number gives the same scene on every machine.

use std::f64::consts::{PI, TAU};

use fastrand::Rng;

use crate::rectangle::{Rectangle, Walls};
use crate::scene::{Pose, Scene};
use crate::{Point, along, between, direction, norm, turned};

/// A kind of scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Kind {
    /// Rooms with doors and furniture, walls parallel to the axes.
    Offices,
    /// The same, turned by 10 to 80 degrees.
    TurnedOffices,
    /// Boxes parallel to the axes.
    Boxes,
    /// Polygons of three to eight corners.
    Polygons,
    /// A corridor that bends to both sides, by no right angle.
    SlantedCorridors,
    /// Racks with aisles, driven forwards.
    Aisles,
    /// Dead-end aisles too narrow to turn in.
    ReverseAisles,
    /// Doors narrower than the circle that the robot needs to turn.
    NarrowDoors,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 8] = [
        Self::Offices,
        Self::TurnedOffices,
        Self::Boxes,
        Self::Polygons,
        Self::SlantedCorridors,
        Self::Aisles,
        Self::ReverseAisles,
        Self::NarrowDoors,
    ];

    /// Scene `number` of this kind.
    ///
    /// # Panics
    ///
    /// If in a thousand layouts no start and goal are free.
    #[must_use]
    pub fn scene(self, number: u64) -> Scene {
        let mut rng = Rng::with_seed(number * 64 + self as u64);
        (0..1000)
            .find_map(|_| match self {
                Self::Offices => offices(&mut rng),
                Self::TurnedOffices => {
                    let angle = uniform(&mut rng, 10.0, 80.0).to_radians();
                    offices(&mut rng).map(|scene| turned_scene(scene, angle))
                }
                Self::Boxes => boxes(&mut rng),
                Self::Polygons => polygons(&mut rng),
                Self::SlantedCorridors => slanted_corridor(&mut rng),
                Self::Aisles => aisles(&mut rng),
                Self::ReverseAisles => reverse_aisles(&mut rng),
                Self::NarrowDoors => narrow_doors(&mut rng),
            })
            .expect("some layout has room for a start and a goal")
    }
}

/// How far start and goal are from the walls, metres.
const CLEAR: f64 = 0.03;

fn uniform(rng: &mut Rng, min: f64, max: f64) -> f64 {
    min + (max - min) * rng.f64()
}

fn quad(min: Point, max: Point) -> Vec<Point> {
    vec![min, [max[0], min[1]], max, [min[0], max[1]]]
}

fn room(size: Point) -> Vec<Point> {
    quad([0.0; 2], size)
}

/// A scene without start and goal.
fn empty(solids: Vec<Vec<Point>>, size: Point, footprint: [f64; 2]) -> Scene {
    let start = Pose { position: [0.0; 2], heading: 0.0 };
    let goal = start.position;
    let (goal_heading, reverse, grain) = (None, false, 0.0);
    Scene { solids, room: room(size), footprint, start, goal, goal_heading, reverse, grain }
}

/// A free pose in a box.
fn pose(rng: &mut Rng, scene: &Scene, walls: &Walls, [min, max]: [Point; 2]) -> Option<Pose> {
    (0..100).find_map(|_| {
        let position = [uniform(rng, min[0], max[0]), uniform(rng, min[1], max[1])];
        let heading = uniform(rng, -PI, PI);
        let pose = Pose { position, heading };
        is_clear(scene, walls, pose).then_some(pose)
    })
}

fn is_clear(scene: &Scene, walls: &Walls, pose: Pose) -> bool {
    let rectangle = Rectangle::new(pose, scene.footprint, CLEAR);
    scene.is_free(pose.position) && walls.is_clear(&rectangle)
}

/// Start and goal anywhere, at least `apart` from each other, the goal with a heading half of
/// the time.
fn anywhere(rng: &mut Rng, mut scene: Scene, size: Point, apart: f64) -> Option<Scene> {
    let walls = Walls::new(scene.walls());
    for _ in 0..20 {
        let start = pose(rng, &scene, &walls, [[0.0; 2], size])?;
        let goal = pose(rng, &scene, &walls, [[0.0; 2], size])?;
        if norm(between(start.position, goal.position)) >= apart {
            (scene.start, scene.goal) = (start, goal.position);
            scene.goal_heading = rng.bool().then_some(goal.heading);
            return Some(scene);
        }
    }
    None
}

/// Rooms made by splitting a floor of 14 by 10 m with walls, each with a door or two, and desks.
fn offices(rng: &mut Rng) -> Option<Scene> {
    let size = [14.0, 10.0];
    let mut solids = Vec::new();
    split(rng, [[0.0; 2], size], 3, &mut solids);
    for _ in 0..rng.usize(0..8) {
        let half = [uniform(rng, 0.15, 0.8), uniform(rng, 0.15, 0.4)];
        let half = if rng.bool() { half } else { [half[1], half[0]] };
        let center = [uniform(rng, 1.0, size[0] - 1.0), uniform(rng, 1.0, size[1] - 1.0)];
        solids.push(quad(along(center, half, -1.0), along(center, half, 1.0)));
    }
    let footprint = [uniform(rng, 0.4, 0.6), uniform(rng, 0.5, 0.9)];
    anywhere(rng, empty(solids, size, footprint), size, 4.0)
}

/// Splits a room in two, across its longer side.
fn split(rng: &mut Rng, [min, max]: [Point; 2], depth: usize, solids: &mut Vec<Vec<Point>>) {
    let axis = usize::from(max[1] - min[1] > max[0] - min[0]);
    let (extent, across) = (max[axis] - min[axis], 1 - axis);
    if depth == 0 || extent < 4.0 {
        return;
    }
    let at = min[axis] + extent * uniform(rng, 0.35, 0.65);
    let thick = uniform(rng, 0.1, 0.2);
    let door = uniform(rng, 0.8, 1.3);
    let from = uniform(rng, min[across] + 0.1, max[across] - door - 0.1);
    let mut wall = |low: f64, high: f64| {
        let (mut a, mut b) = ([at - thick / 2.0; 2], [at + thick / 2.0; 2]);
        (a[across], b[across]) = (low, high);
        solids.push(quad(a, b));
    };
    wall(min[across], from);
    wall(from + door, max[across]);
    let (mut first, mut second) = (max, min);
    (first[axis], second[axis]) = (at - thick / 2.0, at + thick / 2.0);
    split(rng, [min, first], depth - 1, solids);
    split(rng, [second, max], depth - 1, solids);
}

fn turned_scene(mut scene: Scene, angle: f64) -> Scene {
    let outlines = scene.solids.iter_mut().chain(std::iter::once(&mut scene.room));
    for point in outlines.flatten() {
        *point = turned(*point, angle);
    }
    scene.start.position = turned(scene.start.position, angle);
    scene.start.heading += angle;
    scene.goal = turned(scene.goal, angle);
    scene.goal_heading = scene.goal_heading.map(|heading| heading + angle);
    scene.grain += angle;
    scene
}

fn boxes(rng: &mut Rng) -> Option<Scene> {
    let size = [10.0; 2];
    let solids = (0..rng.usize(6..20))
        .map(|_| {
            let half = [uniform(rng, 0.1, 1.2), uniform(rng, 0.1, 1.2)];
            let center = [uniform(rng, 0.0, 10.0), uniform(rng, 0.0, 10.0)];
            quad(along(center, half, -1.0), along(center, half, 1.0))
        })
        .collect();
    let footprint = [uniform(rng, 0.3, 0.7), uniform(rng, 0.4, 1.1)];
    anywhere(rng, empty(solids, size, footprint), size, 4.0)
}

fn polygons(rng: &mut Rng) -> Option<Scene> {
    let size = [10.0; 2];
    let solids = (0..rng.usize(5..14))
        .map(|_| {
            let center = [uniform(rng, 0.5, 9.5), uniform(rng, 0.5, 9.5)];
            let corners = rng.usize(3..9);
            let first = uniform(rng, 0.0, TAU);
            let most = uniform(rng, 0.5, 1.6);
            (0..corners)
                .map(|corner| {
                    let angle = first + TAU * (corner as f64 + 0.8 * rng.f64()) / corners as f64;
                    along(center, direction(angle), most * uniform(rng, 0.3, 1.0))
                })
                .collect()
        })
        .collect();
    let footprint = [uniform(rng, 0.3, 0.7), uniform(rng, 0.4, 1.1)];
    anywhere(rng, empty(solids, size, footprint), size, 4.0)
}

/// A corridor along a line that bends by 15 to 70 degrees to one side and the other.
fn slanted_corridor(rng: &mut Rng) -> Option<Scene> {
    let footprint = [uniform(rng, 0.4, 0.7), uniform(rng, 0.6, 1.1)];
    let wide = footprint[0].hypot(footprint[1]) + uniform(rng, 0.05, 0.7);
    let mut line = vec![[0.0, 0.0]];
    let (mut heading, mut headings) = (uniform(rng, -0.6, 0.6), Vec::new());
    for _ in 0..rng.usize(3..6) {
        headings.push(heading);
        let last = line[line.len() - 1];
        line.push(along(last, direction(heading), uniform(rng, 2.5, 5.0)));
        let turn = uniform(rng, 15.0, 70.0).to_radians();
        heading = if heading > 0.0 { heading - turn } else { heading + turn };
    }
    // Both sides of the corridor, mitred at the bends.
    let side = |sign: f64| -> Vec<Point> {
        (0..line.len())
            .map(|index| {
                let (before, after) = (index.max(1) - 1, index.min(headings.len() - 1));
                let (first, second) = (headings[before], headings[after]);
                let offset = wide / 2.0 / ((second - first) / 2.0).cos();
                let out = direction(f64::midpoint(first, second) + PI / 2.0);
                along(line[index], out, sign * offset)
            })
            .collect()
    };
    let (left, right) = (side(1.0), side(-1.0));
    let all: Vec<_> = left.iter().chain(&right).copied().collect();
    let low = [0, 1].map(|axis| all.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min) - 1.0);
    let high =
        [0, 1].map(|axis| all.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max) + 1.0);
    let last = line.len() - 1;
    let mut upper = left.clone();
    upper.extend([[high[0], left[last][1]], high, [low[0], high[1]], [low[0], left[0][1]]]);
    let mut lower = right.clone();
    lower.extend([[high[0], right[last][1]], [high[0], low[1]], low, [low[0], right[0][1]]]);
    let lids = [vec![left[0], right[0], [low[0], right[0][1]], [low[0], left[0][1]]], {
        vec![left[last], [high[0], left[last][1]], [high[0], right[last][1]], right[last]]
    }];
    let mut scene = empty(vec![upper, lower], [1.0; 2], footprint);
    scene.solids.extend(lids);
    scene.room = quad(low, high);
    scene.grain = headings[0];
    let ahead = footprint[1] / 2.0 + CLEAR + 0.1;
    let heading = headings[0] + uniform(rng, -0.1, 0.1);
    scene.start = Pose { position: along(line[0], direction(headings[0]), ahead), heading };
    let end = headings[headings.len() - 1];
    scene.goal = along(line[last], direction(end), -ahead - uniform(rng, 0.0, 1.0));
    scene.goal_heading = rng.bool().then_some(end);
    let walls = Walls::new(scene.walls());
    let goal = Pose { position: scene.goal, heading: end };
    let is_free = is_clear(&scene, &walls, scene.start) && is_clear(&scene, &walls, goal);
    is_free.then_some(scene)
}

/// Rows of racks with aisles between them and cross aisles at both ends.
fn aisles(rng: &mut Rng) -> Option<Scene> {
    let footprint = [uniform(rng, 0.5, 0.8), uniform(rng, 0.8, 1.4)];
    let aisle = footprint[0] + uniform(rng, 0.15, 0.8);
    let cross = footprint[0].hypot(footprint[1]) + uniform(rng, 0.2, 1.2);
    let (rows, rack, long) = (rng.usize(3..6), uniform(rng, 0.8, 1.2), uniform(rng, 4.0, 9.0));
    let size = [long + 2.0 * cross, rows as f64 * (rack + aisle) + aisle];
    let floor = |row: usize| row as f64 * (rack + aisle);
    let solids = (0..rows)
        .map(|row| {
            let low = floor(row) + aisle;
            quad([cross, low], [cross + long, low + rack])
        })
        .collect();
    let mut scene = empty(solids, size, footprint);
    let walls = Walls::new(scene.walls());
    let (from, to) = (rng.usize(0..=rows), rng.usize(0..=rows));
    let in_aisle = |rng: &mut Rng, row: usize| {
        let x = uniform(rng, cross + footprint[1], cross + long - footprint[1]);
        let (slack, heading) = (aisle - footprint[0] - 0.1, if rng.bool() { 0.0 } else { PI });
        let y = floor(row) + aisle / 2.0 + uniform(rng, -slack, slack).clamp(-0.2, 0.2) / 2.0;
        Pose { position: [x, y], heading }
    };
    scene.start = in_aisle(rng, from);
    let goal = in_aisle(rng, to);
    scene.goal = goal.position;
    scene.goal_heading = rng.bool().then_some(goal.heading);
    let is_free = is_clear(&scene, &walls, scene.start) && is_clear(&scene, &walls, goal);
    (is_free && from != to).then_some(scene)
}

/// Aisles that end at a wall, off one cross aisle; the robot stands in one with its front to the
/// wall, or goes into one and must stand with its back to it, or both.
fn reverse_aisles(rng: &mut Rng) -> Option<Scene> {
    let footprint = [uniform(rng, 0.5, 0.8), uniform(rng, 1.0, 1.4)];
    let aisle = footprint[0] + uniform(rng, 0.1, 0.25);
    let cross = footprint[0].hypot(footprint[1]) + uniform(rng, 0.3, 1.5);
    let (rows, rack, long) = (rng.usize(2..5), uniform(rng, 0.8, 1.2), uniform(rng, 3.0, 6.0));
    let size = [long + cross, rows as f64 * (rack + aisle) + aisle];
    let solids = (0..rows)
        .map(|row| {
            let low = row as f64 * (rack + aisle) + aisle;
            quad([cross, low], [cross + long, low + rack])
        })
        .collect();
    let mut scene = empty(solids, size, footprint);
    scene.reverse = true;
    let walls = Walls::new(scene.walls());
    let in_aisle = |rng: &mut Rng, row: usize, heading: f64| {
        let x = uniform(rng, cross + footprint[1], cross + long - footprint[1] / 2.0 - 0.1);
        let y = row as f64 * (rack + aisle) + aisle / 2.0;
        Pose { position: [x, y], heading }
    };
    let (from, to) = (rng.usize(0..=rows), rng.usize(0..=rows));
    let (first, second) = *rng.choice([(0.0, 0.0), (0.0, PI), (PI, PI)].iter())?;
    scene.start = in_aisle(rng, from, first);
    let goal = in_aisle(rng, to, second);
    scene.goal = goal.position;
    scene.goal_heading = Some(goal.heading);
    let is_free = is_clear(&scene, &walls, scene.start) && is_clear(&scene, &walls, goal);
    (is_free && from != to).then_some(scene)
}

/// Rooms in a row, a door in each wall between them.
fn narrow_doors(rng: &mut Rng) -> Option<Scene> {
    let footprint = [uniform(rng, 0.4, 0.8), uniform(rng, 1.0, 1.8)];
    let rooms = rng.usize(2..4);
    let (deep, high) = (uniform(rng, 3.0, 5.0), uniform(rng, 4.0, 7.0));
    let size = [deep * rooms as f64, high];
    let mut solids = Vec::new();
    for wall in 1..rooms {
        let at = deep * wall as f64;
        let thick = uniform(rng, 0.1, 0.3);
        let door = footprint[0] + uniform(rng, 0.08, 0.4);
        let from = uniform(rng, 0.3, high - door - 0.3);
        solids.push(quad([at - thick / 2.0, 0.0], [at + thick / 2.0, from]));
        solids.push(quad([at - thick / 2.0, from + door], [at + thick / 2.0, high]));
    }
    let mut scene = empty(solids, size, footprint);
    let walls = Walls::new(scene.walls());
    scene.start = pose(rng, &scene, &walls, [[0.0; 2], [deep, high]])?;
    let goal = pose(rng, &scene, &walls, [[size[0] - deep, 0.0], size])?;
    scene.goal = goal.position;
    scene.goal_heading = rng.bool().then_some(goal.heading);
    Some(scene)
}
