//! Robots that turn at corners with continuous curvature.

use planning::any_angle::{self, Planner, RobotMotion};
use planning::budget::{Budget, Spent};
use planning::free_space::floor::Floor;
use planning::free_space::walls::Walls;
use planning::trajectory::{Limits, SmoothDriving, SmoothedDrive, smooth_drive};

use super::errand::Errand;

/// A motion's free clearance counts as kept if it is less by no more than this part of the robot's
/// size: on clothoids it is known from below.
const KEPT: f64 = 1e-8;

/// What is asked of a robot whose turns are to be smooth.
pub(super) fn smooth_driving<'a>(
    errand: &'a Errand,
    walls: &'a Walls<2>,
    limits: &'a Limits,
) -> SmoothDriving<'a> {
    let Errand { footprint, abilities, .. } = errand;
    SmoothDriving { footprint, walls, limits, min_turn_radius: abilities.min_turn_radius }
}

/// Puts smooth turns in place of the arcs of a motion whose free clearance is known. It stays as it
/// is, with stops at its arcs, if that would be less: beside an end, a smooth turn may come closer to
/// another wall than the arc.
pub(super) fn smooth(
    (errand, limits): (&Errand, &Limits),
    (walls, floor): (&Walls<2>, &Floor),
    planner: &mut Planner,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<(), Spent> {
    let task = smooth_driving(errand, walls, limits);
    let SmoothedDrive { legs, leg_clearances, clearance, length } =
        smooth_drive(&task, &found.legs, budget)?;
    let mut smooth = RobotMotion { legs, leg_clearances, clearance, length, ..found.clone() };
    any_angle::certify(&errand.among(walls, floor), planner, &mut smooth, budget)?;
    let size = errand.footprint.swing_radius() + errand.footprint.width();
    if smooth.free_clearance >= found.free_clearance - KEPT * size {
        *found = smooth;
    }
    Ok(())
}
