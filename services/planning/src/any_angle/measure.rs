//! What a motion measures: length, clearance, and whether it touches a wall.

use super::{Errand, RobotMotion};
use crate::budget::{Budget, Spent};
use crate::clearance::rectangle::{Met, nearest_along};
use crate::geometry::Vector;
use crate::motion::{Curve, Leg};

/// Where a motion touches a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Contact {
    /// The leg on which it does.
    pub(super) leg: usize,
    /// The wall point, metres; `None` where the robot must not turn in place.
    pub(super) wall: Option<Vector<2>>,
}

/// Measures a motion leg by leg; returns where it touches walls, one place for each leg.
pub(super) fn measure(
    errand: &Errand<'_>,
    legs: Vec<Leg<2>>,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<Vec<Contact>, Spent> {
    let RobotMotion { leg_clearances, .. } = found;
    leg_clearances.clear();
    let (mut whole, mut contacts) = (Met::NOTHING, Vec::new());
    nearest_along(&errand.footprint, &legs, errand.walls, budget, |leg, met, at| {
        if met.value <= errand.contact() {
            contacts.push(Contact { leg, wall: Some(met.wall) });
        }
        whole.offer(met.value, at, met.wall);
        leg_clearances.push(met.value);
        Ok::<_, Spent>(())
    })?;
    found.length = legs.iter().map(|leg| leg.curve.length()).sum();
    found.clearance = whole.clearance();
    found.legs = legs;
    Ok(contacts)
}

/// What a motion costs: its length, the angle turned in place, and the stops on the way.
pub(super) fn cost(errand: &Errand<'_>, legs: &[Leg<2>]) -> f64 {
    let mut cost = 0.0;
    let mut was_reverse = None;
    for (index, leg) in legs.iter().enumerate() {
        cost += leg.curve.length();
        match leg.curve {
            Curve::Turn { sweep, .. } => {
                cost += errand.costs.turn * sweep.abs();
                if 0 < index && index + 1 < legs.len() {
                    cost += errand.costs.stop;
                }
                was_reverse = None;
            }
            _ => {
                let is_reverse = leg.curve.is_reverse();
                if was_reverse.is_some_and(|was| was != is_reverse) {
                    cost += errand.costs.stop;
                }
                was_reverse = Some(is_reverse);
            }
        }
    }
    cost
}
