//! Polygons cut into boxes.

use super::SolidsError;
use crate::budget::{Budget, Cap, Held};
use crate::geometry::orientation::{Side, side_of_line};
use crate::geometry::polygon::edges;
use crate::geometry::{AxisBox, Vector};
use std::collections::BTreeMap;

/// An upright edge of the outline.
#[derive(Debug, Clone, Copy)]
struct Upright {
    x: f64,
    /// Ranks of its ends among the second coordinates of the outline.
    low: usize,
    high: usize,
    /// By how much the winding number grows from left to right.
    step: i32,
}

/// A range of second coordinates, up to the next range.
#[derive(Debug, Clone, Copy)]
struct Range {
    winding: i32,
    /// The first coordinate from which on it has this winding number.
    since: f64,
}

/// An edge, a height and an upright for each step of an edge, and ranges.
const BYTES_PER_STAIR: usize = 96;

/// Steps of the budget that sorting one stair of an edge takes.
const STEPS_PER_STAIR: u64 = 24;

/// Steps that changing one range takes.
const STEPS_PER_RANGE: u64 = 8;

/// Appends boxes whose union is the polygon with slanted edges replaced by steps outside it.
pub(super) fn cut(
    vertices: &[Vector<2>],
    tolerance: f64,
    boxes: &mut Vec<AxisBox<2>>,
    budget: &Budget<'_>,
) -> Result<(), SolidsError> {
    let steps: f64 = edges(vertices).map(|(a, b)| steps_of(&(b - a), tolerance)).sum();
    if steps.is_nan() {
        return Err(SolidsError::ToleranceNotPositive { tolerance, least: 0.0 });
    }
    // Saturates if there are more steps than can be counted.
    budget.check(Cap::Pieces, boxes.len().saturating_add((steps / 2.0) as usize))?;
    let _held = Held::new(budget, (steps as usize).saturating_mul(BYTES_PER_STAIR))?;
    budget.step((steps as u64).saturating_mul(STEPS_PER_STAIR))?;
    let outline = stairs(vertices, tolerance);

    let mut heights: Vec<f64> = outline.iter().map(|point| point[1]).collect();
    heights.sort_unstable_by(f64::total_cmp);
    heights.dedup();
    let rank = |height: f64| heights.partition_point(|other| *other < height);
    let mut uprights: Vec<Upright> = edges(&outline)
        .filter(|(a, b)| a[0] == b[0] && a[1] != b[1])
        .map(|(a, b)| {
            // The inside is on the left of an edge.
            let step = if b[1] < a[1] { 1 } else { -1 };
            let (low, high) = (rank(a[1].min(b[1])), rank(a[1].max(b[1])));
            Upright { x: a[0], low, high, step }
        })
        .collect();
    uprights.sort_unstable_by(|a, b| {
        a.x.total_cmp(&b.x)
            .then(a.low.cmp(&b.low))
            .then(a.high.cmp(&b.high))
            .then(a.step.cmp(&b.step))
    });

    let outside = Range { winding: 0, since: f64::NEG_INFINITY };
    let mut ranges = BTreeMap::from([(0, outside)]);
    let mut within = Vec::new();
    for upright in &uprights {
        for end in [upright.low, upright.high] {
            if let Some((_, range)) = ranges.range(..=end).next_back() {
                let range = *range;
                ranges.insert(end, range);
            }
        }
        within.clear();
        within.extend(ranges.range(upright.low..=upright.high).map(|(low, range)| (*low, *range)));
        budget.step(STEPS_PER_RANGE * within.len() as u64)?;
        budget.check(Cap::Pieces, boxes.len())?;
        for pair in within.windows(2) {
            let [(low, range), (high, _)] = *pair else { continue };
            if range.winding > 0 && range.since < upright.x {
                let min = Vector::<2>::new(range.since, heights[low]);
                let max = Vector::<2>::new(upright.x, heights[high]);
                boxes.extend(AxisBox::new(min, max));
            }
            let winding = range.winding + upright.step;
            ranges.insert(low, Range { winding, since: upright.x });
        }
        // Merge neighbours that are the same from here on.
        let mut before = ranges.range(..upright.low).next_back().map(|(_, range)| *range);
        for (low, _) in &within {
            let Some(range) = ranges.get(low).copied() else { continue };
            if before.is_some_and(|before| same(&before, &range)) {
                ranges.remove(low);
            } else {
                before = Some(range);
            }
        }
    }
    Ok(())
}

fn same(a: &Range, b: &Range) -> bool {
    a.winding == b.winding && (a.winding == 0 || a.since == b.since)
}

/// The number of steps that replace an edge; NaN if that takes a tolerance.
fn steps_of(along: &Vector<2>, tolerance: f64) -> f64 {
    let least = along[0].abs().min(along[1].abs());
    if least == 0.0 {
        1.0
    } else if tolerance > 0.0 {
        libm::ceil(least / tolerance).max(1.0) + 1.0
    } else {
        f64::NAN
    }
}

/// The outline, counter-clockwise, with axis-parallel edges only.
///
/// Its winding number is that of the polygon plus one for every triangle added outside an
/// edge, so it is positive exactly in their union, even where steps reach over other edges.
fn stairs(vertices: &[Vector<2>], tolerance: f64) -> Vec<Vector<2>> {
    let count = vertices.len();
    let less = |i: &usize, j: &usize| {
        let (a, b) = (vertices[*i], vertices[*j]);
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    };
    // At an extreme vertex the polygon turns in its own sense.
    let extreme = (0..count).min_by(less).unwrap_or(0);
    let (before, after) = ((extreme + count - 1) % count, (extreme + 1) % count);
    let turn = side_of_line(&vertices[before], &vertices[extreme], &vertices[after]);
    let mut outline = Vec::with_capacity(count);
    let forwards = turn == Side::Left;
    for index in 0..count {
        let (i, j) = if forwards {
            (index, (index + 1) % count)
        } else {
            (count - 1 - index, (2 * count - 2 - index) % count)
        };
        push_stairs(&vertices[i], &vertices[j], tolerance, &mut outline);
    }
    outline
}

/// Appends the points from `a` to before `b`, with the outside on the right.
fn push_stairs(a: &Vector<2>, b: &Vector<2>, tolerance: f64, outline: &mut Vec<Vector<2>>) {
    outline.push(*a);
    let along = b - a;
    if along[0] == 0.0 || along[1] == 0.0 {
        return;
    }
    let count = steps_of(&along, tolerance) - 1.0;
    // Points between are moved outwards by more than rounding could move them inwards.
    let outwards = -along[0].signum();
    let rounding = 4.0 * f64::EPSILON * (a[1].abs() + b[1].abs());
    let mut from = *a;
    for step in 1..=count as usize {
        let to = if step as f64 == count {
            *b
        } else {
            let x = a[0] + along[0] * (step as f64 / count);
            let on_edge = a[1] + along[1] * ((x - a[0]) / along[0]);
            Vector::<2>::new(x, on_edge + outwards * rounding)
        };
        let forwards = |part: f64| part * along[0].signum() > 0.0;
        if !(forwards(to[0] - from[0]) && (forwards(b[0] - to[0]) || to == *b)) {
            continue;
        }
        let corner = Vector::<2>::new(to[0], from[1]);
        let to_the_right = side_of_line(&from, &to, &corner) == Side::Right;
        outline.push(if to_the_right { corner } else { Vector::<2>::new(from[0], to[1]) });
        if to != *b {
            outline.push(to);
        }
        from = to;
    }
}
