//! How far the recording is, for people: a line on a terminal, now and then a log line elsewhere.

use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::size;

/// How often a terminal is told.
const TERMINAL: Duration = Duration::from_millis(500);

/// How often a log is.
const LOG: Duration = Duration::from_secs(10);

/// What the writing thread tells while it works.
#[derive(Debug, Default)]
pub(crate) struct Written {
    pub(crate) messages: AtomicU64,
    pub(crate) lost: AtomicU64,
    pub(crate) bytes: AtomicU64,
    /// Free on the disk.
    pub(crate) free: AtomicU64,
    /// Whether that is less than is to stay free.
    pub(crate) is_full: AtomicBool,
}

pub(crate) struct Progress {
    output: String,
    is_terminal: bool,
    shown: Instant,
    /// Messages then.
    messages: u64,
    /// Whether a line stands on the terminal.
    is_shown: bool,
}

impl Progress {
    pub(crate) fn new(output: &Path) -> Self {
        Self {
            output: output.display().to_string(),
            is_terminal: io::stderr().is_terminal(),
            shown: Instant::now(),
            messages: 0,
            is_shown: false,
        }
    }

    pub(crate) fn show(&mut self, written: &Written) {
        let since = self.shown.elapsed();
        if since < if self.is_terminal { TERMINAL } else { LOG } {
            return;
        }
        let messages = written.messages.load(Ordering::Relaxed);
        let lost = written.lost.load(Ordering::Relaxed);
        let bytes = size::text(written.bytes.load(Ordering::Relaxed));
        let free = size::text(written.free.load(Ordering::Relaxed));
        let rate = (messages.saturating_sub(self.messages)) as f64 / since.as_secs_f64();
        (self.shown, self.messages) = (Instant::now(), messages);
        if self.is_terminal {
            let output = &self.output;
            let line = format!(
                "{output}: {messages} messages, {bytes}, {rate:.0}/s, {lost} lost, {free} free"
            );
            let _ = write!(io::stderr(), "\r\x1b[2K{line}");
            self.is_shown = true;
        } else {
            tracing::info!(messages, bytes, rate = rate.round(), lost, free, "recorded");
        }
    }

    /// Makes place for other lines.
    pub(crate) fn clear(&mut self) {
        if std::mem::take(&mut self.is_shown) {
            let _ = write!(io::stderr(), "\r\x1b[2K");
        }
    }
}
