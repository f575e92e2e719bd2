//! One sum: a convex polygon that a displacement must keep out of.

use crate::geometry::Vector;
use crate::geometry::distance::cross;
use crate::geometry::orientation::Side;
use crate::translation::convex;

/// Up to this many vertices all of them are looked at.
const FEW: usize = 12;

/// A face of a sum: its outward unit normal, and how far the sum reaches along it, metres, less
/// what counts as contact.
#[derive(Debug, Clone, Copy)]
struct SumFace {
    normal: Vector<2>,
    reach: f64,
}

/// A shift of the displacement, straight from one to another.
#[derive(Debug, Clone, Copy)]
pub(in crate::translation) struct Shift {
    pub(super) from: Vector<2>,
    pub(super) to: Vector<2>,
    pub(super) along: Vector<2>,
    length: f64,
}

impl Shift {
    pub(in crate::translation) fn new(from: &Vector<2>, to: &Vector<2>) -> Self {
        let along = to - from;
        Self { from: *from, to: *to, along, length: along.norm() }
    }

    pub(in crate::translation) fn along(&self) -> &Vector<2> {
        &self.along
    }

    pub(in crate::translation) fn length(&self) -> f64 {
        self.length
    }

    /// Whether it comes into a circle; it may say so of one that it passes by.
    pub(in crate::translation) fn comes_near(&self, (center, radius): &(Vector<2>, f64)) -> bool {
        let Self { from, along, length, .. } = self;
        let to = center - from;
        if *length == 0.0 {
            return to.norm_squared() < radius * radius;
        }
        let (ahead, room) = (along.dot(&to), radius * length);
        cross(along, &to).abs() < room && -room < ahead && ahead < length * length + room
    }

    /// Whether it comes into the box between two corners; it may say so of one that it passes by.
    pub(super) fn comes_into(&self, [min, max]: &[Vector<2>; 2]) -> bool {
        let Self { from, to, along, .. } = self;
        let (low, high) = (from.inf(to), from.sup(to));
        if (0..2).any(|axis| max[axis] <= low[axis] || high[axis] <= min[axis]) {
            return false;
        }
        let half = (max - min) / 2.0;
        let off = cross(along, &(min + half - from)).abs();
        self.length == 0.0 || off < along.x.abs() * half.y + along.y.abs() * half.x
    }
}

/// A convex polygon, counter-clockwise from the lowest of its vertices.
#[derive(Debug, Clone)]
pub(in crate::translation) struct SumPolygon {
    vertices: Vec<Vector<2>>,
    /// A face begins at each vertex.
    faces: Vec<SumFace>,
    /// What its faces count as contact, metres.
    slack: f64,
    /// A circle around it.
    center: Vector<2>,
    radius: f64,
}

impl SumPolygon {
    /// Of a polygon counter-clockwise.
    pub(super) fn new(mut vertices: Vec<Vector<2>>, slack: f64) -> Self {
        vertices.dedup();
        if vertices.first() == vertices.last() {
            vertices.pop();
        }
        let lowest = convex::lowest(&vertices);
        vertices.rotate_left(lowest);
        let faces = convex::normals(&vertices)
            .map(|(normal, reach)| SumFace { normal, reach: reach - slack })
            .collect();
        let [min, max] = convex::bounds(&vertices);
        let center = if vertices.is_empty() { Vector::zeros() } else { (min + max) / 2.0 };
        let square = vertices.iter().map(|at| (at - center).norm_squared()).fold(0.0, f64::max);
        Self { vertices, faces, slack, center, radius: square.sqrt() }
    }

    pub(in crate::translation) fn vertices(&self) -> &[Vector<2>] {
        &self.vertices
    }

    /// The centre and the radius of a circle around it, metres.
    pub(in crate::translation) fn around(&self) -> (Vector<2>, f64) {
        (self.center, self.radius)
    }

    /// Whether no part of a shift is inside, as is soon found; false says nothing.
    pub(super) fn is_passed_by(&self, shift: &Shift) -> bool {
        !shift.comes_near(&self.around()) || self.is_beside(shift)
    }

