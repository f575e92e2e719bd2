//! What a robot sweeps over in a turn, and how its clearance depends on the gap.

use std::f64::consts::FRAC_PI_2;

use planning::clearance::rectangle::Footprint;
use planning::driving::limits::{balanced_gap, greatest_gap, outer_radius};
use schemas::message::{Curve, Leg};

use super::drawing::{Anchor, Drawing, Point, View, number, polar};
use super::motion::{answer, answers, boxes, ends, flat, outline, path};

const ROBOT: [f64; 2] = [1.0, 1.5];
/// Of both corridors.
const WIDTH: f64 = 3.0;
const CHANNELS: [[Point; 2]; 2] = [[[0.2, -2.0], [3.2, 6.2]], [[0.2, 3.2], [8.4, 6.2]]];
const CORNER: Point = [3.2, 3.2];

pub(crate) fn figure() -> String {
    let mut drawing = Drawing::new(
        [792.0, 372.0],
        "The safest gap",
        "Left: the outline of what a robot of 1.0 m by 1.5 m sweeps over as it turns in a \
         corridor 3 m wide at the safest gap. It is bounded by a circle of the radius g and one \
         of the radius R(g) about the corner, and leaves 0.93 m to the corner and to the \
         outer walls. Right: the clearance against the gap. It grows as the gap up to the safest, \
         0.93 m, and falls to 0 at 1.90 m.",
    );
    let robot = Footprint::new(ROBOT[0], ROBOT[1]).expect("a footprint");
    draw_turn(&mut drawing, &robot);
    draw_graph(&mut drawing, &robot);
    drawing.finish()
}

/// A scene in which the robot turns a full quarter: it starts and ends beside the circle.
fn scene(gap: f64, clearance: &str) -> String {
    let aside = ROBOT[0] / 2.0 + gap;
    let (start, goal) = ([CORNER[0] - aside, 0.5], [7.0, CORNER[1] + aside]);
    format!(
        r#"{{"task": "drive",
            "free_space": {{"channels": {}, "in_order": true}},
            "body": {{"footprint": {{"width": {}, "length": {}}}}},
            "start": {{"position": {start:?}, "heading": {FRAC_PI_2}}},
            "goal": {{"position": {goal:?}, "heading": 0}},
            "clearance": {clearance}, "sampling": {{"count": 2}}}}"#,
        boxes(&CHANNELS),
        ROBOT[0],
        ROBOT[1],
    )
}

