//! Legs from tangents: turn, line, arc, line, ..., line, turn.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::tangent::{Circle, Tangent};
use super::taut::ROUNDED;
use super::{Goal, Pose, SAME_HEADING, StartTurn, shortest_turn};
use crate::geometry::{Sign, Vector};
use crate::motion::{Curve, Leg, Rule, Rung, wrapped};

/// Lines up to this length are left out, metres: the arcs beside them touch.
pub(crate) const NO_LINE: f64 = 1e-12;

/// A circle that the path runs around.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rounding {
    pub(crate) circle: Circle,
    /// The angle run around it, radians; `None`: from the line before it to the line after.
    pub(crate) sweep: Option<f64>,
    /// The junction that it belongs to.
    pub(crate) junction: usize,
    /// The rule for the turn.
    pub(crate) rule: Option<Rule>,
}

/// Appends the legs along lines, each with the circle that the path runs around after it.
pub(crate) fn write<'a>(
    (start, start_turn, goal): (&Pose, StartTurn, &Goal),
    lines: impl Iterator<Item = (&'a Tangent, Option<Rounding>)>,
    rung: Option<Rung>,
    legs: &mut Vec<Leg<2>>,
) {
    let leg = |curve, junction: Option<&Rounding>| Leg {
        curve,
        junction: junction.map(|circle| circle.junction),
        rule: junction.and_then(|circle| circle.rule),
        rung,
    };
    let mut heading = wrapped(start.heading);
    let mut turns_about: Option<Rounding> = None;
    for (line, circle) in lines {
        let next = libm::atan2(line.direction.y, line.direction.x);
        let has_line = line.length > NO_LINE;
        let mut turned = 0.0;
        if let Some(circle) = turns_about {
            legs.push(leg(arc(&circle, heading, next), Some(&circle)));
        } else {
            let turn = shortest_turn(heading, next);
            if turn.abs() > SAME_HEADING {
                if has_line && start_turn == StartTurn::WhileMoving {
                    turned = turn;
                } else {
                    legs.push(leg(turn_in_place(start.position, heading, turn), None));
                }
            }
        }
        if has_line {
            let curve = Curve::Line { from: line.from, to: line.to, heading: next, turned };
            legs.push(leg(curve, circle.as_ref()));
        }
        heading = next;
        turns_about = circle;
    }
    if let Some(to) = goal.heading {
        let turn = shortest_turn(heading, wrapped(to));
        if turn.abs() > SAME_HEADING {
            legs.push(leg(turn_in_place(goal.position, heading, turn), None));
        }
    }
    if legs.is_empty() {
        legs.push(leg(turn_in_place(start.position, heading, 0.0), None));
    }
}

/// The arc about a circle that turns from one tangent heading to the next.
fn arc(about: &Rounding, from: f64, to: f64) -> Curve<2> {
    let Rounding { circle: Circle { center, signed_radius }, sweep, .. } = *about;
    let turn = Sign::of(signed_radius);
    let sense = turn.factor();
    Curve::Arc {
        center,
        radius: signed_radius.abs(),
        // The centre is a quarter turn to the side of the turn.
        start_angle: wrapped(from - sense * FRAC_PI_2),
        sweep: sense * sweep.unwrap_or_else(|| forwards(turn, from, to)),
        reverse: false,
    }
}

/// The angle in [0, 2 pi) from one heading (both in (-pi, pi]) to the other in the sense
/// of a turn, radians; backwards by no more than rounding is 0.
fn forwards(turn: Sign, from: f64, to: f64) -> f64 {
    let angle = turn.factor() * (to - from);
    let angle = if angle < -ROUNDED { angle + TAU } else { angle };
    if angle > TAU - ROUNDED { 0.0 } else { angle.max(0.0) }
}

fn turn_in_place(position: Vector<2>, from_heading: f64, sweep: f64) -> Curve<2> {
    Curve::Turn { position, from_heading, sweep }
}
