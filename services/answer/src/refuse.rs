//! What planning refuses, in the words and numbers of a reply.

use std::fmt;

use planning::budget::{Cap, Spent};
use planning::clearance::Clearance;
use planning::disassembly::DisassemblyError;
use planning::driving::DrivingError;
use planning::free_space::ChainError;
use planning::geometry::{BoxError, Direction, Sign};
use planning::route::RouteError;
use planning::trajectory::{LimitError, SamplingError};
use schemas::message::{ErrorCode, Refusal};

use super::Refused;

mod blocked;

pub(super) use blocked::blocked;

/// Which coordinate of a scene is which axis: 0 x, 1 y, 2 z.
pub(super) type Axes = [u32; 3];

/// Assembly in two dimensions lives in (x, z).
pub(super) const PLANE: Axes = [0, 2, 1];
/// Assembly in three dimensions lives in (x, y, z).
pub(super) const SPACE: Axes = [0, 1, 2];
/// Driving lives in (x, y).
pub(super) const FLOOR: Axes = [0, 1, 2];

/// A number as people read it: to nanometres, without zeros at its end. The reply's
/// fields have it in full.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size != 0.0 && !(1e-6..1e12).contains(&size) {
            return write!(f, "{:e}", self.0);
        }
        let text = format!("{:.9}", self.0);
        f.write_str(text.trim_end_matches('0').trim_end_matches('.'))
    }
}

/// How many other junctions or places of a way would have to change.
struct Others(&'static str, usize);

impl fmt::Display for Others {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(what, count) = self;
        match count {
            0 => Ok(()),
            1 => write!(f, "; 1 other {what} on that way is too small as well"),
            _ => write!(f, "; {count} other {what}s on that way are too small as well"),
        }
    }
}

/// With the numbers of a junction.
fn at_junction(
    axes: &Axes,
    (junction, axis): (usize, usize),
    (needs, has): (f64, f64),
    refusal: Refusal,
) -> Refusal {
    Refusal {
        junction: Some(junction as u64),
        axis: Some(axes[axis]),
        needs: Some(needs),
        has: Some(has),
        ..refusal
    }
}

fn letter(axes: &Axes, coordinate: usize) -> char {
    ['x', 'y', 'z'][axes[coordinate] as usize]
}

pub(super) fn axis_box(field: String, axes: &Axes, error: BoxError) -> Refusal {
    let message = match error {
        BoxError::NotFinite { axis, min, max } => {
            format!("{field}: {} is not finite: min {min}, max {max}", letter(axes, axis))
        }
        BoxError::Inverted { axis, min, max } => format!(
            "{field}: {} is inverted or empty: min {min} must be less than max {max}",
            letter(axes, axis)
        ),
    };
    let (BoxError::NotFinite { axis, .. } | BoxError::Inverted { axis, .. }) = error;
    Refusal { axis: Some(axes[axis]), ..Refusal::invalid(field, message) }
}

pub(super) fn chain(axes: &Axes, error: ChainError) -> Refusal {
    match error {
        ChainError::Spent(error) => spent(error),
        ChainError::Empty => {
            Refusal::invalid("free_space.channels", format!("free_space.channels: {error}"))
        }
        ChainError::Apart { first, second, axis, end, begin } => {
            let message = format!(
                "channels {first} and {second} do not overlap along {}: one ends at {}, the \
                 other begins at {}; consecutive channels must share a junction",
                letter(axes, axis),
                Short(end),
                Short(begin)
            );
            let refusal = Refusal::invalid(format!("free_space.channels[{second}]"), message);
            Refusal {
                junction: Some(first as u64),
                axis: Some(axes[axis]),
                has: Some(end),
                needs: Some(begin),
                ..refusal
            }
        }
        ChainError::Parallel { first, second, axis } => {
            let message = format!(
                "channels {first} and {second} both run along {}; a junction turns from one axis \
                 to another: join them into one channel",
                letter(axes, axis)
            );
            let refusal = Refusal::invalid(format!("free_space.channels[{second}]"), message);
            Refusal { junction: Some(first as u64), axis: Some(axes[axis]), ..refusal }
        }
    }
}

