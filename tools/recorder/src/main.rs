//! The `recorder` command; see `recorder --help`.

use std::error::Error;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use bus::Domain;
use clap::Parser;
use program::{Diagnostics, Exit, LogFormat, PrintError};
use recorder::Settings;
use recording::{FLUSH_INTERVAL, Summary};

/// Records all requests and replies of a planner to an MCAP file until a signal (SIGINT,
/// SIGTERM or SIGHUP) asks it to end; then finishes the file
#[derive(Parser)]
#[command(
    name = "recorder",
    version,
    after_help = "\
Examples:
  recorder -o run.mcap
  recorder -o run.mcap --for 60s --flush 100ms

If the recorder is killed, the file has everything up to the last flush; `replay recover`
finishes it. Messages that came too fast are counted; the count is printed and written to the
file.

Domains are found under CLEARWAY_ROOT; by default, under clearway in XDG_RUNTIME_DIR, or
/tmp/clearway-UID. `plan --list` shows them.

The summary goes to stdout, diagnostics to stderr; RUST_LOG chooses them (RUST_LOG=debug).
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
    /// End after this time [default: at a signal]
    #[arg(long = "for", value_name = "TIME", value_parser = humantime::parse_duration)]
    duration: Option<Duration>,
    /// How often to flush: as much is lost if the recorder is killed [default: 250ms]
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    flush: Option<Duration>,
    /// How long to wait for a planner to start
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration, default_value = "10s")]
    wait: Duration,
    /// How diagnostics look: text, or json, an object on each line
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    log_format: LogFormat,
}

fn main() -> ExitCode {
    program::main("recorder", || {
        let arguments = Arguments::parse();
        program::start_diagnostics(Diagnostics::Events, arguments.log_format);
        bus::forward_to_tracing();
        run(arguments)
    })
}

fn run(arguments: Arguments) -> Result<Exit, Box<dyn Error>> {
    let Arguments { output, domain, overwrite, duration, flush, wait, log_format: _ } = arguments;
    let domain = domain.unwrap_or_default();
    let flush = flush.unwrap_or(FLUSH_INTERVAL);
    let settings = Settings { output, domain, overwrite, duration, flush, wait };
    let Summary { recorded, lost, .. } = recorder::run(&settings)?;
    let path = settings.output.display();
    let exit = if lost == 0 { Exit::Done } else { Exit::Lost };
    let printed = writeln!(io::stdout(), "{path}: {recorded} messages recorded, {lost} lost");
    match printed.map_err(PrintError) {
        // What was lost counts, even if nobody reads on.
        Err(error) if !error.is_closed() => Err(error.into()),
        _ => Ok(exit),
    }
}
