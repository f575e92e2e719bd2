//! Command-line arguments.

mod help;

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bus::Domain;
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use comparison::tolerance::Tolerance;
use schemas::message::Task;

use crate::bless::only::Only;
use crate::changes::FieldChange;
use crate::output::{self, OutputError};
use crate::show::filter::{self, Condition, Refused};
use crate::tolerances;
use crate::units::Measure;
use help::{
    BLESSED, CHECKED, COMPARED, COPY_EXIT_CODES, EXAMPLES, EXIT_CODES, EXPORTED, EXTRACTED, MERGED,
    PAIRED, PLAYED, SHOWN, TOLERANCES,
};

/// Plans again what was recorded, and compares
#[derive(Debug, Parser)]
#[command(name = "replay", version = program::VERSION, after_help = format!("{EXAMPLES}\n{EXIT_CODES}"))]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Plan every recorded request again and compare with the recorded reply
    #[command(
        after_help = format!("{CHECKED}\n{COMPARED}\n{TOLERANCES}\n{EXIT_CODES}"),
        mut_arg("domain", |domain| domain.requires("via_bus")),
        mut_arg("wait", |wait| wait.requires("via_bus")),
        mut_arg("timeout", |timeout| timeout.requires("via_bus")),
    )]
    Check(Check),
    /// List a recording's requests, or print one of them or its reply
    #[command(after_help = format!("{SHOWN}\n{COPY_EXIT_CODES}"))]
    Show(Show),
    /// Describe a recording
    #[command(after_help = COPY_EXIT_CODES)]
    Info {
        /// The recording
        file: PathBuf,
        /// Print lines for people, or one JSON object
        #[arg(long, value_enum, default_value_t = Format::Text)]
        format: Format,
        #[command(flatten)]
        strict: Strict,
    },
    /// Compare the replies of two recordings: files, or folders with the files of one each
    #[command(after_help = format!("{PAIRED}\n{COMPARED}\n{TOLERANCES}\n{EXIT_CODES}"))]
    Diff(Diff),
    /// Accept the replies planned now: rewrite those recorded, and nothing else
    #[command(after_help = format!("{BLESSED}\n{EXIT_CODES}"))]
    Bless(Bless),
    /// Copy some requests and their replies into a recording of their own
    #[command(after_help = format!("{EXTRACTED}\n{COPY_EXIT_CODES}"))]
    Extract(Extract),
    /// Write requests and replies for viewers, as samples, or as ROS messages
    #[command(after_help = format!("{EXPORTED}\n{COPY_EXIT_CODES}"))]
    Export(Export),
    /// Merge recordings into one, in order of time
    #[command(after_help = format!("{MERGED}\n{COPY_EXIT_CODES}"))]
    Merge(Merge),
    /// Send recorded requests to a running planner, and print how long its replies take
    #[command(after_help = format!("{PLAYED}\n{EXIT_CODES}"))]
    Play(Play),
    /// Copy what checksums vouch for in a cut or damaged recording into a new one
    #[command(after_help = COPY_EXIT_CODES)]
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

#[derive(Debug, Clone, Copy, Default, Args)]
pub(crate) struct Strict {
    /// Refuse recordings of which checksums don't cover all messages
    #[arg(long)]
    pub(crate) strict: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Check {
    /// Recordings, or folders to search for *.mcap
    #[arg(required = true, value_name = "PATH")]
    pub(crate) paths: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) compare: Compare,
    /// Set a field of every scene before it is planned; repeatable
    #[arg(long, value_name = "FIELD=VALUE")]
    pub(crate) with: Vec<FieldChange>,
    /// Plan under the table `caps` of this planner's configuration [default: as the recording
    /// says; where it says nothing, a planner's defaults]
    #[arg(long, value_name = "FILE", conflicts_with = "via_bus")]
    pub(crate) config: Option<PathBuf>,
    /// Ask the running planner of a domain instead of planning in this process
    #[arg(long)]
    pub(crate) via_bus: bool,
    #[command(flatten)]
    pub(crate) bus: Bus,
    /// How many requests to plan at a time [default: one on each core]
    #[arg(short, long, value_name = "N")]
    pub(crate) jobs: Option<NonZero<u16>>,
    #[command(flatten)]
    pub(crate) page: HtmlPage,
    #[command(flatten)]
    pub(crate) strict: Strict,
    /// Print lines for people, one JSON object, or JUnit XML
    #[arg(long, value_enum, default_value_t = ReportFormat::Text)]
    pub(crate) format: ReportFormat,
}

