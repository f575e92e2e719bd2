//! `replay extract`: some requests as a recording of their own.

use std::collections::BTreeSet;
use std::error::Error;
use std::io::{self, Write};

use comparison::describe::counted;
use program::warn;
use recording::{Message, Options, Writer};
use schemas::message::{Request, RequestContent};

use crate::arguments::Extract;
use crate::copying::{self, Messages, Picked};
use crate::findings::Findings;
use crate::{check, output};

/// Runs the command; the inner result is that of printing.
pub(crate) fn run(
    arguments: &Extract,
    findings: &mut Findings,
    out: &mut impl Write,
) -> Result<io::Result<()>, Box<dyn Error>> {
    let Extract { file, request, id, failing, output: to, overwrite, .. } = arguments;
    output::check(to, *overwrite, &[file])?;
    let failing: BTreeSet<u64> = match failing {
        false => BTreeSet::new(),
        true => {
            let checked = check::run(&arguments.check(), findings)?;
            findings.regression = false;
            let differences = checked.iter().flat_map(|file| file.differences());
            differences.map(|(case, _)| case.index).collect()
        }
    };
    let wanted = |index: u64, content: &Request| {
        let its_id = match &content.content {
            RequestContent::Scene(scene) => scene.id,
            RequestContent::Unreadable { .. } => None,
        };
        failing.contains(&index)
            || request.contains(&index)
            || its_id.is_some_and(|its| id.contains(&its))
    };
    let named = |error| format!("{}: {error}", file.display());
    let mut messages = Messages::open(file).map_err(named)?;
    let mut picked = Picked::new(&wanted);
    // Created only when there is something to write.
    let (mut writer, mut requests) = (None, 0);
    while let Some((record, _)) = messages.next() {
        picked.learn(messages.asides());
        let Some(record) = picked.pick(record) else { continue };
        let writer = match &mut writer {
            Some(writer) => writer,
            empty => {
                let description = messages.description();
                let overwrite = *overwrite;
                let compression = messages.compression();
                let options = Options { overwrite, description, compression, ..Options::default() };
                empty.insert(Writer::create(to, options)?)
            }
        };
        requests += u64::from(matches!(record.message, Message::Request(_)));
        copying::write(writer, &record)?;
    }
    let others = messages.others();
    messages.end(file, findings);
    if others > 0 && writer.is_some() {
        // They are of no request.
        let others = counted(others, "message");
        warn(format_args!("{}: {others} of other channels left out", file.display()));
    }
    let Some(writer) = writer else {
        warn(format_args!("replay: {} has no such request; nothing written", file.display()));
        findings.failure = true;
        return Ok(Ok(()));
    };
    let summary = writer.finish()?;
    let others = copying::of_others(others, "left out");
    Ok(writeln!(out, "{}{others}", copying::written(to, requests, summary)))
}
