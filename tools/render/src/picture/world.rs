//! The contents of a scene in metres, safe to draw.

use schemas::message::{AxisBox, Body, Direction, SceneRequest, Solid, Task, Trajectory, Vector};

/// A point, metres; unused coordinates are 0.
pub(super) type Point = [f64; 3];

/// Something with an outline.
pub(super) enum Shape {
    /// Least and greatest corner.
    Box([Point; 2]),
    /// In the first two coordinates.
    Polygon(Vec<Point>),
}

/// What moves.
pub(super) enum Mover {
    /// Translates; what it is made of, in the assembled state.
    Part(Vec<Shape>),
    /// Drives and turns about its reference point.
    Robot(Robot),
}

/// A rectangle about a reference point, metres.
#[derive(Clone, Copy)]
pub(super) struct Robot {
    /// Across the heading.
    pub(super) width: f64,
    /// From the reference point to the front end.
    pub(super) front: f64,
    /// From the reference point to the rear end.
    pub(super) rear: f64,
}

impl Robot {
    /// Along the heading.
    pub(super) fn length(&self) -> f64 {
        self.front + self.rear
    }
}

/// A scene.
pub(super) struct World {
    /// 2 or 3.
    pub(super) dimension: usize,
    pub(super) channels: Vec<[Point; 2]>,
    pub(super) solids: Vec<Shape>,
    pub(super) bounds: Option<[Point; 2]>,
    pub(super) mover: Mover,
    /// Whether it is a floor plan: walls that a robot drives among, without given channels.
    pub(super) is_floor_plan: bool,
}

/// Coordinates that can be subtracted and scaled without overflow.
pub(super) fn tame(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value.clamp(-1e100, 1e100) }
}

pub(super) fn point(vector: &Vector) -> Point {
    vector.padded().map(tame)
}

fn corners(sides: &AxisBox) -> [Point; 2] {
    let (a, b) = (point(&sides.min), point(&sides.max));
    [std::array::from_fn(|i| a[i].min(b[i])), std::array::from_fn(|i| a[i].max(b[i]))]
}

impl Shape {
    /// The outline seen along the axis that is not among `axes`.
    pub(super) fn outline(&self, axes: [usize; 2]) -> Vec<[f64; 2]> {
        let [i, j] = axes;
        match self {
            Self::Box([min, max]) => {
                vec![[min[i], min[j]], [max[i], min[j]], [max[i], max[j]], [min[i], max[j]]]
            }
            Self::Polygon(vertices) => vertices.iter().map(|v| [v[i], v[j]]).collect(),
        }
    }

    /// Where the first vertex is.
    fn first(&self) -> Point {
        match self {
            Self::Box([min, _]) => *min,
            Self::Polygon(vertices) => vertices.first().copied().unwrap_or_default(),
        }
    }

    pub(super) fn grow(&self, extent: &mut Extent, by: Point) {
        let mut add = |p: &Point| extent.add(std::array::from_fn(|i| p[i] + by[i]));
        match self {
            Self::Box(corners) => corners.iter().for_each(&mut add),
            Self::Polygon(vertices) => vertices.iter().for_each(&mut add),
        }
    }

    /// Its point closest to `target`: on the boundary, if that is outside.
    pub(super) fn nearest(&self, target: Point) -> Point {
        match self {
            Self::Box([min, max]) => std::array::from_fn(|i| target[i].max(min[i]).min(max[i])),
            Self::Polygon(vertices) => {
                let next = vertices.iter().cycle().skip(1);
                let on_edges = vertices.iter().zip(next).map(|(a, b)| on_segment(*a, *b, target));
                let squared = |p: &Point| {
                    let (x, y) = (p[0] - target[0], p[1] - target[1]);
                    x * x + y * y
                };
                on_edges.min_by(|a, b| squared(a).total_cmp(&squared(b))).unwrap_or(target)
            }
        }
    }
}

