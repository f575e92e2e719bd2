//! Speed and yaw rate along corridor A.

use schemas::message::{Curve, Leg, Trajectory};

use super::drawing::{Anchor, Drawing, Point, View, number};
use super::motion::answer;

const SPEED: f64 = 1.0;
const YAW_RATE: f64 = 0.8;
const LATERAL: f64 = 0.5;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 772.0;

pub(crate) fn figure() -> String {
    let mut drawing = Drawing::new(
        [792.0, 372.0],
        "Speed profile along corridor A",
        "Above, the speed against time: it rises to 1 m/s on the lines, falls before each \
         arc to the arc's own limit, and never exceeds the limit of the leg, drawn as steps. \
         Below, the yaw rate, which is 0 on lines and steps where a line meets an arc.",
    );
    let ends = times(&motion("{\"count\": 2}"));
    let motion = motion("{\"count\": 1500}");
    let duration = motion.duration;
    let across = (RIGHT - LEFT) / duration;
    let mut from = 0.0;
    for (index, (leg, to)) in motion.legs.iter().zip(&ends).enumerate() {
        let [left, right] = [from, *to].map(|time| LEFT + across * time);
        let name = match leg.curve {
            Curve::Line { .. } => "line",
            Curve::Arc { .. } => {
                drawing.shape("junction", &rectangle([left, 34.0], [right, 322.0]));
                "arc"
            }
            Curve::Clothoid { .. } => "clothoid",
            Curve::Turn { .. } => {
                drawing.shape("channel", &rectangle([left, 34.0], [right, 322.0]));
                "turn"
            }
        };
        if right - left > 20.0 || index == 0 {
            let at = [(left + right) / 2.0, 26.0];
            drawing.label("note", Anchor::Middle, at, name);
        }
        from = *to;
    }

    let speed = View { corner: [LEFT, 200.0], min: [0.0, 0.0], scale: 1.0 };
    plot(&mut drawing, &speed, (150.0, &[0.0, 0.5, 1.0]), "speed, m/s");
    let yaw = View { corner: [LEFT, 274.0], min: [0.0, 0.0], scale: 1.0 };
    plot(&mut drawing, &yaw, (50.0, &[-0.8, 0.0, 0.8]), "yaw rate, rad/s");

    let mut limit = Vec::new();
    let mut from = 0.0;
    for (leg, to) in motion.legs.iter().zip(&ends) {
        let most = 150.0 * limit_of(leg);
        limit.extend([[from * across, most], [to * across, most]]);
        from = *to;
    }
    drawing.shape("limit", &speed.polyline(&limit));
    let points = |value: &dyn Fn(usize) -> f64| -> Vec<Point> {
        let samples = motion.samples.iter().enumerate();
        samples.map(|(index, sample)| [sample.t * across, value(index)]).collect()
    };
    let speeds = points(&|index| {
        let [x, y, _] = motion.samples[index].velocity;
        150.0 * libm::hypot(x, y)
    });
    drawing.shape("curve", &speed.polyline(&bends(&speeds)));
    let mut rates = Vec::new();
    let mut before = 0.0;
    for sample in &motion.samples {
        // It steps at the ends of arcs.
        if (sample.yaw_rate - before).abs() > 0.2 {
            rates.push([sample.t * across, 50.0 * before]);
        }
        rates.push([sample.t * across, 50.0 * sample.yaw_rate]);
        before = sample.yaw_rate;
    }
    drawing.shape("curve", &yaw.polyline(&bends(&rates)));

    let mut time = 0.0;
    while time <= duration {
        let x = LEFT + across * time;
        drawing.line("light", [x, 322.0], [x, 327.0]);
        drawing.label("note", Anchor::Middle, [x, 342.0], &number(time));
        time += 5.0;
    }
    drawing.label("note", Anchor::Middle, [(LEFT + RIGHT) / 2.0, 361.0], "time in seconds");
    drawing.finish()
}

fn motion(sampling: &str) -> Trajectory {
    answer(&format!(
        r#"{{"task": "drive",
            "free_space": {{"channels": [
                {{"min": [0, 0], "max": [3, 11]}}, {{"min": [0, 8], "max": [13, 11]}},
                {{"min": [9, 8], "max": [13, 20]}}, {{"min": [9, 16], "max": [22, 20]}}
            ], "in_order": true}},
            "body": {{"footprint": {{"width": 1.0, "length": 1.5}}}},
            "start": {{"position": [1.2, 1.5], "heading": 1.5707963267948966}},
            "goal": {{"position": [20.5, 18.25], "heading": 0}},
            "clearance": {{"gap": 0.2}},
            "limits": {{"speed": {SPEED}, "acceleration": 0.5, "yaw_rate": {YAW_RATE},
                        "yaw_acceleration": 1.0, "lateral_acceleration": {LATERAL}}},
            "sampling": {sampling}}}"#
    ))
}

/// When each leg ends: two samples are the first and the last state, and between them are only the
/// ends of legs.
fn times(motion: &Trajectory) -> Vec<f64> {
    let ends: Vec<_> = motion.samples[1..].iter().map(|sample| sample.t).collect();
    assert_eq!(ends.len(), motion.legs.len(), "a sample for the end of each leg");
    ends
}

/// The greatest speed on a leg, m/s.
fn limit_of(leg: &Leg) -> f64 {
    match leg.curve {
        Curve::Line { .. } | Curve::Clothoid { .. } => SPEED,
        Curve::Arc { radius, .. } => SPEED.min(YAW_RATE * radius).min((LATERAL * radius).sqrt()),
        Curve::Turn { .. } => 0.0,
    }
}

/// The points at which a line bends: speeds are made of straight pieces.
fn bends(line: &[Point]) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::new();
    for (index, point) in line.iter().enumerate() {
        let straight = match (kept.last(), line.get(index + 1)) {
            (Some(last), Some(next)) => {
                let [a, b] = [
                    [point[0] - last[0], point[1] - last[1]],
                    [next[0] - point[0], next[1] - point[1]],
                ];
                let forward = a[0] * b[0] + a[1] * b[1] >= 0.0;
                forward && (a[0] * b[1] - a[1] * b[0]).abs() < 1e-3 * libm::hypot(b[0], b[1])
            }
            _ => false,
        };
        if !straight {
            kept.push(*point);
        }
    }
    kept
}

fn plot(drawing: &mut Drawing, view: &View, (up, ticks): (f64, &[f64]), name: &str) {
    for tick in ticks {
        let [x, y] = view.at([0.0, up * tick]);
        drawing.line("grid", [x, y], [RIGHT, y]);
        drawing.label("note", Anchor::End, [x - 8.0, y + 4.0], &number(*tick));
    }
    let highest = ticks.iter().fold(0.0_f64, |most, tick| most.max(*tick));
    let [x, y] = view.at([0.0, up * highest]);
    drawing.label("over", Anchor::Start, [x + 66.0, y + 19.0], name);
}

fn rectangle([left, top]: Point, [right, bottom]: Point) -> String {
    let [left, top, right, bottom] = [left, top, right, bottom].map(number);
    format!("M{left} {top}H{right}V{bottom}H{left}Z")
}
