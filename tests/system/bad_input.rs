//! What can't be planned is refused by name, with both numbers, and harms nobody.

use std::time::Instant;

use integration_tests::{LONG, TestDomain, scene, scene_text};
use schemas::message::{ClearanceWish, ErrorCode, Gap, Refusal, RequestKey, SceneRequest, Vector};
use schemas::{convert, wire};
use serde_json::{Value, json};

use crate::read::recording;

/// A scene that can't be planned, and what is said of it.
struct Case {
    line: String,
    code: &'static str,
    field: Option<&'static str>,
    /// What the message says: both numbers, where there are two.
    says: &'static [&'static str],
}

/// Section 4 with `value` at `place`, a JSON pointer; without it where `value` is null.
fn scene_with(place: &str, value: Value) -> String {
    let mut scene: Value = serde_json::from_str(&scene_text("disassemble.json")).unwrap();
    // One wish, so that a refused answer is the reply.
    scene["clearance"] = json!({"gap": 0.2});
    let (parent, name) = place.rsplit_once('/').unwrap();
    match scene.pointer_mut(parent).unwrap() {
        Value::Object(fields) => fields.insert(name.to_owned(), value),
        Value::Array(items) => {
            Some(std::mem::replace(&mut items[name.parse::<usize>().unwrap()], value))
        }
        other => panic!("{other} has no {name}"),
    };
    scene.to_string()
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut case = |line: String, code, field, says| cases.push(Case { line, code, field, says });
    let invalid = "invalid_scene";

    case(
        r#"{"id": 7, nonsense"#.to_owned(),
        invalid,
        Some("scene"),
        &["invalid JSON at line 1, column 11"],
    );
    case("[7]".to_owned(), invalid, Some("scene"), &["must be an object", "not a list of 1"]);
    case("{}".to_owned(), invalid, Some("task"), &["task is missing"]);
    let nan = scene_with("/clearance", json!({"gap": 0.5})).replace("0.5}", "NaN}");
    case(nan, invalid, Some("clearance.gap"), &["invalid JSON", "expected value"]);
    let infinite = scene_with("/clearance", json!({"gap": 0.5})).replace("0.5}", "1e999}");
    case(infinite, invalid, Some("clearance.gap"), &["number out of range"]);

    case(
        scene_with("/colour", json!(1)),
        invalid,
        Some("colour"),
        &["colour is not a known field"],
    );
    let field = Some("limits.sped");
    case(
        scene_with("/limits/sped", json!(1)),
        invalid,
        field,
        &["limits.sped is not a known field", "`speed`"],
    );
    case(scene_with("/task", json!("fly")), invalid, Some("task"), &["must be one of", "\"fly\""]);

    let inverted = json!({"min": [8, 2], "max": [7, 6]});
    let field = Some("free_space.channels[1]");
    case(scene_with("/free_space/channels/1", inverted), invalid, field, &["min 8", "max 7"]);
    let flat = json!({"box": {"min": [8, 2], "max": [9, 2]}});
    let field = Some("free_space.solids[0].box");
    case(scene_with("/free_space/solids/0", flat), invalid, field, &["min 2", "max 2"]);

    let polygon = |vertices: Value| scene_with("/body/polygon", vertices);
    let field = Some("body.polygon");
    case(polygon(json!([[5, 2], [6, 2]])), invalid, field, &["2 vertices", "at least 3"]);
    let crossing = json!([[4.5, 1.5], [6, 3], [6, 1.5], [4.5, 3]]);
    case(polygon(crossing), invalid, field, &["edges 0 and 2", "cross"]);
    let space = json!([[4.5, 2], [5, 2, 1], [5, 3]]);
    let says = &["3 coordinates", "points have 2"];
    case(polygon(space), invalid, Some("body.polygon[1]"), says);

    let field = Some("free_space.channels");
    let says = &["0 channels", "at least 1"];
    case(scene_with("/free_space/channels", json!([])), invalid, field, says);
    let apart = json!({"min": [1, 6.5], "max": [7, 8]});
    let field = Some("free_space.channels[1]");
    let says = &["channels 0 and 1 do not overlap along z", "ends at 6 m", "begins at 6.5 m"];
    case(scene_with("/free_space/channels/1", apart), invalid, field, says);

    let mut gap = |gap: Value, says| {
        let line = scene_with("/clearance", json!({"gap": gap}));
        let code = "gap_out_of_range";
        cases.push(Case { line, code, field: Some("clearance.gap"), says });
    };
    gap(json!(0), &["a gap of 0 m at junction 0 along x", "greater than 0 m", "0.255"]);
    gap(json!(-0.1), &["a gap of -0.1 m at junction 0 along x", "greater than 0 m", "0.255"]);
    gap(json!(0.5), &["a gap of 0.5 m at junction 0 along x", "less than 0.255"]);
    gap(json!([0.1, 0.6]), &["a gap of 0.6 m at junction 0 along z", "less than 0.505"]);
    let mut case = |line: String, code, field, says| cases.push(Case { line, code, field, says });
    let gaps = scene_with("/clearance", json!({"gaps": [0.1]}));
    case(gaps, invalid, Some("clearance.gaps"), &["1 gap ", "2 junctions"]);

    let low = json!({"min": [1, 2], "max": [7, 4.5]});
    let says = &["junction 0 is 2.5 m wide along z", "more than 2.99 m"];
    case(scene_with("/free_space/channels/1", low), "junction_too_small", None, says);
    let outside = json!([[3.5, 1.01], [3.5, 4], [6, 4], [6, 1.01]]);
    let says = &["reaches 3.5 m along x", "ends at 4 m"];
    case(polygon(outside), "body_outside_free_space", None, says);

    let code = "too_many_samples";
    let says = &["2000002 samples", "the limit is 1000000"];
    case(scene_with("/sampling", json!({"count": 2_000_000})), code, None, says);
    let field = Some("sampling.period");
    case(
        scene_with("/sampling", json!({"period": 0})),
        invalid,
        field,
        &["is 0 s", "greater than 0"],
    );
    let says = &["is -1 m/s", "between 1e-9 and 1e12"];
    case(scene_with("/limits/speed", json!(-1)), invalid, Some("limits.speed"), says);
    case(scene_with("/deadline", json!(-1)), invalid, Some("deadline"), &["greater than 0", "-1"]);
    cases
}

