//! Chains of channels, and bodies that are taken out of them.

use planning::clearance::Clearance;
use planning::disassembly::DisassemblyError;
use planning::free_space::ChainError;
use planning::geometry::Direction;
use schemas::message::{ErrorCode, Refusal, Task};

use super::refused::Refused;
use super::words::{Axes, Count, Short, Towards, at_junction, letter};

pub(crate) fn chain(axes: &Axes, error: ChainError) -> Refused {
    match error {
        ChainError::Empty => no_channels().into(),
        ChainError::Apart { first, second, axis, end, begin } => {
            let message = format!(
                "channels {first} and {second} do not overlap along {}: one ends at {} m, the \
                 other begins at {} m; consecutive channels must overlap",
                letter(axes, axis),
                Short(end),
                Short(begin)
            );
            let refusal = Refusal::invalid(format!("free_space.channels[{second}]"), message);
            at_junction(axes, (first, axis), (begin, end), refusal).into()
        }
        ChainError::Parallel { first, second, axis } => {
            let message = format!(
                "channels {first} and {second} both run along {}, so there is no turn between \
                 them; merge them into one channel",
                letter(axes, axis)
            );
            let refusal = Refusal::invalid(format!("free_space.channels[{second}]"), message);
            Refusal { junction: Some(first as u64), axis: Some(axes[axis]), ..refusal }.into()
        }
        ChainError::Spent(spent) => spent.into(),
    }
}

fn no_channels() -> Refusal {
    let message = "free_space.channels has 0 channels; at least 1 is needed";
    Refusal::invalid("free_space.channels", message)
}

pub(crate) fn disassembly(axes: &Axes, field: String, error: DisassemblyError) -> Refused {
    match error {
        DisassemblyError::NoChannels => Refused::Request(no_channels()),
        DisassemblyError::BodyOutside { axis, body, channel } => {
            let message = format!(
                "the body reaches {} m along {}, but the first channel ends at {} m",
                Short(body),
                letter(axes, axis),
                Short(channel)
            );
            Refused::Request(Refusal {
                axis: Some(axes[axis]),
                needs: Some(body),
                has: Some(channel),
                ..Refusal::new(ErrorCode::BodyOutsideFreeSpace, message)
            })
        }
        DisassemblyError::JunctionTooSmall { junction, axis, needs, has } => {
            let message = format!(
                "junction {junction} is {} m wide along {}; the body needs more than {} m",
                Short(has),
                letter(axes, axis),
                Short(needs)
            );
            let refusal = Refusal::new(ErrorCode::JunctionTooSmall, message);
            Refused::Request(at_junction(axes, (junction, axis), (needs, has), refusal))
        }
        DisassemblyError::GapOutOfRange { junction, axis, gap, least, most } => {
            let message = format!(
                "a gap of {} m at junction {junction} along {} is out of range; it must be greater \
                 than {} m and less than {} m",
                Short(gap),
                letter(axes, axis),
                Short(least),
                Short(most)
            );
            Refused::Answer(Refusal {
                field: Some(field),
                junction: Some(junction as u64),
                axis: Some(axes[axis]),
                has: Some(gap),
                least: Some(least),
                most: Some(most),
                ..Refusal::new(ErrorCode::GapOutOfRange, message)
            })
        }
        DisassemblyError::WrongNumberOfGaps { has, needs } => {
            let message = format!(
                "{field} has {} for {}; give one gap per junction",
                Count(has, "gap"),
                Count(needs, "junction")
            );
            let (has, needs) = (Some(has as f64), Some(needs as f64));
            Refused::Answer(Refusal { has, needs, ..Refusal::invalid(field, message) })
        }
        DisassemblyError::FractionOutOfRange { .. } => {
            Refused::Answer(Refusal::new(ErrorCode::Internal, error.to_string()))
        }
        DisassemblyError::Spent(spent) => spent.into(),
    }
}

pub(crate) fn wall_in_the_way<const D: usize>(near: &Clearance<D>) -> Refusal {
    let wall: Vec<_> = near.wall.iter().map(|value| Short(*value).to_string()).collect();
    let message = format!(
        "the body touches a wall at ({}) after {} m: its clearance is {} m there and must be \
         greater than 0 m",
        wall.join(", "),
        Short(near.at),
        Short(near.value)
    );
    let refusal = Refusal::new(ErrorCode::WallInTheWay, message);
    Refusal { needs: Some(0.0), has: Some(near.value), ..refusal }
}

/// A free place that is not beyond the mouth, but so many metres short of it.
pub(crate) fn short_of_the_mouth(axes: &Axes, task: Task, exit: Direction, short: f64) -> Refused {
    let field = if task == Task::Assemble { "start" } else { "goal" };
    let message = format!(
        "{field}: the body is {} m short of the mouth along {}; it must be beyond it with its last \
         side",
        Short(short),
        Towards(axes, exit),
    );
    let refusal = Refusal::new(ErrorCode::GoalOutsideFreeSpace, message);
    let refusal = Refusal { field: Some(format!("{field}.position")), ..refusal };
    Refusal { needs: Some(0.0), has: Some(-short), ..refusal }.into()
}