pub(super) fn disassembly(axes: &Axes, field: String, error: DisassemblyError) -> Refusal {
    match error {
        DisassemblyError::Spent(error) => spent(error),
        DisassemblyError::NoChannels => {
            Refusal::invalid("free_space.channels", format!("free_space.channels: {error}"))
        }
        DisassemblyError::BodyOutside { axis, body, channel } => {
            let message = format!(
                "the body reaches {} along {}, outside the first channel, which ends at {}",
                Short(body),
                letter(axes, axis),
                Short(channel)
            );
            Refusal {
                axis: Some(axes[axis]),
                needs: Some(body),
                has: Some(channel),
                ..Refusal::new(ErrorCode::BodyOutsideFreeSpace, message)
            }
        }
        DisassemblyError::JunctionTooSmall { junction, axis, needs, has } => {
            let message = format!(
                "junction {junction} is {} m wide along {}, the body needs more than {} m",
                Short(has),
                letter(axes, axis),
                Short(needs)
            );
            Refusal {
                junction: Some(junction as u64),
                axis: Some(axes[axis]),
                needs: Some(needs),
                has: Some(has),
                ..Refusal::new(ErrorCode::JunctionTooSmall, message)
            }
        }
        DisassemblyError::GapOutOfRange { junction, axis, gap, least, most } => {
            let message = format!(
                "a gap of {} m at junction {junction} along {} must be greater than {} m and less \
                 than {} m",
                Short(gap),
                letter(axes, axis),
                Short(least),
                Short(most)
            );
            Refusal {
                field: Some(field),
                junction: Some(junction as u64),
                axis: Some(axes[axis]),
                has: Some(gap),
                least: Some(least),
                most: Some(most),
                ..Refusal::new(ErrorCode::GapOutOfRange, message)
            }
        }
        DisassemblyError::WrongNumberOfGaps { has, needs } => Refusal {
            has: Some(has as f64),
            needs: Some(needs as f64),
            ..Refusal::invalid(field, format!("{has} gaps are given for {needs} junctions"))
        },
        DisassemblyError::FractionOutOfRange { .. } => {
            Refusal::new(ErrorCode::Internal, error.to_string())
        }
    }
}

/// The budget of the request ended.
pub(super) fn spent(spent: Spent) -> Refusal {
    let Spent::Limit { cap, most } = spent else {
        return Refusal::new(ErrorCode::Internal, spent.to_string());
    };
    let setting = format!("caps.{}", cap.name());
    let (field, remedy) = match cap {
        Cap::Steps => (None, "ask for fewer answers, or simplify the scene"),
        Cap::Bytes => (None, "ask for fewer answers or samples, or simplify the scene"),
        Cap::Pieces => (Some("free_space.solids"), "give fewer solids or slanted edges"),
        Cap::Channels | Cap::ChannelSteps => {
            (Some("free_space.solids"), "give fewer solids, or narrower bounds")
        }
        Cap::Junctions => (Some("free_space.channels"), "give channels that overlap fewer others"),
        Cap::RouteSteps => {
            (Some("free_space"), "give fewer channels or solids, or channels in travel order")
        }
    };
    let message = format!(
        "{spent}, the limit that the planner's configuration sets (`{setting}`); {remedy}, or \
         raise the limit"
    );
    Refusal {
        field: field.map(str::to_owned),
        most: Some(most as f64),
        setting: Some(setting),
        ..Refusal::new(ErrorCode::TooCostly, message)
    }
}

pub(super) fn no_mouth(axes: &Axes, exit: Direction, needs: f64, has: f64) -> Refusal {
    let (sign, way) = (exit.sign.factor(), if exit.sign == Sign::Positive { '+' } else { '-' });
    let axis = letter(axes, exit.axis);
    let (needs, has) = (sign * needs, sign * has);
    let message = format!(
        "no route: the cavity has no mouth towards {way}{axis}; its channels reach {axis} = {}, and \
         the way out is at {axis} = {}",
        Short(has),
        Short(needs)
    );
    let refusal = Refusal::new(ErrorCode::NoRoute, message);
    Refusal { axis: Some(axes[exit.axis]), needs: Some(needs), has: Some(has), ..refusal }
}

