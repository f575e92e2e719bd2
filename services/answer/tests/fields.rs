//! Fields that do not belong to the task, and numbers that are out of range.

use answer::{Caps, reply_to};
use schemas::json::{read_scene, reply_to_json};
use schemas::message::{
    ErrorCode, Refusal, Reply, Request, RequestContent, RequestKey, SceneRequest,
};

const PART: &str = r#"{ "task": "disassemble",
    "free_space": { "channels": [{ "min": [0, 0], "max": [2, 5] }], "in_order": true },
    "body": { "box": { "min": [0.5, 0.5], "max": [1.5, 3] } }, "clearance": { "gap": 0.1 } }"#;

const DRIVE: &str = r#"{ "task": "drive",
    "free_space": { "channels": [{ "min": [0, 0], "max": [10, 3] }], "in_order": true },
    "body": { "footprint": { "width": 1, "length": 1.5 } },
    "start": { "position": [2, 1.5], "heading": 0 }, "goal": { "position": [8, 1.5] },
    "clearance": { "gap": 0.2 } }"#;

/// The scene with one more field.
fn with(scene: &str, field: &str) -> SceneRequest {
    read_scene(&scene.replacen('{', &format!("{{ {field},"), 1)).unwrap()
}

fn reply(scene: SceneRequest) -> Reply {
    let content = RequestContent::Scene(scene);
    reply_to(&Request { key: RequestKey::default(), sent_ns: 0, content }, &Caps::default())
}

fn refusal(scene: SceneRequest) -> Refusal {
    reply(scene).answers.expect_err("the scene is refused")
}

