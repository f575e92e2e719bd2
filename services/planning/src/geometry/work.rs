//! How much is done, counted in tests: what grows with a scene is looked at, not timed.

use std::cell::Cell;

thread_local! {
    static LOOKS: Cell<usize> = const { Cell::new(0) };
}

/// Counts one look at a box.
pub(crate) fn look() {
    LOOKS.set(LOOKS.get() + 1);
}

/// The looks that `run` takes.
pub(crate) fn looks(run: impl FnOnce()) -> usize {
    let before = LOOKS.get();
    run();
    LOOKS.get() - before
}

/// `work` is given a size and does that much; it returns how many things n its scene
/// has and the looks taken. These are at most `factor * n log2 n`, for every size.
#[track_caller]
pub(crate) fn check_n_log_n(
    factor: f64,
    sizes: &[usize],
    mut work: impl FnMut(usize) -> (usize, usize),
) {
    for size in sizes {
        let (n, looks) = work(*size);
        let most = factor * n as f64 * (n as f64).log2();
        assert!(looks as f64 <= most, "{looks} looks at {n} things, more than {most:.0}");
        // Neither is the factor so generous that it says nothing.
        assert!(looks as f64 >= most / 3.0, "{looks} looks at {n} things, {most:.0} allowed");
    }
}
