//! A body that slides along its heading: the swept set is a longer rectangle.

use super::segment::{Rectangle, Segment};
use super::{Footprint, Met, TIE};
use crate::free_space::walls::Wall;
use crate::geometry::{Vector, unit};

/// A line travelled along the heading; of length 0, a body at rest.
pub(super) struct Slide {
    from: Vector<2>,
    heading: Vector<2>,
    length: f64,
    half_length: f64,
    /// The swept set in the frame at `from` with its x axis along the heading.
    swept: Rectangle,
}

impl Slide {
    pub(super) fn new(
        footprint: &Footprint,
        from: &Vector<2>,
        to: &Vector<2>,
        heading: f64,
    ) -> Self {
        let length = (to - from).dot(&(to - from)).sqrt();
        let (a, b) = (footprint.length / 2.0, footprint.width / 2.0);
        Self {
            from: *from,
            heading: unit(heading),
            length,
            half_length: a,
            swept: Rectangle {
                center: Vector::<2>::new(length / 2.0, 0.0),
                half: Vector::<2>::new(a + length / 2.0, b),
            },
        }
    }

    /// A box around the swept set.
    pub(super) fn bounds(&self) -> (Vector<2>, Vector<2>) {
        bounds(&(self.from + self.heading * self.swept.center.x), &self.heading, &self.swept.half)
    }

    pub(super) fn meet(&self, wall: &Wall<2>, met: &mut Met) {
        let segment = Segment::seen(wall, &self.from, &self.heading);
        segment.meet(&self.swept, met.value + TIE, |distance, t| {
            // The wall point is nearest from when the front edge reaches it.
            let ahead = segment.at(t).x - self.half_length;
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
