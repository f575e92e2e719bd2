//! A Python with what independent readers need.

use std::path::{Path, PathBuf};
use std::process::Command;

const PACKAGES: [&str; 2] = ["mcap==1.6.0", "mcap-protobuf-support==0.6.0"];

/// A Python with these packages from PyPI, made once; none where it can't be had.
pub(crate) fn python() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python-mcap-1.6.0-protobuf-0.6.0");
    let python = folder.join("bin/python3");
    if runs(&python, &["-c", "import mcap.stream_reader, mcap_protobuf.decoder"]) {
        return Some(python);
    }
    // Tests run side by side: each makes one, and one of them stays.
    let parent = folder.parent()?;
    let made = tempfile::Builder::new().prefix("python-").tempdir_in(parent).ok()?.keep();
    let installs =
        [&["-m", "pip", "install", "--quiet", "--disable-pip-version-check"][..], &PACKAGES]
            .concat();
    let fresh = made.join("bin/python3");
    let ready =
        runs(Path::new("python3"), &["-m", "venv", made.to_str()?]) && runs(&fresh, &installs);
    if ready && std::fs::rename(&made, &folder).is_ok() {
        return Some(python);
    }
    // Removed as far as possible; it is in the folder of temporary files.
    _ = std::fs::remove_dir_all(&made);
    runs(&python, &["-c", "import mcap.stream_reader, mcap_protobuf.decoder"]).then_some(python)
}

/// Whether a program runs and succeeds.
pub(crate) fn runs(program: &Path, arguments: &[&str]) -> bool {
    Command::new(program).args(arguments).output().is_ok_and(|done| done.status.success())
}
