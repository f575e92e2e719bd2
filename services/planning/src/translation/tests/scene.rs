//! Random scenes of the kinds that people have, their solids and parts given as outlines and as
//! convex pieces.

use proptest::prelude::*;

use crate::budget::Budget;
use crate::clearance::translating::Body;
use crate::free_space::walls::Walls;
use crate::geometry::polygon::Polygon;
use crate::geometry::{AxisBox, Direction, Sign, Vector, rotated, unit};
use crate::translation::{Cavity, Demand, MovedPart, NoWay};

/// A convex polygon.
pub(super) type Convex = Vec<Vector<2>>;

/// A part that leaves towards +z.
#[derive(Debug, Clone)]
pub(super) struct Scene {
    pub(super) outlines: Vec<Vec<Vector<2>>>,
    /// The convex pieces of each solid.
    pub(super) solids: Vec<Vec<Convex>>,
    pub(super) outline: Vec<Vector<2>>,
    /// The convex pieces of the part.
    pub(super) body: Vec<Convex>,
    pub(super) bounds: AxisBox<2>,
}

/// An outline and its convex pieces.
pub(super) type Shape = (Vec<Vector<2>>, Vec<Convex>);

pub(super) fn space(min: [f64; 2], max: [f64; 2]) -> Shape {
    let outline = [[min[0], min[1]], [max[0], min[1]], [max[0], max[1]], [min[0], max[1]]];
    let outline = outline.map(Vector::from).to_vec();
    (outline.clone(), vec![outline])
}

/// A U of this width and height, open at the top, with walls and floor of this thickness.
fn u_shape(width: f64, height: f64, thickness: f64) -> Shape {
    let (w, h, t) = (width, height, thickness);
    let outline = [[0.0, 0.0], [w, 0.0], [w, h], [w - t, h], [w - t, t], [t, t], [t, h], [0.0, h]];
    let pieces =
        [space([0.0, 0.0], [w, t]), space([0.0, 0.0], [t, h]), space([w - t, 0.0], [w, h])];
    (
        outline.map(Vector::from).to_vec(),
        pieces.into_iter().flat_map(|(_, pieces)| pieces).collect(),
    )
}

pub(super) fn l_shape(width: f64, height: f64, thickness: f64) -> Shape {
    let (w, h, t) = (width, height, thickness);
    let outline = [[0.0, 0.0], [w, 0.0], [w, t], [t, t], [t, h], [0.0, h]];
    let pieces = [space([0.0, 0.0], [w, t]), space([0.0, 0.0], [t, h])];
    (
        outline.map(Vector::from).to_vec(),
        pieces.into_iter().flat_map(|(_, pieces)| pieces).collect(),
    )
}

/// A shape turned by an angle about the origin, then moved.
pub(super) fn placed(shape: &Shape, angle: f64, to: Vector<2>) -> Shape {
    let by = if angle == 0.0 { Vector::from([1.0, 0.0]) } else { unit(angle) };
    let place = |points: &Vec<Vector<2>>| points.iter().map(|p| rotated(p, &by) + to).collect();
    (place(&shape.0), shape.1.iter().map(place).collect())
}

/// The parts that people have.
#[derive(Debug, Clone, Copy)]
pub(super) enum PartKind {
    Box,
    Convex,
    L,
    Notched,
}

impl PartKind {
    pub(super) const ALL: &[Self] = &[Self::Box, Self::Convex, Self::L, Self::Notched];

    /// Of this width, height and thickness, metres; convex ones have corners on a circle, apart by
    /// parts of the whole.
    fn shape(self, (width, height, thickness): (f64, f64, f64), corners: &[f64]) -> Shape {
        let shape = match self {
            Self::Box => space([0.0, 0.0], [width, height]),
            Self::Convex => {
                let whole: f64 = corners.iter().sum();
                let mut at = 0.0;
                let outline: Vec<Vector<2>> = corners
                    .iter()
                    .map(|part| {
                        at += part / whole * std::f64::consts::TAU;
                        unit(at) * width / 2.0
                    })
                    .collect();
                return (outline.clone(), vec![outline]);
            }
            Self::L => l_shape(width, height, thickness),
            Self::Notched => u_shape(width, height, thickness.min(0.4 * width)),
        };
        placed(&shape, 0.0, Vector::from([-width / 2.0, -height / 2.0]))
    }
}

