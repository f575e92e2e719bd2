//! Command-line arguments.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bus::Domain;
use clap::{Args, Parser, Subcommand, ValueEnum};
use comparison::tolerance::Tolerance;
use schemas::message::Task;

use crate::bless::only::Only;
use crate::changes::FieldChange;
use crate::output::{self, OutputError};
use crate::show::filter::{self, Condition, Refused};
use crate::tolerances;

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
  129, 130, 143  a signal came (SIGHUP, SIGINT, SIGTERM) while a planner was asked
If several apply, the first of 4, 1, 3 counts.";

const EXAMPLES: &str = "\
Examples:
  replay check recordings/              check all *.mcap in a folder and below
  replay check run.mcap --tolerance 1e-9
  replay check recordings/ --format junit > report.xml
  replay info run.mcap --format json
  replay show run.mcap --task drive --where 'clearance<0.1'
  replay show run.mcap --request 3 | plan -
  replay diff before.mcap after.mcap
  replay bless recordings/ --only moved
  replay extract run.mcap --failing -o failing.mcap
  replay recover killed.mcap.part -o whole.mcap
";

const COMPARED: &str = "\
Codes, fields and numbers are compared. Messages are for people: replies whose refusals are
only worded differently are equal, and counted. Replies that depend on load (too late,
overloaded) are not compared.
";

const CHECKED: &str = "\
Examples:
  replay check recordings/                         all *.mcap in a folder and below
  replay check run.mcap --tolerance position=1mm,heading=0.1deg,time=1ms
  replay check run.mcap --with limits.speed=0.8    what another speed would change
  replay check recordings/ --format junit > report.xml
  replay check recordings/ --html report.html
  replay check recordings/ --via-bus               what the running planner replies
";

const PAIRED: &str = "\
Requests are paired by the ids of their scenes. Those without id are paired if they are equal, or
else by their order within their client: the first client to appear in A is the first of B. Of
several with the same id, the n-th belongs to the n-th.
";

const TOLERANCES: &str = "\
Tolerances: a number for everything, in metres, radians and seconds, or a list of
  position (m, mm, um), heading (rad, deg), time (s, ms), length, clearance, gap (m, mm),
  speed (m/s, mm/s), yaw_rate (rad/s, deg/s), refusal (numbers of refusals, no unit)
What is not listed must be equal bit for bit. For points and velocities, the distance counts. The
file replay.toml beside a recording says the same, for what the command line does not:
  [tolerance]
  position = \"1mm\"
";

const BLESSED: &str = "\
Examples:
  replay bless recordings/
  replay bless recordings/ --only moved --only id=7

Every reply that is not equal bit for bit is accepted, or of these those that --only names. Requests
and other replies stay byte for byte; a recording of an older version becomes one of the newest. A
recording is replaced only if git has it as it is, unless --uncommitted says that it may be lost.
";

const EXTRACTED: &str = "\
Examples:
  replay extract run.mcap --failing -o failing.mcap
  replay extract run.mcap --request 3 --id 17 -o some.mcap

A request for a free space by its name alone gets the free space, so that it can be planned alone.
";

const MERGED: &str = "\
Example:
  replay merge monday.mcap tuesday.mcap -o week.mcap

A request that is in two of them is an error: its replies could not be told apart.
";

const PLAYED: &str = "\
Examples:
  replay play run.mcap                        as it was
  replay play run.mcap --rate 2 --loop        twice as fast, until Ctrl-C
  replay play run.mcap --rate max --clients 8

Each client sends all requests, in the order of the file and at their recorded times; one whose
reply takes longer sends the next late. Replies are not compared: replay check --via-bus does that.
";

const SHOWN: &str = "\
Examples:
  replay show run.mcap
  replay show run.mcap --error --task drive
  replay show run.mcap --where 'clearance<0.1' --where 'took>=50ms'
  replay show run.mcap --request 3 | plan -
  replay show run.mcap --reply 3 --format csv > samples.csv
  replay show run.mcap --request 3 --svg scene.svg

There is a row for each answer. Numbers that --where compares:
  request           of the request, from 0, in the order of the file
  id                of the scene
  answer            of the answer to its request, from 0
  length, clearance, free_clearance, bound
                    metres, or with a unit: 5mm
  duration, took    seconds, or with a unit: 50ms. took is the time from sending the request
                    to sending the last part of the reply
  legs, samples     how many
An answer that has no such number is not listed. Operators: < <= > >= = !=

A request for a free space by its name alone is printed with the free space, if the recording has
it. A free-standing scene gives the same reply.
";

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
    #[command(after_help = format!("{CHECKED}\n{COMPARED}\n{TOLERANCES}\n{EXIT_CODES}"))]
    Check(Check),
    /// List a recording's requests, or print one of them or its reply
    #[command(after_help = format!("{SHOWN}\n{EXIT_CODES}"))]
    Show(Show),
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
    /// Compare the replies of two recordings
    #[command(after_help = format!("{PAIRED}\n{COMPARED}\n{TOLERANCES}\n{EXIT_CODES}"))]
    Diff(Diff),
    /// Accept the replies planned now: rewrite those recorded, and nothing else
    #[command(after_help = format!("{BLESSED}\n{EXIT_CODES}"))]
    Bless(Bless),
    /// Copy some requests and their replies into a recording of their own
    #[command(after_help = format!("{EXTRACTED}\n{EXIT_CODES}"))]
    Extract(Extract),
    /// Put recordings together as one, in the order of time
    #[command(after_help = format!("{MERGED}\n{EXIT_CODES}"))]
    Merge(Merge),
    /// Send recorded requests to a running planner, and print how long its replies take
    #[command(after_help = format!("{PLAYED}\n{EXIT_CODES}"))]
    Play(Play),
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

/// The planner that is asked.
#[derive(Debug, Default, Args)]
pub(crate) struct Bus {
    /// The planner's domain
    #[arg(long, value_name = "NAME")]
    pub(crate) domain: Option<Domain>,
    /// How long to wait for a planner to start
    #[arg(long, value_name = "TIME", default_value = "0s", value_parser = humantime::parse_duration)]
    pub(crate) wait: Duration,
    /// How long to wait for each reply
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = humantime::parse_duration)]
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
    #[arg(long, value_name = "TIME", default_value = "0s", value_parser = humantime::parse_duration)]
    pub(crate) start: Duration,
    /// Leave out what was sent later after the first request
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
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
