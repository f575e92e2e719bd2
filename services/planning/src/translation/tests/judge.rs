//! An obviously right way to find the shortest way out: all sums of convex pieces as convex hulls of
//! all differences of vertices, and Dijkstra's algorithm over all lines between all their vertices.

use super::scene::{Convex, Scene};
use crate::geometry::distance::cross;
use crate::geometry::{AxisBox, Vector};

/// A hull, counter-clockwise.
struct Hull(Vec<Vector<2>>);

/// What the judge takes as overlap.
#[derive(Clone, Copy)]
pub(super) struct Strictness {
    /// Sums are enlarged by a square of this half width, metres.
    pub(super) grown: f64,
    /// Overlaps of up to this depth are none, metres.
    pub(super) allowed: f64,
}

/// The length of the shortest way out; `None` where there is none.
pub(super) fn shortest(scene: &Scene, strictness: Strictness) -> Option<f64> {
    let Strictness { grown, allowed } = strictness;
    let mut solids = scene.solids.concat();
    solids.extend(slabs(&scene.bounds));
    let hulls = sums(&solids, &scene.body, grown);
    // Up to where the least coordinate of the body is at the end of the bounds.
    let lowest = scene.body.concat().iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let out = scene.bounds.max().y - lowest;
    let is_free = |from: &Vector<2>, to: &Vector<2>| {
        hulls.iter().all(|hull| !hull.is_crossed(from, to, allowed))
    };
    let mut nodes = vec![Vector::zeros()];
    nodes.extend(hulls.iter().flat_map(|hull| hull.0.iter().copied()));
    let crossings = hulls.iter().flat_map(|hull| {
        hull.edges().filter(|(a, b)| (a.y < out) != (b.y < out)).map(|(a, b)| {
            let part = (out - a.y) / (b.y - a.y);
            Vector::<2>::new(a.x + (b.x - a.x) * part, out)
        })
    });
    let ends: Vec<Vector<2>> = crossings.collect();
    nodes.retain(|node| is_free(node, node));
    if nodes.first() != Some(&Vector::zeros()) {
        return None;
    }
    let mut lengths = vec![f64::INFINITY; nodes.len()];
    let mut done = vec![false; nodes.len()];
    lengths[0] = 0.0;
    let mut best = f64::INFINITY;
    loop {
        let open = (0..nodes.len()).filter(|node| !done[*node] && lengths[*node] < best);
        let Some(at) = open.min_by(|a, b| lengths[*a].total_cmp(&lengths[*b])) else { break };
        done[at] = true;
        let from = nodes[at];
        let above = Vector::<2>::new(from.x, from.y.max(out));
        for end in ends.iter().chain([&above]) {
            let length = lengths[at] + (end - from).norm();
            if length < best && is_free(&from, end) {
                best = length;
            }
        }
        for next in 0..nodes.len() {
            let length = lengths[at] + (nodes[next] - from).norm();
            if !done[next] && length < lengths[next] && is_free(&from, &nodes[next]) {
                lengths[next] = length;
            }
        }
    }
    best.is_finite().then_some(best)
}

/// The least distance from the solids on a way among them, metres.
pub(super) fn clearance(scene: &Scene, way: &[Vector<2>]) -> f64 {
    let hulls = sums(&scene.solids.concat(), &scene.body, 0.0);
    let apart =
        way.windows(2).flat_map(|ends| hulls.iter().map(|hull| hull.distance(&ends[0], &ends[1])));
    apart.fold(f64::INFINITY, f64::min)
}

/// The sums of solids and the reflected pieces of a body, enlarged by a square of this half width,
/// metres.
fn sums(solids: &[Convex], body: &[Convex], grown: f64) -> Vec<Hull> {
    let square = [[-grown, -grown], [grown, -grown], [grown, grown], [-grown, grown]];
    let square = square.map(Vector::from);
    let of_pair = |solid: &Convex, piece: &Convex| {
        let mut differences = Vec::new();
        for a in solid {
            for b in piece {
                differences.extend(square.iter().map(|corner| a - b + corner));
            }
        }
        hull(differences)
    };
    solids.iter().flat_map(|solid| body.iter().map(|piece| of_pair(solid, piece))).collect()
}

/// Boxes beside and below the bounds, up to the mouth above.
fn slabs(bounds: &AxisBox<2>) -> [Convex; 3] {
    let (min, max) = (bounds.min(), bounds.max());
    let far = 10.0 * (max - min).amax();
    let space = |a: [f64; 2], b: [f64; 2]| -> Convex {
        [[a[0], a[1]], [b[0], a[1]], [b[0], b[1]], [a[0], b[1]]].map(Vector::from).to_vec()
    };
    [
        space([min.x - far, min.y - far], [min.x, max.y]),
        space([max.x, min.y - far], [max.x + far, max.y]),
        space([min.x - far, min.y - far], [max.x + far, min.y]),
    ]
}

impl Hull {
    fn edges(&self) -> impl Iterator<Item = (Vector<2>, Vector<2>)> {
        (0..self.0.len()).map(|at| (self.0[at], self.0[(at + 1) % self.0.len()]))
    }

    /// Whether some point of a segment is deeper inside than `allowed`.
    fn is_crossed(&self, from: &Vector<2>, to: &Vector<2>, allowed: f64) -> bool {
        let (mut enter, mut exit) = (0.0_f64, 1.0_f64);
        for (a, b) in self.edges() {
            let along = (b - a).normalize();
            // How deep inside this side the ends are.
            let before = cross(&along, &(from - a)) - allowed;
            let after = cross(&along, &(to - a)) - allowed;
            if before <= 0.0 && after <= 0.0 {
                return false;
            }
            if before < 0.0 {
                enter = enter.max(before / (before - after));
            } else if after < 0.0 {
                exit = exit.min(before / (before - after));
            }
        }
        enter < exit
    }

    /// The distance of a segment, metres; 0 if it comes inside.
    fn distance(&self, from: &Vector<2>, to: &Vector<2>) -> f64 {
        if self.is_crossed(from, to, 0.0) {
            return 0.0;
        }
        let apart = |point: &Vector<2>, a: &Vector<2>, b: &Vector<2>| {
            let along = b - a;
            let part = (point - a).dot(&along) / along.norm_squared();
            let part = if part > 0.0 { part.min(1.0) } else { 0.0 };
            (point - a - along * part).norm()
        };
        let each = self
            .edges()
            .flat_map(|(a, b)| [apart(&a, from, to), apart(from, &a, &b), apart(to, &a, &b)]);
        each.fold(f64::INFINITY, f64::min)
    }
}

/// Andrew's monotone chain.
fn hull(mut points: Vec<Vector<2>>) -> Hull {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let mut hull: Vec<Vector<2>> = Vec::new();
    for pass in 0..2 {
        let first = hull.len();
        for point in &points {
            while hull.len() >= first + 2 {
                let (a, b) = (hull[hull.len() - 2], hull[hull.len() - 1]);
                if cross(&(b - a), &(point - b)) > 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(*point);
        }
        hull.pop();
        if pass == 0 {
            points.reverse();
        }
    }
    Hull(hull)
}
