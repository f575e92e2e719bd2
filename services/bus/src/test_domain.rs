//! Domains for unit tests.

use std::sync::atomic::{AtomicU32, Ordering};

use crate::domain::Domain;

/// A domain that nobody else uses. The last port that is dropped tidies up.
pub(crate) fn test_domain() -> Domain {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    Domain::new(&format!("unit-{}-{count}", std::process::id())).expect("a possible name")
}
