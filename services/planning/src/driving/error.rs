//! Why a robot cannot be driven as asked, with the numbers that would do.

use thiserror::Error;

use crate::budget::Spent;
use crate::geometry::number::{Number, Point};
use crate::geometry::{AxisBox, Vector};

/// Why a robot cannot be driven as asked. Corners and legs are counted from 0 in travel
/// order; metres and radians.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum DrivingError {
    /// The robot's reference point is not in the first channel.
    #[error(
        "the robot starts at {:.4}, outside the first corridor, which runs from {:.4} to {:.4}",
        Point(position), Point(&channel.min()), Point(&channel.max())
    )]
    BodyOutside {
        /// Where the robot starts.
        position: Vector<2>,
        /// The first channel.
        channel: AxisBox<2>,
    },
    /// The robot touches a wall before it moves.
    #[error(
        "the robot, starting at {:.4}, touches the wall at {:.4}",
        Point(position),
        Point(wall)
    )]
    BodyTouchesWall {
        /// Where the robot starts.
        position: Vector<2>,
        /// The wall point.
        wall: Vector<2>,
    },
    /// The goal is not in the last channel.
    #[error(
        "the goal {:.4} lies outside the last corridor, which runs from {:.4} to {:.4}",
        Point(position), Point(&channel.min()), Point(&channel.max())
    )]
    GoalOutside {
        /// The goal.
        position: Vector<2>,
        /// The last channel.
        channel: AxisBox<2>,
    },
    /// The robot would touch a wall at the goal.
    #[error(
        "the robot, at the goal {:.4} with heading {:.4}, touches the wall at {:.4}",
        Point(position), Number(*heading), Point(wall)
    )]
    GoalTouchesWall {
        /// The goal.
        position: Vector<2>,
        /// Heading there.
        heading: f64,
        /// The wall point.
        wall: Vector<2>,
    },
    /// There must be one gap for every corner.
    #[error("{has} gaps for {needs} corners")]
    GapCount {
        /// Gaps given.
        has: usize,
        /// Corners.
        needs: usize,
    },
    /// A gap is not possible at a corner.
    #[error(
        "corner {corner}: a gap of {:.4} m is out of range, it must be more than {:.4} m and at most {:.4} m",
        Number(*gap), Number(*least), Number(*most)
    )]
    GapOutOfRange {
        /// The corner.
        corner: usize,
        /// The gap asked for.
        gap: f64,
        /// It must be more than this.
        least: f64,
        /// It must not be more than this.
        most: f64,
    },
    /// No tangent joins the guiding circles of two corners.
    #[error(
        "corners {first} and {second} are {:.4} m apart, their guiding circles need {:.4} m; a gap of {:.4} m is possible",
        Number(*has), Number(*needs), Number(*most)
    )]
    CornersTooClose {
        /// The corner entered first.
        first: usize,
        /// The next one.
        second: usize,
        /// Distance between the two.
        has: f64,
        /// Distance that the gaps need.
        needs: f64,
        /// The largest possible gap: at both corners if they turn to different sides, otherwise
        /// at the one with the larger gap.
        most: f64,
    },
    /// The taut path would have to turn backwards about a corner, and cut it if it left it out.
    #[error(
        "corner {corner} and its neighbours are too close: the path would turn by {:.4} rad about it, which must be positive",
        Number(*sweep)
    )]
    CornerNotPassed {
        /// The corner.
        corner: usize,
        /// The angle, positive in the sense of the turn.
        sweep: f64,
    },
    /// A corridor is too narrow for the robot to turn at a corner.
    #[error(
        "corner {corner}: the corridors are {:.4} m wide, the robot needs more than {:.4} m to turn",
        Number(*has), Number(*needs)
    )]
    CornerTooNarrow {
        /// The corner.
        corner: usize,
        /// Width of the narrower corridor.
        has: f64,
        /// It must be wider than this.
        needs: f64,
    },
    /// A wall blocks a turn in place.
    #[error(
        "the robot can't turn in place at {:.4} to heading {:.4}: the wall at {:.4} stops it at heading {:.4}",
        Point(position), Number(*heading), Point(wall), Number(*free)
    )]
    TurnBlocked {
        /// The leg that is this turn.
        leg: usize,
        /// Where.
        position: Vector<2>,
        /// The heading wanted, in (-pi, pi].
        heading: f64,
        /// The heading at which it first touches the wall, in (-pi, pi].
        free: f64,
        /// The wall point.
        wall: Vector<2>,
    },
    /// The robot would touch a wall on a line or an arc.
    #[error(
        "the robot would touch the wall at {:.4}, {:.4} m along leg {leg}",
        Point(wall), Number(*at)
    )]
    WallInTheWay {
        /// The leg.
        leg: usize,
        /// Arc length on the leg, metres.
        at: f64,
        /// The wall point.
        wall: Vector<2>,
    },
    /// The budget ended.
    #[error(transparent)]
    Spent(#[from] Spent),
}
