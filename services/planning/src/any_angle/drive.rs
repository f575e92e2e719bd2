//! The motion that is wished for, with its certificate.

use super::disc::disc_of;
use super::ladder::{LastRung, Target, shortest};
use super::planner::Planner;
use super::{Errand, NoMotion, RobotMotion, Wish, bound, safest};
use crate::budget::Budget;
use crate::clearance::rectangle::clearance_rectangle_pose;

/// One of so many steps is kept back from the search.
const KEPT_BACK: u64 = 16;

/// Finds the motion that is wished for.
pub fn drive(
    errand: &Errand<'_>,
    wish: Wish,
    planner: &mut Planner,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<(), NoMotion> {
    check_ends(errand, budget)?;
    let searched = budget.keeping_back(KEPT_BACK, || match wish {
        Wish::Gap(gap) => {
            let target = Target { gap, least: None, last: LastRung::Lattice };
            shortest(errand, target, planner, found, budget)
        }
        Wish::AtLeast(least) => {
            let gap = least.max(errand.least_gap());
            let target = Target { gap, least: Some(least), last: LastRung::Lattice };
            match shortest(errand, target, planner, found, budget) {
                // A motion with another gap may keep it. Beside an end a rectangle can keep more
                // than a disc.
                Err(refused @ (NoMotion::Blocked { .. } | NoMotion::TooNarrow { .. })) => {
                    let radius = errand.footprint.width() / 2.0 + least;
                    let is_narrow = matches!(refused, NoMotion::TooNarrow { .. });
                    if is_narrow && disc_of(errand, radius, budget)?.is_even() {
                        return Err(refused);
                    }
                    safest::keeping(errand, (least, refused), planner, found, budget)
                }
                result => result,
            }
        }
        Wish::Safest => safest::safest(errand, planner, found, budget),
    });
    planner.lattice.end(budget);
    searched?;
    Ok(bound::certify(errand, planner, found, budget)?)
}

/// Refuses a start or a goal where the robot touches a wall.
fn check_ends(errand: &Errand<'_>, budget: &Budget<'_>) -> Result<(), NoMotion> {
    let Errand { footprint, start, goal, walls, .. } = errand;
    let ends = [(start.position, Some(start.heading), false), (goal.position, goal.heading, true)];
    for (position, heading, at_goal) in ends {
        let Some(heading) = heading else { continue };
        let near = clearance_rectangle_pose(footprint, &position, heading, walls, budget)?;
        if let Some(near) = near
            && near.value <= errand.contact()
        {
            return Err(NoMotion::Occupied { at_goal, wall: near.wall });
        }
    }
    Ok(())
}
