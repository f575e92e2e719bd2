//! Parts and solids of any shape, and parts that fit exactly.

use answer::{Caps, reply_to};
use schemas::json::read_scene;
use schemas::message::{
    Direction, ErrorCode, Refusal, Request, RequestContent, RequestKey, Trajectory,
};

/// The only answer to a scene; `rest` is its fields after the task.
fn plan(rest: &str) -> Result<Trajectory, Refusal> {
    let scene = read_scene(&format!(r#"{{"task": "disassemble", {rest}}}"#)).unwrap();
    let content = RequestContent::Scene(scene);
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    reply_to(&request, &Caps::default()).answers?.remove(0)
}

fn solids(outlines: &str) -> String {
    format!(r#""free_space": {{"solids": [{outlines}]}}"#)
}

/// A block with a groove that widens upwards.
const GROOVE: &str = r#"{"polygon": [[0,0], [8,0], [8,3], [7,3], [5,1], [3,1], [1,3], [0,3]]}"#;

/// A block with a slot from z = 1 to z = 5, and a post on its floor.
const POST: &str = r#"{"polygon": [[0,0], [8,0], [8,5], [6,5], [6,1], [4.5,1], [4.5,2], [3.5,2],
    [3.5,1], [2,1], [2,5], [0,5]]}"#;

#[test]
fn wedge_leaves_its_groove() {
    let wedge = r#""body": {"polygon": [[3.25,1.25], [4.75,1.25], [6,2.5], [2,2.5]]}"#;
    for clearance in [r#""safest""#, r#"{"gap": 0.1}"#] {
        let found = plan(&format!(r#"{}, {wedge}, "clearance": {clearance}"#, solids(GROOVE)));
        let found = found.unwrap();
        assert_eq!((found.length, found.legs.len()), (1.75, 1), "{found:?}");
        // From (3.25, 1.25) to the line through (3, 1) and (1, 3), or from (4, 1.25) to the floor.
        assert_eq!((found.clearance.value, found.clearance.at), (0.25, 0.0));
    }
}

/// Beyond the mouth it goes on to the goal, as a part in channels does.
#[test]
fn wedge_goes_on_to_its_goal() {
    let wedge = r#""body": {"polygon": [[3.25,1.25], [4.75,1.25], [6,2.5], [2,2.5]]}"#;
    let to = |goal: &str| {
        let clearance = r#""clearance": {"gap": 0.1}"#;
        plan(&format!(
            r#"{}, {wedge}, {clearance}, "goal": {{"position": {goal}}}"#,
            solids(GROOVE)
        ))
    };
    let found = to("[3, 5.75]").unwrap();
    assert_eq!((found.length, found.legs.len()), (1.75 + 5.0, 2), "{found:?}");
    assert_eq!(found.samples.last().unwrap().position, [3.0, 5.75, 0.0]);
    assert_eq!((found.clearance.value, found.clearance.at), (0.25, 0.0));
    assert_eq!(to("[0, 5]").unwrap().legs.len(), 1);
    assert_eq!(to("[0, 1]").unwrap_err().code, ErrorCode::GoalOutsideFreeSpace);
}

#[test]
fn notched_part_is_lifted_off_a_post() {
    for (play, gap) in [(0.25, 0.125), (0.25, 0.5), (0.0, 0.1)] {
        let [a, b] = [2.0 + play, 6.0 - play];
        let [c, d] = [3.5 - play, 4.5 + play];
        let found = plan(&format!(
            r#"{}, "body": {{"polygon": [[{a},1.25], [{c},1.25], [{c},2.25], [{d},2.25], [{d},1.25],
                [{b},1.25], [{b},3], [{a},3]]}}, "clearance": {{"gap": {gap}}}"#,
            solids(POST)
        ));
        let found = found.unwrap();
        assert_eq!((found.length, found.legs.len()), (3.75, 1), "{found:?}");
        assert_eq!(found.clearance.value, play);
        assert!(
            found.legs[0].rule.is_none() && found.route.is_empty() && found.channels.is_empty()
        );
    }
}