#[track_caller]
fn check_stray(scene: &str, field: &str, value: &str) {
    let (outer, inner) = field.split_once('.').unwrap_or((field, ""));
    let value = match inner {
        "" => value.to_owned(),
        inner => format!(r#"{{ "{inner}": {value} }}"#),
    };
    let refusal = refusal(with(scene, &format!(r#""{outer}": {value}"#)));
    assert_eq!((refusal.code, refusal.field.as_deref()), (ErrorCode::InvalidScene, Some(field)));
    assert!(refusal.message.starts_with(&format!("{field} is not a field of")), "{refusal:?}");
}

#[test]
fn fields_of_another_task_are_refused() {
    for limit in ["yaw_rate", "yaw_acceleration", "lateral_acceleration"] {
        check_stray(PART, &format!("limits.{limit}"), "1");
    }
    check_stray(PART, "limits.yaw_jerk", "1");
    check_stray(PART, "stop_at_joints", "false");
    check_stray(DRIVE, "frames", r#"{ "fixed": { "position": [1, 1], "heading": 0 } }"#);
    check_stray(PART, "start_turn", r#""in_place""#);
    check_stray(PART, "reverse", "false");
    check_stray(PART, "turn_in_place", "true");
    check_stray(PART, "min_turn_radius", "1");
    check_stray(PART, "turn_cost", "1");
    check_stray(PART, "stop_cost", "1");
    check_stray(DRIVE, "path", r#""rules""#);
    check_stray(DRIVE, "exit", r#""+x""#);
    assert!(reply(with(PART, r#""limits": { "speed": 1, "acceleration": 1 }"#)).answers.is_ok());
    assert!(reply(with(DRIVE, r#""limits": { "yaw_rate": 1 }"#)).answers.is_ok());
}

#[track_caller]
fn check_out_of_range(scene: &str, from: &str, to: &str, field: &str) {
    let replaced = scene.replacen(from, to, 1);
    assert_ne!(replaced, scene);
    let refusal = refusal(read_scene(&replaced).unwrap());
    assert_eq!(refusal.code, ErrorCode::InvalidScene, "{refusal:?}");
    assert_eq!(refusal.field.as_deref(), Some(field));
    assert_eq!(refusal.has.map(f64::abs), Some(1e155), "{refusal:?}");
    assert_eq!((refusal.least, refusal.most), (Some(-1e150), Some(1e150)));
}

#[test]
fn coordinates_that_overflow_are_refused() {
    check_out_of_range(PART, "[2, 5]", "[2, 1e155]", "free_space.channels[0]");
    check_out_of_range(PART, "[0.5, 0.5]", "[0.5, -1e155]", "body.box");
    let polygon = PART.replace(
        r#""box": { "min": [0.5, 0.5], "max": [1.5, 3] }"#,
        r#""polygon": [[0.5, 0.5], [1.5, 0.5], [1, 3]]"#,
    );
    check_out_of_range(&polygon, "[1, 3]", "[1, 1e155]", "body.polygon[2]");
    check_out_of_range(DRIVE, "[2, 1.5]", "[1e155, 1.5]", "start.position");
    check_out_of_range(DRIVE, "[8, 1.5]", "[8, -1e155]", "goal.position");
    check_out_of_range(DRIVE, r#""length": 1.5"#, r#""length": 1e155"#, "body.footprint");
    let bounds = r#""in_order": true, "bounds": { "min": [0, 0], "max": [1e155, 9] }"#;
    check_out_of_range(DRIVE, r#""in_order": true"#, bounds, "free_space.bounds");
    let solids =
        r#""in_order": true, "solids": [{ "box": { "min": [0, 9], "max": [1e155, 10] } }]"#;
    check_out_of_range(DRIVE, r#""in_order": true"#, solids, "free_space.solids[0].box");
    let solids = r#""in_order": true, "solids": [{ "polygon": [[0, 9], [1, 9], [0, 1e155]] }]"#;
    check_out_of_range(DRIVE, r#""in_order": true"#, solids, "free_space.solids[0].polygon[2]");
}

#[test]
fn places_too_far_out_for_the_robot_are_refused() {
    let corridor = |end: &str, goal: &str| {
        let scene = DRIVE.replacen("[10, 3]", &format!("[{end}, 3]"), 1);
        let scene = scene.replacen("[8, 1.5]", &format!("[{goal}, 1.5]"), 1);
        reply(with(&scene, r#""sampling": { "count": 2 }"#))
    };
    let refusal = corridor("1e17", "8e16").answers.expect_err("it is refused");
    assert_eq!(refusal.code, ErrorCode::InvalidScene, "{refusal:?}");
    assert_eq!(refusal.field.as_deref(), Some("goal.position"));
    let numbers = (refusal.has, refusal.least, refusal.most);
    assert_eq!(numbers, (Some(8e16), Some(-1.5e12), Some(1.5e12)));
    assert!(refusal.message.contains("8e16 m is too far out"), "{refusal:?}");
    assert!(refusal.message.ends_with("between -1.5e12 m and 1.5e12 m"), "{refusal:?}");
    // A corridor may be as long as it likes.
    for (end, goal) in [("1e17", "8"), ("2e12", "1.5e12")] {
        let reply = corridor(end, goal);
        let answers = reply.answers.expect("it is answered");
        assert_eq!(answers[0].as_ref().expect("a trajectory").clearance.value, 1.0);
    }
}

#[test]
fn messages_show_huge_and_tiny_numbers_as_powers_of_ten() {
    let huge = "1e150";
    let polygon = |points: &str| {
        let body = r#""box": { "min": [0.5, 0.5], "max": [1.5, 3] }"#;
        PART.replace(body, &format!(r#""polygon": {points}"#))
    };
    let channel = |from: &str, to: &str| PART.replacen(from, to, 1);
    let refused = [
        read_scene(&polygon(&format!("[[{huge}, 0], [{huge}, 3], [{huge}, 1]]"))),
        read_scene(&polygon(&format!("[[0, 0], [{huge}, 0], [{huge}, 0], [0, 1]]"))),
        read_scene(&polygon(&format!("[[0, 0], [{huge}, {huge}], [{huge}, 0], [0, {huge}]]"))),
        read_scene(&channel("[2, 5]", &format!("[-{huge}, 5]"))),
        read_scene(&channel("[2, 5]", "[-1e-150, 5]")),
        read_scene(&DRIVE.replacen("1.5 } }", &format!("-{huge} }} }}"), 1)),
        read_scene(&DRIVE.replacen("[8, 1.5]", &format!("[8, {huge}]"), 1)),
        Ok(with(PART, r#""limits": { "speed": 1e150 }"#)),
        Ok(with(PART, r#""sampling": { "period": -1e150 }"#)),
        Ok(with(PART, r#""deadline": -1e150"#)),
        Ok(with(DRIVE, r#""turn_cost": -1e150"#)),
        Ok(with(DRIVE, r#""min_turn_radius": -1e150"#)),
    ];
    for scene in refused {
        let reply = reply(scene.expect("a scene"));
        let refusal = match reply.answers {
            Err(refusal) => refusal,
            Ok(answers) => answers[0].clone().expect_err("it is refused"),
        };
        let Refusal { message, .. } = refusal;
        let digits = |word: &str| word.chars().filter(char::is_ascii_digit).count();
        assert!(message.split(' ').all(|word| digits(word) < 20), "{message}");
        assert!(message.contains("e150") || message.contains("e-150"), "{message}");
    }
}

#[test]
fn greatest_coordinates_are_answered_in_numbers() {
    let scene = r#"{ "task": "drive", "sampling": { "count": 2 },
        "free_space": { "channels": [{ "min": [0, 0], "max": [1e150, 3e149] }], "in_order": true },
        "body": { "footprint": { "width": 1e149, "length": 1.5e149 } },
        "start": { "position": [2e149, 1.5e149], "heading": 0 },
        "goal": { "position": [8e149, 1.5e149] }, "clearance": { "gap": 2e148 } }"#;
    let reply = reply(read_scene(scene).unwrap());
    let trajectory = reply.answers.as_ref().unwrap()[0].as_ref().unwrap();
    assert_eq!(trajectory.length, 8e149 - 2e149);
    assert!(!reply_to_json(&reply).contains("null"));
}

#[test]
fn start_equal_to_goal_is_one_state() {
    let still = DRIVE.replace("[8, 1.5]", "[2, 1.5]");
    let turned = still.replace(r#""goal": {"#, r#""goal": { "heading": 0,"#);
    for scene in [&still, &turned] {
        let reply = reply(read_scene(scene).unwrap());
        let trajectory = reply.answers.as_ref().unwrap()[0].as_ref().unwrap();
        assert_eq!(trajectory.length.to_bits(), 0, "0, not -0");
        assert_eq!(trajectory.duration.to_bits(), 0);
        let [sample] = trajectory.samples[..] else { panic!("{:?}", trajectory.samples) };
        assert_eq!((sample.t, sample.position, sample.heading), (0.0, [2.0, 1.5, 0.0], 0.0));
        assert!(reply_to_json(&reply).contains(r#""length":0.0"#), "{}", reply_to_json(&reply));
    }
}
