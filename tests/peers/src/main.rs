//! Compares the planner with its peers, and prints tables.

use std::error::Error;
use std::io::{self, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Parser;
use comfy_table::{Cell, CellAlignment, Table, presets};
use peers::floor_plans::{measure, write_blocks};
use peers::judge::{Verdict, judge};
use peers::kinds::Kind;
use peers::lattice::Resolution;
use peers::safest::{Contest, contest};

/// Compares the planner with slow, obviously right peers.
#[derive(Debug, Parser)]
enum Command {
    /// Random scenes of the kinds that people have, beside a lattice search
    Kinds(Arguments),
    /// The safest motion of random scenes, beside those with 50 gaps
    Safest(Contests),
    /// Writes random scenes as JSON files
    Scenes(Scenes),
    /// Times on floor plans, between random places that a grid search connects
    FloorPlans(FloorPlans),
}

#[derive(Debug, clap::Args)]
struct Scenes {
    /// Where to write them
    folder: PathBuf,
    /// Scenes of each kind
    #[arg(long, default_value_t = 20)]
    scenes: u64,
    /// Gap asked for, metres
    #[arg(long, default_value_t = 0.01)]
    gap: f64,
}

#[derive(Debug, clap::Args)]
struct Contests {
    /// Only these kinds
    #[arg(long)]
    kind: Vec<Kind>,
    /// Scenes of each kind
    #[arg(long, default_value_t = 250)]
    scenes: u64,
    /// The first one's number
    #[arg(long, default_value_t = 0)]
    first: u64,
}

#[derive(Debug, clap::Args)]
struct FloorPlans {
    /// The YAML files of maps; random blocks if there are none
    maps: Vec<PathBuf>,
    /// Pairs of places on each
    #[arg(long, default_value_t = 1000)]
    pairs: usize,
    /// Gap asked for, metres
    #[arg(long, default_value_t = 0.02)]
    gap: f64,
}

#[derive(Debug, clap::Args)]
struct Arguments {
    /// Only these kinds
    #[arg(long)]
    kind: Vec<Kind>,
    /// Scenes of each kind
    #[arg(long, default_value_t = 200)]
    scenes: u64,
    /// The first one's number
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Gap asked for, metres
    #[arg(long, default_value_t = 0.01)]
    gap: f64,
    /// Step of the lattice, metres
    #[arg(long, default_value_t = 0.1)]
    step: f64,
    /// Write each scene that the planner refuses, or drives by a longer way, to this folder
    #[arg(long)]
    keep: Option<PathBuf>,
}

/// Longer than the peer's way by more than this is kept.
const LONG: f64 = 1.02;

fn main() -> Result<(), Box<dyn Error>> {
    match Command::parse() {
        Command::Kinds(arguments) => Ok(kinds(&arguments)?),
        Command::Safest(arguments) => Ok(contests(&arguments)?),
        Command::Scenes(arguments) => Ok(scenes(&arguments)?),
        Command::FloorPlans(arguments) => floor_plans(&arguments),
    }
}

fn scenes(arguments: &Scenes) -> io::Result<()> {
    std::fs::create_dir_all(&arguments.folder)?;
    for kind in Kind::ALL {
        for number in 0..arguments.scenes {
            let path = arguments.folder.join(format!("{kind:?}-{number}.json"));
            std::fs::write(path, kind.scene(number).to_json(arguments.gap))?;
        }
    }
    Ok(())
}

/// Random maps: columns and rows, and the part covered by blocks.
const BLOCKS: [(usize, f64); 4] = [(2000, 0.1), (2000, 0.15), (2000, 0.2), (4000, 0.1)];

fn floor_plans(arguments: &FloorPlans) -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let mut maps = arguments.maps.clone();
    if maps.is_empty() {
        for (side, part) in BLOCKS {
            maps.push(write_blocks(folder.path(), side, part)?);
        }
    }
    let mut table = table(&[
        "map",
        "cells",
        "corners",
        "read, ms",
        "answered, ms",
        "p50, ms",
        "p99, ms",
        "max, ms",
        "refused",
    ]);
    for map in maps {
        let figures = measure(&map, arguments.pairs, arguments.gap)?;
        for [start, goal] in &figures.refused {
            writeln!(io::stderr(), "{}: refused from {start:?} to {goal:?}", map.display())?;
        }
        let ms = |time: Duration| format!("{:.2}", time.as_secs_f64() * 1e3);
        let at = |part: usize| {
            let last = figures.further.len().saturating_sub(1);
            figures.further.get(last * part / 100).map_or_else(String::new, |time| ms(*time))
        };
        table.add_row([
            map.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            format!("{} x {}", figures.cells[0], figures.cells[1]),
            figures.corners.to_string(),
            ms(figures.read),
            ms(figures.first),
            at(50),
            at(99),
            at(100),
            figures.refused.len().to_string(),
        ]);
    }
    Ok(writeln!(io::stdout(), "{table}")?)
}

