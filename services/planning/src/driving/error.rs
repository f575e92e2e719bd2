//! Why a robot cannot be driven as asked, with the numbers that would do.

use thiserror::Error;

use crate::budget::Spent;
use crate::geometry::{AxisBox, Vector};

/// Why a robot cannot be driven as asked. Corners and legs are counted from 0 in travel
/// order; metres and radians.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum DrivingError {
    /// The robot's reference point is not in the first channel.
    #[error(
        "the robot starts at ({:.4}, {:.4}), outside the first corridor, which runs from ({:.4}, {:.4}) to ({:.4}, {:.4})",
        position.x, position.y, channel.min().x, channel.min().y, channel.max().x, channel.max().y
    )]
    BodyOutside {
        /// Where the robot starts.
        position: Vector<2>,
        /// The first channel.
        channel: AxisBox<2>,
    },
    /// The robot touches a wall before it moves.
    #[error(
        "the robot, starting at ({:.4}, {:.4}), touches the wall at ({:.4}, {:.4})",
        position.x, position.y, wall.x, wall.y
    )]
    BodyTouchesWall {
        /// Where the robot starts.
        position: Vector<2>,
        /// The wall point.
        wall: Vector<2>,
    },
    /// The goal is not in the last channel.
    #[error(
        "the goal ({:.4}, {:.4}) lies outside the last corridor, which runs from ({:.4}, {:.4}) to ({:.4}, {:.4})",
        position.x, position.y, channel.min().x, channel.min().y, channel.max().x, channel.max().y
    )]
    GoalOutside {
        /// The goal.
        position: Vector<2>,
        /// The last channel.
        channel: AxisBox<2>,
    },
    /// The robot would touch a wall at the goal.
    #[error(
        "the robot, at the goal ({:.4}, {:.4}) with heading {heading:.4}, touches the wall at ({:.4}, {:.4})",
        position.x, position.y, wall.x, wall.y
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
        "corner {corner}: a gap of {gap:.4} m is out of range, it must be more than {least:.4} m and at most {most:.4} m"
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
        "corners {first} and {second} are {has:.4} m apart, their guiding circles need {needs:.4} m; a gap of {most:.4} m is possible"
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
        "corner {corner} and its neighbours are too close: the path would turn by {sweep:.4} rad about it, which must be positive"
    )]
    CornerNotPassed {
        /// The corner.
        corner: usize,
        /// The angle, positive in the sense of the turn.
        sweep: f64,
    },
    /// A corridor is too narrow for the robot to turn at a corner.
    #[error(
        "corner {corner}: the corridors are {has:.4} m wide, the robot needs more than {needs:.4} m to turn"
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
        "the robot can't turn in place at ({:.4}, {:.4}) to heading {heading:.4}: the wall at ({:.4}, {:.4}) stops it at heading {free:.4}",
        position.x, position.y, wall.x, wall.y
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
        "the robot would touch the wall at ({:.4}, {:.4}), {at:.4} m along leg {leg}",
        wall.x, wall.y
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
