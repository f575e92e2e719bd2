//! Where the body must not be: the Minkowski sums of walls and its reflected pieces.

use std::collections::BTreeMap;
use std::ops::Range;

use super::convex;
use crate::budget::{Budget, Spent};
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::Vector;
use crate::geometry::orientation::Side;

/// Vertices of a sum looked at in one step.
const VERTICES_PER_STEP: u64 = 2;

/// Bytes that a vertex of a sum takes, with its face.
const BYTES_PER_VERTEX: usize = 40;

/// Bytes that a sum takes besides.
const BYTES_PER_SUM: usize = 64;

/// Places on each leg at which the depth of a way is looked at.
const PLACES: usize = 64;

/// What a body moves among.
#[derive(Debug, Clone, Copy)]
pub(super) struct Obstacles<'a> {
    /// The surfaces of solids.
    pub(super) walls: &'a Walls<2>,
    /// Walls to which no distance need be kept.
    pub(super) limits: &'a [Wall<2>],
    /// The body reflected at the origin, cut into convex pieces, counter-clockwise.
    pub(super) pieces: &'a [Vec<Vector<2>>],
    /// Displacements at which the body may be as near to the walls as it is there.
    pub(super) relaxed: &'a [Vector<2>],
    /// The least and the greatest corner of the reflected body, metres.
    pub(super) bounds: [Vector<2>; 2],
    /// The middle of the body's bounds, metres.
    pub(super) center: Vector<2>,
    /// The greatest distance of the body from there, metres.
    pub(super) radius: f64,
    /// A shallower overlap is contact, metres.
    pub(super) tolerance: f64,
    /// What rounding may add up to, metres: as far a margin may be missed.
    pub(super) rounding: f64,
}

/// The distance that the body is to keep from each wall, or what it has where that is relaxed, if
/// it is less.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum SumMargin {
    /// None: contact is allowed.
    Contact,
    /// Along each axis, metres: a box around the body.
    PerAxis(Vector<2>),
    /// This convex polygon around each point of the body, counter-clockwise, metres.
    Around(Vec<Vector<2>>),
    /// The body may overlap so far, metres.
    Overlap(f64),
}

impl SumMargin {
    fn polygon(&self) -> Vec<Vector<2>> {
        match self {
            Self::Contact | Self::Overlap(_) => vec![Vector::zeros()],
            Self::PerAxis(gap) => {
                let (x, z) = (gap[0], gap[1]);
                [[-x, -z], [x, -z], [x, z], [-x, z]].map(Vector::from).to_vec()
            }
            Self::Around(polygon) => polygon.clone(),
        }
    }
}

/// A face of a sum: its outward unit normal, and how far the sum reaches along it, metres, less
/// what counts as contact.
#[derive(Debug, Clone, Copy)]
struct SumSide {
    normal: Vector<2>,
    reach: f64,
}

/// The sum of one wall and one piece.
#[derive(Debug, Clone)]
struct PieceSum {
    wall: usize,
    piece: usize,
    /// Whether it has been in the way.
    is_known: bool,
    /// What its faces count as contact, metres.
    slack: f64,
    /// A circle around it.
    around: (Vector<2>, f64),
    vertices: Range<usize>,
    faces: Range<usize>,
}

/// The sums for one margin, each made when it is first looked at.
#[derive(Debug)]
pub(super) struct Sums<'a> {
    obstacles: Obstacles<'a>,
    margin: SumMargin,
    /// The margin as a polygon.
    around: Vec<Vector<2>>,
    /// The pieces with the margin around them, and their bounds.
    enlarged: Vec<Vec<Vector<2>>>,
    bounds: Vec<[Vector<2>; 2]>,
    /// How far the body reaches from its middle, with the margin.
    reach: f64,
    /// By wall and piece.
    made: BTreeMap<(usize, usize), usize>,
    sums: Vec<PieceSum>,
    vertices: Vec<Vector<2>>,
    /// What covers a vertex, if anything does; `None` where nobody has looked.
    covers: Vec<Option<Option<usize>>>,
    faces: Vec<SumSide>,
    /// Bytes taken from the budget.
    held: usize,
}

