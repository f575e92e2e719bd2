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
use comparison::describe::counted;
use comparison::named::NamedFreeSpaces;
use configuration::Config;
use program::warn;
use recording::{Aside, Message, Options, Record, Writer};
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
        let accepted = file.cases.iter().filter(|case| is_accepted(arguments, case));
        let accepted: BTreeSet<u64> = accepted.map(|case| case.index).collect();
        blessed.push((file, accepted));
    }
    // All or none: nobody wants to find out which half was written.
    if !arguments.uncommitted {
        let changed = blessed.iter().filter(|(_, accepted)| !accepted.is_empty());
        for (file, _) in changed {
            files(file).try_for_each(committed::check)?;
        }
    }
    for (file, accepted) in &blessed {
        if !accepted.is_empty() {
            let caps = asked.map_or_else(|| check::recorded_caps(&file.path), Ok)?;
            let files: Vec<&Path> = files(file).collect();
            rewrite(&files, accepted, &caps, findings)?;
        }
        if let Err(error) = tell(file, accepted, out) {
            return Ok(Err(error));
        }
    }
    Ok(Ok(()))
}

/// The files of a recording.
fn files(recording: &Checked) -> impl Iterator<Item = &Path> {
    std::iter::once(&recording.path).chain(&recording.more).map(PathBuf::as_path)
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

/// Writes the files of a recording anew with the replies to these requests as they are planned now.
/// Requests, other replies, statuses and messages of other channels stay byte for byte.
fn rewrite(
    files: &[&Path],
    accepted: &BTreeSet<u64>,
    caps: &Caps,
    findings: &mut Findings,
) -> Result<(), Box<dyn Error>> {
    let mut blessing = Blessing {
        accepted,
        caps,
        free_spaces: NamedFreeSpaces::default(),
        planned: BTreeMap::new(),
        requests: 0,
        ended: None,
    };
    let new: Vec<PathBuf> = files.iter().map(|path| beside(path)).collect();
    let written =
        files.iter().zip(&new).try_for_each(|(path, new)| blessing.rewrite(path, new, findings));
    // Each takes the place of the old one only when all are whole.
    let renamed = written.and_then(|()| {
        Ok(new.iter().zip(files).try_for_each(|(new, path)| fs::rename(new, path))?)
    });
    if renamed.is_err() {
        // The error counts, not whether what was begun can be removed.
        for path in &new {
            copying::discard(path);
            _ = fs::remove_file(path);
        }
    }
    renamed
}

/// A new file in the folder of the old one.
fn beside(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".new");
    path.with_file_name(name)
}

/// A recording that is written anew, file by file.
struct Blessing<'a> {
    /// The requests whose replies are planned, from 0.
    accepted: &'a BTreeSet<u64>,
    caps: &'a Caps,
    free_spaces: NamedFreeSpaces,
    /// Replies that take the place of those that come.
    planned: BTreeMap<RequestKey, Vec<ReplyPart>>,
    /// Requests so far.
    requests: u64,
    /// The number of the message after the file before, in the old recording and in the new.
    ended: Option<[u64; 2]>,
}

impl Blessing<'_> {
    fn rewrite(
        &mut self,
        path: &Path,
        new: &Path,
        findings: &mut Findings,
    ) -> Result<(), Box<dyn Error>> {
        let named = |error| format!("{}: {error}", path.display());
        let mut messages = Messages::open(path).map_err(named)?;
        messages.keep_others();
        let mut next = messages.next();
        let begin = messages.begin().unwrap_or(0);
        // Numbers go on through the files, and what is missing between them stays missing.
        let first = match self.ended {
            Some([old, new]) => new + begin.saturating_sub(old),
            None => begin,
        };
        let options = Options {
            overwrite: true,
            first,
            id: messages.id(),
            compression: messages.compression(),
            description: messages.description(),
            ..Options::default()
        };
        let mut writer = Writer::create(new, options)?;
        while let Some((record, lost)) = next {
            writer.lost(lost);
            self.write_asides(&mut messages, &mut writer)?;
            self.write(&record, &mut writer)?;
            next = messages.next();
        }
        self.write_asides(&mut messages, &mut writer)?;
        let old = messages.sequence();
        if messages.others() > 0 {
            let others = counted(messages.others(), "message");
            warn(format_args!(
                "{}: {others} of other channels kept as they are; those that show replies show the \
                 old ones (replay export)",
                path.display()
            ));
        }
        writer.leave_out(messages.left_out());
        writer.lost(messages.end(path, findings));
        self.ended = old.map(|old| [old, writer.sequence()]);
        writer.finish()?;
        Ok(())
    }

    fn write_asides(
        &mut self,
        messages: &mut Messages,
        writer: &mut Writer,
    ) -> Result<(), Box<dyn Error>> {
        for aside in messages.asides() {
            writer.write_aside(&aside)?;
            if let Aside::FreeSpace { mut request, .. } = aside {
                self.free_spaces.resolve(&mut request);
            }
        }
        Ok(())
    }

    fn write(&mut self, record: &Record, writer: &mut Writer) -> Result<(), Box<dyn Error>> {
        match &record.message {
            Message::Request(request) => {
                copying::write(writer, record)?;
                let mut request = request.clone();
                self.free_spaces.resolve(&mut request);
                let key = request.key;
                match self.accepted.contains(&self.requests) {
                    true => self.planned.insert(key, Answerer::new(self.caps).parts_to(&request)),
                    false => self.planned.remove(&key),
                };
                self.requests += 1;
            }
            Message::Reply(part) => match self.planned.get(&part.key) {
                None => copying::write(writer, record)?,
                Some(_) if !part.last => {}
                Some(_) => {
                    for new in self.planned.remove(&part.key).into_iter().flatten() {
                        let new = ReplyPart { sent_ns: part.sent_ns, ..new };
                        writer.write_reply(&new, record.log_ns)?;
                    }
                }
            },
        }
        Ok(())
    }
}
