//! Shortens straight legs and turns in place.

use super::probe::Probe;
use super::way::{NO_TURN, Way};
use crate::budget::Spent;
use crate::driving::shortest_turn;
use crate::geometry::Vector;

/// Points between which straight legs are tried.
const MOST_POINTS: usize = 120;

/// Legs are tried from each point to as many that follow, and then to every so many.
const NEXT: usize = 16;
const STRIDE: usize = 6;

/// How often shortcuts and moves of points follow each other.
const ROUNDS: usize = 4;

/// Points are moved by steps from the first to the last part of the turning circle's radius.
const FIRST_STEP: f64 = 0.5;
const LAST_STEP: f64 = 1e-4;

/// Moves of all points by steps of one size.
const MOST_SWEEPS: usize = 8;

/// A change must lower the cost by this part of a step.
const WORTH: f64 = 1e-3;

/// Another round is worth it for this part of the cost.
const WORTH_ROUND: f64 = 1e-4;

/// Steps of the budget that a pair of legs, and a move, takes.
const STEPS_PER_PAIR: u64 = 1;
const STEPS_PER_MOVE: u64 = 10;

/// Lowers the cost of a way that is free.
pub(super) fn shorten(way: &mut Way, probe: &Probe<'_>) -> Result<(), Spent> {
    if way.sweeps.is_empty() && !way.check(probe)? {
        return Ok(());
    }
    let mut cost = way.cost(probe);
    for _ in 0..ROUNDS {
        let points = points_on(way);
        if let Some(other) = shortcut(&points, probe)?
            && other.cost(probe) < cost
        {
            *way = other;
        }
        descend(way, probe)?;
        let before = std::mem::replace(&mut cost, way.cost(probe));
        if before - cost <= WORTH_ROUND * before {
            break;
        }
    }
    Ok(())
}

/// Points along a way: all where it turns, and others between them.
fn points_on(way: &Way) -> Vec<Vector<2>> {
    let is_kept = |knot: usize| {
        knot == 0 || knot == way.backs.len() || {
            way.backs[knot - 1] != way.backs[knot]
                || shortest_turn(way.heading(knot - 1), way.heading(knot)).abs() > NO_TURN
        }
    };
    let kept: Vec<_> = (0..way.knots.len()).filter(|knot| is_kept(*knot)).collect();
    let kept: Vec<_> = kept.iter().map(|knot| way.knots[*knot]).collect();
    let total: f64 = kept.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
    let more = MOST_POINTS.saturating_sub(kept.len()).max(MOST_POINTS / 2);
    let apart = total / more as f64;
    let mut points = vec![kept[0]];
    for ends in kept.windows(2) {
        let line = ends[1] - ends[0];
        let pieces = (line.norm() / apart + 1e-6).floor().max(1.0);
        let mut piece = 1.0;
        while piece < pieces {
            points.push(ends[0] + line * (piece / pieces));
            piece += 1.0;
        }
        points.push(ends[1]);
    }
    points
}

/// A straight leg between two points.
struct Edge {
    from: usize,
    back: bool,
    heading: f64,
    /// The least cost up to its end; infinite if it can't be driven.
    cost: f64,
    /// The edge before it, and the turn between.
    before: Option<usize>,
    sweep: f64,
}

/// The least costly way along some of the points, in order.
fn shortcut(points: &[Vector<2>], probe: &Probe<'_>) -> Result<Option<Way>, Spent> {
    let last = points.len() - 1;
    let senses: &[bool] = if probe.errand.abilities.reverse { &[false, true] } else { &[false] };
    let mut edges: Vec<Edge> = Vec::new();
    let mut arriving: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
    let mut best: Option<(f64, usize, f64)> = None;
    for from in 0..last {
        if from > 0 && arriving[from].is_empty() {
            continue;
        }
        let can_turn = probe.can_turn(&points[from])?;
        for to in from + 1..=last {
            let is_tried = to - from <= NEXT || (to - from) % STRIDE == 0 || to == last;
            let way = points[to] - points[from];
            let length = way.norm();
            if !is_tried || length == 0.0 {
                continue;
            }
            for back in senses {
                let ahead = if *back { -way } else { way };
                let heading = libm::atan2(ahead.y, ahead.x);
                let mut edge = Edge {
                    from,
                    back: *back,
                    heading,
                    cost: f64::INFINITY,
                    before: None,
                    sweep: 0.0,
                };
                if !probe.is_line_free(&points[from], &points[to], *back)? {
                    continue;
                }
                arrive(&mut edge, (&edges, &arriving[from]), (&points[from], can_turn), probe)?;
                if edge.cost.is_infinite() {
                    continue;
                }
                edge.cost += length;
                let index = edges.len();
                if to < last {
                    arriving[to].push(index);
                } else {
                    let sweep = match probe.goal_heading {
                        Some(goal) => probe.turn(&points[last], heading, goal)?,
                        None => Some(0.0),
                    };
                    if let Some(sweep) = sweep {
                        let cost = edge.cost + probe.errand.costs.turn * sweep.abs();
                        if best.is_none_or(|(least, ..)| cost < least - NO_TURN) {
                            best = Some((cost, index, sweep));
                        }
                    }
                }
                edges.push(edge);
            }
        }
    }
    let Some((_, end, sweep)) = best else { return Ok(None) };
    let mut way = Way::default();
    way.knots.push(points[last]);
    way.sweeps.push(sweep);
    let mut at = Some(end);
    while let Some(index) = at {
        let edge = &edges[index];
        way.knots.push(points[edge.from]);
        way.backs.push(edge.back);
        way.sweeps.push(edge.sweep);
        at = edge.before;
    }
    way.knots.reverse();
    way.backs.reverse();
    way.sweeps.reverse();
    Ok(Some(way))
}

