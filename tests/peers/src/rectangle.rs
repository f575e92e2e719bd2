//! A rectangle among walls.

use crate::scene::Pose;
use crate::{Point, along, between, direction, norm};

/// Walls in square buckets.
#[derive(Debug)]
pub struct Walls {
    walls: Vec<[Point; 2]>,
    min: Point,
    /// Side of a bucket, metres.
    bucket: f64,
    size: [usize; 2],
    buckets: Vec<Vec<usize>>,
}

/// Buckets along the longer side.
const BUCKETS: f64 = 25.0;

impl Walls {
    /// Sorts walls into buckets.
    #[must_use]
    pub fn new(walls: Vec<[Point; 2]>) -> Self {
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in walls.iter().flatten() {
            for axis in 0..2 {
                min[axis] = min[axis].min(point[axis]);
                max[axis] = max[axis].max(point[axis]);
            }
        }
        let bucket = (max[0] - min[0]).max(max[1] - min[1]) / BUCKETS;
        let size = [0, 1].map(|axis| ((max[axis] - min[axis]) / bucket) as usize + 1);
        let mut made =
            Self { walls, min, bucket, size, buckets: vec![Vec::new(); size[0] * size[1]] };
        for index in 0..made.walls.len() {
            let [a, b] = made.walls[index];
            let low = [a[0].min(b[0]), a[1].min(b[1])];
            let high = [a[0].max(b[0]), a[1].max(b[1])];
            for bucket in made.buckets_of(low, high) {
                made.buckets[bucket].push(index);
            }
        }
        made
    }

    fn buckets_of(&self, low: Point, high: Point) -> impl Iterator<Item = usize> + use<> {
        let index = |value: f64, axis: usize| {
            let bucket = ((value - self.min[axis]) / self.bucket).max(0.0) as usize;
            bucket.min(self.size[axis] - 1)
        };
        let (x, y) = (index(low[0], 0)..=index(high[0], 0), index(low[1], 1)..=index(high[1], 1));
        let width = self.size[0];
        y.flat_map(move |y| x.clone().map(move |x| y * width + x))
    }

    /// The walls that come near a box.
    fn near(&self, low: Point, high: Point) -> impl Iterator<Item = [Point; 2]> + '_ {
        let buckets = self.buckets_of(low, high);
        buckets.flat_map(|bucket| self.buckets[bucket].iter().map(|index| self.walls[*index]))
    }

    /// Whether a rectangle keeps away from all walls.
    #[must_use]
    pub fn is_clear(&self, rectangle: &Rectangle) -> bool {
        let [low, high] = rectangle.bounds();
        self.near(low, high).all(|wall| !rectangle.meets(wall))
    }

    /// The rectangle's distance from the walls, no more than `most`.
    #[must_use]
    pub fn distance(&self, rectangle: &Rectangle, most: f64) -> f64 {
        let [low, high] = rectangle.bounds();
        self.near(low.map(|value| value - most), high.map(|value| value + most))
            .map(|wall| rectangle.distance(wall))
            .fold(most, f64::min)
    }
}

/// A rectangle at a pose.
#[derive(Debug, Clone, Copy)]
pub struct Rectangle {
    center: Point,
    /// Its directions forwards and to the left.
    axes: [Point; 2],
    /// Half of its extent along each.
    half: [f64; 2],
}

impl Rectangle {
    /// A robot of this width and length, grown by `margin` on all sides.
    #[must_use]
    pub fn new(pose: Pose, [width, length]: [f64; 2], margin: f64) -> Self {
        let ahead = direction(pose.heading);
        let half = [length / 2.0 + margin, width / 2.0 + margin];
        Self { center: pose.position, axes: [ahead, [-ahead[1], ahead[0]]], half }
    }

    /// What it covers while it drives straight for `length`, which may be negative.
    #[must_use]
    pub fn swept(self, length: f64) -> Self {
        let center = along(self.center, self.axes[0], length / 2.0);
        Self { center, half: [self.half[0] + length.abs() / 2.0, self.half[1]], ..self }
    }

    /// The box around it.
    fn bounds(&self) -> [Point; 2] {
        let reach = [0, 1].map(|axis| {
            self.half[0] * self.axes[0][axis].abs() + self.half[1] * self.axes[1][axis].abs()
        });
        [along(self.center, reach, -1.0), along(self.center, reach, 1.0)]
    }

    fn local(&self, point: Point) -> Point {
        let from = between(self.center, point);
        self.axes.map(|axis| from[0] * axis[0] + from[1] * axis[1])
    }

    /// Whether it meets a wall, by separating axes.
    fn meets(&self, wall: [Point; 2]) -> bool {
        let [a, b] = wall.map(|point| self.local(point));
        let apart = (0..2).any(|axis| {
            a[axis].min(b[axis]) > self.half[axis] || a[axis].max(b[axis]) < -self.half[axis]
        });
        let normal = [a[1] - b[1], b[0] - a[0]];
        let offset = normal[0] * a[0] + normal[1] * a[1];
        let reach = normal[0].abs() * self.half[0] + normal[1].abs() * self.half[1];
        !apart && offset.abs() <= reach
    }

    /// Its distance from a wall; 0 if they meet.
    fn distance(&self, wall: [Point; 2]) -> f64 {
        if self.meets(wall) {
            return 0.0;
        }
        let [a, b] = wall.map(|point| self.local(point));
        let outside =
            |point: Point| norm([0, 1].map(|axis| (point[axis].abs() - self.half[axis]).max(0.0)));
        let corners = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]]
            .map(|sign| [sign[0] * self.half[0], sign[1] * self.half[1]]);
        let from_corners = corners.map(|corner| point_to_segment(corner, [a, b]));
        from_corners.into_iter().fold(outside(a).min(outside(b)), f64::min)
    }
}

/// Distance of a point from a segment.
fn point_to_segment(point: Point, [a, b]: [Point; 2]) -> f64 {
    let (way, from) = (between(a, b), between(a, point));
    let square = way[0] * way[0] + way[1] * way[1];
    let part = if square == 0.0 { 0.0 } else { (way[0] * from[0] + way[1] * from[1]) / square };
    norm(between(along(a, way, part.clamp(0.0, 1.0)), point))
}
