//! What a request says of a robot: what it may do, and what its motion costs.

use std::f64::consts::FRAC_PI_2;

use answer::{Caps, reply_to};
use schemas::json::read_scene;
use schemas::message::{
    Answer, Curve, ErrorCode, Leg, Refusal, Reply, Request, RequestContent, RequestKey, Trajectory,
};

/// Channels in travel order.
const IN_ORDER: &str = r#"{ "task": "drive",
    "free_space": { "channels": [{ "min": [0, 0], "max": [10, 3] }], "in_order": true },
    "body": { "footprint": { "width": 1, "length": 1.5 } },
    "start": { "position": [2, 1.5], "heading": 0 }, "goal": { "position": [8, 1.5] },
    "clearance": { "gap": 0.2 } }"#;

/// A wall with room on both sides of it.
const ANYWHERE: &str = r#"{ "task": "drive",
    "free_space": { "solids": [{ "polygon": [[4, 2], [5, 2], [5, 8], [4, 8]] }],
        "bounds": { "min": [0, 0], "max": [9, 10] } },
    "body": { "footprint": { "width": 0.5, "length": 0.75 } },
    "start": { "position": [2, 4], "heading": 0 }, "goal": { "position": [7, 4] },
    "clearance": { "gap": 0.1 } }"#;

fn with(scene: &str, field: &str) -> String {
    scene.replacen('{', &format!("{{ {field},"), 1)
}

#[track_caller]
fn replaced(scene: &str, from: &str, to: &str) -> String {
    assert!(scene.contains(from), "{from}");
    scene.replacen(from, to, 1)
}

#[track_caller]
fn reply(scene: &str) -> Reply {
    let content = RequestContent::Scene(read_scene(scene).unwrap());
    reply_to(&Request { key: RequestKey::default(), sent_ns: 0, content }, &Caps::default())
}

#[track_caller]
fn answers(scene: &str) -> Vec<Answer> {
    reply(scene).answers.unwrap_or_else(|refusal| panic!("{refusal:?}"))
}

#[track_caller]
fn trajectory(scene: &str) -> Trajectory {
    answers(scene).remove(0).unwrap()
}

#[track_caller]
fn refusal(scene: &str) -> Refusal {
    reply(scene).answers.expect_err("the scene is refused")
}

/// The same outlines with points given twice, points within edges, and the first point again.
#[test]
fn points_that_repeat_or_lie_on_edges_change_nothing() {
    let plain = trajectory(ANYWHERE);
    for outline in [
        "[[4, 2], [4, 2], [5, 2], [5, 8], [4, 8], [4, 8], [4, 8]]",
        "[[4, 2], [5, 2], [5, 8], [4, 8], [4, 2]]",
        "[[4, 2], [4.5, 2], [5, 2], [5, 3], [5, 4], [5, 8], [4, 8], [4, 5]]",
        "[[4, 2], [4.5, 2], [4.5, 2], [5, 2], [5, 8], [4, 8], [4, 5], [4, 2], [4, 2]]",
    ] {
        let scene = replaced(ANYWHERE, "[[4, 2], [5, 2], [5, 8], [4, 8]]", outline);
        let other = trajectory(&scene);
        assert!((other.length - plain.length).abs() < 1e-12, "{outline}: {}", other.length);
        let [near, other_near] = [&plain, &other].map(|trajectory| trajectory.clearance.value);
        assert!((near - other_near).abs() < 1e-12, "{outline}: {other_near}");
        assert_eq!(other.legs.len(), plain.legs.len());
    }
    // All in one place is no outline, whatever is left out.
    let scene = replaced(ANYWHERE, "[[4, 2], [5, 2], [5, 8], [4, 8]]", "[[4, 2], [4, 2], [4, 2]]");
    check_refused(&scene, "free_space.solids[0].polygon", "no area");
}

/// Out of a bay that is narrower than the turning circle, at any angle: straight out, a turn, and
/// straight to the goal, as where the walls are parallel to the axes.
#[test]
fn turned_bay_is_left_as_the_unturned_one() {
    let scene = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let place = |[x, y]: [f64; 2]| format!("[{}, {}]", cos * x - sin * y, sin * x + cos * y);
        let solid = |[left, low, right, high]: [f64; 4]| {
            let corners = [[left, low], [right, low], [right, high], [left, high]];
            format!(r#"{{ "polygon": [{}] }}"#, corners.map(place).join(", "))
        };
        let solids = [
            [0.0, 0.0, 4.65, 2.0],
            [5.35, 0.0, 10.0, 2.0],
            [-1.0, -1.0, 11.0, 0.0],
            [-1.0, 5.0, 11.0, 6.0],
            [-1.0, 0.0, 0.0, 5.0],
            [10.0, 0.0, 11.0, 5.0],
        ];
        format!(
            r#"{{ "task": "drive", "free_space": {{ "solids": [{}],
                "bounds": {{ "min": [-20, -20], "max": [20, 20] }} }},
                "body": {{ "footprint": {{ "width": 0.6, "length": 1.2 }} }},
                "start": {{ "position": {}, "heading": {} }}, "goal": {{ "position": {} }},
                "clearance": {{ "gap": 0.02 }}, "sampling": {{ "period": 0.05 }} }}"#,
            solids.map(solid).join(", "),
            place([5.0, 0.8]),
            std::f64::consts::FRAC_PI_2 + degrees.to_radians(),
            place([9.0, 3.5]),
        )
    };
    let plain = trajectory(&scene(0.0));
    assert!(plain.length <= 6.7 && plain.clearance.value >= 0.02 - 1e-9);
    for degrees in (10..90).step_by(10) {
        let other = trajectory(&scene(f64::from(degrees)));
        assert!((other.length - plain.length).abs() < 1e-9 * plain.length, "{degrees}");
        assert!((other.clearance.value - plain.clearance.value).abs() < 1e-9, "{degrees}");
        assert_eq!(other.legs.len(), plain.legs.len());
    }
}

