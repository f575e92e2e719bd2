//! The planner process; see `planner --help`.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;

use bus::{Domain, Server};
use clap::Parser;
use planner::config::Config;
use planner::service::serve;
use tracing_subscriber::EnvFilter;

/// Answers scene requests over shared memory with sampled trajectories, until SIGINT
/// or SIGTERM.
#[derive(Parser)]
#[command(
    version,
    after_help = "\
Settings in FILE (TOML), with their defaults:
  wait = \"hybrid\"          # \"event\" sleeps, \"poll\" takes a core, \"hybrid\" spins, then sleeps
  max_clients = 32         # clients at a time
  requests_per_client = 4  # requests that one client can have open
  max_recorders = 2        # recorders at a time
  tap_buffer = 1024        # messages that wait for a slow recorder
  patience = 0.1           # seconds that a reply waits for a client that does not take it

Diagnostics go to stderr; RUST_LOG chooses them (RUST_LOG=debug shows every request).
Exit codes: 0 ended by a signal, 1 failure, 2 usage."
)]
struct Arguments {
    /// Settings
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Keeps systems on one machine apart
    #[arg(long, value_name = "NAME")]
    domain: Option<Domain>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_env_filter(EnvFilter::try_from_default_env().unwrap_or_else(|_| "info".into()))
        .init();
    bus::forward_to_tracing();
    match run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("planner: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> Result<(), Box<dyn std::error::Error>> {
    let config = match &arguments.config {
        Some(path) => Config::read(path)?,
        None => Config::default(),
    };
    let domain = arguments.domain.unwrap_or_default();
    let mut server = Server::open(&domain, &config.server_options())?;
    tracing::info!(%domain, wait = ?config.wait, "ready");
    let served = serve(&mut server);
    tracing::info!(requests = served.requests, undelivered = served.undelivered, "done");
    Ok(())
}
