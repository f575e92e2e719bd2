//! Tables in the documents.

use std::fmt::Write;

use integration_tests::scene;
use schemas::message::{
    ClearanceWish, Corners, Curve, Gap, Limits, SceneRequest, Task, Trajectory,
};

use crate::planned::planned;

/// `docs/driving.md`: length and clearances of the two worked corridors at each gap.
pub(crate) fn corridors() -> String {
    let mut table = String::from(
        "| corridor | gap | length | clearance, whole motion | between first and last arc |\n\
         |---|---|---|---|---|\n",
    );
    for (corridor, name) in [("A", "drive-a.json"), ("B", "drive-b.json")] {
        let answers = planned(&scene(name)).answers.expect("the worked corridors can be driven");
        let last = answers.len() - 1;
        for (index, answer) in answers.iter().enumerate() {
            let trajectory = answer.as_ref().expect("the worked corridors have these gaps");
            let safest = if index == last { "safest, " } else { "" };
            _ = writeln!(
                table,
                "| {corridor} | {safest}{} | {} | {} | {} |",
                number(trajectory.gaps[0]),
                number(trajectory.length),
                number(trajectory.clearance.value),
                number(between_arcs(trajectory))
            );
        }
    }
    table
}

/// The least clearance from the first arc to the last.
fn between_arcs(trajectory: &Trajectory) -> f64 {
    let is_arc = |leg: &schemas::message::Leg| matches!(leg.curve, Curve::Arc { .. });
    let legs = &trajectory.legs;
    let first = legs.iter().position(is_arc).expect("corridors have corners");
    let last = legs.iter().rposition(is_arc).expect("corridors have corners");
    legs[first..=last].iter().map(|leg| leg.clearance).fold(f64::INFINITY, f64::min)
}

/// `docs/method.md`: how long motions take by how they pass their corners.
pub(crate) fn corners() -> String {
    let mut table = String::from(
        "| motion | limits | stopping | `arc` | `smooth` | by stopping, `arc`, `smooth` |\n\
         |---|---|---|---|---|---|\n",
    );
    let default = Limits::default();
    let yaw = |yaw_acceleration| Limits { yaw_acceleration: Some(yaw_acceleration), ..default };
    let jerk = |jerk| Limits { jerk: Some(jerk), ..default };
    let rows = [
        ("part, section 4", "disassemble.json", "default", default),
        ("", "disassemble.json", "`jerk` 2", jerk(2.0)),
        ("robot, corridor A", "drive-a.json", "default", default),
        ("", "drive-a.json", "`yaw_acceleration` 0.3", yaw(0.3)),
        ("", "drive-a.json", "`yaw_acceleration` 0.1", yaw(0.1)),
        ("robot, corridor B", "drive-b.json", "default", default),
        ("", "drive-b.json", "`yaw_acceleration` 0.3", yaw(0.3)),
        ("robot, office", "drive-office-boxes.json", "default", default),
        ("", "drive-office-boxes.json", "`yaw_acceleration` 0.3", yaw(0.3)),
    ];
    for (motion, name, limits_named, limits) in rows {
        let clearance = ClearanceWish::Gap(Gap::Uniform(0.2));
        let given = SceneRequest { clearance, limits, ..scene(name) };
        let [stopping, arc, smooth] = ["stopping", "arc", "smooth"].map(|way| {
            let (corners, stop_at_joints) = match way {
                "arc" => (Corners::Arc, None),
                "smooth" => (Corners::Smooth, None),
                _ if given.task == Task::Drive => (Corners::Arc, Some(true)),
                _ => (Corners::Sharp, None),
            };
            let scene = SceneRequest { corners: Some(corners), stop_at_joints, ..given.clone() };
            let mut answers = planned(&scene).answers.expect("these motions can be planned");
            answers.remove(0).expect("a gap of 0.2 m is possible")
        });
        let stops = match smooth.stops {
            None | Some(0) => String::new(),
            Some(stops) => format!(", {stops} stops"),
        };
        let exceeds = match arc.exceeds {
            None => String::new(),
            Some(exceeds) => format!(", jumps of {:.2} rad/s", exceeds.jump),
        };
        let part = |of: &Trajectory| 100.0 * of.duration / stopping.duration;
        _ = writeln!(
            table,
            "| {motion} | {limits_named} | {:.2} s | {:.2} s{exceeds} | {:.2} s{stops} | 100 %, {:.0} %, {:.0} % |",
            stopping.duration,
            arc.duration,
            smooth.duration,
            part(&arc),
            part(&smooth),
        );
    }
    table
}

/// A length to the picometre: rounding errors are smaller.
fn number(value: f64) -> String {
    let text = format!("{value:.12}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
