//! Frames, start and goal of assembly tasks in three dimensions.

use std::f64::consts::{FRAC_PI_2, PI};

use answer::{Caps, reply_to};
use proptest::prelude::*;
use schemas::json::read_scene;
use schemas::message::{
    Curve, ErrorCode, Refusal, Request, RequestContent, RequestKey, Sample, Trajectory,
};

type Point = [f64; 3];

/// Section 4's channels, 2 m deep.
const DEEP: &str = r#"{"in_order": true, "channels": [{"min": [4, 0, 1], "max": [7, 2, 6]},
    {"min": [1, 0, 2], "max": [7, 2, 6]}, {"min": [1, 0, 2], "max": [5, 2, 7]}]}"#;

/// Section 4's male part, 1 m deep, in the female part's frame, and in its own.
const MALE: [Point; 2] = [[4.5, 0.5, 1.01], [6.99, 1.5, 4.0]];
const MALE_ALONE: [Point; 2] = [[0.0; 3], [2.49, 1.0, 2.99]];

/// Where section 4's male part is led by the rules: nothing makes it move along y.
const WAY: [Point; 4] = [[0.0; 3], [-0.3, 0.0, 1.19], [-2.19, 0.0, 1.8], [-2.19, 0.0, 5.99]];

/// A shaft with four walls and a floor, open above, and a box in it.
const SHAFT: &str = r#"{"solids": [
    {"box": {"min": [0, 0, 0], "max": [6, 4, 1]}},
    {"box": {"min": [0, 0, 1], "max": [1, 4, 5]}}, {"box": {"min": [5, 0, 1], "max": [6, 4, 5]}},
    {"box": {"min": [1, 0, 1], "max": [5, 1, 5]}}, {"box": {"min": [1, 3, 1], "max": [5, 4, 5]}}]}"#;
const PIN: [Point; 2] = [[2.0, 1.5, 1.2], [3.0, 2.5, 2.2]];

fn plan(task: &str, space: &str, body: [Point; 2], more: &str) -> Result<Trajectory, Refusal> {
    let [min, max] = body;
    let text = format!(
        r#"{{"task": "{task}", "free_space": {space},
            "body": {{"box": {{"min": {min:?}, "max": {max:?}}}}}, "clearance": {{"gap": 0.2}} {more}}}"#
    );
    let scene = read_scene(&text).unwrap_or_else(|error| panic!("{error:?}\n{text}"));
    let content = RequestContent::Scene(scene);
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    reply_to(&request, &Caps::default()).answers?.remove(0)
}

/// The ends of the legs, all of them lines.
fn way_points(found: &Trajectory) -> Vec<Point> {
    let ends = |curve: &Curve| match curve {
        Curve::Line { from, to, .. } => [from.padded(), to.padded()],
        other => panic!("{other:?}"),
    };
    let first = ends(&found.legs[0].curve)[0];
    std::iter::once(first).chain(found.legs.iter().map(|leg| ends(&leg.curve)[1])).collect()
}

fn distance(a: Point, b: Point) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

#[track_caller]
fn assert_near(found: &[Point], expected: &[Point], within: f64) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!(distance(*a, *b) <= within, "{found:?} for {expected:?}");
    }
}

fn places(found: &Trajectory) -> Vec<Point> {
    found.samples.iter().map(|sample| sample.position).collect()
}

/// A pose: a place, and a heading about z.
#[derive(Debug, Clone, Copy)]
struct Pose {
    at: Point,
    heading: f64,
}

impl Pose {
    fn turn(&self, [x, y, z]: Point) -> Point {
        let (sin, cos) = self.heading.sin_cos();
        [cos * x - sin * y, sin * x + cos * y, z]
    }

    /// A point of the frame in this pose as the base frame sees it.
    fn out(&self, point: Point) -> Point {
        let turned = self.turn(point);
        [0, 1, 2].map(|axis| self.at[axis] + turned[axis])
    }

    fn json(&self) -> String {
        format!(r#"{{"position": {:?}, "heading": {}}}"#, self.at, self.heading)
    }
}

fn sum(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|axis| a[axis] + b[axis])
}

/// An angle as the difference from another, in (-pi, pi].
fn difference(a: f64, b: f64) -> f64 {
    let difference = (a - b).rem_euclid(2.0 * PI);
    if difference > PI { difference - 2.0 * PI } else { difference }
}

