//! The `replay` command; see `replay --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    replay::run(&replay::command().get_matches())
}
