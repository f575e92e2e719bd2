//! Where the programs under test are.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use cargo_metadata::Message;

use crate::root;

/// The packages whose programs are tested; a program has its package's name.
const PACKAGES: [&str; 4] = ["planner", "plan", "recorder", "replay"];

/// The program of this name, built from the sources as they are.
///
/// Cargo builds programs for the tests of their own package, and tells only these where
/// they are: `cargo test` for all packages builds no `planner`, as no test in its package needs
/// one. So the tests ask cargo once for each test program, with the profile and the target
/// directory that they were built with. That takes a fraction of a second when nothing is
/// to do, and the programs are never older than their sources.
pub fn program(name: &str) -> PathBuf {
    static PROGRAMS: OnceLock<BTreeMap<String, PathBuf>> = OnceLock::new();
    let programs = PROGRAMS.get_or_init(build);
    programs.get(name).unwrap_or_else(|| panic!("{name} is not among {PACKAGES:?}")).clone()
}

fn build() -> BTreeMap<String, PathBuf> {
    // This is <target>/<profile>/deps/<name>-<hash>.
    let this = std::env::current_exe().expect("the system knows this program");
    let profile = this.ancestors().nth(2).expect("tests lie in a directory for their profile");
    let target = profile.parent().expect("profiles lie in the target directory");
    let profile = match profile.file_name().and_then(|name| name.to_str()) {
        Some("debug") | None => "dev",
        Some(name) => name,
    };
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo
        .current_dir(root())
        .args(["build", "--bins", "--quiet", "--message-format=json-render-diagnostics"])
        .args(PACKAGES.iter().flat_map(|package| ["--package", package]))
        .args(["--profile", profile, "--target-dir"])
        .arg(target)
        .stderr(Stdio::inherit());
    let output = cargo.output().expect("cargo runs");
    assert!(output.status.success(), "cargo could not build {PACKAGES:?}");
    Message::parse_stream(output.stdout.as_slice())
        .filter_map(|message| match message.expect("cargo writes its messages whole") {
            Message::CompilerArtifact(made) => Some((made.target.name, made.executable?.into())),
            _ => None,
        })
        .collect()
}
