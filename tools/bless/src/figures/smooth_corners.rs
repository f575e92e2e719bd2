//! The corners of a robot's and a part's path: sharp, as arcs, and smooth, with their curvature.

use schemas::message::{Curve, Leg};

use super::drawing::{Anchor, Drawing, Point, View, number};
use super::motion::{answer, boxes, flat, path};

const WIDTH: f64 = 336.0;
/// Where the scenes end below, pixels from the top.
const BOTTOM: f64 = 304.0;
/// Where a curvature of 0 is in the graphs, and the pixels for the greatest.
const ZERO: f64 = 486.0;
const MOST: f64 = 84.0;

/// One of the two panels.
struct Panel {
    left: f64,
    channels: Vec<[Point; 2]>,
    view: View,
    title: &'static str,
}

pub(crate) fn figure() -> String {
    let mut drawing = Drawing::new(
        [792.0, 560.0],
        "Smooth corners",
        "Left, a robot's corner: the corner itself, the arc that the robot drives about it, and the \
         smooth turn, which begins before the arc and ends behind it. Below, the curvature over the \
         length: that of the arc is a step, that of the smooth turn rises along a clothoid, stays, and \
         falls along another. Right, the same for a way-point of a part, which is passed along a \
         pair of clothoids, on which the curvature rises and falls.",
    );
    draw_robot(&mut drawing);
    draw_part(&mut drawing);
    let y = 540.0;
    for (left, class, name) in
        [(40.0, "guide", "sharp"), (134.0, "gap", "arc"), (212.0, "curve", "smooth")]
    {
        drawing.line(class, [left, y - 4.0], [left + 30.0, y - 4.0]);
        drawing.label("note", Anchor::Start, [left + 38.0, y], name);
    }
    drawing.finish()
}

fn draw_robot(drawing: &mut Drawing) {
    let left = 24.0;
    let panel = Panel {
        left,
        channels: vec![[[4.6, 0.0], [7.6, 5.2]], [[0.2, 2.2], [7.6, 5.2]]],
        view: View { corner: [left, BOTTOM], min: [0.0, 0.0], scale: 45.0 },
        title: "A robot about a corner",
    };
    let [arc, smooth] = ["arc", "smooth"].map(|corners| {
        let motion = answer(&format!(
            r#"{{"task": "drive",
                "free_space": {{"channels": {}, "in_order": true}},
                "body": {{"footprint": {{"width": 1.0, "length": 1.5}}}},
                "start": {{"position": [5.8, 0.9], "heading": 1.5707963267948966}},
                "goal": {{"position": [1.1, 3.4]}}, "corners": "{corners}",
                "clearance": {{"gap": 0.7}}, "sampling": {{"count": 2}}}}"#,
            boxes(&panel.channels),
        ));
        motion.legs
    });
    // Where the lines before and behind the arc meet.
    let lines: Vec<[Point; 2]> = arc.iter().filter_map(line).collect();
    let corner = meeting(lines[0], lines[lines.len() - 1]);
    let sharp = panel.view.polyline(&[lines[0][0], corner, lines[lines.len() - 1][1]]);
    panel.draw(drawing, [&sharp, &path(&panel.view, &arc), &path(&panel.view, &smooth)]);
    panel.draw_curvature(drawing, [&arc, &smooth]);
}

fn draw_part(drawing: &mut Drawing) {
    let left = 436.0;
    let body = [[4.0, 0.1], [4.8, 0.7]];
    // The body's centre stands for it.
    let center = [4.4, 0.4];
    let panel = Panel {
        left,
        channels: vec![[[3.0, 0.0], [5.0, 3.4]], [[1.0, 1.0], [5.0, 3.4]]],
        view: View { corner: [left, BOTTOM], min: [-center[0], -center[1]], scale: 62.0 },
        title: "The centre of a part at a way-point",
    };
    let [sharp, arc, smooth] = ["sharp", "arc", "smooth"].map(|corners| {
        let motion = answer(&format!(
            r#"{{"task": "disassemble",
                "free_space": {{"channels": {}, "in_order": true}},
                "body": {{"box": {}}}, "exit": "-x", "corners": "{corners}",
                "clearance": {{"gap": 0.55}}, "sampling": {{"count": 2}}}}"#,
            boxes(&panel.channels),
            boxes(&[body]).trim_matches(['[', ']']),
        ));
        motion.legs
    });
    panel.draw(
        drawing,
        [&sharp, &arc, &smooth].map(|legs| path(&panel.view, legs)).each_ref().map(|data| &**data),
    );
    panel.draw_curvature(drawing, [&arc, &smooth]);
}

