//! The three kinds of neighbours: opposite turns, equal turns, a corner that is not touched.

use std::f64::consts::{FRAC_PI_2, PI};

use planning::budget::Budget;
use planning::driving::{self, Corner};
use planning::free_space::{Chain, End};
use planning::geometry::{AxisBox, Sign, Vector};
use schemas::message::{Curve, Trajectory};

use super::drawing::{Anchor, Drawing, Point, View, polar};
use super::motion::{answer, boxes, path};

struct Panel {
    channels: &'static [[Point; 2]],
    start: Point,
    goal: Point,
    gap: f64,
    captions: [&'static str; 2],
}

const PANELS: [Panel; 3] = [
    Panel {
        channels: &[[[0.2, 0.2], [3.2, 7.0]], [[0.2, 4.0], [8.6, 7.0]], [[5.6, 4.0], [8.6, 10.0]]],
        start: [1.3, 1.4],
        goal: [7.4, 8.9],
        gap: 0.5,
        captions: ["Opposite turns (S):", "inner tangent, needs l ≥ ρ + ρ′"],
    },
    Panel {
        channels: &[[[0.2, 0.2], [3.2, 8.6]], [[0.2, 5.6], [8.6, 8.6]], [[5.6, 0.2], [8.6, 8.6]]],
        start: [1.3, 1.4],
        goal: [7.6, 1.4],
        gap: 0.7,
        captions: ["Equal turns (U):", "outer tangent, needs l ≥ |ρ − ρ′|"],
    },
    Panel {
        channels: &[[[0.6, 0.2], [5.0, 5.4]], [[0.6, 3.6], [7.6, 5.4]], [[2.6, 3.6], [7.6, 10.0]]],
        start: [4.0, 1.4],
        goal: [4.8, 8.9],
        gap: 0.4,
        captions: ["A corner not touched:", "the sweep would be negative, skipped"],
    },
];

pub(crate) fn figure() -> String {
    let mut drawing = Drawing::new(
        [792.0, 366.0],
        "Tangents between guiding circles",
        "Three corridors. In the first the robot turns right, then left: the straight line \
         between the two guiding circles crosses between their centres. In the second it turns \
         right twice: the line runs along one side of both circles. In the third the straight \
         line passes a corner without touching its circle, which is left out.",
    );
    for (index, panel) in PANELS.iter().enumerate() {
        let view =
            View { corner: [20.0 + 258.0 * index as f64, 304.0], min: [0.0, 0.0], scale: 27.0 };
        draw(&mut drawing, &view, panel);
    }
    drawing.finish()
}

fn draw(drawing: &mut Drawing, view: &View, panel: &Panel) {
    let answer = answer(&format!(
        r#"{{"task": "drive",
            "free_space": {{"channels": {}, "in_order": true}},
            "body": {{"footprint": {{"width": 1.0, "length": 1.5}}}},
            "start": {{"position": {:?}, "heading": 1.5707963267948966}},
            "goal": {{"position": {:?}}},
            "clearance": {{"gap": {}}}, "sampling": {{"count": 2}}}}"#,
        boxes(panel.channels),
        panel.start,
        panel.goal,
        panel.gap,
    ));
    drawing.shape("wall", &view.rectangle([[0.0, 0.0], [8.8, 10.2]]));
    for channel in panel.channels {
        drawing.shape("free", &view.rectangle(*channel));
    }
    let turned = turned_about(&answer);
    let radius = 0.5 + panel.gap;
    for (index, corner) in corners(panel).iter().enumerate() {
        let center = [corner.point.x, corner.point.y];
        let whole = |angle: f64| view.arc(center, radius, angle, PI);
        drawing.shape("guide", &(whole(0.0) + &whole(PI)));
        let touched = turned.contains(&index);
        drawing.circle(if touched { "dot" } else { "passed" }, view.at(center), 4.0);
        let right = corner.rule.turn == Sign::Negative;
        sense(drawing, view, (center, radius), right);
        let [x, y] = view.at(center);
        let name = if right { "q &lt; 0" } else { "q > 0" };
        drawing.label("math note over", Anchor::Middle, [x, y + 18.0], name);
    }
    drawing.shape("path", &path(view, &answer.legs));
    for end in [panel.start, panel.goal] {
        drawing.circle("dot", view.at(end), 3.5);
    }
    for (line, text) in panel.captions.iter().enumerate() {
        let [x, y] = view.at([4.4, 0.0]);
        let class = if line == 0 { "head" } else { "note" };
        drawing.label(class, Anchor::Middle, [x, y + 22.0 + 18.0 * line as f64], text);
    }
}

/// A tip on the circle, opposite to where the path runs.
fn sense(drawing: &mut Drawing, view: &View, (center, radius): (Point, f64), right: bool) {
    let at = if right { -PI / 4.0 } else { 3.0 * PI / 4.0 };
    let step = if right { 0.3 } else { -0.3 };
    let from = polar(center, radius, at + step);
    let to = polar(center, radius, at - step / 2.0);
    let forward = polar(to, 0.01, at - FRAC_PI_2.copysign(step));
    let (from, to) = (view.at(from), view.at(forward));
    drawing.arrow("light", [(from[0] + to[0]) / 2.0, (from[1] + to[1]) / 2.0], to);
}

/// The corners of a panel's junctions.
fn corners(panel: &Panel) -> Vec<Corner> {
    let channels: Vec<_> = panel
        .channels
        .iter()
        .map(|[min, max]| AxisBox::new((*min).into(), (*max).into()).expect("a channel"))
        .collect();
    let (mut chain, mut corners) = (Chain::default(), Vec::new());
    let (start, goal) = (Vector::from(panel.start), Vector::from(panel.goal));
    chain.build(&channels, &start, End::Goal(goal), &Budget::default()).expect("a chain");
    driving::corners_of(&chain, &mut corners);
    corners
}

/// The junctions in which the path turns.
pub(super) fn turned_about(answer: &Trajectory) -> Vec<usize> {
    let arcs = answer.legs.iter().filter(|leg| matches!(leg.curve, Curve::Arc { .. }));
    arcs.filter_map(|leg| leg.junction).map(|junction| junction as usize).collect()
}
