//! One corner: the guiding circle, the tangents to it, and Table 2's two angles.

use std::f64::consts::{FRAC_PI_2, PI};

use schemas::message::Curve;

use super::drawing::{Anchor, Drawing, Point, View, polar};
use super::motion::{answer, boxes, ends, flat, outline, path};

const ROBOT: [f64; 2] = [1.0, 1.5];
const START: Point = [1.0, 0.9];
const GOAL: Point = [9.3, 5.9];
const CHANNELS: [[Point; 2]; 2] = [[[0.2, 0.0], [3.2, 7.0]], [[0.2, 4.0], [10.2, 7.0]]];

pub(crate) fn figure() -> String {
    let answer = answer(&format!(
        r#"{{"task": "drive",
            "free_space": {{"channels": {}, "in_order": true}},
            "body": {{"footprint": {{"width": 1.0, "length": 1.5}}}},
            "start": {{"position": {START:?}, "heading": 1.5707963267948966}},
            "goal": {{"position": {GOAL:?}}},
            "clearance": {{"gap": 0.7}}, "sampling": {{"count": 2}}}}"#,
        boxes(&CHANNELS),
    ));
    let arc = answer.legs.iter().find(|leg| matches!(leg.curve, Curve::Arc { .. }));
    let arc = arc.expect("the robot turns about the corner");
    let Curve::Arc { center, radius, start_angle, sweep } = arc.curve else { unreachable!() };
    let (center, [arriving, leaving]) = (flat(&center), ends(arc));

    let mut drawing = Drawing::new(
        [792.0, 560.0],
        "The guiding circle",
        "A robot in an L-shaped corridor, which comes from below and leaves to the right. Its \
         centre m0 drives along a tangent to the arriving point on the guiding circle about \
         the corner, along the circle to the leaving point, and along a second tangent to the \
         goal. The arriving and the leaving angle are marked at the corner.",
    );
    let view = View { corner: [24.0, 536.0], min: [0.0, 0.0], scale: 72.0 };
    drawing.shape("wall", &view.rectangle([[0.0, 0.0], [10.4, 7.2]]));
    for channel in CHANNELS {
        drawing.shape("free", &view.rectangle(channel));
    }
    drawing.shape("junction", &view.rectangle([[0.2, 4.0], [3.2, 7.0]]));
    let whole = |angle: f64| view.arc(center, radius, angle, PI);
    drawing.shape("guide", &(whole(0.0) + &whole(PI)));

    let middle = {
        let angle = start_angle + sweep / 2.0;
        (polar(center, radius, angle), angle + FRAC_PI_2.copysign(sweep))
    };
    drawing.shape("swept", &view.ring(&outline(middle, ROBOT)));
    drawing.shape("body", &view.ring(&outline((START, arriving.1), ROBOT)));
    drawing.shape("path", &path(&view, &answer.legs));

    angles(&mut drawing, &view, center, [start_angle, start_angle + sweep]);
    // The gap, seen half-way: from the corner to the robot's side.
    let (turned, gap) = (start_angle + sweep / 2.0, radius - ROBOT[0] / 2.0);
    drawing.distance(view.at(center), view.at(polar(center, gap, turned)));
    let [x, y] = view.at(polar(center, gap / 2.0, turned));
    drawing.label("math alert over", Anchor::End, [x - 5.0, y - 1.0], "g");

    let dots: [(Point, &str, Point, Anchor); 5] = [
        (START, "m_0", [12.0, 5.0], Anchor::Start),
        (arriving.0, "m_a", [-9.0, 20.0], Anchor::End),
        (leaving.0, "m_l", [12.0, 17.0], Anchor::Start),
        (GOAL, "goal", [0.0, -12.0], Anchor::Middle),
        (center, "p_n", [12.0, 18.0], Anchor::Start),
    ];
    for (at, name, aside, anchor) in dots {
        let [x, y] = view.at(at);
        drawing.circle("dot", [x, y], 3.5);
        drawing.label("math over", anchor, [x + aside[0], y + aside[1]], name);
    }
    let [x, y] = view.at([4.9, 3.2]);
    for (line, text) in [
        "Guiding circle about p_n: radius ρ = w/2 + g,",
        "w the robot’s width, g the gap.",
        "The lines m_0–m_a and m_l–goal are tangents of it.",
        "Between them the robot turns by 90° − Θ_a − Θ_l.",
    ]
    .iter()
    .enumerate()
    {
        drawing.label("", Anchor::Start, [x, y + 21.0 * line as f64], text);
    }
    drawing.finish()
}

/// The arriving angle, from the level through the corner to the arriving point, and the
/// leaving angle, from the leaving point to the upright.
fn angles(drawing: &mut Drawing, view: &View, center: Point, [arriving, leaving]: [f64; 2]) {
    for (level, angle, name) in [(PI, arriving, "Θ_a"), (FRAC_PI_2, leaving, "Θ_l")] {
        for ray in [level, angle] {
            drawing.line("light", view.at(center), view.at(polar(center, 2.1, ray)));
        }
        let turned = wrapped(angle - level);
        drawing.shape("light", &view.arc(center, 1.9, level, turned));
        let [x, y] = view.at(polar(center, 2.2, level + turned / 2.0));
        let (anchor, y) =
            if level == PI { (Anchor::End, y + 5.0) } else { (Anchor::Middle, y - 2.0) };
        drawing.label("math over", anchor, [x, y], name);
    }
}

fn wrapped(angle: f64) -> f64 {
    planning::motion::wrapped(angle)
}
