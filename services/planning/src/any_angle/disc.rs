//! The disc whose taut path is searched: how far its centre stays from each wall.

use std::f64::consts::{PI, TAU};

use super::Errand;
use crate::budget::{Budget, Spent};
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::distance::{cross, distance_point_segment, distance_segment_segment};
use crate::geometry::{Vector, unit, unrotated};

/// Steps of the budget that a wall near a line, or near an arc, takes.
const STEPS_PER_WALL: u64 = 10;

/// A disc that travels from one point to another.
///
/// Its centre keeps from every wall the disc's radius, or, where the wall is nearer to the start
/// or the goal than that, the distance there: a robot that is docked can leave.
#[derive(Debug, Clone, Copy)]
pub(super) struct Disc<'a> {
    /// Radius, metres.
    pub(super) radius: f64,
    /// Where its centre starts, metres.
    pub(super) start: Vector<2>,
    /// Where its centre goes, metres.
    pub(super) goal: Vector<2>,
    pub(super) walls: &'a Walls<2>,
    /// Distances smaller by no more than this count as kept, metres.
    pub(super) rounding: f64,
    /// Whether some wall is nearer to the start or the goal than the radius.
    is_docked: bool,
}

impl<'a> Disc<'a> {
    pub(super) fn new(
        radius: f64,
        [start, goal]: [Vector<2>; 2],
        (walls, rounding): (&'a Walls<2>, f64),
        budget: &Budget<'_>,
    ) -> Result<Self, Spent> {
        let mut is_docked = false;
        for end in [&start, &goal] {
            walls.near(end, end, radius, budget, |_, wall| {
                is_docked |= distance_to(wall, end) < radius;
            })?;
        }
        Ok(Self { radius, start, goal, walls, rounding, is_docked })
    }

    /// What its centre keeps from the end of a wall, metres.
    pub(super) fn radius_at(&self, point: &Vector<2>) -> f64 {
        if !self.is_docked {
            return self.radius;
        }
        let ends = [self.start, self.goal].map(|end| (end - point).norm());
        self.radius.min(ends[0]).min(ends[1])
    }

    fn radius_of(&self, wall: &Wall<2>) -> f64 {
        if !self.is_docked {
            return self.radius;
        }
        let ends = [&self.start, &self.goal].map(|end| distance_to(wall, end));
        self.radius.min(ends[0]).min(ends[1])
    }

    /// Whether its centre can go straight from one point to another.
    pub(super) fn is_clear(
        &self,
        line: (&Vector<2>, &Vector<2>),
        budget: &Budget<'_>,
    ) -> Result<bool, Spent> {
        let mut clear = true;
        let mut looks = 0;
        self.walls.near_line(line, self.radius, budget, |_, wall| {
            looks += 1;
            let needs = self.radius_of(wall) - self.rounding;
            clear = distance_segment_segment(line, (&wall.from, &wall.to)).distance >= needs;
            clear
        })?;
        budget.step(looks * STEPS_PER_WALL)?;
        Ok(clear)
    }

    /// Whether it keeps its radius from all walls.
    pub(super) fn is_even(&self) -> bool {
        !self.is_docked
    }

    /// The arcs of a circle about a corner on which its centre is free: directions from the
    /// corner, each arc counter-clockwise between unit vectors, all within the first and the last
    /// of `normals`. Walls that end at the corner are left out.
    pub(super) fn free_arcs(
        &self,
        (center, radius): (&Vector<2>, f64),
        normals: &[Vector<2>; 2],
        arcs: &mut Vec<FreeArc>,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let begin = libm::atan2(normals[0].y, normals[0].x);
        let span = turned(&normals[0], &normals[1], 1.0).max(0.0);
        // Of a large circle, only the walls beside the arc.
        let [low, high] = bounds(&FreeArc { ends: *normals }, (center, radius));
        let reach = self.radius;
        let (mut free, mut rest) = (vec![[0.0, span]], Vec::new());
        let mut looks = 0;
        self.walls.nearest(&low, &high, budget, |_, wall| {
            if wall.from == *center || wall.to == *center {
                return reach;
            }
            looks += 1;
            let needs = self.radius_of(wall);
            if distance_to(wall, center) >= radius + needs {
                return reach;
            }
            let is_free = |angle: f64| {
                let at = center + unit(begin + angle) * radius;
                distance_to(wall, &at) >= needs - self.rounding
            };
            let (borders, count) = borders(wall, (center, radius), needs, (begin, span));
            let mut before = 0.0;
            for after in &borders[..count] {
                if *after > before {
                    if !is_free((before + after) / 2.0) {
                        rest.clear();
                        for [from, to] in &free {
                            if *from < before {
                                rest.push([*from, to.min(before)]);
                            }
                            if *to > *after {
                                rest.push([from.max(*after), *to]);
                            }
                        }
                        std::mem::swap(&mut free, &mut rest);
                    }
                    before = *after;
                }
            }
            // A single direction has no part to be looked at.
            if span == 0.0 && !is_free(0.0) {
                free.clear();
            }
            if free.is_empty() { -1.0 } else { reach }
        })?;
        budget.step(looks * STEPS_PER_WALL)?;
        arcs.extend(free.iter().map(|arc| FreeArc { ends: arc.map(|angle| unit(begin + angle)) }));
        Ok(())
    }
}

/// The disc of this radius on a robot's errand.
pub(super) fn disc_of<'a>(
    errand: &Errand<'a>,
    radius: f64,
    budget: &Budget<'_>,
) -> Result<Disc<'a>, Spent> {
    let Errand { start, goal, walls, floor, .. } = errand;
    let ends = [start.position, goal.position];
    Disc::new(radius, ends, (walls, floor.rounding()), budget)
}

