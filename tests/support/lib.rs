//! What the tests have in common: the programs, processes that end with their test, and
//! domains that must be empty in the end.

mod domain;
pub mod load;
mod process;
mod programs;
pub mod raw;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

pub use domain::TestDomain;
pub use process::{Ended, Process, kill_group, kill_pid, kill_process};
pub use programs::program;
pub use rustix::process::Signal;

use schemas::json;
use schemas::message::SceneRequest;
use schemas::status::Status;

/// A limit that only a hang reaches.
pub const LONG: Duration = Duration::from_secs(60);

/// The workspace.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the package lies in the workspace")
}

/// The scene whose free space is the map `office.yaml`.
pub const OFFICE: &str = "drive-office.json";

/// The scene files, in order of their names, but those that need a map beside them.
pub fn scene_files() -> Vec<PathBuf> {
    let directory = root().join("recordings/scenes");
    let entries = std::fs::read_dir(&directory).expect("the scenes are there");
    let mut files: Vec<_> = entries
        .map(|entry| entry.expect("the directory can be read").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .filter(|path| !path.ends_with(OFFICE))
        .collect();
    files.sort();
    assert!(!files.is_empty(), "no scenes in {}", directory.display());
    files
}

/// A scene file's text.
pub fn scene_text(name: &str) -> String {
    let path = root().join("recordings/scenes").join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A scene file's scene.
pub fn scene(name: &str) -> SceneRequest {
    json::read_scene(&scene_text(name)).unwrap_or_else(|bad| panic!("{name}: {bad:?}"))
}

/// The process that serves in a domain, which is not the one that supervises it.
#[track_caller]
pub fn serving(test: &TestDomain) -> u32 {
    let status = bus::StatusReader::connect(&test.domain()).expect("a planner is there");
    let text = status.wait(LONG).expect("the planner says how it is");
    Status::from_json(&text).expect("a status").pid
}

/// Waits until `done` gives something.
#[track_caller]
pub fn wait_for<T>(what: &str, mut done: impl FnMut() -> Option<T>) -> T {
    let until = Instant::now() + LONG;
    loop {
        if let Some(found) = done() {
            return found;
        }
        assert!(Instant::now() < until, "waited {LONG:?} for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}
