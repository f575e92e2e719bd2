//! The motion with the greatest free clearance.

use super::ladder::Planner;
use super::{Errand, Found, NoMotion};
use crate::budget::Budget;

pub(super) fn safest(
    errand: &Errand<'_>,
    planner: &mut Planner,
    found: &mut Found,
    budget: &Budget<'_>,
) -> Result<(), NoMotion> {
    let _ = (errand, planner, found, budget);
    Err(NoMotion::Enclosed { at_goal: false })
}
