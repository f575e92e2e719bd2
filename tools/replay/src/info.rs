//! What `replay info` prints.

use std::io::{self, Write};
use std::path::Path;
use std::time::{Duration, UNIX_EPOCH};

use crate::exchanges::Contents;

/// What is in a recording, as text.
pub fn text(path: &Path, contents: &Contents, out: &mut impl Write) -> io::Result<()> {
    let size = std::fs::metadata(path).map_or(contents.bytes, |metadata| metadata.len());
    let mut line = |name: &str, value: String| writeln!(out, "{name:<10}{value}");
    line("file", path.display().to_string())?;
    line("size", format!("{size} bytes"))?;
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
    line("requests", format!("{} from {} clients", contents.requests, contents.clients.len()))?;
    line("replies", format!("{} whole, in {} parts", contents.exchanges, contents.parts))?;
    let (_, gaps) = contents.missing;
    let gaps = contents.summary.map_or(gaps, |summary| summary.gaps.max(gaps));
    line("lost", format!("{} messages in {gaps} gaps", contents.lost()))?;
    line("incomplete", format!(" {} requests or replies", contents.losses.len()))?;
    if contents.skipped > 0 {
        line("others", format!("{} messages of other channels", contents.skipped))?;
    }
    Ok(())
}
