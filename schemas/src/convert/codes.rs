//! Codes and what they stand for.

use super::Malformed;
use crate::message::{Direction, ErrorCode, StartTurn, Task};

/// Values by code: the code is the index.
pub(crate) const TASKS: [Task; 3] = [Task::Disassemble, Task::Assemble, Task::Drive];

pub(crate) const START_TURNS: [StartTurn; 2] = [StartTurn::InPlace, StartTurn::WhileMoving];

pub(crate) const DIRECTIONS: [Direction; 6] = [
    Direction::PlusX,
    Direction::MinusX,
    Direction::PlusY,
    Direction::MinusY,
    Direction::PlusZ,
    Direction::MinusZ,
];

pub(crate) const ERRORS: [ErrorCode; 15] = [
    ErrorCode::InvalidScene,
    ErrorCode::UnsupportedVersion,
    ErrorCode::BodyOutsideFreeSpace,
    ErrorCode::GoalOutsideFreeSpace,
    ErrorCode::NoRoute,
    ErrorCode::JunctionTooSmall,
    ErrorCode::GapOutOfRange,
    ErrorCode::CornersTooClose,
    ErrorCode::TurnBlocked,
    ErrorCode::WallInTheWay,
    ErrorCode::TooManySamples,
    ErrorCode::DeadlineExceeded,
    ErrorCode::Overloaded,
    ErrorCode::Internal,
    ErrorCode::TooCostly,
];

/// The value that a code stands for.
pub(super) fn value<T: Copy>(what: &'static str, table: &[T], code: u64) -> Result<T, Malformed> {
    usize::try_from(code)
        .ok()
        .and_then(|code| table.get(code))
        .copied()
        .ok_or(Malformed::UnknownCode { what, code, greatest: table.len() as u64 - 1 })
}

/// The code that stands for a value.
pub(super) fn code<T: PartialEq>(table: &[T], value: T) -> u32 {
    table.iter().position(|entry| *entry == value).expect("tables are complete") as u32
}
