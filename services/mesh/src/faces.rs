//! Triangles parallel to the axes, and the planes that they lie in.

use std::collections::BTreeMap;

use robust::Coord;

use crate::error::MeshError;

/// The faces of a mesh by their axis, and the planes between cells.
#[derive(Debug)]
pub(crate) struct Faces {
    /// Different coordinates of vertices along each axis, ascending.
    pub(crate) planes: [Vec<f64>; 3],
    /// Triangles across each axis.
    pub(crate) across: [Vec<Face>; 3],
}

/// A triangle in a plane across an axis.
#[derive(Debug)]
pub(crate) struct Face {
    /// The plane, among those of the axis.
    pub(crate) plane: usize,
    /// Its corners in the plane, along the two axes that follow, against the clock.
    corners: [[f64; 2]; 3],
    /// The planes of those axes that they are on.
    places: [[usize; 2]; 3],
    /// Whether its outside is where the axis decreases.
    pub(crate) opens: bool,
}

impl Face {
    /// Whether a point in the plane belongs to this triangle. Of two that share a side, a point on it belongs
    /// to one.
    pub(crate) fn has(&self, point: [f64; 2]) -> bool {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| {
            let side = turn(from, to, point);
            let owns = (to[1] - from[1]) < 0.0 || (to[1] == from[1] && to[0] < from[0]);
            side > 0.0 || (side == 0.0 && owns)
        })
    }

    /// The cells that it can cover along each of the two axes: from one to before the other.
    pub(crate) fn extent(&self) -> [[usize; 2]; 2] {
        let [a, b, c] = self.places;
        [0, 1].map(|axis| {
            let along = [a[axis], b[axis], c[axis]];
            [along.into_iter().min().unwrap_or(0), along.into_iter().max().unwrap_or(0)]
        })
    }
}

/// Positive if the way from the first over the second to the third point turns to the left; its sign is exact.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let [a, b, c] = [a, b, c].map(|[x, y]| Coord { x, y });
    robust::orient2d(a, b, c)
}

/// The two axes of a plane across one: with it, they are right-handed.
pub(crate) fn beside(axis: usize) -> [usize; 2] {
    [(axis + 1) % 3, (axis + 2) % 3]
}

/// Sorts triangles by axis and plane; those without area don't count.
pub(crate) fn sort(triangles: &[[[f64; 3]; 3]]) -> Result<Faces, MeshError> {
    let mut planes: [Vec<f64>; 3] = Default::default();
    for (triangle, corners) in triangles.iter().enumerate() {
        if !corners.iter().flatten().all(|number| number.is_finite()) {
            return Err(MeshError::NonFinite { triangle });
        }
        for (axis, planes) in planes.iter_mut().enumerate() {
            // Zero has one sign.
            planes.extend(corners.iter().map(|corner| corner[axis] + 0.0));
        }
    }
    for planes in &mut planes {
        planes.sort_unstable_by(f64::total_cmp);
        planes.dedup();
    }
    let mut across: [Vec<Face>; 3] = Default::default();
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some((axis, face)) = face(triangle, corners, &planes)? {
            across[axis].push(face);
        }
    }
    let faces = Faces { planes, across };
    match faces.loose_side() {
        Some(near) => Err(MeshError::Open { near }),
        None => Ok(faces),
    }
}

impl Faces {
    /// A place on a slanted side of a triangle that no other one has. If there is none, what the triangles
    /// of a plane cover ends along the planes across it, so that they cover cells as a whole.
    fn loose_side(&self) -> Option<[f64; 3]> {
        for (axis, faces) in self.across.iter().enumerate() {
            let mut open: BTreeMap<_, i32> = BTreeMap::new();
            for face in faces {
                let [a, b, c] = face.places;
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    if from[0] != to[0] && from[1] != to[1] {
                        let side = (face.plane, face.opens, from.min(to), from.max(to));
                        *open.entry(side).or_default() += if from < to { 1 } else { -1 };
                    }
                }
            }
            let loose = open.into_iter().find(|(_, times)| *times != 0);
            if let Some(((plane, _, at, _), _)) = loose {
                let [u, v] = beside(axis);
                let mut near = [0.0; 3];
                near[axis] = self.planes[axis][plane];
                (near[u], near[v]) = (self.planes[u][at[0]], self.planes[v][at[1]]);
                return Some(near);
            }
        }
        None
    }
}

/// The face of a triangle and the axis that it is across; none if it has no area.
fn face(
    triangle: usize,
    corners: &[[f64; 3]; 3],
    planes: &[Vec<f64>; 3],
) -> Result<Option<(usize, Face)>, MeshError> {
    let [a, b, c] = corners;
    let seen = |axis: usize| {
        let [u, v] = beside(axis);
        corners.map(|corner| [corner[u] + 0.0, corner[v] + 0.0])
    };
    let areas = [0, 1, 2].map(|axis| {
        let [a, b, c] = seen(axis);
        turn(a, b, c)
    });
    if areas == [0.0; 3] {
        return Ok(None);
    }
    let flat = (0..3).find(|&axis| a[axis] == b[axis] && b[axis] == c[axis]);
    let Some(axis) = flat else {
        let over = |choose: fn(f64, f64) -> f64| {
            [0, 1, 2].map(|axis| choose(choose(a[axis], b[axis]), c[axis]))
        };
        let (least, greatest) = (over(f64::min), over(f64::max));
        return Err(MeshError::Slanted { triangle, least, greatest });
    };
    let mut corners = seen(axis);
    let opens = areas[axis] < 0.0;
    if opens {
        corners.swap(1, 2);
    }
    let place = |axis: usize, at: f64| planes[axis].partition_point(|plane| *plane < at);
    let [u, v] = beside(axis);
    let places = corners.map(|corner| [place(u, corner[0]), place(v, corner[1])]);
    Ok(Some((axis, Face { plane: place(axis, a[axis]), corners, places, opens })))
}
