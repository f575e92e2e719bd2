//! A body that turns while it moves on a line, as the paper's robot does on the way to the
//! first arriving point.

use super::along_wall::PlacedRectangle;
use super::segment::{Rectangle, Segment};
use super::{Footprint, Met, TURNING_WHILE_MOVING_BOUND};
use crate::budget::{Budget, Spent};
use crate::free_space::walls::Wall;
use crate::geometry::distance::{distance_segment_box, distance_segment_segment};
use crate::geometry::{Vector, rotated, unit, unrotated};

/// A line on which the heading turns evenly. Progress runs from 0 to 1.
///
/// The search bisects the progress until no part can hold a distance that is less than the
/// least one seen by more than [`TURNING_WHILE_MOVING_BOUND`]. Two bounds hold on each
/// part:
///
/// 1. No point of the body moves farther than (length + reach * |turned|) per unit of
///    progress, the reach being that of its corners from the reference point.
/// 2. A point with second derivative at most m stays within m delta^2 / 8 of its
///    chord over a part of size delta. Body corners have m = reach * turned^2 in the
///    wall's frame; a wall end at most r from the reference point has
///    m = r turned^2 + 2 |turned| length in the body's frame. The distance of a chord
///    to the (convex) wall or body is exact, and while body and wall are apart a
///    corner of one of them is nearest.
pub(super) struct Moving {
    from: Vector<2>,
    travel: Vector<2>,
    length: f64,
    start_heading: f64,
    turned: f64,
    body: Rectangle,
    /// Of the body's corners from the reference point.
    reach: f64,
}

/// Distances are rounded by up to this part of the coordinates.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Steps that placing the body half-way and bounding the distances on both sides take.
const STEPS_PER_PART: u64 = 24;

/// The body at one moment, with what the bounds need.
struct Placed {
    progress: f64,
    /// Body corners in the wall's frame.
    corners: [Vector<2>; 4],
    /// Wall ends in the body's frame.
    ends: [Vector<2>; 2],
    distance: f64,
}

impl Moving {
    pub(super) fn new(
        footprint: &Footprint,
        from: &Vector<2>,
        to: &Vector<2>,
        heading: f64,
        turned: f64,
    ) -> Self {
        let travel = to - from;
        Self {
            from: *from,
            travel,
            length: travel.dot(&travel).sqrt(),
            start_heading: heading - turned,
            turned,
            body: footprint.rectangle(),
            reach: footprint.swing_radius(),
        }
    }

    /// A box around the swept set.
    pub(super) fn bounds(&self) -> (Vector<2>, Vector<2>) {
        let to = self.from + self.travel;
        let extent = Vector::<2>::new(self.reach, self.reach);
        (self.from.inf(&to) - extent, self.from.sup(&to) + extent)
    }

    /// The body at this progress.
    pub(super) fn body_at(&self, progress: f64) -> PlacedRectangle {
        PlacedRectangle {
            origin: self.from + self.travel * progress,
            heading: unit(self.start_heading + self.turned * progress),
            shape: self.body,
        }
    }

    /// The most of a second derivative of a point of the body by the progress, metres.
    pub(super) fn bend(&self) -> f64 {
        self.reach * self.turned * self.turned
    }

    /// The angle turned, without its sign.
    pub(super) fn turned(&self) -> f64 {
        self.turned.abs()
    }

    /// No point of the body moves farther per unit of progress, metres.
    pub(super) fn fastest(&self) -> f64 {
        self.length + self.reach * self.turned()
    }

    pub(super) fn meet(
        &self,
        wall: &Wall<2>,
        met: &mut Met,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let start = self.placed(wall, 0.0, met);
        let end = self.placed(wall, 1.0, met);
        let farthest =
            start.ends.iter().chain(&end.ends).map(|end| end.dot(end)).fold(0.0, f64::max);
        let turned = self.turned.abs();
        let size = self.from.amax().max(wall.from.amax()).max(wall.to.amax());
        let size = size.max(self.length).max(self.reach);
        let bend = Bend {
            bound: TURNING_WHILE_MOVING_BOUND.max(ROUNDING * size),
            corner: self.reach * turned * turned,
            end: farthest.sqrt() * turned * turned + 2.0 * turned * self.length,
        };
        self.refine(wall, (&start, &end), &bend, met, budget)
    }

    /// Looks for smaller distances between two placements.
    fn refine(
        &self,
        wall: &Wall<2>,
        (a, b): (&Placed, &Placed),
        bend: &Bend,
        met: &mut Met,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        budget.step(STEPS_PER_PART)?;
        let enough = met.value - bend.bound;
        let part = b.progress - a.progress;
        let first_touch_is_known = met.value == 0.0 && met.along <= a.progress;
        let speed = self.fastest();
        if first_touch_is_known || (a.distance + b.distance - speed * part) / 2.0 >= enough {
            return Ok(());
        }
        let mut corners = f64::INFINITY;
        for chord in a.corners.iter().zip(&b.corners) {
            let closest = distance_segment_segment(chord, (&wall.from, &wall.to));
            corners = corners.min(closest.distance);
        }
        let (low, high) = (self.body.center - self.body.half, self.body.center + self.body.half);
        let mut ends = f64::INFINITY;
        for chord in a.ends.iter().zip(&b.ends) {
            ends = ends.min(distance_segment_box(chord, (&low, &high)).distance);
        }
        let eighth = part * part / 8.0;
        if (corners - bend.corner * eighth).min(ends - bend.end * eighth) >= enough {
            return Ok(());
        }
        let middle = a.progress + part / 2.0;
        if !(a.progress < middle && middle < b.progress) {
            // Two neighbouring numbers: nothing lies between.
            return Ok(());
        }
        let middle = self.placed(wall, middle, met);
        self.refine(wall, (a, &middle), bend, met, budget)?;
        self.refine(wall, (&middle, b), bend, met, budget)
    }

    /// Places the body at this progress and offers its distance.
    fn placed(&self, wall: &Wall<2>, progress: f64, met: &mut Met) -> Placed {
        let position = self.from + self.travel * progress;
        let heading = unit(self.start_heading + self.turned * progress);
        let segment = Segment::seen(wall, &position, &heading);
        let (mut distance, mut nearest) = (f64::INFINITY, 0.0);
        segment.meet(&self.body, f64::INFINITY, |candidate, t| {
            if candidate < distance {
                (distance, nearest) = (candidate, t);
            }
        });
        met.offer(distance, progress, wall.from + (wall.to - wall.from) * nearest);
        Placed {
            progress,
            corners: self.body.corners().map(|corner| position + rotated(&corner, &heading)),
            ends: [wall.from, wall.to].map(|end| unrotated(&(end - position), &heading)),
            distance,
        }
    }
}

/// The bound of the error, and bounds of second derivatives by progress, metres.
struct Bend {
    /// How much less than found a distance may be.
    bound: f64,
    /// Of the body's corners in the wall's frame.
    corner: f64,
    /// Of the wall's ends in the body's frame.
    end: f64,
}
