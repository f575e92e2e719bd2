//! The wall clock.

use std::time::{SystemTime, UNIX_EPOCH};

/// The time as messages carry it: nanoseconds since the Unix epoch.
pub fn now_ns() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos() as u64)
}
