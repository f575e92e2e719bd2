//! Plans recorded requests again and compares the replies.

use std::io;
use std::path::{Path, PathBuf};

use schemas::message::{Reply, Request, RequestKey};

use crate::compare::{Outcome, Tolerance, compare};
use crate::exchanges::{self, Contents};

/// How one recording compares.
#[derive(Debug)]
pub struct Checked {
    /// The file.
    pub path: PathBuf,
    /// What is in it.
    pub contents: Contents,
    /// Its exchanges, in the order of their replies' ends.
    pub cases: Vec<Case>,
}

/// How one exchange compares.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Counts the recording's requests, from 0.
    pub index: u64,
    /// The request.
    pub key: RequestKey,
    /// How it compares.
    pub outcome: Outcome,
}

/// How exchanges compared, in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Replies that are equal.
    pub equal: u64,
    /// Replies that differ.
    pub different: u64,
    /// Replies that can't be repeated.
    pub not_repeatable: u64,
}

impl Checked {
    /// Its outcomes, in numbers.
    pub fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        for case in &self.cases {
            match case.outcome {
                Outcome::Equal => counts.equal += 1,
                Outcome::Different(_) => counts.different += 1,
                Outcome::NotRepeatable => counts.not_repeatable += 1,
            }
        }
        counts
    }
}

/// Checks the recording at `path`: what `plan` makes of its requests against what was
/// recorded.
pub fn check(
    path: &Path,
    tolerance: Tolerance,
    plan: impl Fn(&Request) -> Reply,
    progress: impl FnMut(u64),
) -> Checked {
    let mut cases = Vec::new();
    let contents = exchanges::read(path, progress, |exchange| {
        let planned = plan(&exchange.request);
        let outcome = compare(&exchange.reply, &planned, tolerance);
        cases.push(Case { index: exchange.index, key: exchange.request.key, outcome });
    });
    Checked { path: path.to_owned(), contents, cases }
}

/// The files that `paths` name: files themselves, and all `*.mcap` within folders, sorted.
pub fn find(paths: &[PathBuf]) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        let named =
            |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
        if std::fs::metadata(path).map_err(named)?.is_dir() {
            let before = files.len();
            find_in(path, &mut files).map_err(named)?;
            files[before..].sort();
            if files.len() == before {
                let error = io::Error::new(io::ErrorKind::NotFound, "no *.mcap files in it");
                return Err(named(error));
            }
        } else {
            files.push(path.clone());
        }
    }
    Ok(files)
}

fn find_in(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        // Links to folders are not followed: they may lead back.
        if entry.file_type()?.is_dir() {
            find_in(&entry.path(), files)?;
        } else if entry.path().extension().is_some_and(|extension| extension == "mcap") {
            files.push(entry.path());
        }
    }
    Ok(())
}
