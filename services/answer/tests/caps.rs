//! What one request may cost: refused above, with the cap in force.

use answer::{Caps, Workspace, reply_to};
use schemas::json::read_scene;
use schemas::message::{
    ErrorCode, Refusal, Reply, Request, RequestContent, RequestKey, SceneRequest,
};

fn scene(text: &str) -> SceneRequest {
    read_scene(text).unwrap()
}

fn channels() -> SceneRequest {
    scene(include_str!("../../../recordings/scenes/disassemble-channels.json"))
}

fn unordered() -> SceneRequest {
    let mut scene = channels();
    scene.free_space.in_order = false;
    scene
}

fn solids() -> SceneRequest {
    scene(include_str!("../../../recordings/scenes/disassemble-solids.json"))
}

fn each() -> SceneRequest {
    scene(include_str!("../../../recordings/scenes/disassemble.json"))
}

fn reply(scene: &SceneRequest, caps: &Caps) -> Reply {
    let content = RequestContent::Scene(scene.clone());
    reply_to(&Request { key: RequestKey::default(), sent_ns: 0, content }, caps)
}

/// The scene is refused under these caps, for this reason, and not under the default ones.
#[track_caller]
fn check(scene: &SceneRequest, caps: Caps, field: Option<&str>, said: &str) {
    let refusals = |reply: Reply| -> Vec<Refusal> {
        match reply.answers {
            Err(refusal) => vec![refusal],
            Ok(answers) => answers.into_iter().filter_map(Result::err).collect(),
        }
    };
    assert_eq!(refusals(reply(scene, &Caps::default())), []);
    let refused = refusals(reply(scene, &caps));
    assert!(!refused.is_empty(), "nothing is refused");
    for refusal in refused {
        assert_eq!(refusal.field.as_deref(), field, "{refusal:?}");
        assert!(refusal.message.contains(said), "{refusal:?}");
    }
}

#[test]
fn too_many_samples_are_refused() {
    let caps = Caps { samples: 10, ..Caps::default() };
    check(&channels(), caps, None, "at most 10 can be had");
    let refusal = reply(&channels(), &caps).answers.unwrap_err();
    assert_eq!((refusal.code, refusal.has), (ErrorCode::TooManySamples, Some(10.0)));
}

#[test]
fn too_many_answers_are_refused() {
    let caps = Caps { answers: 2, ..Caps::default() };
    check(&each(), caps, Some("clearance.each"), "asks for 3 answers, from 1 to 2 can be had");
}

#[test]
fn too_large_requests_are_refused() {
    let caps = Caps { cells: 20, ..Caps::default() };
    check(&channels(), caps, Some("request"), "cells of memory, at most 20 are read");
}

/// The scene is too costly under these caps: this setting is met, whose value is `most`.
#[track_caller]
fn check_costly(scene: &SceneRequest, caps: Caps, field: Option<&str>, cap: &str, most: u64) {
    let setting = format!("caps.{cap}");
    check(scene, caps, field, &format!("more than {most} "));
    check(scene, caps, field, &format!("(`{setting}`)"));
    let answers = reply(scene, &caps).answers;
    for refusal in answers
        .map_or_else(|all| vec![all], |each| each.into_iter().filter_map(Result::err).collect())
    {
        assert_eq!((refusal.code, refusal.most), (ErrorCode::TooCostly, Some(most as f64)));
        // Shared memory has no place for it yet; the message has it.
        assert!(refusal.setting.is_none_or(|met| met == setting));
    }
}

#[test]
fn too_many_boxes_of_solids_are_refused() {
    let caps = Caps { pieces: 2, ..Caps::default() };
    check_costly(&solids(), caps, Some("free_space.solids[0].polygon"), "pieces", 2);
}

#[test]
fn too_many_channels_are_refused() {
    let field = Some("free_space.solids");
    check_costly(&solids(), Caps { channels: 1, ..Caps::default() }, field, "channels", 1);
    let caps = Caps { channel_steps: 1, ..Caps::default() };
    check_costly(&solids(), caps, field, "channel_steps", 1);
}

#[test]
fn too_many_junctions_are_refused() {
    let caps = Caps { junctions: 2, ..Caps::default() };
    check_costly(&unordered(), caps, Some("free_space.channels"), "junctions", 2);
}

#[test]
fn too_long_a_search_is_refused() {
    let caps = Caps { route_steps: 1, ..Caps::default() };
    check_costly(&unordered(), caps, Some("free_space"), "route_steps", 1);
}

#[test]
fn a_request_that_costs_too_much_altogether_is_refused() {
    for scene in [channels(), unordered(), solids()] {
        check_costly(&scene, Caps { steps: 5, ..Caps::default() }, None, "steps", 5);
        check_costly(&scene, Caps { bytes: 100, ..Caps::default() }, None, "bytes", 100);
    }
}

#[test]
fn answers_found_before_the_budget_ended_stay_answers() {
    let each = each();
    let count = |steps| {
        let reply = reply(&each, &Caps { steps, ..Caps::default() });
        // Too little even for what all answers share.
        let Ok(answers) = reply.answers else { return 0 };
        let found = answers.iter().take_while(|answer| answer.is_ok()).count();
        for answer in &answers[found..] {
            assert_eq!(answer.as_ref().unwrap_err().code, ErrorCode::TooCostly);
        }
        found
    };
    let found: Vec<_> = (1..600).map(count).collect();
    assert!((0..=3).all(|count| found.contains(&count)), "{found:?}");
    assert!(found.is_sorted(), "{found:?}");
}

#[test]
fn an_empty_table_is_the_defaults() {
    let caps: Caps = toml::from_str("").unwrap();
    assert_eq!(caps, Caps::default());
    let caps: Caps = toml::from_str("samples = 7").unwrap();
    assert_eq!(caps, Caps { samples: 7, ..Caps::default() });
    // A workspace has the same defaults.
    let default = format!("{:?}", Workspace::default());
    assert!(default.contains(&format!("{:?}", Caps::default())));
}
