//! A second look at solids that no route was found through.

use planning::geometry::{AxisBox, Direction, Vector};
use planning::route::{Motion, RouteError, Traveller, blocked};
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
    ) -> Result<(), Refusal> {
        check::mouth(axes, self.channels(), cavity, exit).map_err(|refusal| {
            let seen = motion.and_then(|motion| self.look_again(axes, motion.traveller()));
            seen.map_or(refusal, |refused| refused.refusal)
        })
    }

    /// Says why there is no route.
    pub(in super::super) fn refuse_route(
        &mut self,
        axes: &Axes,
        field: String,
        error: RouteError,
        traveller: &Traveller<D>,
    ) -> Refused {
        let seen = match error {
            RouteError::NoChannels
            | RouteError::StartOutside { .. }
            | RouteError::GoalOutside { .. }
            | RouteError::JunctionTooSmall { .. }
            | RouteError::Apart { .. }
            | RouteError::Separate { .. }
            // Given up; there may be none.
            | RouteError::TooManySteps { .. } => self.look_again(axes, traveller),
            // Solids have nothing to do with these.
            RouteError::GapOutOfRange { .. }
            | RouteError::Parallel { .. }
            | RouteError::Blocked
            | RouteError::GapPerJunction { .. }
            | RouteError::GapNotPositive { .. }
            | RouteError::FractionOutOfRange { .. } => None,
        };
        seen.unwrap_or_else(|| refuse::route(axes, field, error))
    }

    /// What is in the way between the solids, if that can be told.
    fn look_again(&mut self, axes: &Axes, traveller: &Traveller<D>) -> Option<Refused> {
        if !self.explains {
            return None;
        }
        let Self { second_look, solids, caps, .. } = self;
        let (bounds, room) = second_look.made_for?;
        let boxes = second_look.boxes.get_or_insert_with(|| {
            let mut boxes = Vec::new();
            solids
                .channels(&bounds, &Vector::zeros(), &caps.solids(), &mut boxes)
                .ok()
                .map(|()| boxes)
        });
        let found = blocked(boxes.as_ref()?, &bounds, &room, traveller, caps.route_steps)?;
        refuse::blocked(axes, &found, solids, &bounds)
    }
}
