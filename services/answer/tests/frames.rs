//! Frames (paper, section 4), and where assembly tasks begin and end.

use answer::{Caps, reply_to};
use proptest::prelude::*;
use schemas::json::read_scene;
use schemas::message::{
    Curve, ErrorCode, Refusal, Request, RequestContent, RequestKey, Sample, Trajectory,
};

/// Section 4's channels and solid, in the female part's frame.
const FEMALE: &str = r#"{"in_order": true, "channels": [{"min": [4, 1], "max": [7, 6]},
    {"min": [1, 2], "max": [7, 6]}, {"min": [1, 2], "max": [5, 7]}],
    "solids": [{"polygon": [[0, 0], [0, 7], [1, 7], [1, 2], [4, 2], [4, 1], [7, 1], [7, 6], [5, 6],
    [5, 7], [8, 7], [8, 0]]}]}"#;

/// Section 4's male part in the female part's frame, and in its own, whose origin is m1.
const MALE: &str = "[[4.5, 1.01], [4.5, 4], [6.99, 4], [6.99, 1.01]]";
const MALE_ALONE: &str = "[[0, 0], [0, 2.99], [2.49, 2.99], [2.49, 0]]";

fn plan(task: &str, body: &str, more: &str) -> Result<Trajectory, Refusal> {
    let text = format!(
        r#"{{"task": "{task}", "free_space": {FEMALE}, "body": {{"polygon": {body}}},
            "clearance": {{"gap": 0.2}} {more}}}"#
    );
    let scene = read_scene(&text).unwrap_or_else(|error| panic!("{error:?}"));
    let content = RequestContent::Scene(scene);
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    reply_to(&request, &Caps::default()).answers?.remove(0)
}

/// The ends of the legs, all of them lines.
fn way_points(found: &Trajectory) -> Vec<[f64; 2]> {
    let ends = |curve: &Curve| match curve {
        Curve::Line { from, to, .. } => [from, to].map(|p| [p.as_slice()[0], p.as_slice()[1]]),
        other => panic!("{other:?}"),
    };
    let first = ends(&found.legs[0].curve)[0];
    std::iter::once(first).chain(found.legs.iter().map(|leg| ends(&leg.curve)[1])).collect()
}

#[track_caller]
fn assert_near(found: &[[f64; 2]], expected: &[[f64; 2]], within: f64) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a[0] - b[0]).hypot(a[1] - b[1]) <= within, "{found:?} for {expected:?}");
    }
}

fn place(sample: &Sample) -> [f64; 2] {
    [sample.position[0], sample.position[1]]
}

/// m1 runs from (4.5, 1.01) by (4.2, 2.2) and (2.31, 2.81) to (2.31, 7); f1 is at (12, -6).
#[test]
fn section_4_in_the_base_frame() {
    let plain = plan("disassemble", MALE, "").unwrap();
    let frames = r#", "frames": {"fixed": {"position": [12, -6], "heading": 0},
        "moving": {"position": [16.5, -4.99], "heading": 0}, "samples": "base"},
        "sampling": {"spacing": 100}"#;
    let found = plan("disassemble", MALE_ALONE, frames).unwrap();
    assert_near(&way_points(&found), &way_points(&plain), 1e-14);
    let states: Vec<_> = found.samples.iter().map(place).collect();
    let by_hand = [[16.5, -4.99], [16.2, -3.8], [14.31, -3.19], [14.31, 1.0]];
    assert_near(&states, &by_hand, 1e-14);
    assert!((found.clearance.value - 0.01).abs() < 1e-14);
    // As displacements, if that is wanted.
    let found = plan("disassemble", MALE_ALONE, &frames.replace("base", "fixed")).unwrap();
    assert_eq!(place(&found.samples[0]), [0.0, 0.0]);
}

#[test]
fn frame_of_the_fixed_part_alone_changes_no_leg() {
    let plain = plan("disassemble", MALE, "").unwrap();
    let frames = r#", "frames": {"fixed": {"position": [12, -6], "heading": 2.5}}"#;
    assert_eq!(plan("disassemble", MALE, frames).unwrap(), plain);
}

/// Both parts turned by the same angle: a quarter turn exactly, and any other.
#[test]
fn turned_parts_have_the_turned_motion() {
    let plain = plan("disassemble", MALE, "").unwrap();
    for heading in [std::f64::consts::FRAC_PI_2, 0.7, -2.9] {
        let (sin, cos) = f64::sin_cos(heading);
        let turn = |[x, z]: [f64; 2]| [12.0 + cos * x - sin * z, -6.0 + sin * x + cos * z];
        let frames = format!(
            r#", "frames": {{"fixed": {{"position": [12, -6], "heading": {heading}}},
                "samples": "base"}}"#
        );
        let found = plan("disassemble", MALE, &frames).unwrap();
        assert_eq!(found.legs, plain.legs);
        for (there, here) in plain.samples.iter().zip(&found.samples) {
            assert_near(&[place(here)], &[turn(place(there))], 1e-12);
            let speed = |sample: &Sample| sample.velocity[0].hypot(sample.velocity[1]);
            assert!((speed(here) - speed(there)).abs() < 1e-12);
            assert_eq!((here.t, here.heading), (there.t, heading));
        }
    }
}

/// The male part drawn lying on its side and turned upright by its frame.
#[test]
fn moving_part_is_turned_into_the_fixed_frame() {
    let plain = plan("disassemble", MALE, "").unwrap();
    // (x, z) = (4.5 - w, 1.01 + u) for a body drawn in (u, w).
    let lying = "[[0, 0], [2.99, 0], [2.99, -2.49], [0, -2.49]]";
    let frames = format!(
        r#", "frames": {{"fixed": {{"position": [0, 0], "heading": 0}},
            "moving": {{"position": [4.5, 1.01], "heading": {}}}}}"#,
        std::f64::consts::FRAC_PI_2
    );
    let found = plan("disassemble", lying, &frames).unwrap();
    assert_near(&way_points(&found), &way_points(&plain), 1e-14);
}

