//! A robot that drives backwards is one that drives forwards with its front and rear exchanged.

use std::f64::consts::PI;

use super::Errand;
use crate::clearance::rectangle::Footprint;
use crate::driving::{Goal, Pose};
use crate::motion::{Curve, Leg, Rung, wrapped};

/// The same errand for the robot with its front and rear exchanged.
pub(super) fn flipped<'a>(errand: &Errand<'a>) -> Errand<'a> {
    let Errand { footprint, start, goal, .. } = *errand;
    let (front, rear) = (footprint.rear(), footprint.front());
    Errand {
        // The same sides are as valid the other way round.
        footprint: Footprint::offset(footprint.width(), front, rear).unwrap_or(footprint),
        start: Pose { heading: wrapped(start.heading + PI), ..start },
        goal: Goal { heading: goal.heading.map(|heading| wrapped(heading + PI)), ..goal },
        ..*errand
    }
}

/// What the flipped robot drives forwards, this one drives backwards.
pub(super) fn turn_round(legs: &mut [Leg<2>]) {
    for leg in legs {
        leg.rung = Some(Rung::Reverse);
        match &mut leg.curve {
            Curve::Line { heading, .. } => *heading = wrapped(*heading + PI),
            Curve::Arc { reverse, .. } => *reverse = !*reverse,
            Curve::Clothoid { from_heading, reverse, .. } => {
                (*from_heading, *reverse) = (wrapped(*from_heading + PI), !*reverse);
            }
            Curve::Turn { from_heading, .. } => *from_heading = wrapped(*from_heading + PI),
        }
    }
}
