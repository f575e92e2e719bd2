//! The free clearance of a motion: its clearance without what start and goal decide already.

use super::along_wall::{NearShape, PlacedRectangle};
use super::moving::Moving;
use super::segment::Rectangle;
use super::slide::{Slide, bounds};
use super::swing::Swing;
use super::{Footprint, Met, nearest, nearest_along};
use crate::budget::{Budget, Spent};
use crate::clearance::Clearance;
use crate::clearance::clothoid::PlacedClothoid;
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::{Vector, rotated, unit};
use crate::motion::{Curve, Leg, Pose};

/// By this part of the radius of its turning circle a body comes closer to a wall point than it
/// is at the start and at the goal, or the point does not bind the free clearance.
const BINDING: f64 = 1e-9;

/// The greatest error of the free clearance where a line on which the body also turns
/// decides it, metres.
pub const FREE_TURNING_WHILE_MOVING_BOUND: f64 = 1e-7;

/// Cost of a shape beside a wall, in looks at a wall.
const STEPS_PER_SHAPE: u64 = 8;

/// Legs whose nearest wall point does not bind that wait until the others are measured.
const WAITING: usize = 16;

/// The free clearance of the motion along `legs` between two poses: the largest c such that
/// the body keeps from every wall point at least the least of c, its distance at the start
/// and its distance at the goal. A robot that is docked at a wall does not hide the rest of
/// the way. `None` if no wall point binds: the free clearance is then infinite. The motion
/// must not touch a wall.
///
/// The result is the least distance over all pairs of a pose on the way and a wall point that
/// is closer there than at the start and at the goal, each in closed form: along a wall the
/// distances to the swept area of a line, to what a corner of the body sweeps on an arc, and
/// to both end poses are made of linear pieces and square roots, which are equal at the roots
/// of quadratic equations. Closer is closer by more than the [`binding_tolerance`]; with that
/// the result is exact to rounding, and to [`FREE_TURNING_WHILE_MOVING_BOUND`] where a line on
/// which the body turns decides. Where a clothoid does, it is less by no more than
/// [`PRECISION`](crate::clearance::clothoid::PRECISION) says.
///
/// The poses are those of the whole motion, of which the legs may be a part. `at` counts from
/// the start of the legs.
///
/// ```
/// use planning::budget::Budget;
/// use planning::clearance::rectangle::{Footprint, free_clearance};
/// use planning::free_space::walls::{Wall, Walls};
/// use planning::motion::{Curve, Leg, Pose};
///
/// // Docked 0.02 m ahead of a wall, the robot drives away between two others.
/// let robot = Footprint::new(1.0, 2.0)?;
/// let (start, goal) = ([1.02, 0.0].into(), [9.0, 0.0].into());
/// let curve = Curve::Line { from: start, to: goal, heading: 0.0, turned: 0.0 };
/// let legs = [Leg { curve, junction: None, rule: None, rung: None }];
/// let mut walls = Walls::default();
/// for (from, to) in [([0.0, -4.0], [0.0, 4.0]), ([3.0, 0.8], [7.0, 0.8])] {
///     walls.push(Wall { from: from.into(), to: to.into() });
/// }
/// let ends = [start, goal].map(|position| Pose { position, heading: 0.0 });
/// let free = free_clearance(&robot, &legs, &walls, &ends, &Budget::default())?;
/// assert!((free.expect("a wall binds").value - 0.3).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn free_clearance(
    footprint: &Footprint,
    legs: &[Leg<2>],
    walls: &Walls<2>,
    [start, goal]: &[Pose; 2],
    budget: &Budget<'_>,
) -> Result<Option<Clearance<2>>, Spent> {
    let tolerance = binding_tolerance(footprint, [start, goal]);
    let ends = [start, goal].map(|pose| {
        let body = placed(footprint, &pose.position, &unit(pose.heading));
        NearShape::Rectangle(body, tolerance)
    });
    let (value, wall) = (f64::INFINITY, Vector::zeros());
    let mut binding = Binding { ends, tolerance, value, wall, leg: 0, apart: 0.0 };
    // What decides is mostly a leg's nearest wall point. Only where that does not bind, as
    // beside the start, its walls are looked at one by one, best when the others have shown
    // how far to look.
    let (mut waiting, mut count) = ([0; WAITING], 0);
    nearest_along(footprint, legs, walls, budget, |index, met, _| {
        if met.value >= binding.value {
            return Ok(());
        }
        if met.value < binding.cap(&met.wall) {
            (binding.value, binding.wall, binding.leg) = (met.value, met.wall, index);
        } else if count < WAITING {
            waiting[count] = index;
            count += 1;
        } else {
            binding.look(footprint, (index, &legs[index].curve), walls, budget)?;
        }
        Ok::<_, Spent>(())
    })?;
    for &index in &waiting[..count] {
        binding.look(footprint, (index, &legs[index].curve), walls, budget)?;
    }
    if binding.value == f64::INFINITY {
        return Ok(None);
    }
    let before: f64 = legs[..binding.leg].iter().map(|leg| leg.curve.length()).sum();
    let curve = &legs[binding.leg].curve;
    let met = meet_point(footprint, curve, &binding.wall, budget)?;
    let at = before + met.along * curve.length();
    Ok(Some(Clearance { value: binding.value, at, wall: binding.wall }))
}

