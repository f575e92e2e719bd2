//! The way with the greatest clearance.

use super::convex;
use super::sums::{Obstacles, SumMargin};
use crate::budget::{Budget, Spent};
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::distance::{distance_segment_segment, nearest_on_segment};
use crate::geometry::{Vector, polygon, unit};

/// The normals that a polygon around a circle has in any case.
const NORMALS: usize = 16;

/// It has those of this many sides of walls and of the part, besides.
const MOST_SIDES: usize = 24;

/// Normals that differ by no more are one, radians.
const SAME: f64 = 1e-6;

/// A wall is cut until all points of a piece are about as far from the part: up to this factor.
const RATIO: f64 = 1.5;

/// Nor is a piece cut that is shorter than this part of the extent.
const SHORTEST: f64 = 1e-3;

/// Steps that the distance of two edges takes.
const STEPS_PER_PAIR: u64 = 8;

/// Directions of the sides of a polygon around a circle.
#[derive(Debug, Clone)]
pub(super) struct CirclePolygon {
    /// Unit normals, counter-clockwise from +x.
    angles: Vec<f64>,
}

impl CirclePolygon {
    /// No polygon reaches farther beyond its circle than to this multiple of its radius.
    pub(super) const BEYOND: f64 = 1.02;

    /// With the normals of walls and part, so that what they leave between parallel sides is exact.
    pub(super) fn new(walls: &Walls<2>, pieces: &[Vec<Vector<2>>]) -> Self {
        let step = std::f64::consts::TAU / NORMALS as f64;
        let mut circle = Self { angles: (0..NORMALS).map(|at| at as f64 * step).collect() };
        let walls = walls.as_slice().iter().map(|wall| wall.to - wall.from);
        let pieces = pieces.iter().flat_map(|piece| polygon::edges(piece).map(|(a, b)| b - a));
        for along in walls.take(1 << 10).chain(pieces.take(1 << 10)) {
            if circle.angles.len() >= NORMALS + 2 * MOST_SIDES {
                break;
            }
            circle.add(&Vector::from([along.y, -along.x]));
        }
        circle
    }

    /// Adds sides across a direction.
    pub(super) fn add(&mut self, direction: &Vector<2>) {
        use std::f64::consts::{PI, TAU};
        for turned in [0.0, PI] {
            let angle = libm::atan2(direction.y, direction.x) + turned;
            let angle = if angle < 0.0 { angle + TAU } else { angle };
            let angle = if angle >= TAU { angle - TAU } else { angle };
            let at = self.angles.partition_point(|other| *other < angle);
            let near = |other: f64| (other - angle).abs().min(TAU - (other - angle).abs());
            let count = self.angles.len();
            let neighbours = [self.angles[at % count], self.angles[(at + count - 1) % count]];
            if neighbours.iter().all(|other| near(*other) > SAME) {
                self.angles.insert(at, angle);
            }
        }
    }

    /// The polygon around a circle of this radius, metres.
    pub(super) fn margin(&self, radius: f64) -> SumMargin {
        if radius <= 0.0 {
            return SumMargin::Contact;
        }
        let next = self.angles.iter().skip(1).chain(&self.angles[..1]);
        let corner = |(a, b): (&f64, &f64)| {
            let half = if b > a { (b - a) / 2.0 } else { (b + std::f64::consts::TAU - a) / 2.0 };
            unit(a + half) * (radius / libm::cos(half))
        };
        SumMargin::Around(self.angles.iter().zip(next).map(corner).collect())
    }
}

