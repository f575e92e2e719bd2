//! Non-finite and huge numbers in a search for a route end in a reply, without delay.

use answer::{Caps, reply_to};
use schemas::json::read_scene;
use schemas::message::{
    Choice, ClearanceWish, ErrorCode, Gap, Request, RequestContent, RequestKey, SceneRequest,
};

/// A robot and a part in three unordered channels whose coordinates reach `scale` metres.
fn scenes(scale: f64) -> [SceneRequest; 2] {
    let channels = format!(
        r#"[{{"min": [{0}, 0], "max": [{1}, 3]}}, {{"min": [0, 0], "max": [3, {1}]}},
        {{"min": [{0}, {2}], "max": [{1}, {1}]}}]"#,
        -scale,
        scale,
        scale - scale / 4.0
    );
    let drive = format!(
        r#"{{"task": "drive", "free_space": {{"channels": {channels}}},
        "body": {{"footprint": {{"width": 0.5, "length": 0.5}}}},
        "start": {{"position": [{0}, 1.5], "heading": 0}}, "goal": {{"position": [{0}, {1}]}},
        "clearance": {{"gap": 0.1}}, "sampling": {{"count": 2}}}}"#,
        -scale / 2.0,
        scale - scale / 8.0
    );
    let part = format!(
        r#"{{"task": "disassemble", "free_space": {{"channels": {channels}}},
        "body": {{"box": {{"min": [-5, 1], "max": [-4.5, 1.5]}}}},
        "clearance": {{"gap": 0.1}}, "sampling": {{"count": 2}}}}"#
    );
    [drive, part].map(|scene| read_scene(&scene).expect("a scene"))
}

/// The code of the first refusal, if any.
fn refused(scene: SceneRequest) -> Option<ErrorCode> {
    let content = RequestContent::Scene(scene);
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    match reply_to(&request, &Caps::default()).answers {
        Err(refusal) => Some(refusal.code),
        Ok(answers) => answers.into_iter().find_map(|answer| answer.err().map(|error| error.code)),
    }
}

#[test]
fn usual_numbers_make_a_route() {
    for scene in scenes(40.0) {
        assert_eq!(refused(scene), None);
    }
}

#[test]
fn non_finite_gaps_are_refused() {
    for scene in scenes(40.0) {
        for gap in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, 0.0, -0.1] {
            for clearance in [
                ClearanceWish::Gap(Gap::Uniform(gap)),
                ClearanceWish::Each(vec![Choice::Gap(Gap::Uniform(gap)), Choice::Safest]),
            ] {
                let code = refused(SceneRequest { clearance, ..scene.clone() });
                assert_eq!(code, Some(ErrorCode::GapOutOfRange), "{gap}");
            }
        }
    }
}

#[test]
fn huge_coordinates_are_answered() {
    // From 1e154 on squares overflow, then sums; from 1e150 on coordinates are refused.
    for scale in [1e12, 1e100, 1e154, 1e200, 1e307, 1.7e308] {
        for scene in scenes(scale) {
            for clearance in [scene.clearance.clone(), ClearanceWish::Safest] {
                refused(SceneRequest { clearance, ..scene.clone() });
            }
        }
    }
}
