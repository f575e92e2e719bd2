//! The rectangular mobile robot through corridors: section 5 of the paper.
//!
//! The robot's centre follows straight lines and arcs of guiding circles about
//! the corners inside the turns (equation 5.1), its heading tangent to them.
//! Lines are the common tangents of the circles; Table 2 names what happens at
//! every corner ([`rules`]). What the paper leaves to trial and error is
//! computed: the clearance that remains ([`drive`]) and the gap that makes it
//! greatest ([`safest`]).

use std::f64::consts::{PI, TAU};

use crate::budget::Budget;
use crate::clearance::Clearance;
use crate::clearance::rectangle::{self, Footprint, Met};
use crate::free_space::Chain;
use crate::free_space::walls::Walls;
use crate::geometry::{AxisBox, Direction, Vector};
use crate::motion::{Curve, Leg, wrapped};

mod error;
mod legs;
pub mod limits;
mod refusal;
pub mod rules;
mod safest;
pub(crate) mod tangent;
mod taut;

pub use error::DrivingError;
pub use safest::safest;

use rules::TurnRule;
use taut::Knot;

/// Where the robot is: its centre, metres, and its heading, radians
/// counter-clockwise from +x (any finite value).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Centre of the footprint, metres.
    pub position: Vector<2>,
    /// Radians.
    pub heading: f64,
}

/// Where the robot is to go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Centre of the footprint, metres.
    pub position: Vector<2>,
    /// Radians; `None`: the heading that it arrives with.
    pub heading: Option<f64>,
}

/// How the robot gets from its first heading into that of the first line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum StartTurn {
    /// By a turn in place.
    #[default]
    InPlace,
    /// Evenly on its way along the first line, as the paper has it.
    WhileMoving,
}

/// The gap between the robot's side and the corners it turns about (gap_r in
/// equation 5.1), metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gaps<'a> {
    /// One for all corners.
    Uniform(f64),
    /// One for each, in travel order.
    PerCorner(&'a [f64]),
}

impl Gaps<'_> {
    /// The gap at a corner, metres.
    pub fn at(&self, corner: usize) -> f64 {
        match self {
            Self::Uniform(gap) => *gap,
            Self::PerCorner(gaps) => gaps[corner],
        }
    }
}

/// What a junction is to a robot that turns in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// p_n: the corner of the corridor inside the turn.
    pub point: Vector<2>,
    /// The rule of Table 2 for this turn.
    pub rule: &'static TurnRule,
    /// Width of the corridor the robot comes from, measured from `point`, metres.
    pub width_in: f64,
    /// Width of the corridor it goes into, measured from `point`, metres.
    pub width_out: f64,
}

impl Corner {
    /// The corner of a junction of two channels, entered along `approach` and left
    /// along `leave`; `None` unless the channels overlap and these are along
    /// different axes.
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
    let pairs = chain.channels().windows(2).zip(chain.corners());
    corners.extend(pairs.map(|(pair, corner)| {
        Corner::new(&pair[0], &pair[1], corner.approach, corner.leaving)
            .expect("consecutive channels of a chain overlap and have different axes")
    }));
}

/// What is asked: a robot, where it starts and ends, and what is between.
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
    /// The first channel; the start must lie in it.
    pub first: AxisBox<2>,
    /// The last channel; the goal must lie in it.
    pub last: AxisBox<2>,
    /// The junctions between, in travel order.
    pub corners: &'a [Corner],
    /// What the robot must not touch.
    pub walls: &'a Walls<2>,
}

/// A way for the robot, and the buffers that are needed to find one; refilled by
/// every call.
#[derive(Debug, Clone, Default)]
pub struct Path {
    legs: Vec<Leg<2>>,
    leg_clearances: Vec<f64>,
    length: f64,
    clearance: Option<Clearance<2>>,
    turning: Option<Clearance<2>>,
    knots: Vec<Knot>,
    kept: Vec<bool>,
}