#[test]
fn deep_section_4_is_left_as_in_the_plane() {
    let found = plan("disassemble", DEEP, MALE, "").unwrap();
    assert_near(&way_points(&found), &WAY, 1e-14);
    // The clearance is that to the wall at x = 7, as in the plane.
    assert!((found.clearance.value - 0.01).abs() < 1e-14);
}

/// The female part stands at (12, 5, -6), the male part's frame is its corner.
#[test]
fn deep_section_4_in_the_base_frame() {
    let frames = r#", "frames": {"fixed": {"position": [12, 5, -6], "heading": 0},
        "moving": {"position": [16.5, 5.5, -4.99], "heading": 0}, "samples": "base"},
        "sampling": {"spacing": 100}"#;
    let found = plan("disassemble", DEEP, MALE_ALONE, frames).unwrap();
    assert_near(&way_points(&found), &WAY, 1e-14);
    let by_hand = [[16.5, 5.5, -4.99], [16.2, 5.5, -3.8], [14.31, 5.5, -3.19], [14.31, 5.5, 1.0]];
    assert_near(&places(&found), &by_hand, 1e-14);
    let found = plan("disassemble", DEEP, MALE_ALONE, &frames.replace("base", "fixed")).unwrap();
    assert_near(&places(&found), &WAY, 1e-14);
}

/// Headings are about z: a quarter turn of both parts takes x to y.
#[test]
fn turned_parts_move_along_the_turned_axes() {
    let frames = format!(
        r#", "frames": {{"fixed": {{"position": [10, 20, 30], "heading": {FRAC_PI_2}}},
            "samples": "base"}}, "sampling": {{"spacing": 100}}"#
    );
    let found = plan("disassemble", DEEP, MALE, &frames).unwrap();
    // The part's frame is the female part's, so it begins at (10, 20, 30).
    let by_hand =
        [[10.0, 20.0, 30.0], [10.0, 19.7, 31.19], [10.0, 17.81, 31.8], [10.0, 17.81, 35.99]];
    assert_near(&places(&found), &by_hand, 1e-13);
    assert!(found.samples.iter().all(|sample| sample.heading == FRAC_PI_2));
    // On the first two legs it moves in the plane of y and z, on the last along z alone.
    let found = plan("disassemble", DEEP, MALE, &frames.replace("100", "0.1")).unwrap();
    for Sample { position, velocity, .. } in &found.samples {
        assert!(velocity[0].abs() < 1e-12 && velocity[1] < 1e-12, "{velocity:?}");
        assert!(position[2] < 31.8 + 1e-9 || velocity[1].abs() < 1e-12, "{velocity:?}");
    }
}

/// The male part as it is drawn in a frame that is turned by each multiple of a quarter turn.
#[test]
fn part_is_turned_by_quarter_turns() {
    let drawn = [
        (0.0, MALE_ALONE),
        (FRAC_PI_2, [[0.0, -2.49, 0.0], [1.0, 0.0, 2.99]]),
        (PI, [[-2.49, -1.0, 0.0], [0.0, 0.0, 2.99]]),
        (-FRAC_PI_2, [[-1.0, 0.0, 0.0], [0.0, 2.49, 2.99]]),
    ];
    for (heading, body) in drawn {
        let frames = format!(
            r#", "frames": {{"fixed": {{"position": [0, 0, 0], "heading": 0}},
                "moving": {{"position": [4.5, 0.5, 1.01], "heading": {heading}}}}}"#
        );
        let found = plan("disassemble", DEEP, body, &frames).unwrap();
        assert_near(&way_points(&found), &WAY, 1e-14);
    }
    let askew = r#", "frames": {"fixed": {"position": [0, 0, 0], "heading": 0.5},
        "moving": {"position": [4.5, 0.5, 1.01], "heading": 0.9}}"#;
    let refused = plan("disassemble", DEEP, MALE_ALONE, askew).unwrap_err();
    assert_eq!(refused.field.as_deref(), Some("frames.moving.heading"));
    // Both turned alike are not askew to each other.
    let alike = askew.replace("0.9", "0.5").replace("[4.5, 0.5, 1.01]", "[0, 0, 0]");
    assert_near(&way_points(&plan("disassemble", DEEP, MALE, &alike).unwrap()), &WAY, 1e-14);
}

