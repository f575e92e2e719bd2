//! Driving a rectangular mobile robot through corridors (section 5).
//!
//! The robot's reference point follows straight lines and arcs of guiding circles about the corners
//! inside the turns (equation 5.1), with its heading tangent to them. The lines are common
//! tangents of the circles; Table 2 ([`rules`]) names the turn at every corner. What the paper
//! leaves to trial and error is computed: the clearance that remains ([`drive`]) and the gap
//! with the greatest clearance ([`safest`]).
//!
//! ```
//! use std::f64::consts::FRAC_PI_2;
//! use planning::budget::Budget;
//! use planning::clearance::rectangle::Footprint;
//! use planning::driving::{CornerGaps, Drive, DrivingPath, Goal, Pose, StartTurn, corners_of, drive};
//! use planning::free_space::walls::{Complement, Walls};
//! use planning::free_space::{Chain, End};
//! use planning::geometry::AxisBox;
//!
//! // Up a corridor 3 m wide and to the right along another: rule 1 of Table 2.
//! let budget = Budget::default();
//! let first = AxisBox::new([0.0, 0.0].into(), [3.0, 10.0].into())?;
//! let last = AxisBox::new([0.0, 7.0].into(), [12.0, 10.0].into())?;
//! let start = Pose { position: [2.0, 2.0].into(), heading: FRAC_PI_2 };
//! let goal = Goal { position: [10.0, 8.0].into(), heading: None };
//! let (mut chain, mut corners, mut walls) = (Chain::default(), Vec::new(), Walls::default());
//! chain.build(&[first, last], &start.position, End::Goal(goal.position), &budget)?;
//! corners_of(&chain, &mut corners);
//! walls.set_complement(chain.channels(), None, &mut Complement::default(), &budget)?;
//!
//! let footprint = Footprint::new(1.0, 1.5)?;
//! let (start_turn, corners, walls) = (StartTurn::InPlace, &corners[..], &walls);
//! let task = Drive { footprint, start, goal, start_turn, first, last, corners, walls };
//! let mut path = DrivingPath::default();
//! drive(&task, CornerGaps::Uniform(0.5), &mut path, &budget)?;
//!
//! // 5 m up, a quarter of the guiding circle of radius 1 m about (3, 7), and 7 m to the right.
//! let lengths: Vec<_> = path.legs().iter().map(|leg| leg.curve.length()).collect();
//! for (length, expected) in lengths.iter().zip([5.0, FRAC_PI_2, 7.0]) {
//!     assert!((length - expected).abs() < 1e-12);
//! }
//! assert_eq!(path.legs()[1].rule.map(|rule| (rule.table, rule.number)), Some((2, 1)));
//! // The corner stays 0.5 m from the robot's side.
//! assert!((path.clearance().expect("there are walls").value - 0.5).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::f64::consts::{PI, TAU};

use crate::budget::Budget;
use crate::clearance::Clearance;
use crate::clearance::rectangle::{self, Footprint, Met};
use crate::free_space::Chain;
use crate::free_space::walls::Walls;
use crate::geometry::{AxisBox, Direction, Vector};
use crate::motion::{Curve, Leg, wrapped};

pub use crate::motion::Pose;

mod error;
pub(crate) mod legs;
pub mod limits;
mod refusal;
pub mod rules;
mod safest;
pub(crate) mod tangent;
mod taut;

pub(crate) use taut::STRAIGHT;

pub use error::DrivingError;
pub use safest::safest;

use legs::Rounding;
use rules::TurnRule;
use taut::Knot;

/// Where the robot is to go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Of the reference point, metres.
    pub position: Vector<2>,
    /// Radians; `None`: the heading that it arrives with.
    pub heading: Option<f64>,
}

/// How the robot turns from its first heading to that of the first line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum StartTurn {
    /// By a turn in place.
    #[default]
    InPlace,
    /// Evenly along the first line, as in the paper.
    WhileMoving,
}

/// The gap between the robot's side and the corners that it turns about (gap_r in equation
/// 5.1), metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CornerGaps<'a> {
    /// One gap for all corners.
    Uniform(f64),
    /// One gap per corner, in travel order.
    PerCorner(&'a [f64]),
}

