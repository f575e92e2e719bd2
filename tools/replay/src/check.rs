//! `replay check`: plans again what was recorded.

mod workers;

use std::error::Error;
use std::fs;
use std::io::{self, IsTerminal};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::thread;

use answer::Caps;
use comparison::check::{Checked, find};
use comparison::exchanges;
use comparison::named::NamedFreeSpaces;
use configuration::{Config, ConfigError};
use indicatif::{ProgressBar, ProgressStyle};
use program::warn;
use schemas::message::{Refusal, Request, RequestContent};

use crate::arguments::Check;
use crate::changes::{self, FieldChange};
use crate::findings::Findings;
use crate::html::{Details, Page};
use crate::reading::{WORTH_A_BAR, complain};
use crate::running;
use crate::tolerances::Folders;
use workers::{NoReply, Settings, Task};

/// Checks all recordings that the arguments name. What is wrong with one does not keep the others
/// from being checked.
pub(crate) fn run(
    arguments: &Check,
    findings: &mut Findings,
) -> Result<Vec<Checked>, Box<dyn Error>> {
    let inputs: Vec<&Path> = arguments.paths.iter().map(|path| &**path).collect();
    arguments.page.check(&inputs)?;
    let config = arguments.config.as_deref().map(Config::read).transpose()?;
    let config = config.map(|config| config.caps);
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let bus = arguments.via_bus.then_some(&arguments.bus);
    if let Some(bus) = bus {
        running::begin();
        // Whether there is one, before anything is read.
        running::connect(bus)?;
    }
    let settings = Settings {
        bus,
        jobs: arguments.jobs.map_or(cores, |jobs| jobs.get() as usize),
        draw: arguments.page.html.is_some(),
    };
    let files = files(&arguments.paths, findings);
    let bar = progress(&files);
    let mut checked: Vec<Checked> = Vec::new();
    let mut folders = Folders::default();
    let done = workers::run(&settings, |give| {
        let mut before = 0;
        for files in exchanges::recordings(&files) {
            let path = files[0].clone();
            let caps = match config.map_or_else(|| recorded_caps(&path), Ok) {
                Ok(caps) => caps,
                Err(error) => {
                    warn(format_args!("{error}"));
                    findings.failure = true;
                    continue;
                }
            };
            let tolerance = match folders.tolerance(arguments.compare.tolerance(), &path) {
                Ok(tolerance) => tolerance,
                Err(said) => {
                    warn(format_args!("{said}"));
                    findings.failure = true;
                    continue;
                }
            };
            let (mut named, mut order, file) = (NamedFreeSpaces::default(), 0, checked.len());
            let progress = |at| bar.set_position(before + at);
            let mut refused = Refused::default();
            let contents = exchanges::read_all(&files, progress, |mut exchange| {
                exchange.uploads.iter_mut().for_each(|upload| named.resolve(upload));
                if bus.is_some() && bus::terminated() {
                    return;
                }
                named.resolve(&mut exchange.request);
                match changed(&exchange.request, &arguments.with) {
                    Ok(changed) => {
                        give(Task { file, order, exchange, changed, tolerance, caps });
                        order += 1;
                    }
                    Err(refusal) => refused.add(exchange.index, refusal),
                }
            });
            findings.failure |= refused.count > 0;
            bar.suspend(|| refused.tell(&path));
            before += files.iter().map(|path| length(path)).sum::<u64>();
            bar.suspend(|| complain(&path, &contents));
            findings.add(&contents);
            let more = files[1..].to_vec();
            checked.push(Checked { path, more, contents, cases: Vec::new() });
        }
    });
    bar.finish_and_clear();
    let mut details = Vec::with_capacity(done.len());
    for done in done {
        match done.case {
            Ok((case, drawn)) => {
                checked[done.file].cases.push(case);
                details.push(drawn);
            }
            Err(NoReply { index, said }) => {
                findings.failure = true;
                let path = checked[done.file].path.display();
                warn(format_args!("{path}: request {index} is not compared: {said}"));
            }
        }
    }
    if bus.is_some() {
        findings.interrupted = bus::termination_signal();
    }
    arguments.page.write(|| page(&checked, &details))?;
    findings.regression |= checked.iter().any(|file| file.counts().different > 0);
    if checked.iter().all(|file| file.cases.is_empty()) {
        warn(format_args!("replay: nothing to compare"));
        findings.failure |= !findings.loss;
    }
    Ok(checked)
}

/// The page about all files; `details` are those of all cases, one after the other.
fn page(checked: &[Checked], details: &[Details]) -> String {
    let mut page = Page::new("replay check");
    let mut details = details.iter();
    for file in checked {
        let name = file.path.to_string_lossy();
        page.file(&name, &file.counts(), &[&file.contents]);
        for (case, details) in file.cases.iter().zip(&mut details) {
            page.reply([&name, &case.index.to_string()], case.id, &case.comparison, details);
        }
    }
    page.finish()
}

/// The caps under which a recording was made, as far as it says.
pub(crate) fn recorded_caps(path: &Path) -> Result<Caps, ConfigError> {
    match exchanges::description(path).get("config") {
        Some(json) => configuration::caps_of(json, path),
        None => Ok(Caps::default()),
    }
}

/// The request as `--with` changes it, if it does.
fn changed(request: &Request, with: &[FieldChange]) -> Result<Option<Request>, Refusal> {
    match &request.content {
        RequestContent::Scene(scene) if !with.is_empty() => {
            let content = RequestContent::Scene(changes::changed(scene, with)?);
            Ok(Some(Request { content, ..*request }))
        }
        _ => Ok(None),
    }
}

/// Requests that are no scenes with what `--with` sets.
#[derive(Default)]
struct Refused {
    count: u64,
    first: Option<(u64, Refusal)>,
}

impl Refused {
    fn add(&mut self, index: u64, refusal: Refusal) {
        self.count += 1;
        self.first.get_or_insert((index, refusal));
    }

    fn tell(&self, path: &Path) {
        let Some((index, refusal)) = &self.first else { return };
        let more = match self.count - 1 {
            0 => String::new(),
            more => format!(" (and {more} more)"),
        };
        let (path, said) = (path.display(), &refusal.message);
        warn(format_args!("{path}: request {index}{more} can't be changed: {said}"));
    }
}

/// The recordings that `paths` name.
fn files(paths: &[PathBuf], findings: &mut Findings) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for path in paths {
        match find(std::slice::from_ref(path)) {
            Ok(found) => files.extend(found),
            Err(error) => {
                warn(format_args!("replay: {error}"));
                findings.failure = true;
            }
        }
    }
    files
}

fn length(path: &Path) -> u64 {
    fs::metadata(path).map_or(0, |metadata| metadata.len())
}

/// A bar on stderr over all files, if they take a while and that is a terminal.
fn progress(files: &[PathBuf]) -> ProgressBar {
    let length = files.iter().map(|path| length(path)).sum();
    if length < WORTH_A_BAR || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {bytes}/{total_bytes} {eta}");
    ProgressBar::new(length).with_style(style.expect("a valid template"))
}
