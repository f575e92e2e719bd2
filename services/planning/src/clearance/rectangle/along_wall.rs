//! Distances from the points of a wall to shapes, as functions of the place on the wall.
//!
//! Along a straight wall the distance to a rectangle, or to a circle, is made of pieces that
//! are linear in the place or the root of a square polynomial. Places where two such pieces
//! are equal have a closed form.

use super::segment::Rectangle;
use crate::geometry::distance::cross;
use crate::geometry::{Vector, unrotated};

/// A rectangle in the plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedRectangle {
    pub(super) origin: Vector<2>,
    pub(super) heading: Vector<2>,
    /// In the frame at the origin with its x axis along the heading.
    pub(super) shape: Rectangle,
}

impl PlacedRectangle {
    fn local(&self, point: &Vector<2>) -> Vector<2> {
        unrotated(&(point - self.origin), &self.heading)
    }

    pub(super) fn distance(&self, point: &Vector<2>) -> f64 {
        self.shape.distance(&self.local(point))
    }
}

/// The points from an angle to another, seen from a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sector {
    /// Unit vector in its middle.
    pub(super) middle: Vector<2>,
    /// Unit vector at half of its angle.
    pub(super) half: Vector<2>,
}

/// Something that a wall point may be near to.
#[derive(Debug, Clone, Copy)]
pub(super) enum NearShape {
    /// A rectangle, and a distance that counts less.
    Rectangle(PlacedRectangle, f64),
    /// The outside of a circle about a point, within a sector: what a corner of the body
    /// that runs on it comes to as it passes.
    Outside(Vector<2>, f64, Sector),
    /// The inside of one: what an edge of the body that is tangent to it comes to.
    Inside(Vector<2>, f64, Sector),
}

impl NearShape {
    /// The distance that counts; infinite where the shape does not apply.
    pub(super) fn distance(&self, point: &Vector<2>) -> f64 {
        match self {
            Self::Rectangle(rectangle, less) => rectangle.distance(point) - less,
            Self::Outside(center, radius, sector) => {
                let arm = point - center;
                let beyond = arm.dot(&arm).sqrt() - radius;
                if beyond >= 0.0 && sector.holds(&arm) { beyond } else { f64::INFINITY }
            }
            Self::Inside(center, radius, sector) => {
                let arm = point - center;
                let within = radius - arm.dot(&arm).sqrt();
                if within >= 0.0 && sector.holds(&arm) { within } else { f64::INFINITY }
            }
        }
    }

    /// The same shape, a rectangle farther away by this.
    pub(super) fn less_by(self, by: f64) -> Self {
        match self {
            Self::Rectangle(rectangle, less) => Self::Rectangle(rectangle, less - by),
            other => other,
        }
    }

    /// How much less than it is the distance counts.
    pub(super) fn less(&self) -> f64 {
        if let Self::Rectangle(_, less) = self { *less } else { 0.0 }
    }

    /// Calls `cut` with the places on the line `from + place * along` between which the
    /// distance is one formula.
    pub(super) fn cuts(&self, from: &Vector<2>, along: &Vector<2>, mut cut: impl FnMut(f64)) {
        match self {
            Self::Rectangle(rectangle, _) => {
                let from = rectangle.local(from) - rectangle.shape.center;
                let along = unrotated(along, &rectangle.heading);
                for axis in 0..2 {
                    for side in [rectangle.shape.half[axis], -rectangle.shape.half[axis]] {
                        cut((side - from[axis]) / along[axis]);
                    }
                }
            }
            Self::Outside(center, radius, sector) | Self::Inside(center, radius, sector) => {
                let arm = from - center;
                let foot = -arm.dot(along);
                let across = cross(&arm, along);
                let chord = (radius * radius - across * across).sqrt();
                cut(foot - chord);
                cut(foot + chord);
                for ray in sector.rays() {
                    cut(-cross(&ray, &arm) / cross(&ray, along));
                }
            }
        }
    }

    /// The formula of the distance about the point `at` of a line along a unit vector, by the
    /// place from there.
    pub(super) fn law(&self, at: &Vector<2>, along: &Vector<2>) -> DistanceLaw {
        match self {
            Self::Rectangle(rectangle, less) => {
                let Rectangle { center, half } = rectangle.shape;
                let at = rectangle.local(at) - center;
                let along = unrotated(along, &rectangle.heading);
                let beyond = [0, 1].map(|axis| at[axis].abs() > half[axis]);
                let corner = Vector::<2>::new(half.x.copysign(at.x), half.y.copysign(at.y));
                match beyond {
                    [true, true] => DistanceLaw::root(&(at - corner), &along, -less, 1.0),
                    [false, false] => DistanceLaw::Linear { at: -less, slope: 0.0 },
                    [x, _] => {
                        let axis = usize::from(!x);
                        let sign = 1.0_f64.copysign(at[axis]);
                        DistanceLaw::Linear {
                            at: at[axis].abs() - half[axis] - less,
                            slope: sign * along[axis],
                        }
                    }
                }
            }
            Self::Outside(center, radius, _) => {
                DistanceLaw::root(&(at - center), along, -radius, 1.0)
            }
            Self::Inside(center, radius, _) => {
                DistanceLaw::root(&(at - center), along, *radius, -1.0)
            }
        }
    }
}

