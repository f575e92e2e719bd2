//! Simple polygons.

use super::box_tree::BoxTree;
use super::number::{Number, Point};
use super::orientation::{Side, segments_meet, side_of_line};
use super::{AxisBox, Vector};
use crate::budget::{Budget, Held, Spent};
use thiserror::Error;

/// Up to this many edges all pairs are checked, without an index.
const FEW: usize = 64;

/// Steps that checking two edges takes whose bounding boxes meet.
const STEPS_PER_PAIR: u64 = 4;

/// A polygon whose boundary neither crosses nor touches itself, convex or not, with its
/// vertices in either sense of rotation. Metres.
///
/// ```
/// use planning::budget::Budget;
/// use planning::geometry::polygon::{Polygon, PolygonError};
///
/// let bow_tie = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]];
/// let error = Polygon::new(bow_tie.map(Into::into).to_vec(), &Budget::default()).unwrap_err();
/// assert!(matches!(error, PolygonError::Crossing { first: 0, second: 2, .. }));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    vertices: Vec<Vector<2>>,
    bounds: AxisBox<2>,
}

/// Why vertices are no [`Polygon`]. Edge `i` runs from vertex `i` to the next one, the
/// last edge back to vertex 0.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum PolygonError {
    /// Fewer than three vertices.
    #[error("the polygon has {has} vertices, at least {needs} are needed")]
    TooFewVertices {
        /// How many there are.
        has: usize,
        /// How many are needed.
        needs: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error(
        "vertex {vertex} of the polygon is not finite: ({}, {})",
        Number(*x), Number(*y)
    )]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// Its first coordinate.
        x: f64,
        /// Its second coordinate.
        y: f64,
    },
    /// All vertices share one coordinate.
    #[error(
        "the polygon has no area: all {vertices} vertices have coordinate {axis} = {}",
        Number(*value)
    )]
    Flat {
        /// How many vertices there are.
        vertices: usize,
        /// The coordinate.
        axis: usize,
        /// Its value, metres.
        value: f64,
    },
    /// Two vertices are the same point.
    #[error(
        "vertices {first} and {second} of the polygon are the same point ({}, {})",
        Number(*x), Number(*y)
    )]
    Repeated {
        /// Index of the earlier vertex.
        first: usize,
        /// Index of the later vertex.
        second: usize,
        /// First coordinate of both, metres.
        x: f64,
        /// Second coordinate of both, metres.
        y: f64,
    },
    /// Two edges cross, overlap, or touch other than at a common vertex.
    #[error(
        "edges {first} and {second} of the polygon cross: {} to {} and {} to {}",
        Point(&first_edge[0]), Point(&first_edge[1]), Point(&second_edge[0]), Point(&second_edge[1])
    )]
    Crossing {
        /// Index of the earlier edge.
        first: usize,
        /// Index of the later edge.
        second: usize,
        /// Ends of the earlier edge, metres.
        first_edge: [Vector<2>; 2],
        /// Ends of the later edge, metres.
        second_edge: [Vector<2>; 2],
    },
    /// The budget ended.
    #[error(transparent)]
    Spent(#[from] Spent),
}

impl Polygon {
    /// The polygon with these vertices in order, the last joined to the first.
    /// Allocates only for more than 64 vertices.
    pub fn new(vertices: Vec<Vector<2>>, budget: &Budget<'_>) -> Result<Self, PolygonError> {
        let bounds = check(&vertices, budget)?;
        Ok(Self { vertices, bounds })
    }

    /// The vertices, in order, metres.
    pub fn vertices(&self) -> &[Vector<2>] {
        &self.vertices
    }

    /// Returns the vertices for reuse of their memory.
    pub fn into_vertices(self) -> Vec<Vector<2>> {
        self.vertices
    }

    /// The smallest axis-parallel box around it.
    pub fn bounds(&self) -> &AxisBox<2> {
        &self.bounds
    }

    /// Whether `point` is inside. For a point on the boundary the answer may be either.
    pub fn contains(&self, point: &Vector<2>) -> bool {
        contains(edges(&self.vertices), point)
    }

    /// Whether it is an axis-parallel rectangle (and so the same as its bounds).
    pub fn is_axis_box(&self) -> bool {
        let (min, max) = (self.bounds.min(), self.bounds.max());
        let on_corner = |v: &Vector<2>| (0..2).all(|i| v[i] == min[i] || v[i] == max[i]);
        // Four distinct corners of a simple polygon.
        self.vertices.len() == 4 && self.vertices.iter().all(on_corner)
    }
}

/// The edges of a closed polygon, in order.
pub(crate) fn edges(vertices: &[Vector<2>]) -> impl Iterator<Item = (Vector<2>, Vector<2>)> {
    let next = vertices.iter().cycle().skip(1);
    vertices.iter().zip(next).map(|(a, b)| (*a, *b))
}

/// Whether `point` is inside the closed outline made of `edges`: whether a ray in the
/// direction of the first axis crosses it an odd number of times.
pub(crate) fn contains(
    edges: impl Iterator<Item = (Vector<2>, Vector<2>)>,
    point: &Vector<2>,
) -> bool {
    let mut inside = false;
    for (a, b) in edges {
        if (a[1] > point[1]) != (b[1] > point[1]) {
            let left = side_of_line(&a, &b, point) == Side::Left;
            inside ^= left == (b[1] > a[1]);
        }
    }
    inside
}

