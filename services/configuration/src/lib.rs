//! The planner's settings, read from its configuration file (TOML).
//!
//! For the planner, and for tools that plan under a planner's caps. This crate does not know the
//! bus: [`Config`] only says what the bus is to be opened with.

use std::path::{Path, PathBuf};
use std::thread::available_parallelism;

use answer::{CACHE_BYTES, Caps};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The planner's settings; those that a file leaves out have their defaults.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// `"event"`, `"hybrid"` or `"poll"`: how the planner waits for requests.
    pub wait: WaitFor,
    /// The most clients connected at a time.
    pub max_clients: usize,
    /// The most open requests of one client.
    pub requests_per_client: usize,
    /// The most recorders connected at a time.
    pub max_recorders: usize,
    /// Messages kept for a slow recorder before the oldest are lost.
    pub tap_buffer: usize,
    /// Whether the planner takes its shared memory at the start, all that it can come to use.
    pub reserve: bool,
    /// How long a reply waits for a client that does not take it, seconds.
    pub patience: f64,
    /// How many requests are planned at a time. 0: one for each core but one, at least 1.
    pub workers: usize,
    /// The most requests that wait for a worker; further ones are refused as `overloaded`.
    pub queue: usize,
    /// Their size, bytes; and the size of reply parts that no client has taken yet.
    pub queue_bytes: usize,
    /// How long requests in hand are planned on when the planner is asked to end, seconds.
    pub grace: f64,
    /// The most memory kept from one request to the next, bytes: mostly channels, junctions and
    /// walls for requests over the same free space. 0 keeps nothing.
    pub cache: usize,
    /// What one request may cost; the table `[caps]`.
    pub caps: Caps,
}

/// How the planner waits for requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WaitFor {
    /// Sleep until a request comes.
    Event,
    /// Spin briefly, then sleep.
    Hybrid,
    /// Never sleep: the fastest, at the cost of a core.
    Poll,
}

impl WaitFor {
    /// As in the configuration.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Event => "event",
            Self::Hybrid => "hybrid",
            Self::Poll => "poll",
        }
    }
}

/// Why a configuration file is refused.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// The file can't be read.
    #[error("can't read {}: {cause}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        cause: std::io::Error,
    },
    /// It is not TOML, or has unknown settings or values of the wrong type.
    #[error("{}: {}", path.display(), in_words(cause))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        cause: Box<toml::de::Error>,
    },
    /// What a recording says of the planner's settings can't be read.
    #[error("{}: the planner's settings: {cause}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        cause: serde_json::Error,
    },
    /// A setting is out of range.
    #[error("{}: {field} is {value}; it must be between {least} and {most}", path.display())]
    OutOfRange {
        /// The file.
        path: PathBuf,
        /// The setting.
        field: &'static str,
        /// Its value.
        value: f64,
        /// The least allowed.
        least: f64,
        /// The most allowed.
        most: f64,
    },
}

impl Default for Config {
    fn default() -> Self {
        Self {
            wait: WaitFor::Hybrid,
            max_clients: 64,
            requests_per_client: 2,
            max_recorders: 2,
            tap_buffer: 768,
            reserve: false,
            patience: 1.0,
            workers: 0,
            queue: 256,
            queue_bytes: 256 << 20,
            grace: 2.0,
            cache: CACHE_BYTES,
            caps: Caps::default(),
        }
    }
}

/// Without the names that Rust has for numbers.
fn in_words(cause: &toml::de::Error) -> String {
    let mut text = cause.to_string();
    for whole in ["usize", "u64", "u32"] {
        text =
            text.replace(&format!("expected {whole}"), "expected a whole number, not less than 0");
    }
    text.replace("expected f64", "expected a number")
}

impl Config {
    /// Reads a configuration file.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let text = std::fs::read_to_string(path)
            .map_err(|cause| ConfigError::Unreadable { path: path.to_owned(), cause })?;
        let config: Self = toml::from_str(&text).map_err(|cause| ConfigError::Malformed {
            path: path.to_owned(),
            cause: Box::new(cause),
        })?;
        config.check(path)?;
        Ok(config)
    }

    /// All settings as JSON.
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::to_value(self).expect("names and numbers")
    }

    /// How many requests are planned at a time on this machine.
    pub fn workers(&self) -> usize {
        match self.workers {
            0 => available_parallelism().map_or(1, |cores| cores.get().saturating_sub(1).max(1)),
            workers => workers,
        }
    }

    /// Checks that every setting is in its range; `path` says where they are from.
    pub fn check(&self, path: &Path) -> Result<(), ConfigError> {
        let bounds = [
            ("max_clients", self.max_clients as f64, 1.0, 1024.0),
            ("requests_per_client", self.requests_per_client as f64, 1.0, 64.0),
            ("max_recorders", self.max_recorders as f64, 1.0, 16.0),
            ("tap_buffer", self.tap_buffer as f64, 1.0, 1_048_576.0),
            ("patience", self.patience, 0.0, 60.0),
            ("workers", self.workers as f64, 0.0, 256.0),
            ("queue", self.queue as f64, 1.0, 65_536.0),
            ("queue_bytes", self.queue_bytes as f64, 0.0, (1_u64 << 40) as f64),
            ("grace", self.grace, 0.0, 3600.0),
            ("cache", self.cache as f64, 0.0, (1_u64 << 40) as f64),
        ];
        for (field, value, least, most) in bounds.into_iter().chain(self.caps.ranges()) {
            // NaN lies in no range.
            if !(least..=most).contains(&value) {
                let path = path.to_owned();
                return Err(ConfigError::OutOfRange { path, field, value, least, most });
            }
        }
        Ok(())
    }
}

/// The caps in what [`Config::to_json`] made, perhaps in a later version; `from` says where it is
/// from.
///
/// # Errors
///
/// If it has none, caps that this version does not know, or values out of their range.
pub fn caps_of(json: &str, from: &Path) -> Result<Caps, ConfigError> {
    #[derive(Deserialize)]
    struct Capped {
        caps: Caps,
    }
    let failed = |cause| ConfigError::Json { path: from.to_owned(), cause };
    let Capped { caps } = serde_json::from_str(json).map_err(failed)?;
    Config { caps, ..Config::default() }.check(from)?;
    Ok(caps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_in_range() {
        Config::default().check(Path::new("planner.toml")).unwrap();
    }

    #[test]
    fn caps_are_read_back() {
        let caps = Caps { samples: 77, ..Caps::default() };
        let json = Config { caps, ..Config::default() }.to_json();
        let from = Path::new("run.mcap");
        assert_eq!(caps_of(&json.to_string(), from).unwrap(), caps);
        let mut later = json.clone();
        later["colour"] = 1.into();
        assert_eq!(caps_of(&later.to_string(), from).unwrap(), caps);
        let mut unknown = json.clone();
        unknown["caps"]["colour"] = 1.into();
        assert!(caps_of(&unknown.to_string(), from).unwrap_err().to_string().contains("colour"));
        let mut wrong = json;
        wrong["caps"]["samples"] = 0.into();
        assert!(
            caps_of(&wrong.to_string(), from).unwrap_err().to_string().contains("samples is 0")
        );
    }

    #[test]
    fn setting_out_of_range_is_named_with_its_range() {
        let config = Config { max_clients: 0, ..Config::default() };
        let error = config.check(Path::new("planner.toml")).unwrap_err();
        let message = "planner.toml: max_clients is 0; it must be between 1 and 1024";
        assert_eq!(error.to_string(), message);
        let config = Config { patience: f64::NAN, ..Config::default() };
        assert!(config.check(Path::new("planner.toml")).is_err());
    }
}
