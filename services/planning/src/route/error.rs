//! Why there is no route.

use crate::budget::Spent;
use crate::geometry::number::Number;
use thiserror::Error;

/// Why there is no route. Channels are named by their index.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum RouteError {
    /// The free space has no channel.
    #[error("there are 0 channels, at least 1 is needed")]
    NoChannels,
    /// No channel contains the start.
    #[error(
        "no channel contains the start: the nearest, {channel}, ends at {} along coordinate {axis}, the body reaches {}",
        Number(*end), Number(*body)
    )]
    StartOutside {
        /// The channel that it is least outside of.
        channel: usize,
        /// The coordinate along which it is farthest outside.
        axis: usize,
        /// Coordinate of the body's side that is outside, metres.
        body: f64,
        /// Coordinate of the channel's side that it passes, metres.
        end: f64,
    },
    /// No channel contains the goal.
    #[error(
        "no channel contains the goal: the nearest, {channel}, ends at {} along coordinate {axis}, the goal is at {}",
        Number(*end), Number(*goal)
    )]
    GoalOutside {
        /// The channel that it is least outside of.
        channel: usize,
        /// The coordinate along which it is farthest outside.
        axis: usize,
        /// The goal's coordinate, metres.
        goal: f64,
        /// Coordinate of the channel's side that it passes, metres.
        end: f64,
    },
    /// Every way leads through a junction that is too small by (2.5), or over channels that
    /// are apart. This is the worst junction on the way whose worst junction is best: made larger
    /// than it needs to be, it opens that way, unless `others` are too small as well.
    #[error(
        "no route: the junction of channels {first} and {second} is {} m wide along coordinate {axis}, it must be wider than {} m",
        Number(*has), Number(*needs)
    )]
    JunctionTooSmall {
        /// The channel before it.
        first: usize,
        /// The channel after it.
        second: usize,
        /// Its place on that way, in travel order.
        junction: usize,
        /// The coordinate along which it is too small.
        axis: usize,
        /// What it must exceed, metres.
        needs: f64,
        /// Its extent, metres; 0 if the channels just touch.
        has: f64,
        /// How many other junctions of that way are too small, by no more.
        others: usize,
    },
    /// As [`RouteError::JunctionTooSmall`], for channels that do not even touch.
    #[error(
        "no route: channels {first} and {second} are {} m apart along coordinate {axis}, they must overlap by more than {} m",
        Number(*apart), Number(*needs)
    )]
    Apart {
        /// The channel before the gap between them.
        first: usize,
        /// The channel after it.
        second: usize,
        /// The junction's place on that way, in travel order.
        junction: usize,
        /// The coordinate along which they are apart.
        axis: usize,
        /// What their junction must exceed, metres.
        needs: f64,
        /// The distance between them along it, metres.
        apart: f64,
        /// How many other junctions of that way are too small, by no more.
        others: usize,
    },
    /// As [`RouteError::JunctionTooSmall`], for (3.1): the body would pass, but not with this gap.
    #[error(
        "no route with a gap of {} m: at the junction of channels {first} and {second} it must be between {} m and {} m along coordinate {axis}",
        Number(*gap), Number(*least), Number(*most)
    )]
    GapOutOfRange {
        /// The channel before the junction.
        first: usize,
        /// The channel after it.
        second: usize,
        /// Its place on the way, in travel order.
        junction: usize,
        /// The coordinate.
        axis: usize,
        /// The gap asked for, metres.
        gap: f64,
        /// It must be greater than this, metres.
        least: f64,
        /// It must be less than this, metres.
        most: f64,
    },
    /// Large enough channels meet, but without a turn.
    #[error("no route: channels {first} and {second} both run along coordinate {axis}")]
    Parallel {
        /// The channel before the junction.
        first: usize,
        /// The channel after it.
        second: usize,
        /// The axis of both.
        axis: usize,
    },
    /// Start and end lie in separate parts of the free space, and a search across what lies
    /// between would take too many steps.
    #[error(
        "start and end lie in separate parts of the free space: {reached} of {channels} channels are reachable from the start"
    )]
    Separate {
        /// Channels reachable from the start, however small the junctions.
        reached: usize,
        /// The number of all channels.
        channels: usize,
    },
    /// Gaps per junction were given, but the route is not known yet.
    #[error(
        "{has} gaps are given for junctions, but the route is not known yet: give one gap for all"
    )]
    GapPerJunction {
        /// How many were given.
        has: usize,
    },
    /// The gap is not a positive number.
    #[error(
        "the gap along coordinate {axis} is {} m, it must be greater than {} m",
        Number(*gap), Number(*least)
    )]
    GapNotPositive {
        /// The coordinate.
        axis: usize,
        /// The gap asked for, metres.
        gap: f64,
        /// It must be greater than this, metres.
        least: f64,
    },
    /// [`crate::disassembly::Gap::Fraction`] outside (0, 1].
    #[error(
        "the fraction {} of the greatest gap must be greater than {} and at most {}",
        Number(*fraction), Number(*least), Number(*most)
    )]
    FractionOutOfRange {
        /// The part asked for.
        fraction: f64,
        /// It must be greater than this.
        least: f64,
        /// It must not be greater than this.
        most: f64,
    },
    /// There are routes, but following them showed all to be blocked.
    #[error("every route found is blocked")]
    Blocked,
    /// The budget ended.
    #[error(transparent)]
    Spent(#[from] Spent),
}
