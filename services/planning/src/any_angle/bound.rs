//! The certificate of a motion: its free clearance, and how short a motion that keeps it can be.

use super::disc::disc_of;
use super::planner::Planner;
use super::taut::TurnRadii;
use super::{Errand, PRECISION, RobotMotion};
use crate::budget::{Budget, Spent};
use crate::clearance::rectangle::free_clearance;
use crate::driving::Pose;
use crate::motion::Curve;

/// Measures the free clearance of a motion whose legs, length and clearance are known, and finds
/// its bound. If the budget ends before that, the bound is the straight line, and the motion is
/// marked as incomplete.
pub fn certify(
    errand: &Errand<'_>,
    planner: &mut Planner,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<(), Spent> {
    measure_free_clearance(errand, found, budget)?;
    let length = found.length;
    let apart = (errand.goal.position - errand.start.position).norm();
    found.bound = apart.min(length);
    let is_straight = length - apart <= PRECISION * length;
    if is_straight || !found.free_clearance.is_finite() {
        return Ok(());
    }
    // Nearest to a wall point, the heading is at a right angle to the line to it; unless the
    // robot stops there to go back, or turns.
    let footprint = &errand.footprint;
    let is_forward = found.legs.iter().all(|leg| {
        !leg.curve.is_reverse() && !matches!(leg.curve, Curve::Line { turned, .. } if turned != 0.0)
    });
    let half = footprint.width() / 2.0;
    let half = if is_forward { half } else { half.min(footprint.front()).min(footprint.rear()) };
    // The taut path at the gap bounds all that keeps more; the motion itself may be it.
    if is_forward
        && let Some(taut) = found.taut_length
        && found.free_clearance >= found.gap - errand.precision()
        && (length - taut <= PRECISION * length
            || found.free_clearance <= found.gap + errand.precision())
    {
        found.bound = taut.clamp(found.bound, length);
        return Ok(());
    }
    let radius = half + found.free_clearance - errand.precision();
    if radius <= 0.0 {
        return Ok(());
    }
    let disc = disc_of(errand, radius, budget)?;
    let Planner { bounds, .. } = planner;
    let path = budget.keeping_back(2, || bounds.find(errand.floor, &disc, TurnRadii::DISC, budget));
    match path {
        Ok(Some(path)) => found.bound = path.length.clamp(found.bound, length),
        Ok(None) => {}
        // A motion is an answer; the straight line is a bound.
        Err(Spent::Limit { .. }) => found.is_complete = false,
        Err(spent) => return Err(spent),
    }
    Ok(())
}

/// Measures the free clearance of a motion.
pub(super) fn measure_free_clearance(
    errand: &Errand<'_>,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<(), Spent> {
    let Errand { footprint, start, goal, walls, .. } = errand;
    // Without a heading at the goal, it is the one with which the robot arrives.
    let last = found.legs.last().map_or(start.heading, |leg| leg.curve.end_heading());
    let goal = Pose { position: goal.position, heading: goal.heading.unwrap_or(last) };
    let free = free_clearance(footprint, &found.legs, walls, &[*start, goal], budget)?;
    found.free_clearance = free.map_or(f64::INFINITY, |free| free.value);
    Ok(())
}