/// A wall point binds the free clearance only if the body comes closer to it than it is at
/// the start and at the goal by more than this, metres: 1e-9 of the radius of its turning circle,
/// or what coordinates far from the origin are rounded by.
pub fn binding_tolerance(footprint: &Footprint, ends: [&Pose; 2]) -> f64 {
    let farthest = ends[0].position.amax().max(ends[1].position.amax());
    (BINDING * footprint.swing_radius()).max(8.0 * f64::EPSILON * farthest)
}

/// The least distance found that binds.
struct Binding {
    /// The body at the start and at the goal, whose distances count less by the tolerance.
    ends: [NearShape; 2],
    tolerance: f64,
    value: f64,
    wall: Vector<2>,
    leg: usize,
    /// How far the leg looked at stays from the walls, metres.
    apart: f64,
}

impl Binding {
    /// What a distance of this wall point must be less than to bind.
    fn cap(&self, point: &Vector<2>) -> f64 {
        self.ends[0].distance(point).min(self.ends[1].distance(point))
    }

    /// Looks for lesser distances over one leg.
    fn look(
        &mut self,
        footprint: &Footprint,
        (leg, curve): (usize, &Curve<2>),
        walls: &Walls<2>,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let before = self.value;
        match *curve {
            Curve::Line { from, to, heading, turned } if turned != 0.0 => {
                let moving = Moving::new(footprint, &from, &to, heading, turned);
                self.apart = nearest(footprint, curve, walls, 0.0, budget)?.value;
                for part in 0..=SAMPLES {
                    let body = moving.body_at(f64::from(part) / f64::from(SAMPLES));
                    self.near(&[NearShape::Rectangle(body, 0.0)], body.bounds(), walls, budget)?;
                }
                self.look_while_turning(&moving, (0.0, 1.0), walls, budget)?;
            }
            Curve::Line { from, to, heading, .. } => {
                let slide = Slide::new(footprint, (&from, &to), heading, curve.is_reverse());
                let shapes = [NearShape::Rectangle(slide.swept(), 0.0)];
                self.near(&shapes, slide.bounds(), walls, budget)?;
            }
            Curve::Arc { center, radius, start_angle, sweep, reverse } => {
                let arc = (&center, radius, start_angle, sweep);
                let swing = Swing::on_arc(footprint, arc, reverse);
                self.near(&swing.shapes(), swing.bounds(), walls, budget)?;
            }
            Curve::Clothoid { .. } => self.look_along_clothoid(footprint, curve, walls, budget)?,
            Curve::Turn { position, from_heading, sweep } => {
                let swing = Swing::in_place(footprint, &position, from_heading, sweep);
                self.near(&swing.shapes(), swing.bounds(), walls, budget)?;
            }
        }
        if self.value < before {
            self.leg = leg;
        }
        Ok(())
    }

