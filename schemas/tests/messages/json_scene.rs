//! Scenes as people write them: all forms, and what is said of wrong ones.

use proptest::prelude::*;
use schemas::json;
use schemas::message::{
    Body, Choice, ClearanceWish, Digest, Direction, ErrorCode, Footprint, Gap, Goal, Limits, Pose,
    Report, Sampling, SceneRequest, Solid, StartTurn, Task, Vector,
};

use super::examples::{SCENES, SECTION_4, scene};

/// A scene in which one field is replaced or added (`value` is JSON).
fn with(field: &str, value: &str) -> String {
    let mut fields = vec![
        ("id", "7"),
        ("task", "\"disassemble\""),
        ("free_space", r#"{"channels": [{"min": [4, 1], "max": [7, 6]}]}"#),
        ("body", r#"{"polygon": [[4.5, 1], [4.5, 4], [6.5, 4]]}"#),
        ("clearance", r#"{"gap": 0.2}"#),
    ];
    match fields.iter_mut().find(|(name, _)| *name == field) {
        Some(known) => known.1 = value,
        None => fields.push((field, value)),
    }
    let fields: Vec<_> =
        fields.iter().map(|(name, value)| format!("\"{name}\": {value}")).collect();
    format!("{{ {} }}", fields.join(", "))
}

#[track_caller]
fn check<T: PartialEq + std::fmt::Debug>(
    field: &str,
    value: &str,
    read: impl FnOnce(SceneRequest) -> T,
    expected: T,
) {
    let read = read(json::read_scene(&with(field, value)).unwrap());
    assert_eq!(read, expected, "{field}: {value}");
}

#[test]
fn section_4_is_read() {
    let read = scene(SECTION_4);
    let channels = read.free_space.channels.unwrap();
    assert_eq!((read.id, read.task), (Some(7), Task::Disassemble));
    assert_eq!(channels.len(), 3);
    assert_eq!(channels[2].max, [5.0, 7.0].into());
    assert!(read.free_space.in_order);
    let polygon: Vec<Vector> =
        vec![[4.5, 1.01].into(), [4.5, 4.0].into(), [6.99, 4.0].into(), [6.99, 1.01].into()];
    assert_eq!(read.body, Body::Polygon(polygon));
    assert_eq!(read.clearance, ClearanceWish::Gap(Gap::Uniform(0.2)));
    let limits = Limits { speed: Some(1.0), acceleration: Some(0.5), ..Limits::default() };
    assert_eq!(read.limits, limits);
    assert_eq!(read.sampling, Some(Sampling::Period(0.02)));
    assert_eq!((read.exit, read.start, read.goal), (Vec::new(), None, None));
}

#[test]
fn recorded_scenes_are_read_and_written() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/scenes");
    let mut scenes = 0;
    for file in std::fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "json") {
            continue;
        }
        let text = std::fs::read_to_string(path).unwrap();
        if !text.contains("free_space") {
            // Goes with a map.
            continue;
        }
        let read = scene(&text);
        let written: serde_json::Value = serde_json::from_str(&json::scene_to_json(&read)).unwrap();
        let given: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(in_floats(written), in_floats(given));
        scenes += 1;
    }
    assert!(scenes > 0);
}

/// 1 and 1.0 are one number.
fn in_floats(value: serde_json::Value) -> serde_json::Value {
    use serde_json::Value;
    match value {
        Value::Number(number) => Value::from(number.as_f64()),
        Value::Array(list) => list.into_iter().map(in_floats).collect(),
        Value::Object(fields) => {
            fields.into_iter().map(|(name, value)| (name, in_floats(value))).collect()
        }
        other => other,
    }
}

#[test]
fn scenes_are_written_as_people_would() {
    let written = json::scene_to_json(&scene(SCENES[3].1));
    assert_eq!(
        written,
        concat!(
            r#"{"id":1,"task":"drive","free_space":{"channels":[{"min":[0.0,0.0],"max":"#,
            r#"[3.0,20.0]},{"min":[0.0,17.0],"max":[20.0,20.0]}],"in_order":true},"#,
            r#""body":{"footprint":{"width":1.0,"length":1.5}},"#,
            r#""start":{"position":[1.5,2.0],"heading":1.5707963267948966},"#,
            r#""goal":{"position":[18.0,18.5],"heading":-0.25},"start_turn":"while_moving","#,
            r#""clearance":{"gaps":[0.2]},"limits":{"speed":2.0,"acceleration":1.0,"#,
            r#""yaw_rate":0.5,"yaw_acceleration":0.75,"lateral_acceleration":0.25}}"#,
        )
    );
    for (name, text) in SCENES {
        let read = scene(text);
        assert_eq!(scene(&json::scene_to_json(&read)), read, "{name}");
    }
}

