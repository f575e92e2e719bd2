//! The judgement on a route.

use crate::budget::Spent;
use crate::driving::DrivingError;
use crate::motion::Leg;

/// What following a route shows about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Judgement<T> {
    /// It can be followed.
    Accepted {
        /// The length of its path, metres.
        length: f64,
        /// What the judge made of it, returned by the search if the route is taken.
        value: T,
    },
    /// It is blocked on the arc about this junction or the straight line that leads to it;
    /// `None` for the last line, to the goal. Junctions are counted from 0 in travel order.
    Blocked(Option<usize>),
    /// Neither this route nor any other can be followed.
    Hopeless,
}

impl<T> Judgement<T> {
    /// What an error of [`crate::driving::drive`] says about the route; `legs` are those of the
    /// refused path. An error if the budget ended.
    pub fn of_refusal(refusal: &DrivingError, legs: &[Leg<2>]) -> Result<Self, Spent> {
        let junction_of = |leg: usize| legs.get(leg).and_then(|leg| leg.junction);
        Ok(match *refusal {
            DrivingError::Spent(spent) => return Err(spent),
            DrivingError::BodyOutside { .. }
            | DrivingError::BodyTouchesWall { .. }
            | DrivingError::GoalOutside { .. }
            | DrivingError::GapCount { .. } => Self::Hopeless,
            DrivingError::GoalTouchesWall { .. } => Self::Blocked(None),
            DrivingError::GapOutOfRange { corner, .. }
            | DrivingError::CornersTooClose { second: corner, .. }
            | DrivingError::CornerNotPassed { corner, .. }
            | DrivingError::CornerTooNarrow { corner, .. } => Self::Blocked(Some(corner)),
            // Before the first line or after the last.
            DrivingError::TurnBlocked { leg, .. } => Self::Blocked(junction_of(leg + 1)),
            DrivingError::WallInTheWay { leg, .. } => Self::Blocked(junction_of(leg)),
        })
    }
}
