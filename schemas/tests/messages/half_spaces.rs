//! Half-spaces (paper, 2.1 and 2.2): the same scenes as by boxes, bit for bit.

use proptest::prelude::*;
use schemas::json::{read_scene, scene_to_json};
use schemas::message::{Axis, AxisBox, Body, Solid, Vector};

/// Section 4 with its channels as the paper writes them, its solid a box, its body a box.
const SECTION_4: &str = r#"{"task": "disassemble", "free_space": {"channels": [
        {"half_spaces": [{"axis": "x", "at_least": 4}, {"axis": "x", "at_most": 7},
                         {"axis": "z", "at_least": 1}, {"axis": "z", "at_most": 6}]},
        {"min": [1, 2], "max": [7, 6]},
        {"half_spaces": [{"axis": "z", "at_most": 7}, {"axis": "x", "at_most": 5},
                         {"axis": "z", "at_least": 2}, {"axis": "x", "at_least": 1}]}],
        "in_order": true,
        "solids": [{"half_spaces": [{"axis": "x", "at_least": 0}, {"axis": "x", "at_most": 8},
                                    {"axis": "z", "at_least": 0}, {"axis": "z", "at_most": 1}]}],
        "bounds": {"half_spaces": [{"axis": "x", "at_least": 0}, {"axis": "x", "at_most": 8},
                                   {"axis": "z", "at_least": 0}, {"axis": "z", "at_most": 7}]}},
    "body": {"half_spaces": [{"axis": "x", "at_least": 4.5}, {"axis": "x", "at_most": 6.99},
                             {"axis": "z", "at_least": 1.01}, {"axis": "z", "at_most": 4}]},
    "clearance": {"gap": 0.2}}"#;

/// In place of what bounds the body along z.
const X_AGAIN: &str = r#"{"axis": "x", "at_least": 1}"#;

fn corners(min: &[f64], max: &[f64]) -> AxisBox {
    AxisBox { min: Vector::new(min).unwrap(), max: Vector::new(max).unwrap() }
}

#[test]
fn intersections_are_boxes() {
    let scene = read_scene(SECTION_4).unwrap();
    let [first, second, third] = [
        corners(&[4.0, 1.0], &[7.0, 6.0]),
        corners(&[1.0, 2.0], &[7.0, 6.0]),
        corners(&[1.0, 2.0], &[5.0, 7.0]),
    ];
    assert_eq!(scene.free_space.channels, Some(vec![first, second, third]));
    let floor = Solid::Box(corners(&[0.0, 0.0], &[8.0, 1.0]));
    assert_eq!(scene.free_space.solids, Some(vec![floor]));
    assert_eq!(scene.free_space.bounds, Some(corners(&[0.0, 0.0], &[8.0, 7.0])));
    assert_eq!(scene.body, Body::Box(corners(&[4.5, 1.01], &[6.99, 4.0])));
    // Written, it has boxes.
    let written = scene_to_json(&scene);
    assert!(!written.contains("half_spaces"), "{written}");
    assert_eq!(read_scene(&written).unwrap(), scene);
}

#[track_caller]
fn check_refused(text: &str, field: &str, message: &str) {
    let refusal = read_scene(text).unwrap_err().refusal;
    assert_eq!(refusal.field.as_deref(), Some(field), "{}", refusal.message);
    assert!(refusal.message.contains(message), "{}", refusal.message);
}

