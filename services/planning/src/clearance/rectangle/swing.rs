//! A body that turns rigidly about a centre: along an arc of a guiding circle or, with
//! radius 0, in place.

use std::f64::consts::FRAC_PI_2;

use super::along_wall::{NearShape, PlacedRectangle, Sector};
use super::segment::{Rectangle, Segment};
use super::slide::bounds;
use super::{Footprint, Met, TIE};
use crate::free_space::walls::Wall;
use crate::geometry::distance::cross;
use crate::geometry::{Sign, Vector, rotated, unit, unrotated};

/// The motion in the frame of the body half-way: origin at the centre of the turn, x axis
/// along the heading. The angle turned then runs from minus to plus half the sweep (or
/// back), so one comparison of cosines tells whether an angle is within the sweep.
pub(super) struct Swing {
    center: Vector<2>,
    middle: Vector<2>,
    body: Rectangle,
    /// The two near the centre, then the two far from it.
    corners: [Vector<2>; 4],
    /// Distances of the corners from the centre.
    radii: [f64; 4],
    /// Whether the two corners of a side share a circle: the reference point is in the middle.
    is_even: bool,
    /// The greatest of the radii.
    outer: f64,
    /// The unit vector at half of the sweep's size.
    half: Vector<2>,
    half_sweep: f64,
    sense: Sign,
    /// Least distance of the body from the centre.
    inner: f64,
}

impl Swing {
    pub(super) fn on_arc(
        footprint: &Footprint,
        (center, radius, start_angle, sweep): (&Vector<2>, f64, f64, f64),
        reverse: bool,
    ) -> Self {
        // The centre lies to the left of a body that drives a left turn forwards.
        let sense = Sign::of(sweep);
        let side = if reverse { sense.opposite() } else { sense }.factor();
        let heading = start_angle + side * FRAC_PI_2 + sweep / 2.0;
        Self::new(footprint, center, -side * radius, heading, sweep)
    }

    pub(super) fn in_place(
        footprint: &Footprint,
        position: &Vector<2>,
        from_heading: f64,
        sweep: f64,
    ) -> Self {
        Self::new(footprint, position, 0.0, from_heading + sweep / 2.0, sweep)
    }

    fn new(
        footprint: &Footprint,
        center: &Vector<2>,
        offset: f64,
        heading: f64,
        sweep: f64,
    ) -> Self {
        let mut body = footprint.rectangle();
        body.center.y = offset;
        let (rear, front) = (-footprint.rear, footprint.front);
        let half_width = body.half.y;
        let near = if offset < 0.0 { half_width } else { -half_width };
        let corners = [
            Vector::<2>::new(rear, offset + near),
            Vector::<2>::new(front, offset + near),
            Vector::<2>::new(rear, offset - near),
            Vector::<2>::new(front, offset - near),
        ];
        let radii = corners.map(|corner| corner.dot(&corner).sqrt());
        Self {
            center: *center,
            middle: unit(heading),
            body,
            corners,
            radii,
            is_even: footprint.front == footprint.rear,
            outer: radii[2].max(radii[3]),
            half: unit(sweep.abs() / 2.0),
            half_sweep: sweep.abs() / 2.0,
            sense: Sign::of(sweep),
            // The reference point lies between front and rear, and so nearest to the centre.
            inner: (offset.abs() - half_width).max(0.0),
        }
    }

    /// A box around the swept set: around both end placements, enlarged by how far a corner's
    /// circle bulges over its chord.
    pub(super) fn bounds(&self) -> (Vector<2>, Vector<2>) {
        let conjugate = Vector::<2>::new(self.half.x, -self.half.y);
        let ends = [self.half, conjugate].map(|turn| {
            let heading = rotated(&self.middle, &turn);
            let center = self.center + rotated(&self.body.center, &heading);
            bounds(&center, &heading, &self.body.half)
        });
        let bulge = self.outer * (1.0 - self.half.x);
        let bulge = Vector::<2>::new(bulge, bulge);
        (ends[0].0.inf(&ends[1].0) - bulge, ends[0].1.sup(&ends[1].1) + bulge)
    }

