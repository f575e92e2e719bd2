//! Tells the programs which revision they are built from: `CLEARWAY_REVISION`, or else the commit of
//! the checkout. Without git, or outside of a checkout of this project, there is none.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=CLEARWAY_REVISION");
    let given = std::env::var("CLEARWAY_REVISION").ok().filter(|given| !given.trim().is_empty());
    let mut version = env!("CARGO_PKG_VERSION").to_owned();
    if let Some(revision) = given.or_else(commit) {
        let revision = revision.trim();
        version += &format!(" ({revision})");
        println!("cargo::rustc-env=CLEARWAY_BUILT_REVISION={revision}");
    }
    println!("cargo::rustc-env=CLEARWAY_BUILT_VERSION={version}");
}

/// The commit that is checked out here.
fn commit() -> Option<String> {
    // A copy of this project inside another one's checkout is not of that one's revision.
    let top = git(&["rev-parse", "--show-toplevel"])?;
    if Path::new(&top).canonicalize().ok()? != Path::new("../..").canonicalize().ok()? {
        return None;
    }
    // The log of `HEAD` grows with each commit and each checkout; `HEAD` itself only names a branch.
    for file in ["HEAD", "logs/HEAD"] {
        let path = git(&["rev-parse", "--git-path", file])?;
        // One that is not there would have this run every time.
        if Path::new(&path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    git(&["rev-parse", "--short=12", "HEAD"])
}

fn git(arguments: &[&str]) -> Option<String> {
    let done = Command::new("git").args(arguments).output().ok()?;
    let said = String::from_utf8(done.stdout).ok()?;
    let said = said.trim();
    (done.status.success() && !said.is_empty()).then(|| said.to_owned())
}