/// A part about the origin, some 1 m large, of one of some kinds.
pub(super) fn part(kinds: &'static [PartKind]) -> impl Strategy<Value = Shape> {
    let sizes = (0.5..1.2_f64, 0.5..1.2_f64, 0.1..0.4_f64);
    (0..kinds.len(), sizes, proptest::collection::vec(0.3..1.0_f64, 3..7))
        .prop_map(|(kind, sizes, corners)| kinds[kind].shape(sizes, &corners))
}

/// Blocks in a room.
pub(super) fn blocks(angle: impl Strategy<Value = f64>) -> impl Strategy<Value = Vec<Shape>> {
    let block = ((0.0..10.0_f64, 0.5..7.0_f64), (0.3..2.5_f64, 0.3..2.5_f64), angle).prop_map(
        |((x, z), (width, height), angle)| {
            let block = space([-width / 2.0, -height / 2.0], [width / 2.0, height / 2.0]);
            placed(&block, angle, Vector::from([x, z]))
        },
    );
    proptest::collection::vec(block, 2..6)
}

/// A room of 10 m by 8 m with blocks in it, and a ceiling that has two openings: where they begin and
/// how wide they are, metres.
pub(super) fn room_of(
    [[first, wide], [second, wider]]: [[f64; 2]; 2],
    blocks: Vec<Shape>,
) -> Vec<Shape> {
    let mut solids = vec![
        space([-1.0, -1.0], [11.0, 0.0]),
        space([-1.0, 0.0], [0.0, 9.0]),
        space([10.0, 0.0], [11.0, 9.0]),
        space([0.0, 8.0], [first, 9.0]),
        space([first + wide, 8.0], [second, 9.0]),
        space([second + wider, 8.0], [10.0, 9.0]),
    ];
    solids.extend(blocks);
    solids
}

fn room(block_angle: impl Strategy<Value = f64>) -> impl Strategy<Value = Vec<Shape>> {
    let doors = (0.5..4.0_f64, 0.4..1.6_f64, 5.0..8.0_f64, 0.4..1.6_f64);
    (blocks(block_angle), doors).prop_map(|(blocks, (first, wide, second, wider))| {
        room_of([[first, wide], [second, wider]], blocks)
    })
}

/// A slot as wide as the part needs, and some play, at an angle; the part turned as well, or not.
fn slot(turned: bool) -> impl Strategy<Value = Scene> {
    let play = prop_oneof![Just(0.0), 1e-6..1e-5_f64, 0.02..0.6_f64];
    (part(PartKind::ALL), play, -1.4..1.4_f64, 0.5..2.0_f64, 0.0..0.5_f64).prop_map(
        move |(part, play, angle, depth, lean)| {
            let part = if turned { part } else { placed(&part, -angle, Vector::zeros()) };
            let low = part.0.iter().fold(Vector::<2>::repeat(f64::INFINITY), |a, b| a.inf(b));
            let high = part.0.iter().fold(Vector::<2>::repeat(f64::NEG_INFINITY), |a, b| a.sup(b));
            let size = high - low;
            let (width, height) = (size.x + play + 2.0, size.y + depth + 1.0);
            let solid = u_shape(width, height, 1.0);
            let inside = Vector::<2>::new(1.0 + play * lean, 1.0 + play * 0.5) - low;
            let part = placed(&part, 0.0, inside);
            let at = Vector::from([3.0, 2.0]);
            scene(vec![placed(&solid, angle, at)], placed(&part, angle, at))
        },
    )
}

