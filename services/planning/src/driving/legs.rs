//! Legs from tangents: turn, line, arc, line, ..., line, turn.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::tangent::Tangent;
use super::taut::{Knot, ROUNDED};
use super::{Drive, SAME_HEADING, StartTurn, shortest_turn};
use crate::geometry::{Sign, Vector};
use crate::motion::{Curve, Leg, wrapped};

/// Lines up to this length are left out, metres: the arcs beside them touch.
const NO_LINE: f64 = 1e-12;

/// Writes the legs of the path that turns about `knots` and ends with `last`.
pub(super) fn write(drive: &Drive<'_>, knots: &[Knot], last: &Tangent, legs: &mut Vec<Leg<2>>) {
    let mut heading = wrapped(drive.start.heading);
    let mut turns_about: Option<&Knot> = None;
    let lines = knots.iter().map(|knot| (&knot.arrival, Some(knot))).chain([(last, None)]);
    for (line, knot) in lines {
        let next = libm::atan2(line.direction.y, line.direction.x);
        let has_line = line.length > NO_LINE;
        let mut turned = 0.0;
        if let Some(knot) = turns_about {
            legs.push(arc(drive, knot, heading, next));
        } else {
            let turn = shortest_turn(heading, next);
            if turn.abs() > SAME_HEADING {
                if has_line && drive.start_turn == StartTurn::WhileMoving {
                    turned = turn;
                } else {
                    legs.push(turn_in_place(&drive.start.position, heading, turn));
                }
            }
        }
        if has_line {
            legs.push(Leg {
                curve: Curve::Line { from: line.from, to: line.to, heading: next, turned },
                junction: knot.map(|knot| knot.corner),
                rule: knot.map(|knot| drive.corners[knot.corner].rule.name()),
                rung: None,
            });
        }
        heading = next;
        turns_about = knot;
    }
    if let Some(goal) = drive.goal.heading {
        let turn = shortest_turn(heading, wrapped(goal));
        if turn.abs() > SAME_HEADING {
            legs.push(turn_in_place(&drive.goal.position, heading, turn));
        }
    }
    if legs.is_empty() {
        legs.push(turn_in_place(&drive.start.position, heading, 0.0));
    }
}

/// The arc about a knot that turns from one tangent heading to the next.
fn arc(drive: &Drive<'_>, knot: &Knot, from: f64, to: f64) -> Leg<2> {
    let rule = drive.corners[knot.corner].rule;
    let sense = rule.turn.factor();
    let sweep = forwards(rule.turn, from, to);
    Leg {
        curve: Curve::Arc {
            center: knot.circle.center,
            radius: knot.circle.signed_radius.abs(),
            // The centre is a quarter turn to the side of the turn.
            start_angle: wrapped(from - sense * FRAC_PI_2),
            sweep: sense * sweep,
            reverse: false,
        },
        junction: Some(knot.corner),
        rule: Some(rule.name()),
        rung: None,
    }
}

/// The angle in [0, 2 pi) from one heading (both in (-pi, pi]) to the other in the sense
/// of a turn, radians; backwards by no more than rounding is 0.
fn forwards(turn: Sign, from: f64, to: f64) -> f64 {
    let angle = turn.factor() * (to - from);
    let angle = if angle < -ROUNDED { angle + TAU } else { angle };
    if angle > TAU - ROUNDED { 0.0 } else { angle.max(0.0) }
}

fn turn_in_place(position: &Vector<2>, from_heading: f64, sweep: f64) -> Leg<2> {
    Leg {
        curve: Curve::Turn { position: *position, from_heading, sweep },
        junction: None,
        rule: None,
        rung: None,
    }
}
