//! `replay merge`: several recordings as one.

use std::collections::BTreeMap;
use std::error::Error;
use std::io::{self, Write};
use std::path::Path;

use recording::{Message, Options, Record, Writer};
use schemas::message::RequestKey;

use crate::arguments::Merge;
use crate::copying::{self, Messages};
use crate::findings::Findings;
use crate::output;

/// A recording with its next message.
struct Source<'a> {
    path: &'a Path,
    messages: Messages,
    next: Option<(Record, u64)>,
}

/// Runs the command; the inner result is that of printing.
pub(crate) fn run(
    arguments: &Merge,
    findings: &mut Findings,
    out: &mut impl Write,
) -> Result<io::Result<()>, Box<dyn Error>> {
    let Merge { files, output: to, overwrite } = arguments;
    let inputs: Vec<&Path> = files.iter().map(|path| &**path).collect();
    output::check(to, *overwrite, &inputs)?;
    let mut sources = Vec::with_capacity(files.len());
    for path in &inputs {
        let named = |error| format!("{}: {error}", path.display());
        let mut messages = Messages::open(path).map_err(named)?;
        let next = messages.next();
        sources.push(Source { path, messages, next });
    }
    let mut writer = Writer::create(to, Options { overwrite: *overwrite, ..Options::default() })?;
    // Where each request was found first.
    let mut seen: BTreeMap<RequestKey, usize> = BTreeMap::new();
    let mut requests = 0;
    // The earliest message of all files; of equal times, that of the file named first. Within a
    // file the order stays as it is.
    while let Some(earliest) = earliest(&sources) {
        let source = &mut sources[earliest];
        let Some((record, lost)) = source.next.take() else { unreachable!("it was just there") };
        source.next = source.messages.next();
        if let Message::Request(request) = &record.message {
            let first = *seen.entry(request.key).or_insert(earliest);
            if first != earliest {
                let [one, other] = [first, earliest].map(|at| inputs[at].display());
                let key = request.key;
                drop(writer);
                // What was there before stays; of the new one there is only a part.
                let mut part = to.clone().into_os_string();
                part.push(".part");
                _ = std::fs::remove_file(part);
                return Err(format!("request {key} is in {one} and in {other}").into());
            }
            requests += 1;
        }
        writer.lost(lost);
        copying::write(&mut writer, &record)?;
    }
    for source in sources {
        writer.lost(source.messages.end(source.path, findings));
    }
    let summary = writer.finish()?;
    findings.loss |= summary.lost > 0;
    Ok(writeln!(out, "{}", copying::written(to, requests, summary)))
}

fn earliest(sources: &[Source]) -> Option<usize> {
    let heads = sources.iter().enumerate();
    let heads = heads.filter_map(|(at, source)| Some((source.next.as_ref()?.0.log_ns, at)));
    heads.min().map(|(_, at)| at)
}