    /// What a wall point outside the body comes close to: the body at both ends, the circle of
    /// a corner, the circle inside.
    pub(super) fn shapes(&self) -> [NearShape; 7] {
        let placed = |turn: Vector<2>| {
            let heading = rotated(&self.middle, &turn);
            NearShape::Rectangle(
                PlacedRectangle { origin: self.center, heading, shape: self.body },
                0.0,
            )
        };
        let to_end = Vector::<2>::new(self.half.x, self.sense.factor() * self.half.y);
        let sector =
            |middle: Vector<2>| Sector { middle: rotated(&middle, &self.middle), half: self.half };
        let corner = |index: usize| {
            let (corner, radius) = (self.corners[index], self.radii[index]);
            // A corner in the centre has no direction, and does not move.
            let sector = sector(if radius > 0.0 { corner / radius } else { Vector::zeros() });
            NearShape::Outside(self.center, radius, sector)
        };
        let side = Vector::<2>::new(0.0, Sign::of(self.body.center.y).factor());
        [
            placed(Vector::<2>::new(to_end.x, -to_end.y)),
            placed(to_end),
            corner(0),
            corner(1),
            corner(2),
            corner(3),
            NearShape::Inside(self.center, self.inner, sector(side)),
        ]
    }

    pub(super) fn meet(&self, wall: &Wall<2>, met: &mut Met) {
        let segment = Segment::seen(wall, &self.center, &self.middle);
        let ends = [segment.from, segment.from + segment.span];
        let seen = Seen {
            foot: segment.foot(&Vector::<2>::zeros()),
            line: cross(&segment.from, &segment.span).abs() * segment.inverse_length,
            lengths: ends.map(|end| end.dot(&end).sqrt()),
            ends,
            segment,
        };
        // The body stays between two circles, far from which the wall may be.
        let nearest = if seen.crosses() { seen.line } else { seen.lengths[0].min(seen.lengths[1]) };
        let farthest = seen.lengths[0].max(seen.lengths[1]);
        if !met.wants((nearest - self.outer).max(self.inner - farthest)) {
            return;
        }
        self.placements(wall, &seen, met);
        let on_circle = if self.is_even { 2 } else { 1 };
        for (corners, radii) in self.corners.chunks(on_circle).zip(self.radii.chunks(on_circle)) {
            self.corners_to_wall(wall, &seen, corners, radii[0], met);
        }
        for end in 0..2 {
            self.wall_end_to_edges(wall, &seen, end, met);
        }
    }

    /// The body at the start and at the end of the motion.
    fn placements(&self, wall: &Wall<2>, seen: &Seen, met: &mut Met) {
        let to_end = Vector::<2>::new(self.half.x, self.sense.factor() * self.half.y);
        let to_start = Vector::<2>::new(to_end.x, -to_end.y);
        for (turn, along) in [(to_start, 0.0), (to_end, 1.0)] {
            seen.segment.unrotated(&turn).meet(&self.body, met.value + TIE, |distance, t| {
                met.offer(distance, along, point(wall, t));
            });
        }
    }

