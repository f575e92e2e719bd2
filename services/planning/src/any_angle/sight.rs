//! What can be seen from a point: vertices of the floor, junction by junction.

use crate::free_space::floor::{Face, Floor, NONE};
use crate::geometry::Vector;
use crate::geometry::distance::cross;
use crate::geometry::orientation::{Side, side_of_line};

/// A junction seen from a point through all junctions before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sight {
    /// The face that is entered.
    pub(super) face: u32,
    /// The edge of that face by which it is entered.
    pub(super) edge: u8,
    /// The vertices that bound the view on the right and on the left.
    pub(super) bounds: [u32; 2],
    /// An end of the first junction on the way that is too narrow for the disc; `NONE` if there
    /// is none.
    pub(super) narrow: u32,
    /// The gate of the pocket that the face is in; `NONE` if it is in none, or in one unknown.
    pub(super) gate: u32,
}

impl Sight {
    /// The views through the edges of a face that do not hold the point they are seen from.
    pub(super) fn from_face(
        floor: &Floor,
        point: &Vector<2>,
        face: &Face,
        index: u32,
    ) -> impl Iterator<Item = Self> {
        (0..3).filter_map(move |edge| {
            let [right, left] = [edge, (edge + 1) % 3].map(|at| face.vertices[at]);
            let is_seen = side_of_line(&floor.vertex(right), &floor.vertex(left), point);
            let beyond = face.beyond(edge).filter(|_| is_seen == Side::Left)?;
            Self::through(floor, index, beyond, ([right, left], [NONE; 2]))
        })
    }

    fn through(
        floor: &Floor,
        from: u32,
        into: u32,
        (bounds, [narrow, gate]): ([u32; 2], [u32; 2]),
    ) -> Option<Self> {
        let edge = floor.face(into).edge_to(from)?;
        Some(Self { face: into, edge: edge as u8, bounds, narrow, gate })
    }

    /// The ends of the junction on the right and on the left.
    pub(super) fn ends(&self, face: &Face) -> [u32; 2] {
        let edge = usize::from(self.edge);
        [face.vertices[(edge + 1) % 3], face.vertices[edge]]
    }

    /// The vertex beyond the junction.
    pub(super) fn apex(&self, face: &Face) -> u32 {
        face.vertices[(usize::from(self.edge) + 2) % 3]
    }

    /// Whether a point in the face is seen.
    pub(super) fn shows(&self, floor: &Floor, from: &Vector<2>, point: &Vector<2>) -> bool {
        let [right, left] = self.bounds.map(|bound| floor.vertex(bound));
        side_of_line(from, &right, point) != Side::Right
            && side_of_line(from, &left, point) != Side::Left
    }

    /// The views through the two other edges of the face, and whether its apex is seen.
    pub(super) fn further(&self, floor: &Floor, from: &Vector<2>) -> ([Option<Self>; 2], bool) {
        let face = floor.face(self.face);
        let edge = usize::from(self.edge);
        let apex = self.apex(face);
        let [right, left] = self.bounds;
        let of_right = floor.side(from, right, apex);
        let of_left = floor.side(from, left, apex);
        let beyond = |edge: usize, bounds: [u32; 2]| {
            let behind = [self.narrow, self.gate];
            face.beyond(edge)
                .and_then(|into| Self::through(floor, self.face, into, (bounds, behind)))
        };
        let through_right = (of_right == Side::Left)
            .then(|| [right, if of_left == Side::Right { apex } else { left }])
            .and_then(|bounds| beyond((edge + 1) % 3, bounds));
        let through_left = (of_left == Side::Right)
            .then(|| [if of_right == Side::Left { apex } else { right }, left])
            .and_then(|bounds| beyond((edge + 2) % 3, bounds));
        let is_seen = of_right != Side::Right && of_left != Side::Left;
        ([through_right, through_left], is_seen)
    }

    /// The part of the junction that is seen: its ends on the right and on the left.
    pub(super) fn window(&self, floor: &Floor, from: &Vector<2>) -> [Vector<2>; 2] {
        let ends = self.ends(floor.face(self.face));
        let junction = ends.map(|end| floor.vertex(end));
        [0, 1].map(|side| {
            if self.bounds[side] == ends[side] {
                return junction[side];
            }
            let ray = floor.vertex(self.bounds[side]) - from;
            let [right, left] = junction.map(|end| cross(&ray, &(end - from)));
            let part = right / (right - left);
            // In a narrow view both ends may be on the ray, to rounding.
            if (0.0..=1.0).contains(&part) {
                junction[0] + (junction[1] - junction[0]) * part
            } else {
                junction[side]
            }
        })
    }
}

/// The least length of a way from one point through a window to another, metres.
pub(super) fn way_through(from: &Vector<2>, [right, left]: &[Vector<2>; 2], to: &Vector<2>) -> f64 {
    let along = left - right;
    let square = along.norm_squared();
    let mut to = *to;
    if square > 0.0 {
        let height = |point: &Vector<2>| cross(&along, &(point - right));
        if height(from) * height(&to) > 0.0 {
            // On this side of the window: what reaches its mirror image is as long.
            let normal = Vector::<2>::new(-along.y, along.x);
            to -= normal * (2.0 * height(&to) / square);
        }
    }
    let way = to - from;
    let by = |point: &Vector<2>| (point - from).norm() + (to - point).norm();
    if cross(&(right - from), &way) < 0.0 {
        by(right)
    } else if cross(&(left - from), &way) > 0.0 {
        by(left)
    } else {
        way.norm()
    }
}
