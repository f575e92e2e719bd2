//! Refusals when there is no route: what would open one, and by how much it is too small.

use answer::{Caps, reply_to};
use schemas::json::read_scene;
use schemas::message::{ErrorCode, Refusal, Request, RequestContent, RequestKey};

/// Junction, axis, what is needed and what there is.
type Numbers = (Option<u64>, Option<u32>, Option<f64>, Option<f64>);

fn refusal(scene: &str) -> Refusal {
    let content = RequestContent::Scene(read_scene(scene).unwrap());
    let reply =
        reply_to(&Request { key: RequestKey::default(), sent_ns: 0, content }, &Caps::default());
    reply.answers.expect_err("there is no route")
}

#[track_caller]
fn check(scene: &str, code: ErrorCode, numbers: Numbers, message: &str) {
    let refusal = refusal(scene);
    assert_eq!(refusal.message, message);
    assert_eq!(refusal.code, code);
    assert_eq!((refusal.junction, refusal.axis, refusal.needs, refusal.has), numbers);
}

/// The same of what lies in a solid.
#[track_caller]
fn check_in_solid(scene: &str, code: ErrorCode, field: &str, depth: f64, message: &str) {
    let refusal = refusal(scene);
    assert_eq!(refusal.message, message);
    assert_eq!((refusal.code, refusal.field.as_deref()), (code, Some(field)));
    assert_eq!((refusal.has, refusal.most), (Some(depth), Some(0.0)));
}

fn solid<const D: usize>(min: [f64; D], max: [f64; D]) -> String {
    format!(r#"{{"box": {{"min": {min:?}, "max": {max:?}}}}}"#)
}

/// A robot of 0.75 m x 2 m, which needs R(0) = 1.25 m to turn, on a floor of 8 m x 6 m.
fn drive(solids: &str, start: [f64; 2], goal: [f64; 2], clearance: &str) -> String {
    format!(
        r#"{{"task": "drive", "free_space": {{"solids": [{solids}],
        "bounds": {{"min": [0, 0], "max": [8, 6]}}}},
        "body": {{"footprint": {{"width": 0.75, "length": 2}}}},
        "start": {{"position": {start:?}, "heading": 0}}, "goal": {{"position": {goal:?}}},
        "clearance": {clearance}}}"#
    )
}

const WIDE: &str = r#"{"gap": 0.125}"#;

/// A wall of 0.25 m, with a door from y = 2 on.
fn wall_with_door(width: f64) -> String {
    solid([4., 0.], [4.25, 2.]) + ", " + &solid([4., 2. + width], [4.25, 6.])
}

/// The female part of section 4 with a neck that reaches to some x, and a box for a male part.
fn disassemble(neck: f64, lid: &str, exit: &str, min: [f64; 2], max: [f64; 2]) -> String {
    format!(
        r#"{{"task": "disassemble", "free_space": {{"solids": [{{"polygon": [[0, 0], [0, 7],
        [1, 7], [1, 2], [4, 2], [4, 1], [7, 1], [7, 6], [{neck}, 6], [{neck}, 7], [8, 7],
        [8, 0]]}}{lid}]}}, "body": {{"box": {{"min": {min:?}, "max": {max:?}}}}},
        "exit": {exit}, "clearance": {{"gap": 0.125}}}}"#
    )
}

const UP: &str = r#""+z""#;
const ROOM: [f64; 2] = [4.25, 1.25];

