//! Whether a file can be had back from git.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Why a file is not overwritten.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NotCommitted {
    #[error("{} has changes that git does not have; --uncommitted overwrites it", .0.display())]
    Changed(PathBuf),
    #[error("git does not know {}; --uncommitted overwrites it", .0.display())]
    Unknown(PathBuf),
    #[error("can't ask git about {}: {said}; --uncommitted overwrites it", path.display())]
    NoAnswer { path: PathBuf, said: String },
}

/// Whether git has the file as it is.
pub(super) fn check(path: &Path) -> Result<(), NotCommitted> {
    let tracked = git(path, &["ls-files", "--error-unmatch"])?;
    if !tracked.status.success() {
        let said = String::from_utf8_lossy(&tracked.stderr);
        return Err(match said.contains("not a git repository") {
            true => NotCommitted::NoAnswer {
                path: path.to_owned(),
                said: "it is not in a git repository".to_owned(),
            },
            false => NotCommitted::Unknown(path.to_owned()),
        });
    }
    let status = git(path, &["status", "--porcelain"])?;
    if !status.status.success() || !status.stdout.is_empty() {
        return Err(NotCommitted::Changed(path.to_owned()));
    }
    Ok(())
}

fn git(path: &Path, arguments: &[&str]) -> Result<Output, NotCommitted> {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let name = path.file_name().unwrap_or(OsStr::new(""));
    let mut command = Command::new("git");
    // Its messages in English; names are no patterns.
    command.env("LC_ALL", "C").args(["--literal-pathspecs", "-C"]).arg(folder);
    let asked = command.args(arguments).arg("--").arg(name).output();
    asked.map_err(|error| NotCommitted::NoAnswer { path: path.to_owned(), said: error.to_string() })
}
