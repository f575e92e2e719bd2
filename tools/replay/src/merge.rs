//! `replay merge`: several recordings as one.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::io::{self, Write};
use std::path::Path;

use recording::{Aside, FILE_KEY, Message, Options, Record, SERIES_KEY, Writer};
use schemas::message::RequestKey;

use crate::arguments::Merge;
use crate::copying::{self, Messages};
use crate::findings::Findings;
use crate::{check, output};

/// A recording with its next message.
struct Source<'a> {
    path: &'a Path,
    messages: Messages,
    next: Option<(Record, u64)>,
    /// What stands before it.
    asides: Vec<Aside>,
}

impl Source<'_> {
    /// The next message with what stands before it.
    fn take(&mut self) -> Option<(Record, u64, Vec<Aside>)> {
        let (record, lost) = self.next.take()?;
        let asides = std::mem::take(&mut self.asides);
        self.advance();
        Some((record, lost, asides))
    }

    fn advance(&mut self) {
        self.next = self.messages.next();
        self.asides.extend(self.messages.asides());
    }
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
        messages.keep_others();
        let mut source = Source { path, messages, next: None, asides: Vec::new() };
        source.advance();
        sources.push(source);
    }
    let overwrite = *overwrite;
    let description = description(&sources)?;
    let mut writer = Writer::create(to, Options { overwrite, description, ..Options::default() })?;
    // Where each request was found first.
    let mut seen: BTreeMap<RequestKey, usize> = BTreeMap::new();
    let mut requests = 0;
    // The earliest message of all files; of equal times, that of the file named first. Within a
    // file the order stays as it is.
    while let Some(earliest) = earliest(&sources) {
        let source = &mut sources[earliest];
        let Some((record, lost, asides)) = source.take() else { unreachable!("it was there") };
        if let Message::Request(request) = &record.message {
            let first = *seen.entry(request.key).or_insert(earliest);
            if first != earliest {
                let [one, other] = [first, earliest].map(|at| inputs[at].display());
                let key = request.key;
                drop(writer);
                copying::discard(to);
                return Err(format!("request {key} is in {one} and in {other}").into());
            }
            requests += 1;
        }
        writer.lost(lost);
        asides.iter().try_for_each(|aside| writer.write_aside(aside))?;
        copying::write(&mut writer, &record)?;
    }
    let mut others = 0;
    for source in sources {
        source.asides.iter().try_for_each(|aside| writer.write_aside(aside))?;
        writer.leave_out(source.messages.left_out());
        others += source.messages.others();
        writer.lost(source.messages.end(source.path, findings));
    }
    let summary = writer.finish()?;
    findings.loss |= summary.lost > 0;
    let others = copying::of_others(others, "kept");
    Ok(writeln!(out, "{}{others}", copying::written(to, requests, summary)))
}

/// What their recorders wrote at the beginning: as it is where all say the same, else what each
/// says, in order. The replies of a merger are checked under one set of caps, so those must agree.
fn description(sources: &[Source]) -> Result<BTreeMap<String, String>, Box<dyn Error>> {
    let [first, others @ ..] = sources else { return Ok(BTreeMap::new()) };
    let caps = check::recorded_caps(first.path)?;
    for other in others {
        if check::recorded_caps(other.path)? != caps {
            let [one, other] = [first, other].map(|source| source.path.display());
            return Err(format!(
                "{one} and {other} were planned under different caps; in one recording their \
                 replies could not be checked"
            )
            .into());
        }
    }
    let descriptions: Vec<_> = sources.iter().map(|source| source.messages.description()).collect();
    let names: BTreeSet<&String> = descriptions.iter().flat_map(BTreeMap::keys).collect();
    let of_files = ["id", SERIES_KEY, FILE_KEY];
    let names = names.into_iter().filter(|name| !of_files.contains(&name.as_str()));
    let merged = names.map(|name| {
        let mut values: Vec<&str> = Vec::new();
        for value in descriptions.iter().filter_map(|description| description.get(name)) {
            if !values.contains(&value.as_str()) {
                values.push(value);
            }
        }
        // Caps are read from it, and they agree.
        let value = if name == "config" { values[0].to_owned() } else { values.join("; ") };
        (name.clone(), value)
    });
    Ok(merged.collect())
}

fn earliest(sources: &[Source]) -> Option<usize> {
    let heads = sources.iter().enumerate();
    let heads = heads.filter_map(|(at, source)| Some((source.next.as_ref()?.0.log_ns, at)));
    heads.min().map(|(_, at)| at)
}
