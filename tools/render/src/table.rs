//! Replies as tables in a terminal.

use std::io::{self, Write};

use comfy_table::{CellAlignment, Table, presets};
use schemas::message::{Answer, Curve, Leg, Refusal, Reply, SceneRequest, Trajectory, Vector};

/// Writes a reply as tables: a row for each answer, and the legs if there is only one. `scene`
/// is `None` if it could not be read.
pub fn write(
    out: &mut impl Write,
    name: &str,
    scene: Option<&SceneRequest>,
    reply: &Reply,
) -> io::Result<()> {
    let id = reply.id.map_or(String::new(), |id| format!(" (id {id})"));
    let task = scene.map_or(String::new(), |scene| format!("{}: ", scene.task));
    match &reply.answers {
        Err(refusal) => writeln!(out, "{name}{id}: {task}{}\n", refused(refusal)),
        Ok(answers) => {
            writeln!(out, "{name}{id}: {}", task.trim_end_matches(": "))?;
            writeln!(out, "{}", answers_table(answers))?;
            // Below the table: messages would widen its columns.
            for (index, answer) in answers.iter().enumerate() {
                if let Err(refusal) = answer {
                    writeln!(out, "  answer {index}: {}", refused(refusal))?;
                }
            }
            if let [Ok(trajectory)] = answers.as_slice() {
                writeln!(out, "{}", legs_table(&trajectory.legs))?;
            }
            writeln!(out)
        }
    }
}

/// A refusal in one line.
pub fn refused(refusal: &Refusal) -> String {
    format!("refused, {}: {}", refusal.code, refusal.message)
}

/// A table without frames; all columns but the first are right-aligned.
pub fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header(header);
    for (index, column) in table.column_iter_mut().enumerate() {
        column.set_padding((if index == 0 { 2 } else { 1 }, 1));
        if index > 0 {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

fn answers_table(answers: &[Answer]) -> Table {
    let mut table = table(&["gap", "length", "clearance", "at", "duration", "legs", "samples"]);
    for answer in answers {
        match answer {
            Ok(trajectory) => table.add_row([
                gaps(trajectory),
                format!("{:.6} m", trajectory.length),
                format!("{:.6} m", trajectory.clearance.value),
                format!("{:.3} m", trajectory.clearance.at),
                format!("{:.3} s", trajectory.duration),
                trajectory.legs.len().to_string(),
                trajectory.samples.len().to_string(),
            ]),
            Err(_) => table.add_row(["refused", "-", "-", "-", "-", "-", "-"]),
        };
    }
    table
}

fn legs_table(legs: &[Leg]) -> Table {
    let has_rungs = legs.iter().any(|leg| leg.rung.is_some());
    let rung = if has_rungs { &["rung"][..] } else { &[] };
    let mut table = table(&[&["leg", "from", "to", "length", "clearance", "rule"], rung].concat());
    for leg in legs {
        let (from, to) = match &leg.curve {
            Curve::Line { from, to, .. } => (point(from), point(to)),
            Curve::Arc { center, radius, sweep, .. } => (
                format!("about {} r {radius:.3}", point(center)),
                format!("{:+.1}°", sweep.to_degrees()),
            ),
            Curve::Clothoid { from, to, .. } => (point(from), point(to)),
            Curve::Turn { position, sweep, .. } => {
                (point(position), format!("{:+.1}°", sweep.to_degrees()))
            }
        };
        let reverse = if leg.reverse { ", reverse" } else { "" };
        let mut row = vec![
            format!("{}{reverse}", leg.curve.kind()),
            from,
            to,
            format!("{:.6} m", leg.length),
            format!("{:.6} m", leg.clearance),
            leg.rule.map_or(String::new(), |rule| {
                let junction = leg.junction.map_or(String::new(), |at| format!(", junction {at}"));
                format!("{rule}{junction}")
            }),
        ];
        if has_rungs {
            row.push(leg.rung.map_or(String::new(), |rung| rung.to_string()));
        }
        table.add_row(row);
    }
    table
}

fn point(point: &Vector) -> String {
    let coordinates: Vec<_> =
        point.as_slice().iter().map(|coordinate| format!("{coordinate:.3}")).collect();
    format!("({})", coordinates.join(", "))
}

/// The gaps of a trajectory in brief: one number if all are equal.
pub fn gaps(trajectory: &Trajectory) -> String {
    let gaps = &trajectory.gaps;
    match gaps.first() {
        None => "-".to_owned(),
        Some(first) if gaps.iter().all(|gap| gap == first) => number(*first),
        Some(_) => {
            let junctions = gaps.chunks(trajectory.gaps_per_junction.max(1) as usize);
            let mut text: Vec<_> = junctions
                .map(|axes| axes.iter().map(|gap| number(*gap)).collect::<Vec<_>>().join("/"))
                .collect();
            if text.len() > 4 {
                text.truncate(3);
                text.push("...".to_owned());
            }
            text.join(" ")
        }
    }
}

/// A number to micrometres, without trailing zeros.
fn number(value: f64) -> String {
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use schemas::message::Rung;

    use super::*;

    #[test]
    fn legs_say_how_they_were_found_and_driven() {
        let turn = Curve::Turn {
            position: [1.0, 2.0].into(),
            from_heading: 0.0,
            to_heading: 1.0,
            sweep: 1.0,
        };
        let (from, to) = ([1.0, 2.0].into(), [3.0, 2.0].into());
        let line = Curve::Line { from, to, heading: 0.0, turned: 0.0 };
        let plain = [Leg::new(turn, 0.0, 0.5), Leg::new(line, 2.0, 0.25)];
        let text = legs_table(&plain).to_string();
        assert!(!text.contains("rung") && !text.contains("reverse"), "{text}");
        let legs = plain.map(|leg| Leg { rung: Some(Rung::Aligned), ..leg });
        let legs = [legs[0], Leg { reverse: true, ..legs[1] }];
        let text = legs_table(&legs).to_string();
        let rows: Vec<&str> = text.lines().collect();
        assert!(rows[0].trim_end().ends_with("rung"), "{text}");
        assert!(rows[2].trim_start().starts_with("line, reverse"), "{text}");
        assert!(rows[1..].iter().all(|row| row.trim_end().ends_with("aligned")), "{text}");
    }
}