impl Check {
    /// Without changes, on all cores.
    fn plain(paths: Vec<PathBuf>, compare: Compare, config: Option<PathBuf>) -> Self {
        let (page, format) = (HtmlPage::default(), ReportFormat::Text);
        let (with, jobs, via_bus, bus) = (Vec::new(), None, false, Bus::default());
        Self {
            paths,
            compare,
            with,
            config,
            via_bus,
            bus,
            jobs,
            page,
            strict: Strict::default(),
            format,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct Bless {
    /// Recordings, or folders to search for *.mcap
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// Accept only this: request=N, id=ID, within, moved, appeared or vanished; repeatable
    #[arg(long, value_name = "WHAT")]
    pub(crate) only: Vec<Only>,
    /// Overwrite recordings that git does not have as they are
    #[arg(long)]
    pub(crate) uncommitted: bool,
    /// Configuration of the planner: its table `caps` bounds what a request may cost
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
}

impl Bless {
    /// The check that tells what has changed.
    pub(crate) fn check(&self) -> Check {
        Check::plain(self.paths.clone(), Compare::default(), self.config.clone())
    }
}

#[derive(Debug, Args)]
#[group(id = "picked", required = true, multiple = true)]
pub(crate) struct Extract {
    /// The recording
    pub(crate) file: PathBuf,
    /// Requests that are planned differently now
    #[arg(long, group = "picked")]
    pub(crate) failing: bool,
    /// This request, from 0, in the order of the file; repeatable
    #[arg(long, value_name = "N", group = "picked")]
    pub(crate) request: Vec<u64>,
    /// Requests whose scenes have this id; repeatable
    #[arg(long, value_name = "ID", group = "picked")]
    pub(crate) id: Vec<u64>,
    #[command(flatten)]
    compare: Compare,
    /// Configuration of the planner that was recorded, for --failing
    #[arg(long, value_name = "FILE", requires = "failing")]
    config: Option<PathBuf>,
    /// The new recording
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    pub(crate) overwrite: bool,
}

impl Extract {
    /// The check that tells what fails.
    pub(crate) fn check(&self) -> Check {
        Check::plain(vec![self.file.clone()], self.compare, self.config.clone())
    }
}

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("written").required(true).multiple(true)))]
pub(crate) struct Export {
    /// The recording
    pub(crate) file: PathBuf,
    /// Only this request, from 0, in the order of the file; repeatable
    #[arg(long, value_name = "N")]
    pub(crate) request: Vec<u64>,
    /// Only scenes with this id; repeatable
    #[arg(long, value_name = "ID")]
    pub(crate) id: Vec<u64>,
    /// Only this task; repeatable
    #[arg(long, value_name = "TASK", value_parser = filter::task)]
    pub(crate) task: Vec<Task>,
    /// The recording again, with messages for viewers
    #[arg(short, long, value_name = "OUT.mcap", group = "written")]
    pub(crate) output: Option<PathBuf>,
    /// A row for each sample; the column scene has the request's number
    #[arg(long, value_name = "FILE.csv", group = "written")]
    pub(crate) csv: Option<PathBuf>,
    /// A line of JSON for each motion, with a nav_msgs/Path and a
    /// trajectory_msgs/MultiDOFJointTrajectory
    #[arg(long, value_name = "FILE.jsonl", group = "written")]
    pub(crate) ros: Option<PathBuf>,
    /// Begin each motion when the one before has ended
    #[arg(long)]
    pub(crate) apart: bool,
    /// Also show walls as floor plans with cells of this side, such as 5cm
    #[arg(long, value_name = "CELL", value_parser = cell, requires = "output")]
    pub(crate) grid: Option<f64>,
    /// Name of the frame that scenes are in
    #[arg(long, value_name = "NAME", default_value = "map")]
    pub(crate) frame: String,
    /// Replace existing files
    #[arg(long)]
    pub(crate) overwrite: bool,
}

fn cell(text: &str) -> Result<f64, String> {
    match Measure::Length.parse(text)? {
        side if side > 0.0 => Ok(side),
        _ => Err("must be greater than 0".to_owned()),
    }
}

/// The planner that is asked.
#[derive(Debug, Default, Args)]
pub(crate) struct Bus {
    /// The planner's domain
    #[arg(long, value_name = "NAME")]
    pub(crate) domain: Option<Domain>,
    /// How long to wait for a planner to start
    #[arg(long, value_name = "TIME", default_value = "0s", value_parser = program::time)]
    pub(crate) wait: Duration,
    /// How long to wait for each reply
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = program::time)]
    pub(crate) timeout: Duration,
}

#[derive(Debug, Args)]
pub(crate) struct Play {
    /// The recording
    pub(crate) file: PathBuf,
    #[command(flatten)]
    pub(crate) bus: Bus,
    /// How many times as fast as recorded, or max: each request after the reply before
    #[arg(long, value_name = "N", default_value = "1", value_parser = rate)]
    pub(crate) rate: Rate,
    /// How many clients play, each everything
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) clients: NonZero<u8>,
    /// Begin again at the end, until a signal comes
    #[arg(long = "loop")]
    pub(crate) repeat: bool,
    /// Leave out what was sent earlier after the first request
    #[arg(long, value_name = "TIME", default_value = "0s", value_parser = program::time)]
    pub(crate) start: Duration,
    /// Leave out what was sent later after the first request
    #[arg(long, value_name = "TIME", value_parser = program::time)]
    pub(crate) until: Option<Duration>,
    /// Send each request when Enter is pressed
    #[arg(long, conflicts_with_all = ["rate", "clients", "repeat"])]
    pub(crate) step: bool,
    /// Print lines for people, or one JSON object
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
}