    /// Whether some of a shift is inside by more than the contact.
    pub(in crate::translation) fn is_entered_by(&self, shift: &Shift) -> bool {
        !self.is_beside(shift) && self.part_within(shift) > 0.0
    }

    /// Whether all of it is on one side of the line of a shift, as is soon found; false says nothing.
    fn is_beside(&self, shift: &Shift) -> bool {
        let Shift { from, along, length, .. } = shift;
        if self.vertices.len() <= FEW || *length == 0.0 {
            return false;
        }
        self.farthest_left(from, along) <= 0.0 || self.farthest_left(from, &-along) <= 0.0
    }

    /// How far it reaches to the left of the line from a point along `direction`, as a multiple of its
    /// length; negative if it is on the right.
    pub(in crate::translation) fn farthest_left(
        &self,
        from: &Vector<2>,
        direction: &Vector<2>,
    ) -> f64 {
        let off = |vertex: &Vector<2>| cross(direction, &(vertex - from));
        if self.vertices.len() <= FEW {
            return self.vertices.iter().map(off).fold(f64::NEG_INFINITY, f64::max);
        }
        // Where its sides are parallel to the line.
        off(&self.vertices[self.first_side_from(&-direction)])
    }

    /// The vertex at which the first side begins that does not come before a direction.
    fn first_side_from(&self, direction: &Vector<2>) -> usize {
        let count = self.vertices.len();
        let side = |at: usize| self.vertices[(at + 1) % count] - self.vertices[at];
        let (mut first, mut end) = (0, count);
        while first < end {
            let middle = usize::midpoint(first, end);
            if convex::angle_order(&side(middle), direction) > 0.0 {
                first = middle + 1;
            } else {
                end = middle;
            }
        }
        first % count
    }

    /// How much of a shift, from 0 to 1, is inside by more than the contact.
    pub(super) fn part_within(&self, shift: &Shift) -> f64 {
        let Shift { from, along, .. } = shift;
        let (mut enter, mut exit) = (0.0_f64, 1.0_f64);
        for SumFace { normal, reach } in &self.faces {
            let depth = reach - normal.dot(from);
            let rate = normal.dot(along);
            if rate > 0.0 {
                exit = exit.min(depth / rate);
            } else if rate < 0.0 {
                enter = enter.max(depth / rate);
            } else if depth <= 0.0 {
                return 0.0;
            }
            if exit <= enter {
                return 0.0;
            }
        }
        exit - enter
    }

    /// The shortest move out of it, metres.
    pub(super) fn out(&self, at: &Vector<2>) -> Option<Vector<2>> {
        let faces = convex::normals(&self.vertices);
        let out = faces.map(|(normal, reach)| normal * (reach - normal.dot(at)));
        out.min_by(|a, b| a.norm().total_cmp(&b.norm()))
    }

    /// Calls `visit` with each vertex at which a line from `point` touches it, no closer than
    /// `tolerance`, and the side of the line on which it is.
    pub(in crate::translation) fn touching(
        &self,
        point: &Vector<2>,
        tolerance: f64,
        mut visit: impl FnMut(usize, &Vector<2>, Side),
    ) {
        let Self { vertices, faces, slack, .. } = self;
        let count = vertices.len();
        let beyond = |face: &SumFace| face.normal.dot(point) - face.reach - slack;
        let Some(mut left) = faces.last().map(beyond) else { return };
        for (at, (vertex, face)) in vertices.iter().zip(faces).enumerate() {
            // A line touches where one side faces the point and the next does not.
            let entered = std::mem::replace(&mut left, beyond(face));
            if entered * left > 0.0 && entered.abs().min(left.abs()) > tolerance {
                continue;
            }
            let (before, after) =
                (&vertices[(at + count - 1) % count], &vertices[(at + 1) % count]);
            let line = vertex - point;
            let length = line.norm();
            let side = |other: &Vector<2>| cross(&line, &(other - vertex)) / length;
            if length > 0.0 {
                let (a, b) = (side(before), side(after));
                if a >= -tolerance && b >= -tolerance {
                    visit(at, vertex, Side::Left);
                }
                if a <= tolerance && b <= tolerance {
                    visit(at, vertex, Side::Right);
                }
            }
        }
    }
}
