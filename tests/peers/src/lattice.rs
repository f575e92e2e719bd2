//! A search over a grid of poses: the peer that says what can be driven.
//!
//! Positions on a grid, sixteen headings, steps straight ahead (or back) and turns in place to the
//! neighbouring heading, the robot grown by a margin. From each pose close to the goal it tries to
//! turn to the goal, drive there straight and turn to the heading wanted. What it finds is
//! shortened by trying straight lines between points of the way, again and again.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::f64::consts::PI;

use fastrand::Rng;

use crate::rectangle::{Rectangle, Walls};
use crate::scene::{Pose, Scene};
use crate::{Point, between, norm, turned, wrapped};

/// Grid of the peer.
#[derive(Debug, Clone, Copy)]
pub struct Resolution {
    /// Between neighbours on the grid, metres.
    pub step: f64,
    /// By which the robot is grown on all sides, metres.
    pub margin: f64,
}

impl Default for Resolution {
    fn default() -> Self {
        Self { step: 0.1, margin: 0.01 }
    }
}

/// A straight piece of a way; the robot turns in place to it.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    /// Where it begins.
    pub from: Point,
    /// Where it ends.
    pub to: Point,
    /// Whether the robot drives it backwards.
    pub reverse: bool,
}

impl Piece {
    fn length(&self) -> f64 {
        norm(between(self.from, self.to))
    }

    /// The robot's heading on it.
    fn heading(&self) -> f64 {
        let way = between(self.from, self.to);
        let forwards = way[1].atan2(way[0]);
        if self.reverse { wrapped(forwards + PI) } else { forwards }
    }
}

/// Length of a way, metres.
#[must_use]
pub fn length(way: &[Piece]) -> f64 {
    way.iter().map(Piece::length).sum()
}

/// The sixteen headings' grid vectors, counter-clockwise.
const STEPS: [[i32; 2]; 16] = [
    [1, 0],
    [2, 1],
    [1, 1],
    [1, 2],
    [0, 1],
    [-1, 2],
    [-1, 1],
    [-2, 1],
    [-1, 0],
    [-2, -1],
    [-1, -1],
    [-1, -2],
    [0, -1],
    [1, -2],
    [1, -1],
    [2, -1],
];

/// A turn in place is tested at steps of this angle, radians.
const TURNED: f64 = 0.02;

/// Poses this close to the goal try to reach it, metres.
const CLOSE: f64 = 1.5;

/// Finds a way in a grid along the walls and in one along the robot; the shorter of both.
#[must_use]
pub fn find(scene: &Scene, resolution: Resolution) -> Option<Vec<Piece>> {
    let walls = Walls::new(scene.walls());
    let search = Search { scene, walls: &walls, resolution };
    let found = [scene.grain, scene.start.heading].map(|grain| {
        let way = search.run(grain)?;
        Some(search.shortened(way))
    });
    found.into_iter().flatten().min_by(|a, b| length(a).total_cmp(&length(b)))
}

struct Search<'a> {
    scene: &'a Scene,
    walls: &'a Walls,
    resolution: Resolution,
}

/// A pose of the grid: its place, and its heading or none for the start's own.
type Node = ([i32; 2], Option<usize>);