pub(super) fn route(axes: &Axes, field: String, error: RouteError) -> Refused {
    let no_route = |message| Refusal::new(ErrorCode::NoRoute, message);
    let (refusal, whole) = match error {
        RouteError::NoChannels => {
            (no_route("the free space has no channel larger than the body".to_owned()), true)
        }
        RouteError::StartOutside { channel, axis, body, end } => {
            let message = format!(
                "no channel holds the start: channel {channel} comes nearest, but ends at {} along \
                 {}, and the body reaches {}",
                Short(end),
                letter(axes, axis),
                Short(body)
            );
            let refusal = Refusal::new(ErrorCode::BodyOutsideFreeSpace, message);
            let (needs, has) = (Some(body), Some(end));
            (Refusal { axis: Some(axes[axis]), needs, has, ..refusal }, true)
        }
        RouteError::GoalOutside { channel, axis, goal, end } => {
            let message = format!(
                "no channel holds the goal: channel {channel} comes nearest, but ends at {} along \
                 {}, and the goal is at {}",
                Short(end),
                letter(axes, axis),
                Short(goal)
            );
            let refusal = Refusal::new(ErrorCode::GoalOutsideFreeSpace, message);
            let (needs, has) = (Some(goal), Some(end));
            (Refusal { axis: Some(axes[axis]), needs, has, ..refusal }, true)
        }
        RouteError::JunctionTooSmall { first, second, junction, axis, needs, has, others } => {
            let message = format!(
                "no route: the junction of channels {first} and {second} would open one, but it is \
                 {} m wide along {}, more than {} m are needed{}",
                Short(has),
                letter(axes, axis),
                Short(needs),
                Others("junction", others)
            );
            (at_junction(axes, (junction, axis), (needs, has), no_route(message)), true)
        }
        RouteError::Apart { first, second, junction, axis, needs, apart, others } => {
            let message = format!(
                "no route: channels {first} and {second} are {} m apart along {}; joined by more \
                 than {} m there they would open one{}",
                Short(apart),
                letter(axes, axis),
                Short(needs),
                Others("junction", others)
            );
            // A junction with less than no extent: what is missing is needs - has.
            (at_junction(axes, (junction, axis), (needs, -apart), no_route(message)), true)
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
            let refusal = Refusal {
                field: Some(field),
                junction: Some(junction as u64),
                axis: Some(axes[axis]),
                has: Some(gap),
                least: Some(least),
                most: Some(most),
                ..Refusal::new(ErrorCode::GapOutOfRange, message)
            };
            (refusal, false)
        }
        RouteError::GapNotPositive { axis, gap, least } => {
            let message = format!(
                "a gap of {} m along {} must be greater than {} m",
                Short(gap),
                letter(axes, axis),
                Short(least)
            );
            let refusal = Refusal {
                field: Some(field),
                axis: Some(axes[axis]),
                has: Some(gap),
                least: Some(least),
                ..Refusal::new(ErrorCode::GapOutOfRange, message)
            };
            (refusal, false)
        }
        RouteError::Separate { reached, channels } => {
            let message = format!(
                "no route: start and end lie in separate parts of the free space; {reached} of \
                 {channels} channels hang together with the start, and what lies between is too \
                 much to look at"
            );
            let (needs, has) = (Some(channels as f64), Some(reached as f64));
            (Refusal { needs, has, ..no_route(message) }, true)
        }
        RouteError::Parallel { first, second, axis } => {
            let message = format!(
                "no route: channels {first} and {second} both run along {}, and a junction turns \
                 from one axis to another",
                letter(axes, axis)
            );
            (Refusal { axis: Some(axes[axis]), ..no_route(message) }, true)
        }
        RouteError::GapPerJunction { .. } => (Refusal::invalid(field, error.to_string()), false),
        RouteError::Spent(error) => (spent(error), false),
        // Those that are judged say what blocks them.
        RouteError::Blocked | RouteError::FractionOutOfRange { .. } => {
            (Refusal::new(ErrorCode::Internal, error.to_string()), false)
        }
    };
    Refused { refusal, whole }
}

/// A way is too narrow for a robot with this gap, and wide enough with less.
pub(super) fn less_gap(field: String, too_narrow: Refusal, gap: f64, most: f64) -> Refusal {
    let message = format!(
        "{}; with a gap of less than {} m, not {} m, it is wide enough",
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

pub(super) fn driving(field: String, error: DrivingError) -> Refused {
    let refusal = |code| Refusal::new(code, error.to_string());
    let corner = |corner: usize| Some(corner as u64);
    let (refusal, whole) = match error {
        DrivingError::Spent(error) => (spent(error), false),
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
    Refused { refusal, whole }
}

pub(super) fn wall_in_the_way<const D: usize>(near: &Clearance<D>) -> Refusal {
    let (at, wall) = (near.at, near.wall.as_slice());
    let message = format!(
        "the body touches a wall at ({}) after {} m: it needs more than 0 m there and has 0 m",
        wall.iter().map(|value| Short(*value).to_string()).collect::<Vec<_>>().join(", "),
        Short(at)
    );
    let refusal = Refusal::new(ErrorCode::WallInTheWay, message);
    Refusal { needs: Some(0.0), has: Some(near.value), ..refusal }
}

pub(super) fn limit(error: LimitError) -> Refusal {
    let LimitError::OutOfRange { field, value, least, most } = error;
    let refusal = Refusal::invalid(format!("limits.{field}"), format!("limits.{error}"));
    Refusal { has: Some(value), least: Some(least), most: Some(most), ..refusal }
}

pub(super) fn sampling(error: SamplingError) -> Refusal {
    let field = match error {
        SamplingError::NotPositive { field, .. } => field,
        SamplingError::TooFew { .. } => "count",
    };
    Refusal::invalid(format!("sampling.{field}"), format!("sampling.{error}"))
}

pub(super) fn too_many_samples(needs: u64, most: u64) -> Refusal {
    let message = format!(
        "the trajectory would have {needs} samples, at most {most} can be had; sample less densely"
    );
    Refusal {
        needs: Some(needs as f64),
        has: Some(most as f64),
        ..Refusal::new(ErrorCode::TooManySamples, message)
    }
}
