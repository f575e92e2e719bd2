//! Plans a recording's requests again and compares the replies.

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use std::{fs, io};

use schemas::message::{Reply, Request, RequestContent, RequestKey};

use crate::compare::{Comparison, Difference, Outcome, Verdict, compare};
use crate::describe::counted;
use crate::exchanges::{self, Contents, Exchange};
use crate::tolerance::Tolerance;

/// Differences of a file that its text shows.
const MOST_SHOWN: usize = 10;

/// How the replies of one recording compare.
#[derive(Debug)]
pub struct Checked {
    /// The file, or the first of several.
    pub path: PathBuf,
    /// The recording's files that follow it.
    pub more: Vec<PathBuf>,
    /// What is in it.
    pub contents: Contents,
    /// Its exchanges, in the order in which their replies ended.
    pub cases: Vec<Case>,
}

/// How one reply compares.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Counts the recording's requests, from 0.
    pub index: u64,
    /// The request.
    pub key: RequestKey,
    /// The scene's id.
    pub id: Option<u64>,
    /// How its reply compares.
    pub comparison: Comparison,
    /// How long it took to plan it again.
    pub planning: Duration,
}

impl Case {
    /// Compares the reply that was recorded with the one planned now.
    pub fn new(
        exchange: &Exchange,
        (planned, planning): (&Reply, Duration),
        tolerance: &Tolerance,
    ) -> Self {
        let Exchange { index, request, reply, uploads: _ } = exchange;
        let id = match &request.content {
            RequestContent::Scene(scene) => scene.id,
            RequestContent::Unreadable { .. } => reply.id,
        };
        let comparison = compare(reply, planned, tolerance);
        Self { index: *index, key: request.key, id, comparison, planning }
    }
}

/// How many replies compare in which way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Replies that are equal.
    pub equal: u64,
    /// Equal replies with differently worded messages.
    pub reworded: u64,
    /// Equal replies with differences within tolerance.
    pub within: u64,
    /// Replies that differ.
    pub different: u64,
    /// Replies that depend on load.
    pub not_repeatable: u64,
}

impl Counts {
    /// Counts a reply.
    pub fn add(&mut self, comparison: &Comparison) {
        match &comparison.outcome {
            Outcome::Equal { reworded } => {
                self.equal += 1;
                self.reworded += u64::from(*reworded > 0);
                let mut answers = comparison.answers.iter();
                self.within += u64::from(answers.any(|it| it.verdict == Verdict::Within));
            }
            Outcome::Different(_) => self.different += 1,
            Outcome::NotRepeatable => self.not_repeatable += 1,
        }
    }
}

impl Counts {
    /// Such as `3 equal (1 worded differently)`.
    pub fn equal(&self) -> String {
        match (self.equal, self.reworded) {
            (equal, 0) => format!("{equal} equal"),
            (equal, reworded) => format!("{equal} equal ({reworded} worded differently)"),
        }
    }

    /// Such as ` (1 within tolerance)`; nothing if there is none.
    pub fn within(&self) -> String {
        match self.within {
            0 => String::new(),
            within => format!(" ({within} within tolerance)"),
        }
    }
}

/// The counts that are not 0, such as `3 equal (1 worded differently), 2 different`.
impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { equal, reworded: _, within: _, different, not_repeatable } = *self;
        let mut parts = Vec::new();
        if equal > 0 {
            parts.push(self.equal());
        }
        if different > 0 {
            parts.push(format!("{different} different"));
        }
        if not_repeatable > 0 {
            parts.push(format!("{not_repeatable} not repeatable (depend on load)"));
        }
        write!(f, "{}{}", parts.join(", "), self.within())
    }
}

impl Checked {
    /// How many replies compare in which way.
    pub fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        self.cases.iter().for_each(|case| counts.add(&case.comparison));
        counts
    }

    /// The replies that differ.
    pub fn differences(&self) -> impl Iterator<Item = (&Case, &Difference)> {
        self.cases.iter().filter_map(|case| match &case.comparison.outcome {
            Outcome::Different(difference) => Some((case, &**difference)),
            Outcome::Equal { .. } | Outcome::NotRepeatable => None,
        })
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "request {} ({})", self.index, self.key)
    }
}

/// The first differences, a line each, and a line of counts.
impl fmt::Display for Checked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { path, more, contents, cases: _ } = self;
        let path = match more.len() {
            0 => path.display().to_string(),
            more => format!("{} and {more} more", path.display()),
        };
        for (case, difference) in self.differences().take(MOST_SHOWN) {
            writeln!(f, "{path}: {case}: {difference}")?;
            for answer in
                case.comparison.answers.iter().filter(|answer| answer.verdict.is_regression())
            {
                writeln!(f, "    {answer}")?;
            }
        }
        let counts = self.counts();
        let left = counts.different.saturating_sub(MOST_SHOWN as u64);
        if left > 0 {
            writeln!(f, "{path}: {} more differ", counted(left, "request"))?;
        }
        write!(f, "{path}: {}", counted(contents.requests, "request"))?;
        if counts != Counts::default() {
            write!(f, ", {counts}")?;
        }
        if !contents.losses.is_empty() {
            write!(f, ", {} incomplete", contents.losses.len())?;
        }
        if contents.lost() > 0 {
            write!(f, ", {} lost while recording", counted(contents.lost(), "message"))?;
        }
        match &contents.error {
            Some(error) if error.is_cut() => write!(f, ", cut"),
            Some(_) => write!(f, ", unreadable before its end"),
            None => Ok(()),
        }
    }
}

/// Plans the requests of a recording again with `plan`, one after the other, and compares the replies with those
/// recorded. `files` are its files, one or more; `progress` receives the number of bytes read.
pub fn check(
    files: &[PathBuf],
    tolerance: &Tolerance,
    mut plan: impl FnMut(&Request) -> Reply,
    progress: impl FnMut(u64),
) -> Checked {
    let mut cases = Vec::new();
    let contents = exchanges::read_all(files, progress, |exchange| {
        for upload in &exchange.uploads {
            // So that its free space is known.
            plan(upload);
        }
        let began = Instant::now();
        let planned = plan(&exchange.request);
        cases.push(Case::new(&exchange, (&planned, began.elapsed()), tolerance));
    });
    let path = files.first().cloned().unwrap_or_default();
    Checked { path, more: files.iter().skip(1).cloned().collect(), contents, cases }
}

/// The recordings that `paths` name: files, and all `*.mcap` in folders and below, sorted.
pub fn find(paths: &[PathBuf]) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        let named =
            |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
        if fs::metadata(path).map_err(named)?.is_dir() {
            let before = files.len();
            find_in(path, &mut files).map_err(named)?;
            files[before..].sort();
            if files.len() == before {
                let error = io::Error::new(io::ErrorKind::NotFound, "contains no *.mcap files");
                return Err(named(error));
            }
        } else {
            files.push(path.clone());
        }
    }
    Ok(files)
}

fn find_in(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
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