impl CornerGaps<'_> {
    /// The gap at a corner, metres.
    pub fn at(&self, corner: usize) -> f64 {
        match self {
            Self::Uniform(gap) => *gap,
            Self::PerCorner(gaps) => gaps[corner],
        }
    }
}

/// The corner of a junction that a robot turns about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// p_n, the corner of the corridor inside the turn, metres.
    pub point: Vector<2>,
    /// The rule of Table 2 for this turn.
    pub rule: &'static TurnRule,
    /// Width of the corridor the robot comes from, measured from `point`, metres.
    pub width_in: f64,
    /// Width of the corridor it goes into, measured from `point`, metres.
    pub width_out: f64,
}

impl Corner {
    /// The corner of the junction of two channels, entered along `approach` and left along
    /// `leave`; `None` unless the channels overlap and the directions have different axes.
    pub fn new(
        incoming: &AxisBox<2>,
        outgoing: &AxisBox<2>,
        approach: Direction,
        leave: Direction,
    ) -> Option<Self> {
        let rule = TurnRule::of(approach, leave)?;
        let point = rule.corner_of(&incoming.intersection(outgoing)?);
        Some(Self {
            point,
            rule,
            width_in: leave.coordinate(&point) - range(incoming, leave).0,
            width_out: range(outgoing, approach).1 - approach.coordinate(&point),
        })
    }

    /// Width of the narrower of the two corridors, metres.
    pub fn width(&self) -> f64 {
        self.width_in.min(self.width_out)
    }
}

/// Least and greatest coordinate of a box along a direction, metres.
fn range(channel: &AxisBox<2>, along: Direction) -> (f64, f64) {
    let (a, b) = (along.coordinate(&channel.min()), along.coordinate(&channel.max()));
    (a.min(b), a.max(b))
}

/// Refills `corners` with those of a chain, in travel order.
pub fn corners_of(chain: &Chain<2>, corners: &mut Vec<Corner>) {
    corners.clear();
    let pairs = chain.channels().windows(2).zip(chain.junctions());
    corners.extend(pairs.map(|(pair, corner)| {
        Corner::new(&pair[0], &pair[1], corner.approach, corner.leaving)
            .expect("consecutive channels of a chain overlap and have different axes")
    }));
}

/// A task: a robot, its start and goal, and what lies between.
#[derive(Debug, Clone, Copy)]
pub struct Drive<'a> {
    /// The robot.
    pub footprint: Footprint,
    /// Where it starts.
    pub start: Pose,
    /// Where it ends.
    pub goal: Goal,
    /// How it turns into the first line.
    pub start_turn: StartTurn,
    /// The first channel, which must hold the start.
    pub first: AxisBox<2>,
    /// The last channel, which must hold the goal.
    pub last: AxisBox<2>,
    /// The corners between, in travel order.
    pub corners: &'a [Corner],
    /// What the robot must not touch.
    pub walls: &'a Walls<2>,
}

/// A path for the robot. Reusable memory, refilled by every call.
#[derive(Debug, Clone, Default)]
pub struct DrivingPath {
    legs: Vec<Leg<2>>,
    leg_clearances: Vec<f64>,
    length: f64,
    clearance: Option<Clearance<2>>,
    turning: Option<Clearance<2>>,
    knots: Vec<Knot>,
    kept: Vec<bool>,
}

