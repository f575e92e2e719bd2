//! Arguments and exit codes.

use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use answer::Caps;
use clap::{Args, Parser, Subcommand, ValueEnum};
use configuration::Config;
use indicatif::{ProgressBar, ProgressStyle};
use recording::{Options, recover};
use schemas::message::{Reply, Request};

use crate::compare::{Outcome, Tolerance};
use crate::{check, diff, exchanges, info, report};

const AFTER_HELP: &str = "\
Exit codes:
  0  done; what was compared is equal
  1  failure: a file could not be read, is damaged, or there was nothing to compare
  2  the arguments are wrong
  3  data was lost: messages that the recorder missed, requests without whole replies,
     replies without requests, a recording that is cut (its recorder was killed)
  4  a regression was found: replies differ
Where several apply, 4 goes before 1 and 1 before 3.

Examples:
  replay check recordings/              check all *.mcap in a folder and below
  replay check run.mcap --tolerance 1e-9
  replay check recordings/ --format junit > report.xml
  replay diff before.mcap after.mcap
  replay recover killed.mcap -o whole.mcap";

/// Plans again what was recorded, and compares
#[derive(Debug, Parser)]
#[command(name = "replay", version, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Plan every recorded request again and compare with the recorded reply
    #[command(after_help = AFTER_HELP)]
    Check {
        /// Recordings, or folders that are searched for *.mcap
        #[arg(required = true, value_name = "PATH")]
        paths: Vec<PathBuf>,
        #[command(flatten)]
        compare: Compare,
        /// The configuration of the planner that was recorded, for the caps on what a request
        /// may cost; nothing else in it matters here
        #[arg(long, value_name = "FILE")]
        config: Option<PathBuf>,
        /// How the result is printed
        #[arg(long, value_enum, default_value_t = Format::Text)]
        format: Format,
    },
    /// Say what is in a recording
    Info {
        /// The recording
        file: PathBuf,
    },
    /// Compare the replies of two recordings, pairing requests that ask the same
    #[command(after_help = AFTER_HELP)]
    Diff {
        /// The recording that counts as right
        a: PathBuf,
        /// The recording that is compared with it
        b: PathBuf,
        #[command(flatten)]
        compare: Compare,
    },
    /// Copy what is whole in a cut or damaged recording into a new one
    Recover {
        /// The cut or damaged recording
        file: PathBuf,
        /// The new recording
        #[arg(short, long, value_name = "OUT")]
        output: PathBuf,
        /// Replace the new recording if it exists
        #[arg(long)]
        overwrite: bool,
    },
}

#[derive(Debug, Args)]
struct Compare {
    /// How far numbers may be apart, in metres, radians and seconds alike; without it they
    /// must be equal bit for bit
    #[arg(long, value_name = "T", value_parser = tolerance)]
    tolerance: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Lines for people
    Text,
    /// One JSON object
    Json,
    /// JUnit XML, for build servers
    Junit,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value),
        _ => Err("a tolerance is a number, zero or greater".into()),
    }
}

impl Compare {
    fn tolerance(&self) -> Tolerance {
        self.tolerance.map_or(Tolerance::Exact, Tolerance::Within)
    }
}

/// The results of a command, the worst of which becomes the exit code.
#[derive(Debug, Clone, Copy, Default)]
struct Findings {
    regression: bool,
    failure: bool,
    loss: bool,
}

impl Findings {
    fn of(&mut self, contents: &exchanges::Contents) {
        self.failure |= contents.failure().is_some();
        self.loss |= contents.is_incomplete();
    }

    fn code(self) -> ExitCode {
        let code = match self {
            Self { regression: true, .. } => 4,
            Self { failure: true, .. } => 1,
            Self { loss: true, .. } => 3,
            Self { .. } => 0,
        };
        code.into()
    }
}

/// Runs the command line; `plan` is the planner.
pub fn main(plan: impl Fn(&Request, &Caps) -> Reply) -> ExitCode {
    let cli = Cli::parse();
    let mut out = BufWriter::new(io::stdout().lock());
    let mut findings = Findings::default();
    let printed = run(cli.command, plan, &mut findings, &mut out).and_then(|()| out.flush());
    match printed {
        // Who reads no further has seen enough; what was found stays found.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {}
        Err(error) => {
            warn(format_args!("replay: {error}"));
            findings.failure = true;
        }
        Ok(()) => {}
    }
    findings.code()
}

/// Tells standard error, if somebody listens.
fn warn(text: std::fmt::Arguments) {
    let _ = writeln!(io::stderr(), "{text}");
}

