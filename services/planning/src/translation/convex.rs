//! Convex polygons: a polygon cut into them, and their Minkowski sums.

use std::collections::BTreeMap;

use crate::budget::{Budget, Spent};
use crate::geometry::Vector;
use crate::geometry::distance::cross;
use crate::geometry::orientation::{Side, side_of_line};

/// Vertices looked at in one step.
const VERTICES_PER_STEP: u64 = 4;

/// Cuts a simple polygon, in either sense, into convex pieces, counter-clockwise.
///
/// Ears are clipped, with exact predicates, and then the triangles merged as long as they stay
/// convex (Hertel and Mehlhorn, 1983): at most four times as many pieces as needed.
pub(super) fn pieces(
    outline: &[Vector<2>],
    budget: &Budget<'_>,
) -> Result<Vec<Vec<Vector<2>>>, Spent> {
    let count = outline.len();
    let area: f64 =
        (1..count.saturating_sub(1)).map(|at| turn_size(outline, [0, at, at + 1])).sum();
    let ring: Vec<usize> =
        if area < 0.0 { (0..count).rev().collect() } else { (0..count).collect() };
    let triangles = clip_ears(outline, ring, budget)?;
    let pieces = merge(outline, triangles, budget)?;
    Ok(pieces
        .into_iter()
        .map(|piece| piece.into_iter().map(|vertex| outline[vertex]).collect())
        .collect())
}

/// Twice the signed area of a triangle of vertices.
fn turn_size(outline: &[Vector<2>], [a, b, c]: [usize; 3]) -> f64 {
    cross(&(outline[b] - outline[a]), &(outline[c] - outline[a]))
}

fn turn(outline: &[Vector<2>], [a, b, c]: [usize; 3]) -> Side {
    side_of_line(&outline[a], &outline[b], &outline[c])
}

/// Triangulates the polygon, whose vertices `ring` has counter-clockwise. A vertex on a straight
/// line is no vertex.
fn clip_ears(
    outline: &[Vector<2>],
    mut ring: Vec<usize>,
    budget: &Budget<'_>,
) -> Result<Vec<Vec<usize>>, Spent> {
    let mut triangles = Vec::new();
    let around = |ring: &[usize], at: usize| {
        let count = ring.len();
        [ring[(at + count - 1) % count], ring[at], ring[(at + 1) % count]]
    };
    let (mut at, mut failed) = (0, 0);
    while ring.len() > 2 {
        at %= ring.len();
        let corner = around(&ring, at);
        let side = turn(outline, corner);
        let is_ear = match side {
            Side::Left => {
                budget.step(1 + ring.len() as u64 / VERTICES_PER_STEP)?;
                let [a, b, c] = corner;
                !ring.iter().any(|other| {
                    !corner.contains(other)
                        && [[a, b], [b, c], [c, a]]
                            .iter()
                            .all(|[from, to]| turn(outline, [*from, *to, *other]) != Side::Right)
                })
            }
            // Nothing to cut off.
            Side::On => true,
            Side::Right => false,
        };
        // A simple polygon has an ear; the end is for the sake of certainty.
        if is_ear || failed > ring.len() {
            if side == Side::Left {
                triangles.push(corner.to_vec());
            }
            ring.remove(at);
            failed = 0;
            // Not a fan, but every other vertex.
            at += usize::from(side == Side::Left);
        } else {
            at += 1;
            failed += 1;
        }
    }
    Ok(triangles)
}

/// Joins pieces along their common edges as long as they stay convex.
fn merge(
    outline: &[Vector<2>],
    mut pieces: Vec<Vec<usize>>,
    budget: &Budget<'_>,
) -> Result<Vec<Vec<usize>>, Spent> {
    let mut of_edge = BTreeMap::new();
    let edges = |piece: &[usize]| {
        let next = piece.iter().cycle().skip(1);
        piece.iter().copied().zip(next.copied()).collect::<Vec<_>>()
    };
    for (index, piece) in pieces.iter().enumerate() {
        of_edge.extend(edges(piece).into_iter().map(|edge| (edge, index)));
    }
    let diagonals: Vec<_> = of_edge.keys().copied().filter(|(a, b)| a < b).collect();
    // What each piece has become a part of.
    let mut whole: Vec<usize> = (0..pieces.len()).collect();
    for (a, b) in diagonals {
        let (Some(&one), Some(&other)) = (of_edge.get(&(a, b)), of_edge.get(&(b, a))) else {
            continue;
        };
        let (one, other) = (find(&mut whole, one), find(&mut whole, other));
        if one == other {
            continue;
        }
        budget.step(1 + (pieces[one].len() + pieces[other].len()) as u64 / VERTICES_PER_STEP)?;
        // One from b round to a, then the other from after a to before b.
        let rotated = |piece: &[usize], first: usize| {
            let at = piece.iter().position(|vertex| *vertex == first).unwrap_or(0);
            piece[at..].iter().chain(&piece[..at]).copied().collect::<Vec<_>>()
        };
        let mut joined = rotated(&pieces[one], b);
        let rest = rotated(&pieces[other], a);
        joined.extend(&rest[1..rest.len() - 1]);
        let count = joined.len();
        let is_convex = [a, b].iter().all(|vertex| {
            let at = joined.iter().position(|other| other == vertex).unwrap_or(0);
            let corner = [joined[(at + count - 1) % count], *vertex, joined[(at + 1) % count]];
            turn(outline, corner) != Side::Right
        });
        if is_convex {
            whole[other] = one;
            pieces[one] = joined;
            pieces[other].clear();
        }
    }
    pieces.retain(|piece| !piece.is_empty());
    Ok(pieces)
}

