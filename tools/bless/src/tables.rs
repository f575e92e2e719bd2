//! Tables in the documents.

use std::fmt::Write;

use integration_tests::scene;
use schemas::message::{Curve, Trajectory};

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

/// A length to the picometre: rounding errors are smaller.
fn number(value: f64) -> String {
    let text = format!("{value:.12}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
