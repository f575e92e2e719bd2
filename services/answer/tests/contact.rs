//! Contact is not penetration: parts may touch, and no solid may stand in their way.

use answer::{Caps, reply_to};
use schemas::json::read_scene;
use schemas::message::{ErrorCode, Refusal, Request, RequestContent, RequestKey, Trajectory};

/// The only answer to a scene for a body that leaves `channels` (JSON; none: made) between
/// `solids`.
fn answer(channels: Option<&str>, solids: &str, body: &str) -> Result<Trajectory, Refusal> {
    let channels = channels.map_or(String::new(), |channels| {
        format!(r#""channels": [{channels}], "in_order": true, "#)
    });
    let scene = read_scene(&format!(
        r#"{{ "task": "disassemble", "free_space": {{ {channels}"solids": [{solids}] }},
            "body": {body}, "clearance": {{ "gap": 0.1 }} }}"#
    ));
    let content = RequestContent::Scene(scene.unwrap());
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    reply_to(&request, &Caps::default()).answers?.remove(0)
}

#[track_caller]
fn check_touches(channels: Option<&str>, solids: &str, body: &str, wall: &[f64]) {
    let trajectory = answer(channels, solids, body).unwrap();
    let near = trajectory.clearance;
    assert_eq!((near.value, near.at), (0.0, 0.0));
    assert_eq!(near.wall.as_slice(), wall);
    assert!(trajectory.length > 0.0);
}

#[track_caller]
fn check_refused(channels: Option<&str>, solids: &str, body: &str) {
    let refusal = answer(channels, solids, body).unwrap_err();
    assert_eq!(refusal.code, ErrorCode::WallInTheWay, "{refusal:?}");
    assert_eq!((refusal.needs, refusal.has), (Some(0.0), Some(0.0)), "{refusal:?}");
}

/// A part with a hole from (0, 0) to (2, 5), open at the top.
const HOLE: &str = r#"{"polygon": [[-1,-1], [3,-1], [3,5], [2,5], [2,0], [0,0], [0,5], [-1,5]]}"#;

const CHANNEL: Option<&str> = Some(r#"{"min": [0,0], "max": [2,5]}"#);

#[test]
fn peg_that_stands_on_the_floor_of_its_hole_is_taken_out() {
    let peg = r#"{"box": {"min": [0.5,0], "max": [1.5,3]}}"#;
    check_touches(CHANNEL, HOLE, peg, &[1.0, 0.0]);
    check_touches(None, HOLE, peg, &[1.0, 0.0]);
    let pointed = r#"{"polygon": [[1,0], [1.5,1], [1.5,3], [0.5,3], [0.5,1]]}"#;
    check_touches(CHANNEL, HOLE, pointed, &[1.0, 0.0]);
    check_touches(None, HOLE, pointed, &[1.0, 0.0]);
}

#[test]
fn peg_that_lies_at_the_wall_of_its_hole_is_taken_out() {
    let peg = r#"{"box": {"min": [0,0.5], "max": [1.5,3]}}"#;
    check_touches(CHANNEL, HOLE, peg, &[0.0, 1.75]);
    check_touches(None, HOLE, peg, &[0.0, 1.75]);
}

#[test]
fn peg_on_the_floor_of_a_hole_in_space_is_taken_out() {
    let channel = Some(r#"{"min": [0,0,0], "max": [2,2,5]}"#);
    let floor = r#"{"box": {"min": [-1,-1,-1], "max": [3,3,0]}}"#;
    let peg = r#"{"box": {"min": [0.5,0.5,0], "max": [1.5,1.5,3]}}"#;
    check_touches(channel, floor, peg, &[1.0, 1.0, 0.0]);
    let stone = r#", {"box": {"min": [1,1,4], "max": [3,3,6]}}"#;
    check_refused(channel, &format!("{floor}{stone}"), peg);
}

#[test]
fn corner_on_a_slanted_solid_is_taken_away() {
    let channel = Some(r#"{"min": [0,0], "max": [2,4]}"#);
    let slope = r#"{"polygon": [[1,-1], [3,1], [3,-1]]}"#;
    check_touches(channel, slope, r#"{"box": {"min": [1,0], "max": [2,1]}}"#, &[2.0, 0.0]);
    // With coordinates that are rounded.
    let channel = Some(r#"{"min": [0,0.1], "max": [0.7,2.1]}"#);
    let slope = r#"{"polygon": [[0.6,-0.2], [0.8,0.4], [0.8,-0.2]]}"#;
    let body = r#"{"box": {"min": [0.3,0.1], "max": [0.7,0.6]}}"#;
    let near = answer(channel, slope, body).unwrap().clearance;
    assert!(near.value < 1e-15, "{near:?}");
}

#[test]
fn solid_in_a_channel_is_in_the_way() {
    let peg = r#"{"box": {"min": [0.5,0], "max": [1.5,1]}}"#;
    for stone in [
        // In the body's way, touched by it, around the channel, around the body.
        r#"{"box": {"min": [1,3], "max": [3,4]}}"#,
        r#"{"box": {"min": [1.5,3], "max": [3,4]}}"#,
        r#"{"polygon": [[1.5,4], [3,3], [3,5]]}"#,
        r#"{"box": {"min": [-1,-1], "max": [9,9]}}"#,
        r#"{"box": {"min": [0.2,-0.2], "max": [1.8,1.2]}}"#,
    ] {
        check_refused(CHANNEL, stone, peg);
    }
}

#[test]
fn solid_in_a_channel_that_the_body_does_not_touch_is_not_in_the_way() {
    let peg = r#"{"box": {"min": [0.5,0], "max": [1.5,1]}}"#;
    let stone = r#"{"box": {"min": [1.75,3], "max": [3,4]}}"#;
    assert_eq!(answer(CHANNEL, stone, peg).unwrap().clearance.value, 0.25);
}

#[test]
fn solid_beyond_the_mouth_is_in_the_way() {
    let peg = r#"{"box": {"min": [0.5,0], "max": [1.5,3]}}"#;
    let lid = r#"{"box": {"min": [0,7], "max": [2,9]}}"#;
    check_refused(CHANNEL, &format!("{HOLE}, {lid}"), peg);
    let just_above = r#"{"box": {"min": [0,8], "max": [2,9]}}"#;
    check_touches(CHANNEL, &format!("{HOLE}, {just_above}"), peg, &[1.0, 0.0]);
}
