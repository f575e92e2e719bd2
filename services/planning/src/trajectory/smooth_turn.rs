//! Turns whose curvature is continuous: a clothoid, an arc and a clothoid.

use crate::geometry::clothoid::Clothoid;
use crate::geometry::{Sign, Vector, rotated, unit};
use crate::motion::{Curve, wrapped};
use std::f64::consts::{FRAC_PI_2, PI};

/// A symmetric turn to the left of greatest curvature 1 and sharpness 1 / (2 d): a clothoid that turns
/// by d, an arc, and the clothoid mirrored.
///
/// Its ends and its middle follow from the clothoid's end (x, y): half-way it is at
/// (x + sin h - sin d, y + cos d - cos h) and heads along (cos h, sin h), for the half h of its
/// turn, and it is symmetric about the normal there.
#[derive(Debug, Clone, Copy)]
pub(super) struct SmoothTurn {
    /// What it turns by, radians, greater than 0.
    turn: f64,
    /// What each clothoid turns by.
    clothoid: f64,
    /// From end to end.
    chord: f64,
    /// How far its middle is from the chord.
    rise: f64,
}

/// Where a turn begins, in the direction of travel.
#[derive(Debug, Clone, Copy)]
pub(super) struct TurnStart {
    pub(super) position: Vector<2>,
    /// The heading; opposite to the direction of travel in reverse.
    pub(super) heading: f64,
    pub(super) reverse: bool,
}

impl SmoothTurn {
    /// Of the turn, a `part` from 0 to 1 is on clothoids.
    pub(super) fn new(turn: f64, part: f64) -> Self {
        let (half, clothoid) = (0.5 * turn, 0.5 * part * turn);
        let bend = Clothoid { curvature: 0.0, sharpness: 0.5 / clothoid };
        let (along, leaning) = (unit(half), unit(clothoid));
        let place = bend.place(2.0 * clothoid);
        let middle = place + Vector::from([along.y - leaning.y, leaning.x - along.x]);
        let chord = 2.0 * middle.dot(&along);
        let rise = middle.x * along.y - middle.y * along.x;
        Self { turn, clothoid, chord, rise }
    }

    /// How large it is, in metres for the unit, where it begins and ends so far outside of an arc of
    /// this radius, on the arc's tangents. Not positive if there is none.
    pub(super) fn beside_arc(&self, radius: f64, beyond: f64) -> f64 {
        let along = unit(0.5 * self.turn);
        (2.0 * radius * along.y + 2.0 * beyond * along.x) / self.chord
    }

    /// How far outside of an arc of this radius it must begin and end so that both have the same
    /// middle.
    pub(super) fn beyond_arc(&self, radius: f64) -> f64 {
        let along = unit(0.5 * self.turn);
        let higher = self.beside_arc(radius, 0.0) * self.rise - radius * (1.0 - along.x);
        let sinks = along.y - 2.0 * along.x * self.rise / self.chord;
        if sinks > 0.0 { (higher / sinks).max(0.0) } else { 0.0 }
    }

    /// How large it is where it begins and ends so far from where its tangents meet; it must turn by
    /// less than half a turn.
    pub(super) fn between_tangents(&self, reach: f64) -> f64 {
        let half = 0.5 * self.turn;
        2.0 * reach * libm::cos(half) / self.chord
    }

    /// Its curvature at both ends of the first clothoid and that one's length, for this size.
    pub(super) fn first(&self, size: f64) -> ([f64; 2], f64) {
        ([0.0, 1.0 / size], 2.0 * self.clothoid * size)
    }

    /// The curves of a turn of this size to a side, two or three, from its start to `end`.
    pub(super) fn curves(
        &self,
        size: f64,
        side: Sign,
        start: &TurnStart,
        end: Vector<2>,
    ) -> impl Iterator<Item = Curve<2>> {
        let side = side.factor();
        let ([_, curvature], length) = self.first(size);
        let (curvature, clothoid) = (curvature * side, self.clothoid * side);
        let TurnStart { position, heading, reverse } = *start;
        let direction = heading + if reverse { PI } else { 0.0 };
        let bend = Clothoid { curvature: 0.0, sharpness: curvature / length };
        let to = position + rotated(&bend.place(length), &unit(direction));
        let first = Curve::Clothoid {
            from: position,
            to,
            from_heading: wrapped(heading),
            curvatures: [0.0, curvature],
            length,
            reverse,
        };
        let out = direction + clothoid - side * FRAC_PI_2;
        let sweep = self.turn * side - 2.0 * clothoid;
        let arc = Curve::Arc {
            center: to - unit(out) * size,
            radius: size,
            start_angle: wrapped(out),
            sweep,
            reverse,
        };
        let arc = (sweep * side > 0.0).then_some(arc);
        let last = Curve::Clothoid {
            from: arc.map_or(to, |arc| arc.end()),
            to: end,
            from_heading: wrapped(heading + self.turn * side - clothoid),
            curvatures: [curvature, 0.0],
            length,
            reverse,
        };
        [Some(first), arc, Some(last)].into_iter().flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clearance::clothoid::PlacedClothoid;
    use proptest::prelude::*;

    proptest! {
        /// In place of arcs, forwards and backwards: ends meet, and headings and curvatures go on.
        #[test]
        fn turns_lead_from_tangent_to_tangent(
            radius in 0.2..3.0_f64, turn in 0.01..5.0_f64, part in 0.05..=1.0_f64,
            heading in -PI..PI, is_left in any::<bool>(), reverse in any::<bool>(),
            share in 0.0..1.0_f64,
        ) {
            let side = Sign::of(if is_left { 1.0 } else { -1.0 });
            let direction = heading + if reverse { PI } else { 0.0 };
            let shape = SmoothTurn::new(turn, part);
            let beyond = if turn < 3.0 { share * shape.beyond_arc(radius) } else { 0.0 };
            let size = shape.beside_arc(radius, beyond);
            prop_assume!(size > 0.0);
            // From the arc's start at the origin to its end.
            let out = direction - side.factor() * FRAC_PI_2;
            let end = (unit(out + turn * side.factor()) - unit(out)) * radius;
            let leaves = direction + turn * side.factor();
            let start = TurnStart { position: -unit(direction) * beyond, heading, reverse };
            let end = end + unit(leaves) * beyond;
            let curves: Vec<_> = shape.curves(size, side, &start, end).collect();
            let scale = 1.0 + radius + beyond + size;
            for pair in curves.windows(2) {
                prop_assert!((pair[0].end() - pair[1].start()).norm() < 1e-13 * scale);
                let bend = wrapped(pair[0].end_heading() - pair[1].start_heading());
                prop_assert!(bend.abs() < 1e-13);
                let [_, before] = pair[0].curvatures();
                let [after, _] = pair[1].curvatures();
                prop_assert!((before - after).abs() < 1e-12 * before.abs());
            }
            // The stated end is where the last clothoid leads.
            let last = curves.last().unwrap();
            let led = PlacedClothoid::of(last).unwrap().at(1.0);
            prop_assert!((led - end).norm() < 1e-12 * scale, "{led} {end}");
            prop_assert!(wrapped(last.end_heading() - heading - turn * side.factor()).abs() < 1e-13);
            let turned: f64 = curves.iter().map(Curve::turned).sum();
            prop_assert!((turned - turn * side.factor()).abs() < 1e-13);
        }
    }
}