impl Search<'_> {
    fn grown(&self, pose: Pose) -> Rectangle {
        Rectangle::new(pose, self.scene.footprint, self.resolution.margin)
    }

    /// Whether the robot can turn in place, the shorter way or the longer one.
    fn turns(&self, position: Point, from: f64, to: f64) -> bool {
        let short = wrapped(to - from);
        let long = if short > 0.0 { short - 2.0 * PI } else { short + 2.0 * PI };
        [short, long].into_iter().any(|angle| self.sweeps(position, from, angle))
    }

    fn sweeps(&self, position: Point, from: f64, angle: f64) -> bool {
        let steps = (angle.abs() / TURNED).ceil() as i32;
        (0..=steps).all(|step| {
            let heading = from + angle * f64::from(step) / f64::from(steps.max(1));
            self.walls.is_clear(&self.grown(Pose { position, heading }))
        })
    }

    /// Whether the robot can drive a piece, in line with it.
    fn drives(&self, piece: &Piece) -> bool {
        let pose = Pose { position: piece.from, heading: piece.heading() };
        let length = if piece.reverse { -piece.length() } else { piece.length() };
        self.walls.is_clear(&self.grown(pose).swept(length))
    }

    /// Whether the robot can arrive at the goal with this heading.
    fn arrives(&self, heading: f64) -> bool {
        let goal = self.scene.goal_heading;
        goal.is_none_or(|wanted| self.turns(self.scene.goal, heading, wanted))
    }

    fn ways(&self) -> &'static [bool] {
        if self.scene.reverse { &[false, true] } else { &[false] }
    }

    /// A way from the start, in a grid turned by `grain` about it.
    fn run(&self, grain: f64) -> Option<Vec<Piece>> {
        let Scene { start, goal, .. } = *self.scene;
        let step = self.resolution.step;
        let place = |cell: [i32; 2]| {
            let [x, y] = turned(cell.map(|value| f64::from(value) * step), grain);
            [start.position[0] + x, start.position[1] + y]
        };
        let headings = STEPS.map(|[x, y]| f64::from(y).atan2(f64::from(x)) + grain);
        let heading = |node: Node| node.1.map_or(start.heading, |index| headings[index]);
        let first: Node = ([0; 2], None);
        let mut best: HashMap<Node, (f64, Option<(Node, bool)>)> = HashMap::new();
        let mut end: Option<(f64, Node, bool)> = None;
        let mut open = BinaryHeap::new();
        best.insert(first, (0.0, None));
        open.push((Reverse(Order(norm(between(start.position, goal)))), first));
        while let Some((Reverse(Order(bound)), node)) = open.pop() {
            if end.is_some_and(|(cost, ..)| cost <= bound) {
                break;
            }
            let (cost, position) = (best[&node].0, place(node.0));
            if bound > cost + norm(between(position, goal)) + 1e-9 {
                continue;
            }
            let to_goal = norm(between(position, goal));
            if to_goal <= CLOSE && end.is_none_or(|(least, ..)| cost + to_goal < least) {
                for reverse in self.ways() {
                    let piece = Piece { from: position, to: goal, reverse: *reverse };
                    let (has, wants) = (heading(node), piece.heading());
                    let can = if to_goal < 1e-9 {
                        self.arrives(has)
                    } else {
                        self.drives(&piece)
                            && self.turns(position, has, wants)
                            && self.arrives(wants)
                    };
                    if can {
                        end = Some((cost + to_goal, node, *reverse));
                        break;
                    }
                }
            }
            let mut try_next = |next: Node, cost: f64, how: (Node, bool)| {
                if best.get(&next).is_none_or(|(known, _)| cost < *known - 1e-9) {
                    best.insert(next, (cost, Some(how)));
                    let bound = cost + norm(between(place(next.0), goal));
                    open.push((Reverse(Order(bound)), next));
                }
            };
            let Some(index) = node.1 else {
                for (index, to) in headings.iter().enumerate() {
                    if self.turns(position, start.heading, *to) {
                        try_next((node.0, Some(index)), cost, (node, false));
                    }
                }
                continue;
            };
            for next in [(index + 1) % 16, (index + 15) % 16] {
                if self.sweeps(position, headings[index], wrapped(headings[next] - headings[index]))
                {
                    try_next((node.0, Some(next)), cost + 1e-6, (node, false));
                }
            }
            for reverse in self.ways() {
                let sign = if *reverse { -1 } else { 1 };
                let cell = [0, 1].map(|axis| node.0[axis] + sign * STEPS[index][axis]);
                let piece = Piece { from: position, to: place(cell), reverse: *reverse };
                if self.drives(&piece) {
                    try_next((cell, Some(index)), cost + piece.length(), (node, *reverse));
                }
            }
        }
        let (_, mut node, reverse) = end?;
        let mut way = vec![Piece { from: place(node.0), to: goal, reverse }];
        while let Some((before, reverse)) = best[&node].1 {
            if before.0 != node.0 {
                way.push(Piece { from: place(before.0), to: place(node.0), reverse });
            }
            node = before;
        }
        way.reverse();
        way.retain(|piece| piece.length() > 1e-9);
        Some(way)
    }

    /// The way after many tries to cut it short.
    fn shortened(&self, mut way: Vec<Piece>) -> Vec<Piece> {
        let mut rng = Rng::with_seed(way.len() as u64);
        for _ in 0..600 {
            if way.len() < 2 {
                break;
            }
            let total = length(&way);
            let (a, b) = (rng.f64() * total, rng.f64() * total);
            let (low, high) = (a.min(b), a.max(b));
            let tried = self.cut(&way, low, high);
            if let Some(shorter) = tried.filter(|tried| length(tried) < total - 1e-9) {
                way = shorter;
            }
        }
        way
    }

    /// The way with a straight line from one arc length to another, if the robot can drive it.
    fn cut(&self, way: &[Piece], low: f64, high: f64) -> Option<Vec<Piece>> {
        let (mut before, mut after) = (Vec::new(), Vec::new());
        let mut at = 0.0;
        let [mut from, mut to] = [way[0].from, self.scene.goal];
        let mut reverse = false;
        for piece in way {
            let end = at + piece.length();
            let point = |arc: f64| {
                let part = (arc - at) / piece.length();
                let way = between(piece.from, piece.to);
                [piece.from[0] + way[0] * part, piece.from[1] + way[1] * part]
            };
            if end <= low {
                before.push(*piece);
            } else if at <= low {
                from = point(low);
                reverse = piece.reverse;
                before.push(Piece { to: from, ..*piece });
            }
            if at >= high {
                after.push(*piece);
            } else if end >= high {
                to = point(high);
                after.push(Piece { from: to, ..*piece });
            }
            at = end;
        }
        let new = Piece { from, to, reverse };
        if new.length() < 1e-6 || !self.drives(&new) {
            return None;
        }
        let mut made = before;
        made.push(new);
        made.extend(after);
        made.retain(|piece| piece.length() > 1e-9);
        let first = made.first()?.heading();
        let turns = self.turns(self.scene.start.position, self.scene.start.heading, first)
            && made.windows(2).all(|pair| {
                let (from, to) = (pair[0].heading(), pair[1].heading());
                wrapped(to - from).abs() < 1e-9 || self.turns(pair[0].to, from, to)
            })
            && self.arrives(made.last()?.heading());
        turns.then_some(made)
    }
}

/// A cost in a queue.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Order(f64);

impl Eq for Order {}

impl PartialOrd for Order {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Order {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
