//! The `recorder` command; see `recorder --help`.

use std::error::Error;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use bus::Domain;
use clap::{ArgMatches, Command, CommandFactory, FromArgMatches, Parser, ValueEnum};
use program::{Diagnostics, Exit, LogFormat, PrintError, warn};
use recording::{CHUNK_BYTES, Compression, FLUSH_INTERVAL, Finished, Split};
use schemas::message::ErrorCode;

use crate::{EndReason, Ended, Settings, Snapshot, Topic, Topics, size};

/// Records all requests and replies of a planner to an MCAP file until a signal (SIGINT,
/// SIGTERM or SIGHUP) asks it to end; then finishes the file
#[derive(Parser)]
#[command(
    name = "recorder",
    version = program::VERSION,
    after_help = "\
Examples:
  recorder -o run.mcap
  recorder -o run.mcap --duration 60s --flush 100ms --compression lz4
  recorder -o run.mcap --split-size 1GiB --max-files 10 --min-free-space 5GiB
  recorder -o late.mcap --snapshot 30s --snapshot-on no_route,deadline_exceeded

Until it is finished, run.mcap is run.mcap.part. If the recorder is killed, that has everything up
to the last flush, and how much the planner had sent by then; `replay recover` finishes it.
Messages that came too fast, and those that a planner had sent when it was lost, are counted; the
count is printed and written to the file.

A split recording is run-0000.mcap, run-0001.mcap and so on, each readable alone. A file ends
where no request waits for its reply, if there is such a moment in the last tenth of it.

Domains are found under CLEARWAY_ROOT; by default, under clearway in XDG_RUNTIME_DIR, or
/tmp/clearway-UID. `plan --list` shows them.

