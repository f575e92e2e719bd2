//! The `planner` command; see `planner --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    planner::command_line::run(&planner::command_line::command().get_matches())
}
