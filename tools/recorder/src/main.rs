//! The `recorder` command; see `recorder --help`.

use std::io::{self, IsTerminal};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use bus::{ConnectError, Domain, TapEvent, TapMessage, TapReader};
use clap::Parser;
use recording::{FLUSH_INTERVAL, Options, Summary, WriteError, Writer};
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

/// How long the recorder sleeps when nothing is there: the tap's buffer holds far more
/// than comes meanwhile.
const IDLE: Duration = Duration::from_millis(1);

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    tracing_subscriber::fmt()
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        .with_env_filter(EnvFilter::try_from_default_env().unwrap_or_else(|_| "info".into()))
        .init();
    bus::forward_to_tracing();
    match run(&arguments) {
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

#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error(transparent)]
    Connect(#[from] ConnectError),
    #[error(transparent)]
    Write(#[from] WriteError),
}

fn run(arguments: &Arguments) -> Result<Summary, Failure> {
    let mut tap = connect(arguments)?;
    let mut writer = Writer::create(&arguments.output, Options { overwrite: arguments.overwrite })?;
    tracing::info!(output = %arguments.output.display(), "recording");
    let interval = arguments.flush.unwrap_or(FLUSH_INTERVAL);
    let begin = Instant::now();
    let mut flushed = Instant::now();
    loop {
        let mut idle = true;
        // Asked before looking, so that what came before the signal is taken.
        let stop = tap.terminated() || arguments.duration.is_some_and(|d| begin.elapsed() >= d);
        while let Some(event) = tap.receive() {
            idle = false;
            record(&mut writer, event)?;
            if flushed.elapsed() >= interval {
                break;
            }
        }
        if flushed.elapsed() >= interval {
            writer.flush()?;
            flushed = Instant::now();
        }
        if stop && idle {
            return Ok(writer.finish()?);
        }
        if idle {
            std::thread::sleep(IDLE);
        }
    }
}

fn connect(arguments: &Arguments) -> Result<TapReader, ConnectError> {
    let domain = arguments.domain.clone().unwrap_or_default();
    let until = Instant::now() + arguments.wait;
    let mut told = false;
    loop {
        match TapReader::connect(&domain) {
            Err(ConnectError::NoPlanner { .. }) if Instant::now() < until => {
                if !told {
                    tracing::info!(%domain, "waiting for a planner");
                    told = true;
                }
                std::thread::sleep(Duration::from_millis(50));
            }
            done => return done,
        }
    }
}

fn record(writer: &mut Writer, event: TapEvent) -> Result<(), WriteError> {
    let log_ns = bus::now_ns();
    let written = match event {
        TapEvent::Message(TapMessage::Request(request)) => writer.write_request(&request, log_ns),
        TapEvent::Message(TapMessage::Reply(part)) => writer.write_reply(&part, log_ns),
        TapEvent::Lost { messages } => {
            tracing::warn!(messages, "lost: they came too fast");
            writer.lost(messages);
            Ok(())
        }
        TapEvent::Restarted => {
            tracing::warn!("another planner took over");
            Ok(())
        }
    };
    match written {
        // Counted as lost by the writer; the others go on.
        Err(error @ WriteError::TooLarge { .. }) => {
            tracing::warn!(%error, "lost");
            Ok(())
        }
        done => done,
    }
}
