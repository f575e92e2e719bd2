//! The `fuzz` command; see `fuzz --help`.

use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::{Parser, builder::PossibleValuesParser};
use clearway_fuzz_targets::{Failure, TARGETS, Target, run, search};

/// Replays inputs, or mutates a target's corpus, without libFuzzer.
#[derive(Parser)]
#[command(
    version,
    after_help = "\
Examples:
  fuzz border fuzz/artifacts/border/crash-1
  fuzz scene --time 300

Exit codes: 0 done, 1 an input made the target panic, 2 usage."
)]
struct Arguments {
    /// What to fuzz
    #[arg(value_parser = PossibleValuesParser::new(TARGETS.map(|target| target.name)))]
    target: String,
    /// Inputs to replay [default: the target's corpus]
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Then run on mutations of them for this many seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0)]
    time: u64,
    /// The seed of the first thousand mutations; the next thousand have the next seed
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let target = TARGETS.into_iter().find(|target| target.name == arguments.target);
    let target = target.expect("clap has checked the name");
    match inputs(&target, &arguments.files) {
        Err(error) => {
            eprintln!("fuzz: {error}");
            ExitCode::FAILURE
        }
        Ok(inputs) => match fuzz(&target, &inputs, &arguments) {
            Ok(runs) => {
                println!("{}: {runs} inputs, no failures", target.name);
                ExitCode::SUCCESS
            }
            Err(failure) => {
                let path = PathBuf::from(format!("fuzz/artifacts/{}/panic", target.name));
                let saved = path.parent().map_or(Ok(()), fs::create_dir_all);
                match saved.and_then(|()| fs::write(&path, &failure.input)) {
                    Ok(()) => eprintln!("fuzz: {failure:?}\nthe input is in {}", path.display()),
                    Err(error) => eprintln!("fuzz: {failure:?}\n{}: {error}", path.display()),
                }
                ExitCode::FAILURE
            }
        },
    }
}

fn inputs(target: &Target, files: &[PathBuf]) -> std::io::Result<Vec<Vec<u8>>> {
    let mut files = files.to_vec();
    if files.is_empty() {
        for entry in fs::read_dir(target.corpus())? {
            files.push(entry?.path());
        }
        files.sort();
    }
    files.iter().map(fs::read).collect()
}

fn fuzz(target: &Target, inputs: &[Vec<u8>], arguments: &Arguments) -> Result<u64, Failure> {
    for input in inputs {
        run(target, input)?;
    }
    let (begin, time) = (Instant::now(), Duration::from_secs(arguments.time));
    let mut mutations = 0;
    while begin.elapsed() < time {
        search(target, inputs, 1000, arguments.seed + mutations / 1000)?;
        mutations += 1000;
    }
    Ok(inputs.len() as u64 + mutations)
}