fn complain(path: &Path, contents: &exchanges::Contents) {
    let _ = report::complain(path.display(), contents, &mut io::stderr().lock());
}

/// Runs one command: `Err` where something other than the recordings fails.
fn run(
    command: Command,
    plan: impl Fn(&Request, &Caps) -> Reply,
    findings: &mut Findings,
    out: &mut impl Write,
) -> io::Result<()> {
    match command {
        Command::Check { paths, compare, config, format } => {
            let config = config.as_deref().map(Config::read).transpose();
            let caps = config.map_err(io::Error::other)?.unwrap_or_default().caps;
            let plan = |request: &Request| plan(request, &caps);
            let mut checked = Vec::new();
            for path in check::find(&paths)? {
                let bar = progress(&path);
                let file =
                    check::check(&path, compare.tolerance(), plan, |at| bar.set_position(at));
                bar.finish_and_clear();
                complain(&path, &file.contents);
                findings.of(&file.contents);
                findings.regression |= file.counts().different > 0;
                checked.push(file);
            }
            if checked.iter().all(|file| file.cases.is_empty()) {
                warn(format_args!("replay: there was nothing to compare"));
                findings.failure |= !findings.loss;
            }
            match format {
                Format::Text => report::text(&checked, out),
                Format::Json => report::json(&checked, out),
                Format::Junit => report::junit(&checked, out),
            }
        }
        Command::Info { file } => {
            let bar = progress(&file);
            let contents = exchanges::read(&file, |at| bar.set_position(at), drop);
            bar.finish_and_clear();
            complain(&file, &contents);
            findings.of(&contents);
            info::text(&file, &contents, out)
        }
        Command::Diff { a, b, compare } => {
            let bar = progress(&b);
            let compared = diff::diff([&a, &b], compare.tolerance(), |at| bar.set_position(at));
            bar.finish_and_clear();
            for (path, contents) in [&a, &b].into_iter().zip(&compared.contents) {
                complain(path, contents);
                findings.of(contents);
            }
            findings.regression |= print_diff(&compared, [&a, &b], out)?;
            Ok(())
        }
        Command::Recover { file, output, overwrite } => {
            let recovered = match recover(&file, &output, Options { overwrite }) {
                Ok(recovered) => recovered,
                Err(error) => return Err(io::Error::other(error)),
            };
            if let Some(reason) = &recovered.reason {
                warn(format_args!("{}: {reason}", file.display()));
            }
            let summary = recovered.summary;
            findings.loss |= summary.lost > 0 || recovered.unreadable > 0;
            writeln!(
                out,
                "{}: {} messages recovered, {} missing in {} gaps, {} unreadable, {} of other \
                 channels left out",
                output.display(),
                summary.recorded,
                summary.lost,
                summary.gaps,
                recovered.unreadable,
                recovered.skipped,
            )
        }
    }
}

/// Prints what differs; whether anything does.
fn print_diff(
    compared: &diff::Compared,
    [a, b]: [&PathBuf; 2],
    out: &mut impl Write,
) -> io::Result<bool> {
    let mut equal = 0;
    let mut different = 0;
    for (index, pair) in compared.pairs.iter().enumerate() {
        match &pair.outcome {
            Outcome::Different(difference) => {
                different += 1;
                let [one, other] = pair.keys;
                let place = &difference.place;
                let (recorded, planned) = (&difference.recorded, &difference.planned);
                writeln!(
                    out,
                    "pair {index} ({one} and {other}): {place}: {recorded} in {}, {planned} in {}",
                    a.display(),
                    b.display(),
                )?;
            }
            Outcome::Equal | Outcome::NotRepeatable => equal += 1,
        }
    }
    for (path, keys) in [a, b].into_iter().zip(&compared.alone) {
        for key in keys {
            writeln!(out, "request {key} is only in {}", path.display())?;
        }
    }
    let [alone_a, alone_b] = compared.alone.each_ref().map(Vec::len);
    writeln!(
        out,
        "{equal} equal, {different} different, {alone_a} only in {}, {alone_b} only in {}",
        a.display(),
        b.display(),
    )?;
    Ok(different + alone_a + alone_b > 0)
}

/// A bar on standard error for files that take a while, where that is a terminal.
fn progress(path: &Path) -> ProgressBar {
    const WORTH_IT: u64 = 32 << 20;
    let length = std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    if length < WORTH_IT || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {bytes}/{total_bytes} {eta}");
    ProgressBar::new(length).with_style(style.expect("a template as indicatif wants it"))
}