#[test]
fn goal_beyond_the_mouth_is_reached() {
    // Out at (-2.19, 5.99), then to (3, 8): beside the mouth, above the part.
    let found = plan("disassemble", MALE, r#", "goal": {"position": [3, 8]}"#).unwrap();
    let expected = [[0.0, 0.0], [-0.3, 1.19], [-2.19, 1.8], [-2.19, 5.99], [3.0, 8.0]];
    assert_near(&way_points(&found), &expected, 1e-14);
    let last = found.samples.last().unwrap();
    assert_eq!((place(last), last.velocity), ([3.0, 8.0], [0.0; 3]));
    // Straight ahead there is no stop at the mouth.
    let found = plan("disassemble", MALE, r#", "goal": {"position": [-2.19, 8]}"#).unwrap();
    assert_eq!(found.legs.len(), 3);
    // From there into the part: the exact reverse.
    let back = plan("assemble", MALE, r#", "start": {"position": [3, 8]}"#).unwrap();
    let mut points = way_points(&back);
    points.reverse();
    assert_near(&points, &expected, 1e-14);
    assert_eq!(place(&back.samples[0]), [3.0, 8.0]);
}

#[test]
fn start_is_where_the_body_is_taken_up() {
    let found = plan("disassemble", MALE, r#", "start": {"position": [-0.1, 0.5]}"#).unwrap();
    assert_eq!(place(&found.samples[0]), [-0.1, 0.5]);
    let expected = [[-0.1, 0.5], [-0.3, 1.19], [-2.19, 1.8], [-2.19, 5.99]];
    assert_near(&way_points(&found), &expected, 1e-14);
    let outside = plan("disassemble", MALE, r#", "start": {"position": [-1, 0.5]}"#).unwrap_err();
    assert_eq!(outside.code, ErrorCode::BodyOutsideFreeSpace);
}

#[test]
fn goal_short_of_the_mouth_is_refused() {
    let short = plan("disassemble", MALE, r#", "goal": {"position": [0, 5]}"#).unwrap_err();
    assert_eq!(short.code, ErrorCode::GoalOutsideFreeSpace);
    assert_eq!(short.field.as_deref(), Some("goal.position"));
    assert!((short.has.unwrap() + 0.99).abs() < 1e-14, "{short:?}");
    let short = plan("assemble", MALE, r#", "start": {"position": [0, 5]}"#).unwrap_err();
    assert_eq!(short.field.as_deref(), Some("start.position"));
    let heading = r#", "goal": {"position": [0, 8], "heading": 1}"#;
    assert_eq!(
        plan("disassemble", MALE, heading).unwrap_err().field.as_deref(),
        Some("goal.heading")
    );
}

/// With channels alone the body can't leave the strip beyond the mouth.
#[test]
fn goal_beside_the_strip_is_in_the_way_of_a_wall() {
    let plan = |goal: &str| {
        let text = format!(
            r#"{{"task": "disassemble", "free_space": {{"in_order": true,
                "channels": [{{"min": [0, 0], "max": [3, 4]}}]}},
                "body": {{"box": {{"min": [1, 1], "max": [2, 2]}}}},
                "clearance": {{"gap": 0.2}}, "goal": {{"position": {goal}}}}}"#
        );
        let content = RequestContent::Scene(read_scene(&text).unwrap());
        let request = Request { key: RequestKey::default(), sent_ns: 0, content };
        reply_to(&request, &Caps::default()).answers?.remove(0)
    };
    assert_eq!(plan("[0.5, 9]").unwrap().clearance.value, 0.5);
    assert_eq!(plan("[1.5, 9]").unwrap_err().code, ErrorCode::WallInTheWay);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// The fixed part goes evenly from one pose to the other, and the states belong together:
    /// velocities and yaw rates are what places and headings change by.
    #[test]
    fn moving_frames_carry_the_samples(
        from in prop::array::uniform3(-3.0..3.0_f64), to in prop::array::uniform3(-3.0..3.0_f64),
    ) {
        let pose = |[x, z, h]: [f64; 3]| format!(r#"{{"position": [{x}, {z}], "heading": {h}}}"#);
        let frames = format!(
            r#", "frames": {{"fixed": {}, "fixed_at_end": {}, "samples": "base"}},
                "sampling": {{"period": 0.001}}"#,
            pose(from), pose(to)
        );
        let found = plan("disassemble", MALE, &frames).unwrap();
        let plain = plan("disassemble", MALE, "").unwrap();
        let (first, last) = (&found.samples[0], found.samples.last().unwrap());
        assert_near(&[place(first)], &[[from[0], from[1]]], 1e-12);
        let out = *way_points(&plain).last().unwrap();
        let (sin, cos) = to[2].sin_cos();
        let end = [to[0] + cos * out[0] - sin * out[1], to[1] + sin * out[0] + cos * out[1]];
        assert_near(&[place(last)], &[end], 1e-12);
        for pair in found.samples.windows(2) {
            let (a, b) = (&pair[0], &pair[1]);
            let dt = b.t - a.t;
            for axis in 0..2 {
                let moved = b.position[axis] - a.position[axis];
                let mean = 0.5 * (a.velocity[axis] + b.velocity[axis]);
                // Velocity jumps in direction at way-points, where it is 0.
                prop_assert!((moved - mean * dt).abs() < 1e-3 * dt + 1e-12, "{a:?} {b:?}");
            }
        }
    }
}
