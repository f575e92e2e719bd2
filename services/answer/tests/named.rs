//! Free spaces that are sent once and named from then on.

use answer::{Answerer, Caps, reply_to};
use schemas::json::{read_scene, reply_to_json};
use schemas::message::{
    Digest, ErrorCode, Reply, Request, RequestContent, RequestKey, SceneRequest,
};

fn room() -> SceneRequest {
    let text = r#"{"task": "drive", "free_space": {"solids": [
        {"polygon": [[4, 0], [4.5, 0], [5, 4], [4.5, 4]]}],
        "bounds": {"min": [0, 0], "max": [10, 6]}},
        "body": {"footprint": {"width": 0.6, "length": 0.9}},
        "start": {"position": [2, 2], "heading": 0}, "goal": {"position": [8, 2]},
        "clearance": {"gap": 0.1}}"#;
    read_scene(text).unwrap()
}

fn request(scene: SceneRequest) -> Request {
    Request { key: RequestKey::default(), sent_ns: 0, content: RequestContent::Scene(scene) }
}

fn code(reply: Reply) -> ErrorCode {
    reply.answers.expect_err("a refusal").code
}

#[test]
fn name_is_answered_as_the_free_space_itself() {
    let plain = room();
    let mut named = plain.clone();
    named.free_space.named = Some(plain.free_space.digest());
    let expected = reply_to_json(&reply_to(&request(plain), &Caps::default()));

    let mut answerer = Answerer::new(&Caps::default());
    let alone = request(named.with_name_alone());
    assert_eq!(code(answerer.reply_to(&alone)), ErrorCode::UnknownFreeSpace);
    assert_eq!(reply_to_json(&answerer.reply_to(&request(named))), expected);
    for _ in 0..3 {
        assert_eq!(reply_to_json(&answerer.reply_to(&alone)), expected);
    }
}

#[test]
fn wrong_name_is_refused_and_not_kept() {
    let mut wrong = room();
    wrong.free_space.named = Some(Digest([7; 32]));
    let mut answerer = Answerer::new(&Caps::default());
    let refusal = answerer.reply_to(&request(wrong.clone())).answers.expect_err("a refusal");
    assert_eq!(refusal.field.as_deref(), Some("free_space.named"));
    let right = wrong.free_space.digest().to_string();
    assert!(refusal.message.contains(&right), "{refusal:?}");
    let alone = request(wrong.with_name_alone());
    assert_eq!(code(answerer.reply_to(&alone)), ErrorCode::UnknownFreeSpace);
}

/// A request that is refused for another reason makes its free space known all the same.
#[test]
fn free_space_of_a_refused_request_is_known() {
    let mut named = room();
    named.free_space.named = Some(named.free_space.digest());
    let mut outside = named.clone();
    outside.goal.as_mut().unwrap().position = [80.0, 2.0].into();
    let mut answerer = Answerer::new(&Caps::default());
    assert_eq!(code(answerer.reply_to(&request(outside))), ErrorCode::GoalOutsideFreeSpace);
    assert!(answerer.reply_to(&request(named.with_name_alone())).answers.is_ok());
}