/// Straight up to the mouth at z = 5, then to a place beside the shaft.
#[test]
fn goal_beyond_the_mouth_is_reached_in_space() {
    let found = plan("disassemble", SHAFT, PIN, r#", "goal": {"position": [4, -3, 6]}"#).unwrap();
    let expected = [[0.0; 3], [0.0, 0.0, 3.8], [4.0, -3.0, 6.0]];
    assert_near(&way_points(&found), &expected, 1e-14);
    // (4, -3, 2.2) further: 25 + 4.84.
    assert!((found.length - (3.8 + 29.84_f64.sqrt())).abs() < 1e-14, "{}", found.length);
    let last = found.samples.last().unwrap();
    assert_eq!((last.position, last.velocity), ([4.0, -3.0, 6.0], [0.0; 3]));
    let back = plan("assemble", SHAFT, PIN, r#", "start": {"position": [4, -3, 6]}"#).unwrap();
    let mut points = way_points(&back);
    points.reverse();
    assert_near(&points, &expected, 1e-14);
    assert_eq!(back.samples[0].position, [4.0, -3.0, 6.0]);
    // Short of the mouth by 0.8 m.
    let short =
        plan("disassemble", SHAFT, PIN, r#", "goal": {"position": [0, 0, 3]}"#).unwrap_err();
    assert_eq!(short.code, ErrorCode::GoalOutsideFreeSpace);
    assert_eq!(short.field.as_deref(), Some("goal.position"));
    assert!((short.has.unwrap() + 0.8).abs() < 1e-14, "{short:?}");
}

/// The box is taken up half-way, and put there again.
#[test]
fn start_in_space_is_where_the_body_is_taken_up() {
    let from = r#", "start": {"position": [0.5, -0.2, 0.7]}"#;
    let found = plan("disassemble", SHAFT, PIN, from).unwrap();
    let expected = [[0.5, -0.2, 0.7], [0.5, -0.2, 3.8]];
    assert_near(&way_points(&found), &expected, 1e-14);
    // The nearest wall is that at y = 1: the box begins at 1.5 - 0.2.
    assert!((found.clearance.value - 0.3).abs() < 1e-14, "{:?}", found.clearance);
    let back = plan("assemble", SHAFT, PIN, &from.replace("start", "goal")).unwrap();
    let mut points = way_points(&back);
    points.reverse();
    assert_near(&points, &expected, 1e-14);
    let inside = plan("disassemble", SHAFT, PIN, r#", "start": {"position": [0, -0.6, 0]}"#);
    assert_eq!(inside.unwrap_err().code, ErrorCode::BodyOutsideFreeSpace);
}

/// With channels alone only the last channel's strip is free beyond the mouth: 4 m by 2 m.
#[test]
fn strip_beyond_the_mouth_has_four_sides() {
    let goal = |at: Point| format!(r#", "goal": {{"position": {at:?}}}"#);
    let free = plan("disassemble", DEEP, MALE, &goal([-2.0, 0.4, 8.0])).unwrap();
    assert_near(&way_points(&free)[4..], &[[-2.0, 0.4, 8.0]], 1e-14);
    // x reaches 4.99 of 5, y 1.9 of 2.
    assert!((free.legs[3].clearance - 0.01).abs() < 1e-14, "{:?}", free.legs[3]);
    for beside in [[-1.9, 0.0, 8.0], [-3.6, 0.0, 8.0], [-2.19, 0.6, 8.0], [-2.19, -0.6, 8.0]] {
        let refused = plan("disassemble", DEEP, MALE, &goal(beside)).unwrap_err();
        assert_eq!(refused.code, ErrorCode::WallInTheWay, "{beside:?}");
    }
}

#[test]
fn places_in_space_have_three_coordinates() {
    for (field, more) in [
        ("start.position", r#", "start": {"position": [0, 0]}"#),
        ("goal.position", r#", "goal": {"position": [0, 9]}"#),
        ("frames.fixed.position", r#", "frames": {"fixed": {"position": [0, 0], "heading": 0}}"#),
    ] {
        let refused = plan("disassemble", DEEP, MALE, more).unwrap_err();
        assert_eq!(
            (refused.code, refused.field.as_deref()),
            (ErrorCode::InvalidScene, Some(field))
        );
    }
}

prop_compose! {
    fn pose()(
        at in prop::array::uniform3(-3.0..3.0_f64), heading in -4.0..4.0_f64,
    ) -> Pose {
        Pose { at, heading }
    }
}

/// A box as the frame of the moving part sees it, for a pose of that in the fixed part's frame by
/// quarter turns.
fn drawn([min, max]: [Point; 2], place: &Pose) -> [Point; 2] {
    let back = Pose { at: [0.0; 3], heading: -place.heading };
    let [a, b] =
        [min, max].map(|corner| back.turn([0, 1, 2].map(|axis| corner[axis] - place.at[axis])));
    [[0, 1, 2].map(|axis| a[axis].min(b[axis])), [0, 1, 2].map(|axis| a[axis].max(b[axis]))]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Whatever the frames, the motion relative to the fixed part is the same, and the samples are it as
    /// the moving fixed part carries it: evenly with the length of the path.
    #[test]
    fn frames_in_space_carry_the_motion(
        fixed in pose(),
        at_end in pose(),
        origin in prop::array::uniform3(-3.0..3.0_f64),
        quarters in -1..3_i32,
        from in prop::array::uniform3(-0.4..0.4_f64),
        to in (-3.0..3.0_f64, -3.0..3.0_f64, 4.0..6.0_f64),
        takes_apart in any::<bool>(),
    ) {
        let (from, to) = ([from[0], from[1], from[2].abs()], [to.0, to.1, to.2]);
        let task = if takes_apart { "disassemble" } else { "assemble" };
        let (start, goal) = if takes_apart { (from, to) } else { (to, from) };
        let sampling = r#", "sampling": {"period": 0.01}"#;
        let ends = |start: Point, goal: Point| format!(
            r#", "start": {{"position": {start:?}}}, "goal": {{"position": {goal:?}}} {sampling}"#
        );
        let plain = plan(task, SHAFT, PIN, &ends(start, goal)).unwrap();

        // The moving part's frame in the fixed part's, in the assembled state.
        let assembled = Pose { at: origin, heading: f64::from(quarters) * FRAC_PI_2 };
        let then = if takes_apart { fixed } else { at_end };
        let moving = Pose { at: then.out(origin), heading: then.heading + assembled.heading };
        let frames = format!(
            r#"{}, "frames": {{"fixed": {}, "fixed_at_end": {}, "moving": {}, "samples": "base"}}"#,
            ends(fixed.out(sum(origin, start)), at_end.out(sum(origin, goal))),
            fixed.json(), at_end.json(), moving.json(),
        );
        let found = plan(task, SHAFT, drawn(PIN, &assembled), &frames).unwrap();
        assert_near(&way_points(&found), &way_points(&plain), 1e-12);
        prop_assert!((found.clearance.value - plain.clearance.value).abs() < 1e-12);

        prop_assert_eq!(found.samples.len(), plain.samples.len());
        let turned = difference(at_end.heading, fixed.heading);
        let (mut along, mut before) = (0.0, plain.samples[0].position);
        for (there, here) in plain.samples.iter().zip(&found.samples) {
            along += distance(before, there.position);
            before = there.position;
            let part = along / plain.length;
            let carried = Pose {
                at: [0, 1, 2].map(|axis| fixed.at[axis] + part * (at_end.at[axis] - fixed.at[axis])),
                heading: fixed.heading + part * turned,
            };
            let expected = carried.out(sum(origin, there.position));
            prop_assert!(distance(here.position, expected) < 1e-9, "{:?} for {:?}", here, expected);
            let heading = carried.heading + assembled.heading;
            prop_assert!(difference(here.heading, heading).abs() < 1e-9, "{:?} {}", here, heading);
            prop_assert!((here.t - there.t).abs() < 1e-9);
        }
        // Velocities and yaw rates are what places and headings change by.
        for pair in found.samples.windows(2) {
            let (a, b) = (&pair[0], &pair[1]);
            let dt = b.t - a.t;
            for axis in 0..3 {
                let moved = b.position[axis] - a.position[axis];
                let mean = 0.5 * (a.velocity[axis] + b.velocity[axis]);
                prop_assert!((moved - mean * dt).abs() < 2e-2 * dt + 1e-9, "{:?} {:?}", a, b);
            }
            let mean = 0.5 * (a.yaw_rate + b.yaw_rate);
            let turned = difference(b.heading, a.heading);
            prop_assert!((turned - mean * dt).abs() < 2e-2 * dt + 1e-9, "{:?} {:?}", a, b);
        }
    }
}
