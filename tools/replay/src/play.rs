//! `replay play`: sends recorded requests to a running planner.

use std::error::Error;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Barrier, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

use bus::{CallError, Client, ConnectError};
use comparison::describe::counted;
use hdrhistogram::Histogram;
use program::warn;
use schemas::message::{RequestContent, SceneRequest};
use serde_json::json;

use crate::arguments::{Format, Play, Rate};
use crate::findings::Findings;
use crate::report::write_json;
use crate::{reading, running};

/// Longer latencies count as this: an hour.
const LONGEST_NS: u64 = 3_600_000_000_000;

/// A request to send.
struct Cue {
    /// After the recording's first request.
    at: Duration,
    scene: SceneRequest,
}

/// What a client has seen.
struct Seen {
    /// From sending a request to its whole reply, nanoseconds.
    latency: Histogram<u64>,
    refused: u64,
    failed: u64,
    /// The first failure.
    failure: Option<String>,
    /// How late the request that was latest was sent.
    late: Duration,
}

impl Seen {
    fn new() -> Self {
        let latency = Histogram::new_with_bounds(1, LONGEST_NS, 3).expect("these are possible");
        Self { latency, refused: 0, failed: 0, failure: None, late: Duration::ZERO }
    }

    fn add(&mut self, other: Self) {
        let Self { latency, refused, failed, failure, late } = other;
        self.latency.add(latency).expect("all have the same bounds");
        self.refused += refused;
        self.failed += failed;
        self.failure = self.failure.take().or(failure);
        self.late = self.late.max(late);
    }
}

/// Runs the command; the inner result is that of printing.
pub(crate) fn run(
    arguments: &Play,
    findings: &mut Findings,
    out: &mut impl Write,
) -> Result<io::Result<()>, Box<dyn Error>> {
    let cues = cues(arguments, findings);
    if cues.is_empty() {
        return Err(format!("{} has no request to play", arguments.file.display()).into());
    }
    running::begin();
    let count = usize::from(arguments.clients.get());
    let (all_there, began) = (Barrier::new(count), OnceLock::new());
    let missing = AtomicBool::new(false);
    let client = || {
        let client = running::connect(&arguments.bus);
        missing.fetch_or(client.is_err(), Ordering::Relaxed);
        // All are there before the first asks, or nobody asks.
        all_there.wait();
        let client = client?;
        Ok(match missing.load(Ordering::Relaxed) {
            true => Seen::new(),
            false => play(arguments, &cues, &client, *began.get_or_init(Instant::now)),
        })
    };
    let seen: Result<Vec<Seen>, ConnectError> = thread::scope(|scope| {
        let playing: Vec<_> = (0..count).map(|_| scope.spawn(client)).collect();
        playing.into_iter().map(|client| client.join().expect("a client does not panic")).collect()
    });
    let took = began.get().map_or(Duration::ZERO, Instant::elapsed);
    let seen = seen?.into_iter().reduce(|mut all, seen| {
        all.add(seen);
        all
    });
    let seen = seen.expect("there is a client at least");
    if let Some(failure) = &seen.failure {
        let failed = seen.failed;
        let failed = counted(failed, "request");
        warn(format_args!("replay: no reply to {failed}; the first: {failure}"));
        findings.failure = true;
    }
    // A loop ends no other way.
    if !arguments.repeat {
        findings.interrupted = bus::termination_signal();
    }
    Ok(print(arguments, &seen, took, out))
}

/// The requests between `--start` and `--until`, in the order of the file.
fn cues(arguments: &Play, findings: &mut Findings) -> Vec<Cue> {
    let (mut found, mut unreadable) = (Vec::new(), 0);
    reading::whole(&arguments.file, findings, |asked| {
        match asked.request.content {
            RequestContent::Scene(scene) => found.push((asked.index, asked.request.sent_ns, scene)),
            RequestContent::Unreadable { .. } => unreadable += 1,
        }
        ControlFlow::Continue(())
    });
    // What lacks its reply can be played all the same.
    findings.loss = false;
    if unreadable > 0 {
        let unreadable = counted(unreadable, "request");
        warn(format_args!("replay: left out {unreadable} that can't be read as scenes"));
    }
    found.sort_by_key(|(index, ..)| *index);
    let first = found.iter().map(|(_, sent_ns, _)| *sent_ns).min().unwrap_or(0);
    let cues = found.into_iter().map(|(_, sent_ns, scene)| {
        let at = Duration::from_nanos(sent_ns - first);
        Cue { at, scene }
    });
    let is_wanted = |cue: &Cue| {
        cue.at >= arguments.start && arguments.until.is_none_or(|until| cue.at <= until)
    };
    cues.filter(is_wanted).map(|cue| Cue { at: cue.at - arguments.start, ..cue }).collect()
}

