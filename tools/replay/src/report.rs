//! What `replay check` prints as text and JSON.

use std::io::{self, Write};

use comparison::check::Checked;
use comparison::describe::counted;
use comparison::exchanges::Contents;
use comparison::report::CheckReport;
use recording::Recovered;
use serde::Serialize;

/// Incomplete exchanges of a file that stderr shows.
const MOST_SHOWN: usize = 10;

/// The first differences, and a line for each file.
pub(crate) fn text(checked: &[Checked], out: &mut impl Write) -> io::Result<()> {
    checked.iter().try_for_each(|file| writeln!(out, "{file}"))
}

/// What is wrong with a recording, a line each.
pub(crate) fn troubles(contents: &Contents) -> impl Iterator<Item = String> {
    let left = contents.incomplete().count().saturating_sub(MOST_SHOWN);
    let error = contents.error.as_ref().map(ToString::to_string);
    let uncovered = (!contents.coverage.is_whole()).then(|| contents.coverage.to_string());
    let error = error.into_iter().chain(uncovered);
    let shown = contents.incomplete().take(MOST_SHOWN);
    let more = (left > 0).then(|| format!("{left} more are incomplete"));
    error.chain(shown).chain(more).chain(missed(contents)).chain(unrecorded(contents))
}

/// How many messages the recorder missed, if any.
pub(crate) fn missed(contents: &Contents) -> Option<String> {
    let lost = contents.lost();
    (lost > 0).then(|| format!("the recorder missed {}", counted(lost, "message")))
}

/// How many messages a killed recorder knew of that are not in its file, if any.
fn unrecorded(contents: &Contents) -> Option<String> {
    let waiting = contents.unrecorded();
    (waiting > 0).then(|| format!("{waiting} messages were sent before its end and are missing"))
}

/// Parts of a recording that are named one by one.
const MOST_NAMED: usize = 20;

/// What is wrong with a file that was recovered, a line each.
pub(crate) fn losses(recovered: &Recovered) -> impl Iterator<Item = String> {
    let dropped = &recovered.dropped;
    let named = dropped.iter().take(MOST_NAMED);
    let left = dropped.len().saturating_sub(MOST_NAMED);
    let reason = recovered.reason.as_ref().map(ToString::to_string);
    let named = named.map(|part| format!("byte {}: {}", part.offset, part.damage));
    let more = (left > 0).then(|| format!("{left} more parts are damaged"));
    reason.into_iter().chain(named).chain(more)
}

/// What was recovered, in words.
pub(crate) fn recovered(recovered: &Recovered) -> String {
    let Recovered { summary, unreadable, unverified, others, .. } = recovered;
    let mut text = format!(
        "{} messages recovered, {} missing in {} gaps, {unreadable} unreadable, {others} of other \
         channels kept",
        summary.recorded, summary.lost, summary.gaps,
    );
    if *unverified > 0 {
        text += &format!(", {unverified} that no checksum covers");
    }
    text
}

/// All files as one JSON object.
pub(crate) fn json(checked: &[Checked], out: &mut impl Write) -> io::Result<()> {
    write_json(&CheckReport::from(checked), out)
}

/// Writes a JSON value and ends the line.
pub(crate) fn write_json(value: &impl Serialize, out: &mut impl Write) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, value)?;
    writeln!(out)
}
