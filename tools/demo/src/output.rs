//! Files and table of a demo.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use comparison::check::Checked;
use render::table::table;

use crate::Error;

/// The folder for this run: the one asked for, which must not contain a demo yet, or the
/// next free number.
pub(crate) fn directory(asked: Option<PathBuf>) -> Result<PathBuf, Error> {
    if let Some(directory) = asked {
        fs::create_dir_all(&directory)?;
        if directory.join("demo.mcap").exists() {
            return Err(format!(
                "{} already contains a demo; choose another folder",
                directory.display()
            )
            .into());
        }
        return Ok(directory);
    }
    let parent = Path::new("target/demo");
    fs::create_dir_all(parent)?;
    for number in 1.. {
        let directory = parent.join(number.to_string());
        match fs::create_dir(&directory) {
            Ok(()) => return Ok(directory),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error.into()),
        }
    }
    unreachable!("there is always another number")
}

/// Saves a picture.
pub(crate) fn save(directory: &Path, name: &str, picture: &str) -> Result<(), Error> {
    let name = name.replace(' ', "-").to_lowercase();
    Ok(fs::write(directory.join(format!("{name}.svg")), picture)?)
}

/// One line of the table.
pub(crate) struct Row {
    pub(crate) task: String,
    pub(crate) gap: String,
    pub(crate) length: f64,
    pub(crate) clearance: f64,
    pub(crate) legs: Vec<f64>,
    pub(crate) duration: f64,
    pub(crate) samples: usize,
    pub(crate) round_trip: Duration,
}

pub(crate) fn print(rows: &[Row], directory: &Path, checked: &Checked) -> io::Result<()> {
    let mut out = io::stdout().lock();
    let mut table = table(&[
        "task",
        "gap",
        "length",
        "clearance",
        "per leg",
        "duration",
        "samples",
        "round trip",
    ]);
    for row in rows {
        table.add_row([
            row.task.clone(),
            row.gap.clone(),
            format!("{:.6} m", row.length),
            format!("{:.4} m", row.clearance),
            legs(&row.legs),
            format!("{:.2} s", row.duration),
            row.samples.to_string(),
            format!("{:.1} µs", row.round_trip.as_secs_f64() * 1e6),
        ]);
    }
    writeln!(
        out,
        "{table}\n\n\
         Clearances are exact: over the whole motion, and per leg. Round trips are medians\n\
         of {}, through shared memory, with a recorder listening.\n",
        crate::ROUNDS
    )?;
    writeln!(out, "{checked}\n\nRecording and pictures are in {}:", directory.display())?;
    let mut files: Vec<_> =
        fs::read_dir(directory)?.map(|entry| Ok(entry?.file_name())).collect::<io::Result<_>>()?;
    files.sort();
    for file in files {
        writeln!(out, "  {}", file.to_string_lossy())?;
    }
    Ok(())
}

/// The clearances of the legs, or their range where there are many.
fn legs(clearances: &[f64]) -> String {
    if clearances.len() <= 3 {
        let each: Vec<_> = clearances.iter().map(|value| format!("{value:.4}")).collect();
        return each.join(" ");
    }
    let least = clearances.iter().copied().fold(f64::INFINITY, f64::min);
    let most = clearances.iter().copied().fold(0.0, f64::max);
    format!("{least:.4} to {most:.4}")
}
