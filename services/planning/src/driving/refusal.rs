//! Finds out why a robot cannot be driven as asked, and which numbers would do.

use super::limits::TurnRoom;
use super::{CONTACT, CornerGaps, Drive, DrivingError};
use crate::budget::{Budget, Spent};
use crate::clearance::rectangle::{Met, clearance_rectangle_pose};
use crate::geometry::{AxisBox, Vector};
use crate::motion::{Curve, Leg, wrapped};

/// Checks that start and goal lie in their channels.
pub(super) fn check_ends(drive: &Drive<'_>) -> Result<(), DrivingError> {
    let inside = |point: &Vector<2>, channel: &AxisBox<2>| {
        (0..2).all(|axis| channel.min()[axis] <= point[axis] && point[axis] <= channel.max()[axis])
    };
    let (position, channel) = (drive.start.position, drive.first);
    if !inside(&position, &channel) {
        return Err(DrivingError::BodyOutside { position, channel });
    }
    let (position, channel) = (drive.goal.position, drive.last);
    if !inside(&position, &channel) {
        return Err(DrivingError::GoalOutside { position, channel });
    }
    Ok(())
}

/// Checks that the robot at its start touches no wall and is not inside a solid.
pub(super) fn check_start(drive: &Drive<'_>, budget: &Budget<'_>) -> Result<(), DrivingError> {
    let position = drive.start.position;
    let inside = drive.walls.solid_around(&position, budget)?;
    let touched = match inside {
        Some(index) => Some(drive.walls.as_slice()[index].from),
        None => touched(drive, &position, drive.start.heading, budget)?,
    };
    match touched {
        Some(wall) => Err(DrivingError::BodyTouchesWall { position, wall }),
        None => Ok(()),
    }
}

/// The wall point that the robot touches at a pose, if it does.
fn touched(
    drive: &Drive<'_>,
    position: &Vector<2>,
    heading: f64,
    budget: &Budget<'_>,
) -> Result<Option<Vector<2>>, Spent> {
    let near = clearance_rectangle_pose(&drive.footprint, position, heading, drive.walls, budget)?;
    Ok(near.filter(|near| near.value <= CONTACT).map(|near| near.wall))
}

/// Checks that there is a positive gap for every corner.
pub(super) fn check_gaps(drive: &Drive<'_>, gaps: &CornerGaps<'_>) -> Result<(), DrivingError> {
    let needs = drive.corners.len();
    if let CornerGaps::PerCorner(gaps) = gaps
        && gaps.len() != needs
    {
        return Err(DrivingError::GapCount { has: gaps.len(), needs });
    }
    for corner in 0..needs {
        let gap = gaps.at(corner);
        if !(gap > 0.0 && gap.is_finite()) {
            return Err(gap_out_of_range(drive, corner, gap));
        }
    }
    Ok(())
}

fn gap_out_of_range(drive: &Drive<'_>, corner: usize, gap: f64) -> DrivingError {
    let most = greatest_gap(&rooms(drive, corner)).max(0.0);
    DrivingError::GapOutOfRange { corner, gap, least: 0.0, most }
}

fn rooms(drive: &Drive<'_>, corner: usize) -> [TurnRoom; 2] {
    TurnRoom::at(&drive.footprint, &drive.corners[corner])
}

/// The gap at which the robot touches the outer wall of the corridor with less room, metres.
fn greatest_gap(rooms: &[TurnRoom; 2]) -> f64 {
    rooms[0].greatest_gap().min(rooms[1].greatest_gap())
}

/// Why the robot touches a wall on leg `index`.
pub(super) fn contact(
    drive: &Drive<'_>,
    gaps: &CornerGaps<'_>,
    legs: &[Leg<2>],
    (index, met): (usize, &Met),
    budget: &Budget<'_>,
) -> Result<DrivingError, Spent> {
    if let Some(error) = contact_at_goal(drive, legs, budget)? {
        return Ok(error);
    }
    let leg = &legs[index];
    if let Curve::Turn { position, from_heading, sweep } = leg.curve {
        return Ok(DrivingError::TurnBlocked {
            leg: index,
            position,
            heading: leg.curve.end_heading(),
            free: wrapped(from_heading + met.along * sweep),
            wall: met.wall,
        });
    }
    // A line is blocked if the arcs beside it leave too little room.
    let is_arc = matches!(leg.curve, Curve::Arc { .. });
    let beside = if is_arc { index..=index } else { index.saturating_sub(1)..=index + 1 };
    for corner in beside.filter_map(|index| {
        let leg = legs.get(index)?;
        leg.junction.filter(|_| matches!(leg.curve, Curve::Arc { .. }))
    }) {
        let rooms = rooms(drive, corner);
        if let Some(room) = rooms.iter().find(|room| room.width <= room.least_width()) {
            let (has, needs) = (room.width, room.least_width());
            return Ok(DrivingError::CornerTooNarrow { corner, has, needs });
        }
        if gaps.at(corner) >= greatest_gap(&rooms) {
            return Ok(gap_out_of_range(drive, corner, gaps.at(corner)));
        }
    }
    let at = met.along * leg.curve.length();
    Ok(DrivingError::WallInTheWay { leg: index, at, wall: met.wall })
}

/// The error if the robot touches a wall at the goal.
fn contact_at_goal(
    drive: &Drive<'_>,
    legs: &[Leg<2>],
    budget: &Budget<'_>,
) -> Result<Option<DrivingError>, Spent> {
    let arrives = || {
        let curve = legs.last()?.curve;
        (!matches!(curve, Curve::Arc { .. })).then(|| curve.end_heading())
    };
    let position = drive.goal.position;
    let Some(heading) = drive.goal.heading.or_else(arrives).map(wrapped) else { return Ok(None) };
    let wall = touched(drive, &position, heading, budget)?;
    Ok(wall.map(|wall| DrivingError::GoalTouchesWall { position, heading, wall }))
}
