//! What a search for a taut path finds, and at which radii it turns.

use crate::driving::tangent::{Circle, Tangent};
use crate::geometry::Vector;
use crate::geometry::distance::cross;

/// Turns backwards by no more than this count as none, radians.
pub(super) const STRAIGHT: f64 = 1e-9;

/// A path of straight lines and arcs: a line to each circle, an arc around it, and a last line.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::any_angle) struct TautPath {
    /// The circles in travel order, with the line that leads to each.
    pub(in crate::any_angle) turns: Vec<TautTurn>,
    /// The line to the goal.
    pub(in crate::any_angle) last: Tangent,
    /// Metres.
    pub(in crate::any_angle) length: f64,
}

/// A circle that the path runs around.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::any_angle) struct TautTurn {
    /// The vertex of the floor at its centre.
    pub(in crate::any_angle) vertex: u32,
    pub(in crate::any_angle) circle: Circle,
    /// The line that leads to it.
    pub(in crate::any_angle) arrival: Tangent,
    /// The angle run around it, radians, in the sense of the circle.
    pub(in crate::any_angle) sweep: f64,
}

/// The radii at which a path turns about corners: those of the disc, or larger ones.
#[derive(Debug, Clone, Copy)]
pub(in crate::any_angle) struct TurnRadii<'a> {
    /// Nowhere less than this, metres.
    pub(in crate::any_angle) least: f64,
    /// At these vertices no less than this, metres.
    pub(in crate::any_angle) own: &'a [(u32, f64)],
}

impl TurnRadii<'_> {
    /// Those of the disc.
    pub(in crate::any_angle) const DISC: Self = Self { least: 0.0, own: &[] };

    /// The largest of those that are not the disc's, metres.
    pub(super) fn most(&self) -> f64 {
        self.own.iter().map(|(_, radius)| *radius).fold(self.least, f64::max)
    }

    /// The radius of its own that a vertex has, metres.
    pub(super) fn own_at(&self, vertex: u32) -> Option<f64> {
        self.own.iter().find(|(other, _)| *other == vertex).map(|(_, radius)| *radius)
    }
}

/// A line of no length.
pub(super) fn at_rest(point: Vector<2>) -> Tangent {
    Tangent { from: point, to: point, direction: Vector::from([1.0, 0.0]), length: 0.0 }
}

/// The direction from the corner that is touched to the centre of a disc that arrives.
pub(super) fn contact_normal(direction: &Vector<2>, sense: f64) -> Vector<2> {
    Vector::<2>::new(sense * direction.y, -sense * direction.x)
}

/// Whether one direction is reached from another by a turn backwards, certainly.
pub(super) fn is_behind(from: &Vector<2>, to: &Vector<2>, sense: f64) -> bool {
    sense * cross(from, to) < -2.0 * STRAIGHT
}