fn on_segment(a: Point, b: Point, target: Point) -> Point {
    let along = [b[0] - a[0], b[1] - a[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let t = (target[0] - a[0]) * along[0] + (target[1] - a[1]) * along[1];
    let t = if squared > 0.0 { (t / squared).clamp(0.0, 1.0) } else { 0.0 };
    [a[0] + t * along[0], a[1] + t * along[1], 0.0]
}

impl World {
    pub(super) fn of(scene: &SceneRequest) -> Self {
        let space = &scene.free_space;
        let solids: Vec<Shape> = space.solids.iter().flatten().flat_map(solid).collect();
        let body = answer::body_in_fixed_frame(scene);
        let mover = match body.as_ref().unwrap_or(&scene.body) {
            Body::Polygon(vertices) => {
                Mover::Part(vec![Shape::Polygon(vertices.iter().map(point).collect())])
            }
            Body::Box(sides) => Mover::Part(vec![Shape::Box(corners(sides))]),
            Body::Boxes(boxes) => {
                Mover::Part(boxes.iter().map(|sides| Shape::Box(corners(sides))).collect())
            }
            Body::Footprint(footprint) => Mover::Robot(Robot {
                width: tame(footprint.width()).abs(),
                front: tame(footprint.front()).abs(),
                rear: tame(footprint.rear()).abs(),
            }),
        };
        let boxes = space.channels.iter().flatten();
        let three = boxes.chain(&space.bounds).any(|sides| sides.min.dimension() == 3)
            || match &scene.body {
                Body::Box(sides) => sides.min.dimension() == 3,
                Body::Boxes(boxes) => boxes.iter().any(|sides| sides.min.dimension() == 3),
                Body::Polygon(_) | Body::Footprint(_) => false,
            };
        Self {
            dimension: if three && scene.task != Task::Drive { 3 } else { 2 },
            channels: space.channels.iter().flatten().map(corners).collect(),
            bounds: space.bounds.as_ref().map(corners),
            is_floor_plan: scene.task == Task::Drive
                && space.channels.is_none()
                && !solids.is_empty(),
            solids,
            mover,
        }
    }

    /// The channels that an answer chose from: the planner's own, or the request's.
    pub(super) fn channels_of(&self, answer: Option<&Trajectory>) -> Vec<[Point; 2]> {
        match answer {
            Some(answer) if !answer.channels.is_empty() => {
                answer.channels.iter().map(corners).collect()
            }
            _ => self.channels.clone(),
        }
    }

    /// Everything at rest.
    pub(super) fn extent(&self) -> Extent {
        let mut extent = Extent::default();
        let still = [0.0; 3];
        self.channels.iter().chain(&self.bounds).flatten().for_each(|p| extent.add(*p));
        self.solids.iter().for_each(|solid| solid.grow(&mut extent, still));
        if let Mover::Part(shapes) = &self.mover {
            shapes.iter().for_each(|shape| shape.grow(&mut extent, still));
        }
        extent
    }
}

/// Where the first vertex is of what a part is made of.
pub(super) fn first(shapes: &[Shape]) -> Point {
    shapes.first().map_or([0.0; 3], Shape::first)
}

/// What a solid is made of.
pub(super) fn solid(solid: &Solid) -> Vec<Shape> {
    match solid {
        Solid::Polygon(vertices) => vec![Shape::Polygon(vertices.iter().map(point).collect())],
        Solid::Box(sides) => vec![Shape::Box(corners(sides))],
        Solid::Boxes(boxes) => boxes.iter().map(|sides| Shape::Box(corners(sides))).collect(),
    }
}

/// The junctions between channels that follow each other on a route, in travel order.
pub(super) fn junctions(
    channels: &[[Point; 2]],
    route: impl Iterator<Item = usize>,
    dimension: usize,
) -> Vec<[Point; 2]> {
    let travelled: Vec<&[Point; 2]> = route.filter_map(|index| channels.get(index)).collect();
    let common = |pair: &[&[Point; 2]]| {
        let min = std::array::from_fn(|i| pair[0][0][i].max(pair[1][0][i]));
        let max: Point = std::array::from_fn(|i| pair[0][1][i].min(pair[1][1][i]));
        [min, max]
    };
    let mut junctions: Vec<[Point; 2]> = travelled.windows(2).map(common).collect();
    // Channels that don't overlap still count, so that junctions keep their numbers.
    for [min, max] in &mut junctions {
        if (0..dimension).any(|i| min[i] > max[i]) {
            *max = *min;
        }
    }
    junctions
}

/// The coordinate a direction runs along, and whether it increases.
pub(super) fn axis(direction: Direction, dimension: usize) -> Option<(usize, bool)> {
    let flat = dimension == 2;
    match direction {
        Direction::PlusX => Some((0, true)),
        Direction::MinusX => Some((0, false)),
        Direction::PlusY => (!flat).then_some((1, true)),
        Direction::MinusY => (!flat).then_some((1, false)),
        Direction::PlusZ => Some((if flat { 1 } else { 2 }, true)),
        Direction::MinusZ => Some((if flat { 1 } else { 2 }, false)),
    }
}

/// The smallest box around points.
#[derive(Clone, Copy, Default)]
pub(super) struct Extent(Option<[Point; 2]>);

impl Extent {
    pub(super) fn add(&mut self, p: Point) {
        let [min, max] = self.0.get_or_insert([p, p]);
        for i in 0..3 {
            (min[i], max[i]) = (min[i].min(p[i]), max[i].max(p[i]));
        }
    }

    /// All corners, least and greatest.
    pub(super) fn corners(&self) -> impl IntoIterator<Item = Point> + use<> {
        self.0.into_iter().flatten()
    }

    /// Widened by a margin on all sides, and so that no side has length 0.
    pub(super) fn padded(&self, part: f64, dimension: usize) -> [Point; 2] {
        let [mut min, mut max] = self.0.unwrap_or([[0.0; 3], [1.0; 3]]);
        let sides = || (0..dimension).map(|i| max[i] - min[i]);
        let farthest = min.iter().chain(&max).fold(0.0, |most: f64, c| most.max(c.abs()));
        let longest = sides().fold(0.0, f64::max).max(farthest * 1e-12).max(1e-100);
        for i in 0..dimension {
            // Slivers get a little room.
            let margin = (longest * part).max((longest * 0.25 - (max[i] - min[i])) / 2.0);
            (min[i], max[i]) = (min[i] - margin, max[i] + margin);
        }
        [min, max]
    }
}