    /// Bisects a line on which the body turns until no part can hold much less, or the body
    /// moves by no more than the tolerance.
    ///
    /// No point of the body strays farther from its chord over a part than `bend`. What a side
    /// sweeps along chords ends at both its places and at the chords of its ends, or where the
    /// chords of its points run along itself. There it is within `slid` * `turned` / cos(`turned`
    /// / 2) of one of the others, the angle turned over the part and the way of the body's
    /// fastest point: a point of the side that has come to the same place along it before is
    /// on another place of the side, turned by less, or past its end, on the end's chord. So but
    /// for these two, which shrink with the square of the part, a wall point is as near to
    /// what the body sweeps as to its places at both ends and to the chords of its corners. None
    /// is inside: the body stays `apart` from the walls by more than the bend.
    fn look_while_turning(
        &mut self,
        moving: &Moving,
        (low, high): (f64, f64),
        walls: &Walls<2>,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let part = high - low;
        let bend = moving.bend() * part * part / 8.0;
        let (slid, turned) = (moving.fastest() * part, moving.turned() * part);
        if slid <= self.tolerance {
            return Ok(());
        }
        if bend < self.apart && turned < 1.0 {
            // 1 / cos(0.5) is 1.14.
            let less = bend + 1.2 * slid * turned;
            let bodies = [moving.body_at(low), moving.body_at(high)];
            let [before, after] = bodies.map(|body| body.corners());
            let mut shapes = [NearShape::Rectangle(bodies[0], less); 6];
            shapes[1] = NearShape::Rectangle(bodies[1], less);
            for corner in 0..4 {
                let chord = PlacedRectangle::between(&before[corner], &after[corner]);
                shapes[2 + corner] = NearShape::Rectangle(chord, less);
            }
            let limit = self.value - FREE_TURNING_WHILE_MOVING_BOUND;
            let mut bound = Self { value: limit, ..*self };
            let [(low, high), (other_low, other_high)] = bodies.map(|body| body.bounds());
            let around = (low.inf(&other_low), high.sup(&other_high));
            bound.near(&shapes, around, walls, budget)?;
            if bound.value >= limit {
                return Ok(());
            }
        }
        let middle = low + part / 2.0;
        let body = moving.body_at(middle);
        self.near(&[NearShape::Rectangle(body, 0.0)], body.bounds(), walls, budget)?;
        self.look_while_turning(moving, (low, middle), walls, budget)?;
        self.look_while_turning(moving, (middle, high), walls, budget)
    }

    /// Looks for lesser distances along the arcs that osculate a clothoid, which are told by how
    /// much less they count.
    ///
    /// On the clothoid a wall point may be nearer by `less`, so it may bind if on the arc it is no
    /// farther than at the ends by that.
    fn look_along_clothoid(
        &mut self,
        footprint: &Footprint,
        curve: &Curve<2>,
        walls: &Walls<2>,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let Some(clothoid) = PlacedClothoid::of(curve) else { return Ok(()) };
        let (bound, ends) = ((footprint.swing_radius(), self.value, f64::NEG_INFINITY), self.ends);
        let found = clothoid.least(bound, |arc, less| {
            let ends = ends.map(|end| end.less_by(less));
            let mut near = Self { ends, value: self.value + less, ..*self };
            near.look(footprint, (near.leg, arc), walls, budget)?;
            Ok(Clearance { value: near.value, at: 0.0, wall: near.wall })
        })?;
        if found.value < self.value {
            (self.value, self.wall) = (found.value, found.wall);
        }
        Ok(())
    }

    /// Looks for lesser distances from shapes within a box, of which those that count less
    /// are last.
    fn near(
        &mut self,
        shapes: &[NearShape],
        (min, max): (Vector<2>, Vector<2>),
        walls: &Walls<2>,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let less = shapes.iter().map(NearShape::less).fold(0.0, f64::max);
        let mut spent = Ok(());
        walls.nearest(&min, &max, budget, |_, wall| {
            spent = budget.step(STEPS_PER_SHAPE * shapes.len() as u64);
            if spent.is_err() {
                return -1.0;
            }
            for shape in shapes {
                self.beside(shape, wall);
            }
            self.value + less
        })?;
        spent
    }

    /// Looks for a lesser distance between a shape and the points of a wall that bind.
    fn beside(&mut self, shape: &NearShape, wall: &Wall<2>) {
        let span = wall.to - wall.from;
        let length = span.dot(&span).sqrt();
        if length == 0.0 {
            let value = shape.distance(&wall.from);
            if value < self.value && value < self.cap(&wall.from) {
                (self.value, self.wall) = (value, wall.from);
            }
            return;
        }
        let along = span / length;
        // Of the shape and of both ends, four each, and the ends of the wall.
        let mut cuts = Cuts::<14>::between(0.0, length);
        for shape in [shape, &self.ends[0], &self.ends[1]] {
            shape.cuts(&wall.from, &along, |place| cuts.push(place));
        }
        for [low, high] in cuts.parts() {
            let middle = low + (high - low) / 2.0;
            let at = wall.from + along * middle;
            let (low, high) = (low - middle, high - middle);
            if shape.distance(&at) == f64::INFINITY {
                continue;
            }
            let law = shape.law(&at, &along);
            let lowest = law.lowest(low, high);
            let value = law.at(lowest);
            if value >= self.value {
                continue;
            }
            let caps = [0, 1].map(|end| self.ends[end].law(&at, &along));
            // Where the least of all binds, it is the least that does.
            if low < lowest && lowest < high && value < caps[0].at(lowest).min(caps[1].at(lowest)) {
                (self.value, self.wall) = (value, at + along * lowest);
                continue;
            }
            let mut cuts = Cuts::<6>::between(low, high);
            for cap in &caps {
                law.crossings(cap, (low, high), |place| cuts.push(place));
            }
            for [low, high] in cuts.parts() {
                let lowest = law.lowest(low, high);
                let value = law.at(lowest);
                // The order of the distances is the same all over the part.
                let inside = low + (high - low) / 2.0;
                let cap = caps[0].at(inside).min(caps[1].at(inside));
                if value < self.value && law.at(inside) < cap {
                    (self.value, self.wall) = (value, at + along * lowest);
                }
            }
        }
    }
}