/// The walls, those near the part cut so that a piece asks for no less than what the part keeps from
/// it at the start: from a floor on which it stands, only where it stands.
pub(super) fn cut_near(
    walls: &Walls<2>,
    outlines: &[Vec<Vector<2>>],
    extent: f64,
    budget: &Budget<'_>,
) -> Result<Walls<2>, Spent> {
    let mut cut = Walls::default();
    let mut stack = Vec::new();
    let vertices: Vec<Vector<2>> = outlines.iter().flatten().copied().collect();
    let [min, max] = convex::bounds(&vertices);
    for wall in walls.as_slice() {
        budget.step(1)?;
        let (low, high) = wall.bounds();
        let apart = (low - max).sup(&(min - high)).max();
        if apart > extent / 8.0 {
            cut.push(*wall);
            continue;
        }
        stack.push(*wall);
        while let Some(piece) = stack.pop() {
            budget.step(3 * STEPS_PER_PAIR * vertices.len() as u64)?;
            let distance = |from: &Vector<2>, to: &Vector<2>| {
                let edges = outlines.iter().flat_map(|outline| polygon::edges(outline));
                edges
                    .map(|(a, b)| distance_segment_segment((from, to), (&a, &b)).distance)
                    .fold(f64::INFINITY, f64::min)
            };
            let Wall { from, to } = piece;
            let shortest = SHORTEST * extent;
            let most = distance(&from, &from).max(distance(&to, &to));
            if (to - from).norm() > shortest && most > RATIO * distance(&from, &to) + shortest {
                let middle = (from + to) / 2.0;
                stack.push(Wall { from: middle, to });
                stack.push(Wall { from, to: middle });
            } else {
                cut.push(piece);
            }
        }
    }
    cut.index(budget)?;
    Ok(cut)
}

/// Clearances at which sums beside a way would close it, from `least` to `most` metres, with the
/// directions across; the least first.
pub(super) fn closing(
    way: &[Vector<2>],
    obstacles: &Obstacles<'_>,
    (least, most): (f64, f64),
    budget: &Budget<'_>,
) -> Result<Vec<(f64, Vector<2>)>, Spent> {
    // The sums, and whether a margin is kept from them.
    let mut near: Vec<(Vec<Vector<2>>, bool)> = Vec::new();
    for ends in way.windows(2) {
        let way = (&ends[0], &ends[1]);
        let mut take = |wall: &Wall<2>, has_margin: bool| {
            for piece in obstacles.pieces {
                let mut sum = Vec::new();
                convex::sum(piece, &[wall.from, wall.to], &mut sum);
                let beside = polygon::edges(&sum)
                    .any(|(a, b)| distance_segment_segment(way, (&a, &b)).distance <= most);
                if beside {
                    near.push((sum, has_margin));
                }
            }
            near.len() < MOST_NEAR
        };
        obstacles.limits.iter().for_each(|limit| {
            take(limit, false);
        });
        let segment = (&(obstacles.center + ends[0]), &(obstacles.center + ends[1]));
        let reach = obstacles.radius + most;
        obstacles.walls.near_line(segment, reach, budget, |_, wall| take(wall, true))?;
    }
    let mut found = Vec::new();
    for (index, (one, margin)) in near.iter().enumerate() {
        for (other, other_margin) in &near[index + 1..] {
            budget.step(STEPS_PER_PAIR * (one.len() * other.len()) as u64)?;
            let margins = f64::from(u8::from(*margin) + u8::from(*other_margin));
            let apart = between(one, other).into_iter().chain(between(other, one));
            let closest = apart.min_by(|a, b| a.norm().total_cmp(&b.norm()));
            let Some(across) = closest else { continue };
            let closes = across.norm() / margins;
            if least < closes && closes < most {
                found.push((closes, across));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(found)
}

/// From the vertices of one polygon to the nearest points of the other.
fn between(one: &[Vector<2>], other: &[Vector<2>]) -> Vec<Vector<2>> {
    let to = |vertex: &Vector<2>| {
        polygon::edges(other)
            .map(|(a, b)| nearest_on_segment(vertex, (&a, &b)) - vertex)
            .min_by(|a, b| a.norm().total_cmp(&b.norm()))
    };
    one.iter().filter_map(to).collect()
}

/// Sums beside a way that are compared with each other.
const MOST_NEAR: usize = 64;