/// The ends of a line.
fn line(leg: &Leg) -> Option<[Point; 2]> {
    match leg.curve {
        Curve::Line { from, to, .. } => Some([flat(&from), flat(&to)]),
        _ => None,
    }
}

/// Where two lines meet that are not parallel.
fn meeting([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Point {
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [d[0] - c[0], d[1] - c[1]]);
    let part = ((c[0] - a[0]) * v[1] - (c[1] - a[1]) * v[0]) / (u[0] * v[1] - u[1] * v[0]);
    [a[0] + part * u[0], a[1] + part * u[1]]
}

impl Panel {
    /// The scene with its three paths: sharp, arcs, smooth.
    fn draw(&self, drawing: &mut Drawing, paths: [&str; 3]) {
        // What is shown counts from the view's least point.
        let here = |[x, y]: Point| [x + self.view.min[0], y + self.view.min[1]];
        let [min, max] = self.channels.iter().fold(
            [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]],
            |[min, max], [least, most]| {
                [
                    [min[0].min(least[0]), min[1].min(least[1])],
                    [max[0].max(most[0]), max[1].max(most[1])],
                ]
            },
        );
        let wall = [[min[0] - 0.2, min[1] - 0.2], [max[0] + 0.2, max[1] + 0.2]].map(here);
        drawing.shape("wall", &self.view.rectangle(wall));
        for channel in &self.channels {
            drawing.shape("free", &self.view.rectangle(channel.map(here)));
        }
        for (class, data) in ["guide", "gap", "curve"].iter().zip(paths) {
            drawing.shape(class, data);
        }
        let at = [self.left + WIDTH / 2.0, 26.0];
        drawing.label("head", Anchor::Middle, at, self.title);
    }

    /// The curvature over the length: of the arcs and of the smooth turns.
    fn draw_curvature(&self, drawing: &mut Drawing, motions: [&[Leg]; 2]) {
        let graphs = motions.map(curvature);
        let most = graphs.iter().flatten().fold(0.0_f64, |most, [_, k]| most.max(k.abs()));
        let length = graphs.iter().flatten().fold(0.0_f64, |most, [along, _]| most.max(*along));
        let (left, across, up) = (self.left + 34.0, (WIDTH - 40.0) / length, MOST / most);
        let view = View { corner: [left, ZERO], min: [0.0, 0.0], scale: 1.0 };
        for tick in [0.0, 1.0] {
            let [x, y] = view.at([0.0, up * tick]);
            drawing.line("grid", [x, y], [self.left + WIDTH, y]);
            drawing.label("note", Anchor::End, [x - 8.0, y + 4.0], &number(tick));
        }
        let [x, y] = view.at([0.0, MOST]);
        drawing.label(
            "note",
            Anchor::Start,
            [x - 22.0, y - 12.0],
            "curvature in rad/m over the length",
        );
        for (class, graph) in ["gap", "curve"].iter().zip(graphs) {
            let points: Vec<_> = graph.iter().map(|[along, k]| [across * along, up * k]).collect();
            drawing.shape(class, &view.polyline(&points));
        }
    }
}

/// Length travelled and curvature (rad/m, positive to the left) where legs begin and end.
fn curvature(legs: &[Leg]) -> Vec<Point> {
    let (mut points, mut along) = (Vec::new(), 0.0);
    for leg in legs {
        let [from, to] = match leg.curve {
            Curve::Line { .. } => [0.0; 2],
            Curve::Arc { radius, sweep, .. } => [sweep.signum() / radius; 2],
            Curve::Clothoid { curvatures, .. } => curvatures,
            Curve::Turn { .. } => continue,
        };
        points.push([along, from]);
        along += leg.length;
        points.push([along, to]);
    }
    points
}