impl Path {
    /// The legs in travel order.
    pub fn legs(&self) -> &[Leg<2>] {
        &self.legs
    }

    /// The clearance over every leg, metres; infinite without walls. Empty after
    /// [`route`].
    pub fn leg_clearances(&self) -> &[f64] {
        &self.leg_clearances
    }

    /// Arc length of the centre's path, metres.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The clearance over the whole motion; `None` without walls and after
    /// [`route`].
    pub fn clearance(&self) -> Option<Clearance<2>> {
        self.clearance
    }

    /// The clearance from the first arriving point to the last leaving point,
    /// which the gap decides; over the whole motion if there is no arc. `at` counts
    /// from the beginning of the motion. `None` as for [`Path::clearance`].
    pub fn turning(&self) -> Option<Clearance<2>> {
        self.turning
    }
}

/// A clearance up to this counts as contact, metres.
const CONTACT: f64 = 1e-12;

/// Finds the way with these gaps, measures its clearance, and refuses it if the
/// robot would touch a wall.
pub fn drive(
    drive: &Drive<'_>,
    gaps: Gaps<'_>,
    path: &mut Path,
    budget: &Budget<'_>,
) -> Result<(), DrivingError> {
    route(drive, gaps, path, budget)?;
    refusal::check_start(drive, budget)?;
    let footprint = &drive.footprint;
    let is_arc = |leg: &Leg<2>| matches!(leg.curve, Curve::Arc { .. });
    let first_arc = path.legs.iter().position(is_arc);
    let last_arc = path.legs.iter().rposition(is_arc);

    let mut whole = Met::NOTHING;
    let mut turning = Met::NOTHING;
    let mut travelled = 0.0;
    let mut guess = footprint.width().max(footprint.length());
    for (index, leg) in path.legs.iter().enumerate() {
        let met = rectangle::nearest(footprint, &leg.curve, drive.walls, guess, budget)?;
        if met.value <= CONTACT {
            let legs = &path.legs;
            return Err(refusal::contact(drive, &gaps, legs, (index, &met), budget)?);
        }
        let length = leg.curve.length();
        let at = travelled + met.along * length;
        whole.offer(met.value, at, met.wall);
        if first_arc <= Some(index) && Some(index) <= last_arc {
            turning.offer(met.value, at, met.wall);
        }
        path.leg_clearances.push(met.value);
        travelled += length;
        guess = rectangle::next_guess(&met, guess);
    }
    path.clearance = whole.clearance();
    path.turning = if first_arc.is_some() { turning.clearance() } else { path.clearance };
    Ok(())
}

/// Finds the way with these gaps without regard to walls: legs and length only.
///
/// A robot that is at its goal already turns in place by nothing: one leg.
pub fn route(
    drive: &Drive<'_>,
    gaps: Gaps<'_>,
    path: &mut Path,
    budget: &Budget<'_>,
) -> Result<(), DrivingError> {
    let Path { legs, leg_clearances, length, clearance, turning, knots, kept } = path;
    legs.clear();
    leg_clearances.clear();
    (*length, *clearance, *turning) = (0.0, None, None);

    refusal::check_ends(drive)?;
    refusal::check_gaps(drive, &gaps)?;
    let last = taut::tighten(drive, &gaps, knots, kept, budget)?;
    legs::write(drive, knots, &last, legs);
    *length = legs.iter().map(|leg| leg.curve.length()).sum();
    Ok(())
}

/// The signed angle from one heading to another the shorter way round; half a
/// turn goes left.
fn shortest_turn(from: f64, to: f64) -> f64 {
    let turn = wrapped(to - from);
    if turn <= -PI + SAME_HEADING { turn + TAU } else { turn }
}

/// Headings that differ by no more than this are the same, radians.
const SAME_HEADING: f64 = 1e-12;

#[cfg(test)]
mod tests;
