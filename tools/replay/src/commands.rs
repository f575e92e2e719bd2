//! The commands.

use std::error::Error;
use std::io::{self, BufWriter, Write};
use std::ops::ControlFlow;

use program::{Exit, PrintError, warn};
use recording::{Options, recover};

use crate::arguments::{Arguments, Command, Format, ReportFormat};
use crate::findings::Findings;
use crate::{bless, check, diff, export, extract, info, junit, merge, play, reading, report, show};

/// Runs the command line.
pub(crate) fn run(arguments: Arguments) -> Result<Exit, Box<dyn Error>> {
    let mut findings = Findings::default();
    let mut out = BufWriter::new(io::stdout().lock());
    let printed = match arguments.command {
        Command::Check(arguments) => {
            findings.strict = arguments.strict.strict;
            let checked = check::run(&arguments, &mut findings)?;
            match arguments.format {
                ReportFormat::Text => report::text(&checked, &mut out),
                ReportFormat::Json => report::json(&checked, &mut out),
                ReportFormat::Junit => out.write_all(junit::report(&checked)?.as_bytes()),
            }
        }
        Command::Info { file, format, strict } => {
            findings.strict = strict.strict;
            let contents = reading::whole(&file, &mut findings, |_| ControlFlow::Continue(()));
            match format {
                // Why was said.
                _ if contents.is_unopened() => Ok(()),
                Format::Text => info::text(&file, &contents, &mut out),
                Format::Json => info::json(&file, &contents, &mut out),
            }
        }
        Command::Show(arguments) => show::run(&arguments, &mut findings, &mut out)?,
        Command::Diff(arguments) => {
            findings.strict = arguments.strict.strict;
            let compared = diff::run(&arguments, &mut findings)?;
            let paths = [arguments.a.as_path(), &arguments.b];
            match arguments.format {
                ReportFormat::Text => diff::text(&compared, paths, &mut out),
                ReportFormat::Json => diff::json(&compared, paths, &mut out),
                ReportFormat::Junit => {
                    out.write_all(junit::diff_report(&compared, paths)?.as_bytes())
                }
            }
        }
        Command::Bless(arguments) => bless::run(&arguments, &mut findings, &mut out)?,
        Command::Extract(arguments) => extract::run(&arguments, &mut findings, &mut out)?,
        Command::Export(arguments) => export::run(&arguments, &mut findings, &mut out)?,
        Command::Merge(arguments) => merge::run(&arguments, &mut findings, &mut out)?,
        Command::Play(arguments) => play::run(&arguments, &mut findings, &mut out)?,
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
