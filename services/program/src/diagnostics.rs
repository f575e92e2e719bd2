//! Diagnostics on stderr.

use std::io::{self, IsTerminal};

use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt;
use tracing_subscriber::layer::{Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

use crate::log_format::{self, LogFormat};
use crate::print::warn;

/// How much a program says by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Diagnostics {
    /// Warnings and errors.
    Warnings,
    /// What a service does, too.
    Events,
}

/// From now on `tracing` goes to stderr; text is in colour on a terminal. In JSON, errors that
/// end the program and panics are objects, too.
///
/// `RUST_LOG` overrides `default`: a level (`debug`), or a list such as
/// `info,planner=debug,iceoryx2=off`.
pub fn start_diagnostics(default: Diagnostics, format: LogFormat) {
    let level = match default {
        Diagnostics::Warnings => LevelFilter::WARN,
        Diagnostics::Events => LevelFilter::INFO,
    };
    let (filter, unreadable) = filter(std::env::var("RUST_LOG").ok().as_deref(), level);
    let lines = fmt::layer()
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        // A closed stderr is nobody's business.
        .log_internal_errors(false);
    let lines = match log_format::choose(format) {
        LogFormat::Text => lines.boxed(),
        LogFormat::Json => {
            std::panic::set_hook(Box::new(|panic| tracing::error!(target: "panic", "{panic}")));
            lines.json().flatten_event(true).with_ansi(false).boxed()
        }
    };
    tracing_subscriber::registry().with(lines).with(filter).init();
    if let Some(reason) = unreadable {
        warn(format_args!("RUST_LOG is ignored: {reason}"));
    }
}

/// What `wanted` lets through, and why it can't be read, if it can't.
fn filter(wanted: Option<&str>, default: LevelFilter) -> (Targets, Option<String>) {
    let fallback = Targets::new().with_default(default);
    match wanted.map(str::trim) {
        None | Some("") => (fallback, None),
        Some(text) => match text.parse() {
            Ok(targets) => (targets, None),
            Err(error) => (fallback, Some(format!("{text:?}: {error}"))),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(wanted: Option<&str>, planner: LevelFilter, other: LevelFilter) {
        let (targets, unreadable) = filter(wanted, LevelFilter::INFO);
        let most = |target: &str| {
            use tracing_subscriber::filter::LevelFilter as L;
            let levels = [L::TRACE, L::DEBUG, L::INFO, L::WARN, L::ERROR];
            let passes = |level: &L| targets.would_enable(target, &level.into_level().unwrap());
            levels.into_iter().find(passes).unwrap_or(L::OFF)
        };
        assert_eq!(unreadable, None);
        assert_eq!((most("planner::service"), most("iceoryx2")), (planner, other), "{wanted:?}");
    }

    #[test]
    fn rust_log_overrides_the_default() {
        check(None, LevelFilter::INFO, LevelFilter::INFO);
        check(Some(""), LevelFilter::INFO, LevelFilter::INFO);
        check(Some("debug"), LevelFilter::DEBUG, LevelFilter::DEBUG);
        check(Some("off"), LevelFilter::OFF, LevelFilter::OFF);
        check(Some("warn,planner=trace"), LevelFilter::TRACE, LevelFilter::WARN);
    }

    #[test]
    fn an_unreadable_rust_log_is_reported_and_ignored() {
        let (targets, unreadable) = filter(Some("planner=loud"), LevelFilter::WARN);
        assert!(unreadable.unwrap().starts_with("\"planner=loud\": "));
        assert_eq!(targets, Targets::new().with_default(LevelFilter::WARN));
    }
}
