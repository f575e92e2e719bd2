//! Legs along a taut path.

use super::Errand;
use super::taut::{TautPath, TautTurn};
use crate::driving::STRAIGHT;
use crate::driving::legs::{NO_LINE, Rounding, write};
use crate::driving::rules::TurnRule;
use crate::driving::tangent::Tangent;
use crate::free_space::floor::{NONE, Reflex};
use crate::geometry::{Direction, Sign, Vector, unit};
use crate::motion::{Leg, Rule, Rung};

/// The legs along a taut path.
pub(super) fn legs_of(errand: &Errand<'_>, path: &TautPath, rung: Rung) -> Vec<Leg<2>> {
    let Errand { start, start_turn, goal, .. } = errand;
    let mut legs = Vec::with_capacity(2 * path.turns.len() + 3);
    let mut lines = Vec::with_capacity(path.turns.len() + 1);
    let mut before: Option<Tangent> = None;
    for (index, turn) in path.turns.iter().enumerate() {
        let line = before.take().map_or(turn.arrival, |before| joined(&before, &turn.arrival));
        // Past corners in line the path goes straight on.
        if turn.sweep <= STRAIGHT {
            before = Some(line);
        } else {
            lines.push((line, Some(rounding(errand, index, turn))));
        }
    }
    // A robot that is at its goal heads nowhere else.
    let at_rest = Tangent { direction: unit(start.heading), ..path.last };
    let is_at_rest = path.turns.is_empty() && path.length == 0.0;
    let last = before.map_or(path.last, |before| joined(&before, &path.last));
    lines.push((if is_at_rest { at_rest } else { last }, None));
    let lines = lines.iter().map(|(line, circle)| (line, *circle));
    write((start, *start_turn, goal), lines, Some(rung), &mut legs);
    legs
}

/// Two lines of which the second goes on straight where the first ends.
fn joined(one: &Tangent, other: &Tangent) -> Tangent {
    if one.length <= NO_LINE {
        return *other;
    }
    if other.length <= NO_LINE {
        return *one;
    }
    let way = other.to - one.from;
    let length = way.norm();
    Tangent { from: one.from, to: other.to, direction: way / length, length }
}

fn rounding(errand: &Errand<'_>, junction: usize, turn: &TautTurn) -> Rounding {
    let TautTurn { vertex, circle, sweep, .. } = *turn;
    let corner = if vertex == NONE { None } else { errand.floor.corner(vertex) };
    let rule = corner.and_then(|corner| rule_at(corner, circle.signed_radius));
    Rounding { circle, sweep: Some(sweep), junction, rule }
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
