//! The gap with the greatest clearance.

use crate::budget::{Budget, Spent};

use super::limits::TurnRoom;
use super::{Corner, CornerGaps, Drive, DrivingError, DrivingPath, drive};

/// Precision of the safest gap if it has no closed form, metres.
const PRECISION: f64 = 1e-10;

/// A clearance within this of the gap counts as equal to it, metres.
const ATTAINED: f64 = 1e-9;

/// The number of gaps tried before the search narrows.
const TRIALS: usize = 48;

/// Ratio of each to the one before: 48 steps lead down to a millionth.
const RATIO: f64 = 0.75;

/// The gap, equal at all corners, with the greatest clearance from the first arriving to the
/// last leaving point, metres; 0 without corners. `path` is left with its path.
///
/// If the measured clearance is the gap that leaves as much to the outer wall as to the corner
/// of the narrowest corridor ([`balanced_gap`](super::limits::balanced_gap)), and a larger gap leaves less, it is that gap.
/// Otherwise (corners interact, the walls are not those of the corridors, or start and goal
/// allow less) the measured clearance is maximised to 1e-9 m among the gaps whose guiding
/// circles do not reach beyond the narrowest corridor. In overlapping corridors a gap may lead
/// the path past some corners; such gaps are found in the second case only.
pub fn safest(
    task: &Drive<'_>,
    path: &mut DrivingPath,
    budget: &Budget<'_>,
) -> Result<f64, DrivingError> {
    let rooms = task.corners.iter().map(|corner| TurnRoom::at(&task.footprint, corner)[0]);
    let Some((narrowest, room)) = rooms.enumerate().min_by(|(_, a), (_, b)| a.compare(b)) else {
        drive(task, CornerGaps::Uniform(0.0), path, budget)?;
        return Ok(0.0);
    };
    let balanced = room.balanced_gap();
    let mut turning = |gap: f64| -> Trial {
        match drive(task, CornerGaps::Uniform(gap), path, budget) {
            Ok(()) => Ok(Ok(path.turning.map_or(f64::INFINITY, |turning| turning.value))),
            Err(DrivingError::Spent(spent)) => Err(spent),
            Err(refusal) => Ok(Err(refusal)),
        }
    };
    if is_peak(&mut turning, balanced)? {
        return Ok(balanced);
    }
    let width = task.corners.iter().map(Corner::width).fold(f64::INFINITY, f64::min);
    let most = width - task.footprint.width() / 2.0;
    if most <= 0.0 {
        let (has, needs) = (room.width, room.least_width());
        return Err(DrivingError::CornerTooNarrow { corner: narrowest, has, needs });
    }
    let found = maximise(&mut turning, most)?;
    drive(task, CornerGaps::Uniform(found), path, budget)?;
    Ok(found)
}

/// The clearance with a gap, or why the gap is refused.
type Trial = Result<Result<f64, DrivingError>, Spent>;

/// Whether `gap` has the clearance `gap`, and a larger one has less. `gap` itself is tried
/// last.
fn is_peak(turning: &mut impl FnMut(f64) -> Trial, gap: f64) -> Result<bool, Spent> {
    if gap.is_nan() || gap <= 0.0 {
        return Ok(false);
    }
    // A step well above rounding, even far from the origin.
    let beyond = turning(gap + 1e-6)?.unwrap_or(0.0);
    Ok(beyond < gap && turning(gap)?.is_ok_and(|there| there >= gap - ATTAINED))
}

/// The gap up to `most` with the greatest clearance: the best of a geometric series, then
/// golden section between its neighbours. Refused gaps count as clearance 0; if all are
/// refused, the error is that of the least.
fn maximise(turning: &mut impl FnMut(f64) -> Trial, most: f64) -> Result<f64, DrivingError> {
    let mut best = (0.0, 0.0);
    let mut refusal = None;
    let mut gap = most;
    for _ in 0..TRIALS {
        match turning(gap)? {
            Ok(value) if value > best.1 => best = (gap, value),
            Ok(_) => {}
            Err(error) => refusal = Some(error),
        }
        gap *= RATIO;
    }
    if let (true, Some(error)) = (best.1 == 0.0, refusal) {
        return Err(error);
    }
    let mut value = |gap: f64| turning(gap).map(|clearance| clearance.unwrap_or(0.0));
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = (best.0 * RATIO, (best.0 / RATIO).min(most));
    let mut lower = high - golden * (high - low);
    let mut upper = low + golden * (high - low);
    let (mut at_lower, mut at_upper) = (value(lower)?, value(upper)?);
    // Ends as well where no numbers are left between: large ones are farther apart than the
    // precision.
    while high - low > PRECISION && low < lower && lower < upper && upper < high {
        // Ties go to the shorter path.
        if at_lower >= at_upper {
            (high, upper, at_upper) = (upper, lower, at_lower);
            lower = high - golden * (high - low);
            at_lower = value(lower)?;
        } else {
            (low, lower, at_lower) = (lower, upper, at_upper);
            upper = low + golden * (high - low);
            at_upper = value(upper)?;
        }
        for (gap, value) in [(lower, at_lower), (upper, at_upper)] {
            if value > best.1 {
                best = (gap, value);
            }
        }
    }
    Ok(best.0)
}
