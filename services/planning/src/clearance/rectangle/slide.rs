//! A body that slides along its heading: the swept set is a longer rectangle.

use super::along_wall::PlacedRectangle;
use super::segment::{Rectangle, Segment};
use super::{Footprint, Met, TIE};
use crate::free_space::walls::Wall;
use crate::geometry::{Sign, Vector, unit};

/// A line travelled along the heading or against it; of length 0, a body at rest.
pub(super) struct Slide {
    from: Vector<2>,
    heading: Vector<2>,
    length: f64,
    /// The sense of travel along the heading.
    sense: Sign,
    /// From the reference point to the edge that leads.
    lead: f64,
    /// The swept set in the frame at `from` with its x axis along the heading.
    swept: Rectangle,
}

impl Slide {
    pub(super) fn new(
        footprint: &Footprint,
        (from, to): (&Vector<2>, &Vector<2>),
        heading: f64,
        reverse: bool,
    ) -> Self {
        let length = (to - from).dot(&(to - from)).sqrt();
        let body = footprint.rectangle();
        let (sense, lead) = if reverse {
            (Sign::Negative, footprint.rear)
        } else {
            (Sign::Positive, footprint.front)
        };
        let half = length / 2.0;
        Self {
            from: *from,
            heading: unit(heading),
            length,
            sense,
            lead,
            swept: Rectangle {
                center: Vector::<2>::new(body.center.x + sense.factor() * half, 0.0),
                half: Vector::<2>::new(body.half.x + half, body.half.y),
            },
        }
    }

    /// A box around the swept set.
    pub(super) fn bounds(&self) -> (Vector<2>, Vector<2>) {
        bounds(&(self.from + self.heading * self.swept.center.x), &self.heading, &self.swept.half)
    }

    /// The swept set.
    pub(super) fn swept(&self) -> PlacedRectangle {
        PlacedRectangle { origin: self.from, heading: self.heading, shape: self.swept }
    }

    pub(super) fn meet(&self, wall: &Wall<2>, met: &mut Met) {
        let segment = Segment::seen(wall, &self.from, &self.heading);
        segment.meet(&self.swept, met.value + TIE, |distance, t| {
            // The wall point is nearest from when the leading edge reaches it.
            let ahead = self.sense.factor() * segment.at(t).x - self.lead;
            let along = if ahead <= 0.0 { 0.0 } else { (ahead / self.length).min(1.0) };
            met.offer(distance, along, wall.from + (wall.to - wall.from) * t);
        });
    }
}

/// A box around the rectangle with these half sides, its x axis along `heading`.
pub(super) fn bounds(
    center: &Vector<2>,
    heading: &Vector<2>,
    half: &Vector<2>,
) -> (Vector<2>, Vector<2>) {
    let (cos, sin) = (heading.x.abs(), heading.y.abs());
    let extent = Vector::<2>::new(cos * half.x + sin * half.y, sin * half.x + cos * half.y);
    (center - extent, center + extent)
}
