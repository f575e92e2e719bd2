//! Exact clearance of a body that moves without turning.
//!
//! A box passing an axis-parallel wall is a point passing their Minkowski sum along a
//! segment. Otherwise two outlines come closest where a vertex of one meets an edge of the
//! other, which leaves finitely many pairs of segments.

use super::Clearance;
use crate::budget::{Budget, Spent};
use crate::free_space::walls::{Wall, Walls, planar};
use crate::geometry::box_tree::distance_squared_box_box;
use crate::geometry::distance::{distance_segment_box, distance_segment_segment};
use crate::geometry::polygon::{self, Polygon};
use crate::geometry::{AxisBox, Vector};
use crate::motion::{Curve, Leg};

/// Steps that a box against a wall takes.
const STEPS_PER_WALL: u64 = 2;

/// Steps that an edge of the body against a wall takes.
const STEPS_PER_EDGE: u64 = 8;

/// The moving body in its assembled state.
#[derive(Debug, Clone, Copy)]
pub struct Body<'a, const D: usize> {
    bounds: AxisBox<D>,
    /// Of a polygon that does not fill its bounds, otherwise empty.
    outline: &'a [Vector<2>],
    /// Of a union of several boxes, otherwise empty.
    boxes: &'a [AxisBox<D>],
}

impl<const D: usize> Body<'_, D> {
    /// A box.
    pub fn from_box(body: &AxisBox<D>) -> Self {
        Self { bounds: *body, outline: &[], boxes: &[] }
    }

    /// The smallest box around it.
    pub fn bounds(&self) -> &AxisBox<D> {
        &self.bounds
    }

    /// Whether it is one box.
    pub fn is_box(&self) -> bool {
        self.outline.is_empty() && self.boxes.is_empty()
    }

    /// Whether it is given by several boxes.
    pub fn is_union(&self) -> bool {
        !self.boxes.is_empty()
    }

    /// Boxes that cover it: those that it is the union of, or its bounds.
    pub fn boxes(&self) -> &[AxisBox<D>] {
        if self.boxes.is_empty() { std::slice::from_ref(&self.bounds) } else { self.boxes }
    }

    /// The outlines in the plane of which it is the union.
    pub fn outlines(&self) -> Vec<Vec<Vector<2>>> {
        match self.outline {
            [] => self.boxes().iter().map(|part| corners(part).to_vec()).collect(),
            outline => vec![outline.to_vec()],
        }
    }

    /// A point on the boundary of each of its parts.
    fn points(&self) -> impl Iterator<Item = Vector<D>> {
        self.boxes().iter().map(|part| {
            let mut point = part.min();
            if let Some(vertex) = self.outline.first() {
                (point[0], point[1]) = (vertex[0], vertex[1]);
            }
            point
        })
    }
}

impl<'a, const D: usize> Body<'a, D> {
    /// The union of boxes, which may overlap, touch and be apart; `None` without any.
    pub fn from_boxes(boxes: &'a [AxisBox<D>]) -> Option<Self> {
        let corners = boxes.iter().map(|part| (part.min(), part.max()));
        let (min, max) = corners.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))?;
        let bounds = AxisBox::new(min, max).ok()?;
        let boxes = if boxes.len() == 1 { &[] } else { boxes };
        Some(Self { bounds, outline: &[], boxes })
    }
}

impl<'a> Body<'a, 2> {
    /// A polygon, convex or not. An axis-parallel rectangle is taken as a box.
    pub fn from_polygon(body: &'a Polygon) -> Self {
        let outline = if body.is_axis_box() { &[][..] } else { body.vertices() };
        Self { bounds: *body.bounds(), outline, boxes: &[] }
    }
}

/// The corners of a box in the plane.
fn corners<const D: usize>(sides: &AxisBox<D>) -> [Vector<2>; 4] {
    let (min, max) = (planar(&sides.min()), planar(&sides.max()));
    [min, Vector::from([max[0], min[1]]), max, Vector::from([min[0], max[1]])]
}

