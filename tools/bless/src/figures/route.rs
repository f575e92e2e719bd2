//! A route between pillars: corners that the taut path turns about, and corners that it passes.

use planning::budget::Budget;
use planning::driving;
use planning::free_space::{Chain, End};
use planning::geometry::{AxisBox, Vector};

use super::drawing::{Anchor, Drawing, Point, View};
use super::motion::{answer, boxes, common, corners, path};
use super::tangents::turned_about;

const START: Point = [1.0, 1.0];
const GOAL: Point = [15.0, 8.8];
const SIDE: Point = [16.0, 9.8];
const RADIUS: f64 = 0.3 + 0.25;

pub(crate) fn figure() -> String {
    let mut drawing = Drawing::new(
        [792.0, 516.0],
        "A robot's route in the open",
        "A robot's path between nine pillars, drawn taut. It turns about some corners on their \
         guiding circles and passes the other corners of its junctions in straight lines.",
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
    let along: Vec<[Point; 2]> =
        answer.route.iter().map(|index| corners(&answer.channels[*index as usize])).collect();
    for pair in along.windows(2) {
        drawing.shape("junction", &view.rectangle(common(pair[0], pair[1])));
    }
    drawing.shape("path", &path(&view, &answer.legs));
    let turned = turned_about(&answer);
    for (index, corner) in corners_along(&along).into_iter().enumerate() {
        let touched = turned.contains(&index);
        if touched {
            drawing.circle("guide", view.at(corner), RADIUS * view.scale);
        }
        drawing.circle(if touched { "dot" } else { "passed" }, view.at(corner), 4.5);
    }
    for (at, name, aside) in [(START, "start", 20.0), (GOAL, "goal", -12.0)] {
        let [x, y] = view.at(at);
        drawing.circle("dot", [x, y], 3.5);
        drawing.label("over", Anchor::Middle, [x, y + aside], name);
    }
    let y = 500.0;
    drawing.circle("dot", [34.0, y - 4.0], 4.5);
    drawing.label("note", Anchor::Start, [46.0, y], "corner turned about, on its guiding circle");
    drawing.circle("passed", [334.0, y - 4.0], 4.5);
    drawing.label("note", Anchor::Start, [346.0, y], "corner passed at a distance");
    drawing.shape("junction", "M548 490h16v12h-16Z");
    drawing.label("note", Anchor::Start, [572.0, y], "junctions of the route");
    drawing.finish()
}

/// The corners of the junctions along a route.
fn corners_along(channels: &[[Point; 2]]) -> Vec<Point> {
    let channels: Vec<_> = channels
        .iter()
        .map(|[min, max]| AxisBox::new((*min).into(), (*max).into()).expect("a channel"))
        .collect();
    let (mut chain, mut corners) = (Chain::default(), Vec::new());
    let (start, goal) = (Vector::from(START), Vector::from(GOAL));
    chain.build(&channels, &start, End::Goal(goal), &Budget::default()).expect("a chain");
    driving::corners_of(&chain, &mut corners);
    corners.iter().map(|corner| [corner.point.x, corner.point.y]).collect()
}
