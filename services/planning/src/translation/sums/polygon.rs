//! One sum: a convex polygon that a displacement must keep out of.

use crate::geometry::Vector;
use crate::geometry::distance::{cross, nearest_on_segment};
use crate::geometry::orientation::Side;
use crate::translation::convex;

/// Up to this many vertices all of them are looked at.
const FEW: usize = 12;

/// A circle is well inside that has this part of the radius that there is room for, less contact.
const WELL: f64 = 0.999;

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

    /// Whether it has a point in a circle.
    fn meets(&self, (center, radius): &(Vector<2>, f64)) -> bool {
        (center - self.nearest(center)).norm_squared() <= radius * radius
    }

    /// The point on it that is nearest to another, but for rounding.
    fn nearest(&self, point: &Vector<2>) -> Vector<2> {
        nearest_on_segment(point, (&self.from, &self.to))
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
    /// The first vertex from which a side leads down.
    highest: usize,
    /// A face begins at each vertex.
    faces: Vec<SumFace>,
    /// What its faces count as contact, metres.
    slack: f64,
    /// A circle around it.
    center: Vector<2>,
    radius: f64,
    /// Of a circle about the same centre, all of which is well inside; may be negative.
    inner: f64,
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
            .collect::<Vec<_>>();
        let sides = crate::geometry::polygon::edges(&vertices).map(|(from, to)| to - from);
        let highest = sides.take_while(|side| !convex::leads_down(side)).count();
        let (center, radius) = convex::circle(vertices.iter());
        let depth = |face: &SumFace| face.reach - face.normal.dot(&center);
        // Nothing is inside of what has no faces.
        let depth = faces.iter().map(depth).reduce(f64::min);
        let inner = depth.map_or(f64::NEG_INFINITY, |depth| WELL * depth - slack);
        Self { vertices, highest, faces, slack, center, radius, inner }
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
        let is_well_inside = self.inner > 0.0 && shift.meets(&(self.center, self.inner));
        is_well_inside
            || !self.is_beside(shift) && !self.is_apart(shift) && self.part_within(shift) > 0.0
    }

    /// Whether all of it is on one side of the line of a shift, as is soon found; false says nothing.
    fn is_beside(&self, shift: &Shift) -> bool {
        let Shift { from, along, length, .. } = shift;
        if self.vertices.len() <= FEW || *length == 0.0 {
            return false;
        }
        self.farthest_left(from, along) <= 0.0 || self.farthest_left(from, &-along) <= 0.0
    }

    /// Whether a shift is wholly beyond a side that faces it, as is soon found; false says nothing.
    fn is_apart(&self, shift: &Shift) -> bool {
        let count = self.vertices.len();
        if count <= FEW {
            return false;
        }
        let facing = self.facing(&(shift.nearest(&self.center) - self.center));
        [facing, self.around_to(facing + count - 1)].iter().any(|side| {
            let SumFace { normal, reach } = &self.faces[*side];
            let depth = reach - normal.dot(&shift.from);
            depth <= 0.0 && depth - normal.dot(&shift.along) <= 0.0
        })
    }

    /// A side whose normal is the next from a direction on.
    fn facing(&self, direction: &Vector<2>) -> usize {
        self.first_side_from(&Vector::from([-direction.y, direction.x]))
    }

    /// How far it reaches to the left of the line from a point along `direction`, as a multiple of its
    /// length; negative if it is on the right.
    fn farthest_left(&self, from: &Vector<2>, direction: &Vector<2>) -> f64 {
        let off = |vertex: &Vector<2>| cross(direction, &(vertex - from));
        if self.vertices.len() <= FEW {
            return self.vertices.iter().map(off).fold(f64::NEG_INFINITY, f64::max);
        }
        // Where its sides are parallel to the line.
        off(&self.vertices[self.first_side_from(&-direction)])
    }

    /// Whether it reaches less far to the left of the line than so much, likewise.
    pub(in crate::translation) fn is_right_of(
        &self,
        (from, direction): (&Vector<2>, &Vector<2>),
        most: f64,
    ) -> bool {
        if self.vertices.len() <= FEW {
            return self.vertices.iter().all(|vertex| cross(direction, &(vertex - from)) < most);
        }
        self.farthest_left(from, direction) < most
    }

    /// Whether a point is inside by more than contact, and rounding.
    pub(in crate::translation) fn holds(&self, point: &Vector<2>) -> bool {
        self.faces.iter().all(|face| face.reach - face.normal.dot(point) > self.slack)
    }

    /// The vertex at which the first side begins that does not come before a direction.
    fn first_side_from(&self, direction: &Vector<2>) -> usize {
        let count = self.vertices.len();
        // First they lead up, then down.
        let (mut first, mut end) =
            if convex::leads_down(direction) { (self.highest, count) } else { (0, self.highest) };
        while first < end {
            let middle = usize::midpoint(first, end);
            if cross(&self.side(middle), direction) > 0.0 {
                first = middle + 1;
            } else {
                end = middle;
            }
        }
        self.around_to(first)
    }

    /// The side that begins at a vertex.
    fn side(&self, at: usize) -> Vector<2> {
        self.vertices[self.around_to(at + 1)] - self.vertices[at]
    }

    /// An index that is less than twice as many as there are vertices, counted around.
    fn around_to(&self, at: usize) -> usize {
        let count = self.vertices.len();
        if at < count { at } else { at - count }
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
        let mut look = |at: usize| self.touch_at(at, point, tolerance, &mut visit);
        if let Some([first, second]) = self.ends_of_facing_sides(point, tolerance) {
            look(first.min(second));
            look(first.max(second));
            return;
        }
        let Some(mut left) = self.faces.last().map(|face| self.beyond(face, point)) else { return };
        for (at, face) in self.faces.iter().enumerate() {
            // A line touches where one side faces the point and the next does not.
            let entered = std::mem::replace(&mut left, self.beyond(face, point));
            if entered * left <= 0.0 || entered.abs().min(left.abs()) <= tolerance {
                look(at);
            }
        }
    }

    /// How far a point is beyond a side, metres.
    fn beyond(&self, face: &SumFace, point: &Vector<2>) -> f64 {
        face.normal.dot(point) - face.reach - self.slack
    }

    /// Calls `visit` if a line from `point` touches it at a vertex.
    fn touch_at(
        &self,
        at: usize,
        point: &Vector<2>,
        tolerance: f64,
        visit: &mut impl FnMut(usize, &Vector<2>, Side),
    ) {
        let (vertices, count) = (&self.vertices, self.vertices.len());
        let vertex = &vertices[at];
        let before = &vertices[self.around_to(at + count - 1)];
        let after = &vertices[self.around_to(at + 1)];
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

    /// The vertices at which the sides end that face a point, and where they begin; `None` where that is
    /// not soon found, or a side is hardly farther from the point than `tolerance`, metres.
    fn ends_of_facing_sides(&self, point: &Vector<2>, tolerance: f64) -> Option<[usize; 2]> {
        let count = self.faces.len();
        if count <= FEW || count != self.vertices.len() {
            return None;
        }
        let beyond = |side: usize| self.beyond(&self.faces[self.around_to(side)], point);
        let to = point - self.center;
        let (facing, averted) = (self.facing(&to), self.facing(&-to));
        if beyond(facing) <= tolerance || beyond(averted) >= -tolerance {
            return None;
        }
        // Those that face it follow each other.
        let first_from = |first: usize, end: usize, is_past: &dyn Fn(f64) -> bool| {
            let (mut low, mut high) = (0, self.around_to(end + count - first));
            while high - low > 1 {
                let middle = usize::midpoint(low, high);
                if is_past(beyond(first + middle)) { high = middle } else { low = middle }
            }
            first + high
        };
        let end = first_from(facing, averted, &|beyond| beyond <= tolerance);
        let begin = first_from(averted, facing, &|beyond| beyond >= -tolerance);
        let is_clear = beyond(end) < -tolerance && beyond(begin) > tolerance;
        is_clear.then_some([end, begin].map(|at| self.around_to(at)))
    }
}