/// The least cost up to the beginning of an edge, turn and stop included.
fn arrive(
    edge: &mut Edge,
    (edges, arriving): (&[Edge], &[usize]),
    (at, can_turn): (&Vector<2>, bool),
    probe: &Probe<'_>,
) -> Result<(), Spent> {
    let costs = &probe.errand.costs;
    if edge.from == 0 {
        if let Some(sweep) = probe.turn(at, 0.0, edge.heading)? {
            (edge.cost, edge.sweep) = (costs.turn * sweep.abs(), sweep);
        }
        return Ok(());
    }
    probe.budget.step(STEPS_PER_PAIR * arriving.len() as u64)?;
    for index in arriving {
        let before = &edges[*index];
        let price = |sweep: f64| {
            let stops = sweep.abs() > NO_TURN || before.back != edge.back;
            before.cost + costs.turn * sweep.abs() + if stops { costs.stop } else { 0.0 }
        };
        let mut sweep = shortest_turn(before.heading, edge.heading);
        if price(sweep) >= edge.cost - NO_TURN {
            continue;
        }
        if !can_turn {
            let Some(free) = probe.turn(at, before.heading, edge.heading)? else { continue };
            sweep = free;
        }
        if price(sweep) < edge.cost - NO_TURN {
            (edge.cost, edge.sweep, edge.before) = (price(sweep), sweep, Some(*index));
        }
    }
    Ok(())
}

/// Moves the points, one by one or the two of a leg, as long as that lowers the cost.
fn descend(way: &mut Way, probe: &Probe<'_>) -> Result<(), Spent> {
    let mut step = FIRST_STEP * probe.swing;
    while step > LAST_STEP * probe.swing {
        for _ in 0..MOST_SWEEPS {
            let mut changed = false;
            for knot in 1..way.knots.len().saturating_sub(1) {
                for direction in directions(way, knot) {
                    changed |= shift(way, (knot, knot), direction * step, probe)?;
                }
                if knot + 2 < way.knots.len() {
                    for direction in directions(way, knot) {
                        changed |= shift(way, (knot, knot + 1), direction * step, probe)?;
                    }
                }
            }
            if !changed {
                break;
            }
        }
        step /= 2.0;
    }
    Ok(())
}

/// Along the legs at a point, midway between them, and at right angles to each of these.
pub(super) fn directions(way: &Way, knot: usize) -> [Vector<2>; 12] {
    let along = |leg: usize| {
        let line = way.knots[leg + 1] - way.knots[leg];
        let length = line.norm();
        if length > 0.0 { line / length } else { Vector::<2>::new(1.0, 0.0) }
    };
    let (before, after) = (along(knot - 1), along(knot));
    let middle = before + after;
    let length = middle.norm();
    let middle = if length > 1e-6 { middle / length } else { before };
    let across = |along: Vector<2>| Vector::<2>::new(-along.y, along.x);
    let half = [before, after, middle, across(before), across(after), across(middle)];
    let [a, b, c, d, e, f] = half;
    [a, -a, b, -b, c, -c, d, -d, e, -e, f, -f]
}

/// Moves some points if that lowers the cost; whether it does.
fn shift(
    way: &mut Way,
    (first, last): (usize, usize),
    by: Vector<2>,
    probe: &Probe<'_>,
) -> Result<bool, Spent> {
    probe.budget.step(STEPS_PER_MOVE)?;
    let legs = first - 1..=last;
    let turns = first - 1..=(last + 1).min(way.knots.len() - 1);
    let lengths = |way: &Way| legs.clone().map(|leg| way.length_of(leg)).sum::<f64>();
    let price = |way: &Way, sweeps: &dyn Fn(usize) -> f64| {
        let turns = turns.clone().map(|knot| way.cost_of_turn(knot, sweeps(knot), probe));
        turns.sum::<f64>() + lengths(way)
    };
    let most = price(way, &|knot| way.sweeps[knot]) - WORTH * by.norm();
    let move_by = |way: &mut Way, by: &Vector<2>| {
        for knot in first..=last {
            way.knots[knot] += by;
        }
    };
    let before = [way.knots[first], way.knots[last]];
    let restore = |way: &mut Way| (way.knots[first], way.knots[last]) = (before[0], before[1]);
    move_by(way, &by);
    let shortest = |knot: usize| {
        let [from, to] = way.headings_at(knot, probe);
        shortest_turn(from, to)
    };
    if price(way, &shortest) >= most {
        restore(way);
        return Ok(false);
    }
    let mut sweeps = [0.0; 4];
    for (sweep, knot) in sweeps.iter_mut().zip(turns.clone()) {
        let [from, to] = way.headings_at(knot, probe);
        let Some(free) = probe.turn(&way.knots[knot], from, to)? else {
            restore(way);
            return Ok(false);
        };
        *sweep = free;
    }
    let mut is_better = price(way, &|knot| sweeps[knot + 1 - first]) < most;
    for leg in legs.clone() {
        let (from, to) = (&way.knots[leg], &way.knots[leg + 1]);
        is_better = is_better && probe.is_line_free(from, to, way.backs[leg])?;
    }
    if !is_better {
        restore(way);
        return Ok(false);
    }
    for (sweep, knot) in sweeps.into_iter().zip(turns) {
        way.sweeps[knot] = sweep;
    }
    Ok(true)
}
