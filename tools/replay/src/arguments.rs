//! Command-line arguments.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use comparison::compare::Tolerance;

const EXIT_CODES: &str = "\
Results go to stdout, diagnostics to stderr.
Exit codes:
  0  done; all replies compared are equal
  1  failure: a file can't be read or is damaged, or there was nothing to compare
  2  usage: wrong arguments
  3  data was lost: the recorder missed messages, a request lacks its whole reply or a reply
     its request, or the recording is cut off (its recorder was killed); `recover`: something is
     missing, or was kept without a checksum
  4  regression: replies differ
If several apply, the first of 4, 1, 3 counts.";

const EXAMPLES: &str = "\
Examples:
  replay check recordings/              check all *.mcap in a folder and below
  replay check run.mcap --tolerance 1e-9
  replay check recordings/ --format junit > report.xml
  replay info run.mcap --format json
  replay diff before.mcap after.mcap
  replay recover killed.mcap.part -o whole.mcap
";

const COMPARED: &str = "\
Codes, fields and numbers are compared. Messages are for people: replies whose refusals are
only worded differently are equal, and counted. Replies that depend on load (too late,
overloaded) are not compared.
";

/// Plans again what was recorded, and compares
#[derive(Debug, Parser)]
#[command(name = "replay", version, after_help = format!("{EXAMPLES}\n{EXIT_CODES}"))]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Plan every recorded request again and compare with the recorded reply
    #[command(after_help = format!("{COMPARED}\n{EXIT_CODES}"))]
    Check {
        /// Recordings, or folders to search for *.mcap
        #[arg(required = true, value_name = "PATH")]
        paths: Vec<PathBuf>,
        #[command(flatten)]
        compare: Compare,
        /// Plan under the table `caps` of this planner's configuration [default: as the recording
        /// says; where it says nothing, a planner's defaults]
        #[arg(long, value_name = "FILE")]
        config: Option<PathBuf>,
        /// Print lines for people, one JSON object, or JUnit XML
        #[arg(long, value_enum, default_value_t = ReportFormat::Text)]
        format: ReportFormat,
        #[command(flatten)]
        strict: Strict,
    },
    /// Describe a recording
    #[command(after_help = EXIT_CODES)]
    Info {
        /// The recording
        file: PathBuf,
        /// Print lines for people, or one JSON object
        #[arg(long, value_enum, default_value_t = Format::Text)]
        format: Format,
        #[command(flatten)]
        strict: Strict,
    },
    /// Compare the replies of two recordings, pairing equal requests
    #[command(after_help = format!("{COMPARED}\n{EXIT_CODES}"))]
    Diff {
        /// The recording that counts as right
        a: PathBuf,
        /// The recording to compare with it
        b: PathBuf,
        #[command(flatten)]
        compare: Compare,
        /// Print lines for people, or one JSON object
        #[arg(long, value_enum, default_value_t = Format::Text)]
        format: Format,
        #[command(flatten)]
        strict: Strict,
    },
    /// Copy what checksums vouch for in a cut or damaged recording into a new one
    #[command(after_help = EXIT_CODES)]
    Recover {
        /// The cut or damaged recording
        file: PathBuf,
        /// The new recording
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
        /// Replace an existing file
        #[arg(long)]
        overwrite: bool,
        /// Keep also what can be decoded without a right checksum; the new recording says so
        #[arg(long)]
        unverified: bool,
    },
}

#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct Strict {
    /// Refuse recordings of which checksums don't cover all messages
    #[arg(long)]
    pub(crate) strict: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Compare {
    /// How far numbers may differ, in metres, radians and seconds alike [default: not at all]
    #[arg(long, value_name = "NUMBER", value_parser = tolerance)]
    tolerance: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ReportFormat {
    Text,
    Json,
    Junit,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    Text,
    Json,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value),
        _ => Err("must be a number, 0 or greater".into()),
    }
}

impl Compare {
    pub(crate) fn tolerance(&self) -> Tolerance {
        self.tolerance.map_or(Tolerance::Exact, Tolerance::Within)
    }
}
