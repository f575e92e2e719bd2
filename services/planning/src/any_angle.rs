//! Driving among walls at any angle.
//!
//! Free space is a [`Floor`]: faces are channels, the edges between them junctions. The robot
//! follows the taut path of its guiding circles, straight lines and arcs about the corners of the
//! walls. Where the rectangle does not fit along it, other ways are tried, rung by rung
//! ([`Rung`](crate::motion::Rung)).

use thiserror::Error;

use crate::budget::Spent;
use crate::clearance::Clearance;
use crate::clearance::rectangle::Footprint;
use crate::driving::{Goal, Pose, StartTurn};
use crate::free_space::floor::Floor;
use crate::free_space::walls::Walls;
use crate::geometry::Vector;
use crate::geometry::number::{Number, Point};
use crate::motion::Leg;

mod arc_memo;
mod backwards;
mod bound;
mod disc;
mod disc_path;
mod drive;
mod fuse;
mod ladder;
mod lattice;
mod legs;
mod measure;
mod planner;
mod pockets;
mod queue;
mod refusal;
mod safest;
mod sight;
mod taut;
mod travelled;

pub use bound::certify;
pub use disc_path::disc_path;
pub use drive::drive;
pub use lattice::Resolution;
pub use planner::Planner;
pub use travelled::ChannelsTravelled;

/// A robot, where it stands, and where it is to go.
#[derive(Debug, Clone, Copy)]
pub struct Errand<'a> {
    /// The rectangle that the robot covers.
    pub footprint: Footprint,
    /// Where it stands.
    pub start: Pose,
    /// Where it is to go.
    pub goal: Goal,
    /// How it takes up its first heading.
    pub start_turn: StartTurn,
    /// What it may do.
    pub abilities: Abilities,
    /// What turns and stops count.
    pub costs: Costs,
    /// The walls, to which clearance is measured.
    pub walls: &'a Walls<2>,
    /// The free space among them.
    pub floor: &'a Floor,
}

impl Errand<'_> {
    /// The robot touches a wall that is no farther away, metres.
    fn contact(&self) -> f64 {
        CONTACT * self.footprint.width()
    }

    /// To what clearances are found, metres. Smaller differences are rounding.
    fn precision(&self) -> f64 {
        PRECISION * self.footprint.width()
    }

    /// The least gap, metres: a disc that comes nearer to a wall can't be told from one that
    /// touches it.
    fn least_gap(&self) -> f64 {
        self.precision().max(2.0 * self.floor.rounding())
    }
}

/// What a robot may do besides driving forwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Abilities {
    /// Drive backwards.
    pub reverse: bool,
    /// Turn in place.
    pub turn_in_place: bool,
    /// The least radius of an arc, metres.
    pub min_turn_radius: f64,
}

impl Default for Abilities {
    fn default() -> Self {
        Self { reverse: false, turn_in_place: true, min_turn_radius: 0.0 }
    }
}

/// What turns in place and stops count, beside the length of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Costs {
    /// Metres a radian turned in place.
    pub turn: f64,
    /// Metres a stop on the way.
    pub stop: f64,
}

impl Costs {
    /// Those that grow with the robot, so that the unit does not matter: a quarter of its length
    /// a radian, and a tenth of it a stop.
    pub fn of(footprint: &Footprint) -> Self {
        let length = footprint.length();
        Self { turn: 0.25 * length, stop: 0.1 * length }
    }
}

/// Those of a robot that is 1 m long.
impl Default for Costs {
    fn default() -> Self {
        Self { turn: 0.25, stop: 0.1 }
    }
}

/// Which of all motions is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wish {
    /// The shortest that keeps this gap between the robot's side and the corners that it turns
    /// about, metres.
    Gap(f64),
    /// The shortest whose free clearance is at least this, metres.
    AtLeast(f64),
    /// That with the greatest free clearance, and among those the shortest.
    Safest,
}

/// A motion that was found.
#[derive(Debug, Clone, Default)]
pub struct RobotMotion {
    /// The legs in travel order.
    pub legs: Vec<Leg<2>>,
    /// The clearance over every leg, metres; infinite without walls.
    pub leg_clearances: Vec<f64>,
    /// The gap kept from the corners, metres.
    pub gap: f64,
    /// Arc length, metres.
    pub length: f64,
    /// The clearance over the whole motion; `None` without walls.
    pub clearance: Option<Clearance<2>>,
    /// The clearance apart from walls that are nearer at the start or the goal, metres.
    pub free_clearance: f64,
    /// No motion with this free clearance is shorter, metres.
    pub bound: f64,
    /// Whether the search for it came to an end.
    pub is_complete: bool,
    /// The length of the taut path at the gap, if that was found on the way to this motion,
    /// metres: a bound of all that keeps the gap.
    pub taut_length: Option<f64>,
}

impl RobotMotion {
    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.legs.capacity() * size_of::<Leg<2>>()
            + self.leg_clearances.capacity() * size_of::<f64>()
    }
}

/// Why there is no motion.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NoMotion {
    /// The robot touches a wall, or is inside one, at the start or the goal.
    #[error("the robot touches a wall where it {}", if *.at_goal { "goes" } else { "stands" })]
    Occupied {
        /// At the goal.
        at_goal: bool,
        /// The wall point, metres.
        wall: Vector<2>,
    },
    /// No way is wide enough.
    #[error(
        "a passage is {} m wide; the robot needs more than {} m",
        Number(*has), Number(*needs)
    )]
    TooNarrow {
        /// The ends of the shortest line across the passage, metres.
        across: [Vector<2>; 2],
        /// Its width, metres.
        has: f64,
        /// What the robot needs, metres.
        needs: f64,
    },
    /// Walls separate the start from the goal.
    #[error("walls enclose the {}", if *.at_goal { "goal" } else { "start" })]
    Enclosed {
        /// The goal rather than the start.
        at_goal: bool,
        /// Where the walls are thinnest: points on both sides, metres.
        across: [Vector<2>; 2],
        /// How thick they are there, metres.
        thickness: f64,
    },
    /// There is a way for a disc, and none was found for the rectangle.
    #[error("the robot touches a wall at {}", Point(wall))]
    Blocked {
        /// The wall point that the last motion tried touches, metres.
        wall: Vector<2>,
        /// Whether it is a turn in place that touches it.
        turning: bool,
        /// Whether driving backwards would help.
        reverse_helps: bool,
        /// How finely other ways were searched; `None` if they were not, or need not be.
        resolution: Option<Resolution>,
    },
    /// The budget has been spent.
    #[error(transparent)]
    Spent(#[from] Spent),
}

/// Rounding of clearances that are nothing, as a part of the robot's width.
const CONTACT: f64 = 1e-12;

/// Clearances are found to this part of the robot's width, lengths to this part of them.
const PRECISION: f64 = 1e-9;

#[cfg(test)]
mod tests;
