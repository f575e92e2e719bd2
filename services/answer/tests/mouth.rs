//! Where a part is out of its cavity: at the mouth of the solids, however far it sticks out.

use answer::{Caps, reply_to};
use schemas::json::read_scene;
use schemas::message::{ErrorCode, Refusal, Request, RequestContent, RequestKey, Trajectory};

/// The answer for a body, given by its least and greatest corner, that leaves a hole from z = 1 to
/// z = 4 in a block, seen in a frame in which `exit` is up.
fn answer(task: &str, exit: &str, body: [[f64; 2]; 2]) -> Trajectory {
    let turned = |[x, z]: [f64; 2]| match exit {
        "+z" => [x, z],
        "-z" => [-x, -z],
        "+x" => [z, -x],
        _ => [-z, x],
    };
    let hull = |[a, b]: [[f64; 2]; 2]| {
        let (a, b) = (turned(a), turned(b));
        let [min, max] = [f64::min, f64::max].map(|of| [of(a[0], b[0]), of(a[1], b[1])]);
        format!(r#"{{"box": {{"min": {min:?}, "max": {max:?}}}}}"#)
    };
    let block = [[[0.0, 0.0], [4.0, 1.0]], [[0.0, 0.0], [1.0, 4.0]], [[3.0, 0.0], [4.0, 4.0]]];
    let solids = block.map(hull).join(", ");
    plan(task, exit, &format!(r#"{{"solids": [{solids}]}}"#), &hull(body)).unwrap()
}

/// The only answer to a scene of which free space and body are JSON.
fn plan(task: &str, exit: &str, free_space: &str, body: &str) -> Result<Trajectory, Refusal> {
    let scene = read_scene(&format!(
        r#"{{ "task": "{task}", "free_space": {free_space}, "exit": "{exit}",
            "body": {body}, "clearance": {{ "gap": 0.1 }}, "sampling": {{ "count": 5 }} }}"#
    ));
    let content = RequestContent::Scene(scene.unwrap());
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    reply_to(&request, &Caps::default()).answers?.remove(0)
}

#[test]
fn pin_is_out_when_its_foot_is_at_the_mouth() {
    for exit in ["+z", "-z", "+x", "-x"] {
        for task in ["disassemble", "assemble"] {
            for top in [3.9, 4.0, 4.001, 5.0, 8.0] {
                let found = answer(task, exit, [[1.5, 1.2], [2.5, top]]);
                assert!((found.length - 2.8).abs() < 1e-15, "{task} {exit} {top}: {found:?}");
                assert!((found.clearance.value - 0.2).abs() < 1e-15, "{task} {exit} {top}");
            }
        }
    }
}

#[test]
fn half_drawn_pin_goes_on_from_where_it_is() {
    let found = answer("disassemble", "+z", [[1.5, 3.5], [2.5, 5.0]]);
    assert_eq!(found.length, 0.5);
    let last = found.samples.last().unwrap();
    assert_eq!(last.position.as_slice(), [0.0, 0.5, 0.0]);
}

#[test]
fn half_drawn_pin_leaves_a_channel_that_is_given() {
    for order in [", \"in_order\": true", ""] {
        for (exit, body) in [("+z", [[1.0, 3.5], [2.0, 5.0]]), ("-z", [[1.0, -1.0], [2.0, 0.5]])] {
            let [min, max] = body;
            let free = format!(r#"{{"channels": [{{"min": [0,0], "max": [3,4]}}]{order}}}"#);
            let body = format!(r#"{{"box": {{"min": {min:?}, "max": {max:?}}}}}"#);
            let found = plan("disassemble", exit, &free, &body).unwrap();
            assert_eq!((found.length, found.clearance.value), (0.5, 1.0), "{found:?}");
            // Out of the other end it does not stick.
            let other = if exit == "+z" { "-z" } else { "+z" };
            let refusal = plan("disassemble", other, &free, &body).unwrap_err();
            assert_eq!(refusal.code, ErrorCode::BodyOutsideFreeSpace);
        }
    }
}

#[test]
fn pin_beyond_the_mouth_is_out() {
    for foot in [4.0, 4.25] {
        let found = answer("disassemble", "+z", [[1.5, foot], [2.5, 7.0]]);
        assert_eq!((found.length, found.samples.len()), (0.0, 1), "{found:?}");
    }
}
