//! A Python and a Node.js with what independent readers need.

use std::path::{Path, PathBuf};
use std::process::Command;

const PYTHON: [&str; 2] = ["mcap==1.6.0", "mcap-protobuf-support==0.6.0"];

/// And from npm.
const NODE: [&str; 4] =
    ["@mcap/core@2.2.2", "@mcap/support@1.1.0", "@foxglove/schemas@2.1.0", "protobufjs@8.8.1"];

/// A Python with these packages from PyPI, made once; none where it can't be had.
pub(crate) fn python() -> Option<PathBuf> {
    let made = made_once("python-mcap-1.6.0-protobuf-0.6.0", |folder| {
        let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
        runs(Path::new("python3"), &["-m", "venv", folder.to_str().unwrap_or_default()])
            && runs(&folder.join("bin/python3"), &[&pip[..], &PYTHON].concat())
    });
    made.map(|folder| folder.join("bin/python3"))
}

/// A folder with these packages for Node.js, made once; none where they can't be had.
pub(crate) fn node() -> Option<PathBuf> {
    if !runs(Path::new("node"), &["--version"]) {
        return None;
    }
    made_once("node-mcap-2.2.2", |folder| {
        // Without one of its own, npm takes the folder of another package above.
        let install = ["install", "--ignore-scripts", "--silent", "--no-audit", "--no-fund"];
        let prefix = ["--prefix", folder.to_str().unwrap_or_default()];
        std::fs::write(folder.join("package.json"), r#"{"private": true}"#).is_ok()
            && runs(Path::new("npm"), &[&install[..], &prefix, &NODE].concat())
    })
}

/// A folder of this name, made if it is not there. Tests run side by side: each makes one, and
/// one of them stays.
fn made_once(name: &str, make: impl FnOnce(&Path) -> bool) -> Option<PathBuf> {
    let parent = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let folder = parent.join(name);
    if folder.exists() {
        return Some(folder);
    }
    let made = tempfile::Builder::new().prefix("making-").tempdir_in(parent).ok()?;
    let is_whole = make(made.path());
    if is_whole && std::fs::rename(made.path(), &folder).is_ok() {
        let _moved = made.keep();
    }
    folder.exists().then_some(folder)
}

/// Whether a program runs and succeeds.
fn runs(program: &Path, arguments: &[&str]) -> bool {
    Command::new(program).args(arguments).output().is_ok_and(|done| done.status.success())
}
