//! The `bless` command; see `bless --help`.

mod corpora;
mod figures;
mod files;
mod header;
mod pictures;
mod planned;
mod recordings;
mod tables;
mod wire;

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use program::Exit;

use files::FILES;

/// Regenerates the repository's generated files: pictures, figures, tables, schemas and golden
/// recordings.
///
/// A golden recording carries times and random keys, so it is replaced only if its requests
/// or replies have changed.
#[derive(Parser)]
#[command(
    name = "bless",
    version,
    after_help = "\
Examples:
  cargo bless
  cargo bless --check
  cargo bless recordings/routes.mcap

Exit codes: 0 done, 1 failure, 2 usage, 4 files are out of date."
)]
struct Arguments {
    /// Only these files, by their paths in the repository [default: all]
    #[arg(value_name = "PATH")]
    only: Vec<PathBuf>,
    /// Write nothing; print each file that is out of date
    #[arg(long)]
    check: bool,
    /// Replace golden recordings even if their requests and replies are unchanged
    #[arg(long, conflicts_with = "check")]
    force: bool,
}

#[derive(Debug, thiserror::Error)]
enum Error {
    #[error("can't read {}: {cause}", path.display())]
    Read { path: PathBuf, cause: io::Error },
    #[error("can't write {}: {cause}", path.display())]
    Write { path: PathBuf, cause: io::Error },
    #[error("{}: {reason}", path.display())]
    Content { path: PathBuf, reason: String },
    #[error("{} is not a generated file; these are:\n  {}", path.display(), known.join("\n  "))]
    Unknown { path: PathBuf, known: Vec<String> },
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(exit) => exit.into(),
        Err(error @ Error::Unknown { .. }) => {
            eprintln!("bless: {error}");
            Exit::Usage.into()
        }
        Err(error) => {
            eprintln!("bless: {error}");
            Exit::Failure.into()
        }
    }
}

fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let seeds = corpora::seeds();
    let goldens = recordings::all();
    let known: Vec<&str> = (FILES.iter().map(|file| file.path))
        .chain(goldens.iter().map(|recording| recording.path.as_str()))
        .chain(seeds.iter().map(|(path, _)| path.as_str()))
        .collect();
    for path in &arguments.only {
        if !known.iter().any(|known| path == Path::new(known)) {
            let known = known.iter().map(|path| (*path).to_owned()).collect();
            return Err(Error::Unknown { path: path.clone(), known });
        }
    }
    let wanted = |path: &str| {
        arguments.only.is_empty() || arguments.only.iter().any(|only| only == Path::new(path))
    };
    let mut stale = 0;
    for file in FILES.iter().filter(|file| wanted(file.path)) {
        let Some(text) = file.renewed()? else { continue };
        stale += 1;
        if arguments.check {
            println!("{} is out of date", file.path);
        } else {
            files::write(file.path, text.as_bytes())?;
            println!("{} written", file.path);
        }
    }
    for (path, bytes) in seeds.iter().filter(|(path, _)| wanted(path)) {
        if files::read(path)?.as_ref() == Some(bytes) {
            continue;
        }
        stale += 1;
        if arguments.check {
            println!("{path} is out of date");
        } else {
            files::write(path, bytes)?;
            println!("{path} written");
        }
    }
    for recording in goldens.iter().filter(|recording| wanted(&recording.path)) {
        let difference = recording.difference()?;
        match difference {
            None if !arguments.force => continue,
            _ => stale += 1,
        }
        let because = difference.map_or(String::new(), |difference| format!(": {difference}"));
        if arguments.check {
            println!("{} is out of date{because}", recording.path);
        } else {
            recording.make()?;
            println!("{} written{because}", recording.path);
        }
    }
    if stale == 0 {
        println!("all generated files are up to date");
    }
    Ok(if arguments.check && stale > 0 { Exit::Regression } else { Exit::Done })
}
