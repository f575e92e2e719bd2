//! The `plan` command; see `plan --help`.

mod arguments;
mod grey;
mod health;
mod list;
mod map_scene;
mod mesh_scene;
mod pictures;
mod session;
mod stdin;
mod stream;

use std::process::ExitCode;

use arguments::Arguments;
use clap::{ArgMatches, Command, CommandFactory, FromArgMatches};
use program::{Diagnostics, LogFormat};

/// Its command line.
pub fn command() -> Command {
    Arguments::command()
}

/// Runs it.
pub fn run(matches: &ArgMatches) -> ExitCode {
    program::main("plan", || {
        let arguments = Arguments::from_arg_matches(matches)?;
        program::start_diagnostics(Diagnostics::Warnings, LogFormat::Text);
        bus::forward_to_tracing();
        match &arguments {
            Arguments { list: true, format, .. } => Ok(list::run(*format)?),
            Arguments { status: true, .. } => Ok(health::status(&arguments)?),
            Arguments { ping: true, .. } => Ok(health::ping(&arguments)?),
            _ => Ok(session::run(&arguments)?),
        }
    })
}