fn check(vertices: &[Vector<2>], budget: &Budget<'_>) -> Result<AxisBox<2>, PolygonError> {
    let count = vertices.len();
    if count < 3 {
        return Err(PolygonError::TooFewVertices { has: count, needs: 3 });
    }
    let (mut min, mut max) = (vertices[0], vertices[0]);
    for (index, vertex) in vertices.iter().enumerate() {
        let (x, y) = (vertex[0], vertex[1]);
        if !(x.is_finite() && y.is_finite()) {
            return Err(PolygonError::NotFinite { vertex: index, x, y });
        }
        (min, max) = (min.inf(vertex), max.sup(vertex));
    }
    for axis in 0..2 {
        if min[axis] == max[axis] {
            let value = min[axis];
            return Err(PolygonError::Flat { vertices: count, axis, value });
        }
    }
    budget.step(count as u64)?;
    if is_convex(vertices) {
        // No two edges meet but where they join.
    } else if count <= FEW {
        budget.step((count * count / 2) as u64)?;
        for first in 0..count {
            for second in first + 1..count {
                check_pair(vertices, first, second)?;
            }
        }
    } else {
        check_indexed(vertices, budget)?;
    }
    // Cannot fail: extents are positive.
    AxisBox::new(min, max).map_err(|_| PolygonError::Flat {
        vertices: count,
        axis: 0,
        value: min[0],
    })
}

/// Whether the outline turns to one side at each vertex, and once around in all: it is convex
/// then, and simple.
fn is_convex(vertices: &[Vector<2>]) -> bool {
    let [.., before, last] = vertices else { return false };
    // The half of all directions that the edge has: each that is not beyond half a turn.
    let is_up = |from: &Vector<2>, to: &Vector<2>| (to.y, to.x) > (from.y, from.x);
    let (mut a, mut b) = (before, last);
    let (mut sense, mut rises) = (None, 0);
    for c in vertices {
        let side = side_of_line(a, b, c);
        if side == Side::On || sense.is_some_and(|sense| sense != side) {
            return false;
        }
        sense = Some(side);
        rises += usize::from(!is_up(a, b) && is_up(b, c));
        (a, b) = (b, c);
    }
    rises == 1
}

/// Checks only pairs whose bounding boxes meet; reports the first wrong pair.
fn check_indexed(vertices: &[Vector<2>], budget: &Budget<'_>) -> Result<(), PolygonError> {
    let count = vertices.len();
    let bounds = |index: usize| {
        let (a, b) = edge(vertices, index);
        (a.inf(&b), a.sup(&b))
    };
    let mut tree = BoxTree::default();
    let _held = Held::new(budget, BoxTree::<2>::bytes_for(count))?;
    tree.build(count, bounds, budget)?;
    for first in 0..count {
        let (min, max) = bounds(first);
        let mut wrong: Option<usize> = None;
        let mut pairs = 0;
        tree.visit(&min, &max, 0.0, budget, |second| {
            pairs += 1;
            let earlier = wrong.is_none_or(|least| second < least);
            if second > first && earlier && check_pair(vertices, first, second).is_err() {
                wrong = Some(second);
            }
            0.0
        })?;
        budget.step(STEPS_PER_PAIR * pairs)?;
        if let Some(second) = wrong {
            check_pair(vertices, first, second)?;
        }
    }
    Ok(())
}

fn edge(vertices: &[Vector<2>], index: usize) -> (Vector<2>, Vector<2>) {
    let next = if index + 1 == vertices.len() { 0 } else { index + 1 };
    (vertices[index], vertices[next])
}

/// Checks two different edges, the earlier one first.
fn check_pair(vertices: &[Vector<2>], first: usize, second: usize) -> Result<(), PolygonError> {
    let ((a, b), (c, d)) = (edge(vertices, first), edge(vertices, second));
    let count = vertices.len();
    let after = |index: usize| if index + 1 == count { 0 } else { index + 1 };
    let (i, j, k, l) = (first, after(first), second, after(second));
    for (one, other) in [(i, k), (i, l), (j, k), (j, l)] {
        if one != other && vertices[one] == vertices[other] {
            let (first, second) = (one.min(other), one.max(other));
            let (x, y) = (vertices[one][0], vertices[one][1]);
            return Err(PolygonError::Repeated { first, second, x, y });
        }
    }
    // Neighbours share a vertex; beyond it they must not overlap.
    let crossing = if j == k || l == i {
        let (before, shared, after) = if j == k { (a, b, d) } else { (c, a, b) };
        side_of_line(&shared, &before, &after) == Side::On
            && (before - shared).dot(&(after - shared)) > 0.0
    } else {
        segments_meet((&a, &b), (&c, &d))
    };
    if crossing {
        let (first_edge, second_edge) = ([a, b], [c, d]);
        return Err(PolygonError::Crossing { first, second, first_edge, second_edge });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