#[test]
fn each_bad_scene_is_refused_by_name_and_the_next_is_planned() {
    let test = TestDomain::new();
    let planner = test.planner(&[]);
    let recorder = test.recorder("run.mcap", &[]);
    let good = scene_with("/id", json!(7));
    let cases = cases();
    let lines: Vec<_> = cases.iter().flat_map(|case| [&*case.line, &*good]).collect();
    let lines = lines.join("\n");

    let planned = test.plan_lines(&lines);
    assert_eq!(planned.code, Some(1), "a scene was refused");
    let replies: Vec<_> = planned.stdout.lines().collect();
    assert_eq!(replies.len(), 2 * cases.len());
    for (case, reply) in cases.iter().zip(replies.chunks(2)) {
        let refused: Value = serde_json::from_str(reply[0]).unwrap();
        let error = &refused["error"];
        assert_eq!(error["code"], case.code, "{reply:?}");
        assert_eq!(error["field"].as_str(), case.field, "{reply:?}");
        let message = error["message"].as_str().unwrap();
        assert!(case.says.iter().all(|said| message.contains(said)), "{message}: {:?}", case.says);
        let planned: Value = serde_json::from_str(reply[1]).unwrap();
        assert_eq!(planned["id"], 7);
        assert!(planned["trajectories"][0]["length"].is_number(), "{}", reply[1]);
    }
    let good = test.plan_lines(&good);
    assert_eq!((good.code, good.stdout.trim_end()), (Some(0), replies[1]));

    assert_eq!(recorder.stop().code, Some(0), "no message was lost");
    let replayed = test.run("replay", &["check", "run.mcap"]);
    assert_eq!(replayed.code, Some(0), "{replayed:?}");
    assert_eq!(planner.stop().code, Some(0));
}

/// Refusals on the bus of what JSON can't say.
struct Raw {
    test: TestDomain,
}

impl Raw {
    /// Sends memory as it is, after `change`; how it is refused.
    fn refusal(
        &self,
        scene: &SceneRequest,
        change: impl FnOnce(&mut wire::RequestHeader, &mut Vec<u64>),
    ) -> Refusal {
        let client = self.test.connect();
        let mut cells = Vec::new();
        let mut header =
            convert::write_scene(scene, RequestKey::default(), bus::now_ns(), &mut cells).unwrap();
        change(&mut header, &mut cells);
        let mut pending = client.send_cells(header, &cells).unwrap();
        let reply = pending.wait(Instant::now() + LONG).unwrap();
        assert!(client.call(&crate::bad_input::good(), LONG).unwrap().answers.is_ok());
        reply.answers.expect_err("it is refused")
    }

