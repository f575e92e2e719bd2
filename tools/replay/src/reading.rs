//! Reading recordings with progress, and telling what is wrong with them.

use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::path::Path;

use comparison::exchanges::{Asked, Contents, read_asked};
use indicatif::{ProgressBar, ProgressStyle};
use program::warn;

use crate::findings::Findings;
use crate::report;

/// Bytes that take long enough to read for a progress bar.
pub(crate) const WORTH_A_BAR: u64 = 32 << 20;

/// Reads a recording until `each` has seen enough. What is wrong with it is told on stderr and
/// added to `findings`.
pub(crate) fn whole(
    path: &Path,
    findings: &mut Findings,
    each: impl FnMut(Asked) -> ControlFlow<()>,
) -> Contents {
    let bar = progress(path);
    let contents = read_asked(std::slice::from_ref(&path), |at| bar.set_position(at), each);
    bar.finish_and_clear();
    complain(path, &contents);
    findings.add(&contents);
    contents
}

/// Tells on stderr what is wrong with a recording.
pub(crate) fn complain(path: &Path, contents: &Contents) {
    report::troubles(contents).for_each(|trouble| {
        warn(format_args!("{}: {trouble}", path.display()));
    });
}

/// A bar on stderr for files that take a while, if that is a terminal.
pub(crate) fn progress(path: &Path) -> ProgressBar {
    let length = std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    if length < WORTH_A_BAR || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {bytes}/{total_bytes} {eta}");
    ProgressBar::new(length).with_style(style.expect("a valid template"))
}