impl<'a> Sums<'a> {
    pub(super) fn new(obstacles: Obstacles<'a>, margin: SumMargin) -> Self {
        let around = margin.polygon();
        let enlarged: Vec<Vec<Vector<2>>> = obstacles
            .pieces
            .iter()
            .map(|piece| match margin {
                SumMargin::Contact | SumMargin::Overlap(_) => piece.clone(),
                SumMargin::PerAxis(_) | SumMargin::Around(_) => {
                    let mut sum = Vec::new();
                    convex::sum(piece, &around, &mut sum);
                    sum
                }
            })
            .collect();
        let bounds = enlarged.iter().map(|piece| convex::bounds(piece)).collect();
        let beyond = around.iter().map(Vector::norm).fold(0.0, f64::max);
        Self {
            reach: obstacles.radius + beyond,
            obstacles,
            margin,
            around,
            enlarged,
            bounds,
            made: BTreeMap::new(),
            sums: Vec::new(),
            vertices: Vec::new(),
            covers: Vec::new(),
            faces: Vec::new(),
            held: 0,
        }
    }

    pub(super) fn tolerance(&self) -> f64 {
        self.obstacles.tolerance
    }

    /// The centre and the radius of a circle around a sum, metres.
    pub(super) fn around(&self, sum: usize) -> (Vector<2>, f64) {
        self.sums[sum].around
    }

    pub(super) fn vertices(&self, sum: usize) -> &[Vector<2>] {
        &self.vertices[self.sums[sum].vertices.clone()]
    }

    /// Remembers a sum that is in the way. Returns whether it is new.
    pub(super) fn learn(&mut self, sum: usize) -> bool {
        !std::mem::replace(&mut self.sums[sum].is_known, true)
    }

    /// Whether the body can't be where a sum has its vertex `index`, because of a sum that is known.
    pub(super) fn is_covered(
        &mut self,
        sum: usize,
        index: usize,
        budget: &Budget<'_>,
    ) -> Result<bool, Spent> {
        let at = self.sums[sum].vertices.start + index;
        let covers = match self.covers[at] {
            Some(covers) => covers,
            None => {
                let vertex = self.vertices[at];
                let covers = self.in_the_way((&vertex, &vertex), budget)?;
                self.covers[at] = Some(covers);
                covers
            }
        };
        Ok(covers.is_some_and(|covers| self.sums[covers].is_known))
    }

    /// A sum in the way of a displacement that changes from `from` to `to`; `None` if that is free.
    /// It is one that is known, or else the one that most of the way is in.
    pub(super) fn in_the_way(
        &mut self,
        (from, to): (&Vector<2>, &Vector<2>),
        budget: &Budget<'_>,
    ) -> Result<Option<usize>, Spent> {
        let Obstacles { walls, limits, center, .. } = self.obstacles;
        let segment = (&(center + from), &(center + to));
        let reach = look_reach(self.reach);
        let mut deepest: Option<(f64, usize)> = None;
        let mut spent = Ok(());
        let (low, high) = (from.inf(to), from.sup(to));
        let mut look = |index: usize, wall: &Wall<2>| {
            let found = self.most_in_the_way((index, wall), (from, to), [&low, &high], budget);
            match found {
                Ok(Some(found)) if deepest.is_none_or(|(most, _)| found.0 > most) => {
                    deepest = Some(found);
                    // Nothing is to be learnt.
                    return found.0 < f64::INFINITY;
                }
                Ok(_) => {}
                Err(error) => spent = Err(error),
            }
            spent.is_ok()
        };
        let first = walls.as_slice().len();
        if limits.iter().enumerate().all(|(index, limit)| look(first + index, limit)) {
            walls.near_line(segment, reach, budget, look)?;
        }
        spent.map(|()| deepest.map(|(_, sum)| sum))
    }

