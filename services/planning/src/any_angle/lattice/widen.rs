//! Leads straight legs farther from the walls.

use super::probe::Probe;
use super::shorten::directions;
use super::way::Way;
use crate::budget::Spent;
use crate::motion::Curve;

/// Points are moved by steps from the first to the last part of the turning circle's radius.
const FIRST_STEP: f64 = 0.25;
const LAST_STEP: f64 = 1e-8;

/// Moves by steps of one size.
const MOST_MOVES: usize = 24;

/// A move must lead away by this part of its step, and a piece be nearer by it to be the nearest.
const WORTH: f64 = 1e-4;

/// Steps of the budget that a move takes beside its looks at walls.
const STEPS_PER_MOVE: u64 = 10;

/// A leg, or the turn at a point.
#[derive(Debug, Clone, Copy)]
enum WayPiece {
    Leg(usize),
    Turn(usize),
}

/// Moves the points of a way as long as the piece that is nearest to a wall gets farther from it.
/// What counts is the free clearance.
pub(super) fn widen(way: &mut Way, probe: &Probe<'_>) -> Result<(), Spent> {
    let count = way.backs.len();
    let mut step = FIRST_STEP * probe.swing;
    while step > LAST_STEP * probe.swing {
        for _ in 0..MOST_MOVES {
            let mut worst: Option<(f64, WayPiece)> = None;
            let pieces = (0..count).map(WayPiece::Leg).chain((0..=count).map(WayPiece::Turn));
            for piece in pieces {
                let Some(curve) = curve_of(way, piece, probe) else { continue };
                let is_worse = match worst {
                    Some((least, _)) => !probe.is_freer(&curve, least - WORTH * step)?,
                    None => true,
                };
                if is_worse {
                    worst = Some((probe.free_clearance(&curve)?, piece));
                }
            }
            let Some((least, piece)) = worst else { return Ok(()) };
            if !least.is_finite() || !move_off(way, piece, (step, least + WORTH * step), probe)? {
                break;
            }
        }
        step /= 2.0;
    }
    Ok(())
}

/// Moves a point of this piece, or both of a leg, so that all beside them keep more than `least`;
/// whether there is such a move.
fn move_off(
    way: &mut Way,
    piece: WayPiece,
    (step, least): (f64, f64),
    probe: &Probe<'_>,
) -> Result<bool, Spent> {
    let count = way.backs.len();
    let (first, last) = match piece {
        WayPiece::Leg(leg) => (leg, leg + 1),
        WayPiece::Turn(knot) => (knot.saturating_sub(1), knot + 1),
    };
    for knot in first.max(1)..=last.min(count.saturating_sub(1)) {
        for end in knot..=(knot + 1).min(count - 1) {
            for direction in directions(way, knot) {
                probe.budget.step(STEPS_PER_MOVE)?;
                let before = [way.knots[knot], way.knots[end]];
                let sweeps = way.sweeps.clone();
                for moved in knot..=end {
                    way.knots[moved] += direction * step;
                }
                if keeps_more((way, knot, end), least, probe)? {
                    return Ok(true);
                }
                (way.knots[knot], way.knots[end]) = (before[0], before[1]);
                way.sweeps = sweeps;
            }
        }
    }
    Ok(false)
}

/// Whether all legs and turns beside some points keep more than this; their turns are found anew.
fn keeps_more(
    (way, first, last): (&mut Way, usize, usize),
    least: f64,
    probe: &Probe<'_>,
) -> Result<bool, Spent> {
    for leg in first - 1..=last {
        if !is_freer(way, WayPiece::Leg(leg), least, probe)? {
            return Ok(false);
        }
    }
    for knot in first - 1..=last + 1 {
        way.turn_again(knot, probe);
        if !is_freer(way, WayPiece::Turn(knot), least, probe)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Whether a piece has more free clearance than this, metres.
fn is_freer(way: &Way, piece: WayPiece, least: f64, probe: &Probe<'_>) -> Result<bool, Spent> {
    curve_of(way, piece, probe).map_or(Ok(true), |curve| probe.is_freer(&curve, least))
}

/// `None` where it does not turn.
fn curve_of(way: &Way, piece: WayPiece, probe: &Probe<'_>) -> Option<Curve<2>> {
    match piece {
        WayPiece::Leg(leg) => {
            Some(probe.line(&way.knots[leg], &way.knots[leg + 1], way.backs[leg]))
        }
        WayPiece::Turn(knot) if way.sweeps[knot] == 0.0 => None,
        WayPiece::Turn(knot) => {
            let [from, _] = way.headings_at(knot, probe);
            Some(probe.turn_by(&way.knots[knot], from, way.sweeps[knot]))
        }
    }
}
