//! What belongs to the process that made it.
//!
//! A fork copies ports and loans, but what they hold in shared memory is there once: if both
//! processes gave it back, the planner would write where one of them still reads.

use std::mem::ManuallyDrop;
use std::ops::Deref;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// How often this process and those before it were forked on the way to it.
static GENERATION: AtomicU64 = AtomicU64::new(0);

/// Counts from the first use.
static COUNTING: LazyLock<()> = LazyLock::new(|| {
    extern "C" fn count() {
        GENERATION.fetch_add(1, Ordering::Relaxed);
    }
    #[expect(unsafe_code, reason = "the system's own way to learn of a fork")]
    // SAFETY: what is called in the child touches one atomic number.
    unsafe {
        // Without memory for it, forks go unseen, as in every program that does not ask.
        libc::pthread_atfork(None, None, Some(count));
    }
});

/// Remembers the process in which it was made.
#[derive(Debug, Clone, Copy)]
pub struct Origin {
    generation: u64,
}

impl Origin {
    /// This process.
    #[expect(clippy::new_without_default, reason = "it depends on the moment")]
    pub fn new() -> Self {
        LazyLock::force(&COUNTING);
        Self { generation: GENERATION.load(Ordering::Relaxed) }
    }

    /// Whether this process was forked from the one in which this was made. Costs one load.
    pub fn is_forked(&self) -> bool {
        self.generation != GENERATION.load(Ordering::Relaxed)
    }
}

/// A value that only the process that made it drops. In a process forked from it, it is lost.
#[derive(Debug)]
pub(crate) struct OwnedHere<T> {
    value: ManuallyDrop<T>,
    origin: Origin,
}

impl<T> OwnedHere<T> {
    pub(crate) fn new(value: T) -> Self {
        Self { value: ManuallyDrop::new(value), origin: Origin::new() }
    }

    /// Whether this is a copy, in a process forked from the one that made it.
    pub(crate) fn is_copy(&self) -> bool {
        self.origin.is_forked()
    }
}

impl<T> Deref for OwnedHere<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T> Drop for OwnedHere<T> {
    fn drop(&mut self) {
        if self.is_copy() {
            return;
        }
        #[expect(unsafe_code, reason = "dropped here or never")]
        // SAFETY: it is not used after this.
        unsafe {
            ManuallyDrop::drop(&mut self.value);
        }
    }
}
