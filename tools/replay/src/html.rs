//! Comparisons as a page of their own: one file, without network.

mod difference;

use std::fmt::Write;

use comparison::check::Counts;
use comparison::compare::{AnswerComparison, Comparison, Verdict};
use comparison::describe::short;
use comparison::exchanges::Contents;
use comparison::motion::{Change, Deviation};
use schemas::message::{Reply, RequestContent};

use crate::report::troubles;

/// Differences that are drawn; of more there are only the numbers.
const MOST_DRAWN: usize = 1_000;

/// The details of the answers of a reply that are not equal, each with its place.
pub(crate) type Details = Vec<(Option<usize>, String)>;

/// Draws the answers that are not equal.
pub(crate) fn details(
    request: &RequestContent,
    replies: [&Reply; 2],
    comparison: &Comparison,
) -> Details {
    let listed = comparison.answers.iter().filter(|answer| is_listed(answer));
    listed.map(|answer| (answer.answer, difference::details(request, replies, answer))).collect()
}

fn is_listed(answer: &AnswerComparison) -> bool {
    !matches!(answer.verdict, Verdict::Equal | Verdict::NotRepeatable)
}

/// A page in the making.
pub(crate) struct Page {
    title: String,
    files: String,
    rows: String,
    /// Details that the page shows when asked.
    kept: String,
    count: usize,
    drawn: usize,
    without: Vec<String>,
}

impl Page {
    pub(crate) fn new(title: &str) -> Self {
        let empty = String::new;
        let (files, rows, kept) = (empty(), empty(), empty());
        let title = title.to_owned();
        Self { title, files, rows, kept, count: 0, drawn: 0, without: Vec::new() }
    }

    /// Adds a recording, or a pair of them.
    pub(crate) fn file(&mut self, name: &str, counts: &Counts, contents: &[&Contents]) {
        let Counts { equal, reworded: _, within, different, not_repeatable } = *counts;
        let requests = contents.first().map_or(0, |contents| contents.requests);
        let class = if different > 0 { "different" } else { "" };
        let trouble = contents.iter().flat_map(|contents| troubles(contents));
        let trouble = trouble.collect::<Vec<_>>().join("; ");
        _ = write!(
            self.files,
            "<tr><td>{}<td>{requests}<td>{equal}<td>{within}<td class=\"{class}\">{different}<td>{not_repeatable}<td class=\"word bad\">{}</tr>",
            escaped(name),
            escaped(&trouble)
        );
    }

    /// Adds the answers of a reply that are not equal.
    pub(crate) fn reply(
        &mut self,
        [file, request]: [&str; 2],
        id: Option<u64>,
        comparison: &Comparison,
        details: &Details,
    ) {
        for answer in comparison.answers.iter().filter(|answer| is_listed(answer)) {
            let drawn = details.iter().find(|(index, _)| *index == answer.answer);
            self.answer([file, request], id, answer, drawn.map(|(_, details)| details.as_str()));
        }
    }

    /// Adds a request that has no other to compare with.
    pub(crate) fn alone(&mut self, line: String) {
        self.without.push(line);
    }

