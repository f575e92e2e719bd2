//! Where the body must not be: the Minkowski sums of walls and its reflected pieces.

use std::cell::RefCell;

use super::blocks::{Block, Blocks, NONE};
use super::convex;
use crate::budget::{Budget, Spent};
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::Vector;
pub(super) use polygon::{Shift, SumPolygon};
use span::{Span, Spans};

mod polygon;
mod span;

/// Vertices of a sum looked at in one step.
const VERTICES_PER_STEP: u64 = 2;

/// Pieces passed over in one step.
const PIECES_PER_STEP: u64 = 8;

/// Bytes that a vertex of a sum takes, with its face.
const BYTES_PER_VERTEX: usize = 40;

/// Bytes that a sum takes besides.
const BYTES_PER_SUM: usize = 128;

/// Bytes that a unit takes, besides those for each piece.
const BYTES_PER_UNIT: usize = 192;

/// Places on each leg at which the depth of a way is looked at.
const PLACES: usize = 64;

/// What a body moves among.
#[derive(Debug, Clone, Copy)]
pub(super) struct Obstacles<'a> {
    /// The surfaces of solids.
    pub(super) walls: &'a Walls<2>,
    /// The blocks of these solids.
    pub(super) blocks: &'a RefCell<Blocks>,
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

/// A wall, or a block of a solid, with the sums of it and each piece of the body.
#[derive(Debug)]
struct Unit {
    /// The first of its walls.
    wall: usize,
    shape: UnitShape,
    low: Vector<2>,
    high: Vector<2>,
    /// A circle around all of its sums.
    around: (Vector<2>, f64),
    /// The sum of each piece, `NONE` where it has not been made.
    sums: Vec<u32>,
    /// The query that looked at it last.
    seen: u64,
}

/// What a unit is.
#[derive(Debug)]
enum UnitShape {
    /// A wall, from which no margin need be kept if it is a limit.
    Wall { ends: [Vector<2>; 2], is_limit: bool },
    /// A convex part of a solid.
    Block(Vec<Vector<2>>),
}

impl UnitShape {
    fn corners(&self) -> &[Vector<2>] {
        match self {
            Self::Wall { ends, .. } => ends,
            Self::Block(corners) => corners,
        }
    }
}

/// The sum of a unit and a piece.
#[derive(Debug)]
struct PieceSum {
    /// The first wall of the unit.
    wall: usize,
    piece: usize,
    /// Whether it has been in the way.
    is_known: bool,
    polygon: SumPolygon,
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
    /// A circle around all of them.
    circle: (Vector<2>, f64),
    /// The largest first: most of a shift is in its sums.
    order: Vec<usize>,
    /// How far they reach across the shift that is looked at.
    spans: Spans,
    /// How far the body reaches from its middle, with the margin.
    reach: f64,
    /// Walls of which less may be asked, and the first wall of the solid of each.
    near: Vec<(usize, Wall<2>)>,
    /// By wall; `NONE` where nobody has looked.
    unit_of: Vec<u32>,
    units: Vec<Unit>,
    sums: Vec<PieceSum>,
    queries: u64,
    /// Bytes taken from the budget.
    held: usize,
}

impl<'a> Sums<'a> {
    pub(super) fn new(
        obstacles: Obstacles<'a>,
        margin: SumMargin,
        budget: &Budget<'_>,
    ) -> Result<Self, Spent> {
        let Obstacles { walls, limits, pieces, relaxed, bounds, .. } = obstacles;
        let around = margin.polygon();
        let enlarge = |piece: &[Vector<2>]| match margin {
            SumMargin::Contact | SumMargin::Overlap(_) => piece.to_vec(),
            SumMargin::PerAxis(_) | SumMargin::Around(_) => {
                let mut sum = Vec::new();
                convex::sum(piece, &around, &mut sum);
                sum
            }
        };
        let enlarged: Vec<_> = pieces.iter().map(|piece| enlarge(piece)).collect();
        let count = walls.as_slice().len() + limits.len();
        let held = size_of::<u32>() * count;
        budget.hold(held)?;
        let mut near = Vec::new();
        if !matches!(margin, SumMargin::Contact | SumMargin::Overlap(_)) {
            let [low, high] = convex::bounds(&around);
            let play = Vector::repeat(obstacles.tolerance);
            for end in relaxed {
                let (min, max) = (end - bounds[1] + low - play, end - bounds[0] + high + play);
                walls.near(&min, &max, 0.0, budget, |index, wall| {
                    if let Some(solid) = walls.walls_beside(index) {
                        near.push((solid.start, *wall));
                    }
                })?;
            }
        }
        let bounds: Vec<_> = enlarged.iter().map(convex::bounds).collect();
        let size = |piece: &usize| (bounds[*piece][1] - bounds[*piece][0]).norm_squared();
        let mut order: Vec<_> = (0..enlarged.len()).collect();
        order.sort_by(|a, b| size(b).total_cmp(&size(a)));
        Ok(Self {
            reach: obstacles.radius + around.iter().map(Vector::norm).fold(0.0, f64::max),
            bounds,
            order,
            circle: convex::circle(enlarged.iter().flatten()),
            spans: Spans::new(),
            obstacles,
            margin,
            around,
            enlarged,
            near,
            unit_of: vec![NONE; count],
            units: Vec::new(),
            sums: Vec::new(),
            queries: 0,
            held,
        })
    }

