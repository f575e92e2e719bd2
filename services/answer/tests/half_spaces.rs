//! Half-spaces (paper, 2.2) are answered as the boxes that they are, byte for byte.

use answer::{Answerer, Caps};
use schemas::codec;
use schemas::json::read_scene;
use schemas::message::{Request, RequestContent, RequestKey};

fn parts(text: &str) -> Vec<Vec<u8>> {
    let content = RequestContent::Scene(read_scene(text).unwrap());
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    Answerer::new(&Caps::default()).parts_to(&request).iter().map(codec::encode).collect()
}

/// The half-spaces of a box in the plane, the paper's way.
fn half_spaces([x, other]: [&str; 2], [a, b, c, d]: [f64; 4]) -> String {
    format!(
        r#"{{"half_spaces": [{{"axis": "{x}", "at_least": {a}}}, {{"axis": "{x}", "at_most": {c}}},
            {{"axis": "{other}", "at_least": {b}}}, {{"axis": "{other}", "at_most": {d}}}]}}"#
    )
}

fn corners([a, b, c, d]: [f64; 4]) -> String {
    format!(r#"{{"min": [{a}, {b}], "max": [{c}, {d}]}}"#)
}

#[test]
fn section_4_is_answered_alike() {
    let channels = [[4.0, 1.0, 7.0, 6.0], [1.0, 2.0, 7.0, 6.0], [1.0, 2.0, 5.0, 7.0]];
    let (floor, body) = ([0.0, 0.0, 8.0, 1.0], [4.5, 1.01, 6.99, 4.0]);
    let text = |channels: [String; 3], floor: String, body: String| {
        format!(
            r#"{{"task": "disassemble", "clearance": {{"each": [0.01, 0.2, "safest"]}},
                "free_space": {{"in_order": true, "channels": [{}], "solids": [{floor}]}},
                "body": {body}}}"#,
            channels.join(", "),
        )
    };
    let boxed = |sides| format!(r#"{{"box": {}}}"#, corners(sides));
    let expected = parts(&text(channels.map(corners), boxed(floor), boxed(body)));
    assert!(expected.len() >= 3);
    let sides = |sides| half_spaces(["x", "z"], sides);
    assert_eq!(parts(&text(channels.map(sides), sides(floor), sides(body))), expected);
}

#[test]
fn corridors_are_answered_alike() {
    let text = |channels: [String; 2]| {
        format!(
            r#"{{"task": "drive", "clearance": {{"gap": 0.2}},
                "free_space": {{"in_order": true, "channels": [{}]}},
                "body": {{"footprint": {{"width": 1.0, "length": 1.5}}}},
                "start": {{"position": [2, 1.5], "heading": 0}}, "goal": {{"position": [8.5, 9]}}}}"#,
            channels.join(", ")
        )
    };
    let channels = [[0.0, 0.0, 10.0, 3.0], [7.0, 0.0, 10.0, 12.0]];
    let expected = parts(&text(channels.map(corners)));
    assert!(!expected.is_empty());
    assert_eq!(parts(&text(channels.map(|sides| half_spaces(["x", "y"], sides)))), expected);
}
