//! Ways between the outlines of solids, without channels.

use planning::budget::Budget;
use planning::clearance::translating::Body;
use planning::geometry::{Direction, Vector};
use planning::translation::{self, Cavity, MovedPart, NoWay};

use crate::free_space::Outlines;

/// Finds a way between outlines that leads out along an exit.
pub(super) type Slide<const D: usize> = fn(
    &Body<'_, D>,
    &Outlines<D>,
    Direction,
    translation::Demand<D>,
    &Budget<'_>,
) -> Result<Vec<Vector<D>>, NoWay<D>>;

/// Finds a way in the plane.
pub(super) fn slide(
    body: &Body<'_, 2>,
    outlines: &Outlines<2>,
    exit: Direction,
    wish: translation::Demand<2>,
    budget: &Budget<'_>,
) -> Result<Vec<Vector<2>>, NoWay<2>> {
    let part = MovedPart::new(body, budget)?;
    let Some(bounds) = outlines.bounds() else { return Err(NoWay::Closed(None)) };
    let cavity = Cavity { part: &part, walls: outlines.walls(), bounds, exit };
    cavity.plan(wish, budget)
}