/// A part of a circle, counter-clockwise, less than half a turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FreeArc {
    /// Unit vectors from the centre.
    pub(super) ends: [Vector<2>; 2],
}

impl FreeArc {
    /// Whether it holds a direction, to this precision in radians.
    pub(super) fn holds(&self, direction: &Vector<2>, precision: f64) -> bool {
        let [first, last] = &self.ends;
        cross(first, direction) >= -precision
            && cross(direction, last) >= -precision
            && (first + last).dot(direction) >= -precision
    }
}

/// The least and the greatest coordinates of an arc.
fn bounds(arc: &FreeArc, (center, radius): (&Vector<2>, f64)) -> [Vector<2>; 2] {
    let [mut low, mut high] = [arc.ends[0].inf(&arc.ends[1]), arc.ends[0].sup(&arc.ends[1])];
    for [x, y] in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]] {
        let extreme = Vector::from([x, y]);
        if arc.holds(&extreme, 1e-9) {
            low = low.inf(&extreme);
            high = high.sup(&extreme);
        }
    }
    [low, high].map(|direction| center + direction * radius)
}

/// Where a circle crosses the border of what is within a distance of a wall: angles from `begin`
/// to the left that are less than `most`, in order, and `most` at the end; and their number.
fn borders(
    wall: &Wall<2>,
    (center, radius): (&Vector<2>, f64),
    distance: f64,
    (begin, most): (f64, f64),
) -> ([f64; 9], usize) {
    let mut borders = [most; 9];
    let mut count = 0;
    let mut around = |middle: &Vector<2>, cosine: f64| {
        if cosine.abs() < 1.0 {
            let (middle, half) = (libm::atan2(middle.y, middle.x), libm::acos(cosine));
            for angle in [middle - half, middle + half] {
                let angle = angle - begin;
                let angle = angle - TAU * (angle / TAU).floor();
                if angle < most {
                    borders[count] = angle;
                    count += 1;
                }
            }
        }
    };
    for end in [&wall.from, &wall.to] {
        let apart = end - center;
        let square = apart.norm_squared();
        let sum = radius * radius + square - distance * distance;
        around(&apart, sum / (2.0 * radius * square.sqrt()));
    }
    let way = wall.to - wall.from;
    let length = way.norm();
    if length > 0.0 {
        let normal = Vector::<2>::new(-way.y, way.x) / length;
        let height = (center - wall.from).dot(&normal);
        for side in [-distance, distance] {
            around(&normal, (side - height) / radius);
        }
    }
    borders[..count].sort_unstable_by(f64::total_cmp);
    (borders, count + 1)
}

/// The distance of a point from a wall, metres.
pub(super) fn distance_to(wall: &Wall<2>, point: &Vector<2>) -> f64 {
    distance_point_segment(point, (&wall.from, &wall.to))
}

/// The angle from one direction to another in a sense (1: left, -1: right), in (-pi, pi].
pub(super) fn turned(from: &Vector<2>, to: &Vector<2>, sense: f64) -> f64 {
    let turned = unrotated(to, from);
    let angle = sense * libm::atan2(turned.y, turned.x);
    if angle <= -PI { PI } else { angle }
}