/// The exact clearance of `body` along `legs`, whose positions are displacements from where
/// the body is given. Only lines count. `each` is refilled with the clearance of every leg;
/// the result is that of the whole motion, `None` without walls or legs.
///
/// Contact and overlap give 0 at the first contact, and so does a body that starts inside a
/// solid or around one. Of places that are equally close to rounding (some 1e-14 of the
/// coordinates) the first is reported; of those at one time, the one on the first wall.
///
/// ```
/// use planning::budget::Budget;
/// use planning::clearance::translating::{Body, clearance_body_legs};
/// use planning::free_space::walls::Walls;
/// use planning::geometry::{AxisBox, Vector};
/// use planning::motion::{Curve, Leg};
///
/// // A unit square moves up past a box to its right, 0.5 m away.
/// let body = AxisBox::new([0.0, 0.0].into(), [1.0, 1.0].into())?;
/// let mut walls = Walls::default();
/// walls.push_box(&AxisBox::new([1.5, 3.0].into(), [4.0, 9.0].into())?);
/// let curve = Curve::translation(Vector::from([0.0, 0.0]), Vector::from([0.0, 5.0]));
/// let legs = [Leg { curve, junction: None, rule: None, rung: None }];
/// let (body, mut each, budget) = (Body::from_box(&body), Vec::new(), Budget::default());
/// let clearance = clearance_body_legs(&body, &walls, &legs, &mut each, &budget)?;
/// let clearance = clearance.expect("there are walls");
/// // First when its upper side is level with the lower side of the box.
/// assert_eq!((clearance.value, clearance.at), (0.5, 2.0));
/// assert_eq!(clearance.wall, Vector::from([1.5, 3.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn clearance_body_legs<const D: usize>(
    body: &Body<'_, D>,
    walls: &Walls<D>,
    legs: &[Leg<D>],
    each: &mut Vec<Clearance<D>>,
    budget: &Budget<'_>,
) -> Result<Option<Clearance<D>>, Spent> {
    each.clear();
    let mut whole: Option<Nearest<D>> = None;
    let mut travelled = 0.0;
    for leg in legs {
        let Curve::Line { from, to, .. } = &leg.curve else { continue };
        let mut nearest = leg_clearance(body, walls, (from, to), budget)?;
        if each.is_empty() && (nearest.value, nearest.at) != (0.0, 0.0) {
            // It touches no wall at the start, so each part is inside a solid wholly or not at all.
            for point in body.points() {
                if let Some(wall) = walls.solid_around(&(point + from), budget)? {
                    let point = walls.as_slice()[wall].from;
                    nearest = Nearest { value: 0.0, at: 0.0, wall, point, ..nearest };
                    break;
                }
            }
        }
        if nearest.value == f64::INFINITY {
            return Ok(None);
        }
        let length = leg.curve.length();
        nearest.at = travelled + nearest.at * length;
        travelled += length;
        each.push(nearest.clearance());
        match &mut whole {
            Some(whole) => {
                whole.rounding = whole.rounding.max(nearest.rounding);
                whole.take(nearest.value, nearest.at, nearest.wall, nearest.point);
            }
            None => whole = Some(nearest),
        }
    }
    Ok(whole.map(|whole| whole.clearance()))
}

/// The closest place so far.
#[derive(Debug, Clone, Copy)]
struct Nearest<const D: usize> {
    value: f64,
    /// Where on the leg, from 0 to 1; for the whole motion the arc length.
    at: f64,
    wall: usize,
    point: Vector<D>,
    /// Distances that differ by no more count as equal, metres.
    rounding: f64,
}

impl<const D: usize> Nearest<D> {
    fn take(&mut self, value: f64, at: f64, wall: usize, point: Vector<D>) {
        let first = (at, wall) < (self.at, self.wall);
        if value < self.value - self.rounding || (value <= self.value + self.rounding && first) {
            (self.at, self.wall, self.point) = (at, wall, point);
        }
        self.value = self.value.min(value);
    }

    /// Anything farther away can be left out.
    fn reach(&self) -> f64 {
        self.value + self.rounding
    }

    fn clearance(&self) -> Clearance<D> {
        Clearance { value: self.value, at: self.at, wall: self.point }
    }
}

