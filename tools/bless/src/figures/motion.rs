//! Scenes planned for a figure, and their geometry in the plane.

use std::f64::consts::FRAC_PI_2;

use planning::geometry::clothoid::Clothoid;
use schemas::json;
use schemas::message::{
    AxisBox, Curve, Leg, Request, RequestContent, RequestKey, SceneRequest, Trajectory, Vector,
};

use super::drawing::{Point, View, polar};

/// The answers to a scene, all of which must be trajectories.
pub(super) fn answers(scene: &str) -> Vec<Trajectory> {
    let content = RequestContent::Scene(read(scene));
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    let reply = answer::reply_to(&request, &answer::Caps::default());
    let answers = reply.answers.expect("the figures' scenes can be planned");
    answers.into_iter().map(|answer| answer.expect("the figures' gaps are possible")).collect()
}

/// The only answer to a scene.
pub(super) fn answer(scene: &str) -> Trajectory {
    let mut answers = answers(scene);
    assert_eq!(answers.len(), 1, "{scene} asks for one answer");
    answers.remove(0)
}

/// A scene from its JSON.
pub(super) fn read(scene: &str) -> SceneRequest {
    json::read_scene(scene).expect("the figures' scenes can be read")
}

/// A vector in the plane.
pub(super) fn flat(vector: &Vector) -> Point {
    let [x, y, _] = vector.padded();
    [x, y]
}

/// A box in the plane.
pub(super) fn corners(space: &AxisBox) -> [Point; 2] {
    [flat(&space.min), flat(&space.max)]
}

/// A box moved.
pub(super) fn moved(space: [Point; 2], by: Point) -> [Point; 2] {
    space.map(|point| [point[0] + by[0], point[1] + by[1]])
}

/// The common part of two boxes.
pub(super) fn common(one: [Point; 2], other: [Point; 2]) -> [Point; 2] {
    let pick = |choose: fn(f64, f64) -> f64, end: usize| {
        [choose(one[end][0], other[end][0]), choose(one[end][1], other[end][1])]
    };
    [pick(f64::max, 0), pick(f64::min, 1)]
}

/// A JSON list of boxes.
pub(super) fn boxes(spaces: &[[Point; 2]]) -> String {
    let one = |[min, max]: &[Point; 2]| format!(r#"{{"min": {min:?}, "max": {max:?}}}"#);
    format!("[{}]", spaces.iter().map(one).collect::<Vec<_>>().join(", "))
}

/// A robot's centre and heading.
pub(super) type Pose = (Point, f64);

/// The poses in which a leg begins and ends.
pub(super) fn ends(leg: &Leg) -> [Pose; 2] {
    match leg.curve {
        Curve::Line { from, to, heading, turned } => {
            [(flat(&from), heading - turned), (flat(&to), heading)]
        }
        Curve::Arc { center, radius, start_angle, sweep } => [start_angle, start_angle + sweep]
            .map(|angle| {
                let heading = angle + FRAC_PI_2.copysign(sweep);
                (polar(flat(&center), radius, angle), heading)
            }),
        Curve::Clothoid { from, to, from_heading, to_heading, .. } => {
            [(flat(&from), from_heading), (flat(&to), to_heading)]
        }
        Curve::Turn { position, from_heading, to_heading, .. } => {
            [(flat(&position), from_heading), (flat(&position), to_heading)]
        }
    }
}

/// The centre's path along the legs.
pub(super) fn path(view: &View, legs: &[Leg]) -> String {
    let begin = legs.first().map_or([0.0; 2], |leg| ends(leg)[0].0);
    let mut data = view.polyline(&[begin]);
    for leg in legs {
        let to = ends(leg)[1].0;
        match leg.curve {
            Curve::Arc { radius, sweep, .. } => data += &view.arc_to(radius, sweep, to),
            Curve::Line { .. } => data += &view.polyline(&[to]).replace('M', "L"),
            Curve::Clothoid { from, from_heading, curvatures, length, .. } => {
                let places = clothoid((flat(&from), from_heading), curvatures, length);
                data += &view.polyline(&places).replace('M', "L");
            }
            Curve::Turn { .. } => {}
        }
    }
    data
}

/// Places on a clothoid driven forwards, its end among them.
fn clothoid((from, heading): Pose, curvatures: [f64; 2], length: f64) -> Vec<Point> {
    let [curvature, end] = curvatures;
    let curve = Clothoid { curvature, sharpness: (end - curvature) / length };
    let (sin, cos) = libm::sincos(heading);
    let places = (1..=24).map(|step| curve.place(length * f64::from(step) / 24.0));
    places
        .map(|at| [from[0] + cos * at.x - sin * at.y, from[1] + sin * at.x + cos * at.y])
        .collect()
}

/// The corners of a robot: rear left, front left, front right, rear right.
pub(super) fn outline((center, heading): Pose, [width, length]: [f64; 2]) -> [Point; 4] {
    let (sin, cos) = libm::sincos(heading);
    let corner = |ahead: f64, left: f64| {
        [center[0] + ahead * cos - left * sin, center[1] + ahead * sin + left * cos]
    };
    let (a, b) = (length / 2.0, width / 2.0);
    [corner(-a, b), corner(a, b), corner(a, -b), corner(-a, -b)]
}
