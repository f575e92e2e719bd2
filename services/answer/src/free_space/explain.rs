//! Why no route leads between solids: a second look, at free boxes of any size.

use planning::budget::{Cap, Spent};
use planning::geometry::Vector;
use planning::route::{RouteError, Traveller, blocked};
use planning::translation::{Demand, NoWay};
use schemas::message::Refusal;

use super::made::{Cut, Made};
use crate::answers::Resources;
use crate::cache::{FreeBoxes, Kind};
use crate::refuse::{self, Axes, Refused};

/// Whether a refusal is to say what is in the way, which takes time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Explain {
    /// It is.
    Fully,
    /// Whatever it says, it will not be read.
    No,
}

/// Whether solids may have to do with an error.
fn is_about_solids(error: &RouteError) -> bool {
    match error {
        RouteError::NoChannels
        | RouteError::StartOutside { .. }
        | RouteError::GoalOutside { .. }
        | RouteError::JunctionTooSmall { .. }
        | RouteError::Apart { .. }
        | RouteError::Separate { .. }
        // Given up; there may be no route.
        | RouteError::Spent(Spent::Limit { cap: Cap::RouteSteps, .. }) => true,
        RouteError::GapOutOfRange { .. }
        | RouteError::Parallel { .. }
        | RouteError::Blocked
        | RouteError::GapPerJunction { .. }
        | RouteError::GapNotPositive { .. }
        | RouteError::FractionOutOfRange { .. }
        | RouteError::Spent(_) => false,
    }
}

/// Says why no route was found for a union of boxes: its channels are in no request and in no reply.
pub(crate) fn closed_to_union(axes: &Axes, field: String, error: RouteError) -> Refused {
    match error {
        RouteError::Spent(_) => refuse::route(axes, field, error),
        error if is_about_solids(&error) => {
            refuse::no_way(axes, field, Demand::<3>::Part(1.0), NoWay::Closed(None))
        }
        error => refuse::route(axes, field, error),
    }
}

impl<const D: usize> Cut<'_, D> {
    /// Says why no route was found through the channels that were made: what is in the way
    /// between the solids, if that can be told.
    pub(crate) fn refuse_route(
        &mut self,
        made: &Made<D>,
        axes: &Axes,
        (field, error): (String, RouteError),
        traveller: &Traveller<D>,
        resources: &mut Resources<'_>,
    ) -> Refused {
        if !is_about_solids(&error) {
            return refuse::route(axes, field, error);
        }
        match self.in_the_way(made, axes, traveller, resources) {
            Ok(Some(refused)) => refused,
            Err(Spent::Stopped) => Spent::Stopped.into(),
            // Too costly to tell.
            Ok(None) | Err(Spent::Limit { .. }) => refuse::route(axes, field, error),
        }
    }

    /// Says why none of the channels made leads out along the exit, where a body like this
    /// is to be taken out.
    pub(crate) fn refuse_mouth(
        &mut self,
        made: &Made<D>,
        axes: &Axes,
        refusal: Refusal,
        traveller: &Traveller<D>,
        resources: &mut Resources<'_>,
    ) -> Refused {
        match self.in_the_way(made, axes, traveller, resources) {
            Ok(Some(refused)) => refused,
            Err(Spent::Stopped) => Spent::Stopped.into(),
            Ok(None) | Err(Spent::Limit { .. }) => Refused::Request(refusal),
        }
    }

    fn in_the_way(
        &mut self,
        made: &Made<D>,
        axes: &Axes,
        traveller: &Traveller<D>,
        resources: &mut Resources<'_>,
    ) -> Result<Option<Refused>, Spent> {
        let Self { solids, .. } = self;
        let Resources { budget, cache, .. } = resources;
        let content = cache.describe(Kind::SolidsBoxes, D);
        content.boxes(&[made.bounds]);
        content.boxes(solids.boxes());
        let boxes = cache.get(budget, || {
            let mut boxes = Vec::new();
            match solids.channels(&made.bounds, &Vector::zeros(), budget, &mut boxes) {
                Ok(()) => Ok(FreeBoxes(Some(boxes))),
                // Depends on nothing but the solids, so it may be kept.
                Err(Spent::Limit { cap: Cap::Channels | Cap::ChannelSteps, .. }) => {
                    Ok(FreeBoxes(None))
                }
                Err(spent) => Err(spent),
            }
        })?;
        let Some(boxes) = &boxes.0 else { return Ok(None) };
        let found = blocked(boxes, &made.bounds, &made.room, traveller, budget)?;
        Ok(found.and_then(|found| refuse::blocked(axes, &found, solids, &made.bounds)))
    }
}