    #[track_caller]
    fn check_number(&self, scene: &SceneRequest, field: &str, says: &str) {
        let refusal = self.refusal(scene, |_, _| {});
        assert_eq!(refusal.code, ErrorCode::InvalidScene, "{refusal:?}");
        assert_eq!(refusal.field.as_deref(), Some(field), "{refusal:?}");
        assert!(refusal.message.contains(says), "{refusal:?}");
    }

    #[track_caller]
    fn check_memory(
        &self,
        says: &str,
        change: impl FnOnce(&mut wire::RequestHeader, &mut Vec<u64>),
    ) {
        let refusal = self.refusal(&good(), change);
        assert_eq!(refusal.code, ErrorCode::InvalidScene, "{refusal:?}");
        assert_eq!(refusal.field.as_deref(), Some("request"), "{refusal:?}");
        assert!(refusal.message.contains(says), "{refusal:?}");
    }
}

fn good() -> SceneRequest {
    scene("disassemble-channels.json")
}

#[test]
fn what_json_cannot_say_is_refused_as_well() {
    let raw = Raw { test: TestDomain::new() };
    let planner = raw.test.planner(&[]);
    let recorder = raw.test.recorder("run.mcap", &[]);

    for (value, says) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (f64::NEG_INFINITY, "-inf")] {
        let mut scene = good();
        scene.limits.speed = Some(value);
        raw.check_number(&scene, "limits.speed", says);
        let mut scene = good();
        scene.deadline = Some(value);
        raw.check_number(&scene, "deadline", says);
        let mut scene = good();
        scene.free_space.channels.as_mut().unwrap()[2].max = [5.0, value].into();
        raw.check_number(&scene, "free_space.channels[2]", says);
        let mut scene = good();
        let corners: [[f64; 2]; 3] = [[4.5, 1.01], [4.5, value], [6.99, 1.01]];
        scene.body = schemas::message::Body::Polygon(corners.map(Vector::from).to_vec());
        raw.check_number(&scene, "body.polygon", says);
        let mut scene = good();
        scene.sampling = Some(schemas::message::Sampling::Period(value));
        raw.check_number(&scene, "sampling.period", says);
        let mut scene = good();
        scene.clearance = ClearanceWish::Gap(Gap::Uniform(value));
        let refusal = raw.refusal(&scene, |_, _| {});
        assert_eq!(refusal.code, ErrorCode::GapOutOfRange, "{refusal:?}");
        assert!(refusal.message.contains(says), "{refusal:?}");
    }

    let refusal = raw.refusal(&good(), |header, _| header.version += 1);
    assert_eq!(refusal.code, ErrorCode::UnsupportedVersion);
    let version = f64::from(schemas::wire::VERSION);
    assert_eq!((refusal.has, refusal.needs), (Some(version + 1.0), Some(version)));
    raw.check_memory("dimension", |header, _| header.dimension = 9);
    raw.check_memory("task", |header, _| header.task = 7);
    raw.check_memory("given", |header, _| header.given = u64::MAX);
    raw.check_memory("channels", |header, _| header.channels = u64::MAX);
    raw.check_memory("body", |header, _| header.body_points = u64::MAX / 2);
    raw.check_memory("solids", |header, _| header.solids = 1 << 60);
    raw.check_memory("cells", |_, cells| cells.push(0));
    raw.check_memory("channels", |_, cells| cells.truncate(cells.len() - 1));
    raw.check_memory("choice", |_, cells| cells[0] = 99);

    assert_eq!(recorder.stop().code, Some(0), "no message was lost");
    assert_eq!(planner.stop().code, Some(0));
    // What is no scene is kept as it came, and refused again.
    let asked = recording(&raw.test.path("run.mcap")).requests().len();
    let replayed = raw.test.run("replay", &["check", "run.mcap"]);
    assert_eq!(replayed.stdout, format!("run.mcap: {asked} requests, {asked} equal\n"));
    assert_eq!(replayed.code, Some(0));
}
