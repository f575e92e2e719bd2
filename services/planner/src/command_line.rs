//! The `planner` command; see `planner --help`.

use std::error::Error;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use answer::CacheStats;
use bus::{Domain, Server};
use clap::{ArgMatches, Command, CommandFactory, FromArgMatches, Parser};
use configuration::Config;
use program::{Diagnostics, Exit, LogFormat};

use crate::metrics;
use crate::options::server_options;
use crate::service::serve;
use crate::supervisor::supervise;

/// Plans the scenes that clients send over shared memory, until it is ended by a signal.
#[derive(Parser)]
#[command(
    name = "planner",
    version = program::VERSION,
    after_help = "\
Settings in FILE (TOML), with their defaults:
  wait = \"hybrid\"          # \"event\" sleeps, \"poll\" takes a core, \"hybrid\" spins, then sleeps
  max_clients = 64         # clients connected at a time
  requests_per_client = 2  # open requests of one client
  max_recorders = 2        # recorders connected at a time
  tap_buffer = 768         # messages kept for a slow recorder
  reserve = false          # true takes all of this shared memory at the start
  patience = 1.0           # seconds that a reply waits for a client that does not take it
  workers = 0              # requests planned at a time; 0: one for each core but one
  queue = 256              # requests that wait for a worker; more are refused as overloaded
  queue_bytes = 268435456  # bytes of requests that wait, and of replies not taken yet
  grace = 2.0              # seconds for what is in hand when the planner is asked to end
  cache = 268435456        # bytes kept between requests, mostly of free spaces; 0 keeps none
  [caps]                   # what one request may cost; more is refused as too_costly
  cells = 67108864         # size of the request, in cells of 8 bytes
  steps = 1000000000       # steps of planning, all answers together (about 10 ns each)
  bytes = 1073741824       # bytes of memory held at a time, replies included
  answers = 10000          # answers to the request
  samples = 1000000        # samples of one trajectory (72 bytes of reply each)
  pieces = 1048576         # boxes that the solids are cut into (200 bytes each)
  channels = 262144        # channels made from the solids (100 bytes each)
  channel_steps = 67108864 # boxes looked at to make them (10 to 100 ns each)
  junctions = 4194304      # junctions of the channels (16 bytes each)
  route_steps = 16777216   # pairs of junctions looked at for one route

Domains are found under CLEARWAY_ROOT; by default, under clearway in XDG_RUNTIME_DIR, or
/tmp/clearway-UID. `plan --list` shows them.

Diagnostics go to stderr; RUST_LOG selects them (RUST_LOG=debug shows every request). Under
systemd (Type=notify, NotifyAccess=all) the planner says when it is ready; WatchdogSec works.
Exit codes: 0 ended by a signal, 1 failure, 2 usage."
)]
struct Arguments {
    /// Reads settings from a file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Serves metrics for Prometheus at http://ADDR/metrics; a port alone is on this machine only
    #[arg(long, value_name = "ADDR", value_parser = metrics::address)]
    metrics: Option<SocketAddr>,
    /// Takes at the start all shared memory that serving can come to need, so that a /dev/shm
    /// which fills up later does no harm
    #[arg(long)]
    reserve: bool,
    /// How diagnostics look: text, or json, an object on each line
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    log_format: LogFormat,
    /// Serves in this process alone, without another one that starts it again if it dies
    #[arg(long)]
    unsupervised: bool,
    /// When asked to end, goes on with what is in hand for this long
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    grace: Option<f64>,
    /// Serves this domain; systems in different domains do not see each other
    #[arg(long, value_name = "NAME")]
    domain: Option<Domain>,
}

/// Its command line.
pub fn command() -> Command {
    Arguments::command()
}

/// Runs it.
pub fn run(matches: &ArgMatches) -> ExitCode {
    program::main("planner", || {
        let arguments = Arguments::from_arg_matches(matches)?;
        program::start_diagnostics(Diagnostics::Events, arguments.log_format);
        bus::forward_to_tracing();
        serve_until_ended(arguments)
    })
}

fn seconds(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "not a number of seconds".to_owned())
}

fn serve_until_ended(arguments: Arguments) -> Result<Exit, Box<dyn Error>> {
    let mut config = match &arguments.config {
        Some(path) => Config::read(path)?,
        None => Config::default(),
    };
    if let Some(grace) = arguments.grace {
        config.grace = grace;
        config.check(Path::new("--grace"))?;
    }
    config.reserve |= arguments.reserve;
    if !arguments.unsupervised
        && let Some(exit) = supervise(Duration::from_secs_f64(config.grace))?
    {
        return Ok(exit);
    }
    let domain = arguments.domain.unwrap_or_default();
    let mut server = Server::open(&domain, &server_options(&config))?;
    let served = serve((&mut server, &domain), &config, arguments.metrics)?;
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
