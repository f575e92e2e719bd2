//! Distances between a rectangle, a segment and points, in the rectangle's frame.

use crate::free_space::walls::Wall;
use crate::geometry::distance::cross;
use crate::geometry::{Vector, unrotated};

/// A rectangle whose sides are parallel to the axes of its frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rectangle {
    pub(super) center: Vector<2>,
    /// Half of its sides.
    pub(super) half: Vector<2>,
}

impl Rectangle {
    pub(super) fn corners(&self) -> [Vector<2>; 4] {
        let (low, high) = (self.center - self.half, self.center + self.half);
        [low, Vector::<2>::new(low.x, high.y), Vector::<2>::new(high.x, low.y), high]
    }

    /// Distance from a point; 0 inside.
    pub(super) fn distance(&self, point: &Vector<2>) -> f64 {
        let dx = ((point.x - self.center.x).abs() - self.half.x).max(0.0);
        let dy = ((point.y - self.center.y).abs() - self.half.y).max(0.0);
        (dx * dx + dy * dy).sqrt()
    }
}

/// A wall in some frame: the points `from + t span` for t in [0, 1].
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    pub(super) from: Vector<2>,
    pub(super) span: Vector<2>,
    /// 1 / |span|; 0 for a point.
    pub(super) inverse_length: f64,
}

impl Segment {
    pub(super) fn between(from: Vector<2>, to: Vector<2>) -> Self {
        let span = to - from;
        let length = span.dot(&span).sqrt();
        Self { from, span, inverse_length: if length > 0.0 { 1.0 / length } else { 0.0 } }
    }

    /// The wall in the frame at `origin` with its x axis along `heading`.
    pub(super) fn seen(wall: &Wall<2>, origin: &Vector<2>, heading: &Vector<2>) -> Self {
        Self::between(
            unrotated(&(wall.from - origin), heading),
            unrotated(&(wall.to - origin), heading),
        )
    }

    pub(super) fn at(&self, t: f64) -> Vector<2> {
        self.from + self.span * t
    }

    /// The same segment rotated back by the angle of the unit vector `by`.
    pub(super) fn unrotated(&self, by: &Vector<2>) -> Self {
        Self {
            from: unrotated(&self.from, by),
            span: unrotated(&self.span, by),
            inverse_length: self.inverse_length,
        }
    }

    /// Parameter of the foot of the perpendicular from `point`; may lie outside [0, 1].
    pub(super) fn foot(&self, point: &Vector<2>) -> f64 {
        (point - self.from).dot(&self.span) * self.inverse_length * self.inverse_length
    }

    /// Offers candidates for the least distance between this segment and the rectangle, each
    /// as (distance, parameter), unless it exceeds `limit`.
    pub(super) fn meet(&self, body: &Rectangle, limit: f64, mut offer: impl FnMut(f64, f64)) {
        let from = self.from - body.center;
        let to = from + self.span;
        let dx = from.x.min(to.x).max(-from.x.max(to.x)) - body.half.x;
        let dy = from.y.min(to.y).max(-from.y.max(to.y)) - body.half.y;
        let (dx, dy) = (dx.max(0.0), dy.max(0.0));
        if dx * dx + dy * dy > limit * limit {
            return;
        }
        if dx == 0.0
            && dy == 0.0
            && let Some((enters, leaves)) = clip(&from, &self.span, &body.half)
        {
            offer(0.0, enters);
            offer(0.0, leaves);
            return;
        }
        offer(body.distance(&self.from), 0.0);
        offer(body.distance(&(self.from + self.span)), 1.0);
        for corner in body.corners() {
            let t = self.foot(&corner);
            if 0.0 < t && t < 1.0 {
                let apart = corner - self.from;
                offer(cross(&self.span, &apart).abs() * self.inverse_length, t);
            }
        }
    }
}

/// The part of `from + t span` in the rectangle about the origin, as an interval of t.
fn clip(from: &Vector<2>, span: &Vector<2>, half: &Vector<2>) -> Option<(f64, f64)> {
    let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let (from, span, half) = (from[axis], span[axis], half[axis]);
        if span == 0.0 {
            if from.abs() > half {
                return None;
            }
            continue;
        }
        let (one, other) = ((-half - from) / span, (half - from) / span);
        enters = enters.max(one.min(other));
        leaves = leaves.min(one.max(other));
    }
    (enters <= leaves).then_some((enters, leaves))
}
