//! Domains for unit tests.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::domain::Domain;

/// A domain that nobody else uses. The last port that is dropped tidies up.
pub(crate) fn test_domain() -> Domain {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    Domain::new(&format!("unit-{}-{count}", std::process::id())).expect("a possible name")
}

/// A directory for domains that is removed with this.
pub(crate) struct TestRoot(tempfile::TempDir);

impl TestRoot {
    pub(crate) fn new() -> Self {
        let alone = Permissions::from_mode(0o700);
        let directory = tempfile::Builder::new().prefix("cw").permissions(alone).tempdir_in("/tmp");
        Self(directory.expect("/tmp has room"))
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }
}
