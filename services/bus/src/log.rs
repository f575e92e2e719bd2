//! iceoryx2's own diagnostics, forwarded to `tracing`.

use std::fmt::Arguments;

use iceoryx2::prelude::{LogLevel, set_log_level, set_logger};

/// Longest origin that is passed on; iceoryx2 prints whole port structures there, up to
/// 10 KB for one warning.
const MOST_ORIGIN: usize = 80;

struct ToTracing;

/// From now on iceoryx2 logs warnings and errors through `tracing`, target `iceoryx2`.
pub fn forward_to_tracing() {
    static LOGGER: ToTracing = ToTracing;
    set_logger(&LOGGER);
    set_log_level(LogLevel::Warn);
}

impl iceoryx2_log::Log for ToTracing {
    fn log(&self, level: LogLevel, origin: Arguments, message: Arguments) {
        let mut origin = origin.to_string();
        origin.truncate(origin.floor_char_boundary(MOST_ORIGIN));
        match level {
            LogLevel::Trace | LogLevel::Debug => {
                tracing::debug!(target: "iceoryx2", origin, "{message}");
            }
            LogLevel::Info => tracing::info!(target: "iceoryx2", origin, "{message}"),
            LogLevel::Warn => tracing::warn!(target: "iceoryx2", origin, "{message}"),
            LogLevel::Error | LogLevel::Fatal => {
                tracing::error!(target: "iceoryx2", origin, "{message}");
            }
        }
    }
}
