//! Where the programs under test are.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use cargo_metadata::Message;

use crate::root;

/// The program of this name, built from the sources as they are.
///
/// Cargo builds programs for the tests of their own package, and tells only these where
/// they are: `cargo test --workspace` builds no `planner`, as no test in its package needs
/// one. So each test program asks cargo once, with the profile and the target directory that
/// it was built with itself. The selection is such that features are those of `cargo test
/// --workspace`: only the programs are new then, and no dependency is built twice. Where
/// nothing is to do, it takes a fraction of a second.
pub fn program(name: &str) -> PathBuf {
    static PROGRAMS: OnceLock<BTreeMap<String, PathBuf>> = OnceLock::new();
    let programs = PROGRAMS.get_or_init(build);
    programs.get(name).unwrap_or_else(|| panic!("{name} is not among {programs:?}")).clone()
}

fn build() -> BTreeMap<String, PathBuf> {
    // A test is <target>/<profile>/deps/<name>-<hash>, a program <target>/<profile>/<name>.
    let this = std::env::current_exe().expect("the system knows this program");
    let mut folders = this.ancestors().skip(1).skip_while(|folder| folder.ends_with("deps"));
    let profile = folders.next().expect("programs are in a folder for their profile");
    let target = profile.parent().expect("profiles lie in the target directory");
    let profile = match profile.file_name().and_then(|name| name.to_str()) {
        Some("debug") | None => "dev",
        Some(name) => name,
    };
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo
        .current_dir(root())
        .args(["build", "--workspace", "--bins", "--test", "system"])
        .args(["--quiet", "--message-format=json-render-diagnostics"])
        .args(["--profile", profile, "--target-dir"])
        .arg(target)
        .stderr(Stdio::inherit());
    let output = cargo.output().expect("cargo runs");
    assert!(output.status.success(), "cargo could not build the programs");
    Message::parse_stream(output.stdout.as_slice())
        .filter_map(|message| match message.expect("cargo writes its messages whole") {
            Message::CompilerArtifact(made) if made.target.is_bin() => {
                Some((made.target.name, made.executable?.into()))
            }
            _ => None,
        })
        .collect()
}
