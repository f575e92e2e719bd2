//! The commands.

use std::error::Error;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};

use answer::{Answerer, Caps};
use clap::Parser;
use comparison::compare::Tolerance;
use comparison::{check, diff, exchanges};
use configuration::Config;
use indicatif::{ProgressBar, ProgressStyle};
use program::{Exit, PrintError, warn};
use recording::{Options, recover};
use schemas::message::Request;

use crate::arguments::{Arguments, Command, Format, ReportFormat};
use crate::findings::Findings;
use crate::{info, junit, report};

/// Runs the command line.
pub(crate) fn run() -> Result<Exit, Box<dyn Error>> {
    let mut findings = Findings::default();
    let mut out = BufWriter::new(io::stdout().lock());
    let printed = match Arguments::parse().command {
        Command::Check { paths, compare, config, format, strict } => {
            findings.strict = strict.strict;
            let checked = checked(&paths, compare.tolerance(), config.as_deref(), &mut findings)?;
            match format {
                ReportFormat::Text => report::text(&checked, &mut out),
                ReportFormat::Json => report::json(&checked, &mut out),
                ReportFormat::Junit => out.write_all(junit::report(&checked)?.as_bytes()),
            }
        }
        Command::Info { file, format, strict } => {
            findings.strict = strict.strict;
            let bar = progress(std::slice::from_ref(&file));
            let contents = exchanges::read(&file, |at| bar.set_position(at), drop);
            bar.finish_and_clear();
            complain(&file, &contents);
            findings.add(&contents);
            match format {
                Format::Text => info::text(&file, &contents, &mut out),
                Format::Json => info::json(&file, &contents, &mut out),
            }
        }
        Command::Diff { a, b, compare, format, strict } => {
            findings.strict = strict.strict;
            let bar = progress(std::slice::from_ref(&b));
            let compared = diff::diff([&a, &b], compare.tolerance(), |at| bar.set_position(at));
            bar.finish_and_clear();
            let paths = [a.as_path(), &b];
            for (path, contents) in paths.iter().zip(&compared.contents) {
                complain(path, contents);
                findings.add(contents);
            }
            findings.regression |= crate::diff::differ(&compared);
            match format {
                Format::Text => crate::diff::text(&compared, paths, &mut out),
                Format::Json => crate::diff::json(&compared, paths, &mut out),
            }
        }
        Command::Recover { file, output, overwrite, unverified } => {
            let options = Options { overwrite, ..Options::default() };
            let recovered = recover(&file, &output, unverified, options)?;
            report::losses(&recovered)
                .for_each(|trouble| warn(format_args!("{}: {trouble}", file.display())));
            findings.loss |= recovered.is_incomplete();
            writeln!(out, "{}: {}", output.display(), report::recovered(&recovered))
        }
    };
    match printed.and_then(|()| out.flush()).map_err(PrintError) {
        // What was found counts, even if nobody reads on.
        Err(error) if !error.is_closed() => Err(error.into()),
        _ => Ok(findings.exit()),
    }
}

/// Checks all recordings that `paths` name.
fn checked(
    paths: &[PathBuf],
    tolerance: Tolerance,
    config: Option<&Path>,
    findings: &mut Findings,
) -> Result<Vec<check::Checked>, Box<dyn Error>> {
    let asked = config.map(Config::read).transpose()?.map(|config| config.caps);
    let mut checked = Vec::new();
    for files in exchanges::recordings(&check::find(paths)?) {
        let path = &files[0];
        let recorded = || match exchanges::description(path).get("config") {
            Some(json) => configuration::caps_of(json, path),
            None => Ok(Caps::default()),
        };
        let caps = asked.map_or_else(recorded, Ok)?;
        let bar = progress(&files);
        // A file has the free spaces that its requests name.
        let mut answerer = Answerer::new(&caps);
        let plan = |request: &Request| answerer.reply_to(request);
        let file = check::check(&files, tolerance, plan, |at| bar.set_position(at));
        bar.finish_and_clear();
        complain(path, &file.contents);
        findings.add(&file.contents);
        findings.regression |= file.counts().different > 0;
        checked.push(file);
    }
    if checked.iter().all(|file| file.cases.is_empty()) {
        warn(format_args!("replay: nothing to compare"));
        findings.failure |= !findings.loss;
    }
    Ok(checked)
}

fn complain(path: &Path, contents: &exchanges::Contents) {
    report::troubles(contents).for_each(|trouble| {
        warn(format_args!("{}: {trouble}", path.display()));
    });
}

/// A bar on stderr for files that take a while, if that is a terminal.
fn progress(files: &[PathBuf]) -> ProgressBar {
    const WORTH_IT: u64 = 32 << 20;
    let length = |path| std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    let length = files.iter().map(length).sum();
    if length < WORTH_IT || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {bytes}/{total_bytes} {eta}");
    ProgressBar::new(length).with_style(style.expect("a valid template"))
}
