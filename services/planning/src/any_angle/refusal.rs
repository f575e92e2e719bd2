//! Why there is no motion: the narrowest place of the widest way.

use super::ladder::Planner;
use super::measure::Contact;
use super::{Errand, Found, NoMotion};
use crate::budget::{Budget, Spent};
use crate::motion::Curve;

/// No disc of this radius can pass.
pub(super) fn no_way(
    errand: &Errand<'_>,
    radius: f64,
    planner: &mut Planner,
    budget: &Budget<'_>,
) -> Result<NoMotion, Spent> {
    let _ = (radius, planner, budget);
    Ok(NoMotion::Enclosed { at_goal: errand.goal.heading.is_some() })
}

/// A disc can pass, and the robot can't.
pub(super) fn blocked(errand: &Errand<'_>, found: &Found, contact: &Contact) -> NoMotion {
    let turning =
        found.legs.get(contact.leg).is_some_and(|leg| matches!(leg.curve, Curve::Turn { .. }));
    let wall = contact.wall.unwrap_or(errand.start.position);
    NoMotion::Blocked { wall, turning, reverse_helps: false }
}
