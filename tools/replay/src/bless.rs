//! `replay bless`: what is planned now becomes what is expected.

mod committed;
pub(crate) mod only;

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use answer::{Answerer, Caps};
use comparison::check::{Case, Checked};
use comparison::compare::{Outcome, Verdict};
use comparison::named::NamedFreeSpaces;
use configuration::Config;
use program::warn;
use recording::{Message, Options, Writer};
use schemas::message::{ReplyPart, RequestKey};

use crate::arguments::Bless;
use crate::check;
use crate::copying::{self, Messages};
use crate::findings::Findings;

/// Runs the command; the inner result is that of printing.
pub(crate) fn run(
    arguments: &Bless,
    findings: &mut Findings,
    out: &mut impl Write,
) -> Result<io::Result<()>, Box<dyn Error>> {
    let asked =
        arguments.config.as_deref().map(Config::read).transpose()?.map(|config| config.caps);
    let checked = check::run(&arguments.check(), findings)?;
    findings.regression = false;
    let mut blessed: Vec<(Checked, BTreeSet<u64>)> = Vec::new();
    for file in checked {
        if let Some(error) = &file.contents.error {
            let path = file.path.display();
            warn(format_args!("{path} is left as it is: {error} (replay recover)"));
            continue;
        }
        if file.more > 0 {
            let (path, files) = (file.path.display(), file.more + 1);
            warn(format_args!(
                "{path} is left as it is: the recording has {files} files; `replay merge` makes \
                 one of them"
            ));
            findings.failure = true;
            continue;
        }
        let accepted = file.cases.iter().filter(|case| is_accepted(arguments, case));
        let accepted: BTreeSet<u64> = accepted.map(|case| case.index).collect();
        blessed.push((file, accepted));
    }
    // All or none: nobody wants to find out which half was written.
    if !arguments.uncommitted {
        let changed = blessed.iter().filter(|(_, accepted)| !accepted.is_empty());
        for (file, _) in changed {
            committed::check(&file.path)?;
        }
    }
    for (file, accepted) in &blessed {
        if !accepted.is_empty() {
            let caps = asked.map_or_else(|| check::recorded_caps(&file.path), Ok)?;
            rewrite(&file.path, accepted, &caps, findings)?;
        }
        if let Err(error) = tell(file, accepted, out) {
            return Ok(Err(error));
        }
    }
    Ok(Ok(()))
}

/// Whether the reply has changed, if only by a bit, and is to be accepted.
fn is_accepted(arguments: &Bless, case: &Case) -> bool {
    let answers = &case.comparison.answers;
    let is_within = answers.iter().any(|answer| answer.verdict == Verdict::Within);
    let differs = matches!(case.comparison.outcome, Outcome::Different(_)) || is_within;
    let only = &arguments.only;
    differs && (only.is_empty() || only.iter().any(|only| only.includes(case)))
}

fn tell(file: &Checked, accepted: &BTreeSet<u64>, out: &mut impl Write) -> io::Result<()> {
    let path = file.path.display();
    for case in file.cases.iter().filter(|case| accepted.contains(&case.index)) {
        let id = case.id.map_or(String::new(), |id| format!(", id {id}"));
        writeln!(out, "{path}: request {} ({}{id}) accepted", case.index, case.key)?;
        let changed = case.comparison.answers.iter();
        for answer in changed.filter(|answer| answer.verdict != Verdict::Equal) {
            writeln!(out, "    {answer}")?;
        }
    }
    let (accepted, replies) = (accepted.len(), file.cases.len());
    writeln!(out, "{path}: {accepted} of {replies} replies accepted")
}

/// Writes the recording anew with the replies to these requests as they are planned now. Requests
/// and other replies stay byte for byte.
fn rewrite(
    path: &Path,
    accepted: &BTreeSet<u64>,
    caps: &Caps,
    findings: &mut Findings,
) -> Result<(), Box<dyn Error>> {
    let new = beside(path);
    let written = rewrite_to(&new, path, accepted, caps, findings);
    let renamed = written.and_then(|()| Ok(fs::rename(&new, path)?));
    if renamed.is_err() {
        // The error counts, not whether the half of a file can be removed.
        _ = fs::remove_file(&new);
    }
    renamed
}

/// A new file that takes the place of the old one only when it is whole.
fn beside(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".new");
    path.with_file_name(name)
}

fn rewrite_to(
    new: &Path,
    path: &Path,
    accepted: &BTreeSet<u64>,
    caps: &Caps,
    findings: &mut Findings,
) -> Result<(), Box<dyn Error>> {
    let named = |error| format!("{}: {error}", path.display());
    let mut messages = Messages::open(path).map_err(named)?;
    let description = messages.description();
    let options = Options { overwrite: true, description, ..Options::default() };
    let mut writer = Writer::create(new, options)?;
    let mut free_spaces = NamedFreeSpaces::default();
    let mut planned: BTreeMap<RequestKey, Vec<ReplyPart>> = BTreeMap::new();
    let mut requests = 0;
    while let Some((record, lost)) = messages.next() {
        writer.lost(lost);
        for mut upload in messages.free_spaces() {
            writer.write_free_space(&upload, record.log_ns)?;
            free_spaces.resolve(&mut upload);
        }
        match &record.message {
            Message::Request(request) => {
                copying::write(&mut writer, &record)?;
                let mut request = request.clone();
                free_spaces.resolve(&mut request);
                let key = request.key;
                match accepted.contains(&requests) {
                    true => planned.insert(key, Answerer::new(caps).parts_to(&request)),
                    false => planned.remove(&key),
                };
                requests += 1;
            }
            Message::Reply(part) => match planned.get(&part.key) {
                None => copying::write(&mut writer, &record)?,
                Some(_) if !part.last => {}
                Some(_) => {
                    for new in planned.remove(&part.key).into_iter().flatten() {
                        let new = ReplyPart { sent_ns: part.sent_ns, ..new };
                        writer.write_reply(&new, record.log_ns)?;
                    }
                }
            },
        }
    }
    let lost = messages.end(path, findings);
    writer.lost(lost);
    writer.finish()?;
    Ok(())
}
