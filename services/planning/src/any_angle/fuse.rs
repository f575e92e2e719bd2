//! One arc in place of many: what a person would draw about a wall of small steps.
//!
//! Where a floor plan is drawn in cells, a slanted wall is a staircase, and the taut path turns a
//! little about each of its steps. Such a run of turns is replaced by a single arc between the
//! lines before and after it, the largest that keeps the disc's distance, if the path gets longer
//! by no more than a small part.

use super::disc::{Disc, turned};
use super::taut::{TautPath, TautTurn};
use crate::budget::{Budget, Spent};
use crate::driving::tangent::{Circle, Tangent};
use crate::free_space::floor::NONE;
use crate::geometry::Vector;
use crate::geometry::distance::cross;

/// A path may get longer by this part of its length.
const MOST_LONGER: f64 = 5e-4;

/// A run has at least so many turns.
const FEWEST_TURNS: usize = 3;

/// Between the turns of a run the path goes straight for no more than this many radii.
const MOST_STRAIGHT: f64 = 2.0;

/// How often a radius is halved.
const HALVINGS: usize = 12;

/// Replaces runs of turns by single arcs. The path stays as clear as it is.
pub(super) fn fused(
    path: &TautPath,
    disc: &Disc<'_>,
    budget: &Budget<'_>,
) -> Result<Option<TautPath>, Spent> {
    if path.turns.len() < FEWEST_TURNS {
        return Ok(None);
    }
    let mut spare = MOST_LONGER * path.length;
    let mut turns: Vec<TautTurn> = Vec::with_capacity(path.turns.len());
    let mut last = path.last;
    let mut changed = false;
    let mut first = 0;
    while first < path.turns.len() {
        let mut end = first + 1;
        while end < path.turns.len() && belongs(path, end, disc.radius) {
            end += 1;
        }
        // All of the run, or as many of its turns as can be fused.
        let mut fused = None;
        while end - first >= FEWEST_TURNS {
            fused = fuse(path, first..end, (disc, spare), budget)?;
            if fused.is_some() {
                break;
            }
            end = first + (end - first) / 2;
        }
        match fused {
            Some(Fused { turn, departure, longer }) => {
                spare -= longer;
                changed = true;
                // The line before the run ends later or earlier, that after it begins so.
                turns.push(turn);
                first = end;
                match path.turns.get(end) {
                    Some(next) => {
                        let arrival = shortened(&next.arrival, departure);
                        turns.push(TautTurn { arrival, ..*next });
                        first += 1;
                    }
                    None => last = shortened(&path.last, departure),
                }
            }
            None => {
                turns.push(path.turns[first]);
                first += 1;
            }
        }
    }
    if !changed {
        return Ok(None);
    }
    let mut length = last.length;
    for turn in &turns {
        length += turn.arrival.length + turn.circle.signed_radius.abs() * turn.sweep;
    }
    Ok(Some(TautPath { turns, last, length }))
}

/// Whether a turn belongs to the run of the one before it.
fn belongs(path: &TautPath, index: usize, radius: f64) -> bool {
    let [one, other] = [&path.turns[index - 1], &path.turns[index]];
    one.circle.signed_radius * other.circle.signed_radius > 0.0
        && other.arrival.length <= MOST_STRAIGHT * radius
}

struct Fused {
    turn: TautTurn,
    /// Where the arc ends.
    departure: Vector<2>,
    /// By how much the path gets longer, metres.
    longer: f64,
}

enum Tried {
    Fits(Fused),
    /// A larger one is shorter.
    TooLong,
    /// A smaller one is farther from the walls.
    Blocked,
}

/// The largest arc in place of a run of turns.
fn fuse(
    path: &TautPath,
    run: std::ops::Range<usize>,
    (disc, spare): (&Disc<'_>, f64),
    budget: &Budget<'_>,
) -> Result<Option<Fused>, Spent> {
    budget.step(run.len() as u64)?;
    let turns = &path.turns[run.clone()];
    let (Some(first), Some(last)) = (turns.first(), turns.last()) else { return Ok(None) };
    let arrival = &first.arrival;
    let leaving = path.turns.get(run.end).map_or(&path.last, |next| &next.arrival);
    let sense = first.circle.signed_radius.signum();
    let sweep = turned(&arrival.direction, &leaving.direction, sense);
    // The lines before and after meet where the path would turn at a point.
    let determinant = cross(&arrival.direction, &leaving.direction);
    if sweep <= 1e-6 || sense * determinant <= 1e-9 {
        return Ok(None);
    }
    let apart = leaving.from - arrival.to;
    let ahead = cross(&apart, &leaving.direction) / determinant;
    let corner = arrival.to + arrival.direction * ahead;
    let behind = (leaving.from - corner).dot(&leaving.direction);
    if ahead <= 0.0 || behind <= 0.0 {
        return Ok(None);
    }
    // What the run measures, and what the two lines to the corner do.
    let mut length = last.circle.signed_radius.abs() * last.sweep;
    for (turn, next) in turns.iter().zip(&turns[1..]) {
        length += turn.circle.signed_radius.abs() * turn.sweep + next.arrival.length;
    }
    let tangent = libm::tan(sweep / 2.0);
    // As long as the lines allow.
    let most = (ahead + arrival.length).min(behind + leaving.length) / tangent;
    let least = disc.radius;
    let try_radius = |radius: f64| -> Result<Tried, Spent> {
        let reach = radius * tangent;
        let longer = ahead + behind - 2.0 * reach + radius * sweep - length;
        if longer > spare {
            return Ok(Tried::TooLong);
        }
        let from = corner - arrival.direction * reach;
        let to = corner + leaving.direction * reach;
        let left = |way: &Vector<2>| Vector::<2>::new(-way.y, way.x) * sense;
        let center = from + left(&arrival.direction) * radius;
        let normals = [-left(&arrival.direction), -left(&leaving.direction)];
        let around = if sense > 0.0 { normals } else { [normals[1], normals[0]] };
        let mut arcs = Vec::new();
        disc.free_arcs((&center, radius), &around, &mut arcs, budget)?;
        let is_free = matches!(&arcs[..], [arc]
            if (arc.ends[0] - around[0]).norm() < 1e-9 && (arc.ends[1] - around[1]).norm() < 1e-9);
        if !is_free
            || !disc.is_clear((&arrival.from, &from), budget)?
            || !disc.is_clear((&to, &leaving.to), budget)?
        {
            return Ok(Tried::Blocked);
        }
        let turn = TautTurn {
            vertex: NONE,
            circle: Circle { center, signed_radius: sense * radius },
            arrival: Tangent {
                from: arrival.from,
                to: from,
                direction: arrival.direction,
                length: (from - arrival.from).norm(),
            },
            sweep,
        };
        Ok(Tried::Fits(Fused { turn, departure: to, longer: longer.max(0.0) }))
    };
    if most <= least {
        return Ok(None);
    }
    // A larger arc is shorter, and nearer to the walls.
    let mut best = None;
    let (mut low, mut high) = (least, most);
    for step in 0..HALVINGS {
        let radius = if step == 0 { most * (1.0 - 1e-12) } else { (low + high) / 2.0 };
        match try_radius(radius)? {
            Tried::Fits(found) => {
                best = Some(found);
                low = radius;
                if step == 0 {
                    break;
                }
            }
            Tried::TooLong => low = radius,
            Tried::Blocked => high = radius,
        }
    }
    Ok(best)
}

/// A line that begins later, at a point on it.
fn shortened(line: &Tangent, from: Vector<2>) -> Tangent {
    Tangent { from, length: (line.to - from).norm(), ..*line }
}
