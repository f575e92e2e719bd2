//! `plan --status` and `plan --ping`: how a planner is.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use bus::{CallError, ConnectError, Domain, StatusReader};
use program::{Exit, PrintError};
use schemas::json::read_scene;
use schemas::message::SceneRequest;
use schemas::status::Status;

use crate::arguments::{Arguments, Format};
use crate::session::{Failure, connect};

/// Pings of one run.
const PINGS: usize = 10;

#[derive(Debug, thiserror::Error)]
pub(crate) enum HealthFailure {
    #[error(transparent)]
    Connect(#[from] ConnectError),
    #[error(transparent)]
    NotConnected(#[from] Box<Failure>),
    #[error(transparent)]
    Call(#[from] CallError),
    // Not transparent: `program::main` looks for it among the sources.
    #[error("{0}")]
    Print(#[from] PrintError),
    #[error("the planner of domain {domain} said nothing for {limit:?}: it is frozen, or ending")]
    Silent { domain: Domain, limit: Duration },
    #[error("the planner's status can't be read: {0}")]
    Unreadable(serde_json::Error),
    #[error("{0} has no CSV form; use --format text or json")]
    Csv(&'static str),
}

/// Prints what the planner says of itself.
pub(crate) fn status(arguments: &Arguments) -> Result<Exit, HealthFailure> {
    let domain = arguments.domain.clone().unwrap_or_default();
    let reader = StatusReader::connect(&domain)?;
    let limit = arguments.timeout;
    let Some(text) = reader.wait(limit) else {
        return Err(HealthFailure::Silent { domain, limit });
    };
    let status = Status::from_json(&text).map_err(HealthFailure::Unreadable)?;
    let text = match arguments.format {
        Format::Csv => return Err(HealthFailure::Csv("--status")),
        Format::Json => text,
        Format::Text => table(&domain, &status),
    };
    writeln!(io::stdout(), "{text}").map_err(PrintError)?;
    Ok(Exit::Done)
}

fn table(domain: &Domain, status: &Status) -> String {
    let Status {
        version,
        pid,
        uptime,
        requests,
        answered,
        undelivered,
        refused,
        queue,
        workers,
        unsent,
        cache,
        latency,
        config: _,
    } = status;
    let mut lines = vec![
        format!("planner {version} in domain {domain}, process {pid}, up {}", seconds(*uptime)),
        format!("requests     {requests} taken, {answered} answered, {undelivered} not delivered"),
    ];
    let refused: Vec<_> = refused.iter().map(|(code, count)| format!("{count} {code}")).collect();
    if !refused.is_empty() {
        lines.push(format!("refused      {}", refused.join(", ")));
    }
    lines.push(format!(
        "queue        {} of at most {} requests, {} bytes",
        queue.requests, queue.most, queue.bytes
    ));
    lines.push(format!(
        "workers      {}, {} requests begun, {unsent} bytes not taken yet",
        workers.count, workers.planning
    ));
    lines.push(format!(
        "cache        {} entries, {} bytes, {} hits, {} misses",
        cache.entries, cache.bytes, cache.hits, cache.misses
    ));
    if latency.count > 0 {
        let micros = |micros: f64| format!("{:?}", Duration::from_nanos((micros * 1e3) as u64));
        lines.push(format!(
            "latency      half {}, 90 % {}, 99 % {}, 99.9 % {}, longest {}",
            micros(latency.p50),
            micros(latency.p90),
            micros(latency.p99),
            micros(latency.p999),
            micros(latency.max)
        ));
    }
    lines.join("\n")
}

fn seconds(time: f64) -> String {
    humantime::format_duration(Duration::from_secs(time as u64)).to_string()
}

/// Asks for a small trajectory a few times, and prints how long that takes.
pub(crate) fn ping(arguments: &Arguments) -> Result<Exit, HealthFailure> {
    let domain = arguments.domain.clone().unwrap_or_default();
    let client = connect(&domain, arguments.wait).map_err(Box::new)?;
    let scene = small();
    let mut times = Vec::with_capacity(PINGS);
    for _ in 0..PINGS {
        let begun = Instant::now();
        client.call(&scene, arguments.timeout)?;
        times.push(begun.elapsed());
    }
    times.sort_unstable();
    let [least, median, most] = [times[0], times[PINGS / 2], times[PINGS - 1]];
    let micros = |time: Duration| time.as_nanos() as f64 / 1e3;
    let mut out = io::stdout();
    let printed = match arguments.format {
        Format::Csv => return Err(HealthFailure::Csv("--ping")),
        Format::Json => writeln!(
            out,
            "{{\"pings\":{PINGS},\"least\":{},\"median\":{},\"most\":{}}}",
            micros(least),
            micros(median),
            micros(most)
        ),
        Format::Text => writeln!(
            out,
            "the planner of domain {domain} answers: {PINGS} requests, median {median:?}, least \
             {least:?}, most {most:?}"
        ),
    };
    printed.map_err(PrintError)?;
    Ok(Exit::Done)
}

/// A robot that drives three metres.
fn small() -> SceneRequest {
    read_scene(
        r#"{"task": "drive", "free_space": {"channels": [{"min": [0, 0], "max": [5, 2]}],
            "in_order": true}, "body": {"footprint": {"width": 1, "length": 1}},
            "start": {"position": [1, 1], "heading": 0}, "goal": {"position": [4, 1]},
            "clearance": {"gap": 0.1}, "sampling": {"count": 2}}"#,
    )
    .expect("it is a scene")
}

#[cfg(test)]
mod tests {
    use super::*;
    use schemas::message::{Request, RequestContent, RequestKey};

    #[test]
    fn a_ping_is_answered() {
        let content = RequestContent::Scene(small());
        let request = Request { key: RequestKey::default(), sent_ns: 0, content };
        let reply = answer::reply_to(&request, &answer::Caps::default());
        assert_eq!(reply.answers.unwrap()[0].as_ref().unwrap().length, 3.0);
    }
}