#[test]
fn narrow_door_is_named() {
    let scene = drive(&wall_with_door(0.5), [2., 5.], [6., 1.], r#""safest""#);
    let numbers = (None, None, Some(0.75), Some(0.5));
    let message = "no route: the widest way leads between (4, 2.5) and (4, 2), which are 0.5 m \
                   apart; the robot needs more than 0.75 m";
    check(&scene, ErrorCode::NoRoute, numbers, message);
}

#[test]
fn widest_of_several_doors_is_named() {
    let walls = [
        solid([4., 0.], [4.25, 1.]),
        solid([4., 1.25], [4.25, 3.]),
        solid([4., 3.75], [4.25, 5.]),
        solid([4., 5.5], [4.25, 6.]),
    ];
    let scene = drive(&walls.join(", "), [2., 2.], [6., 2.], r#""safest""#);
    let numbers = (None, None, Some(0.75), Some(0.75));
    let message = "no route: the widest way leads between (4, 3) and (4, 3.75), which are 0.75 m \
                   apart; the robot needs more than 0.75 m";
    check(&scene, ErrorCode::NoRoute, numbers, message);
}

#[test]
fn narrower_of_two_doors_in_a_row_is_named() {
    let first = wall_with_door(0.75);
    let second = solid([5.75, 0.], [6., 4.]) + ", " + &solid([5.75, 4.5], [6., 6.]);
    let scene = drive(&format!("{first}, {second}"), [2., 5.], [7., 1.], r#""safest""#);
    let numbers = (None, None, Some(0.75), Some(0.5));
    let message = "no route: the widest way leads between (5.75, 4) and (5.75, 4.5), which are \
                   0.5 m apart; the robot needs more than 0.75 m";
    check(&scene, ErrorCode::NoRoute, numbers, message);
}

#[test]
fn door_wide_enough_but_for_the_gap_is_a_matter_of_the_gap() {
    let door = wall_with_door(1.5);
    let scene = drive(&door, [2., 5.], [6., 1.], r#"{"gap": 0.5}"#);
    let refused = refusal(&scene);
    assert_eq!(refused.code, ErrorCode::GapOutOfRange);
    // Half of what the door is wider than the robot.
    let numbers = (refused.has, refused.least, refused.most);
    assert_eq!(numbers, (Some(0.5), Some(0.0), Some(0.375)));
    assert_eq!(
        refused.message,
        "no route: the widest way leads between (4, 3.5) and (4, 2), which are 1.5 m apart; the \
         robot is 0.75 m wide, so the gap must be less than 0.375 m, not 0.5 m"
    );
}

#[test]
fn wall_is_named_with_its_thickness() {
    let wall = solid([1., 5.], [2., 6.]) + ", " + &solid([4., 0.], [4.25, 6.]);
    let scene = drive(&wall, [2., 3.], [6., 3.], WIDE);
    let numbers = (None, None, Some(0.0), Some(-0.25));
    let message = "no route: walls enclose the goal; they are thinnest from (4, 6) to (4.25, 6), \
                   0.25 m, and an opening there must be wider than 0.75 m";
    check(&scene, ErrorCode::NoRoute, numbers, message);
}

#[test]
fn start_and_goal_without_room_are_told() {
    let door = wall_with_door(0.5);
    let numbers = (None, None, None, None);
    let message = "start: the robot touches the wall at (4, 1.875)";
    let scene = drive(&door, [4.125, 2.25], [6., 1.], WIDE);
    check(&scene, ErrorCode::BodyOutsideFreeSpace, numbers, message);
    let message = "goal: the robot would touch the wall at (4, 1.875)";
    let scene = drive(&door, [6., 1.], [4.125, 2.25], WIDE)
        .replace(r#""goal": {"#, r#""goal": {"heading": 0, "#);
    check(&scene, ErrorCode::GoalOutsideFreeSpace, numbers, message);
    // Arriving with any heading, there is no way.
    let numbers = (None, None, Some(1.0), Some(0.5));
    let message = "no route: the widest way leads between (4.25, 2) and (4.25, 2.5), which are \
                   0.5 m apart; the robot needs more than 1 m";
    let scene = drive(&door, [6., 1.], [4.125, 2.25], WIDE);
    check(&scene, ErrorCode::NoRoute, numbers, message);
}

#[test]
fn start_and_goal_in_a_solid_or_out_of_bounds_are_told() {
    let door = wall_with_door(0.5);
    let scene = drive(&door, [4.125, 1.], [6., 1.], WIDE);
    let message =
        "start.position is inside solid 0, 0.125 m from its nearest side; it must be outside";
    let field = "free_space.solids[0]";
    check_in_solid(&scene, ErrorCode::BodyOutsideFreeSpace, field, 0.125, message);
    let scene = drive(&door, [6., 1.], [4.125, 3.], WIDE);
    let message =
        "goal.position is inside solid 1, 0.125 m from its nearest side; it must be outside";
    let field = "free_space.solids[1]";
    check_in_solid(&scene, ErrorCode::GoalOutsideFreeSpace, field, 0.125, message);
    let scene = drive(&door, [6., 1.], [6., 6.5], WIDE);
    let message =
        "goal.position is outside free_space.bounds: they end at y = 6 m, but it is at y = 6.5 m";
    let numbers = (None, Some(1), Some(6.5), Some(6.0));
    check(&scene, ErrorCode::GoalOutsideFreeSpace, numbers, message);
}

#[test]
fn body_in_a_solid_is_told() {
    let scene = disassemble(5., "", UP, [3.75, 1.25], [6.75, 4.]);
    let message = "the body's bounding box reaches 0.25 m into solid 0 along x; at most 0 m is \
                   allowed";
    let field = "free_space.solids[0]";
    check_in_solid(&scene, ErrorCode::BodyOutsideFreeSpace, field, 0.25, message);
}

#[test]
fn narrow_place_within_a_part_is_named() {
    let scene = disassemble(5., "", UP, ROOM, [6.75, 5.5]);
    let numbers = (Some(0), Some(2), Some(4.25), Some(4.0));
    let message = "no route: the passage from (x 1, z 2) to (x 7, z 6) is 4 m wide along z, but \
                   must be wider than 4.25 m";
    check(&scene, ErrorCode::NoRoute, numbers, message);
}

#[test]
fn narrow_mouth_is_named() {
    let scene = disassemble(3., "", UP, ROOM, [6.75, 4.]);
    let numbers = (Some(1), Some(0), Some(2.5), Some(2.0));
    let message = "no route: the passage from (x 1, z 6) to (x 3, z 7) is 2 m wide along x, but \
                   must be wider than 2.5 m";
    check(&scene, ErrorCode::NoRoute, numbers, message);
}

#[test]
fn what_closes_the_mouth_is_named() {
    let lid = ", ".to_owned() + &solid([1., 6.5], [5., 7.]);
    let scene = disassemble(5., &lid, UP, ROOM, [6.75, 4.]);
    let numbers = (Some(2), Some(2), Some(0.0), Some(-0.5));
    let message = "no route: from (x 1, z 6.5) to (x 5, z 7) a wall of solid 1, 0.5 m thick along \
                   z, separates start and end; an opening through it must be wider than 2.5 m \
                   along x";
    check(&scene, ErrorCode::NoRoute, numbers, message);
    // Of several exits the first is explained where none does.
    let exits = r#"["+z", "+x"]"#;
    let scene = disassemble(5., &lid, exits, ROOM, [6.75, 4.]);
    check(&scene, ErrorCode::NoRoute, numbers, message);
}

#[test]
fn narrow_place_in_space_is_named() {
    // A room below, a room above, and a hole of 1 m x 0.75 m in the floor between.
    let with_hole = [
        solid([0., 0., 2.], [1.5, 4., 2.5]),
        solid([2.5, 0., 2.], [4., 4., 2.5]),
        solid([1.5, 0., 2.], [2.5, 1., 2.5]),
        solid([1.5, 1.75, 2.], [2.5, 4., 2.5]),
    ];
    let scene = |solids: &[String]| {
        format!(
            r#"{{"task": "disassemble", "free_space": {{"solids": [{}],
            "bounds": {{"min": [0, 0, 0], "max": [4, 4, 5]}}}}, "exit": "+z",
            "body": {{"box": {{"min": [0.25, 0.25, 0.25], "max": [1.125, 1.125, 1.25]}}}},
            "clearance": "safest"}}"#,
            solids.join(", ")
        )
    };
    let numbers = (Some(0), Some(1), Some(0.875), Some(0.75));
    let message = "no route: the passage from (x 1.5, y 1, z 2) to (x 2.5, y 1.75, z 2.5) is 0.75 \
                   m wide along y, but must be wider than 0.875 m";
    check(&scene(&with_hole), ErrorCode::NoRoute, numbers, message);
    let numbers = (Some(0), Some(2), Some(0.0), Some(-0.5));
    let message = "no route: from (x 0, y 0, z 2) to (x 4, y 4, z 2.5) a wall of solid 0, 0.5 m \
                   thick along z, separates start and end; an opening through it must be wider \
                   than 0.875 m along x and 0.875 m along y";
    check(&scene(&[solid([0., 0., 2.], [4., 4., 2.5])]), ErrorCode::NoRoute, numbers, message);
}

#[test]
fn channels_that_are_apart_are_named() {
    let scene = r#"{"task": "disassemble", "free_space": {"channels": [
        {"min": [0, 0], "max": [9, 2]}, {"min": [5, 2.25], "max": [8, 9]}]},
        "body": {"box": {"min": [1, 0.5], "max": [2, 1.5]}}, "clearance": "safest"}"#;
    let numbers = (Some(0), Some(2), Some(1.0), Some(-0.25));
    let message = "no route: channels 0 and 1 are 0.25 m apart along z; a route would open if \
                   they overlapped by more than 1 m";
    check(scene, ErrorCode::NoRoute, numbers, message);
}

