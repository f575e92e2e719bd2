//! A route between pillars: the faces of the floor, and the corners that the taut path turns about.

use planning::budget::Budget;
use planning::free_space::floor::Floor;
use planning::free_space::walls::Walls;
use planning::geometry::{AxisBox, Vector};
use schemas::message::Curve;

use super::drawing::{Anchor, Drawing, Point, View};
use super::motion::{answer, boxes, path};

const START: Point = [1.0, 1.0];
const GOAL: Point = [15.0, 8.8];
const SIDE: Point = [16.0, 9.8];
const RADIUS: f64 = 0.3 + 0.25;

pub(crate) fn figure() -> String {
    let mut drawing = Drawing::new(
        [792.0, 516.0],
        "A robot's route in the open",
        "A robot's path between nine pillars, drawn taut over the triangles of the floor. It turns \
         about some corners on their guiding circles and passes all others in straight lines.",
    );
    let pillars: Vec<[Point; 2]> = (0..9)
        .map(|index| {
            let (column, row) = (index % 3, index / 3);
            let x = 2.6 + 4.3 * f64::from(column) + 0.7 * f64::from((row * 2 + column) % 3);
            let y = 1.5 + 2.8 * f64::from(row) - 0.5 * f64::from((column * 2 + row) % 3);
            [[x, y], [x + 1.3, y + 1.2]]
        })
        .collect();
    let solids = pillars.iter().map(|pillar| {
        let list = boxes(&[*pillar]);
        format!(r#"{{"box": {}}}"#, &list[1..list.len() - 1])
    });
    let answer = answer(&format!(
        r#"{{"task": "drive",
            "free_space": {{"solids": [{}], "bounds": {{"min": [0, 0], "max": {SIDE:?}}}}},
            "body": {{"footprint": {{"width": 0.6, "length": 0.6}}}},
            "start": {{"position": {START:?}, "heading": 0}},
            "goal": {{"position": {GOAL:?}}},
            "clearance": {{"gap": 0.25}}, "sampling": {{"count": 2}}}}"#,
        solids.collect::<Vec<_>>().join(", "),
    ));

    let view = View { corner: [28.0, 472.0], min: [0.0, 0.0], scale: 46.0 };
    let frame = [[-0.15, -0.15], [SIDE[0] + 0.15, SIDE[1] + 0.15]];
    drawing.shape("wall", &view.rectangle(frame));
    drawing.shape("free", &view.rectangle([[0.0, 0.0], SIDE]));
    for pillar in &pillars {
        drawing.shape("wall", &view.rectangle(*pillar));
    }
    for triangle in triangles(&pillars) {
        let [a, b, c] = triangle.map(|corner| view.at(corner));
        let outline = format!("M{} {}L{} {}L{} {}Z", a[0], a[1], b[0], b[1], c[0], c[1]);
        drawing.shape("junction", &outline);
    }
    drawing.shape("path", &path(&view, &answer.legs));
    for leg in &answer.legs {
        if let Curve::Arc { center, .. } = &leg.curve {
            let corner = [center.padded()[0], center.padded()[1]];
            drawing.circle("guide", view.at(corner), RADIUS * view.scale);
            drawing.circle("dot", view.at(corner), 4.5);
        }
    }
    for (at, name, aside) in [(START, "start", 20.0), (GOAL, "goal", -12.0)] {
        let [x, y] = view.at(at);
        drawing.circle("dot", [x, y], 3.5);
        drawing.label("over", Anchor::Middle, [x, y + aside], name);
    }
    let y = 500.0;
    drawing.circle("dot", [34.0, y - 4.0], 4.5);
    drawing.label("note", Anchor::Start, [46.0, y], "corner turned about, on its guiding circle");
    drawing.shape("junction", "M348 490h16v12h-16Z");
    drawing.label("note", Anchor::Start, [372.0, y], "faces of the floor; the edges are junctions");
    drawing.finish()
}

/// The free faces of the floor between the pillars.
fn triangles(pillars: &[[Point; 2]]) -> Vec<[Point; 3]> {
    let mut walls = Walls::default();
    let sides = |[min, max]: [Point; 2]| AxisBox::new(min.into(), max.into()).expect("a box");
    walls.push_inside(&sides([[0.0, 0.0], SIDE]));
    pillars.iter().for_each(|pillar| walls.push_box(&sides(*pillar)));
    let floor = Floor::new(&walls, &Budget::default()).expect("a floor");
    let is_free = |triangle: &[Point; 3]| {
        let middle =
            [0, 1].map(|axis| triangle.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
        !pillars.iter().any(|[min, max]| {
            (0..2).all(|axis| min[axis] < middle[axis] && middle[axis] < max[axis])
        })
    };
    let points = |triangle: [Vector<2>; 3]| triangle.map(|corner| [corner.x, corner.y]);
    floor.triangles().map(points).filter(is_free).collect()
}
