//! Why there is no route.

use crate::budget::Spent;
use thiserror::Error;

/// Why there is no route. Channels are named by their index.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum RouteError {
    /// The free space has no channel.
    #[error("there are 0 channels, at least 1 is needed")]
    NoChannels,
    /// No channel holds the start.
    #[error(
        "no channel holds the start; the nearest, {channel}, ends at {end} along coordinate {axis}, the body reaches {body}"
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
    /// No channel holds the goal.
    #[error(
        "no channel holds the goal; the nearest, {channel}, ends at {end} along coordinate {axis}, the goal is at {goal}"
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
    /// Every way leads through a junction that is too small by (2.5), or over channels
    /// that are apart. Of all ways this is the one whose worst junction lacks least, and
    /// on it the junction that lacks most: made larger than what it needs, it opens the
    /// way, unless others on it are too small as well.
    #[error(
        "no way through: the junction of channels {first} and {second} is {has} m wide along coordinate {axis}, more than {needs} m are needed"
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
        /// Its extent, metres; 0 if the channels only touch.
        has: f64,
        /// How many other junctions of that way are too small, by no more.
        others: usize,
    },
    /// The same where the two channels do not even touch.
    #[error(
        "no way through: channels {first} and {second} are {apart} m apart along coordinate {axis}, a junction of more than {needs} m is needed"
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
        /// How far apart they are, metres.
        apart: f64,
        /// How many other junctions of that way are too small, by no more.
        others: usize,
    },
    /// The same for (3.1): the body would pass on some way, but not with this gap.
    #[error(
        "no way through with the gap {gap} m: at the junction of channels {first} and {second} it must be between {least} m and {most} m along coordinate {axis}"
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
    /// Channels that are large enough meet, but without a turn.
    #[error("no way through: channels {first} and {second} both run along coordinate {axis}")]
    Parallel {
        /// The channel before the junction.
        first: usize,
        /// The channel after it.
        second: usize,
        /// The axis of both.
        axis: usize,
    },
    /// The start and the end lie in parts of the free space that do not even touch, and
    /// to look over all that lies between would take too many steps.
    #[error(
        "start and end lie in separate parts of the free space: {reached} of {channels} channels hang together with the start"
    )]
    Separate {
        /// Channels that hang together with the start.
        reached: usize,
        /// All channels.
        channels: usize,
    },
    /// One gap per junction was given for a route that is to be found.
    #[error("{has} gaps are given for the junctions of a route that is not known")]
    GapPerJunction {
        /// How many were given.
        has: usize,
    },
    /// The gap is not a positive number.
    #[error("the gap {gap} m along coordinate {axis} is not greater than {least} m")]
    GapNotPositive {
        /// The coordinate.
        axis: usize,
        /// The gap asked for, metres.
        gap: f64,
        /// It must be greater than this, metres.
        least: f64,
    },
    /// [`crate::disassembly::Gap::Fraction`] outside (0, 1].
    #[error("the part {fraction} of the greatest gap is not in ({least}, {most}]")]
    FractionOutOfRange {
        /// The part asked for.
        fraction: f64,
        /// It must be greater than this.
        least: f64,
        /// It must not be greater than this.
        most: f64,
    },
    /// There are routes, but what was found out about them, by following them, is that
    /// they are blocked.
    #[error("every route found is blocked")]
    Blocked,
    /// The budget ended.
    #[error(transparent)]
    Spent(#[from] Spent),
}
