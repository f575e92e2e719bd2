//! The `replay` command; see `replay --help`.

mod arguments;
mod commands;
mod diff;
mod findings;
mod info;
mod junit;
mod report;

use std::process::ExitCode;

fn main() -> ExitCode {
    program::main("replay", commands::run)
}
