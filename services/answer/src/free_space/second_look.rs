//! A second look at solids that no route was found through.

use planning::budget::{Budget, Spent};
use planning::geometry::{AxisBox, Direction, Vector};
use planning::route::{Blocked, Motion, RouteError, Traveller, blocked};
use schemas::message::Refusal;

use super::FreeSpace;
use crate::refuse::{self, Axes};
use crate::{Refused, check};

/// All maximal free boxes, whatever their size. They are made where an answer is refused,
/// once for the bounds at hand, and are no part of any other answer.
#[derive(Debug, Default)]
pub(super) struct SecondLook<const D: usize> {
    /// What channels were made for.
    made_for: Option<(AxisBox<D>, Vector<D>)>,
    /// `None` within: there are too many.
    boxes: Option<Option<Vec<AxisBox<D>>>>,
}

impl<const D: usize> SecondLook<D> {
    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Channels are made within these bounds for a body of this size.
    pub(super) fn prepare(&mut self, bounds: AxisBox<D>, room: Vector<D>) {
        let made_for = Some((bounds, room));
        if self.made_for != made_for {
            *self = Self { made_for, boxes: None };
        }
    }
}

impl<const D: usize, M: Motion<D>> FreeSpace<D, M> {
    /// Refuses a cavity that none of its channels leads out of along the exit.
    pub(in super::super) fn check_mouth(
        &mut self,
        axes: &Axes,
        cavity: &AxisBox<D>,
        exit: Direction,
        motion: Option<M>,
        budget: &Budget<'_>,
    ) -> Result<(), Refusal> {
        check::mouth(axes, self.channels(), cavity, exit).map_err(|refusal| {
            let seen = match motion {
                Some(motion) => self.look_again(axes, motion.traveller(), budget),
                None => Ok(None),
            };
            match seen {
                Ok(Some(refused)) => refused.refusal,
                Ok(None) => refusal,
                Err(spent) => refuse::spent(spent),
            }
        })
    }

    /// Says why there is no route.
    pub(in super::super) fn refuse_route(
        &mut self,
        axes: &Axes,
        field: String,
        error: RouteError,
        traveller: &Traveller<D>,
        budget: &Budget<'_>,
    ) -> Refused {
        let seen = match error {
            RouteError::NoChannels
            | RouteError::StartOutside { .. }
            | RouteError::GoalOutside { .. }
            | RouteError::JunctionTooSmall { .. }
            | RouteError::Apart { .. }
            | RouteError::Separate { .. }
            // Given up; there may be none.
            | RouteError::Spent(Spent::Limit { .. }) => self.look_again(axes, traveller, budget),
            // Solids have nothing to do with these.
            RouteError::GapOutOfRange { .. }
            | RouteError::Parallel { .. }
            | RouteError::Blocked
            | RouteError::GapPerJunction { .. }
            | RouteError::GapNotPositive { .. }
            | RouteError::Spent(Spent::Stopped)
            | RouteError::FractionOutOfRange { .. } => Ok(None),
        };
        match seen {
            Ok(Some(refused)) => refused,
            Ok(None) => refuse::route(axes, field, error),
            Err(spent) => refuse::spent(spent).into(),
        }
    }

    /// What is in the way between the solids, if that can be told within the limits.
    /// `Err`: planning is stopped.
    fn look_again(
        &mut self,
        axes: &Axes,
        traveller: &Traveller<D>,
        budget: &Budget<'_>,
    ) -> Result<Option<Refused>, Spent> {
        match self.seen_again(traveller, budget) {
            Ok(Some((found, bounds))) => Ok(refuse::blocked(axes, &found, &self.solids, &bounds)),
            Ok(None) | Err(Spent::Limit { .. }) => Ok(None),
            Err(Spent::Stopped) => Err(Spent::Stopped),
        }
    }

    fn seen_again(
        &mut self,
        traveller: &Traveller<D>,
        budget: &Budget<'_>,
    ) -> Result<Option<(Blocked<D>, AxisBox<D>)>, Spent> {
        let Self { second_look, solids, explains, .. } = self;
        let Some((bounds, room)) = second_look.made_for.filter(|_| *explains) else {
            return Ok(None);
        };
        if second_look.boxes.is_none() {
            let mut boxes = Vec::new();
            second_look.boxes = match solids.channels(&bounds, &Vector::zeros(), budget, &mut boxes)
            {
                Ok(()) => Some(Some(boxes)),
                Err(Spent::Limit { .. }) => Some(None),
                Err(Spent::Stopped) => return Err(Spent::Stopped),
            };
        }
        let Some(Some(boxes)) = &second_look.boxes else { return Ok(None) };
        let found = blocked(boxes, &bounds, &room, traveller, budget)?;
        Ok(found.map(|found| (found, bounds)))
    }
}