/// Plays all requests by one client, once or for ever.
fn play(arguments: &Play, cues: &[Cue], client: &Client, began: Instant) -> Seen {
    let mut seen = Seen::new();
    let mut round = began;
    loop {
        for cue in cues {
            let due = match arguments.rate {
                Rate::Times(rate) => round + cue.at.div_f64(rate),
                Rate::Most => round,
            };
            let waited = match arguments.step {
                true => step(cue),
                false => sleep_until(due),
            };
            if waited.is_break() {
                return seen;
            }
            let sent = Instant::now();
            if let (Rate::Times(_), false) = (arguments.rate, arguments.step) {
                seen.late = seen.late.max(sent.saturating_duration_since(due));
            }
            match running::ask(client, &cue.scene, arguments.bus.timeout) {
                Ok(reply) => {
                    let latency = u64::try_from(sent.elapsed().as_nanos()).unwrap_or(LONGEST_NS);
                    seen.latency.saturating_record(latency);
                    seen.refused += u64::from(!reply.answers.iter().flatten().any(Result::is_ok));
                }
                Err(CallError::Interrupted) => return seen,
                Err(error) => {
                    seen.failed += 1;
                    let lost = matches!(error, CallError::PlannerLost);
                    seen.failure.get_or_insert(error.to_string());
                    if lost {
                        return seen;
                    }
                }
            }
        }
        if !arguments.repeat {
            return seen;
        }
        round = Instant::now();
    }
}

/// Waits for a line on stdin; its end is the end.
fn step(cue: &Cue) -> ControlFlow<()> {
    let id = cue.scene.id.map_or(String::new(), |id| format!(" (id {id})"));
    warn(format_args!("replay: Enter sends the request of {:?}{id}", cue.at));
    match io::stdin().read_line(&mut String::new()) {
        Ok(1..) if !bus::terminated() => ControlFlow::Continue(()),
        _ => ControlFlow::Break(()),
    }
}

/// Sleeps in short turns: a signal ends it.
fn sleep_until(due: Instant) -> ControlFlow<()> {
    const TURN: Duration = Duration::from_millis(50);
    loop {
        if bus::terminated() {
            return ControlFlow::Break(());
        }
        match due.saturating_duration_since(Instant::now()) {
            Duration::ZERO => return ControlFlow::Continue(()),
            left => thread::sleep(left.min(TURN)),
        }
    }
}

fn print(arguments: &Play, seen: &Seen, took: Duration, out: &mut impl Write) -> io::Result<()> {
    const QUANTILES: [(&str, f64); 4] = [("50", 0.5), ("90", 0.9), ("99", 0.99), ("99.9", 0.999)];
    let Seen { latency, refused, failed, failure: _, late } = seen;
    let replies = latency.len();
    let per_second = replies as f64 / took.as_secs_f64();
    match arguments.format {
        Format::Text => {
            let clients = counted(arguments.clients.get().into(), "client");
            let seconds = took.as_secs_f64();
            writeln!(
                out,
                "{replies} replies to {clients} in {seconds:.3} s ({per_second:.1} a second), \
                 {refused} refused, {failed} without reply"
            )?;
            if replies > 0 {
                let time = |ns: u64| format!("{:?}", Duration::from_nanos(ns));
                let quantiles = QUANTILES
                    .map(|(name, at)| format!("{name} % {}", time(latency.value_at_quantile(at))));
                let (all, most) = (quantiles.join(", "), time(latency.max()));
                writeln!(out, "latency: {all}, longest {most}; sent up to {late:?} late")?;
            }
            Ok(())
        }
        Format::Json => {
            let seconds = |ns: u64| ns as f64 * 1e-9;
            let at = |quantile| (replies > 0).then(|| seconds(latency.value_at_quantile(quantile)));
            let value = json!({
                "clients": arguments.clients,
                "replies": replies,
                "refused": refused,
                "failed": failed,
                "seconds": took.as_secs_f64(),
                "per_second": per_second,
                "late": late.as_secs_f64(),
                "latency": {
                    "p50": at(0.5),
                    "p90": at(0.9),
                    "p99": at(0.99),
                    "p999": at(0.999),
                    "max": (replies > 0).then(|| seconds(latency.max())),
                },
            });
            write_json(&value, out)
        }
    }
}