    pub(super) fn tolerance(&self) -> f64 {
        self.obstacles.tolerance
    }

    pub(super) fn polygon(&self, sum: usize) -> &SumPolygon {
        &self.sums[sum].polygon
    }

    /// What is told apart where lines touch sums, metres.
    pub(super) fn rounding(&self) -> f64 {
        self.obstacles.rounding
    }

    /// Remembers a sum that is in the way. Returns whether it is new.
    pub(super) fn learn(&mut self, sum: usize) -> bool {
        !std::mem::replace(&mut self.sums[sum].is_known, true)
    }

    /// A sum in the way of a shift of the displacement; `None` if that is free. It is one that is
    /// known, or else the one that most of the way is in.
    pub(super) fn in_the_way(
        &mut self,
        shift: &Shift,
        budget: &Budget<'_>,
    ) -> Result<Option<usize>, Spent> {
        let Obstacles { walls, limits, pieces, center, rounding, .. } = self.obstacles;
        let segment = (&(center + shift.from), &(center + shift.to));
        let reach = look_reach(self.reach);
        self.queries += 1;
        budget.step(pieces.len() as u64)?;
        self.spans.look_along(shift, (pieces, &self.around), rounding);
        let mut deepest: Option<(f64, usize)> = None;
        let mut spent = Ok(());
        let mut look = |index: usize, wall: &Wall<2>| {
            let least = deepest.map_or(0.0, |(most, _)| most);
            match self.most_in_the_way((index, wall), (shift, least), budget) {
                Ok(Some(found)) if found.0 > least => {
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

    /// How much of a shift, if more than `least`, is in a sum of the unit of a wall, and in which; all
    /// and more of it is in one that is known.
    fn most_in_the_way(
        &mut self,
        (index, wall): (usize, &Wall<2>),
        (shift, least): (&Shift, f64),
        budget: &Budget<'_>,
    ) -> Result<Option<(f64, usize)>, Spent> {
        let at = self.unit((index, wall), budget)?;
        let unit = &mut self.units[at];
        if std::mem::replace(&mut unit.seen, self.queries) == self.queries {
            return Ok(None);
        }
        budget.step(1)?;
        if !shift.comes_near(&unit.around) {
            return Ok(None);
        }
        let span = Span::of(unit.shape.corners(), shift);
        if self.spans.are_passed_by(&span) {
            return Ok(None);
        }
        budget.step(self.enlarged.len() as u64 / PIECES_PER_STEP)?;
        let (low, high) = (unit.low, unit.high);
        let (mut most, mut found) = (least, None);
        for at_piece in 0..self.order.len() {
            let piece = self.order[at_piece];
            let [min, max] = &self.bounds[piece];
            let Some(bound) = self.spans.most_within(piece, &span) else { continue };
            let is_known = |sum: u32| sum != NONE && self.sums[sum as usize].is_known;
            if (bound < most && !is_known(self.units[at].sums[piece]))
                || !shift.comes_into(&[low + min, high + max])
            {
                continue;
            }
            let sum = self.sum(at, piece, budget)?;
            let PieceSum { polygon, is_known, .. } = &self.sums[sum];
            budget.step(1)?;
            if polygon.is_passed_by(shift) {
                continue;
            }
            budget.step(polygon.vertices().len() as u64 / VERTICES_PER_STEP)?;
            let within = polygon.part_within(shift);
            if within > 0.0 && *is_known {
                return Ok(Some((f64::INFINITY, sum)));
            }
            // Of equals it is the first piece.
            let is_first = found.is_some_and(|(first, _)| within == most && piece < first);
            if within > most || is_first {
                (most, found) = (within, Some((piece, sum)));
            }
        }
        Ok(found.map(|(_, sum)| (most, sum)))
    }

    /// The unit that a wall belongs to.
    fn unit(
        &mut self,
        (index, wall): (usize, &Wall<2>),
        budget: &Budget<'_>,
    ) -> Result<usize, Spent> {
        if self.unit_of[index] != NONE {
            return Ok(self.unit_of[index] as usize);
        }
        let Obstacles { walls, blocks, .. } = self.obstacles;
        let is_limit = index >= walls.as_slice().len();
        let mut blocks = blocks.borrow_mut();
        let block = match self.margin {
            SumMargin::Overlap(_) => None,
            _ if is_limit => None,
            _ => blocks.of(walls, index, budget)?.map(|block| blocks.get(block)),
        };
        let number = self.units.len();
        let name = u32::try_from(number).unwrap_or(NONE);
        let (wall, shape) = match block {
            Some(block) if !self.is_relaxed_beside(block, budget)? => {
                block.walls.iter().for_each(|wall| self.unit_of[*wall] = name);
                (block.walls[0], UnitShape::Block(block.corners.clone()))
            }
            _ => {
                self.unit_of[index] = name;
                (index, UnitShape::Wall { ends: [wall.from, wall.to], is_limit })
            }
        };
        let corners = shape.corners();
        let [low, high] = convex::bounds(corners);
        let (center, radius) = convex::circle(corners.iter());
        let around = (center + self.circle.0, radius + self.circle.1);
        let bytes = BYTES_PER_UNIT + size_of::<u32>() * self.enlarged.len();
        budget.hold(bytes)?;
        self.held += bytes;
        budget.step(4)?;
        let sums = vec![NONE; self.enlarged.len()];
        self.units.push(Unit { wall, shape, low, high, around, sums, seen: 0 });
        Ok(number)
    }

    /// Whether a block reaches, with the margin, to a wall of its solid of which less may be asked.
    fn is_relaxed_beside(&self, block: &Block, budget: &Budget<'_>) -> Result<bool, Spent> {
        budget.step(self.near.len() as u64 / VERTICES_PER_STEP)?;
        let [low, high] = convex::bounds(&block.corners);
        let [min, max] = convex::bounds(&self.around);
        let (low, high) = (low + min, high + max);
        Ok(self.near.iter().any(|(solid, wall)| {
            let (min, max) = wall.bounds();
            *solid == block.solid
                && (0..2).all(|axis| low[axis] <= max[axis] && min[axis] <= high[axis])
        }))
    }

    /// The sum of a unit and a piece.
    fn sum(&mut self, unit: usize, piece: usize, budget: &Budget<'_>) -> Result<usize, Spent> {
        let Unit { wall, shape, sums, .. } = &self.units[unit];
        if sums[piece] != NONE {
            return Ok(sums[piece] as usize);
        }
        let mut vertices = Vec::new();
        let slack = self.make((shape, piece), &mut vertices);
        let polygon = SumPolygon::new(vertices, slack);
        let count = polygon.vertices().len();
        let bytes = count * BYTES_PER_VERTEX + BYTES_PER_SUM;
        budget.hold(bytes)?;
        self.held += bytes;
        budget.step(4 + 2 * count as u64)?;
        let sum = self.sums.len();
        self.sums.push(PieceSum { wall: *wall, piece, is_known: false, polygon });
        self.units[unit].sums[piece] = u32::try_from(sum).unwrap_or(NONE);
        Ok(sum)
    }

    /// Fills `polygon` with the sum of a unit and a piece. Returns how much overlap is contact,
    /// metres.
    fn make(&self, (shape, piece): (&UnitShape, usize), polygon: &mut Vec<Vector<2>>) -> f64 {
        let Obstacles { pieces, tolerance, rounding, .. } = self.obstacles;
        let corners = shape.corners();
        let UnitShape::Wall { ends, is_limit: false } = shape else {
            let is_limit = matches!(shape, UnitShape::Wall { .. });
            let piece = if is_limit { &pieces[piece] } else { &self.enlarged[piece] };
            convex::sum(piece, corners, polygon);
            let is_contact = is_limit || self.margin == SumMargin::Contact;
            return if is_contact { tolerance } else { rounding };
        };
        convex::sum(&self.enlarged[piece], corners, polygon);
        match &self.margin {
            SumMargin::Contact => tolerance,
            SumMargin::Overlap(depth) => {
                *polygon = convex::inset(polygon, *depth);
                rounding
            }
            _ if self.reduce(piece, &Wall { from: ends[0], to: ends[1] }, polygon) => tolerance,
            _ => rounding,
        }
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

    /// The wall in whose sum the displacement `at` lies deepest, and the shortest move out of the
    /// sum, metres.
    pub(super) fn depth(
        &mut self,
        at: &Vector<2>,
        budget: &Budget<'_>,
    ) -> Result<Option<(usize, Vector<2>)>, Spent> {
        let Some(sum) = self.in_the_way(&Shift::new(at, at), budget)? else { return Ok(None) };
        let PieceSum { wall, polygon, .. } = &self.sums[sum];
        Ok(polygon.out(at).map(|out| (*wall, out)))
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
