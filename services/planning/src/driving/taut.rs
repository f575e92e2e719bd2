//! The taut path: the corners that it turns about, and the tangents between them.

use super::rules::TurnRule;
use super::tangent::{Circle, Tangent, tangent};
use super::{Corner, CornerGaps, Drive, DrivingError};
use crate::budget::Budget;
use crate::geometry::{Direction, Vector, unit, unrotated};

/// A corner that the path turns about.
#[derive(Debug, Clone, Copy)]
pub(super) struct Knot {
    /// Index of the corner.
    pub(super) corner: usize,
    /// Its guiding circle.
    pub(super) circle: Circle,
    /// The straight leg to it.
    pub(super) arrival: Tangent,
}

/// Turns by less than this do not count, radians.
pub(crate) const STRAIGHT: f64 = 1e-12;

/// Turns backwards by less than this do not count, radians: along lines of many metres
/// rounding does not tell corners apart any better.
pub(super) const ROUNDED: f64 = 1e-9;

/// How far a path may cut into the guiding circle of a corner that it leaves out, metres. The
/// exact clearance is measured afterwards.
const CLEARED: f64 = 1e-9;

/// Steps of the budget that one corner takes in one pass.
const STEPS_PER_CORNER: u64 = 8;

/// Finds the corners that the taut path from start to goal turns about; returns the last
/// straight leg.
///
/// A corner about which the path would turn backwards, or not at all, is left out and its
/// neighbours are joined, until all turns go forwards. If the result cuts a corner that was
/// left out, that corner is put back for good; if the path still turns backwards there, that
/// is an error.
pub(super) fn tighten(
    drive: &Drive<'_>,
    gaps: &CornerGaps<'_>,
    knots: &mut Vec<Knot>,
    kept: &mut Vec<bool>,
    budget: &Budget<'_>,
) -> Result<Tangent, DrivingError> {
    kept.clear();
    loop {
        budget.step(STEPS_PER_CORNER * drive.corners.len() as u64)?;
        let last = wind(drive, gaps, knots, kept)?;
        if knots.len() == drive.corners.len() || !put_back(drive, gaps, knots, &last, kept) {
            return Ok(last);
        }
    }
}

/// One pass from start to goal that leaves out corners turned about backwards, except those
/// in `kept`.
fn wind(
    drive: &Drive<'_>,
    gaps: &CornerGaps<'_>,
    knots: &mut Vec<Knot>,
    kept: &[bool],
) -> Result<Tangent, DrivingError> {
    knots.clear();
    for (index, corner) in drive.corners.iter().enumerate() {
        let circle = guiding_circle(drive, corner, gaps.at(index));
        let arrival = join(drive, gaps, knots, Some(index), &circle, kept)?;
        knots.push(Knot { corner: index, circle, arrival });
    }
    let goal = Circle { center: drive.goal.position, signed_radius: 0.0 };
    let last = join(drive, gaps, knots, None, &goal, kept)?;
    for (index, knot) in knots.iter().enumerate().filter(|(_, knot)| is_kept(kept, knot)) {
        let departure = knots.get(index + 1).map_or(&last, |next| &next.arrival);
        let corner = &drive.corners[knot.corner];
        if !turns_forwards(corner.rule, &knot.arrival.direction, &departure.direction) {
            let turn = unrotated(&departure.direction, &knot.arrival.direction);
            let sweep = corner.rule.turn.factor() * libm::atan2(turn.y, turn.x);
            if sweep.abs() < ROUNDED {
                continue;
            }
            return Err(DrivingError::CornerNotPassed { corner: knot.corner, sweep });
        }
    }
    Ok(last)
}

/// The tangent from the last knot (or the start) to the circle of `corner` (or the goal).
/// Removes knots about which the path would turn backwards.
fn join(
    drive: &Drive<'_>,
    gaps: &CornerGaps<'_>,
    knots: &mut Vec<Knot>,
    corner: Option<usize>,
    circle: &Circle,
    kept: &[bool],
) -> Result<Tangent, DrivingError> {
    loop {
        let Some(top) = knots.last() else {
            let start = Circle { center: drive.start.position, signed_radius: 0.0 };
            return match (tangent(&start, circle), corner) {
                (Some(line), _) => Ok(line),
                (None, Some(corner)) => {
                    Err(too_close_to_point(drive, gaps, &start, corner, circle))
                }
                // The goal is the start.
                (None, None) => Ok(Tangent {
                    from: start.center,
                    to: start.center,
                    direction: unit(drive.start.heading),
                    length: 0.0,
                }),
            };
        };
        let Some(line) = tangent(&top.circle, circle) else {
            return Err(match corner {
                Some(corner) => corners_too_close(drive, top, corner, circle),
                None => too_close_to_point(drive, gaps, circle, top.corner, &top.circle),
            });
        };
        let rule = drive.corners[top.corner].rule;
        if is_kept(kept, top) || turns_forwards(rule, &top.arrival.direction, &line.direction) {
            return Ok(line);
        }
        knots.pop();
    }
}