#[test]
fn clearances_in_all_forms() {
    let wish = |scene: SceneRequest| scene.clearance;
    let check = |text: &str, expected| check("clearance", text, wish, expected);
    let (one, uniform) = (|gap: f64| Gap::PerAxis([gap].into()), Gap::Uniform);
    let two = |x: f64, z: f64| Gap::PerAxis([x, z].into());
    check(r#"{"gap": 0.2}"#, ClearanceWish::Gap(uniform(0.2)));
    check(r#"{"gap": 1}"#, ClearanceWish::Gap(uniform(1.0)));
    check(r#"{"gap": -1}"#, ClearanceWish::Gap(uniform(-1.0)));
    check(r#"{"gap": [0.1, 0.2]}"#, ClearanceWish::Gap(two(0.1, 0.2)));
    check(r#"{"gap": [1, 2, 3]}"#, ClearanceWish::Gap(Gap::PerAxis([1.0, 2.0, 3.0].into())));
    let gaps = ClearanceWish::Gaps(vec![two(0.1, 0.2), two(0.1, 0.3)]);
    check(r#"{"gaps": [[0.1, 0.2], [0.1, 0.3]]}"#, gaps);
    check(r#"{"gaps": [[0.2], [0.3]]}"#, ClearanceWish::Gaps(vec![one(0.2), one(0.3)]));
    check(r#"{"gaps": [0.2, 0.3]}"#, ClearanceWish::Gaps(vec![uniform(0.2), uniform(0.3)]));
    check(r#"{"gaps": [0.2, [0.3]]}"#, ClearanceWish::Gaps(vec![uniform(0.2), one(0.3)]));
    check(r#"{"gaps": []}"#, ClearanceWish::Gaps(Vec::new()));
    check(r#""safest""#, ClearanceWish::Safest);
    let each = vec![Choice::Gap(uniform(0.01)), Choice::Gap(uniform(2.0)), Choice::Safest];
    check(r#"{"each": [0.01, 2, "safest"]}"#, ClearanceWish::Each(each));
    let each = vec![
        Choice::Gap(two(0.1, 0.2)),
        Choice::Gap(uniform(0.5)),
        Choice::Gaps(vec![uniform(0.1), two(0.1, 0.2)]),
    ];
    let text = r#"{"each": [[0.1, 0.2], {"gap": 0.5}, {"gaps": [0.1, [0.1, 0.2]]}]}"#;
    check(text, ClearanceWish::Each(each));
    check(r#"{"curve": 9}"#, ClearanceWish::Curve(9));
    check(r#"{"at_least": 0.25}"#, ClearanceWish::AtLeast(0.25));
    let each = vec![Choice::AtLeast(0.0), Choice::Gap(uniform(0.5)), Choice::AtLeast(1.0)];
    check(r#"{"each": [{"at_least": 0}, 0.5, {"at_least": 1}]}"#, ClearanceWish::Each(each));
}

#[test]
fn other_fields_in_all_forms() {
    let exits = |scene: SceneRequest| scene.exit;
    check("exit", "\"-x\"", exits, vec![Direction::MinusX]);
    let three = vec![Direction::PlusZ, Direction::MinusY, Direction::PlusX];
    check("exit", r#"["+z", "-y", "+x"]"#, exits, three);
    check("exit", "[]", exits, vec![]);
    check("exit", "null", exits, vec![]);
    let sampling = |scene: SceneRequest| scene.sampling;
    check("sampling", r#"{"period": 0.5}"#, sampling, Some(Sampling::Period(0.5)));
    check("sampling", r#"{"spacing": 1}"#, sampling, Some(Sampling::Spacing(1.0)));
    check("sampling", r#"{"count": 50}"#, sampling, Some(Sampling::Count(50)));
    let turn = |scene: SceneRequest| scene.start_turn;
    check("start_turn", "\"in_place\"", turn, Some(StartTurn::InPlace));
    check("start_turn", "\"while_moving\"", turn, Some(StartTurn::WhileMoving));
    let pose = Pose { position: [1.0, 2.0].into(), heading: -7.5 };
    let text = r#"{"position": [1, 2], "heading": -7.5}"#;
    check("start", text, |scene| scene.start, Some(pose));
    let goal = Goal { position: pose.position, heading: Some(-7.5) };
    check("goal", text, |scene| scene.goal, Some(goal));
    let goal = Goal { heading: None, ..goal };
    check("goal", r#"{"position": [1, 2]}"#, |scene| scene.goal, Some(goal));
    check("goal", r#"{"position": [1, 2], "heading": null}"#, |scene| scene.goal, Some(goal));
    let footprint = Body::Footprint(Footprint::Centered { width: 1.0, length: 1.5 });
    let text = r#"{"footprint": {"width": 1.0, "length": 1.5}}"#;
    check("body", text, |scene| scene.body, footprint);
    let text = r#"{"box": {"max": [1, 2, 3], "min": [0, 0, 0]}}"#;
    let corners = |body| match body {
        Body::Box(sides) => Some((sides.min, sides.max)),
        _ => None,
    };
    let expected = Some(([0.0; 3].into(), [1.0, 2.0, 3.0].into()));
    check("body", text, |scene| corners(scene.body), expected);
    check("id", "18446744073709551615", |scene| scene.id, Some(u64::MAX));
    check("id", "null", |scene| scene.id, None);
    check("deadline", "1e-3", |scene| scene.deadline, Some(0.001));
    check("limits", "{}", |scene| scene.limits, Limits::default());
    check("task", "\"assemble\"", |scene| scene.task, Task::Assemble);
    check("task", "\"dr\\u0069ve\"", |scene| scene.task, Task::Drive);
    let text = r#"{"solids": [{"polygon": []}], "bounds": {"min": [0, 0], "max": [8, 7]}}"#;
    check(
        "free_space",
        text,
        |scene| {
            let space = scene.free_space;
            (space.channels, space.in_order, space.solids, space.bounds.map(|bounds| bounds.max))
        },
        (None, false, Some(vec![Solid::Polygon(Vec::new())]), Some([8.0, 7.0].into())),
    );
}

#[test]
fn robots_in_all_forms() {
    check("reverse", "true", |scene| scene.reverse, Some(true));
    check("reverse", "false", |scene| scene.reverse, Some(false));
    check("reverse", "null", |scene| scene.reverse, None);
    check("turn_in_place", "false", |scene| scene.turn_in_place, Some(false));
    check("min_turn_radius", "1", |scene| scene.min_turn_radius, Some(1.0));
    check("turn_cost", "0.5", |scene| scene.turn_cost, Some(0.5));
    check("stop_cost", "0", |scene| scene.stop_cost, Some(0.0));
    check("report", "\"full\"", |scene| scene.report, Some(Report::Full));
    let offset = Body::Footprint(Footprint::Offset { width: 1.0, front: 1.5, rear: 0.0 });
    let text = r#"{"footprint": {"width": 1, "front": 1.5, "rear": 0}}"#;
    check("body", text, |scene| scene.body, offset.clone());
    let text = r#"{"footprint": {"width": 1, "front": 1.5, "rear": 0, "length": null}}"#;
    check("body", text, |scene| scene.body, offset);
}

#[test]
fn free_spaces_by_name() {
    let digits = "00ff".repeat(16);
    let named = |text: &str| format!(r#"{{"named": "{text}"}}"#);
    let name = Digest(std::array::from_fn(|byte| if byte % 2 == 1 { 0xff } else { 0 }));
    for digits in [&digits, &digits.to_uppercase()] {
        check("free_space", &named(digits), |scene| scene.free_space.named, Some(name));
    }
    let written = json::scene_to_json(&scene(&with("free_space", &named(&digits))));
    assert!(written.contains(&format!(r#""free_space":{{"named":"{digits}"}}"#)), "{written}");
    for (text, said) in [
        ("0f".to_owned(), "the text \"0f\"".to_owned()),
        (
            digits.replace("ff", "fg"),
            format!("the text \"{}…\"", &digits.replace("ff", "fg")[..60]),
        ),
        (digits.clone() + "0", format!("the text \"{}…\"", &digits[..60])),
    ] {
        let must = "free_space.named must be a text of 64 hexadecimal digits, not";
        check_refused(
            &with("free_space", &named(&text)),
            "free_space.named",
            &format!("{must} {said}"),
        );
    }
}

#[test]
fn a_footprint_has_one_form() {
    for other in ["front", "rear"] {
        let text = format!(r#"{{"footprint": {{"width": 1, "length": 2, "{other}": 1}}}}"#);
        let message = format!(
            "body.footprint.length does not go with `{other}`; give either `length`, or `front` and \
             `rear`"
        );
        check_refused(&with("body", &text), "body.footprint.length", &message);
    }
}

/// Refused with the field and these words; the id is echoed.
#[track_caller]
fn check_refused(text: &str, field: &str, message: &str) {
    let unreadable = json::read_scene(text).unwrap_err();
    assert_eq!(unreadable.id, Some(7), "{text}");
    check_said(unreadable, field, message);
}

#[track_caller]
fn check_said(unreadable: json::UnreadableScene, field: &str, message: &str) {
    let refusal = unreadable.refusal;
    assert_eq!(refusal.code, ErrorCode::InvalidScene);
    assert_eq!((refusal.field.as_deref(), refusal.message.as_str()), (Some(field), message));
}

#[test]
fn unknown_fields_are_named() {
    let check = |field: &str, value: &str, path: &str, known: &str| {
        let known: Vec<_> = known.split(' ').map(|name| format!("`{name}`")).collect();
        let message = format!("{path} is not a known field; expected one of {}", known.join(", "));
        check_refused(&with(field, value), path, &message);
    };
    let scene = "id task free_space body exit start goal start_turn reverse turn_in_place \
                 min_turn_radius turn_cost stop_cost report clearance limits sampling deadline \
                 frames corners stop_at_joints path";
    check("colour", "1", "colour", scene);
    check("", "1", "scene.\"\"", scene);
    check(&"x".repeat(99), "1", &format!("{}…", "x".repeat(60)), scene);
    let space = "channels in_order solids bounds named";
    check("free_space", r#"{"chanels": []}"#, "free_space.chanels", space);
    let channels = r#"{"channels": [{"min": [4, 1], "max": [7, 6]}, {"min": [4, 1], "mid": 1}]}"#;
    check("free_space", channels, "free_space.channels[1].mid", "min max half_spaces");
    let solids = r#"{"solids": [{"circle": 1}]}"#;
    check("free_space", solids, "free_space.solids[0].circle", "polygon box half_spaces boxes");
    let bounds = r#"{"bounds": {"least": 1}}"#;
    check("free_space", bounds, "free_space.bounds.least", "min max half_spaces");
    check("body", r#"{"circle": 1}"#, "body.circle", "polygon box half_spaces footprint boxes");
    let body = r#"{"footprint": {"width": 1, "depth": 1}}"#;
    check("body", body, "body.footprint.depth", "width length front rear");
    check("body", r#"{"box": {"mid": 1}}"#, "body.box.mid", "min max half_spaces");
    check("start", r#"{"position": [1, 2], "yaw": 1}"#, "start.yaw", "position heading");
    check("goal", r#"{"yaw": 1}"#, "goal.yaw", "position heading");
    check("clearance", r#"{"gap_": 1}"#, "clearance.gap_", "gap gaps each curve at_least");
    let each = r#"{"each": [0.2, {"curve": 1}]}"#;
    check("clearance", each, "clearance.each[1].curve", "gap gaps at_least");
    let limits = "speed acceleration yaw_rate yaw_acceleration lateral_acceleration jerk yaw_jerk";
    check("limits", r#"{"snap": 1}"#, "limits.snap", limits);
    let frames = "fixed fixed_at_end moving samples";
    check("frames", r#"{"part": 1}"#, "frames.part", frames);
    check("sampling", r#"{"step": 1}"#, "sampling.step", "period spacing count");
}

#[test]
fn missing_fields_are_named() {
    let check = |text: &str, path: &str| check_refused(text, path, &format!("{path} is missing"));
    check("{\"id\": 7}", "task");
    check("{\"id\": 7, \"task\": \"drive\"}", "free_space");
    check(&with("body", "null"), "body");
    check(&with("clearance", "null"), "clearance");
    let channels = r#"{"channels": [{"min": [4, 1], "max": [7, 6]}, {"min": [4, 1]}]}"#;
    check(&with("free_space", channels), "free_space.channels[1].max");
    check(&with("free_space", r#"{"bounds": {}}"#), "free_space.bounds.min");
    check(&with("body", r#"{"footprint": {"width": 1}}"#), "body.footprint.length");
    check(&with("body", r#"{"footprint": {"width": 1, "front": 1}}"#), "body.footprint.rear");
    check(&with("body", r#"{"footprint": {"width": 1, "rear": 1}}"#), "body.footprint.front");
    let start = with("start", r#"{"position": [1, 2]}"#);
    check(&start.replacen("disassemble", "drive", 1), "start.heading");
    check(&with("frames", r#"{"samples": "base"}"#), "frames.fixed");
    check(&with("body", r#"{"boxes": [{"min": [0, 0]}]}"#), "body.boxes[0].max");
    check(&with("goal", r#"{"heading": 1}"#), "goal.position");
}

#[test]
fn one_of_several_fields_is_asked_for() {
    let check = |field: &str, value: &str, path: &str, known: &str, found: &str| {
        let known: Vec<_> = known.split(' ').map(|name| format!("`{name}`")).collect();
        let known = known.join(", ");
        let message = format!("{path} must have exactly one of {known}, but has {found}");
        check_refused(&with(field, value), path, &message);
    };
    check("body", "{}", "body", "polygon box half_spaces footprint boxes", "none");
    let two = r#"{"polygon": [], "box": 1}"#;
    check("body", two, "body", "polygon box half_spaces footprint boxes", "`polygon` and `box`");
    let solids = r#"{"solids": [{}]}"#;
    check("free_space", solids, "free_space.solids[0]", "polygon box half_spaces boxes", "none");
    let two = r#"{"gap": 1, "curve": 3}"#;
    check("clearance", two, "clearance", "gap gaps each curve at_least", "`gap` and `curve`");
    let each = r#"{"each": [{}]}"#;
    check("clearance", each, "clearance.each[0]", "gap gaps at_least", "none");
    check("sampling", "{}", "sampling", "period spacing count", "none");
    let two = r#"{"count": 1, "period": 1}"#;
    check("sampling", two, "sampling", "period spacing count", "`count` and `period`");
}

#[test]
fn fields_given_twice_are_refused() {
    let check = |text: &str, path: &str| {
        check_refused(text, path, &format!("{path} is given twice"));
    };
    check("{\"id\": 7, \"id\": 8}", "id");
    check("{\"id\": 7, \"deadline\": null, \"deadline\": 1}", "deadline");
    check("{\"id\": 7, \"exit\": [], \"exit\": null}", "exit");
    check(&with("body", r#"{"box": {"min": [1, 2], "min": [1, 2]}}"#), "body.box.min");
    check(&with("body", r#"{"box": 1, "box": 2}"#), "body.box");
    check(&with("limits", r#"{"speed": 1, "\u0073peed": 1}"#), "limits.speed");
}

#[test]
fn wrong_types_are_refused() {
    let check = |field: &str, value: &str, path: &str, must: &str| {
        check_refused(&with(field, value), path, &format!("{path} must be {must}"));
    };
    let tasks = r#"one of "disassemble", "assemble", "drive", not"#;
    check("task", "\"fly\"", "task", &format!("{tasks} the text \"fly\""));
    check("task", "3", "task", &format!("{tasks} 3"));
    let space = "an object with `channels`, `in_order`, `solids`, `bounds`, `named`, not";
    check("free_space", "[]", "free_space", &format!("{space} an empty list"));
    check("free_space", r#"{"channels": 1}"#, "free_space.channels", "a list, not 1");
    let in_order = "free_space.in_order";
    check("free_space", r#"{"in_order": 1}"#, in_order, "true or false, not 1");
    let sides = "an object with `min`, `max`, `half_spaces`, not a list of 2";
    let pair = r#"{"channels": [[[1, 2], [3, 4]]]}"#;
    check("free_space", pair, "free_space.channels[0]", sides);
    let body = "an object with one of `polygon`, `box`, `half_spaces`, `footprint`, `boxes`, not";
    check("body", "\"box\"", "body", &format!("{body} the text \"box\""));
    check("body", r#"{"polygon": 1}"#, "body.polygon", "a list, not 1");
    let points = "a list of 2 or 3 numbers, not";
    check("body", r#"{"polygon": [[1]]}"#, "body.polygon[0]", &format!("{points} a list of 1"));
    let four = r#"{"polygon": [[1, 2], [1, 2, 3, 4]]}"#;
    check("body", four, "body.polygon[1]", &format!("{points} a list of 4"));
    check("body", r#"{"polygon": [{}]}"#, "body.polygon[0]", &format!("{points} an object"));
    let text = r#"{"polygon": [[1, "2"]]}"#;
    check("body", text, "body.polygon[0][1]", "a number, not the text \"2\"");
    check("body", r#"{"polygon": [[null, 2]]}"#, "body.polygon[0][0]", "a number, not null");
    check("deadline", "\"1s\"", "deadline", "a number, not the text \"1s\"");
    check("deadline", "\"NaN\"", "deadline", "a number, not the text \"NaN\"");
    check("limits", r#"{"speed": true}"#, "limits.speed", "a number, not true");
    let exits = r#"one of "+x", "-x", "+y", "-y", "+z", "-z""#;
    check("exit", r#"["+z", 3]"#, "exit[1]", &format!("{exits}, not 3"));
    let exits = format!("{exits} or a list of these, not");
    check("exit", "\"up\"", "exit", &format!("{exits} the text \"up\""));
    check("exit", "{}", "exit", &format!("{exits} an object"));
    check("reverse", "1", "reverse", "true or false, not 1");
    check("report", "\"all\"", "report", "\"full\", not the text \"all\"");
    check("min_turn_radius", "true", "min_turn_radius", "a number, not true");
    check("start_turn", "1", "start_turn", "one of \"in_place\", \"while_moving\", not 1");
    let wish =
        "\"safest\" or an object with one of `gap`, `gaps`, `each`, `curve`, `at_least`, not";
    check("clearance", "0.2", "clearance", &format!("{wish} 0.2"));
    check("clearance", "\"safe\"", "clearance", &format!("{wish} the text \"safe\""));
    let gap = "a number or a list of 1 to 3 numbers, not";
    check("clearance", r#"{"gap": "1"}"#, "clearance.gap", &format!("{gap} the text \"1\""));
    check("clearance", r#"{"gaps": [{}]}"#, "clearance.gaps[0]", &format!("{gap} an object"));
    let several = "a list of 1 to 3 numbers, not";
    check("clearance", r#"{"gap": []}"#, "clearance.gap", &format!("{several} an empty list"));
    let four = r#"{"each": [[1, 2, 3, 4]]}"#;
    check("clearance", four, "clearance.each[0]", &format!("{several} a list of 4"));
    let choice = "a gap (a number or a list of 1 to 3 numbers), \"safest\", or an object with one of \
                  `gap`, `gaps`, `at_least`, not";
    check("clearance", r#"{"each": [true]}"#, "clearance.each[0]", &format!("{choice} true"));
    let count = format!("a whole number from 0 to {}, not", u64::MAX);
    check("clearance", r#"{"curve": 2.5}"#, "clearance.curve", &format!("{count} 2.5"));
    check("sampling", r#"{"count": -3}"#, "sampling.count", &format!("{count} -3"));
    let long = format!("\"{}\"", "é".repeat(100));
    check(
        "deadline",
        &long,
        "deadline",
        &format!("a number, not the text \"{}…\"", "é".repeat(30)),
    );
}

#[test]
fn ids_that_are_no_u64_are_refused() {
    let check = |id: &str, said: &str| {
        let unreadable = json::read_scene(&with("id", id)).unwrap_err();
        assert_eq!(unreadable.id, None);
        let message = format!("id must be a whole number from 0 to {}, not {said}", u64::MAX);
        check_said(unreadable, "id", &message);
    };
    check("\"7\"", "the text \"7\"");
    check("-1", "-1");
    check("7.0", "7.0");
    check("18446744073709551616", "1.8446744073709552e19");
    check("[7]", "a list of 1");
}

#[test]
fn texts_that_are_no_json_are_refused() {
    let check = |text: &str, message: &str| {
        let unreadable = json::read_scene(text).unwrap_err();
        check_said(
            unreadable,
            message.split_once(": invalid").map_or("scene", |(field, _)| field),
            message,
        );
    };
    check("", "invalid JSON at line 1, column 0: EOF while parsing a value");
    check("{", "invalid JSON at line 1, column 1: EOF while parsing an object");
    check("nonsense", "invalid JSON at line 1, column 2: expected ident");
    check("{\"id\": 1,}", "invalid JSON at line 1, column 10: trailing comma");
    check("{\n\"id\": NaN}", "id: invalid JSON at line 2, column 7: expected value");
    check(
        "{\"deadline\": 1e999}",
        "deadline: invalid JSON at line 1, column 18: number out of range",
    );
    check(
        "{\"free_space\": {\"channels\": [{\"min\": [4, -1e400]}]}}",
        "free_space.channels[0].min[1]: invalid JSON at line 1, column 47: number out of range",
    );
    check(
        "{\"body\": {\"polygon\": [[1, 2], [3 4]]}}",
        "body.polygon[1]: invalid JSON at line 1, column 34: expected `,` or `]`",
    );
}

#[test]
fn what_surrounds_a_scene_is_refused() {
    let text = with("deadline", "1");
    let column = text.len() + 2;
    let said = format!("invalid JSON at line 1, column {column}: unexpected text after the scene");
    check_refused(&format!("{text} {{}}"), "scene", &said);
    let said = "invalid JSON: the text begins with a byte order mark; save it without one";
    check_refused(&format!("\u{feff}{text}"), "scene", said);
    assert!(json::read_scene(&format!(" \r\n\t{text}\n\n")).is_ok());
    let list = json::read_scene("[7]").unwrap_err();
    assert_eq!(list.id, None);
    assert!(list.refusal.message.ends_with("`path`, not a list of 1"), "{list:?}");
    assert!(list.refusal.message.starts_with("scene must be an object with `id`, `task`"));
}

#[test]
fn deep_nesting_is_refused() {
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let deep = format!("{}1{}", open.repeat(100_000), close.repeat(100_000));
        let unreadable = json::read_scene(&with("deadline", &deep)).unwrap_err();
        assert_eq!(unreadable.id, Some(7));
        let refusal = unreadable.refusal;
        assert!(refusal.message.contains("recursion limit exceeded"), "{}", refusal.message);
        let field = refusal.field.unwrap();
        assert!(field.starts_with("deadline") && field.len() <= 203, "{field}");
    }
}

#[test]
fn the_id_is_echoed_from_whatever_follows_it() {
    let check = |text: &str, id| assert_eq!(json::read_scene(text).unwrap_err().id, id, "{text}");
    check("{\"id\": 5, \"task\": ", Some(5));
    check("{\"id\": 5, \"task\": nonsense, \"id\": 6", Some(5));
    check("{\"task\": {\"id\": 4}, \"id\": 5}", Some(5));
    check("{\"task\": 1e999, \"id\": 5}", Some(5));
    check("{\"id\": 5", Some(5));
    check("{\"id\"", None);
    check("{\"\\u0069d\": 5}", Some(5));
    check("[{\"id\": 5}]", None);
}

proptest! {
    /// No answer speaks of how this program is written.
    #[test]
    fn messages_speak_of_the_scene(
        field in prop::sample::select(&["task", "free_space", "body", "exit", "start", "goal",
            "start_turn", "reverse", "turn_in_place", "min_turn_radius", "turn_cost", "stop_cost",
            "report", "clearance", "limits", "sampling", "deadline"][..]),
        value in prop::sample::select(&["1", "-1", "0.5", "true", "\"x\"", "[]", "[[]]", "{}",
            "[1]", "[{}]", "{\"polygon\": {}}", "{\"min\": 1}", "{\"gap\": {}}"][..]),
    ) {
        if let Err(unreadable) = json::read_scene(&with(field, value)) {
            let refusal = unreadable.refusal;
            prop_assert_eq!(unreadable.id, Some(7));
            for word in ["variant", "untagged", "struct", "enum", "u64", "f64", "unit", "sequence"] {
                prop_assert!(!refusal.message.contains(word), "{}", refusal.message);
            }
            prop_assert!(refusal.field.unwrap().starts_with(field), "{}", refusal.message);
        }
    }
}
