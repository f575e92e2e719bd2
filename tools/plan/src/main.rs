//! The `plan` command; see `plan --help`.

mod arguments;
mod csv;
mod grey;
mod list;
mod map_scene;
mod pictures;
mod session;
mod stdin;
mod stream;

use std::process::ExitCode;

use clap::Parser;
use program::Diagnostics;

fn main() -> ExitCode {
    program::main("plan", || {
        let arguments = arguments::Arguments::parse();
        program::start_diagnostics(Diagnostics::Warnings);
        bus::forward_to_tracing();
        match arguments.list {
            true => Ok(list::run(arguments.format)?),
            false => Ok(session::run(&arguments)?),
        }
    })
}
