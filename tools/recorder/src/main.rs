//! The `recorder` command; see `recorder --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    recorder::command_line::run(&recorder::command_line::command().get_matches())
}
