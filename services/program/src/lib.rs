//! What all programs do alike: exit codes, printing results, reporting errors, diagnostics.
//!
//! Results go to stdout, everything else to stderr.
//!
//! ```no_run
//! use program::{Exit, PrintError};
//! use std::io::Write;
//!
//! fn main() -> std::process::ExitCode {
//!     program::main("greet", || {
//!         writeln!(std::io::stdout(), "hello").map_err(PrintError)?;
//!         Ok(Exit::Done)
//!     })
//! }
//! ```

mod diagnostics;
mod exit;
mod log_format;
mod print;
mod time;
mod version;

pub use diagnostics::{Diagnostics, start_diagnostics};
pub use exit::{Exit, main};
pub use log_format::LogFormat;
pub use print::{PrintError, report, warn};
pub use time::time;
pub use version::{REVISION, VERSION};
