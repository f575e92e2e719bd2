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

#[test]
fn too_many_boxes_of_solids_are_refused() {
    let caps = Caps { pieces: 2, ..Caps::default() };
    check(&solids(), caps, Some("free_space.solids[0].polygon"), "at most 2 are allowed");
}

#[test]
fn too_many_channels_are_refused() {
    let caps = Caps { channels: 1, ..Caps::default() };
    check(&solids(), caps, Some("free_space.solids"), "at most 1 are allowed");
    let caps = Caps { channel_steps: 1, ..Caps::default() };
    check(&solids(), caps, Some("free_space.solids"), "at most 1 are allowed");
}

#[test]
fn too_many_junctions_are_refused() {
    let caps = Caps { junctions: 2, ..Caps::default() };
    check(&unordered(), caps, Some("free_space.channels"), "at most 2 are allowed");
}

#[test]
fn too_long_a_search_is_refused() {
    let caps = Caps { route_steps: 1, ..Caps::default() };
    check(&unordered(), caps, Some("free_space"), "at most 1 are allowed");
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
