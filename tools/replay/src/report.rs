//! What `replay check` prints.

use std::fmt;
use std::io::{self, Write};

use serde_json::{Value, json};

use crate::check::{Case, Checked};
use crate::compare::{Difference, Outcome};
use crate::exchanges::Contents;

/// Differences and losses of a file that the text shows; the other forms have all.
const MOST_SHOWN: usize = 10;

/// The result as text: what differs first, and a line for each file.
pub fn text(checked: &[Checked], out: &mut impl Write) -> io::Result<()> {
    for file in checked {
        let path = file.path.display();
        for (case, difference) in different(file).take(MOST_SHOWN) {
            writeln!(out, "{path}: {case}: {difference}")?;
        }
        let counts = file.counts();
        let left = counts.different.saturating_sub(MOST_SHOWN as u64);
        if left > 0 {
            writeln!(out, "{path}: {left} more requests differ")?;
        }
        writeln!(out, "{path}: {}", verdict(file))?;
    }
    Ok(())
}

/// One line about a file.
fn verdict(file: &Checked) -> String {
    let (counts, contents) = (file.counts(), &file.contents);
    let mut parts = vec![format!("{} requests", contents.requests)];
    let numbers = [
        (counts.equal, "equal"),
        (counts.different, "different"),
        (counts.not_repeatable, "not repeatable (late or overloaded)"),
        (contents.losses.len() as u64, "incomplete"),
        (contents.lost(), "messages lost while recording"),
    ];
    parts.extend(
        numbers.iter().filter(|(n, _)| *n > 0).map(|(number, what)| format!("{number} {what}")),
    );
    match &contents.error {
        Some(error) if error.is_cut() => parts.push("cut".into()),
        Some(_) => parts.push("not readable to its end".into()),
        None => {}
    }
    parts.join(", ")
}

/// What is missing from a file, for standard error.
pub fn complain(
    path: impl fmt::Display,
    contents: &Contents,
    out: &mut impl Write,
) -> io::Result<()> {
    if let Some(error) = &contents.error {
        writeln!(out, "{path}: {error}")?;
    }
    for loss in contents.losses.iter().take(MOST_SHOWN) {
        writeln!(out, "{path}: {loss}")?;
    }
    let left = contents.losses.len().saturating_sub(MOST_SHOWN);
    if left > 0 {
        writeln!(out, "{path}: {left} more are incomplete")?;
    }
    if contents.lost() > 0 {
        writeln!(out, "{path}: the recorder missed {} messages", contents.lost())?;
    }
    Ok(())
}

/// The result as one JSON object.
pub fn json(checked: &[Checked], out: &mut impl Write) -> io::Result<()> {
    let files: Vec<_> = checked.iter().map(file_json).collect();
    serde_json::to_writer_pretty(&mut *out, &json!({ "files": files }))?;
    writeln!(out)
}

fn file_json(file: &Checked) -> Value {
    let (counts, contents) = (file.counts(), &file.contents);
    let differences: Vec<_> = different(file)
        .map(|(case, difference)| {
            let place = &difference.place;
            json!({
                "request": case.index,
                "key": case.key.to_string(),
                "answer": place.answer,
                "list": place.item.map(|(list, _)| list),
                "index": place.item.map(|(_, index)| index),
                "field": place.field,
                "recorded": difference.recorded,
                "planned": difference.planned,
                "distance": difference.distance.filter(|distance| distance.is_finite()),
            })
        })
        .collect();
    json!({
        "path": file.path.to_string_lossy(),
        "requests": contents.requests,
        "equal": counts.equal,
        "different": counts.different,
        "not_repeatable": counts.not_repeatable,
        "differences": differences,
        "incomplete": contents.losses.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "lost": contents.lost(),
        "cut": contents.error.as_ref().is_some_and(|error| error.is_cut()),
        "error": contents.error.as_ref().map(ToString::to_string),
    })
}

/// The result as JUnit XML: a suite for each file, a case for each request.
pub fn junit(checked: &[Checked], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(out, r#"<testsuites name="replay check">"#)?;
    for file in checked {
        let (counts, contents) = (file.counts(), &file.contents);
        let path = file.path.to_string_lossy();
        let path = Escaped(&path);
        // What is wrong with the file itself, as cases beside the requests.
        let mut troubles: Vec<_> = contents.losses.iter().map(ToString::to_string).collect();
        troubles.extend(contents.error.as_ref().map(ToString::to_string));
        if contents.lost() > 0 {
            troubles.push(format!("the recorder missed {} messages", contents.lost()));
        }
        writeln!(
            out,
            r#"  <testsuite name="{path}" tests="{}" failures="{}" errors="{}" skipped="{}">"#,
            file.cases.len() + troubles.len(),
            counts.different,
            troubles.len(),
            counts.not_repeatable,
        )?;
        for case in &file.cases {
            write!(out, r#"    <testcase name="{case}" classname="{path}""#)?;
            match &case.outcome {
                Outcome::Equal => writeln!(out, "/>")?,
                Outcome::NotRepeatable => {
                    writeln!(out, r#"><skipped message="late or overloaded"/></testcase>"#)?;
                }
                Outcome::Different(difference) => {
                    let text = difference.to_string();
                    let text = Escaped(&text);
                    writeln!(out, r#"><failure message="{text}"/></testcase>"#)?;
                }
            }
        }
        for (index, trouble) in troubles.iter().enumerate() {
            let text = Escaped(trouble);
            writeln!(
                out,
                r#"    <testcase name="recording {index}" classname="{path}"><error message="{text}"/></testcase>"#,
            )?;
        }
        writeln!(out, "  </testsuite>")?;
    }
    writeln!(out, "</testsuites>")
}

fn different(file: &Checked) -> impl Iterator<Item = (&Case, &Difference)> {
    file.cases.iter().filter_map(|case| match &case.outcome {
        Outcome::Different(difference) => Some((case, &**difference)),
        Outcome::Equal | Outcome::NotRepeatable => None,
    })
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "request {} ({})", self.index, self.key)
    }
}

/// Text within an XML attribute.
struct Escaped<'a>(&'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.chars().try_for_each(|character| match character {
            '&' => f.write_str("&amp;"),
            '<' => f.write_str("&lt;"),
            '>' => f.write_str("&gt;"),
            '"' => f.write_str("&quot;"),
            // XML 1.0 has no form for these.
            '\0'..'\x20' | '\u{fffe}' | '\u{ffff}' => f.write_str(" "),
            _ => write!(f, "{character}"),
        })
    }
}
