//! iceoryx2's own diagnostics, forwarded to `tracing`.

use std::fmt::{self, Arguments, Write};
use std::sync::Once;

use iceoryx2::prelude::{LogLevel, set_log_level, set_logger};

/// Longest origin that is passed on; iceoryx2 prints whole port structures there, up to
/// 10 KB for one warning.
const MOST_ORIGIN: usize = 80;

/// Longest message that is passed on; some have the whole configuration in them.
const MOST_MESSAGE: usize = 240;

struct ToTracing;

/// From now on iceoryx2's errors go through `tracing`, target `iceoryx2`, and its warnings as
/// diagnostics for developers (`debug`). Joining a domain calls this.
pub fn forward_to_tracing() {
    static LOGGER: ToTracing = ToTracing;
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        if set_logger(&LOGGER) {
            set_log_level(LogLevel::Warn);
        }
    });
}

impl iceoryx2_log::Log for ToTracing {
    fn log(&self, level: LogLevel, origin: Arguments, message: Arguments) {
        let origin = beginning(origin, MOST_ORIGIN);
        let message = beginning(message, MOST_MESSAGE);
        match level {
            // It warns of what the bus expects: no configuration file, peers that died half
            // connected. What concerns users the bus says itself, with a cause.
            LogLevel::Trace | LogLevel::Debug | LogLevel::Info | LogLevel::Warn => {
                tracing::debug!(target: "iceoryx2", origin, "{message}");
            }
            LogLevel::Error | LogLevel::Fatal => {
                tracing::error!(target: "iceoryx2", origin, "{message}");
            }
        }
    }
}

/// At most the first `most` bytes of a text.
fn beginning(text: Arguments, most: usize) -> String {
    struct Cut(String, usize);
    impl fmt::Write for Cut {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            let room = self.1 - self.0.len();
            self.0.push_str(&text[..text.floor_char_boundary(room)]);
            // The rest is not even written.
            if text.len() > room { Err(fmt::Error) } else { Ok(()) }
        }
    }
    let mut cut = Cut(String::new(), most);
    if cut.write_fmt(text).is_err() {
        cut.0.push_str("...");
    }
    cut.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_cut() {
        assert_eq!(beginning(format_args!("{}", "short"), 10), "short");
        assert_eq!(beginning(format_args!("{}-{}", "12345", "\u{e4}bc"), 7), "12345-...");
        assert_eq!(beginning(format_args!("{}{}", "1234567", "8"), 7), "1234567...");
    }
}
