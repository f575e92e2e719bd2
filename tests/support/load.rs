//! Requests that take the planner more or less time.

use schemas::json::read_scene;
use schemas::message::{Choice, ClearanceWish, Gap, Sampling, SceneRequest};

use crate::scene;

/// Section 4 with two samples: microseconds.
pub fn short(id: u64) -> SceneRequest {
    let sampling = Some(Sampling::Count(2));
    SceneRequest { id: Some(id), sampling, ..scene("disassemble-channels.json") }
}

/// A robot among pillars, asked for so many gaps: some milliseconds each.
pub fn long(id: u64, answers: u32) -> SceneRequest {
    let gap = |index| Choice::Gap(Gap::Uniform(0.1 + 1e-6 * f64::from(index)));
    let clearance = ClearanceWish::Each((0..answers).map(gap).collect());
    SceneRequest { id: Some(id), clearance, ..pillars(12) }
}

/// The same among many more: it is never answered at once.
pub fn slow(id: u64) -> SceneRequest {
    let clearance = ClearanceWish::Gap(Gap::Uniform(0.1));
    SceneRequest { id: Some(id), clearance, ..pillars(50) }
}

/// Answers to [`endless`].
pub const ENDLESS: u32 = 9_999;

/// Minutes.
pub fn endless(id: u64) -> SceneRequest {
    SceneRequest { clearance: long(id, ENDLESS).clearance, ..slow(id) }
}

/// A robot on its way through a square of pillars.
fn pillars(side: u32) -> SceneRequest {
    let mut solids = Vec::new();
    for row in 0..side {
        for column in 0..side {
            let (x, y) = (3.0 * f64::from(column) + 2.0, 3.0 * f64::from(row) + 2.0);
            let at = x + 0.125 * f64::from((3 * row + column) % 5);
            let (max_x, max_y) = (at + 1.0, y + 1.0);
            solids.push(format!(r#"{{"box": {{"min": [{at}, {y}], "max": [{max_x}, {max_y}]}}}}"#));
        }
    }
    let (solids, extent) = (solids.join(", "), 3 * side + 4);
    let goal = extent - 1;
    let scene = format!(
        r#"{{ "task": "drive",
              "free_space": {{ "solids": [{solids}],
                               "bounds": {{ "min": [0, 0], "max": [{extent}, {extent}] }} }},
              "body": {{ "footprint": {{ "width": 0.5, "length": 0.75 }} }},
              "start": {{ "position": [1, 1], "heading": 0 }},
              "goal": {{ "position": [{goal}, {goal}] }}, "clearance": "safest",
              "sampling": {{ "count": 2 }} }}"#
    );
    read_scene(&scene).expect("a scene")
}