#[test]
fn wall_behind_many_pillars_is_named() {
    let count = 40;
    let place = |index: usize, other: usize| 3.0 * index as f64 + 0.125 * (other % 5) as f64 + 1.0;
    let pillars = (0..count * count).map(|index| {
        let (i, j) = (index / count, index % count);
        let min = [place(i, 7 * i + 3 * j), place(j, 5 * i + 11 * j)];
        solid(min, min.map(|at| at + 1.0))
    });
    let solids: Vec<_> = pillars.chain([solid([70., 0.], [70.25, 128.])]).collect();
    let scene = drive(&solids.join(", "), [1.5, 0.5], [126., 127.5], r#""safest""#)
        .replace("[8, 6]", "[128, 128]");
    let refusal = refusal(&scene);
    assert_eq!(refusal.code, ErrorCode::NoRoute, "{refusal:?}");
    assert!(refusal.message.contains("they are thinnest from (70"), "{refusal:?}");
    assert_eq!(refusal.has, Some(-0.25));
}

#[test]
fn channels_wide_enough_but_for_the_gap_are_a_matter_of_the_gap() {
    let scene = |gap: f64| {
        format!(
            r#"{{"task": "drive", "free_space": {{"channels": [{{"min": [0, 0], "max": [9, 2]}},
            {{"min": [7, 0], "max": [8.5, 9]}}]}},
            "body": {{"footprint": {{"width": 0.75, "length": 2}}}},
            "start": {{"position": [2, 1], "heading": 0}}, "goal": {{"position": [7.75, 6]}},
            "clearance": {{"each": [{gap}, 0.125]}}}}"#
        )
    };
    let content = RequestContent::Scene(read_scene(&scene(0.5)).unwrap());
    let reply =
        reply_to(&Request { key: RequestKey::default(), sent_ns: 0, content }, &Caps::default());
    let answers = reply.answers.expect("an answer to each");
    let refused = answers[0].as_ref().expect_err("too large a gap");
    assert_eq!(refused.code, ErrorCode::GapOutOfRange);
    assert_eq!((refused.has, refused.most), (Some(0.5), Some(0.375)));
    assert!(answers[1].is_ok(), "{:?}", answers[1].as_ref().err());
}