    fn most_in_the_way(
        &mut self,
        (index, wall): (usize, &Wall<2>),
        (from, to): (&Vector<2>, &Vector<2>),
        [low, high]: [&Vector<2>; 2],
        budget: &Budget<'_>,
    ) -> Result<Option<(f64, usize)>, Spent> {
        let (least, greatest) = wall.bounds();
        let mut most: Option<(f64, usize)> = None;
        for piece in 0..self.enlarged.len() {
            let [min, max] = &self.bounds[piece];
            let (min, max) = (least + min, greatest + max);
            if (0..2).any(|axis| max[axis] <= low[axis] || high[axis] <= min[axis]) {
                continue;
            }
            let sum = self.sum(index, wall, piece, budget)?;
            budget.step(self.sums[sum].faces.len() as u64 / VERTICES_PER_STEP)?;
            let within = self.part_within(sum, (from, to));
            if within > 0.0 && self.sums[sum].is_known {
                return Ok(Some((f64::INFINITY, sum)));
            }
            if within > 0.0 && most.is_none_or(|(part, _)| within > part) {
                most = Some((within, sum));
            }
        }
        Ok(most)
    }

    /// How much of a segment, from 0 to 1, is inside a sum by more than the tolerance.
    fn part_within(&self, sum: usize, (from, to): (&Vector<2>, &Vector<2>)) -> f64 {
        let along = to - from;
        let (mut enter, mut exit) = (0.0_f64, 1.0_f64);
        for SumSide { normal, reach } in &self.faces[self.sums[sum].faces.clone()] {
            let depth = reach - normal.dot(from);
            let rate = normal.dot(&along);
            if rate > 0.0 {
                exit = exit.min(depth / rate);
            } else if rate < 0.0 {
                enter = enter.max(depth / rate);
            } else if depth <= 0.0 {
                return 0.0;
            }
            if exit <= enter {
                return 0.0;
            }
        }
        exit - enter
    }

    /// The sum of a wall and a piece.
    fn sum(
        &mut self,
        index: usize,
        wall: &Wall<2>,
        piece: usize,
        budget: &Budget<'_>,
    ) -> Result<usize, Spent> {
        if let Some(sum) = self.made.get(&(index, piece)) {
            return Ok(*sum);
        }
        let is_limit = index >= self.obstacles.walls.as_slice().len();
        let mut polygon = Vec::new();
        let enlarged = if is_limit { &self.obstacles.pieces[piece] } else { &self.enlarged[piece] };
        convex::sum(enlarged, &[wall.from, wall.to], &mut polygon);
        let mut slack = self.obstacles.tolerance;
        if let (false, SumMargin::Overlap(depth)) = (is_limit, &self.margin) {
            slack = self.obstacles.rounding;
            polygon = convex::inset(&polygon, *depth);
        } else if !is_limit
            && self.margin != SumMargin::Contact
            && !self.reduce(piece, wall, &mut polygon)
        {
            slack = self.obstacles.rounding;
        }
        // One face for each vertex.
        polygon.dedup();
        if polygon.first() == polygon.last() {
            polygon.pop();
        }
        let (first, first_face) = (self.vertices.len(), self.faces.len());
        self.vertices.extend(&polygon);
        self.covers.resize(self.vertices.len(), None);
        let faces = convex::normals(&polygon)
            .map(|(normal, reach)| SumSide { normal, reach: reach - slack });
        self.faces.extend(faces);
        let bytes = polygon.len() * BYTES_PER_VERTEX + BYTES_PER_SUM;
        budget.hold(bytes)?;
        self.held += bytes;
        budget.step(4 + 2 * polygon.len() as u64)?;
        let sum = self.sums.len();
        let [min, max] = convex::bounds(&polygon);
        let middle = if polygon.is_empty() { Vector::zeros() } else { (min + max) / 2.0 };
        self.sums.push(PieceSum {
            wall: index,
            piece,
            is_known: false,
            slack,
            around: (middle, polygon.iter().map(|at| (at - middle).norm()).fold(0.0, f64::max)),
            vertices: first..self.vertices.len(),
            faces: first_face..self.faces.len(),
        });
        self.made.insert((index, piece), sum);
        Ok(sum)
    }

