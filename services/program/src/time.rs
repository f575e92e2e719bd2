//! Times on the command line.

use std::time::Duration;

use humantime::{DurationError, parse_duration};

/// Reads a time, such as `500ms`, `10s` or `1h 30min`.
///
/// # Errors
///
/// What is wrong with it, in words.
///
/// ```
/// assert_eq!(program::time("1m 30s").unwrap().as_secs(), 90);
/// assert_eq!(program::time("soon").unwrap_err(), "not a time, such as 500ms, 10s or 1h 30min");
/// ```
pub fn time(text: &str) -> Result<Duration, String> {
    parse_duration(text).map_err(|error| match error {
        DurationError::NumberExpected(_) | DurationError::Empty => {
            "not a time, such as 500ms, 10s or 1h 30min".to_owned()
        }
        error => error.to_string(),
    })
}