impl DrivingPath {
    /// Puts other legs in place of its own, with the clearance over each and over the whole motion.
    /// That in the turns is then no longer known.
    pub fn set_legs(
        &mut self,
        legs: Vec<Leg<2>>,
        leg_clearances: Vec<f64>,
        clearance: Option<Clearance<2>>,
    ) {
        self.length = legs.iter().map(|leg| leg.curve.length()).sum();
        (self.legs, self.leg_clearances) = (legs, leg_clearances);
        (self.clearance, self.turning) = (clearance, None);
    }

    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        self.legs.capacity() * size_of::<Leg<2>>()
            + self.leg_clearances.capacity() * size_of::<f64>()
            + self.knots.capacity() * size_of::<Knot>()
            + self.kept.capacity()
    }

    /// The legs in travel order.
    pub fn legs(&self) -> &[Leg<2>] {
        &self.legs
    }

    /// The clearance over every leg, metres; infinite without walls, empty after [`route`].
    pub fn leg_clearances(&self) -> &[f64] {
        &self.leg_clearances
    }

    /// Arc length of the reference point's path, metres.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The clearance over the whole motion; `None` without walls and after [`route`].
    pub fn clearance(&self) -> Option<Clearance<2>> {
        self.clearance
    }

    /// The clearance from the first arriving point to the last leaving point, which depends
    /// on the gap; over the whole motion if there is no arc. `at` counts from the start of
    /// the motion. `None` as for [`DrivingPath::clearance`].
    pub fn turning(&self) -> Option<Clearance<2>> {
        self.turning
    }
}

/// A clearance up to this counts as contact, metres.
pub(crate) const CONTACT: f64 = 1e-12;

/// Finds the path with these gaps and measures its clearance; an error if the robot would
/// touch a wall.
pub fn drive(
    drive: &Drive<'_>,
    gaps: CornerGaps<'_>,
    path: &mut DrivingPath,
    budget: &Budget<'_>,
) -> Result<(), DrivingError> {
    route(drive, gaps, path, budget)?;
    refusal::check_start(drive, budget)?;
    let footprint = &drive.footprint;
    let is_arc = |leg: &Leg<2>| matches!(leg.curve, Curve::Arc { .. });
    let first_arc = path.legs.iter().position(is_arc);
    let last_arc = path.legs.iter().rposition(is_arc);

    let (mut whole, mut turning) = (Met::NOTHING, Met::NOTHING);
    let DrivingPath { legs, leg_clearances, .. } = &mut *path;
    rectangle::nearest_along(footprint, legs, drive.walls, budget, |index, met, at| {
        if met.value <= CONTACT {
            return Err(refusal::contact(drive, &gaps, legs, (index, met), budget)?);
        }
        whole.offer(met.value, at, met.wall);
        if first_arc <= Some(index) && Some(index) <= last_arc {
            turning.offer(met.value, at, met.wall);
        }
        leg_clearances.push(met.value);
        Ok::<_, DrivingError>(())
    })?;
    path.clearance = whole.clearance();
    path.turning = if first_arc.is_some() { turning.clearance() } else { path.clearance };
    Ok(())
}

/// Finds the legs and the length of the path with these gaps, regardless of walls.
///
/// A robot that is at its goal already turns in place by nothing: one leg.
pub fn route(
    drive: &Drive<'_>,
    gaps: CornerGaps<'_>,
    path: &mut DrivingPath,
    budget: &Budget<'_>,
) -> Result<(), DrivingError> {
    let DrivingPath { legs, leg_clearances, length, clearance, turning, knots, kept } = path;
    legs.clear();
    leg_clearances.clear();
    (*length, *clearance, *turning) = (0.0, None, None);

    refusal::check_ends(drive)?;
    refusal::check_gaps(drive, &gaps)?;
    let last = taut::tighten(drive, &gaps, knots, kept, budget)?;
    let rounding = |knot: &Knot| {
        let rule = Some(drive.corners[knot.corner].rule.name());
        Rounding { circle: knot.circle, sweep: None, junction: knot.corner, rule }
    };
    let lines = knots.iter().map(|knot| (&knot.arrival, Some(rounding(knot))));
    let ends = (&drive.start, drive.start_turn, &drive.goal);
    legs::write(ends, lines.chain([(&last, None)]), None, legs);
    *length = legs.iter().map(|leg| leg.curve.length()).sum();
    Ok(())
}

/// The signed angle from one heading to another by the shorter turn; half a turn goes left.
pub(crate) fn shortest_turn(from: f64, to: f64) -> f64 {
    let turn = wrapped(to - from);
    if turn <= -PI + SAME_HEADING { turn + TAU } else { turn }
}

/// Headings that differ by no more than this count as equal, radians.
pub(crate) const SAME_HEADING: f64 = 1e-12;

#[cfg(test)]
mod tests;
