//! The recorder: a loop that writes a planner's traffic to an MCAP file.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use bus::{ConnectError, Domain, TapEvent, TapMessage, TapReader};
use recording::{Options, Summary, WriteError, Writer};

/// What to record, and where.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The file to write.
    pub output: PathBuf,
    /// The planner's domain.
    pub domain: Domain,
    /// Whether to replace an existing file.
    pub overwrite: bool,
    /// How long to record; `None`: until a signal.
    pub duration: Option<Duration>,
    /// How much may be lost if the recorder is killed.
    pub flush: Duration,
    /// How long to wait for a planner to come up.
    pub wait: Duration,
}

/// How long the recorder sleeps when there is nothing to record. The tap's buffer holds far
/// more messages than arrive meanwhile.
const IDLE: Duration = Duration::from_millis(1);

/// Why there is no recording, or an incomplete one.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The planner's tap could not be connected to.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Records until a signal asks to end or the time is up, then finishes the file.
pub fn run(settings: &Settings) -> Result<Summary, Failure> {
    // Alone in the domain, it leaves nothing behind.
    let mut tap = connect(settings).inspect_err(|_| settings.domain.tidy())?;
    let mut writer = Writer::create(
        &settings.output,
        Options { overwrite: settings.overwrite, ..Options::default() },
    )?;
    tracing::info!(output = %settings.output.display(), "recording");
    let begin = Instant::now();
    let mut flushed = Instant::now();
    loop {
        let mut idle = true;
        // Asked before receiving, so that messages sent before the signal are recorded.
        let stop = tap.terminated() || settings.duration.is_some_and(|d| begin.elapsed() >= d);
        while let Some(event) = tap.receive() {
            idle = false;
            record(&mut writer, event)?;
            if flushed.elapsed() >= settings.flush {
                break;
            }
        }
        if flushed.elapsed() >= settings.flush {
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

fn connect(settings: &Settings) -> Result<TapReader, ConnectError> {
    let until = Instant::now() + settings.wait;
    let mut told = false;
    loop {
        match TapReader::connect(&settings.domain) {
            Err(ConnectError::NoPlanner { .. }) if Instant::now() < until && !bus::terminated() => {
                if !told {
                    tracing::info!(domain = %settings.domain, "waiting for a planner");
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
            tracing::warn!(messages, "messages lost: they came too fast");
            writer.lost(messages);
            Ok(())
        }
        TapEvent::Restarted => {
            tracing::warn!("the planner was restarted");
            Ok(())
        }
    };
    match written {
        // The writer counts it as lost; recording goes on.
        Err(error @ WriteError::TooLarge { .. }) => {
            tracing::warn!(%error, "message lost");
            Ok(())
        }
        done => done,
    }
}