fn draw_turn(drawing: &mut Drawing, robot: &Footprint) {
    let gap = balanced_gap(robot, WIDTH);
    let answer = answer(&scene(gap, r#""safest""#));
    assert!((answer.gaps[0] - gap).abs() < 1e-9, "the safest gap is the balanced one");
    let outer = outer_radius(robot, gap);

    let view = View { corner: [24.0, 324.0], min: [0.0, -0.4], scale: 44.0 };
    // The corridors go on beyond the drawing.
    drawing.shape("wall", &view.rectangle([[0.0, -0.4], [7.9, 6.4]]));
    drawing.shape("free", &view.rectangle([[0.2, -0.42], CHANNELS[0][1]]));
    drawing.shape("free", &view.rectangle([CHANNELS[1][0], [7.92, 6.2]]));
    for leg in &answer.legs {
        drawing.shape("swept", &swept(&view, leg, gap, outer));
    }
    let quarter = |radius: f64| view.arc(CORNER, radius, FRAC_PI_2 - 0.35, 2.27);
    drawing.shape("guide", &quarter(gap));
    drawing.shape("guide", &quarter(outer));
    drawing.shape("path", &path(&view, &answer.legs));

    let diagonal = polar(CORNER, gap, 2.356);
    drawing.distance(view.at(CORNER), view.at(diagonal));
    let side = CORNER[0] - outer;
    drawing.distance(view.at([0.2, CORNER[1] + 0.04]), view.at([side, CORNER[1] + 0.04]));
    let [x, y] = view.at([0.2, CORNER[1]]);
    drawing.label("math alert over", Anchor::Start, [x + 3.0, y - 9.0], "W − R(g)");
    let [x, y] = view.at([CORNER[0] - 0.1, CORNER[1] + 0.42]);
    drawing.label("math alert over", Anchor::Start, [x, y], "g");
    drawing.circle("dot", view.at(CORNER), 3.5);
    let [x, y] = view.at(CORNER);
    drawing.label("math over", Anchor::Start, [x + 9.0, y + 18.0], "p");
    let [x, y] = view.at(polar(CORNER, outer, 0.98));
    drawing.label("math over", Anchor::Start, [x + 6.0, y - 2.0], "R(g)");
    let [x, y] = view.at([3.95, -0.4]);
    let text = format!("W = {WIDTH} m, w = {} m, h = {} m", ROBOT[0], ROBOT[1]);
    drawing.label("note", Anchor::Middle, [x, y + 28.0], &text);
}

/// What the robot sweeps over on a leg.
///
/// On an arc: all between the circles of the two radii, from the first placement to
/// the last, and these.
fn swept(view: &View, leg: &Leg, inner: f64, outer: f64) -> String {
    let [first, last] = ends(leg).map(|pose| outline(pose, ROBOT));
    match leg.curve {
        Curve::Arc { center, start_angle, sweep, .. } => {
            // A right turn: the right side is the inner one.
            let [rear_left, .., rear_right] = first;
            let [_, front_left, front_right, _] = last;
            let center = flat(&center);
            let [from, to] = [start_angle, start_angle + sweep];
            let side = |angle: f64| polar(center, inner, angle);
            let swing = 2.0 * libm::atan2(ROBOT[1] / 2.0, inner + ROBOT[0]);
            let mut data = view.polyline(&[rear_left]);
            data += &view.arc_to(outer, sweep - swing, front_left);
            data += &view.polyline(&[front_right, side(to)]).replace('M', "L");
            data += &view.arc_to(inner, -sweep, side(from));
            data + &view.polyline(&[rear_right]).replace('M', "L") + "Z"
        }
        _ => view.ring(&[first[0], last[1], last[2], first[3]]),
    }
}

fn draw_graph(drawing: &mut Drawing, robot: &Footprint) {
    let (safest, most) = (balanced_gap(robot, WIDTH), greatest_gap(robot, WIDTH));
    // Pixels per metre, from 0 m.
    let (corner, across, up) = ([448.0, 290.0], 156.0, 210.0);
    let at = |gap: f64, clearance: f64| [corner[0] + across * gap, corner[1] - up * clearance];
    let y = |clearance: f64| at(0.0, clearance)[1];

    for tick in [0.0, 0.5, 1.0] {
        drawing.line("grid", at(0.0, tick), at(2.0, tick));
        let label = number(tick);
        drawing.label("note", Anchor::End, [corner[0] - 8.0, y(tick) + 4.0], &label);
    }
    for tick in [0.0, 0.5, 1.0, 1.5, 2.0] {
        drawing.line("grid", at(tick, 0.0), at(tick, 1.1));
        let [x, y] = at(tick, 0.0);
        drawing.label("note", Anchor::Middle, [x, y + 18.0], &number(tick));
    }
    let [x, y] = at(1.0, 0.0);
    drawing.label("note", Anchor::Middle, [x, y + 38.0], "gap g in metres");
    let [x, y] = at(0.0, 1.1);
    drawing.label("note", Anchor::Start, [x - 22.0, y - 14.0], "clearance of the turn in metres");

    let mut points = vec![[0.0, 0.0]];
    for step in 1..40 {
        let gap = most * f64::from(step) / 40.0;
        points.push([gap, turning(gap)]);
    }
    points.extend([[safest, turning(safest)], [most, 0.0]]);
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let graph = View { corner, min: [0.0, 0.0], scale: 1.0 };
    let scaled: Vec<Point> = points.iter().map(|[g, c]| [g * across, c * up]).collect();
    drawing.shape("curve", &graph.polyline(&scaled));

    let peak = at(safest, safest);
    drawing.line("guide", peak, at(safest, 0.0));
    drawing.circle("gap-dot", peak, 4.0);
    let text = format!("g* = {safest:.4} m");
    drawing.label("math alert over", Anchor::Start, [peak[0] + 10.0, peak[1] - 4.0], &text);
    let end = at(most, 0.0);
    drawing.circle("gap-dot", end, 4.0);
    let text = format!("g_{{max}} = {most:.4} m");
    drawing.label("math alert over", Anchor::End, [end[0] + 20.0, end[1] - 12.0], &text);
    let [x, y] = at(0.36, 0.36);
    drawing.label("math over", Anchor::End, [x - 10.0, y - 6.0], "g");
    let [x, y] = at(1.42, 0.48);
    drawing.label("math over", Anchor::Start, [x + 12.0, y - 6.0], "W − R(g)");
}

/// The clearance on the arc at a gap, as the planner measures it.
fn turning(gap: f64) -> f64 {
    let answers = answers(&scene(gap, &format!(r#"{{"gap": {gap:?}}}"#)));
    let arc = answers[0].legs.iter().find(|leg| matches!(leg.curve, Curve::Arc { .. }));
    arc.expect("the robot turns about the corner").clearance
}
