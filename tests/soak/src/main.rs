//! The `soak` command; see `soak --help`.

mod account;
mod client;
mod cycle;
mod health;

use std::error::Error;
use std::io::Write;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use account::Account;
use bus::Domain;
use clap::Parser;
use cycle::{Cycle, Plan, Watch};
use fastrand::Rng;
use health::Health;
use integration_tests::TestDomain;
use program::{Diagnostics, Exit, LogFormat, PrintError};

/// Has many clients use a planner for a while, many of them faulty, and accounts for every
/// request.
///
/// In each cycle, clients ask, drop requests, set deadlines, read slowly, write nonsense into
/// shared memory, leave, and are killed and replaced at random; so is a recorder. In the first
/// third of the cycles, the planner is killed as well. Between cycles, when all have left, nothing
/// may be left of them: neither requests nor memory, descriptors, threads or files.
#[derive(Parser)]
#[command(
    name = "soak",
    version,
    after_help = "\
Examples:
  soak
  soak --for 1h --clients 64

The table goes to stdout. Ctrl-C ends it after the cycle.
Exit codes: 0 all is accounted for, 1 something is not, or grew, 2 usage."
)]
struct Arguments {
    /// How long, about, and at least until it can tell what grows: 30s, 1h
    #[arg(long = "for", value_name = "DURATION", default_value = "30s", value_parser = humantime::parse_duration)]
    lasts: Duration,
    /// Clients at a time
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=256))]
    clients: u32,
    /// How long clients come and go before all leave
    #[arg(long, value_name = "DURATION", default_value = "4s", value_parser = humantime::parse_duration)]
    cycle: Duration,
    /// Never kill the planner
    #[arg(long)]
    calm: bool,
    /// Where chance begins
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// For the clients that this program starts: the domain
    #[arg(long, hide = true)]
    domain: Option<Domain>,
}

/// Set for the clients: where their chance begins.
const SEED: &str = "CLEARWAY_SOAK_SEED";

/// Open requests of one client.
const REQUESTS_PER_CLIENT: usize = 2;

/// Cycles in which nothing is compared yet: what is made once is made.
const WARM_UP: usize = 2;

fn main() -> ExitCode {
    program::main("soak", || {
        let arguments = Arguments::parse();
        program::start_diagnostics(Diagnostics::Warnings, LogFormat::Text);
        bus::forward_to_tracing();
        if let Some(domain) = &arguments.domain {
            client::run(domain, std::env::var(SEED)?.parse()?)?;
            return Ok(Exit::Done);
        }
        soak(&arguments)
    })
}

fn soak(arguments: &Arguments) -> Result<Exit, Box<dyn Error>> {
    // From this call on, a signal leaves time to end the other processes.
    bus::terminated();
    let Arguments { lasts, clients, cycle, seed, .. } = *arguments;
    let test = TestDomain::new();
    // Clients have their peers that write nonsense, and places are kept for those just killed.
    let settings = format!(
        "max_clients = {}\nrequests_per_client = {REQUESTS_PER_CLIENT}\nqueue = {clients}",
        2 * clients + 16
    );
    test.write("planner.toml", &settings);
    let planner = test.planner(&["--config", "planner.toml"]);
    let watch = Watch::start(&test)?;
    let (_, alone) = cycle::quiet(&test, &watch, None, &mut Account::default())?;
    let (mut rng, mut total) = (Rng::with_seed(seed), Account::default());
    let (mut before, mut calm) = (None::<Health>, 0);
    let begun = Instant::now();
    heading()?;
    // As long as it takes to tell, however slow the machine is.
    while (begun.elapsed() < lasts || calm <= WARM_UP) && !bus::terminated() {
        let kills_planners = !arguments.calm && begun.elapsed() < lasts / 3;
        let plan = Plan { clients: clients as usize, lasts: cycle, kills_planners };
        let mut done = cycle::run(&test, &watch, &plan, &alone, &mut rng)
            .inspect_err(|_| eprintln!("the planner said:\n{}", planner.stderr()))?;
        if !kills_planners && done.account.lost > 0 {
            let lost = done.account.lost;
            done.account.fault(format!("{lost} requests were lost by a planner that lives"));
        }
        calm += usize::from(!kills_planners);
        match &before {
            Some(before) => done.health.growth(before).into_iter().for_each(|grown| {
                done.account.fault(format!("the planner has {grown}"));
            }),
            None if calm == WARM_UP => before = Some(done.health),
            None => {}
        }
        row(begun.elapsed(), &done)?;
        total += done.account;
    }
    drop(watch);
    let ended = planner.stop();
    if ended.code != Some(0) {
        total.fault(format!("the planner ended with {:?}: {}", ended.code, ended.stderr));
    }
    if total.sent != total.ended() {
        total.fault(format!("{} requests were sent, {} have an end", total.sent, total.ended()));
    }
    if calm <= WARM_UP {
        total.fault("ended before it could tell what grows".to_owned());
    }
    verdict(&total)
}

const COLUMNS: [&str; 15] = [
    "after",
    "kills",
    "sent",
    "answered",
    "refused",
    "cancelled",
    "given up",
    "lost",
    "gone",
    "fds",
    "threads",
    "memory",
    "shared",
    "files",
    "p99",
];

fn print(cells: [String; 15]) -> Result<(), PrintError> {
    let mut line = String::new();
    for (cell, column) in cells.iter().zip(COLUMNS) {
        let width = column.len().max(8);
        line += &format!("{cell:>width$} ");
    }
    writeln!(std::io::stdout(), "{}", line.trim_end()).map_err(PrintError)
}

fn heading() -> Result<(), PrintError> {
    print(COLUMNS.map(str::to_owned))
}

fn row(after: Duration, cycle: &Cycle) -> Result<(), PrintError> {
    let Cycle { account, kills, status, health } = cycle;
    let mega = |bytes: u64| format!("{:.1} MB", bytes as f64 / 1e6);
    print([
        format!("{} s", after.as_secs()),
        kills.to_string(),
        account.sent.to_string(),
        account.answered.to_string(),
        account.refusals().to_string(),
        account.cancelled.to_string(),
        account.given_up.to_string(),
        account.lost.to_string(),
        account.gone.to_string(),
        health.descriptors.to_string(),
        health.threads.to_string(),
        mega(health.memory),
        mega(health.shared),
        health.files.to_string(),
        format!("{:.1} ms", status.latency.p99 / 1e3),
    ])
}

fn verdict(total: &Account) -> Result<Exit, Box<dyn Error>> {
    let mut out = std::io::stdout();
    let codes: Vec<_> =
        total.refused.iter().map(|(code, count)| format!("{code} {count}")).collect();
    writeln!(out, "\nrefused: {}", codes.join(", ")).map_err(PrintError)?;
    if total.faults.is_empty() {
        let all = "requests are accounted for, and nothing grew";
        writeln!(out, "all {} {all}", total.sent).map_err(PrintError)?;
        return Ok(Exit::Done);
    }
    for fault in &total.faults {
        writeln!(out, "fault: {fault}").map_err(PrintError)?;
    }
    Ok(Exit::Failure)
}
