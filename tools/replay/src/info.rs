//! What `replay info` prints.

use std::io::{self, Write};
use std::path::Path;
use std::time::{Duration, UNIX_EPOCH};

use comparison::describe::counted;
use comparison::exchanges::Contents;
use recording::TOPICS_KEY;
use serde_json::json;

use crate::report::write_json;

fn size(path: &Path, contents: &Contents) -> u64 {
    std::fs::metadata(path).map_or(contents.bytes, |metadata| metadata.len())
}

fn gaps(contents: &Contents) -> u64 {
    let (_, gaps) = contents.missing;
    contents.summary.map_or(gaps, |summary| summary.gaps.max(gaps))
}

/// A recording described in lines.
pub(crate) fn text(path: &Path, contents: &Contents, out: &mut impl Write) -> io::Result<()> {
    let mut line = |name: &str, value: String| writeln!(out, "{name:<10}{value}");
    line("file", path.display().to_string())?;
    line("size", format!("{} bytes", size(path, contents)))?;
    line("library", contents.library.clone())?;
    let state = match (&contents.error, contents.summary) {
        (Some(error), _) => error.to_string(),
        (None, Some(_)) => "finished".into(),
        (None, None) => "ended without a summary".into(),
    };
    line("state", state)?;
    if let Some((first, last)) = contents.times_ns {
        let time = |ns| humantime::format_rfc3339_nanos(UNIX_EPOCH + Duration::from_nanos(ns));
        line("from", time(first).to_string())?;
        line("to", time(last).to_string())?;
        let duration = Duration::from_nanos(last - first);
        line("duration", humantime::format_duration(duration).to_string())?;
    }
    let clients = counted(contents.clients.len() as u64, "client");
    line("requests", format!("{} from {clients}", contents.requests))?;
    let parts = counted(contents.parts, "part");
    line("replies", format!("{} whole, in {parts}", contents.exchanges))?;
    let [lost, gaps] = [(contents.lost(), "message"), (gaps(contents), "gap")]
        .map(|(count, what)| counted(count, what));
    line("lost", format!("{lost} in {gaps}"))?;
    if let Some(left_out) =
        contents.summary.map(|summary| summary.left_out).filter(|&left| left > 0)
    {
        line("left out", counted(left_out, "message"))?;
    }
    line("broken", format!("{} requests or replies", contents.losses.len()))?;
    for (name, requests) in &contents.missing_free_spaces {
        line("missing", format!("free space {name}, {requests} requests"))?;
    }
    line("checksums", contents.coverage.to_string())?;
    if let Some(beat) = contents.heartbeat.filter(|_| contents.summary.is_none()) {
        let waiting = contents.unrecorded();
        let when = humantime::format_rfc3339_nanos(UNIX_EPOCH + Duration::from_nanos(beat.time_ns));
        // Nobody has seen of which topics they are.
        let least = if contents.description.contains_key(TOPICS_KEY) { "at most " } else { "" };
        let text = format!("{when}; {least}{waiting} messages were sent and not recorded then");
        line("last sign", text)?;
    }
    for (name, value) in &contents.description {
        line(name, value.clone())?;
    }
    if contents.statuses > 0 {
        line("statuses", contents.statuses.to_string())?;
    }
    if contents.skipped > 0 {
        let messages = counted(contents.skipped, "message");
        line("others", format!("{messages} of other channels"))?;
    }
    Ok(())
}

/// A recording described as one JSON object.
pub(crate) fn json(path: &Path, contents: &Contents, out: &mut impl Write) -> io::Result<()> {
    let Contents {
        bytes: _,
        library,
        requests,
        parts,
        exchanges,
        clients,
        times_ns,
        losses: _,
        missing_free_spaces,
        missing: _,
        summary,
        skipped,
        statuses,
        coverage,
        heartbeat,
        next_number: _,
        description,
        error,
    } = contents;
    let value = json!({
        "path": path.to_string_lossy(),
        "bytes": size(path, contents),
        "library": library,
        "finished": summary.is_some() && error.is_none(),
        "cut": error.as_ref().is_some_and(|error| error.is_cut()),
        "error": error.as_ref().map(ToString::to_string),
        "first_ns": times_ns.map(|(first, _)| first),
        "last_ns": times_ns.map(|(_, last)| last),
        "requests": requests,
        "clients": clients.len(),
        "replies": exchanges,
        "parts": parts,
        "lost": contents.lost(),
        "gaps": gaps(contents),
        "left_out": summary.map_or(0, |summary| summary.left_out),
        "incomplete": contents.incomplete().collect::<Vec<_>>(),
        "missing_free_spaces": missing_free_spaces.keys().map(ToString::to_string).collect::<Vec<_>>(),
        "other_messages": skipped,
        "statuses": statuses,
        "bytes_of_messages": coverage.bytes,
        "unchecked_bytes": coverage.bytes - coverage.checked,
        "unrecorded": contents.unrecorded(),
        "last_sign_of_life_ns": heartbeat.map(|beat| beat.time_ns),
        "description": description,
    });
    write_json(&value, out)
}
