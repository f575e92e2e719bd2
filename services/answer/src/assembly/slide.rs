//! Ways between the outlines of solids, without channels.

use std::cell::OnceCell;
use std::fmt;

use planning::budget::Budget;
use planning::clearance::translating::Body;
use planning::geometry::{Direction, Vector};
use planning::translation::{self, Cavity, MovedPart, NoWay};

use crate::free_space::Outlines;

/// What finds ways between outlines for one body.
pub(super) trait Slide<const D: usize>: fmt::Debug {
    /// A way that leads out along an exit.
    fn find(
        &self,
        body: &Body<'_, D>,
        outlines: &Outlines<D>,
        exit: Direction,
        wish: translation::Demand<D>,
        budget: &Budget<'_>,
    ) -> Result<Vec<Vector<D>>, NoWay<D>>;
}

/// Finds ways in the plane, for the first body that it is asked for.
#[derive(Debug, Default)]
pub(super) struct PlaneSlide {
    /// It is cut once for all exits and answers.
    part: OnceCell<MovedPart>,
}

impl Slide<2> for PlaneSlide {
    fn find(
        &self,
        body: &Body<'_, 2>,
        outlines: &Outlines<2>,
        exit: Direction,
        wish: translation::Demand<2>,
        budget: &Budget<'_>,
    ) -> Result<Vec<Vector<2>>, NoWay<2>> {
        let part = match self.part.get() {
            Some(part) => part,
            None => {
                let part = MovedPart::new(body, budget)?;
                self.part.get_or_init(|| part)
            }
        };
        let Some(bounds) = outlines.bounds() else { return Err(NoWay::Closed(None)) };
        let cavity = Cavity { part, walls: outlines.walls(), bounds, exit };
        cavity.plan(wish, budget)
    }
}