/// Poses looked at first on a line on which the body turns.
const SAMPLES: u32 = 16;

/// Places in an interval, in order.
struct Cuts<const MOST: usize> {
    places: [f64; MOST],
    count: usize,
}

impl<const MOST: usize> Cuts<MOST> {
    fn between(low: f64, high: f64) -> Self {
        let mut places = [high; MOST];
        places[0] = low;
        Self { places, count: 2 }
    }

    /// Adds a place if it lies inside.
    fn push(&mut self, place: f64) {
        let (low, high) = (self.places[0], self.places[self.count - 1]);
        if low < place && place < high && self.count < MOST {
            let mut index = self.count;
            while self.places[index - 1] > place {
                self.places[index] = self.places[index - 1];
                index -= 1;
            }
            self.places[index] = place;
            self.count += 1;
        }
    }

    /// The intervals between neighbours.
    fn parts(&self) -> impl Iterator<Item = [f64; 2]> {
        self.places[..self.count].windows(2).map(|pair| [pair[0], pair[1]])
    }
}

/// The body at a pose.
pub(super) fn placed(
    footprint: &Footprint,
    position: &Vector<2>,
    heading: &Vector<2>,
) -> PlacedRectangle {
    PlacedRectangle { origin: *position, heading: *heading, shape: footprint.rectangle() }
}

impl PlacedRectangle {
    /// The segment between two points.
    fn between(a: &Vector<2>, b: &Vector<2>) -> Self {
        let span = b - a;
        let length = span.dot(&span).sqrt();
        let heading = if length > 0.0 { span / length } else { Vector::<2>::new(1.0, 0.0) };
        let middle = Vector::<2>::new(length / 2.0, 0.0);
        Self { origin: *a, heading, shape: Rectangle { center: middle, half: middle } }
    }

    fn corners(&self) -> [Vector<2>; 4] {
        self.shape.corners().map(|corner| self.origin + rotated(&corner, &self.heading))
    }

    /// A box around it.
    fn bounds(&self) -> (Vector<2>, Vector<2>) {
        let center = rotated(&self.shape.center, &self.heading);
        bounds(&(self.origin + center), &self.heading, &self.shape.half)
    }
}

/// How a curve meets a single wall point.
fn meet_point(
    footprint: &Footprint,
    curve: &Curve<2>,
    point: &Vector<2>,
    budget: &Budget<'_>,
) -> Result<Met, Spent> {
    let wall = Wall { from: *point, to: *point };
    let mut met = Met::NOTHING;
    match *curve {
        Curve::Line { from, to, heading, turned } if turned != 0.0 => {
            Moving::new(footprint, &from, &to, heading, turned).meet(&wall, &mut met, budget)?;
        }
        Curve::Line { from, to, heading, .. } => {
            let reverse = curve.is_reverse();
            Slide::new(footprint, (&from, &to), heading, reverse).meet(&wall, &mut met);
        }
        Curve::Arc { center, radius, start_angle, sweep, reverse } => {
            let arc = (&center, radius, start_angle, sweep);
            Swing::on_arc(footprint, arc, reverse).meet(&wall, &mut met);
        }
        Curve::Clothoid { .. } => {
            let Some(clothoid) = PlacedClothoid::of(curve) else { return Ok(met) };
            let bound = (footprint.swing_radius(), f64::INFINITY, f64::NEG_INFINITY);
            let found = clothoid.least(bound, |arc, _| {
                budget.step(STEPS_PER_SHAPE)?;
                let Met { value, along, wall, .. } = meet_point(footprint, arc, point, budget)?;
                Ok(Clearance { value, at: along, wall })
            })?;
            met.offer(found.value, found.at, found.wall);
        }
        Curve::Turn { position, from_heading, sweep } => {
            Swing::in_place(footprint, &position, from_heading, sweep).meet(&wall, &mut met);
        }
    }
    Ok(met)
}

#[cfg(test)]
mod tests;
