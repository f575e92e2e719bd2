//! Logs all of a planner's traffic to MCAP: the loop between the planner's tap and
//! the file.

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
    /// Whether an existing file is replaced.
    pub overwrite: bool,
    /// When to stop by itself.
    pub duration: Option<Duration>,
    /// How much may be lost if the recorder is killed.
    pub flush: Duration,
    /// How long to wait for a planner to come up.
    pub wait: Duration,
}

/// How long the recorder sleeps when nothing is there: the tap's buffer holds far more
/// than comes meanwhile.
const IDLE: Duration = Duration::from_millis(1);

/// Why there is no (complete) recording.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// No planner to listen to.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// The file takes no more.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Records until a signal comes or the time is up, then finishes the file.
pub fn run(settings: &Settings) -> Result<Summary, Failure> {
    // Whoever came alone leaves nothing behind.
    let mut tap = connect(settings).inspect_err(|_| settings.domain.tidy())?;
    let mut writer = Writer::create(&settings.output, Options { overwrite: settings.overwrite })?;
    tracing::info!(output = %settings.output.display(), "recording");
    let begin = Instant::now();
    let mut flushed = Instant::now();
    loop {
        let mut idle = true;
        // Asked before looking, so that what came before the signal is taken.
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