#[track_caller]
fn check_refused(scene: &str, field: &str, words: &str) -> Refusal {
    let refusal = refusal(scene);
    assert_eq!((refusal.code, refusal.field.as_deref()), (ErrorCode::InvalidScene, Some(field)));
    assert!(refusal.message.contains(words), "{}", refusal.message);
    refusal
}

#[test]
fn numbers_out_of_range_are_refused_with_both_numbers() {
    for scene in [IN_ORDER, ANYWHERE] {
        let radius = check_refused(
            &with(scene, r#""min_turn_radius": 0"#),
            "min_turn_radius",
            "min_turn_radius is 0 m; it must be finite and greater than 0",
        );
        assert_eq!((radius.has, radius.least), (Some(0.0), Some(0.0)));
        for cost in ["turn_cost", "stop_cost"] {
            let refusal = check_refused(
                &with(scene, &format!(r#""{cost}": -0.5"#)),
                cost,
                "it must be finite and at least 0",
            );
            assert_eq!((refusal.has, refusal.needs), (Some(-0.5), Some(0.0)));
            check_refused(&with(scene, &format!(r#""{cost}": 1e155"#)), cost, "out of range");
        }
        check_refused(&with(scene, r#""min_turn_radius": 1e155"#), "min_turn_radius", "1e155 m");
    }
    let least = replaced(ANYWHERE, r#"{ "gap": 0.1 }"#, r#"{ "at_least": -0.5 }"#);
    let refusal = check_refused(&least, "clearance.at_least", "is -0.5 m; it must be finite");
    assert_eq!((refusal.has, refusal.needs), (Some(-0.5), Some(0.0)));
}

#[test]
fn a_footprint_contains_its_reference_point() {
    let footprint = |front: f64, rear: f64| {
        let offset = format!(r#""front": {front}, "rear": {rear}"#);
        replaced(IN_ORDER, r#""length": 1.5"#, &offset)
    };
    for (front, rear) in [(-0.25, 1.0), (1.0, -0.25)] {
        let refusal = check_refused(&footprint(front, rear), "body.footprint", "-0.25 m");
        assert_eq!((refusal.has, refusal.least), (Some(-0.25), Some(0.0)));
    }
    check_refused(&footprint(0.0, 0.0), "body.footprint", "nor both 0");
    let centered = reply(IN_ORDER);
    assert!(centered.answers.is_ok());
    assert_eq!(reply(&footprint(0.75, 0.75)), centered);
}

#[test]
fn a_robot_that_cannot_turn_in_place_has_a_radius() {
    for scene in [IN_ORDER, ANYWHERE] {
        let scene = with(scene, r#""turn_in_place": false"#);
        check_refused(&scene, "min_turn_radius", "min_turn_radius is missing");
    }
}

#[test]
fn what_the_rules_can_not_do_is_driven_in_the_channels_at_large() {
    let least = replaced(IN_ORDER, r#"{ "gap": 0.2 }"#, r#"{ "at_least": 0.2 }"#);
    let scenes = [
        with(IN_ORDER, r#""reverse": true"#),
        with(IN_ORDER, r#""min_turn_radius": 0.5"#),
        with(IN_ORDER, r#""turn_in_place": false, "min_turn_radius": 0.5"#),
        least,
    ];
    for scene in scenes {
        let found = trajectory(&scene);
        let bound = found.bound.expect("a bound");
        assert!(bound <= found.length, "{found:?}");
        assert!(found.legs.iter().all(|leg| leg.rung.is_some()), "{found:?}");
    }
    let plain = r#""reverse": false, "turn_in_place": true, "turn_cost": 1, "stop_cost": 0"#;
    assert_eq!(reply(&with(IN_ORDER, plain)), reply(IN_ORDER));
}

#[test]
fn full_reports_add_a_certificate_and_change_nothing_else() {
    let mut full = trajectory(&with(IN_ORDER, r#""report": "full""#));
    let bound = full.bound.take().expect("a bound");
    assert!(0.0 < bound && bound <= full.length, "{bound}");
    assert!(full.free_clearance.take().expect("a clearance") >= full.clearance.value);
    assert_eq!(full, trajectory(IN_ORDER));
}

#[test]
fn one_of_several_answers_is_refused_by_itself() {
    let each = replaced(
        IN_ORDER,
        r#"{ "gap": 0.2 }"#,
        r#"{ "each": [{ "at_least": 0.2 }, 0.2, { "at_least": 0.2 }] }"#,
    );
    let answers = answers(&each);
    assert_eq!(answers[1].as_ref().unwrap(), &trajectory(IN_ORDER));
    for index in [0, 2] {
        let refusal = answers[index].as_ref().unwrap_err();
        let field = format!("clearance.each[{index}]");
        assert_eq!(refusal.field.as_deref(), Some(&*field), "{refusal:?}");
    }
}

#[test]
fn assembly_knows_no_free_clearance() {
    let scene = r#"{ "task": "disassemble",
        "free_space": { "channels": [{ "min": [0, 0], "max": [2, 5] }], "in_order": true },
        "body": { "box": { "min": [0.5, 0.5], "max": [1.5, 3] } },
        "clearance": { "at_least": 0.1 } }"#;
    check_refused(scene, "clearance.at_least", "is not a field of assembly tasks");
}

#[test]
fn free_clearance_is_at_least_what_is_asked() {
    for least in [0.0, 0.3, 0.6] {
        let wish = format!(r#"{{ "at_least": {least} }}"#);
        let found = trajectory(&replaced(ANYWHERE, r#"{ "gap": 0.1 }"#, &wish));
        let free = found.free_clearance.unwrap();
        assert!(free >= least - 1e-9, "{free} m, asked for {least} m");
        let bound = found.bound.unwrap();
        assert!(bound <= found.length * (1.0 + 1e-9), "bound {bound} m, length {} m", found.length);
        assert!(found.legs.iter().all(|leg| leg.rung.is_some() && !leg.reverse), "{found:?}");
    }
}

/// A robot that faces away at first drives forwards on the line on which it turns.
#[test]
fn turning_while_moving_is_not_driving_backwards() {
    let facing_away = replaced(ANYWHERE, r#""heading": 0 }"#, r#""heading": 3 }"#);
    let found = trajectory(&with(&facing_away, r#""start_turn": "while_moving""#));
    let Leg { curve: Curve::Line { from, to, heading, turned }, reverse, .. } = &found.legs[0]
    else {
        panic!("{:?}", found.legs[0]);
    };
    let [dx, dy] = [0, 1].map(|axis| to.as_slice()[axis] - from.as_slice()[axis]);
    assert!(turned.abs() > FRAC_PI_2, "{turned}");
    assert!((dy.atan2(dx) - heading).abs() < 1e-9, "{heading}, ({dx}, {dy})");
    assert!(!reverse);
}

#[test]
fn trajectories_in_travel_order_keep_their_fields() {
    let Trajectory { bound, free_clearance, complete, legs, .. } = trajectory(IN_ORDER);
    assert_eq!((bound, free_clearance, complete), (None, None, true));
    assert!(legs.iter().all(|leg| leg.rung.is_none() && !leg.reverse), "{legs:?}");
}

/// Of two corners of a turning robot, the one farther from its reference point decides.
#[test]
fn the_greatest_gap_is_that_of_the_longer_end() {
    let corner = |gap: f64, front: f64, rear: f64| {
        format!(
            r#"{{ "task": "drive", "sampling": {{ "count": 2 }},
            "free_space": {{ "channels": [{{ "min": [0, 0], "max": [3, 20] }},
                {{ "min": [0, 17], "max": [20, 20] }}], "in_order": true }},
            "body": {{ "footprint": {{ "width": 1, "front": {front}, "rear": {rear} }} }},
            "start": {{ "position": [1.5, 2], "heading": 1.5707963267948966 }},
            "goal": {{ "position": [18, 18.5] }}, "clearance": {{ "gap": {gap} }} }}"#
        )
    };
    // The outer corners run on a circle that the outer walls, 3 m from the corner, must enclose.
    let most = f64::sqrt(3.0 * 3.0 - 1.25 * 1.25) - 1.0;
    for (front, rear) in [(1.25, 0.25), (0.25, 1.25)] {
        let refusal = refusal(&corner(most + 1e-6, front, rear));
        assert_eq!(refusal.code, ErrorCode::GapOutOfRange, "{refusal:?}");
        assert!((refusal.most.unwrap() - most).abs() < 1e-12, "{refusal:?}");
        let clearance = trajectory(&corner(most - 1e-6, front, rear)).clearance;
        assert!(clearance.value > 0.0 && clearance.value < 1e-5, "{clearance:?}");
    }
}
