//! Table 1: the same L in its eight orientations, each passed by one rule.

use std::array;

use planning::geometry::{Direction, Sign};

use super::drawing::{Anchor, Drawing, Point, View};
use super::motion::{answer, boxes, common, ends, moved};

const GAP: f64 = 0.35;
/// The part's extents along x and z.
const PART: [f64; 2] = [1.5, 1.2];

/// In the order of the rules.
const TURNS: [(&str, &str); 8] = [
    ("up", "left"),
    ("up", "right"),
    ("left", "up"),
    ("right", "up"),
    ("down", "left"),
    ("down", "right"),
    ("left", "down"),
    ("right", "down"),
];

pub(crate) fn figure() -> String {
    let mut drawing = Drawing::new(
        [792.0, 450.0],
        "The eight rules of Table 1",
        "Eight panels, one for each rule: an L of two channels, the junction between them, the \
         part before and after its motion into the junction. After it the part keeps the gap g \
         from the two sides of the junction that meet in the corner inside the turn.",
    );
    for (index, (approach, leaving)) in TURNS.into_iter().enumerate() {
        let column = (index % 4) as f64;
        let bottom = if index < 4 { 208.0 } else { 430.0 };
        let view = View { corner: [20.0 + 194.0 * column, bottom], min: [0.0; 2], scale: 26.0 };
        draw(&mut drawing, &view, index + 1, (approach, leaving));
    }
    drawing.finish()
}

fn direction(name: &str) -> Direction {
    let (axis, sign) = match name {
        "left" => (0, Sign::Negative),
        "right" => (0, Sign::Positive),
        "down" => (1, Sign::Negative),
        _ => (1, Sign::Positive),
    };
    Direction { axis, sign }
}

/// The side of a panel, metres.
const SIDE: f64 = 6.6;

fn draw(drawing: &mut Drawing, view: &View, number: usize, (approach, leaving): (&str, &str)) {
    let (a, b) = (direction(approach), direction(leaving));
    // A point told along the approach and along the way out, placed in the panel.
    let place = |along: f64, out: f64| -> Point {
        array::from_fn(|axis| {
            let (value, sign) = if axis == a.axis { (along, a.sign) } else { (out, b.sign) };
            if sign == Sign::Positive { value } else { SIDE - value }
        })
    };
    let sorted = |one: Point, other: Point| -> [Point; 2] {
        [
            array::from_fn(|axis| one[axis].min(other[axis])),
            array::from_fn(|axis| one[axis].max(other[axis])),
        ]
    };
    let before = sorted(place(0.2, 0.2), place(6.4, 3.2));
    let after = sorted(place(3.4, 0.2), place(6.4, 6.4));
    let middle = place(1.4, 1.9);
    let part: [Point; 2] =
        [-0.5, 0.5].map(|half| array::from_fn(|axis| middle[axis] + half * PART[axis]));

    let exit = match leaving {
        "left" => "-x",
        "right" => "+x",
        "down" => "-z",
        _ => "+z",
    };
    let ring = |[min, max]: [Point; 2]| [min, [max[0], min[1]], max, [min[0], max[1]]];
    let answer = answer(&format!(
        r#"{{"task": "disassemble",
            "free_space": {{"channels": {}, "in_order": true}},
            "body": {{"polygon": {:?}}}, "exit": "{exit}",
            "clearance": {{"gap": {GAP}}}, "sampling": {{"count": 2}}}}"#,
        boxes(&[before, after]),
        ring(part),
    ));
    let leg = &answer.legs[0];
    let rule = leg.rule.expect("a rule leads into a junction");
    assert_eq!((rule.table, usize::from(rule.number)), (1, number), "{approach}, {leaving}");
    let target = moved(part, ends(leg)[1].0);

    drawing.shape("wall", &view.rectangle([[0.0; 2], [SIDE; 2]]));
    for channel in [before, after] {
        drawing.shape("free", &view.rectangle(channel));
    }
    let junction = common(before, after);
    drawing.shape("junction", &view.rectangle(junction));
    drawing.shape("ghost", &view.rectangle(part));
    drawing.shape("body", &view.rectangle(target));
    let center = |[min, max]: [Point; 2]| [(min[0] + max[0]) / 2.0, (min[1] + max[1]) / 2.0];
    drawing.arrow("path", view.at(center(part)), view.at(center(target)));

    // The corner inside the turn: the entering side along the approach, the leaving side.
    let corner = place(3.4, 3.2);
    let middle = center(target);
    for axis in 0..2 {
        // Towards the corner along a level side, away from it along an upright one: beside the
        // arrow and apart from each other.
        let other = 1 - axis;
        let aside = if axis == 1 { 0.3 } else { -0.3 } * PART[other];
        let towards = |axis: usize| if corner[axis] < middle[axis] { -1.0 } else { 1.0 };
        let mut from = corner;
        from[other] = middle[other] + towards(other) * aside;
        let mut to = from;
        to[axis] -= towards(axis) * GAP;
        drawing.distance(view.at(from), view.at(to));
        let [x, y] = view.at([(from[0] + to[0]) / 2.0, (from[1] + to[1]) / 2.0]);
        let at = match axis {
            0 => [x, y + if towards(1) < 0.0 { -7.0 } else { 15.0 }],
            _ => [x + 9.0 * towards(0), y + 4.0],
        };
        drawing.label("math alert over", Anchor::Middle, at, "g");
    }
    drawing.circle("dot", view.at(corner), 3.5);
    let [x, _] = view.at([SIDE / 2.0, 0.0]);
    let y = view.at([0.0, SIDE])[1] - 9.0;
    let title = format!("Rule {number}: {approach}, then {leaving}");
    drawing.label("head", Anchor::Middle, [x, y], &title);
}
