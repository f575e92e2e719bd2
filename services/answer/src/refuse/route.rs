//! Channels that no route leads through.

use planning::geometry::Direction;
use planning::route::RouteError;
use schemas::message::{ErrorCode, Refusal};

use super::refused::Refused;
use super::words::{Axes, Count, Others, Short, Towards, at_junction, letter};

/// A cavity that none of its channels leads out of.
pub(crate) fn no_mouth(axes: &Axes, exit: Direction, needs: f64, has: f64) -> Refusal {
    let (sign, axis) = (exit.sign.factor(), letter(axes, exit.axis));
    let (needs, has) = (sign * needs, sign * has);
    let message = format!(
        "no route: the cavity is closed towards {}; its channels reach {axis} = {} m, but its \
         mouth is at {axis} = {} m",
        Towards(axes, exit),
        Short(has),
        Short(needs)
    );
    let refusal = Refusal::new(ErrorCode::NoRoute, message);
    Refusal { axis: Some(axes[exit.axis]), needs: Some(needs), has: Some(has), ..refusal }
}

pub(crate) fn route(axes: &Axes, field: String, error: RouteError) -> Refused {
    let no_route = |message| Refusal::new(ErrorCode::NoRoute, message);
    match error {
        RouteError::NoChannels => {
            let message = "no route: the free space has no channel larger than the body";
            Refused::Request(no_route(message.to_owned()))
        }
        RouteError::StartOutside { channel, axis, body, end } => {
            let message = format!(
                "no channel contains the start: the nearest, channel {channel}, ends at {} m along \
                 {}, but the body reaches {} m",
                Short(end),
                letter(axes, axis),
                Short(body)
            );
            let refusal = Refusal::new(ErrorCode::BodyOutsideFreeSpace, message);
            let (needs, has) = (Some(body), Some(end));
            Refused::Request(Refusal { axis: Some(axes[axis]), needs, has, ..refusal })
        }
        RouteError::GoalOutside { channel, axis, goal, end } => {
            let message = format!(
                "no channel contains the goal: the nearest, channel {channel}, ends at {} m along \
                 {}, but the goal is at {} m",
                Short(end),
                letter(axes, axis),
                Short(goal)
            );
            let refusal = Refusal::new(ErrorCode::GoalOutsideFreeSpace, message);
            let (needs, has) = (Some(goal), Some(end));
            Refused::Request(Refusal { axis: Some(axes[axis]), needs, has, ..refusal })
        }
        RouteError::JunctionTooSmall { first, second, junction, axis, needs, has, others } => {
            let message = format!(
                "no route: the junction of channels {first} and {second} is {} m wide along {}, \
                 but must be wider than {} m{}",
                Short(has),
                letter(axes, axis),
                Short(needs),
                Others("junction", others)
            );
            let refusal = no_route(message);
            Refused::Request(at_junction(axes, (junction, axis), (needs, has), refusal))
        }
        RouteError::Apart { first, second, junction, axis, needs, apart, others } => {
            let message = format!(
                "no route: channels {first} and {second} are {} m apart along {}; a route would \
                 open if they overlapped by more than {} m{}",
                Short(apart),
                letter(axes, axis),
                Short(needs),
                Others("junction", others)
            );
            // A junction with less than no extent: what is missing is needs - has.
            let refusal = no_route(message);
            Refused::Request(at_junction(axes, (junction, axis), (needs, -apart), refusal))
        }
        RouteError::GapOutOfRange { first, second, junction, axis, gap, least, most } => {
            let message = format!(
                "no route with a gap of {} m: at the junction of channels {first} and {second} it \
                 must be greater than {} m and less than {} m along {}",
                Short(gap),
                Short(least),
                Short(most),
                letter(axes, axis)
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
        RouteError::GapNotPositive { axis, gap, least } => {
            let message = format!(
                "a gap of {} m along {} is out of range; it must be greater than {} m",
                Short(gap),
                letter(axes, axis),
                Short(least)
            );
            Refused::Answer(Refusal {
                field: Some(field),
                axis: Some(axes[axis]),
                has: Some(gap),
                least: Some(least),
                ..Refusal::new(ErrorCode::GapOutOfRange, message)
            })
        }
        RouteError::Separate { reached, channels } => {
            let message = format!(
                "no route: start and end lie in separate parts of the free space; {reached} of \
                 {channels} channels are reachable from the start"
            );
            let (needs, has) = (Some(channels as f64), Some(reached as f64));
            Refused::Request(Refusal { needs, has, ..no_route(message) })
        }
        RouteError::Parallel { first, second, axis } => {
            let message = format!(
                "no route: channels {first} and {second} both run along {}, so there is no turn \
                 between them; merge them into one channel",
                letter(axes, axis)
            );
            Refused::Request(Refusal { axis: Some(axes[axis]), ..no_route(message) })
        }
        RouteError::GapPerJunction { has } => {
            let message = format!(
                "{field} has {}, one per junction, but the route is not known yet; give one \
                 gap for all junctions, or the channels in travel order (`in_order`)",
                Count(has, "gap")
            );
            Refused::Answer(Refusal::invalid(field, message))
        }
        // Those that judge routes say what blocks them.
        RouteError::Blocked | RouteError::FractionOutOfRange { .. } => {
            Refused::Answer(Refusal::new(ErrorCode::Internal, error.to_string()))
        }
        RouteError::Spent(spent) => spent.into(),
    }
}
