//! The `plan` command; see `plan --help`.

mod arguments;
mod grey;
mod health;
mod list;
mod map_scene;
mod pictures;
mod session;
mod stdin;
mod stream;

use std::process::ExitCode;

use arguments::Arguments;
use clap::Parser;
use program::{Diagnostics, LogFormat};

fn main() -> ExitCode {
    program::main("plan", || {
        let arguments = Arguments::parse();
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