The summary goes to stdout, progress and diagnostics to stderr; RUST_LOG chooses them
(RUST_LOG=debug). Times have units (250ms, 10s, 1h), and so have sizes (64MiB, 1GB).
Exit codes: 0 done, 1 failure, 2 usage, 3 messages were lost."
)]
struct Arguments {
    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The planner's domain
    #[arg(long, value_name = "NAME")]
    domain: Option<Domain>,
    /// Replace existing files
    #[arg(long)]
    overwrite: bool,
    /// End after this time [default: at a signal]
    #[arg(long, visible_alias = "for", value_name = "TIME", value_parser = program::time)]
    duration: Option<Duration>,
    /// End after so many messages
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u64).range(1..))]
    max_messages: Option<u64>,
    /// End when the planner ends and no other takes over within 2 s
    #[arg(long)]
    exit_with_planner: bool,
    /// Record only these; the others are counted as left out
    #[arg(long, value_name = "TOPICS", value_delimiter = ',', value_enum)]
    topics: Vec<TopicName>,
    /// How often to flush: as much is lost if the recorder is killed [default: 250ms]
    #[arg(long, value_name = "TIME", value_parser = program::time)]
    flush: Option<Duration>,
    /// Wait at each flush until the disk has it, so that a power cut costs no more than a kill
    #[arg(long)]
    fsync: bool,
    /// How chunks are compressed
    #[arg(long, value_name = "METHOD", value_enum, default_value_t = Method::None)]
    compression: Method,
    /// The size of chunks, from 1KiB to 64MiB; a larger message has one of its own [default: 1MiB]
    #[arg(long, value_name = "SIZE", value_parser = chunk_size)]
    chunk_size: Option<u64>,
    /// Begin another file at this size
    #[arg(long, value_name = "SIZE", value_parser = size::parse)]
    split_size: Option<u64>,
    /// Begin another file after this time
    #[arg(long, value_name = "TIME", value_parser = program::time)]
    split_duration: Option<Duration>,
    /// Remove the oldest file where there would be more
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(1..))]
    max_files: Option<u32>,
    /// End when the disk has less than this left
    #[arg(long, value_name = "SIZE", value_parser = size::parse)]
    min_free_space: Option<u64>,
    /// Keep what came in this time in memory, and write it on SIGUSR1: FILE-0000 and so on
    #[arg(
        long,
        value_name = "TIME",
        value_parser = program::time,
        conflicts_with_all = ["split_size", "split_duration", "max_messages"]
    )]
    snapshot: Option<Duration>,
    /// The most memory that it takes; beyond, the oldest messages go first [default: 256MiB]
    #[arg(long, value_name = "SIZE", value_parser = size::parse, requires = "snapshot")]
    snapshot_size: Option<u64>,
    /// Write it as well when a request is refused with one of these codes
    #[arg(long, value_name = "CODES", value_delimiter = ',', value_parser = code, requires = "snapshot")]
    snapshot_on: Vec<ErrorCode>,
    /// How long to wait for a planner to start
    #[arg(long, value_name = "TIME", value_parser = program::time, default_value = "10s")]
    wait: Duration,
    /// How diagnostics look: text, or json, an object on each line
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    log_format: LogFormat,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Method {
    None,
    Lz4,
    Zstd,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum TopicName {
    Request,
    Reply,
    Status,
}

/// The most memory of a snapshot, bytes.
const SNAPSHOT_BYTES: u64 = 256 << 20;

fn chunk_size(text: &str) -> Result<u64, String> {
    let bytes = size::parse(text)?;
    let range = 1 << 10..=64 << 20;
    if range.contains(&bytes) { Ok(bytes) } else { Err("must be from 1KiB to 64MiB".to_owned()) }
}

fn code(text: &str) -> Result<ErrorCode, String> {
    let found = ErrorCode::ALL.iter().find(|code| code.name() == text);
    found.copied().ok_or_else(|| {
        let names: Vec<_> = ErrorCode::ALL.iter().map(|code| code.name()).collect();
        format!("the codes are {}", names.join(", "))
    })
}

impl Arguments {
    fn settings(self) -> Settings {
        let Self {
            output,
            domain,
            overwrite,
            duration,
            max_messages,
            exit_with_planner,
            topics,
            flush,
            fsync,
            compression,
            chunk_size,
            split_size,
            split_duration,
            max_files,
            min_free_space,
            snapshot,
            snapshot_size,
            snapshot_on,
            wait,
            log_format: _,
        } = self;
        let topics: Topics = match topics[..] {
            [] => Topics::default(),
            _ => topics
                .into_iter()
                .map(|topic| match topic {
                    TopicName::Request => Topic::Request,
                    TopicName::Reply => Topic::Reply,
                    TopicName::Status => Topic::Status,
                })
                .collect(),
        };
        Settings {
            overwrite,
            duration,
            max_messages,
            flush: flush.unwrap_or(FLUSH_INTERVAL),
            sync: fsync,
            wait,
            exit_with_planner,
            topics,
            compression: match compression {
                Method::None => Compression::None,
                Method::Lz4 => Compression::Lz4,
                Method::Zstd => Compression::Zstd,
            },
            chunk_bytes: chunk_size.unwrap_or(CHUNK_BYTES),
            split: Split {
                bytes: split_size,
                time: split_duration,
                files: max_files.map(|files| files as usize),
            },
            min_free: min_free_space,
            snapshot: snapshot.map(|time| Snapshot {
                time,
                most_bytes: snapshot_size.unwrap_or(SNAPSHOT_BYTES),
                on: snapshot_on,
            }),
            ..Settings::new(output, domain.unwrap_or_default())
        }
    }
}

/// Its command line.
pub fn command() -> Command {
    Arguments::command()
}

/// Runs it.
pub fn run(matches: &ArgMatches) -> ExitCode {
    program::main("recorder", || {
        let arguments = Arguments::from_arg_matches(matches)?;
        program::start_diagnostics(Diagnostics::Events, arguments.log_format);
        bus::forward_to_tracing();
        record(arguments.settings())
    })
}

fn record(settings: Settings) -> Result<Exit, Box<dyn Error>> {
    let Ended { finished, end } = crate::run(&settings)?;
    let Finished { summary, files, removed, missing } = finished;
    let is_whole = summary.lost == 0 && missing.is_empty();
    let mut exit = if is_whole { Exit::Done } else { Exit::Lost };
    for name in &missing {
        warn(format_args!("recorder: requests name free space {name}, which is not recorded"));
    }
    if let EndReason::NoSpace { free, least } = end {
        warn(format_args!("recorder: {free} bytes are free, {least} are to stay free"));
        exit = Exit::Failure;
    }
    let path = settings.output.display();
    let mut said = format!("{path}: {} messages recorded, {} lost", summary.recorded, summary.lost);
    if summary.left_out > 0 {
        said += &format!(", {} left out", summary.left_out);
    }
    match (&settings.snapshot, settings.split.is_never()) {
        (Some(_), _) => {
            said += &format!(", in {files} snapshot{}", if files == 1 { "" } else { "s" });
        }
        (None, false) => {
            said += &format!(", in {files} file{}", if files == 1 { "" } else { "s" });
            if removed > 0 {
                said += &format!(", of which the first {removed} were removed");
            }
        }
        (None, true) => {}
    }
    match writeln!(io::stdout(), "{said}").map_err(PrintError) {
        // What was lost counts, even if nobody reads on.
        Err(error) if !error.is_closed() => Err(error.into()),
        _ => Ok(exit),
    }
}