/// How fast requests are played.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rate {
    Times(f64),
    Most,
}

fn rate(text: &str) -> Result<Rate, String> {
    match text.parse::<f64>() {
        _ if text == "max" => Ok(Rate::Most),
        // Up to where a recording of years is played in nanoseconds, and the reverse.
        Ok(rate) if (1e-6..=1e6).contains(&rate) => Ok(Rate::Times(rate)),
        _ => Err("must be a number from 0.000001 to 1000000, or max".to_owned()),
    }
}

#[derive(Debug, Args)]
pub(crate) struct Merge {
    /// The recordings
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// The new recording
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    pub(crate) overwrite: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Diff {
    /// The recording that counts as right
    pub(crate) a: PathBuf,
    /// The recording to compare with it
    pub(crate) b: PathBuf,
    #[command(flatten)]
    pub(crate) compare: Compare,
    #[command(flatten)]
    pub(crate) page: HtmlPage,
    #[command(flatten)]
    pub(crate) strict: Strict,
    /// Print lines for people, one JSON object, or JUnit XML
    #[arg(long, value_enum, default_value_t = ReportFormat::Text)]
    pub(crate) format: ReportFormat,
}

#[derive(Debug, Args)]
pub(crate) struct Show {
    /// The recording
    pub(crate) file: PathBuf,
    /// Only scenes with this id; repeatable
    #[arg(long, value_name = "ID", conflicts_with_all = ["request", "reply"])]
    pub(crate) id: Vec<u64>,
    /// Only this task; repeatable
    #[arg(long, value_name = "TASK", value_parser = filter::task, conflicts_with_all = ["request", "reply"])]
    pub(crate) task: Vec<Task>,
    /// Only what is refused: with this code, or at all
    #[arg(
        long,
        value_name = "CODE",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "any",
        value_parser = filter::refused,
        conflicts_with_all = ["request", "reply"]
    )]
    pub(crate) error: Option<Refused>,
    /// Only answers for which this holds, such as 'clearance<0.1'; of several, all
    #[arg(long = "where", value_name = "CONDITION", conflicts_with_all = ["request", "reply"])]
    pub(crate) conditions: Vec<Condition>,
    /// Print the scene of this request, from 0, as JSON that `plan` takes
    #[arg(long, value_name = "N", conflicts_with_all = ["reply", "format"])]
    pub(crate) request: Option<u64>,
    /// Print the reply to this request, from 0: as a table, JSON, or a row for each sample
    #[arg(long, value_name = "N")]
    pub(crate) reply: Option<u64>,
    /// Print a table, one JSON object per line, or CSV
    #[arg(long, value_enum, default_value_t = TableFormat::Text)]
    pub(crate) format: TableFormat,
    /// Draw the request with its recorded reply instead of printing
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) svg: Option<PathBuf>,
    /// Replace an existing picture
    #[arg(long, requires = "svg")]
    pub(crate) overwrite: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableFormat {
    Text,
    Json,
    Csv,
}

#[derive(Debug, Clone, Copy, Default, Args)]
pub(crate) struct Compare {
    /// How far numbers may differ, in all or by quantity: 1e-9, or position=1mm,time=1ms
    /// [default: not at all]
    #[arg(long, value_name = "TOLERANCE", value_parser = tolerances::parse)]
    tolerance: Option<Tolerance>,
}

/// A page that is written beside what is printed.
#[derive(Debug, Default, Args)]
pub(crate) struct HtmlPage {
    /// Write a page with every difference drawn: one file, which needs no network
    #[arg(long, value_name = "FILE.html")]
    pub(crate) html: Option<PathBuf>,
    /// Replace an existing page
    #[arg(long, requires = "html")]
    overwrite: bool,
}

impl HtmlPage {
    /// Whether something is in the way, before the work begins.
    pub(crate) fn check(&self, inputs: &[&Path]) -> Result<(), OutputError> {
        let path = self.html.as_deref();
        path.map_or(Ok(()), |path| output::check(path, self.overwrite, inputs))
    }

    /// Writes the page, if one is wanted.
    pub(crate) fn write(&self, make: impl FnOnce() -> String) -> Result<(), OutputError> {
        let path = self.html.as_deref();
        path.map_or(Ok(()), |path| output::write(path, &make(), self.overwrite))
    }
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

impl Compare {
    pub(crate) fn tolerance(&self) -> Tolerance {
        self.tolerance.unwrap_or_default()
    }
}