/// The guiding circle of a corner (equation 5.1), on the side of its turn.
fn guiding_circle(drive: &Drive<'_>, corner: &Corner, gap: f64) -> Circle {
    let radius = drive.footprint.width() / 2.0 + gap;
    Circle { center: corner.point, signed_radius: corner.rule.turn.factor() * radius }
}

fn is_kept(kept: &[bool], knot: &Knot) -> bool {
    kept.get(knot.corner) == Some(&true)
}

/// Whether a path that arrives and departs in these directions (unit vectors) turns forwards
/// about a corner.
fn turns_forwards(rule: &TurnRule, arrival: &Vector<2>, departure: &Vector<2>) -> bool {
    let turn = unrotated(departure, arrival);
    if rule.turn.factor() * turn.y > STRAIGHT {
        return true;
    }
    // Backwards by less than half a turn, or forwards by more? The sweep is a quarter turn
    // less the arriving and the leaving angle.
    let angle = |direction: &Vector<2>, along: Direction, across: Direction| {
        libm::atan2(across.coordinate(direction), along.coordinate(direction))
    };
    let arriving = angle(arrival, rule.approach, rule.leave);
    let leaving = angle(departure, rule.leave, rule.approach);
    arriving + leaving < 0.0
}

/// Marks, between any two neighbours on the path, the corner left out that their line cuts
/// most; returns whether there is one.
fn put_back(
    drive: &Drive<'_>,
    gaps: &CornerGaps<'_>,
    knots: &[Knot],
    last: &Tangent,
    kept: &mut Vec<bool>,
) -> bool {
    kept.resize(drive.corners.len(), false);
    let mut found = false;
    let mut next = 0;
    for index in 0..=knots.len() {
        let (line, end) = knots
            .get(index)
            .map_or((last, drive.corners.len()), |knot| (&knot.arrival, knot.corner));
        let mut worst = (CLEARED, None);
        for corner in next..end {
            let circle = guiding_circle(drive, &drive.corners[corner], gaps.at(corner));
            let cut = cut(line, &circle);
            if cut > worst.0 {
                worst = (cut, Some(corner));
            }
        }
        if let (_, Some(corner)) = worst {
            kept[corner] = true;
            found = true;
        }
        next = end + 1;
    }
    found
}

/// How far a line runs into a guiding circle, or past it on the wrong side, metres.
fn cut(line: &Tangent, circle: &Circle) -> f64 {
    let seen = unrotated(&(circle.center - line.from), &line.direction);
    let radius = circle.signed_radius.abs();
    if (0.0..=line.length).contains(&seen.x) {
        return radius - circle.signed_radius.signum() * seen.y;
    }
    let beyond = if seen.x < 0.0 { seen.x } else { seen.x - line.length };
    radius - (beyond * beyond + seen.y * seen.y).sqrt()
}

/// The error if start or goal lies inside a guiding circle.
fn too_close_to_point(
    drive: &Drive<'_>,
    gaps: &CornerGaps<'_>,
    point: &Circle,
    corner: usize,
    circle: &Circle,
) -> DrivingError {
    let apart = circle.center - point.center;
    let half_width = drive.footprint.width() / 2.0;
    DrivingError::GapOutOfRange {
        corner,
        gap: gaps.at(corner),
        least: 0.0,
        most: (apart.dot(&apart).sqrt() - half_width).max(0.0),
    }
}

/// The error if two guiding circles have no common tangent.
fn corners_too_close(
    drive: &Drive<'_>,
    top: &Knot,
    second: usize,
    circle: &Circle,
) -> DrivingError {
    let apart = circle.center - top.circle.center;
    let has = apart.dot(&apart).sqrt();
    let (one, other) = (top.circle.signed_radius, circle.signed_radius);
    let half_width = drive.footprint.width() / 2.0;
    let most = if one * other < 0.0 {
        has / 2.0 - half_width
    } else {
        one.abs().min(other.abs()) + has - half_width
    };
    DrivingError::CornersTooClose {
        first: top.corner,
        second,
        has,
        needs: (other - one).abs(),
        most: most.max(0.0),
    }
}
