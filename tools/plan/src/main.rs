//! The `plan` command; see `plan --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    plan::run(&plan::command().get_matches())
}