    fn answer(
        &mut self,
        [file, request]: [&str; 2],
        id: Option<u64>,
        comparison: &AnswerComparison,
        details: Option<&str>,
    ) {
        let number = self.count;
        self.count += 1;
        let verdict = comparison.verdict.name();
        let text = |value: Option<u64>| value.map_or(String::new(), |value| value.to_string());
        let (id, answer) = (text(id), text(comparison.answer.map(|answer| answer as u64)));
        _ = write!(
            self.rows,
            r#"<tr class="row" tabindex="0" aria-expanded="false" data-n="{number}" data-verdict="{verdict}"><td>{}<td class="word" data-v="{}">{}<td data-v="{id}">{id}<td data-v="{answer}">{answer}<td class="word {verdict}">{verdict}"#,
            escaped(file),
            request.split(' ').next().unwrap_or_default(),
            escaped(request)
        );
        let motion = comparison.motion.as_deref();
        let deviation = |deviation: Option<Deviation>| deviation.map(|it| it.distance);
        let change = |change: Change| Some(change.by()).filter(|by| *by != 0.0);
        let numbers = [
            motion.and_then(|motion| deviation(motion.position)),
            motion.and_then(|motion| deviation(motion.heading)),
            motion.and_then(|motion| deviation(motion.time)),
            motion.and_then(|motion| change(motion.length)),
            motion.and_then(|motion| change(motion.duration)),
            motion.and_then(|motion| change(motion.clearance)),
        ];
        for number in numbers {
            match number {
                Some(number) => {
                    _ = write!(self.rows, r#"<td data-v="{number}">{}"#, short(number));
                }
                None => self.rows.push_str(r#"<td data-v="">"#),
            }
        }
        self.rows.push_str("</tr>\n");
        let details = match details {
            Some(details) if self.drawn < MOST_DRAWN => {
                self.drawn += 1;
                // Nothing in it may end the element that keeps it.
                details.replace("</script", "<\\/script")
            }
            _ => format!("<p>{}</p>", escaped(&comparison.to_string())),
        };
        _ = writeln!(self.kept, r#"<script type="text/plain" id="d{number}">{details}</script>"#);
    }

    /// The page.
    pub(crate) fn finish(self) -> String {
        const STYLE: &str = include_str!("html/page.css");
        const SCRIPT: &str = include_str!("html/page.js");
        let Self { title, files, rows, kept, count, drawn, without } = self;
        let title = escaped(&title);
        let mut out = format!(
            "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n<h1>{title}</h1>\n<p class=\"subtle\">{count} answers differ. Dashed lines are as recorded.</p>\n<table id=\"files\"><thead><tr><th>recording<th>requests<th>equal<th>within tolerance<th>different<th>not compared<th class=word>trouble</thead><tbody>{files}</tbody></table>\n"
        );
        for line in without {
            _ = writeln!(out, "<p class=\"bad\">{}</p>", escaped(&line));
        }
        if count > 0 {
            out.push_str("<div class=\"controls\"><input type=\"search\" id=\"filter\" placeholder=\"filter ( / )\" aria-label=\"filter\">");
            for verdict in ["moved", "vanished", "appeared", "within"] {
                _ = write!(
                    out,
                    "<label><input type=\"checkbox\" checked value=\"{verdict}\"> {verdict}</label>"
                );
            }
            out.push_str("<button id=\"all\">open all shown</button><span id=\"count\" class=\"subtle\" aria-live=\"polite\"></span></div>\n<table id=\"list\"><thead><tr>");
            let words = ["recording", "request", "id", "answer", "verdict"];
            for (at, name) in words.into_iter().enumerate() {
                let number = if matches!(at, 1..=3) { " data-number" } else { "" };
                _ = write!(out, "<th class=\"word\"{number}><button>{name}</button>");
            }
            for name in [
                "position, m",
                "heading, rad",
                "time, s",
                "\u{394} length, m",
                "\u{394} duration, s",
                "\u{394} clearance, m",
            ] {
                _ = write!(out, "<th data-number><button>{name}</button>");
            }
            _ = write!(out, "</tr></thead><tbody>\n{rows}</tbody></table>\n");
            if drawn < count && drawn == MOST_DRAWN {
                _ = writeln!(out, "<p class=\"subtle\">The first {MOST_DRAWN} are drawn.</p>");
            }
        }
        _ = write!(out, "{kept}<script>\n{SCRIPT}</script>\n</html>\n");
        out
    }
}

/// Text that HTML takes as it is.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '&' => escaped.push_str("&amp;"),
            '"' => escaped.push_str("&quot;"),
            _ => escaped.push(character),
        }
    }
    escaped
}