    /// Body corners on one circle about the centre against the wall.
    fn corners_to_wall(
        &self,
        wall: &Wall<2>,
        seen: &Seen,
        corners: &[Vector<2>],
        radius: f64,
        met: &mut Met,
    ) {
        if radius == 0.0 {
            // The corner stays where it is.
            return;
        }
        let mut candidate = |distance: f64, target: &Vector<2>, length: f64, t: f64| {
            if !met.wants(distance) {
                return;
            }
            for corner in corners {
                let turn = unrotated(target, corner) / (radius * length);
                self.offer(wall, distance, &turn, t, met);
            }
        };
        if seen.segment.inverse_length > 0.0 {
            if radius <= seen.line {
                if seen.crosses() {
                    let foot = seen.segment.at(seen.foot);
                    candidate(seen.line - radius, &foot, seen.line, seen.foot);
                }
            } else {
                let chord = (radius * radius - seen.line * seen.line).sqrt();
                let chord = chord * seen.segment.inverse_length;
                for t in [seen.foot - chord, seen.foot + chord] {
                    if (0.0..=1.0).contains(&t) {
                        candidate(0.0, &seen.segment.at(t), radius, t);
                    }
                }
            }
        }
        for (t, (end, &length)) in [0.0, 1.0].into_iter().zip(seen.ends.iter().zip(&seen.lengths)) {
            if length > 0.0 {
                candidate((length - radius).abs(), end, length, t);
            }
        }
    }

    /// An end of the wall, which moves on a circle in the body's frame, against the edges
    /// of the body.
    fn wall_end_to_edges(&self, wall: &Wall<2>, seen: &Seen, index: usize, met: &mut Met) {
        let (end, length, t) = (&seen.ends[index], seen.lengths[index], index as f64);
        if length == 0.0 || length > self.outer {
            return;
        }
        let (center, half) = (&self.body.center, &self.body.half);
        let mut candidate = |distance: f64, x: f64, y: f64| {
            let turn = unrotated(end, &Vector::<2>::new(x, y)) / (length * length);
            self.offer(wall, distance, &turn, t, met);
        };
        if length < self.inner {
            candidate(self.inner - length, 0.0, length * Sign::of(center.y).factor());
            return;
        }
        // More than the square of what an edge reaches.
        let most = (center.abs() + half).map(|reach| 1.000_001 * reach * reach);
        for y in [center.y - half.y, center.y + half.y] {
            let square = length * length - y * y;
            if (0.0..=most.x).contains(&square) {
                let x = square.sqrt();
                for x in [x, -x] {
                    if (x - center.x).abs() <= half.x {
                        candidate(0.0, x, y);
                    }
                }
            }
        }
        let (front, rear) = (center.x + half.x, center.x - half.x);
        let mut across = |square: f64, ends: &[f64]| {
            if (0.0..=most.y).contains(&square) {
                let y = square.sqrt();
                for x in ends {
                    for y in [y, -y] {
                        if (y - center.y).abs() <= half.y {
                            candidate(0.0, *x, y);
                        }
                    }
                }
            }
        };
        let square = length * length;
        if self.is_even {
            across(square - front * front, &[front, rear]);
        } else {
            across(square - front * front, &[front]);
            across(square - rear * rear, &[rear]);
        }
    }

    /// Offers a distance that occurs at the angle of the unit vector `turn` from half-way, if
    /// that is within the sweep.
    fn offer(&self, wall: &Wall<2>, distance: f64, turn: &Vector<2>, t: f64, met: &mut Met) {
        if turn.x < self.half.x || !met.wants(distance) {
            return;
        }
        let angle = self.sense.factor() * libm::atan2(turn.y, turn.x);
        let along = if self.half_sweep > 0.0 { 0.5 + 0.5 * angle / self.half_sweep } else { 0.0 };
        met.offer(distance, along.clamp(0.0, 1.0), point(wall, t));
    }
}

/// A wall in the frame of a [`Swing`].
struct Seen {
    segment: Segment,
    ends: [Vector<2>; 2],
    /// Distances of the ends from the centre.
    lengths: [f64; 2],
    /// Distance of the wall's line from the centre.
    line: f64,
    /// Parameter of the centre's foot on that line.
    foot: f64,
}

impl Seen {
    /// Whether the foot lies between the ends of the wall.
    fn crosses(&self) -> bool {
        0.0 < self.foot && self.foot < 1.0
    }
}

fn point(wall: &Wall<2>, t: f64) -> Vector<2> {
    wall.from + (wall.to - wall.from) * t
}
