//! The planner's settings, as its configuration file (TOML) says them.

use std::path::{Path, PathBuf};

use answer::{CACHE_BYTES, Caps};
use serde::Deserialize;
use thiserror::Error;

/// The planner's settings; what a file does not say has its default.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// `"event"`, `"hybrid"` or `"poll"`: how the planner waits for requests.
    pub wait: WaitFor,
    /// Clients at a time.
    pub max_clients: usize,
    /// Requests that one client can have open.
    pub requests_per_client: usize,
    /// Recorders at a time.
    pub max_recorders: usize,
    /// Messages that wait for a slow recorder before the oldest are lost.
    pub tap_buffer: usize,
    /// Seconds for which a reply waits for a client that does not take it.
    pub patience: f64,
    /// Bytes of what was made from free spaces that are kept for the next requests over the same;
    /// 0: nothing is kept.
    pub cache: usize,
    /// What one request may cost: the table `[caps]`.
    pub caps: Caps,
}

/// How the planner waits for requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WaitFor {
    /// Sleeps at once.
    Event,
    /// Spins briefly, then sleeps.
    Hybrid,
    /// Never sleeps; takes a core.
    Poll,
}

/// Why a file does not configure a planner.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// It can't be read.
    #[error("can't read {}: {cause}", path.display())]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// Why.
        cause: std::io::Error,
    },
    /// It is no such configuration.
    #[error("{}: {cause}", path.display())]
    Malformed {
        /// Which file.
        path: PathBuf,
        /// What and where.
        cause: Box<toml::de::Error>,
    },
    /// A number is out of range.
    #[error("{}: {field} is {value}, but must be from {least} to {most}", path.display())]
    OutOfRange {
        /// Which file.
        path: PathBuf,
        /// Which setting.
        field: &'static str,
        /// What it is.
        value: f64,
        /// The least that will do.
        least: f64,
        /// The most that will do.
        most: f64,
    },
}

impl Default for Config {
    fn default() -> Self {
        Self {
            wait: WaitFor::Hybrid,
            max_clients: 32,
            requests_per_client: 4,
            max_recorders: 2,
            tap_buffer: 1024,
            patience: 0.1,
            cache: CACHE_BYTES,
            caps: Caps::default(),
        }
    }
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

    fn check(&self, path: &Path) -> Result<(), ConfigError> {
        let bounds = [
            ("max_clients", self.max_clients as f64, 1.0, 1024.0),
            ("requests_per_client", self.requests_per_client as f64, 1.0, 64.0),
            ("max_recorders", self.max_recorders as f64, 1.0, 16.0),
            ("tap_buffer", self.tap_buffer as f64, 1.0, 1_048_576.0),
            ("patience", self.patience, 0.0, 60.0),
            ("cache", self.cache as f64, 0.0, (1_u64 << 40) as f64),
        ];
        for (field, value, least, most) in bounds.into_iter().chain(self.caps.ranges()) {
            // A NaN lies in no range.
            if !(least..=most).contains(&value) {
                let path = path.to_owned();
                return Err(ConfigError::OutOfRange { path, field, value, least, most });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_in_range() {
        Config::default().check(Path::new("planner.toml")).unwrap();
    }
}
