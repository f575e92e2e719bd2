//! The `demo` command; see `demo --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    demo::play_role().unwrap_or_else(|| demo::run(&demo::command().get_matches()))
}
