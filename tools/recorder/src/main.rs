//! The `recorder` command; see `recorder --help`.

use std::io::{self, IsTerminal};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use bus::Domain;
use clap::Parser;
use recorder::Settings;
use recording::FLUSH_INTERVAL;
use tracing_subscriber::EnvFilter;

/// Logs all requests and replies of a planner to an MCAP file until told to stop
/// (SIGINT, SIGTERM), then finishes the file.
#[derive(Parser)]
#[command(
    version,
    after_help = "\
Examples:
  recorder -o run.mcap
  recorder -o run.mcap --for 60s --flush 100ms

If the recorder is killed, the file holds everything up to the last flush; `replay recover`
finishes it. Messages that came too fast are counted, reported and written to the file.

Diagnostics go to stderr, the summary to stdout.
Exit codes: 0 done, 1 failure, 2 usage, 3 messages were lost."
)]
struct Arguments {
    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The planner's domain
    #[arg(long, value_name = "NAME")]
    domain: Option<Domain>,
    /// Replace an existing file
    #[arg(long)]
    overwrite: bool,
    /// Stop after this time
    #[arg(long = "for", value_name = "TIME", value_parser = humantime::parse_duration)]
    duration: Option<Duration>,
    /// How much may be lost if the recorder is killed [default: 250ms]
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    flush: Option<Duration>,
    /// How long to wait for a planner to come up
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration, default_value = "10s")]
    wait: Duration,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    tracing_subscriber::fmt()
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        .with_env_filter(EnvFilter::try_from_default_env().unwrap_or_else(|_| "info".into()))
        .init();
    bus::forward_to_tracing();
    let settings = Settings {
        output: arguments.output.clone(),
        domain: arguments.domain.unwrap_or_default(),
        overwrite: arguments.overwrite,
        duration: arguments.duration,
        flush: arguments.flush.unwrap_or(FLUSH_INTERVAL),
        wait: arguments.wait,
    };
    match recorder::run(&settings) {
        Ok(summary) => {
            println!(
                "{}: {} messages recorded, {} lost",
                arguments.output.display(),
                summary.recorded,
                summary.lost
            );
            if summary.lost == 0 { ExitCode::SUCCESS } else { ExitCode::from(3) }
        }
        Err(error) => {
            eprintln!("recorder: {error}");
            ExitCode::FAILURE
        }
    }
}
