//! An answer that has changed, drawn: both paths over the scene, what they do over time, and
//! their legs.

use std::fmt::Write;

use comparison::compare::AnswerComparison;
use comparison::motion::Deviation;
use render::chart::Chart;
use render::picture::{self, Look};
use schemas::message::{Answer, Leg, Reply, RequestContent, Sample, Trajectory};

use super::escaped;

/// The details of an answer as HTML.
pub(super) fn details(
    request: &RequestContent,
    [recorded, planned]: [&Reply; 2],
    comparison: &AnswerComparison,
) -> String {
    let mut out = String::new();
    _ = write!(out, "<p>{}</p>", escaped(&comparison.to_string()));
    if let Some(first) = &comparison.first {
        _ = write!(
            out,
            r#"<p class="subtle">First difference: {}</p>"#,
            escaped(&first.to_string())
        );
    }
    let [before, now] = [recorded, planned].map(|reply| motion(reply, comparison.answer));
    if let RequestContent::Scene(scene) = request {
        let apart = comparison.motion.as_ref().and_then(|motion| motion.position);
        let apart = apart.and_then(|Deviation { sample, .. }| {
            let place = |motion: Option<&Trajectory>| Some(motion?.samples.get(sample)?.position);
            Some([place(before)?, place(now)?])
        });
        let look = Look { only: comparison.answer, before, apart, ..Look::default() };
        _ = write!(
            out,
            r#"<div class="picture">{}</div>"#,
            picture::draw_with(scene, planned, look)
        );
    }
    charts(&mut out, [before, now]);
    legs(&mut out, [before, now]);
    out
}

/// The motion of an answer, if the reply has it.
fn motion(reply: &Reply, answer: Option<usize>) -> Option<&Trajectory> {
    let answers = reply.answers.as_ref().ok()?;
    answers.get(answer?).map(Answer::as_ref)?.ok()
}

fn charts(out: &mut String, motions: [Option<&Trajectory>; 2]) {
    let over_time = |value: fn(&Sample) -> f64| {
        motions.map(|motion| {
            let samples = motion.map_or(&[][..], |motion| &motion.samples);
            samples.iter().map(|sample| [sample.t, value(sample)]).collect::<Vec<_>>()
        })
    };
    // Clearance is known for each leg, over the path.
    let clearance = motions.map(|motion| {
        let (mut along, mut line) = (0.0, Vec::new());
        for leg in motion.map_or(&[][..], |motion| &motion.legs) {
            line.push([along, leg.clearance]);
            along += leg.length;
            line.push([along, leg.clearance]);
        }
        line
    });
    out.push_str(r#"<div class="charts">"#);
    let mut chart = |name, unit, lines: &[Vec<[f64; 2]>; 2]| {
        let [before, now] = lines;
        out.push_str(&Chart { name, unit, before, now }.draw());
    };
    let speed =
        |sample: &Sample| sample.velocity.iter().map(|speed| speed * speed).sum::<f64>().sqrt();
    chart("m/s", "s, speed", &over_time(speed));
    let headings = over_time(|sample| sample.heading);
    if headings.iter().flatten().any(|[_, heading]| *heading != 0.0) {
        chart("rad", "s, heading", &headings);
    }
    chart("m", "m along the path, clearance of each leg", &clearance);
    out.push_str("</div>");
}

fn legs(out: &mut String, motions: [Option<&Trajectory>; 2]) {
    let legs = motions.map(|motion| motion.map_or(&[][..], |motion| &motion.legs));
    out.push_str(r#"<div class="legs">"#);
    for (index, caption) in ["Legs as recorded", "Legs now"].into_iter().enumerate() {
        let ([these, others], is_there) = match index {
            0 => (legs, motions[0].is_some()),
            _ => ([legs[1], legs[0]], motions[1].is_some()),
        };
        if !is_there {
            continue;
        }
        _ = write!(
            out,
            "<table><caption>{caption}</caption><tr><th>leg<th class=word>kind<th>length, m<th>clearance, m<th class=word>rule</tr>"
        );
        for (at, leg) in these.iter().enumerate() {
            let changed = others.get(at).is_none_or(|other| other != leg);
            let Leg { curve, length, clearance, rule, reverse, .. } = leg;
            let class = if changed { r#" class="changed""# } else { "" };
            let reverse = if *reverse { ", reverse" } else { "" };
            let rule = rule.map_or(String::new(), |rule| rule.to_string());
            _ = write!(
                out,
                "<tr{class}><td>{at}<td class=word>{}{reverse}<td>{length:.6}<td>{clearance:.6}<td class=word>{rule}</tr>",
                curve.kind()
            );
        }
        out.push_str("</table>");
    }
    out.push_str("</div>");
}
