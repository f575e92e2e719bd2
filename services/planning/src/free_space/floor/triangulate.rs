//! The constrained Delaunay triangulation of walls.

use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::{Face, Floor, FloorError, NONE, Wall};
use crate::budget::{Budget, Held, Spent};
use crate::geometry::Vector;
use crate::geometry::box_tree::BoxTree;
use crate::geometry::distance::cross;

/// Steps of the budget that a vertex takes, for each doubling of their number.
const STEPS_PER_VERTEX: u64 = 8;

/// Steps that a wall takes which crosses others, for each vertex of the triangulation that it
/// adds.
const STEPS_PER_CROSSING: u64 = 400;

/// Bytes of working memory that a vertex takes: in the triangulation, and in the floor.
const BYTES_PER_VERTEX: usize = 600;

/// A vertex nearer to a wall than this part of the extent is on it.
const TOUCHING: f64 = 1e-13;

/// What spade takes for coordinates; others are scaled by a power of two, which is exact.
const GREATEST: f64 = 1e50;

/// A vertex of the triangulation.
#[derive(Debug, Clone, Copy)]
struct Vertex(Point2<f64>);

impl HasPosition for Vertex {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.0
    }
}

type Mesh = ConstrainedDelaunayTriangulation<Vertex>;

/// The triangles among walls; the corners are not found yet.
pub(super) fn triangulate(walls: &[Wall<2>], budget: &Budget<'_>) -> Result<Floor, FloorError> {
    let doublings = u64::from(walls.len().max(2).ilog2()) + 1;
    budget.step(walls.len() as u64 * STEPS_PER_VERTEX * doublings)?;
    let mut held = Held::new(budget, walls.len().saturating_mul(BYTES_PER_VERTEX))?;

    let mut points: Vec<Vector<2>> = Vec::with_capacity(2 * walls.len());
    for wall in walls {
        points.extend([wall.from, wall.to]);
    }
    let order = |a: &Vector<2>, b: &Vector<2>| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y));
    points.sort_unstable_by(order);
    points.dedup();
    let find = |point: &Vector<2>| points.binary_search_by(|other| order(other, point));
    let (low, high) = points
        .iter()
        .fold(None, |bounds: Option<(Vector<2>, Vector<2>)>, point| {
            Some(bounds.map_or((*point, *point), |(low, high)| (low.inf(point), high.sup(point))))
        })
        .ok_or(FloorError::Empty)?;
    let farthest = low.amax().max(high.amax());
    let extent = (high - low).amax();
    let tolerance = 8.0 * f64::EPSILON * farthest + TOUCHING * extent;
    let mut tree = BoxTree::default();
    tree.build(points.len(), |index| (points[index], points[index]), budget)?;
    let mut edges: Vec<[usize; 2]> = Vec::with_capacity(walls.len());
    let mut touched = Vec::new();
    for wall in walls {
        let (Ok(from), Ok(to)) = (find(&wall.from), find(&wall.to)) else { continue };
        if from != to {
            split(&points, &tree, [from, to], (tolerance, budget), &mut touched, &mut edges)?;
        }
    }
    drop(tree);
    edges.sort_unstable();
    edges.dedup();

    let scale = scale_of(farthest);

    let scaled = |point: &Vector<2>| Vertex(Point2::new(point.x * scale, point.y * scale));
    let vertices: Vec<Vertex> = points.iter().map(scaled).collect();
    let mut crossing = Vec::new();
    let mesh = Mesh::try_bulk_load_cdt(vertices, edges, |edge| crossing.push(edge));
    // Coordinates are finite and small enough.
    let Ok(mut mesh) = mesh else { return Err(FloorError::Empty) };
    for [from, to] in crossing {
        let before = mesh.num_vertices();
        let [from, to] = [from, to].map(FixedVertexHandle::from_index);
        mesh.add_constraint_and_split(from, to, Vertex);
        let added = (mesh.num_vertices() - before) as u64;
        budget.step((1 + added) * STEPS_PER_CROSSING)?;
        held.resize(mesh.num_vertices().saturating_mul(BYTES_PER_VERTEX))?;
    }
    let first_crossing = points.len();
    points.extend(mesh.vertices().skip(first_crossing).map(|vertex| {
        let at = vertex.position();
        Vector::from([at.x / scale, at.y / scale])
    }));
    let floor = read(&mesh, points, extent, farthest);
    if floor.faces.is_empty() { Err(FloorError::Empty) } else { Ok(floor) }
}

/// Appends a wall in pieces between the vertices that it all but touches. Where walls that should
/// coincide differ by rounding, as in a scene that was turned, they become the same pieces.
fn split(
    points: &[Vector<2>],
    tree: &BoxTree<2>,
    [from, to]: [usize; 2],
    (tolerance, budget): (f64, &Budget<'_>),
    touched: &mut Vec<(f64, usize)>,
    edges: &mut Vec<[usize; 2]>,
) -> Result<(), Spent> {
    let (begin, end) = (points[from], points[to]);
    let way = end - begin;
    let length = way.norm();
    touched.clear();
    tree.visit_along((&begin, &end), tolerance, budget, |index| {
        let apart = points[index] - begin;
        let along = apart.dot(&way) / length;
        let across = cross(&way, &apart).abs() / length;
        if index != from && index != to && across <= tolerance && 0.0 < along && along < length {
            touched.push((along, index));
        }
        true
    })?;
    touched.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut before = from;
    for stop in touched.iter().map(|(_, index)| *index).chain([to]) {
        edges.push([before.min(stop), before.max(stop)]);
        before = stop;
    }
    Ok(())
}

/// The power of two that brings the greatest coordinate into spade's range.
fn scale_of(farthest: f64) -> f64 {
    if farthest > GREATEST || (0.0 < farthest && farthest < 1.0 / GREATEST) {
        libm::exp2(-libm::log2(farthest).floor())
    } else {
        1.0
    }
}

fn read(mesh: &Mesh, vertices: Vec<Vector<2>>, extent: f64, farthest: f64) -> Floor {
    // Inner faces follow the outer one.
    let index = |face: usize| u32::try_from(face - 1).unwrap_or(NONE);
    let vertex_index = |vertex: usize| u32::try_from(vertex).unwrap_or(NONE);
    let mut face_at = vec![NONE; vertices.len()];
    let faces: Vec<Face> = mesh
        .inner_faces()
        .map(|face| {
            let edges = face.adjacent_edges();
            Face {
                vertices: edges.map(|edge| {
                    let vertex = edge.from().index();
                    face_at[vertex] = index(face.index());
                    vertex_index(vertex)
                }),
                across: edges.map(|edge| {
                    edge.rev().face().as_inner().map_or(NONE, |face| index(face.index()))
                }),
                is_wall: edges.map(|edge| edge.is_constraint_edge()),
            }
        })
        .collect();
    Floor { vertices, faces, face_at, corners: Vec::new(), extent, farthest }
}
