//! What one request may cost: refused above, with the cap in force.

use answer::{Caps, Workspace, reply_to};
use schemas::json::read_scene;
use schemas::message::{
    Choice, ClearanceWish, ErrorCode, Gap, Refusal, Reply, Request, RequestContent, RequestKey,
    SceneRequest,
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

fn drive() -> SceneRequest {
    scene(include_str!("../../../recordings/scenes/drive-a.json"))
}

fn reply(scene: &SceneRequest, caps: &Caps) -> Reply {
    let content = RequestContent::Scene(scene.clone());
    reply_to(&Request { key: RequestKey::default(), sent_ns: 0, content }, caps)
}

/// The scene is refused under these caps for this cap, and not under the default ones.
#[track_caller]
fn check(scene: &SceneRequest, caps: Caps, code: ErrorCode, field: Option<&str>, said: &str) {
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
        assert_eq!((refusal.code, refusal.field.as_deref()), (code, field), "{refusal:?}");
        assert!(refusal.message.contains(said), "{refusal:?}");
    }
}

#[track_caller]
fn check_too_costly(scene: &SceneRequest, caps: Caps, field: Option<&str>, said: &str) {
    check(scene, caps, ErrorCode::TooCostly, field, said);
}

#[test]
fn too_many_samples_are_refused() {
    let caps = Caps { samples: 10, ..Caps::default() };
    let said = "would have 669 samples; the limit is 10 (`caps.samples`)";
    check(&channels(), caps, ErrorCode::TooManySamples, None, said);
    let refusal = reply(&channels(), &caps).answers.unwrap_err();
    assert_eq!((refusal.needs, refusal.has), (Some(669.0), Some(10.0)));
}

#[test]
fn too_many_answers_are_refused() {
    let caps = Caps { answers: 2, ..Caps::default() };
    let said = "asks for 3 answers; the number must be between 1 and 2 (`caps.answers`)";
    check_too_costly(&each(), caps, Some("clearance.each"), said);
    let none = SceneRequest { clearance: ClearanceWish::Curve(0), ..each() };
    let refusal = reply(&none, &Caps::default()).answers.unwrap_err();
    assert_eq!(refusal.code, ErrorCode::InvalidScene, "no cap is met");
    assert_eq!(refusal.field.as_deref(), Some("clearance.curve"));
}

#[test]
fn too_large_requests_are_refused() {
    let caps = Caps { cells: 20, ..Caps::default() };
    check_too_costly(&channels(), caps, Some("request"), "at most 20 are read (`caps.cells`)");
}

#[test]
fn too_many_boxes_of_solids_are_refused() {
    let caps = Caps { pieces: 2, ..Caps::default() };
    let said = "the solids are cut into more than 2 boxes (`caps.pieces`)";
    check_too_costly(&solids(), caps, Some("free_space.solids"), said);
}

#[test]
fn too_many_channels_are_refused() {
    let caps = Caps { channels: 1, ..Caps::default() };
    let said = "the solids leave more than 1 channels (`caps.channels`)";
    check_too_costly(&solids(), caps, Some("free_space.solids"), said);
    let caps = Caps { channel_steps: 1, ..Caps::default() };
    let said = "takes more than 1 steps (`caps.channel_steps`)";
    check_too_costly(&solids(), caps, Some("free_space.solids"), said);
}

#[test]
fn too_many_junctions_are_refused() {
    let caps = Caps { junctions: 2, ..Caps::default() };
    let said = "the channels have more than 2 junctions (`caps.junctions`)";
    check_too_costly(&unordered(), caps, Some("free_space"), said);
}

#[test]
fn too_long_a_search_is_refused() {
    let caps = Caps { route_steps: 1, ..Caps::default() };
    let said = "finding a route takes more than 1 steps (`caps.route_steps`)";
    check_too_costly(&unordered(), caps, Some("free_space"), said);
}

#[test]
fn too_many_steps_and_too_much_memory_are_refused() {
    for scene in [channels(), unordered(), solids(), drive()] {
        let caps = Caps { steps: 10, ..Caps::default() };
        let said = "planning takes more than 10 steps (`caps.steps`)";
        check_too_costly(&scene, caps, None, said);
        assert!(reply(&scene, &caps).answers.is_err(), "there is nothing to show");
        let caps = Caps { bytes: 100, ..Caps::default() };
        let said = "planning needs more than 100 bytes of memory (`caps.bytes`)";
        check_too_costly(&scene, caps, None, said);
    }
}

/// The least number of steps with which there is an answer to the scene.
fn least_steps(scene: &SceneRequest) -> u64 {
    let (mut too_few, mut enough) = (0, 1 << 28);
    while enough - too_few > 1 {
        let steps = (too_few + enough) / 2;
        let caps = Caps { steps, ..Caps::default() };
        *(if reply(scene, &caps).answers.is_ok() { &mut enough } else { &mut too_few }) = steps;
    }
    enough
}

#[test]
fn answers_found_before_the_steps_end_stand() {
    let gaps = [0.05, 0.1, 0.15, 0.2, 0.25].map(|gap| Choice::Gap(Gap::Uniform(gap)));
    let scene = SceneRequest { clearance: ClearanceWish::Each(gaps.to_vec()), ..unordered() };
    let whole = reply(&scene, &Caps::default()).answers.unwrap();
    let first = least_steps(&scene);
    let mut most_found = 0;
    for steps in (first..).step_by(first as usize / 8 + 1).take(64) {
        let answers = reply(&scene, &Caps { steps, ..Caps::default() }).answers.unwrap();
        let found = answers.iter().take_while(|answer| answer.is_ok()).count();
        assert_eq!(answers[..found], whole[..found]);
        for refused in &answers[found..] {
            assert_eq!(refused.as_ref().unwrap_err().code, ErrorCode::TooCostly);
        }
        assert!((1..=5).contains(&found) && answers.len() == 5);
        assert!(found >= most_found, "more steps, more answers");
        most_found = found;
    }
    assert_eq!(most_found, 5);
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