fn leg_clearance<const D: usize>(
    body: &Body<'_, D>,
    walls: &Walls<D>,
    (from, to): (&Vector<D>, &Vector<D>),
    budget: &Budget<'_>,
) -> Result<Nearest<D>, Spent> {
    let (least, greatest) = (from.inf(to), from.sup(to));
    let (min, max) = (body.bounds.min() + least, body.bounds.max() + greatest);
    let rounding = 16.0 * f64::EPSILON * min.amax().max(max.amax());
    let nowhere = Vector::zeros();
    let mut nearest =
        Nearest { value: f64::INFINITY, at: f64::INFINITY, wall: 0, point: nowhere, rounding };
    let mut spent = Ok(());
    // The index draws for the walls that it finds; what the boxes take is drawn at the end.
    let mut count = 0;
    walls.nearest(&min, &max, budget, |index, wall| {
        for part in body.boxes() {
            count += 1;
            let (low, high) = wall.bounds();
            // The Minkowski sum of wall and reflected body, and a lower bound by boxes.
            let (low, high) = (low - part.max(), high - part.min());
            let apart = distance_squared_box_box((&low, &high), (&least, &greatest));
            // Slightly less, as rounding must not put it above the distance.
            if apart * (1.0 - 1e-12) > nearest.reach() * nearest.reach() {
                continue;
            }
            if body.outline.is_empty() && (D != 2 || wall.is_axis_parallel()) {
                let closest = distance_segment_box((from, to), (&low, &high));
                if closest.distance <= nearest.reach() {
                    let point = contact(part, wall, &(from + (to - from) * closest.at));
                    nearest.take(closest.distance, closest.at, index, point);
                }
            } else {
                let corners = corners(part);
                let outline = if body.outline.is_empty() { &corners } else { body.outline };
                spent = budget.step(STEPS_PER_EDGE * outline.len() as u64);
                if spent.is_err() {
                    return -1.0;
                }
                // In an overlap at the start no vertex need be near an edge.
                let touching =
                    (0..D).all(|axis| low[axis] <= from[axis] && from[axis] <= high[axis]);
                if touching && let Some(point) = overlap(outline, wall, from) {
                    nearest.take(0.0, 0.0, index, point);
                }
                outline_clearance(outline, (index, wall), (from, to), &mut nearest);
            }
        }
        nearest.reach()
    })?;
    budget.step(STEPS_PER_WALL * count)?;
    spent.map(|()| nearest)
}

/// The point of an axis-parallel wall nearest to the displaced box: along every axis the end
/// that faces it, or the middle of what both share.
fn contact<const D: usize>(
    part: &AxisBox<D>,
    wall: &Wall<D>,
    displacement: &Vector<D>,
) -> Vector<D> {
    let (min, max) = wall.bounds();
    let near = (part.min() + displacement).sup(&min).inf(&max);
    let far = (part.max() + displacement).inf(&max).sup(&min);
    (near + far) / 2.0
}

/// One wall in the plane against an outline: each vertex of either moves along a segment
/// relative to the other.
fn outline_clearance<const D: usize>(
    outline: &[Vector<2>],
    (index, wall): (usize, &Wall<D>),
    (from, to): (&Vector<D>, &Vector<D>),
    nearest: &mut Nearest<D>,
) {
    let (from, to) = (planar(from), planar(to));
    let (a, b) = (planar(&wall.from), planar(&wall.to));
    let (least, greatest) = (from.inf(&to), from.sup(&to));
    let (low, high) = (a.inf(&b), a.sup(&b));
    type Ends<'a> = (&'a Vector<2>, &'a Vector<2>);
    let mut take = |way: Ends<'_>, edge: Ends<'_>, end: Option<&Vector<2>>| {
        let closest = distance_segment_segment(way, edge);
        let point = spatial(end.unwrap_or(&closest.point));
        nearest.take(closest.distance, closest.at, index, point);
        nearest.reach()
    };
    // The first candidate counts in any case, others only if they may be nearer.
    let mut reach = f64::INFINITY;
    for (vertex, next) in polygon::edges(outline) {
        let swept = (&(vertex + least), &(vertex + greatest));
        if distance_squared_box_box(swept, (&low, &high)) <= reach * reach {
            reach = take((&(vertex + from), &(vertex + to)), (&a, &b), None);
        }
        let edge = (&vertex.inf(&next), &vertex.sup(&next));
        for end in [&a, &b] {
            let swept = (&(end - greatest), &(end - least));
            if distance_squared_box_box(swept, edge) <= reach * reach {
                reach = take((&(end - from), &(end - to)), (&vertex, &next), Some(end));
            }
        }
    }
}

/// A point of the wall inside or on the displaced outline.
fn overlap<const D: usize>(
    outline: &[Vector<2>],
    wall: &Wall<D>,
    displacement: &Vector<D>,
) -> Option<Vector<D>> {
    let displacement = planar(displacement);
    let (a, b) = (planar(&wall.from) - displacement, planar(&wall.to) - displacement);
    if polygon::contains(polygon::edges(outline), &a) {
        return Some(wall.from);
    }
    polygon::edges(outline).find_map(|(vertex, next)| {
        let closest = distance_segment_segment((&a, &b), (&vertex, &next));
        (closest.distance == 0.0).then(|| spatial(&(closest.point + displacement)))
    })
}

/// The point of the plane among `D` coordinates.
fn spatial<const D: usize>(point: &Vector<2>) -> Vector<D> {
    let mut spatial = Vector::zeros();
    (spatial[0], spatial[1]) = (point[0], point[1]);
    spatial
}

#[cfg(test)]
mod tests;
