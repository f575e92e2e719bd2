//! A trajectory as a curve: the body's position and heading at an arc length.

use std::f64::consts::{FRAC_PI_2, PI};

use schemas::message::{Curve, Leg, Trajectory, Vector};

use super::world::{Point, point};

/// The curves of a motion with their lengths.
pub struct Course {
    pieces: Vec<Piece>,
}

#[derive(Clone, Copy)]
struct Piece {
    curve: Curve,
    /// Metres.
    length: f64,
    reverse: bool,
}

/// The reference point's position (in assembly tasks, the displacement), and the heading.
#[derive(Debug, Clone, Copy)]
pub struct Placement {
    /// Metres; unused coordinates are 0.
    pub position: [f64; 3],
    /// Radians.
    pub heading: f64,
}

/// The most samples that are drawn if there are no legs.
const MOST_SAMPLES: usize = 2000;

impl Course {
    /// The course of an answer, from its legs, or its samples if it has none.
    pub fn of(answer: &Trajectory) -> Self {
        if !answer.legs.is_empty() {
            let piece = |leg: &Leg| Piece {
                curve: leg.curve,
                length: finite(leg.length).max(0.0),
                reverse: leg.reverse,
            };
            return Self { pieces: answer.legs.iter().map(piece).collect() };
        }
        let stride = answer.samples.len().div_ceil(MOST_SAMPLES).max(1);
        let samples: Vec<_> = answer.samples.iter().step_by(stride).collect();
        let line = |pair: &[&schemas::message::Sample]| {
            let [from, to] = [pair[0].position, pair[1].position].map(Vector::from);
            let (a, b) = (point(&from), point(&to));
            let length = libm::hypot(libm::hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2]);
            let curve = Curve::Line { from, to, heading: pair[1].heading, turned: 0.0 };
            Piece { curve, length, reverse: false }
        };
        Self { pieces: samples.windows(2).map(line).collect() }
    }

    /// The stretches that are driven in reverse.
    pub(super) fn reversed(&self) -> Vec<Self> {
        let stretches = self.pieces.chunk_by(|a, b| a.reverse == b.reverse);
        let reversed = stretches.filter(|stretch| stretch[0].reverse);
        reversed.map(|stretch| Self { pieces: stretch.to_vec() }).collect()
    }

    /// The turns in place that can be seen: where, from which heading, and by how much.
    pub(super) fn turns(&self) -> impl Iterator<Item = (Point, f64, f64)> {
        self.curves().filter_map(|curve| match curve {
            Curve::Turn { position, from_heading, sweep, .. } if sweep.abs() > 0.01 => {
                Some((point(position), finite(*from_heading), finite(*sweep)))
            }
            _ => None,
        })
    }

    pub(super) fn curves(&self) -> impl Iterator<Item = &Curve> {
        self.pieces.iter().map(|piece| &piece.curve)
    }

    pub(super) fn length(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.length).sum()
    }

    /// Begin of the first curve and end of each.
    pub(super) fn way_points(&self) -> Vec<Placement> {
        let begin = self.pieces.first().map(|piece| piece.at(0.0));
        begin.into_iter().chain(self.pieces.iter().map(|piece| piece.at(1.0))).collect()
    }

    /// The arc length at the end of each curve.
    pub(super) fn ends(&self) -> Vec<f64> {
        let sum = |total: &mut f64, piece: &Piece| {
            *total += piece.length;
            Some(*total)
        };
        self.pieces.iter().scan(0.0, sum).collect()
    }

    /// Where the body is at this arc length.
    pub fn placement(&self, at_length: f64) -> Option<Placement> {
        let mut left = finite(at_length).max(0.0);
        for piece in &self.pieces {
            if left <= piece.length && piece.length > 0.0 {
                return Some(piece.at(left / piece.length));
            }
            left -= piece.length;
        }
        match at_length > 0.0 {
            true => self.pieces.last().map(|piece| piece.at(1.0)),
            false => self.pieces.first().map(|piece| piece.at(0.0)),
        }
    }

    /// Placements from the begin to the end, turns in place included: no point up to `reach`
    /// from the reference point moves further than about `step` from one to the next (metres).
    pub fn placements(&self, step: f64, reach: f64) -> impl Iterator<Item = Placement> {
        const MOST: f64 = 1e6;
        self.pieces.iter().flat_map(move |piece| {
            let angle = match piece.curve {
                Curve::Line { turned, .. } => turned,
                Curve::Arc { sweep, .. } | Curve::Turn { sweep, .. } => sweep,
                Curve::Clothoid { curvatures: [first, last], length, .. } => {
                    0.5 * (first + last) * length
                }
            };
            let way = piece.length + finite(angle).abs() * reach;
            let steps = (way / step).ceil().clamp(1.0, MOST) as u32;
            (0..=steps).map(move |index| piece.at(f64::from(index) / f64::from(steps)))
        })
    }

    /// The middle of the longest straight curve and the direction there.
    pub(super) fn longest_line(&self) -> Option<(Point, Point)> {
        let lines = self.pieces.iter().filter_map(|piece| match &piece.curve {
            Curve::Line { from, to, .. } => Some((point(from), point(to), piece.length)),
            _ => None,
        });
        lines.max_by(|a, b| a.2.total_cmp(&b.2)).map(|(from, to, _)| (from, to))
    }
}

