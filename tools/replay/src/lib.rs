//! The `replay` command; see `replay --help`.

mod arguments;
mod bless;
mod changes;
mod check;
mod commands;
mod copying;
mod diff;
mod export;
mod extract;
mod findings;
mod html;
mod info;
mod junit;
mod merge;
mod output;
mod play;
mod reading;
mod report;
mod running;
mod show;
mod tolerances;
mod units;

use std::process::ExitCode;

use arguments::Arguments;
use clap::{ArgMatches, Command, CommandFactory, FromArgMatches};

/// Its command line.
pub fn command() -> Command {
    Arguments::command()
}

/// Runs it.
pub fn run(matches: &ArgMatches) -> ExitCode {
    program::main("replay", || commands::run(Arguments::from_arg_matches(matches)?))
}
