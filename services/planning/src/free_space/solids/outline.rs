//! Rectilinear polygons cut into boxes.

use super::SolidsError;
use crate::budget::{Budget, Cap, Held};
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
}

/// The first coordinate from which on a range of second coordinates is inside; `None` where it is outside.
/// A range ends where the next one begins.
type Inside = Option<f64>;

/// A height and an upright for each edge, and ranges.
const BYTES_PER_EDGE: usize = 96;

/// Steps of the budget that sorting one edge takes.
const STEPS_PER_EDGE: u64 = 24;

/// Steps that changing one range takes.
const STEPS_PER_RANGE: u64 = 8;

/// Appends boxes whose union is the polygon, which must be simple.
pub(super) fn cut(
    vertices: &[Vector<2>],
    boxes: &mut Vec<AxisBox<2>>,
    budget: &Budget<'_>,
) -> Result<(), SolidsError> {
    let is_slanted = |(a, b): &(Vector<2>, Vector<2>)| a[0] != b[0] && a[1] != b[1];
    if let Some((edge, (from, to))) = edges(vertices).enumerate().find(|(_, ends)| is_slanted(ends))
    {
        return Err(SolidsError::Slanted { edge, from, to });
    }
    let count = vertices.len();
    budget.check(Cap::Pieces, boxes.len() + count / 2)?;
    let _held = Held::new(budget, count * BYTES_PER_EDGE)?;
    budget.step(count as u64 * STEPS_PER_EDGE)?;

    let mut heights: Vec<f64> = vertices.iter().map(|point| point[1]).collect();
    heights.sort_unstable_by(f64::total_cmp);
    heights.dedup();
    let rank = |height: f64| heights.partition_point(|other| *other < height);
    let mut uprights: Vec<Upright> = edges(vertices)
        .filter(|(a, b)| a[0] == b[0])
        .map(|(a, b)| {
            let (low, high) = (rank(a[1].min(b[1])), rank(a[1].max(b[1])));
            Upright { x: a[0], low, high }
        })
        .collect();
    uprights.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.low.cmp(&b.low)));

    // Every upright is crossed into the polygon or out of it.
    let mut ranges: BTreeMap<usize, Inside> = BTreeMap::from([(0, None)]);
    let mut within = Vec::new();
    for upright in &uprights {
        for end in [upright.low, upright.high] {
            if let Some((_, inside)) = ranges.range(..=end).next_back() {
                let inside = *inside;
                ranges.insert(end, inside);
            }
        }
        within.clear();
        within
            .extend(ranges.range(upright.low..=upright.high).map(|(low, inside)| (*low, *inside)));
        budget.step(STEPS_PER_RANGE * within.len() as u64)?;
        budget.check(Cap::Pieces, boxes.len())?;
        for pair in within.windows(2) {
            let [(low, inside), (high, _)] = *pair else { continue };
            let Some(since) = inside else {
                ranges.insert(low, Some(upright.x));
                continue;
            };
            let min = Vector::<2>::new(since, heights[low]);
            let max = Vector::<2>::new(upright.x, heights[high]);
            // There is none of no width.
            boxes.extend(AxisBox::new(min, max));
            ranges.insert(low, None);
        }
        // Merge neighbours that are the same from here on.
        let mut before = ranges.range(..upright.low).next_back().map(|(_, inside)| *inside);
        for (low, _) in &within {
            let Some(inside) = ranges.get(low).copied() else { continue };
            if before == Some(inside) {
                ranges.remove(low);
            } else {
                before = Some(inside);
            }
        }
    }
    Ok(())
}