    /// Replaces `polygon`, the sum with the whole margin, by the sum at no more than the distances
    /// where they are relaxed. Returns whether they are less than the margin.
    fn reduce(&self, piece: usize, wall: &Wall<2>, polygon: &mut Vec<Vector<2>>) -> bool {
        let Obstacles { tolerance, relaxed, bounds, .. } = self.obstacles;
        let mut bare = Vec::new();
        let (mut part, mut most) = (1.0_f64, Vector::<2>::repeat(f64::INFINITY));
        let (low, high) = wall.bounds();
        for end in relaxed {
            let mut limit = |apart: Vector<2>| {
                for axis in (0..2).filter(|axis| apart[*axis] >= -tolerance) {
                    most[axis] = most[axis].min(apart[axis].max(0.0));
                }
            };
            // Beside all of the body.
            let apart = (low + bounds[0] - end).sup(&(end - high - bounds[1]));
            if let SumMargin::PerAxis(gap) = &self.margin
                && wall.is_axis_parallel()
                && apart.max() >= -tolerance
            {
                if (gap - apart).min() > 0.0 && self.comes_near(wall, end) {
                    limit(apart);
                }
            } else if lies_in(polygon, end) {
                convex::sum(&self.obstacles.pieces[piece], &[wall.from, wall.to], &mut bare);
                let [min, max] = convex::bounds(&bare);
                let apart = (min - end).sup(&(end - max));
                if matches!(self.margin, SumMargin::PerAxis(_)) && apart.max() >= -tolerance {
                    limit(apart);
                } else {
                    part = part.min(part_of(&bare, end, &self.around).max(0.0));
                }
            }
        }
        if part == 1.0 && most.min() == f64::INFINITY {
            return false;
        }
        let around = match &self.margin {
            // A box of less than the whole gap, which may be flat.
            SumMargin::PerAxis(gap) => SumMargin::PerAxis((gap * part).inf(&most)).polygon(),
            _ => self.around.iter().map(|vertex| vertex * part).collect(),
        };
        convex::sum(&self.obstacles.pieces[piece], &[wall.from, wall.to], &mut bare);
        convex::sum(&bare, &around, polygon);
        true
    }

    /// Whether a wall is within the margin around some piece of the body.
    fn comes_near(&self, wall: &Wall<2>, at: &Vector<2>) -> bool {
        let mut sum = Vec::new();
        self.enlarged.iter().any(|piece| {
            convex::sum(piece, &[wall.from, wall.to], &mut sum);
            lies_in(&sum, at)
        })
    }

    /// Calls `visit` with each vertex of a sum at which a line from `point` touches it, and the side
    /// of the line on which the sum is.
    pub(super) fn touching(
        &self,
        sum: usize,
        point: &Vector<2>,
        mut visit: impl FnMut(usize, &Vector<2>, Side),
    ) {
        let polygon = self.vertices(sum);
        let tolerance = self.obstacles.rounding;
        let count = polygon.len();
        let PieceSum { faces, slack, .. } = &self.sums[sum];
        let faces = &self.faces[faces.clone()];
        let beyond = |face: &SumSide| face.normal.dot(point) - face.reach - slack;
        let Some(mut left) = faces.last().map(beyond) else { return };
        for (at, (vertex, face)) in polygon.iter().zip(faces).enumerate() {
            // A line touches where one side faces the point and the next does not.
            let entered = std::mem::replace(&mut left, beyond(face));
            if entered * left > 0.0 && entered.abs().min(left.abs()) > tolerance {
                continue;
            }
            let (before, after) = (&polygon[(at + count - 1) % count], &polygon[(at + 1) % count]);
            let line = vertex - point;
            let length = line.norm();
            let side = |other: &Vector<2>| {
                (line.x * (other.y - vertex.y) - line.y * (other.x - vertex.x)) / length
            };
            if length > 0.0 {
                let (a, b) = (side(before), side(after));
                if a >= -tolerance && b >= -tolerance {
                    visit(at, vertex, Side::Left);
                }
                if a <= tolerance && b <= tolerance {
                    visit(at, vertex, Side::Right);
                }
            }
        }
    }