#[test]
fn part_that_fits_exactly_slides_out() {
    let block = r#"{"box": {"min": [0,0], "max": [4,4]}}, {"box": {"min": [5,0], "max": [8,4]}}"#;
    let body = r#""body": {"box": {"min": [4,2.5], "max": [5,4]}}"#;
    for clearance in [r#""safest""#, r#"{"gap": 0.1}"#] {
        let found = plan(&format!(r#"{}, {body}, "clearance": {clearance}"#, solids(block)));
        let found = found.unwrap();
        assert_eq!((found.length, found.clearance.value), (1.5, 0.0), "{found:?}");
        assert_eq!(found.legs.len(), 1);
    }
    // A little narrower, it does not.
    let narrow = block.replace("[5,0]", "[4.999,0]").replace("[4,4]", "[4,4.0]");
    let refusal = plan(&format!(r#"{}, {body}, "clearance": "safest""#, solids(&narrow)));
    assert_eq!(refusal.unwrap_err().code, ErrorCode::BodyOutsideFreeSpace);
}

#[test]
fn part_under_a_cover_is_refused() {
    let cover = r#"{"polygon": [[0,4], [8,4], [8,6], [0,5]]}"#;
    let wedge = r#""body": {"polygon": [[3.25,1.25], [4.75,1.25], [6,2.5], [2,2.5]]}"#;
    let covered = solids(&format!("{GROOVE}, {cover}"));
    let found = plan(&format!(r#"{covered}, {wedge}, "clearance": {{"gap": 0.1}}"#));
    // Between block and cover it would be 1 m wide; the wedge is 1.25 m high.
    let refusal = found.unwrap_err();
    assert_eq!((refusal.code, refusal.field), (ErrorCode::NoRoute, None), "{}", refusal.message);
}

#[test]
fn wedge_in_its_block_is_told_how_deep() {
    let wedge = r#""body": {"polygon": [[3.25,0.875], [4.75,0.875], [6,2.5], [2,2.5]]}"#;
    let refusal = plan(&format!(r#"{}, {wedge}, "clearance": "safest""#, solids(GROOVE)));
    let refusal = refusal.unwrap_err();
    assert_eq!(refusal.code, ErrorCode::BodyOutsideFreeSpace);
    assert_eq!(refusal.field.as_deref(), Some("free_space.solids[0]"));
    assert_eq!((refusal.has, refusal.most), (Some(0.125), Some(0.0)), "{}", refusal.message);
}

#[test]
fn gap_that_a_way_can_not_keep_is_refused_with_what_it_can() {
    // A door of 1 m, turned by an eighth.
    let doors = r#"{"polygon": [[0,0], [9,0], [9,-1], [0,-1]]}, {"polygon": [[0,0], [1,0], [1,6], [0,6]]},
        {"polygon": [[8,0], [9,0], [9,6], [8,6]]}, {"polygon": [[1,4], [4,4], [4,6], [1,6]]},
        {"polygon": [[5,4], [8,4], [8,6], [6,6]]}"#;
    let body = r#""body": {"box": {"min": [4,2], "max": [4.5,2.5]}}"#;
    let scene = |gap: f64| format!(r#"{}, {body}, "clearance": {{"gap": {gap}}}"#, solids(doors));
    assert!((plan(&scene(0.2)).unwrap().clearance.value - 0.2).abs() < 1e-12);
    let refusal = plan(&scene(0.3)).unwrap_err();
    assert_eq!(refusal.code, ErrorCode::GapOutOfRange);
    assert!((refusal.most.unwrap() - 0.25).abs() < 1e-9, "{}", refusal.message);
}

#[test]
fn drawer_without_play_slides_out() {
    let sides = [
        ([0, 0, 0], [6, 6, 1]),
        ([0, 0, 5], [6, 6, 6]),
        ([0, 0, 1], [1, 6, 5]),
        ([1, 0, 1], [6, 1, 5]),
        ([1, 5, 1], [6, 6, 5]),
    ];
    let sides = sides.map(|(a, b)| format!(r#"{{"box": {{"min": {a:?}, "max": {b:?}}}}}"#));
    for clearance in [r#""safest""#, r#"{"gap": 0.1}"#] {
        let found = plan(&format!(
            r#"{}, "body": {{"box": {{"min": [1,1,1], "max": [4,5,5]}}}}, "exit": "+x",
                "clearance": {clearance}"#,
            solids(&sides.join(", "))
        ));
        let found = found.unwrap();
        assert_eq!((found.length, found.legs.len()), (5.0, 1), "{found:?}");
        assert_eq!(found.clearance.value, 0.0);
    }
}

/// A wedge under a narrow opening, beside a wide corridor that is longer.
#[test]
fn safest_of_several_exits_is_the_widest() {
    let walls = [
        r#"{"box": {"min": [-1,-1], "max": [0,3]}}"#,
        r#"{"box": {"min": [0,-1], "max": [6,-0.5]}}"#,
        r#"{"box": {"min": [1.7,2], "max": [6,3]}}"#,
    ];
    let wedge = r#""body": {"polygon": [[0.5,0.5], [1.5,0.5], [1,1.5]]}"#;
    let leave = |exits: &str, clearance: &str| {
        let rest = format!(r#""exit": [{exits}], "clearance": {clearance}"#);
        plan(&format!("{}, {wedge}, {rest}", solids(&walls.join(",")))).unwrap()
    };
    for exits in [r#""+z", "+x""#, r#""+x", "+z""#] {
        let shortest = leave(exits, r#"{"gap": 0.1}"#);
        assert_eq!((shortest.exit, shortest.length), (Some(Direction::PlusZ), 2.5));
        let safest = leave(exits, r#""safest""#);
        assert_eq!(safest.exit, Some(Direction::PlusX));
        let clearances = safest.clearance.value - leave(r#""+z""#, r#""safest""#).clearance.value;
        // Half a metre to the wall at the start; in the opening 0.35 m on both sides.
        assert!((clearances - 0.15).abs() < 1e-9, "{clearances}");
    }
}