impl Piece {
    /// The state after a part (0 to 1) of it.
    fn at(&self, part: f64) -> Placement {
        let placement = at(&self.curve, part);
        match self.curve {
            // An arc's own heading is that of driving forwards.
            Curve::Arc { .. } if self.reverse => {
                Placement { heading: placement.heading + PI, ..placement }
            }
            _ => placement,
        }
    }
}

/// Steps over which a clothoid is summed up; they show in no picture.
const CLOTHOID_STEPS: u32 = 64;

/// The place and the heading after a part (0 to 1) of a clothoid: summed up, and drawn to where it ends.
fn on_clothoid(
    [from, to]: [Point; 2],
    heading: f64,
    ([first, last], length): ([f64; 2], f64),
    part: f64,
) -> Placement {
    let turned = |part: f64| part * length * (first + 0.5 * part * (last - first));
    let steps = f64::from(CLOTHOID_STEPS);
    // Driven forwards, until so many steps.
    let way = |until: f64| {
        (0..CLOTHOID_STEPS).map(f64::from).fold([0.0, 0.0], |[x, y], step| {
            let direction = heading + turned((step + 0.5) / steps);
            let run = length / steps * (until - step).clamp(0.0, 1.0);
            [x + run * libm::cos(direction), y + run * libm::sin(direction)]
        })
    };
    let (whole, here) = (way(steps), way(part * steps));
    let ahead = (to[0] - from[0]) * whole[0] + (to[1] - from[1]) * whole[1];
    let sense = if ahead < 0.0 { -1.0 } else { 1.0 };
    let mut position: Point = std::array::from_fn(|i| from[i] + part * (to[i] - from[i]));
    for axis in 0..2 {
        position[axis] += sense * (here[axis] - part * whole[axis]);
    }
    Placement { position, heading: heading + turned(part) }
}

/// The state after a part (0 to 1) of a curve that is driven forwards.
fn at(curve: &Curve, part: f64) -> Placement {
    match curve {
        Curve::Line { from, to, heading, turned } => {
            let (a, b) = (point(from), point(to));
            let position = std::array::from_fn(|i| a[i] + part * (b[i] - a[i]));
            let heading = finite(heading - turned * (1.0 - part));
            Placement { position, heading }
        }
        Curve::Arc { center, radius, start_angle, sweep } => {
            let (center, radius) = (point(center), finite(*radius));
            let angle = finite(start_angle + part * sweep);
            let (sin, cos) = (libm::sin(angle), libm::cos(angle));
            let position = [center[0] + radius * cos, center[1] + radius * sin, center[2]];
            Placement { position, heading: angle + FRAC_PI_2 * sweep.signum() }
        }
        Curve::Clothoid { from, to, from_heading, curvatures, length, .. } => {
            let (ends, heading) = ([from, to].map(point), finite(*from_heading));
            on_clothoid(ends, heading, (curvatures.map(finite), finite(*length)), part)
        }
        Curve::Turn { position, from_heading, sweep, .. } => {
            Placement { position: point(position), heading: finite(from_heading + part * sweep) }
        }
    }
}

/// The point after a part (0 to 1) of a curve.
pub(super) fn along(curve: &Curve, part: f64) -> Point {
    at(curve, part).position
}

/// The begin of a curve.
pub(super) fn begin(curve: &Curve) -> Point {
    at(curve, 0.0).position
}

/// The end of a curve.
pub(super) fn end(curve: &Curve) -> Point {
    at(curve, 1.0).position
}

fn finite(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value.clamp(-1e100, 1e100) }
}