/// The piece that another has become a part of; the way to it is halved.
fn find(whole: &mut [usize], piece: usize) -> usize {
    let mut at = piece;
    while whole[at] != at {
        whole[at] = whole[whole[at]];
        at = whole[at];
    }
    at
}

/// Refills `sum` with the Minkowski sum of two convex polygons, counter-clockwise; either may be a
/// segment, given by its two ends.
pub(super) fn sum(one: &[Vector<2>], other: &[Vector<2>], sum: &mut Vec<Vector<2>>) {
    sum.clear();
    let (m, n) = (one.len(), other.len());
    let (first, second) = (lowest(one), lowest(other));
    let (mut i, mut j) = (0, 0);
    while i < m || j < n {
        let (a, next_a) = (one[(first + i) % m], one[(first + i + 1) % m]);
        let (b, next_b) = (other[(second + j) % n], other[(second + j + 1) % n]);
        sum.push(a + b);
        let turn = match (i < m, j < n) {
            (true, false) => 1.0,
            (false, true) => -1.0,
            _ => angle_order(&(next_a - a), &(next_b - b)),
        };
        i += usize::from(turn >= 0.0);
        j += usize::from(turn <= 0.0);
    }
}

/// The lowest vertex of a polygon, the first of those along the first axis.
pub(super) fn lowest(polygon: &[Vector<2>]) -> usize {
    let order = |a: &usize, b: &usize| {
        let (a, b) = (&polygon[*a], &polygon[*b]);
        a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0]))
    };
    (0..polygon.len()).min_by(order).unwrap_or(0)
}

/// Positive where the edge `a` comes before `b` counter-clockwise from the direction +x, 0 where
/// they are parallel.
pub(super) fn angle_order(a: &Vector<2>, b: &Vector<2>) -> f64 {
    match (leads_down(a), leads_down(b)) {
        (false, true) => 1.0,
        (true, false) => -1.0,
        _ => cross(a, b),
    }
}

/// Whether an edge is in the second half turn from the direction +x.
pub(super) fn leads_down(edge: &Vector<2>) -> bool {
    edge[1] < 0.0 || (edge[1] == 0.0 && edge[0] < 0.0)
}

/// The least and the greatest coordinates of points.
pub(super) fn bounds<'a>(points: impl IntoIterator<Item = &'a Vector<2>>) -> [Vector<2>; 2] {
    points.into_iter().fold(
        [Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY)],
        |[min, max], point| [min.inf(point), max.sup(point)],
    )
}

/// The centre and the radius of a circle around points, about the middle of their bounds, metres.
pub(super) fn circle<'a>(points: impl Iterator<Item = &'a Vector<2>> + Clone) -> (Vector<2>, f64) {
    let [min, max] = bounds(points.clone());
    let center = (min + max) / 2.0;
    let square = points.map(|at| (at - center).norm_squared()).fold(0.0, f64::max);
    (center, square.sqrt())
}

/// The farthest that a polygon reaches along `direction`.
pub(super) fn support(polygon: &[Vector<2>], direction: &Vector<2>) -> f64 {
    polygon.iter().map(|vertex| vertex.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
}

/// The unit normals of a convex polygon's edges that point outwards, with how far it reaches along
/// each.
pub(super) fn normals(polygon: &[Vector<2>]) -> impl Iterator<Item = (Vector<2>, f64)> {
    crate::geometry::polygon::edges(polygon).filter_map(|(from, to)| {
        let along = to - from;
        let length = along.norm();
        (length > 0.0).then(|| {
            let normal = Vector::<2>::new(along.y, -along.x) / length;
            (normal, normal.dot(&from).max(normal.dot(&to)))
        })
    })
}

/// The convex polygon of all points that are deeper than `depth` inside another; it may be empty.
pub(super) fn inset(polygon: &[Vector<2>], depth: f64) -> Vec<Vector<2>> {
    let mut left = polygon.to_vec();
    for (normal, reach) in normals(polygon) {
        let beyond = |point: &Vector<2>| normal.dot(point) - (reach - depth);
        let mut kept = Vec::with_capacity(left.len() + 1);
        for (a, b) in crate::geometry::polygon::edges(&left) {
            let (before, after) = (beyond(&a), beyond(&b));
            if before <= 0.0 {
                kept.push(a);
            }
            if (before < 0.0 && after > 0.0) || (before > 0.0 && after < 0.0) {
                kept.push(a + (b - a) * (before / (before - after)));
            }
        }
        left = kept;
    }
    left
}