#[test]
fn what_is_no_box_is_refused() {
    let body = "body.half_spaces";
    let with = |from: &str, to: &str| {
        assert!(SECTION_4.contains(from));
        SECTION_4.replacen(from, to, 1)
    };
    let open = with(r#", {"axis": "x", "at_most": 6.99}"#, "");
    check_refused(&open, body, "open towards +x");
    let open = with(r#"{"axis": "z", "at_least": 1.01}, "#, "");
    check_refused(&open, body, "open towards -z");
    let flat = with(r#"{"axis": "z", "at_least": 1.01}, {"axis": "z", "at_most": 4}"#, X_AGAIN);
    check_refused(&flat, body, "must bound x and z");
    let both = with(r#""at_most": 6.99"#, r#""at_most": 6.99, "at_least": 1"#);
    check_refused(&both, body, "one of `at_least` and `at_most`");
    let across = with(r#"{"axis": "z", "at_most": 4}"#, r#"{"axis": "y", "at_most": 4}"#);
    let across =
        across.replace(r#"{"axis": "z", "at_least": 1.01}"#, r#"{"axis": "y", "at_least": 1}"#);
    check_refused(&across, "body.half_spaces[2].axis", "\"x\" or \"z\" in the plane of this task");
    let corner = with(r#"{"min": [1, 2], "#, r#"{"min": [1, 2], "half_spaces": [], "#);
    check_refused(&corner, "free_space.channels[1].half_spaces", "must bound x and z");
    let unknown = with(r#""at_most": 6.99"#, r#""below": 6.99"#);
    check_refused(&unknown, "body.half_spaces[1].below", "is not a known field");
}

#[test]
fn robots_have_half_spaces_across_x_and_y() {
    let text = |axis: &str| {
        format!(
            r#"{{"task": "drive", "free_space": {{"channels": [{{"half_spaces": [
                {{"axis": "x", "at_least": 0}}, {{"axis": "x", "at_most": 9}},
                {{"axis": "{axis}", "at_least": 0}}, {{"axis": "{axis}", "at_most": 3}}]}}]}},
                "body": {{"footprint": {{"width": 1, "length": 1}}}}, "clearance": "safest"}}"#
        )
    };
    let channels = read_scene(&text("y")).unwrap().free_space.channels.unwrap();
    assert_eq!(channels, [corners(&[0.0, 0.0], &[9.0, 3.0])]);
    let field = "free_space.channels[0].half_spaces[2].axis";
    check_refused(&text("z"), field, "must be \"x\" or \"y\" in the plane of this task, not \"z\"");
}

proptest! {
    /// Any half-spaces, in any order and as many as one likes, are the box of what they all leave.
    #[test]
    fn order_and_number_do_not_matter(
        bounds in proptest::collection::vec((0..3_usize, any::<bool>(), -9.0..9.0_f64), 6..20),
        planar: bool,
    ) {
        let (mut least, mut most) = ([f64::NEG_INFINITY; 3], [f64::INFINITY; 3]);
        let mut texts = Vec::new();
        let axes: &[(Axis, &str)] = if planar { &[(Axis::X, "x"), (Axis::Z, "z")] } else { &[(Axis::X, "x"), (Axis::Y, "y"), (Axis::Z, "z")] };
        for (axis, up, bound) in bounds {
            let (axis, name) = axes[axis % axes.len()];
            let at = axis as usize;
            if up {
                least[at] = least[at].max(bound);
            } else {
                most[at] = most[at].min(bound);
            }
            let end = if up { "at_least" } else { "at_most" };
            texts.push(format!(r#"{{"axis": "{name}", "{end}": {bound:?}}}"#));
        }
        let text = format!(
            r#"{{"task": "assemble", "free_space": {{}}, "clearance": "safest",
                "body": {{"half_spaces": [{}]}}}}"#,
            texts.join(", ")
        );
        // An axis that nothing is said of is not among the box's, which may be in the plane.
        let named = |axis: &&(Axis, _)| {
            let at = axis.0 as usize;
            least[at].is_finite() || most[at].is_finite()
        };
        let of = |ends: [f64; 3]| {
            axes.iter().filter(named).map(|(axis, _)| ends[*axis as usize]).collect::<Vec<_>>()
        };
        let (least, most) = (of(least), of(most));
        match read_scene(&text) {
            Ok(scene) => prop_assert_eq!(scene.body, Body::Box(corners(&least, &most))),
            Err(_) => prop_assert!(
                least.len() < 2 || least.iter().chain(&most).any(|end| end.is_infinite())
                    || text.contains("\"y\"") != text.contains("\"z\"")
                    || !text.contains("\"x\"")
            ),
        }
    }
}
