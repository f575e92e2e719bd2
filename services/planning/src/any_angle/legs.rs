//! Legs from a taut path: turn, line, arc, line, ..., line, turn.

use std::f64::consts::FRAC_PI_2;

use super::Errand;
use super::taut::TautPath;
use crate::driving::rules::TurnRule;
use crate::driving::{SAME_HEADING, StartTurn, shortest_turn};
use crate::free_space::floor::{NONE, Reflex};
use crate::geometry::{Direction, Sign, Vector};
use crate::motion::{Curve, Leg, Rule, Rung, wrapped};

/// Lines up to this length are left out, metres: the arcs beside them touch.
const NO_LINE: f64 = 1e-12;

/// The legs along a taut path.
pub(super) fn legs_of(errand: &Errand<'_>, path: &TautPath, rung: Rung) -> Vec<Leg<2>> {
    let mut legs = Vec::with_capacity(2 * path.turns.len() + 3);
    let leg = |curve, junction: Option<usize>| {
        let rule = junction.and_then(|junction| {
            let turn = &path.turns[junction];
            let corner = (turn.vertex != NONE).then(|| errand.floor.corner(turn.vertex))??;
            rule_at(corner, turn.circle.signed_radius)
        });
        Leg { curve, junction, rule, rung: Some(rung) }
    };
    let mut heading = wrapped(errand.start.heading);
    let lines = path.turns.iter().map(|turn| &turn.arrival).chain([&path.last]);
    for (index, line) in lines.enumerate() {
        let has_line = line.length > NO_LINE;
        let next = if has_line || !path.turns.is_empty() {
            libm::atan2(line.direction.y, line.direction.x)
        } else {
            heading
        };
        let mut turned = 0.0;
        if let Some(before) = index.checked_sub(1) {
            let turn = &path.turns[before];
            let sense = turn.circle.signed_radius.signum();
            if turn.sweep > 0.0 {
                let curve = Curve::Arc {
                    center: turn.circle.center,
                    radius: turn.circle.signed_radius.abs(),
                    start_angle: wrapped(heading - sense * FRAC_PI_2),
                    sweep: sense * turn.sweep,
                    reverse: false,
                };
                legs.push(leg(curve, Some(before)));
            }
        } else {
            let turn = shortest_turn(heading, next);
            if turn.abs() > SAME_HEADING {
                if has_line && errand.start_turn == StartTurn::WhileMoving {
                    turned = turn;
                } else {
                    legs.push(leg(turn_in_place(errand.start.position, heading, turn), None));
                }
            }
        }
        if has_line {
            let curve = Curve::Line { from: line.from, to: line.to, heading: next, turned };
            legs.push(leg(curve, (index < path.turns.len()).then_some(index)));
        }
        heading = next;
    }
    if let Some(goal) = errand.goal.heading {
        let turn = shortest_turn(heading, wrapped(goal));
        if turn.abs() > SAME_HEADING {
            legs.push(leg(turn_in_place(errand.goal.position, heading, turn), None));
        }
    }
    if legs.is_empty() {
        legs.push(leg(turn_in_place(errand.start.position, heading, 0.0), None));
    }
    legs
}

/// The rule of Table 2 for a turn about a corner, to the left if the radius is positive; `None`
/// unless its walls are parallel to the axes.
fn rule_at(corner: &Reflex, signed_radius: f64) -> Option<Rule> {
    let sense = signed_radius.signum();
    let along = |normal: &Vector<2>| {
        // The robot touches the corner on its left, or on its right.
        let way = Vector::<2>::new(-sense * normal.y, sense * normal.x);
        let axis = (0..2).find(|axis| way[1 - axis] == 0.0)?;
        Some(Direction { axis, sign: Sign::of(way[axis]) })
    };
    let [first, last] = &corner.normals;
    let (from, to) = if sense > 0.0 { (first, last) } else { (last, first) };
    TurnRule::of(along(from)?, along(to)?).map(TurnRule::name)
}

fn turn_in_place(position: Vector<2>, from_heading: f64, sweep: f64) -> Curve<2> {
    Curve::Turn { position, from_heading, sweep }
}
