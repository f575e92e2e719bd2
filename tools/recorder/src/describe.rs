//! What a recording says of itself at its beginning.

use std::collections::BTreeMap;

use recording::TOPICS_KEY;
use schemas::status::Status;
use schemas::wire;

use crate::settings::{Settings, Topics};

/// Names and values: who records what, how, and under which settings it was planned. `status` is
/// what the planner says of itself.
pub(crate) fn describe(settings: &Settings, status: Option<&str>) -> BTreeMap<String, String> {
    let mut description = BTreeMap::new();
    let mut add = |name: &str, value: String| description.insert(name.to_owned(), value);
    add("version", env!("CARGO_PKG_VERSION").to_owned());
    if let Some(revision) = program::REVISION {
        add("revision", revision.to_owned());
    }
    add("layout", format!("{} {:016x}", wire::VERSION, wire::layout_hash()));
    add("host", rustix::system::uname().nodename().to_string_lossy().into_owned());
    add("domain", settings.domain.to_string());
    add("command", settings.command.clone());
    if settings.topics != Topics::default() {
        add(TOPICS_KEY, settings.topics.to_string());
    }
    if let Some(status) = status.and_then(|text| Status::from_json(text).ok()) {
        add("planner", format!("{}, process {}", status.version, status.pid));
        if !status.config.is_null() {
            add("config", status.config.to_string());
        }
    }
    description
}
