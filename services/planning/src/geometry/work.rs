//! Counts work in tests, so that growth with the size of a scene is checked without a clock.

use std::cell::Cell;

thread_local! {
    static LOOKS: Cell<usize> = const { Cell::new(0) };
}

/// Counts one look at a box.
pub(crate) fn look() {
    LOOKS.set(LOOKS.get() + 1);
}

/// The number of looks that `run` takes.
pub(crate) fn looks(run: impl FnOnce()) -> usize {
    let before = LOOKS.get();
    run();
    LOOKS.get() - before
}

/// Checks that work grows as n log n. For a given size `work` returns the number n of things
/// in its scene and the looks it took, which must not exceed `factor * n log2 n`.
#[track_caller]
pub(crate) fn check_n_log_n(
    factor: f64,
    sizes: &[usize],
    mut work: impl FnMut(usize) -> (usize, usize),
) {
    for size in sizes {
        let (n, looks) = work(*size);
        let most = factor * n as f64 * libm::log2(n as f64);
        assert!(looks as f64 <= most, "{looks} looks at {n} things, more than {most:.0}");
        // A factor that is too generous would prove nothing.
        assert!(looks as f64 >= most / 3.0, "{looks} looks at {n} things, {most:.0} allowed");
    }
}
