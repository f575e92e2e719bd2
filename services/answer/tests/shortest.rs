//! The shortest way through channels in travel order, and what none is shorter than.

use answer::{Caps, reply_to};
use schemas::json::read_scene;
use schemas::message::{ErrorCode, Refusal, Request, RequestContent, RequestKey, Trajectory};

fn plan(scene: &str) -> Result<Trajectory, Refusal> {
    let content = RequestContent::Scene(read_scene(scene).unwrap());
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    reply_to(&request, &Caps::default()).answers?.remove(0)
}

/// A part that turns back in its second channel; `rest` are more fields.
fn turning_back(task: &str, rest: &str) -> String {
    format!(
        r#"{{"task": "{task}", "free_space": {{"in_order": true, "channels": [
        {{"min": [0, 0], "max": [6, 9]}}, {{"min": [0, 6], "max": [12, 9]}},
        {{"min": [2, 0], "max": [9, 9]}}]}}, "exit": "-z",
        "body": {{"box": {{"min": [2.5, 1], "max": [3.5, 2]}}}},
        "clearance": {{"gap": 0.25}}{rest}}}"#
    )
}

#[test]
fn bound_is_told_where_it_is_asked_for() {
    let rules = plan(&turning_back("disassemble", "")).unwrap();
    assert_eq!(rules.bound, None);
    assert_eq!(plan(&turning_back("disassemble", r#", "path": "rules""#)).unwrap(), rules);
    let full = plan(&turning_back("disassemble", r#", "report": "full""#)).unwrap();
    let bound = full.bound.unwrap();
    assert_eq!(Trajectory { bound: None, ..full }, rules);
    // Up to 0.25 m above z = 6, and down until all is below z = 0.
    assert!((bound - 12.5).abs() < 1e-9 && bound < rules.length, "{bound}");
    assert_eq!(plan(&turning_back("disassemble", r#", "path": "shortest""#)).unwrap().bound, None);
}

#[test]
fn shortest_way_is_as_long_as_the_bound() {
    for task in ["disassemble", "assemble"] {
        let fields = r#", "report": "full", "path": "shortest""#;
        let found = plan(&turning_back(task, fields)).unwrap();
        let bound = found.bound.unwrap();
        assert!((found.length - 12.5).abs() < 1e-9, "{}", found.length);
        assert!(bound <= found.length && found.length - bound < 1e-9, "{bound}");
        assert_eq!(found.route, [0, 1, 2]);
        assert!(found.legs.iter().all(|leg| leg.rule.is_none()));
        let legs: f64 = found.legs.iter().map(|leg| leg.length).sum();
        assert_eq!(legs, found.length);
        assert!(found.clearance.value > 0.0);
    }
}

#[test]
fn shortest_way_goes_on_to_its_goal() {
    let goal = r#", "report": "full", "path": "shortest", "goal": {"position": [1, -4]}"#;
    let found = plan(&turning_back("disassemble", goal)).unwrap();
    assert_eq!(found.samples.last().unwrap().position, [1.0, -4.0, 0.0]);
    // Mirrored in z = 5.25, the goal is at (1, 14.5).
    let expected = 211.25_f64.sqrt();
    assert!((found.length - expected).abs() < 1e-9, "{} {expected}", found.length);
    assert!(found.length - found.bound.unwrap() < 1e-9);
}

#[test]
fn shortest_ways_need_channels_in_order() {
    let check = |text: &str, field: &str| {
        let refusal = plan(text).unwrap_err();
        assert_eq!(refusal.code, ErrorCode::InvalidScene, "{}", refusal.message);
        assert_eq!(refusal.field.as_deref(), Some(field), "{}", refusal.message);
        assert!(refusal.message.contains("in travel order"), "{}", refusal.message);
    };
    for (fields, field) in
        [(r#", "path": "shortest""#, "path"), (r#", "report": "full""#, "report")]
    {
        let text = turning_back("disassemble", fields);
        check(&text.replace(r#""in_order": true, "#, ""), field);
    }
}