/// A table with a header, numbers to the right.
fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::ASCII_MARKDOWN).set_header(header);
    for column in 1..header.len() {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

fn kinds(arguments: &Arguments) -> io::Result<()> {
    let kinds = if arguments.kind.is_empty() { Kind::ALL.to_vec() } else { arguments.kind.clone() };
    let mut table = table(&[
        "kind", "scenes", "peer", "planner", "missed", "median", "worst", "taut", "faults",
    ]);
    for kind in kinds {
        let row = run(kind, arguments)?;
        table.add_row(row);
    }
    writeln!(io::stdout(), "{table}")
}

/// How often a gap has more clearance than the safest motion, and how long that takes.
fn contests(arguments: &Contests) -> io::Result<()> {
    let kinds = if arguments.kind.is_empty() { Kind::ALL.to_vec() } else { arguments.kind.clone() };
    let mut table = table(&[
        "kind",
        "scenes",
        "beaten",
        "by clearance",
        "at_least",
        "incomplete",
        "p50, ms",
        "max, ms",
    ]);
    for kind in kinds {
        let (mut beaten, mut clearer, mut refused, mut incomplete) = (0, 0, 0, 0);
        let mut times = Vec::new();
        for number in arguments.first..arguments.first + arguments.scenes {
            let found = contest(&kind.scene(number), number);
            let Contest { safest, took, freest, clearest, at_least } = &found;
            times.push(took.as_secs_f64() * 1e3);
            incomplete += u64::from(safest.as_ref().is_ok_and(|drive| !drive.complete));
            let excess = [found.free_excess(), found.clear_excess()];
            beaten += u64::from(excess[0].is_some());
            clearer += u64::from(excess[1].is_some());
            refused += u64::from(at_least.is_some());
            for (excess, best) in excess.iter().zip([freest, clearest]) {
                if let Some(excess) = excess {
                    writeln!(
                        io::stderr(),
                        "{kind:?}-{number}: {excess} m more: {best:?}, but {safest:?}"
                    )?;
                }
            }
            if let Some(refusal) = at_least {
                writeln!(io::stderr(), "{kind:?}-{number}: at_least refused: {refusal}")?;
            }
            if took.as_secs() >= 5 {
                writeln!(io::stderr(), "{kind:?}-{number}: took {} s", took.as_secs_f64())?;
            }
        }
        times.sort_unstable_by(f64::total_cmp);
        let ms = |at: usize| times.get(at).map_or_else(String::new, |time| format!("{time:.0}"));
        table.add_row([
            format!("{kind:?}"),
            arguments.scenes.to_string(),
            beaten.to_string(),
            clearer.to_string(),
            refused.to_string(),
            incomplete.to_string(),
            ms(times.len() / 2),
            ms(times.len().saturating_sub(1)),
        ]);
    }
    writeln!(io::stdout(), "{table}")
}

fn run(kind: Kind, arguments: &Arguments) -> io::Result<Vec<Cell>> {
    let resolution = Resolution { step: arguments.step, ..Resolution::default() };
    let (mut peers, mut planners, mut missed, mut taut, mut faulty) = (0, 0, 0, 0, 0);
    let mut ratios = Vec::new();
    for number in arguments.first..arguments.first + arguments.scenes {
        let scene = kind.scene(number);
        let begin = Instant::now();
        let verdict = judge(&scene, arguments.gap, resolution);
        let name = format!("{kind:?}-{number}");
        let Verdict { planner, peer, faults } = &verdict;
        peers += u64::from(peer.is_some());
        planners += u64::from(planner.is_ok());
        faulty += u64::from(!faults.is_empty());
        for fault in faults {
            writeln!(io::stderr(), "{name}: {fault}")?;
        }
        let mut keep = !faults.is_empty();
        match (planner, peer) {
            (Ok(drive), peer) => {
                taut += u64::from(drive.rungs == ["taut"]);
                if let Some(peer) = peer {
                    let ratio = drive.length / peer;
                    ratios.push(ratio);
                    if ratio > LONG {
                        keep = true;
                        writeln!(
                            io::stderr(),
                            "{name}: {:.3} m by {}, bound {:.3}, turned {:.2}; peer {peer:.3} m",
                            drive.length,
                            drive.rungs.join("+"),
                            drive.bound,
                            drive.turned,
                        )?;
                    }
                }
            }
            (Err(refusal), Some(peer)) => {
                missed += 1;
                keep = true;
                writeln!(io::stderr(), "{name}: peer {peer:.3} m, refused: {refusal}")?;
            }
            (Err(_), None) => {}
        }
        if begin.elapsed().as_secs() >= 20 {
            writeln!(io::stderr(), "{name}: took {} s", begin.elapsed().as_secs())?;
        }
        if let Some(folder) = arguments.keep.as_ref().filter(|_| keep) {
            std::fs::create_dir_all(folder)?;
            std::fs::write(folder.join(format!("{name}.json")), scene.to_json(arguments.gap))?;
        }
    }
    ratios.sort_unstable_by(f64::total_cmp);
    let median = ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN);
    let worst = ratios.last().copied().unwrap_or(f64::NAN);
    let percent = |ratio: f64| format!("{:+.1} %", 100.0 * (ratio - 1.0));
    Ok([
        format!("{kind:?}"),
        arguments.scenes.to_string(),
        peers.to_string(),
        planners.to_string(),
        missed.to_string(),
        percent(median),
        percent(worst),
        taut.to_string(),
        faulty.to_string(),
    ]
    .into_iter()
    .map(Cell::new)
    .collect())
}
