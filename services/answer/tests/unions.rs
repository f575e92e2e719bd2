//! Parts and solids that are unions of boxes.

use answer::{Caps, reply_to};
use proptest::prelude::*;
use schemas::json::read_scene;
use schemas::message::{
    ErrorCode, Refusal, Reply, Request, RequestContent, RequestKey, Trajectory,
};

fn reply(scene: &str) -> Reply {
    let content = RequestContent::Scene(read_scene(scene).unwrap());
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    reply_to(&request, &Caps::default())
}

/// The only answer to a scene; `rest` is its fields after the task.
fn plan(rest: &str) -> Result<Trajectory, Refusal> {
    reply(&format!(r#"{{"task": "disassemble", {rest}}}"#)).answers?.remove(0)
}

fn boxes(boxes: &[[[f64; 3]; 2]]) -> String {
    let sides = boxes.iter().map(|[min, max]| format!(r#"{{"min": {min:?}, "max": {max:?}}}"#));
    format!(r#"{{"boxes": [{}]}}"#, sides.collect::<Vec<_>>().join(", "))
}

/// A block with a slot like a T along x, closed at x = 0 to 1 and open at x = 6.
const T_SLOT: [[[f64; 3]; 2]; 6] = [
    [[0., 0., 0.], [6., 6., 1.]],
    [[0., 0., 1.], [6., 1., 4.]],
    [[0., 5., 1.], [6., 6., 4.]],
    [[0., 1., 3.], [6., 2., 4.]],
    [[0., 4., 3.], [6., 5., 4.]],
    [[0., 0., 1.], [1., 6., 4.]],
];

const T_PART: [[[f64; 3]; 2]; 2] =
    [[[2., 1.25, 1.25], [4., 4.75, 2.75]], [[2., 2.25, 2.75], [4., 3.75, 3.75]]];

#[test]
fn t_slides_out_of_its_slot() {
    let scene = |solids: &str, clearance: &str| {
        format!(
            r#""free_space": {{"solids": [{solids}]}}, "body": {}, "exit": "+x",
            "clearance": {clearance}"#,
            boxes(&T_PART)
        )
    };
    let one = boxes(&T_SLOT);
    let several =
        T_SLOT.map(|[min, max]| format!(r#"{{"box": {{"min": {min:?}, "max": {max:?}}}}}"#));
    for clearance in [r#"{"gap": 0.1}"#, r#""safest""#] {
        let found = plan(&scene(&one, clearance)).unwrap();
        assert_eq!(
            (found.length, found.legs.len(), found.clearance.value),
            (4.0, 1, 0.25),
            "{found:?}"
        );
        assert_eq!(plan(&scene(&several.join(", "), clearance)).unwrap(), found);
    }
}

#[test]
fn t_that_fits_exactly_slides_out() {
    let snug = [[[1., 1., 1.], [4., 5., 3.]], [[1., 2., 3.], [4., 4., 4.]]];
    let found = plan(&format!(
        r#""free_space": {{"solids": [{}]}}, "body": {}, "exit": "+x", "clearance": "safest""#,
        boxes(&T_SLOT),
        boxes(&snug)
    ));
    let found = found.unwrap();
    assert_eq!((found.length, found.legs.len(), found.clearance.value), (5.0, 1, 0.0), "{found:?}");
}

#[test]
fn t_is_held_by_its_slot() {
    let up = format!(
        r#""free_space": {{"solids": [{}]}}, "body": {}, "exit": "+z", "clearance": "safest""#,
        boxes(&T_SLOT),
        boxes(&T_PART)
    );
    let refusal = plan(&up).unwrap_err();
    assert_eq!((refusal.code, refusal.field), (ErrorCode::NoRoute, None), "{}", refusal.message);
}

#[test]
fn union_in_a_solid_is_told_how_deep() {
    let mut part = T_PART;
    part[1][1][1] = 4.125;
    let scene = format!(
        r#""free_space": {{"solids": [{{"box": {{"min": [9, 0, 0], "max": [10, 1, 1]}}}}, {}]}},
        "body": {}, "exit": "+x", "clearance": "safest""#,
        boxes(&T_SLOT),
        boxes(&part)
    );
    let refusal = plan(&scene).unwrap_err();
    assert_eq!(refusal.code, ErrorCode::BodyOutsideFreeSpace);
    assert_eq!(refusal.field.as_deref(), Some("free_space.solids[1]"));
    assert_eq!((refusal.has, refusal.most), (Some(0.125), Some(0.0)), "{}", refusal.message);
}

#[test]
fn union_out_of_the_bounds_is_refused() {
    let mut part = T_PART;
    part[1][1][2] = 4.5;
    let scene = format!(
        r#""free_space": {{"solids": [{}]}}, "body": {}, "exit": "+x", "clearance": "safest""#,
        boxes(&T_SLOT),
        boxes(&part)
    );
    let refusal = plan(&scene).unwrap_err();
    assert_eq!(refusal.code, ErrorCode::BodyOutsideFreeSpace);
    assert_eq!((refusal.needs, refusal.has), (Some(4.5), Some(4.0)), "{}", refusal.message);
}

/// Two bars side by side, with a wall between them that is as long as they are.
#[test]
fn boxes_that_are_apart_move_together() {
    let part = [[[1., 1., 1.], [2., 2., 3.]], [[3., 1., 1.], [4., 2., 3.]]];
    let solids = [
        [[0., 0., 0.], [5., 3., 0.5]],
        [[2.25, 0., 0.5], [2.75, 3., 4.]],
        [[0., 0., 0.5], [0.5, 3., 4.]],
        [[4.5, 0., 0.5], [5., 3., 4.]],
    ];
    let scene = format!(
        r#""free_space": {{"solids": [{}]}}, "body": {}, "clearance": {{"gap": 0.1}}"#,
        boxes(&solids),
        boxes(&part)
    );
    let found = plan(&scene).unwrap();
    assert_eq!(
        (found.length, found.legs.len(), found.clearance.value),
        (3.0, 1, 0.25),
        "{found:?}"
    );
}

#[test]
fn union_of_one_box_is_that_box() {
    let scene = |body: &str| {
        format!(
            r#""free_space": {{"solids": [{}]}}, "body": {body}, "exit": "+x", "clearance": "safest""#,
            boxes(&T_SLOT)
        )
    };
    let union = plan(&scene(r#"{"boxes": [{"min": [2, 2, 1.5], "max": [4, 4, 3.5]}]}"#));
    assert_eq!(union, plan(&scene(r#"{"box": {"min": [2, 2, 1.5], "max": [4, 4, 3.5]}}"#)));
    assert!(union.is_ok(), "{union:?}");
}

#[test]
fn channels_hold_the_bounds_of_a_union() {
    let scene = |body: &str| {
        format!(
            r#""free_space": {{"channels": [{{"min": [0, 0, 0], "max": [3, 3, 9]}},
            {{"min": [0, 0, 5], "max": [9, 3, 9]}}], "in_order": true}}, "exit": "+x",
            "body": {body}, "clearance": {{"gap": 0.25}}"#
        )
    };
    let corner = [[[0.5, 0.5, 0.5], [2.5, 2.5, 1.]], [[0.5, 0.5, 1.], [1., 2.5, 2.5]]];
    let union = plan(&scene(&boxes(&corner))).unwrap();
    let whole =
        plan(&scene(r#"{"box": {"min": [0.5, 0.5, 0.5], "max": [2.5, 2.5, 2.5]}}"#)).unwrap();
    let ends = |found: &Trajectory| found.legs.iter().map(|leg| leg.curve).collect::<Vec<_>>();
    assert_eq!(ends(&union), ends(&whole));
    assert!(union.clearance.value >= whole.clearance.value);
}

#[test]
fn unions_that_make_no_sense_are_refused_by_name() {
    let good = boxes(&T_PART);
    let check = |solid: &str, body: &str, field: &str, needs: &str| {
        let scene = format!(
            r#""free_space": {{"solids": [{solid}]}}, "body": {body}, "exit": "+x", "clearance": "safest""#
        );
        let refusal = plan(&scene).unwrap_err();
        assert_eq!(refusal.code, ErrorCode::InvalidScene);
        assert_eq!(refusal.field.as_deref(), Some(field), "{}", refusal.message);
        assert!(refusal.message.contains(needs), "{}", refusal.message);
    };
    let slot = boxes(&T_SLOT);
    check(r#"{"boxes": []}"#, &good, "free_space.solids[0].boxes", "0 boxes; at least 1");
    check(&slot, r#"{"boxes": []}"#, "body.boxes", "0 boxes; at least 1");
    let inverted = [T_PART[0], [[2., 2., 3.], [4., 4., 3.]]];
    check(&slot, &boxes(&inverted), "body.boxes[1]", "z");
    check(&boxes(&[T_SLOT[0], inverted[1]]), &good, "free_space.solids[0].boxes[1]", "z");
    let flat = r#"{"boxes": [{"min": [0, 0], "max": [1, 1]}]}"#;
    check(flat, &good, "free_space.solids[0].boxes[0].min", "coordinates");
}

#[test]
fn unions_are_turned_by_quarters() {
    let scene = |heading: f64| {
        format!(
            r#""free_space": {{"solids": [{{"box": {{"min": [0, 0], "max": [4, 1]}}}},
            {{"box": {{"min": [0, 1], "max": [1, 4]}}}}]}}, "clearance": {{"gap": 0.1}},
            "body": {{"boxes": [{{"min": [0, -2], "max": [1, 0]}}, {{"min": [1, -1], "max": [2, 0]}}]}},
            "frames": {{"fixed": {{"position": [0, 0], "heading": 0}},
            "moving": {{"position": [1.5, 1.5], "heading": {heading}}}}}"#
        )
    };
    // Turned by a quarter it is from (1.5, 1.5) to (3.5, 3.5).
    let found = plan(&scene(std::f64::consts::FRAC_PI_2)).unwrap();
    assert_eq!((found.length, found.clearance.value), (2.5, 0.5), "{found:?}");
    let refusal = plan(&scene(0.5)).unwrap_err();
    assert_eq!(refusal.field.as_deref(), Some("frames.moving.heading"), "{}", refusal.message);
}

/// The way of an L among blocks, given as boxes and as a polygon.
fn check_l_shape(width: f64, height: f64, blocks: &[(f64, f64, f64)], clearance: &str) {
    let [left, low] = [1.25, 1.25];
    let (right, high) = (left + width, low + height);
    let union = format!(
        r#"{{"boxes": [{{"min": [{left}, {low}], "max": [{right}, {}]}},
        {{"min": [{left}, {low}], "max": [{}, {high}]}}]}}"#,
        low + 0.5,
        left + 0.5
    );
    let outline = format!(
        r#"{{"polygon": [[{left}, {low}], [{right}, {low}], [{right}, {b}], [{a}, {b}], [{a}, {high}],
        [{left}, {high}]]}}"#,
        a = left + 0.5,
        b = low + 0.5
    );
    let mut solids = vec![
        r#"{"min": [0, 0], "max": [9, 1]}"#.to_owned(),
        r#"{"min": [0, 1], "max": [1, 8]}"#.to_owned(),
        r#"{"min": [8, 1], "max": [9, 8]}"#.to_owned(),
    ];
    solids.extend(blocks.iter().map(|(x, z, size)| {
        let (x, z) = (2.0 + x * 4.0, 4.0 + z * 2.0);
        format!(r#"{{"min": [{x}, {z}], "max": [{}, {}]}}"#, x + 1.5 * size, z + size)
    }));
    let one = format!(r#"{{"boxes": [{}]}}"#, solids.join(", "));
    let scene = |solids: &str, body: &str| {
        format!(
            r#""free_space": {{"solids": [{solids}]}}, "body": {body}, "clearance": {clearance}"#
        )
    };
    let several: Vec<String> =
        solids.iter().map(|sides| format!(r#"{{"box": {sides}}}"#)).collect();
    let found = [
        plan(&scene(&one, &union)),
        plan(&scene(&one, &outline)),
        plan(&scene(&several.join(", "), &union)),
    ];
    match &found {
        [Ok(a), Ok(b), Ok(_)] => {
            // Near the start, what a way with the safest clearance keeps depends on the pieces.
            if clearance.contains("gap") {
                assert!((a.length - b.length).abs() < 1e-9, "{} {}", a.length, b.length);
            }
            let [a, b] = [a.clearance.value, b.clearance.value];
            assert!((a - b).abs() < 1e-8, "{a} {b}");
            assert_eq!(found[0], found[2]);
        }
        [Err(a), Err(b), Err(c)] => {
            assert_eq!((a.code, c.code), (b.code, b.code), "{} {}", a.message, b.message);
        }
        _ => panic!("{found:?}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn unions_in_the_plane_move_as_polygons_do(
        width in 0.75..2.0_f64,
        height in 0.75..2.0_f64,
        blocks in proptest::collection::vec((0.0..1.0_f64, 0.0..1.0_f64, 0.3..1.5_f64), 0..5),
        safest in any::<bool>(),
    ) {
        let clearance = if safest { r#""safest""# } else { r#"{"gap": 0.1}"# };
        check_l_shape(width, height, &blocks, clearance);
    }
}

#[test]
fn robots_drive_among_unions() {
    let scene = |solids: &str| {
        format!(
            r#"{{"task": "drive", "free_space": {{"solids": [{solids}],
            "bounds": {{"min": [0, 0], "max": [12, 8]}}}},
            "body": {{"footprint": {{"width": 0.6, "length": 0.9}}}},
            "start": {{"position": [1, 4], "heading": 0}}, "goal": {{"position": [11, 4]}},
            "clearance": {{"gap": 0.2}}}}"#
        )
    };
    let sides = [r#"{"min": [4, 0], "max": [5, 5]}"#, r#"{"min": [5, 2], "max": [8, 5]}"#];
    let union = reply(&scene(&format!(r#"{{"boxes": [{}, {}]}}"#, sides[0], sides[1])));
    let several = format!(r#"{{"box": {}}}, {{"box": {}}}"#, sides[0], sides[1]);
    assert_eq!(union, reply(&scene(&several)));
    assert!(union.answers.unwrap()[0].is_ok());
}
