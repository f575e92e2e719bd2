//! The `replay` command; see `replay --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    replay::cli::main(answer::reply_to)
}
