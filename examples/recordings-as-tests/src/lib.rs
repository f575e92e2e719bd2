//! How a project runs its recordings as tests: `tests/recordings.rs` has a line for each.

use std::path::{Path, PathBuf};

use answer::{Answerer, Caps};
use comparison::check::{Checked, check};
use comparison::exchanges;
use comparison::tolerance::Tolerance;
use schemas::message::{Reply, Request};

/// Where this project keeps its recordings.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../recordings")
}

/// Plans all requests of a recording again under the caps of the planner that was recorded.
pub fn planned_again(name: &str, tolerance: &Tolerance) -> Checked {
    let mut answerer = Answerer::new(&caps(name));
    checked(name, tolerance, |request| answerer.reply_to(request))
}

/// The same by another planner.
pub fn checked(name: &str, tolerance: &Tolerance, plan: impl FnMut(&Request) -> Reply) -> Checked {
    check(&[folder().join(name)], tolerance, plan, |_| {})
}

/// What a request may cost, as the recording says.
pub fn caps(name: &str) -> Caps {
    let path = folder().join(name);
    let description = exchanges::description(&path);
    let config = description.get("config");
    let caps = config.map(|json| configuration::caps_of(json, &path));
    caps.map_or_else(Caps::default, |caps| caps.unwrap_or_else(|error| panic!("{error}")))
}

/// Fails, and says what has moved and how far, unless the whole recording was compared and each
/// reply is as recorded.
#[track_caller]
pub fn assert_unchanged(checked: &Checked) {
    let contents = &checked.contents;
    assert!(contents.error.is_none() && !contents.is_incomplete(), "{checked}");
    assert!(!checked.cases.is_empty(), "{checked}: nothing to compare");
    assert_eq!(checked.counts().different, 0, "\n{checked}\n`replay bless` accepts it");
}
