//! The planner process; see `planner --help`.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use answer::CacheStats;
use bus::{Domain, Server};
use clap::Parser;
use configuration::Config;
use planner::service::{serve, server_options};
use program::{Diagnostics, Exit};

/// Answers scene requests over shared memory with sampled trajectories, until SIGINT
/// or SIGTERM.
#[derive(Parser)]
#[command(
    name = "planner",
    version,
    after_help = "\
Settings in FILE (TOML), with their defaults:
  wait = \"hybrid\"          # \"event\" sleeps, \"poll\" takes a core, \"hybrid\" spins, then sleeps
  max_clients = 32         # clients at a time
  requests_per_client = 4  # requests that one client can have open
  max_recorders = 2        # recorders at a time
  tap_buffer = 1024        # messages that wait for a slow recorder
  patience = 0.1           # seconds that a reply waits for a client that does not take it
  cache = 268435456        # bytes of channels, junctions and walls kept for requests over the
                           # same free space; 0 keeps nothing
  [caps]                   # what one request may cost; what would cost more is refused
  cells = 67108864         # its size, in cells of 8 bytes (memory: some ten times as much)
  answers = 10000          # answers to it (time)
  samples = 1000000        # samples of each trajectory (time; 72 bytes of reply each)
  pieces = 1048576         # boxes that its solids are cut into (memory: 200 bytes each)
  channels = 262144        # channels made from its solids (memory: 100 bytes each)
  channel_steps = 67108864 # boxes looked at for that (time: 10 to 100 ns each)
  junctions = 4194304      # junctions of its channels (memory: 16 bytes each)
  route_steps = 16777216   # pairs of junctions looked at for a route (time, memory)

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
    program::main("planner", || {
        let arguments = Arguments::parse();
        program::start_diagnostics(Diagnostics::Events);
        bus::forward_to_tracing();
        run(arguments)
    })
}

fn run(arguments: Arguments) -> Result<Exit, Box<dyn Error>> {
    let config = match &arguments.config {
        Some(path) => Config::read(path)?,
        None => Config::default(),
    };
    let domain = arguments.domain.unwrap_or_default();
    let mut server = Server::open(&domain, &server_options(&config))?;
    tracing::info!(%domain, wait = ?config.wait, "ready");
    let served = serve(&mut server, &config);
    let CacheStats { hits, misses, bytes, .. } = served.cache;
    tracing::info!(
        requests = served.requests,
        undelivered = served.undelivered,
        cache_hits = hits,
        cache_misses = misses,
        cache_bytes = bytes,
        "done"
    );
    Ok(Exit::Done)
}
