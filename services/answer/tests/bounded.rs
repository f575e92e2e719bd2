//! No request takes longer, or more memory, than its caps allow: small scenes that would, and
//! the caps that they meet.

use answer::{Caps, reply_to};
use schemas::json::read_scene;
use schemas::message::{
    Answer, Choice, ClearanceWish, ErrorCode, Gap, Request, RequestContent, RequestKey, Sampling,
    SceneRequest,
};

/// The answers; a refused request has one.
fn answers(scene: &SceneRequest, caps: &Caps) -> Vec<Answer> {
    let content = RequestContent::Scene(scene.clone());
    let reply = reply_to(&Request { key: RequestKey::default(), sent_ns: 0, content }, caps);
    reply.answers.unwrap_or_else(|refusal| vec![Err(refusal)])
}

#[track_caller]
fn check_costly(answer: &Answer, cap: &str) {
    let refusal = answer.as_ref().expect_err("an answer, and no refusal");
    assert_eq!(refusal.code, ErrorCode::TooCostly, "{refusal:?}");
    assert_eq!(refusal.setting.as_deref(), Some(&*format!("caps.{cap}")), "{refusal:?}");
}

/// Numbers from 0 to 1, always the same.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1 << 24) as f64
    }
}

/// A robot among channels that all overlap each other: ways without number.
fn crowd(count: usize) -> SceneRequest {
    let mut next = numbers();
    let channels: Vec<_> = (0..count)
        .map(|_| {
            let [a, b, c, d] = [next(), next(), 9.0 + next(), 9.0 + next()];
            format!(r#"{{"min": [{a}, {b}], "max": [{c}, {d}]}}"#)
        })
        .collect();
    let text = format!(
        r#"{{"task": "drive", "free_space": {{"channels": [{}]}},
        "body": {{"footprint": {{"width": 1, "length": 1.5}}}},
        "start": {{"position": [2, 2], "heading": 0}}, "goal": {{"position": [8, 8]}},
        "clearance": {{"gap": 0.1}}, "sampling": {{"count": 2}}}}"#,
        channels.join(", ")
    );
    read_scene(&text).expect("a scene")
}

fn each(scene: &SceneRequest, count: u32) -> SceneRequest {
    let gaps = (0..count).map(|index| Choice::Gap(Gap::Uniform(0.05 + 1e-6 * f64::from(index))));
    SceneRequest { clearance: ClearanceWish::Each(gaps.collect()), ..scene.clone() }
}

#[test]
fn ways_without_number_take_little_memory() {
    let caps = Caps { bytes: 4 << 20, ..Caps::default() };
    let [answer] = &answers(&crowd(200), &caps)[..] else { panic!("one answer") };
    // The start and the goal are in sight of each other.
    let length = answer.as_ref().expect("an answer").length;
    assert!((length - 72_f64.sqrt()).abs() < 1e-12, "{length}");
}

#[test]
fn samples_are_bounded_together() {
    let scene = SceneRequest { sampling: Some(Sampling::Count(10_000)), ..crowd(2) };
    let caps = Caps { bytes: 2 << 20, ..Caps::default() };
    let all = answers(&each(&scene, 10), &caps);
    // 72 bytes each.
    assert_eq!(all.iter().filter(|answer| answer.is_ok()).count(), 2);
    all[2..].iter().for_each(|answer| check_costly(answer, "bytes"));
}

/// All answers draw from one budget: those that are found stand, and the others name what it
/// allows and how to stay within.
#[test]
fn answers_are_bounded_together() {
    let scene = crowd(20);
    let one = (1..24)
        .map(|power| Caps { steps: 1 << power, ..Caps::default() })
        .find(|caps| answers(&scene, caps)[0].is_ok())
        .expect("enough steps for one answer");
    // Ten answers that take about as long each.
    let scene = each(&scene, 10);
    let whole = answers(&scene, &Caps::default());
    assert!(whole.iter().all(Result::is_ok));
    let all = answers(&scene, &one);
    let found = all.iter().take_while(|answer| answer.is_ok()).count();
    assert!((1..5).contains(&found), "{found} answers");
    assert_eq!(all[..found], whole[..found]);
    let said = format!(
        "planning takes more than {} steps (`caps.steps`); ask for fewer answers, or describe the \
         free space with fewer channels or solids",
        one.steps
    );
    for answer in &all[found..] {
        check_costly(answer, "steps");
        let refusal = answer.as_ref().unwrap_err();
        assert_eq!((refusal.most, &refusal.message), (Some(one.steps as f64), &said));
    }
    // Each alone is within the budget.
    assert!(answers(&each(&crowd(20), 1), &one)[0].is_ok());
}

/// A robot that is where it is to go stays there: one sample, and a length that is 0.
#[test]
fn robot_at_its_goal_stays() {
    let channels = r#"[{"min": [0, 0], "max": [10, 3]}, {"min": [7, 0], "max": [10, 9]}]"#;
    let block = r#"[{"box": {"min": [4, 3], "max": [7, 9]}}]"#;
    for (free_space, clearance) in [
        (r#"{"channels": [{"min": [0, 0], "max": [10, 3]}], "in_order": true}"#.to_owned(), 1.2),
        (format!(r#"{{"channels": {channels}}}"#), 1.2),
        (format!(r#"{{"solids": {block}, "bounds": {{"min": [0, 0], "max": [10, 9]}}}}"#), 1.2),
    ] {
        for (goal, wish) in [("", r#"{"gap": 0.05}"#), (r#", "heading": 0"#, r#""safest""#)] {
            let text = format!(
                r#"{{"task": "drive", "free_space": {free_space},
                "body": {{"footprint": {{"width": 0.6, "length": 0.9}}}},
                "start": {{"position": [2, 1.5], "heading": 0}},
                "goal": {{"position": [2, 1.5]{goal}}}, "clearance": {wish}}}"#
            );
            let found = answers(&read_scene(&text).expect("a scene"), &Caps::default());
            let trajectory = found[0].as_ref().expect("an answer");
            assert_eq!(trajectory.length.to_bits(), 0.0_f64.to_bits(), "{text}");
            assert_eq!((trajectory.duration, trajectory.legs.len()), (0.0, 1));
            let [sample] = &trajectory.samples[..] else { panic!("{:?}", trajectory.samples) };
            assert_eq!(sample.position, [2.0, 1.5, 0.0]);
            assert_eq!([sample.t, sample.heading, sample.yaw_rate], [0.0; 3]);
            let found = trajectory.clearance.value;
            assert!((found - clearance).abs() < 1e-12, "{found}");
        }
    }
}