    /// The wall in whose sum the displacement `at` lies deepest, and the shortest move out of the
    /// sum, metres.
    pub(super) fn depth(
        &mut self,
        at: &Vector<2>,
        budget: &Budget<'_>,
    ) -> Result<Option<(usize, Vector<2>)>, Spent> {
        let Some(sum) = self.in_the_way((at, at), budget)? else { return Ok(None) };
        let PieceSum { wall, vertices, .. } = &self.sums[sum];
        let faces = convex::normals(&self.vertices[vertices.clone()]);
        let out = faces.map(|(normal, reach)| normal * (reach - normal.dot(at)));
        let least = out.min_by(|a, b| a.norm().total_cmp(&b.norm()));
        Ok(least.map(|out| (*wall, out)))
    }

    /// Across which direction a way lies deepest in the bare sums of the body, and the wall.
    pub(super) fn deepest(&self, way: &[Vector<2>]) -> Option<(usize, Vector<2>)> {
        let mut deepest: Option<(f64, usize, Vector<2>)> = None;
        for PieceSum { wall, piece, .. } in &self.sums {
            let Some(side) = self.obstacles.walls.as_slice().get(*wall) else { continue };
            let mut bare = Vec::new();
            convex::sum(&self.obstacles.pieces[*piece], &[side.from, side.to], &mut bare);
            let faces: Vec<_> = convex::normals(&bare).collect();
            for at in way.windows(2).flat_map(|ends| {
                (0..=PLACES)
                    .map(|part| ends[0] + (ends[1] - ends[0]) * (part as f64 / PLACES as f64))
            }) {
                let least = faces
                    .iter()
                    .map(|(normal, reach)| (reach - normal.dot(&at), *normal))
                    .min_by(|a, b| a.0.total_cmp(&b.0));
                if let Some((depth, normal)) = least
                    && deepest.is_none_or(|(most, ..)| depth > most)
                {
                    deepest = Some((depth, *wall, normal));
                }
            }
        }
        deepest.map(|(_, wall, normal)| (wall, normal))
    }

    /// Gives the memory back.
    pub(super) fn release(&mut self, budget: &Budget<'_>) {
        budget.release(self.held);
        self.held = 0;
    }
}

/// Of a scaled polygon around a point that just touches another one: the scale.
fn part_of(polygon: &[Vector<2>], point: &Vector<2>, around: &[Vector<2>]) -> f64 {
    let apart = |normal: &Vector<2>, reach: f64| {
        (normal.dot(point) - reach) / convex::support(around, &-normal)
    };
    let of_polygon = convex::normals(polygon).map(|(normal, reach)| apart(&normal, reach));
    let of_around = convex::normals(around)
        .map(|(normal, _)| apart(&normal, convex::support(polygon, &normal)));
    of_polygon.chain(of_around).fold(f64::NEG_INFINITY, f64::max)
}

fn lies_in(polygon: &[Vector<2>], point: &Vector<2>) -> bool {
    convex::normals(polygon).all(|(normal, reach)| normal.dot(point) < reach)
}

/// The reach with some room for rounding.
fn look_reach(reach: f64) -> f64 {
    reach * (1.0 + 1e-9)
}
