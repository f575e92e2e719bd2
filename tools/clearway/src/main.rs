//! The `clearway` command; see `clearway --help`.

mod pages;

use std::error::Error;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgMatches, Command, value_parser};
use clap_complete::Shell;
use program::{Exit, PrintError};

/// A program that is one of its commands, and also stands alone.
struct Program {
    name: &'static str,
    command: fn() -> Command,
    run: fn(&ArgMatches) -> ExitCode,
}

const PROGRAMS: [Program; 5] = [
    Program { name: "plan", command: plan::command, run: plan::run },
    Program {
        name: "planner",
        command: planner::command_line::command,
        run: planner::command_line::run,
    },
    Program {
        name: "recorder",
        command: recorder::command_line::command,
        run: recorder::command_line::run,
    },
    Program { name: "replay", command: replay::command, run: replay::run },
    Program { name: "demo", command: demo::command, run: demo::run },
];

fn command() -> Command {
    Command::new("clearway")
        .version(program::VERSION)
        .about("Plans motions over shared memory, records them, and plans them again")
        .after_help(
            "\
Examples:
  clearway planner
  clearway plan recordings/scenes/drive-a.json
  clearway completions bash > ~/.local/share/bash-completion/completions/clearway
  clearway man ~/.local/share/man/man1

Each program is a command of its own as well (planner, plan, recorder, replay, demo), with the same
arguments.",
        )
        .subcommand_required(true)
        .arg_required_else_help(true)
        .subcommands(PROGRAMS.map(|program| (program.command)()))
        .subcommand(
            Command::new("completions")
                .about("Print completions for a shell")
                .arg(
                    Arg::new("shell")
                        .required(true)
                        .value_name("SHELL")
                        .value_parser(value_parser!(Shell))
                        .help("The shell"),
                )
                .arg(
                    Arg::new("program")
                        .value_name("PROGRAM")
                        .value_parser(PossibleValuesParser::new(
                            ["clearway"].into_iter().chain(PROGRAMS.map(|program| program.name)),
                        ))
                        .default_value("clearway")
                        .help("The program whose arguments are completed"),
                ),
        )
        .subcommand(
            Command::new("man").about("Write the man pages of all programs").arg(
                Arg::new("folder")
                    .required(true)
                    .value_name("FOLDER")
                    .value_parser(value_parser!(PathBuf))
                    .help("Where to; it is made if it is missing, and pages in it are replaced"),
            ),
        )
}

/// The programs that have completions and man pages of their own.
fn separate() -> impl Iterator<Item = Command> {
    [command()].into_iter().chain(PROGRAMS.iter().map(|program| (program.command)()))
}

fn main() -> ExitCode {
    if let Some(exit) = demo::play_role() {
        return exit;
    }
    match command().get_matches().subcommand() {
        Some(("completions", given)) => program::main("clearway", || print_completions(given)),
        Some(("man", given)) => program::main("clearway", || {
            let folder: &PathBuf = given.get_one("folder").expect("it is required");
            pages::write(separate(), folder)?;
            Ok(Exit::Done)
        }),
        given => {
            let exit = given.and_then(|(name, given)| {
                let program = PROGRAMS.iter().find(|program| program.name == name)?;
                Some((program.run)(given))
            });
            // clap has refused what is none of them.
            exit.unwrap_or_else(|| Exit::Usage.into())
        }
    }
}

fn print_completions(given: &ArgMatches) -> Result<Exit, Box<dyn Error>> {
    let shell: &Shell = given.get_one("shell").expect("it is required");
    let name: &String = given.get_one("program").expect("it has a default");
    let mut program = separate().find(|program| program.get_name() == name).expect("one of them");
    let mut script = Vec::new();
    clap_complete::generate(*shell, &mut program, name, &mut script);
    io::stdout().write_all(&script).map_err(PrintError)?;
    Ok(Exit::Done)
}
