//! What the programs are built from.

/// The revision of the sources, if it was known when they were built: `CLEARWAY_REVISION` of the
/// environment then, or the commit of the checkout.
pub const REVISION: Option<&str> = option_env!("CLEARWAY_BUILT_REVISION");

/// Version and revision, for `--version`.
pub const VERSION: &str = env!("CLEARWAY_BUILT_VERSION");