impl Sector {
    fn holds(&self, arm: &Vector<2>) -> bool {
        let turn = unrotated(arm, &self.middle);
        turn.x >= self.half.x * arm.dot(arm).sqrt()
    }

    fn rays(&self) -> [Vector<2>; 2] {
        let conjugate = Vector::<2>::new(self.half.x, -self.half.y);
        [self.half, conjugate].map(|turn| crate::geometry::rotated(&self.middle, &turn))
    }
}

/// A distance by the place on a line.
#[derive(Debug, Clone, Copy)]
pub(super) enum DistanceLaw {
    /// `at + slope * place`.
    Linear { at: f64, slope: f64 },
    /// `add + sign * sqrt((place - foot)^2 + square)`.
    Root { foot: f64, square: f64, add: f64, sign: f64 },
}

impl DistanceLaw {
    fn root(arm: &Vector<2>, along: &Vector<2>, add: f64, sign: f64) -> Self {
        let across = cross(arm, along);
        Self::Root { foot: -arm.dot(along), square: across * across, add, sign }
    }

    /// The place of the least distance between two places.
    pub(super) fn lowest(&self, low: f64, high: f64) -> f64 {
        match *self {
            Self::Linear { slope, .. } if slope < 0.0 => high,
            Self::Linear { .. } => low,
            Self::Root { foot, sign, .. } if sign > 0.0 => foot.max(low).min(high),
            Self::Root { foot, .. } if foot - low > high - foot => low,
            Self::Root { .. } => high,
        }
    }

    pub(super) fn at(&self, place: f64) -> f64 {
        match *self {
            Self::Linear { at, slope } => at + slope * place,
            Self::Root { foot, square, add, sign } => {
                let beside = place - foot;
                add + sign * (beside * beside + square).sqrt()
            }
        }
    }

    fn slope(&self, place: f64) -> f64 {
        match *self {
            Self::Linear { slope, .. } => slope,
            Self::Root { foot, square, sign, .. } => {
                let beside = place - foot;
                let root = (beside * beside + square).sqrt();
                if root > 0.0 { sign * beside / root } else { 0.0 }
            }
        }
    }

    /// Calls `found` with at least every place between `low` and `high` where two distances
    /// cross.
    pub(super) fn crossings(
        &self,
        other: &Self,
        (low, high): (f64, f64),
        mut found: impl FnMut(f64),
    ) {
        // Rounding does not move a crossing that far.
        let margin = high - low;
        let mut root = |place: f64| {
            if !(low - margin < place && place < high + margin) {
                return;
            }
            let place = self.polished(other, place);
            if low < place && place < high {
                found(place);
            }
        };
        match (*self, *other) {
            (Self::Linear { at, slope }, Self::Linear { at: b, slope: k }) => {
                root((b - at) / (slope - k));
            }
            (Self::Root { foot, square, add, .. }, Self::Linear { at, slope })
            | (Self::Linear { at, slope }, Self::Root { foot, square, add, .. }) => {
                // With t from the foot, t^2 + square = (rest + slope t)^2.
                let rest = at - add + slope * foot;
                let lead = (1.0 - slope) * (1.0 + slope);
                let discriminant = rest * rest - lead * square;
                let last = square - rest * rest;
                quadratic(lead, -rest * slope, last, discriminant, |t| root(foot + t));
            }
            (
                Self::Root { foot, square, add, .. },
                Self::Root { foot: other_foot, square: other_square, add: other_add, .. },
            ) => {
                // With t from the other foot, the difference of the squares less the square
                // of apart, rest + linear t, is twice apart times the other root. Its sign
                // is lost, and with it whether the roots are added or subtracted.
                let apart = other_add - add;
                let linear = 2.0 * (other_foot - foot);
                let between = other_foot - foot;
                let rest = between * between + square - other_square - apart * apart;
                let twice = 4.0 * apart * apart;
                let lead = linear * linear - twice;
                let discriminant = twice * (rest * rest + lead * other_square);
                let last = rest * rest - twice * other_square;
                quadratic(lead, linear * rest, last, discriminant, |t| root(other_foot + t));
            }
        }
    }

    /// A crossing after two steps of Newton's method.
    fn polished(&self, other: &Self, place: f64) -> f64 {
        let mut best = place;
        for _ in 0..2 {
            let apart = self.at(best) - other.at(best);
            let next = best - apart / (self.slope(best) - other.slope(best));
            if (self.at(next) - other.at(next)).abs() < apart.abs() {
                best = next;
            }
        }
        best
    }
}

/// Calls `root` with the roots of a x^2 + 2 b x + c, whose discriminant b^2 - a c is given:
/// where it is small, the difference would have no digits left.
fn quadratic(a: f64, b: f64, c: f64, discriminant: f64, mut root: impl FnMut(f64)) {
    if discriminant >= 0.0 {
        let sum = -(b + discriminant.sqrt().copysign(b));
        root(sum / a);
        root(c / sum);
    }
}
