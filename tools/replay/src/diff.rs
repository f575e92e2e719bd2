//! `replay diff`: compares two recordings.

use std::collections::BTreeMap;
use std::error::Error;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use comparison::check::{Counts, find};
use comparison::compare::Outcome;
use comparison::diff::{Compared, diff};
use comparison::exchanges;
use comparison::report::DiffReport;

use crate::arguments::Diff;
use crate::findings::Findings;
use crate::html::{self, Details, Page};
use crate::reading::{complain, progress};
use crate::report::write_json;

/// Compares the recordings. What is wrong with them is told on stderr.
pub(crate) fn run(arguments: &Diff, findings: &mut Findings) -> Result<Compared, Box<dyn Error>> {
    let Diff { a, b, compare, page, .. } = arguments;
    page.check(&[a, b])?;
    let [files_of_a, files_of_b] = [files(a)?, files(b)?];
    let bar = progress(b);
    let mut drawn: BTreeMap<u64, Details> = BTreeMap::new();
    let compared = diff(
        [&files_of_a, &files_of_b],
        &compare.tolerance(),
        |at| bar.set_position(at),
        |pair, exchange, reply| {
            if page.html.is_some() {
                let replies = [&exchange.reply, reply];
                let content = &exchange.request.content;
                let details = html::details(content, replies, &pair.comparison);
                drawn.insert(pair.indices[0], details);
            }
        },
    );
    bar.finish_and_clear();
    for (path, contents) in [a, b].iter().zip(&compared.contents) {
        complain(path, contents);
        findings.add(contents);
    }
    let alone = compared.alone.iter().any(|keys| !keys.is_empty());
    findings.regression |= compared.counts().different > 0 || alone;
    page.write(|| report(&compared, &drawn, [a, b]))?;
    Ok(compared)
}

/// The files of the recording that a path names: the file itself, or those in a folder.
fn files(path: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let mut recordings = exchanges::recordings(&find(&[path.to_owned()])?);
    match (recordings.pop(), recordings.len()) {
        (Some(files), 0) => Ok(files),
        (_, more) => {
            let path = path.display();
            Err(format!("{path} holds {} recordings; diff takes one as A and one as B", more + 1)
                .into())
        }
    }
}

/// The page about both.
fn report(compared: &Compared, drawn: &BTreeMap<u64, Details>, paths: [&Path; 2]) -> String {
    let mut page = Page::new("replay diff");
    let [a, b] = paths.map(|path| path.display().to_string());
    let name = format!("{a} and {b}");
    let [contents_a, contents_b] = &compared.contents;
    page.file(&name, &compared.counts(), &[contents_a, contents_b]);
    for (path, keys) in [&a, &b].into_iter().zip(&compared.alone) {
        keys.iter().for_each(|key| page.alone(format!("request {key} is only in {path}")));
    }
    let none = Details::new();
    for pair in &compared.pairs {
        let details = drawn.get(&pair.indices[0]).unwrap_or(&none);
        let [request, other] = pair.indices;
        let request = format!("{request} and {other}");
        page.reply([&name, &request], pair.id, &pair.comparison, details);
    }
    page.finish()
}

/// Each difference in a line, what has moved in each answer, and a line of counts.
pub(crate) fn text(compared: &Compared, paths: [&Path; 2], out: &mut impl Write) -> io::Result<()> {
    let [a, b] = paths.map(Path::display);
    for (index, pair) in compared.pairs.iter().enumerate() {
        if let Outcome::Different(difference) = &pair.comparison.outcome {
            let [one, other] = pair.keys;
            let (path, has_a, has_b) =
                (&difference.path, &difference.recorded, &difference.planned);
            writeln!(
                out,
                "pair {index} ({one} and {other}): {path}: {has_a} in {a}, {has_b} in {b}"
            )?;
            let answers = pair.comparison.answers.iter();
            for answer in answers.filter(|answer| answer.verdict.is_regression()) {
                writeln!(out, "    {answer}")?;
            }
        }
    }
    for (path, keys) in [&a, &b].into_iter().zip(&compared.alone) {
        for key in keys {
            writeln!(out, "request {key} is only in {path}")?;
        }
    }
    let [alone_a, alone_b] = compared.alone.each_ref().map(Vec::len);
    let counts = compared.counts();
    let Counts { different, not_repeatable, .. } = counts;
    write!(out, "{}, {different} different", counts.equal())?;
    if not_repeatable > 0 {
        write!(out, ", {not_repeatable} not repeatable (depend on load)")?;
    }
    writeln!(out, ", {alone_a} only in {a}, {alone_b} only in {b}{}", counts.within())
}

/// All of it as one JSON object.
pub(crate) fn json(compared: &Compared, paths: [&Path; 2], out: &mut impl Write) -> io::Result<()> {
    let names = paths.map(|path| path.to_string_lossy().into_owned());
    write_json(&DiffReport::new(compared, names), out)
}