/// A channel between two slanted walls, with a floor and a step in it.
fn slanted() -> impl Strategy<Value = Scene> {
    (part(PartKind::ALL), 0.9..2.5_f64, -0.8..0.8_f64, 0.0..0.8_f64).prop_map(
        |(part, width, lean, step)| {
            let slanted = |from: f64, to: f64| -> Shape {
                let top = 6.0 * lean;
                let outline = [[from, 0.0], [to, 0.0], [to + top, 6.0], [from + top, 6.0]];
                let outline = outline.map(Vector::from).to_vec();
                (outline.clone(), vec![outline])
            };
            let solids = vec![
                slanted(-2.0, 0.0),
                slanted(width, width + 2.0),
                space([-8.0, -1.0], [12.0, 0.0]),
                placed(&space([-0.5, -0.2], [0.5 + step, 0.2]), 0.3, [3.0 * lean, 3.5].into()),
            ];
            let low = part.0.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
            let at = Vector::from([width / 2.0 + 0.7 * lean, 0.1 - low]);
            scene(solids, placed(&part, 0.0, at))
        },
    )
}

pub(super) fn scene(solids: Vec<Shape>, (outline, body): Shape) -> Scene {
    let (outlines, solids): (Vec<_>, Vec<_>) = solids.into_iter().unzip();
    let all = outlines.concat();
    let low = all.iter().fold(all[0], |a, b| a.inf(b));
    let high = all.iter().fold(all[0], |a, b| a.sup(b));
    Scene { outlines, solids, outline, body, bounds: AxisBox::new(low, high).unwrap() }
}

fn in_room(solids: impl Strategy<Value = Vec<Shape>>, angle: f64) -> impl Strategy<Value = Scene> {
    let at = (1.0..9.0_f64, 1.0..5.0_f64);
    (solids, part(PartKind::ALL), at, -angle..=angle).prop_map(|(solids, part, (x, z), angle)| {
        scene(solids, placed(&part, angle, Vector::from([x, z])))
    })
}

/// Scenes of all kinds.
pub(super) fn scenes() -> impl Strategy<Value = Scene> {
    prop_oneof![
        in_room(room(Just(0.0)), 0.0),
        in_room(room(-1.5..1.5_f64), 1.5),
        slot(true),
        slot(false),
        slanted(),
    ]
}

impl Scene {
    /// The same scene, every point changed alike.
    pub(super) fn changed(&self, change: impl Fn(&Vector<2>) -> Vector<2>) -> Self {
        let all = |points: &Vec<Vector<2>>| points.iter().map(&change).collect::<Vec<_>>();
        let each = |shapes: &Vec<Vec<Vector<2>>>| shapes.iter().map(all).collect::<Vec<_>>();
        let corners = [self.bounds.min(), self.bounds.max()].map(|corner| change(&corner));
        Self {
            outlines: each(&self.outlines),
            solids: self.solids.iter().map(each).collect(),
            outline: all(&self.outline),
            body: each(&self.body),
            bounds: AxisBox::new(corners[0].inf(&corners[1]), corners[0].sup(&corners[1])).unwrap(),
        }
    }

    pub(super) fn extent(&self) -> f64 {
        self.bounds.size().amax()
    }

    /// What the planner says.
    pub(super) fn plan(&self, wish: Demand<2>) -> Result<Vec<Vector<2>>, NoWay<2>> {
        self.plan_to(Direction { axis: 1, sign: Sign::Positive }, wish)
    }

    pub(super) fn plan_to(
        &self,
        exit: Direction,
        wish: Demand<2>,
    ) -> Result<Vec<Vector<2>>, NoWay<2>> {
        let budget = Budget::default();
        let (walls, body) = (self.walls(), Polygon::new(self.outline.clone(), &budget).unwrap());
        let part = MovedPart::new(&Body::from_polygon(&body), &budget)?;
        Cavity { part: &part, walls: &walls, bounds: self.bounds, exit }.plan(wish, &budget)
    }

    pub(super) fn walls(&self) -> Walls<2> {
        let budget = Budget::default();
        let mut walls = Walls::default();
        for outline in &self.outlines {
            walls.push_polygon(&Polygon::new(outline.clone(), &budget).unwrap());
        }
        walls.index(&budget).unwrap();
        walls
    }
}

pub(super) fn length(way: &[Vector<2>]) -> f64 {
    way.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum()
}
