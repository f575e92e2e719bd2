//! Robots that can't be driven as asked.

use planning::driving::DrivingError;
use schemas::message::{ErrorCode, Refusal};

use super::refused::Refused;
use super::words::Short;

/// A route is too narrow for a robot with this gap, and wide enough with less.
pub(crate) fn less_gap(field: String, too_narrow: Refusal, gap: f64, most: f64) -> Refusal {
    let message = format!(
        "{}; it is wide enough for a gap of less than {} m instead of {} m",
        too_narrow.message,
        Short(most),
        Short(gap)
    );
    Refusal {
        code: ErrorCode::GapOutOfRange,
        message,
        field: Some(field),
        needs: None,
        has: Some(gap),
        least: Some(0.0),
        most: Some(most),
        ..too_narrow
    }
}

pub(crate) fn driving(field: String, error: DrivingError) -> Refused {
    let refusal = |code| Refusal::new(code, error.to_string());
    let corner = |corner: usize| Some(corner as u64);
    let (refusal, whole) = match error {
        DrivingError::Spent(spent) => return spent.into(),
        DrivingError::BodyOutside { .. } | DrivingError::BodyTouchesWall { .. } => {
            (refusal(ErrorCode::BodyOutsideFreeSpace), true)
        }
        DrivingError::GoalOutside { .. } => (refusal(ErrorCode::GoalOutsideFreeSpace), true),
        DrivingError::GoalTouchesWall { heading, .. } => {
            let heading = Some(heading);
            (Refusal { heading, ..refusal(ErrorCode::GoalOutsideFreeSpace) }, false)
        }
        DrivingError::GapCount { has, needs } => {
            let (has, needs) = (Some(has as f64), Some(needs as f64));
            (Refusal { has, needs, ..Refusal::invalid(field, error.to_string()) }, false)
        }
        DrivingError::GapOutOfRange { corner: at, gap, least, most } => {
            let refusal = Refusal {
                field: Some(field),
                junction: corner(at),
                has: Some(gap),
                least: Some(least),
                most: Some(most),
                ..refusal(ErrorCode::GapOutOfRange)
            };
            (refusal, false)
        }
        DrivingError::CornersTooClose { first, has, needs, most, .. } => {
            let refusal = Refusal {
                junction: corner(first),
                needs: Some(needs),
                has: Some(has),
                most: Some(most),
                ..refusal(ErrorCode::CornersTooClose)
            };
            (refusal, false)
        }
        DrivingError::CornerNotPassed { corner: at, sweep } => {
            let (needs, has) = (Some(0.0), Some(sweep));
            let refusal = refusal(ErrorCode::CornersTooClose);
            (Refusal { junction: corner(at), needs, has, ..refusal }, false)
        }
        DrivingError::CornerTooNarrow { corner: at, has, needs } => {
            let (needs, has) = (Some(needs), Some(has));
            let refusal = refusal(ErrorCode::JunctionTooSmall);
            (Refusal { junction: corner(at), needs, has, ..refusal }, true)
        }
        DrivingError::TurnBlocked { heading, free, .. } => {
            let refusal = Refusal {
                needs: Some(heading),
                has: Some(free),
                heading: Some(free),
                ..refusal(ErrorCode::TurnBlocked)
            };
            (refusal, false)
        }
        DrivingError::WallInTheWay { .. } => {
            let refusal = refusal(ErrorCode::WallInTheWay);
            (Refusal { needs: Some(0.0), has: Some(0.0), ..refusal }, false)
        }
    };
    Refused::new(refusal, whole)
}
