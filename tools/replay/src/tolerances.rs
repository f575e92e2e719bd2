//! How far replies may differ: given on the command line, and in `replay.toml` beside recordings.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use comparison::tolerance::{Quantity, Tolerance};

use crate::units::Measure;

/// The file beside recordings.
pub(crate) const FILE: &str = "replay.toml";

fn measure(quantity: Quantity) -> Measure {
    match quantity {
        Quantity::Position | Quantity::Length | Quantity::Clearance | Quantity::Gap => {
            Measure::Length
        }
        Quantity::Heading => Measure::Angle,
        Quantity::Time => Measure::Time,
        Quantity::Speed => Measure::Speed,
        Quantity::YawRate => Measure::YawRate,
        Quantity::Refusal => Measure::Number,
    }
}

/// What `--tolerance` says: a number for everything, or `position=1mm,heading=0.1deg`.
pub(crate) fn parse(text: &str) -> Result<Tolerance, String> {
    let mut tolerance = Tolerance::EXACT;
    for item in text.split(',') {
        tolerance = match item.split_once('=') {
            None => with_each(tolerance, bound(Measure::Number, item)?),
            Some((name, number)) => set(tolerance, name.trim(), number)?,
        };
    }
    Ok(tolerance)
}

/// The tolerance with another number for everything that has none of its own.
fn with_each(tolerance: Tolerance, most: f64) -> Tolerance {
    let own = Quantity::ALL.into_iter();
    own.filter_map(|quantity| Some((quantity, tolerance.own(quantity)?)))
        .fold(Tolerance::within(most), |all, (quantity, most)| all.with(quantity, most))
}

fn set(tolerance: Tolerance, name: &str, number: &str) -> Result<Tolerance, String> {
    let quantity = Quantity::from_name(name).ok_or_else(|| {
        let names = Quantity::ALL.map(Quantity::name).join(", ");
        format!("{name:?} is none of {names}")
    })?;
    Ok(tolerance.with(quantity, bound(measure(quantity), number)?))
}

fn bound(measure: Measure, text: &str) -> Result<f64, String> {
    match measure.parse(text) {
        Ok(value) if value >= 0.0 => Ok(value),
        Err(said) if measure != Measure::Number => Err(said),
        _ => Err("must be a number, 0 or greater".to_owned()),
    }
}

/// Tolerances of the folders where recordings lie.
#[derive(Default)]
pub(crate) struct Folders {
    read: BTreeMap<PathBuf, Result<Tolerance, String>>,
}

impl Folders {
    /// What applies to a recording: what is `given`, and then what the file beside it says.
    pub(crate) fn tolerance(&mut self, given: Tolerance, path: &Path) -> Result<Tolerance, String> {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let beside = self.read.entry(folder).or_insert_with_key(|folder| {
            let file = folder.join(FILE);
            read(&file).map_err(|said| format!("{}: {said}", file.display()))
        });
        Ok(given.or(beside.clone()?))
    }
}

/// The tolerances in a file, if it exists.
fn read(path: &Path) -> Result<Tolerance, String> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Tolerance::EXACT),
        Err(error) => return Err(error.to_string()),
    };
    in_toml(&text)
}

fn in_toml(text: &str) -> Result<Tolerance, String> {
    let table: toml::Table = text.parse().map_err(|error: toml::de::Error| error.to_string())?;
    let mut tolerance = Tolerance::EXACT;
    for (name, value) in &table {
        let toml::Value::Table(quantities) = value else {
            return Err(format!("{name} must be the table [tolerance]"));
        };
        if name != "tolerance" {
            return Err(format!("[{name}] is not known; [tolerance] is"));
        }
        for (name, value) in quantities {
            let number = match value {
                toml::Value::String(text) => text.clone(),
                toml::Value::Integer(number) => number.to_string(),
                toml::Value::Float(number) => number.to_string(),
                _ => return Err(format!("tolerance.{name} must be a number or a text")),
            };
            let set = set(tolerance, name, &number);
            tolerance = set.map_err(|said| format!("tolerance.{name}: {said}"))?;
        }
    }
    Ok(tolerance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_for_all_that_has_none_of_its_own() {
        let exact = Tolerance::EXACT;
        assert_eq!(parse("1e-9"), Ok(Tolerance::within(1e-9)));
        let some = exact.with(Quantity::Position, 0.001).with(Quantity::Heading, 0.5);
        assert_eq!(parse("position=1mm, heading=500mrad"), Ok(some));
        let both = Ok(Tolerance::within(1e-9).with(Quantity::Time, 0.002));
        assert_eq!(parse("1e-9,time=2ms"), both);
        assert_eq!(parse("time=2ms,1e-6,1e-9"), both);
    }

    #[test]
    fn wrong_tolerances_are_explained() {
        let said = |text: &str| parse(text).unwrap_err();
        assert_eq!(said("-1"), "must be a number, 0 or greater");
        assert_eq!(said("NaN"), "must be a number, 0 or greater");
        assert_eq!(said("position=-1mm"), "must be a number, 0 or greater");
        assert_eq!(said("time=1mm"), "\"1mm\" must be a number in s, ms, us, ns");
        assert!(said("places=1").starts_with("\"places\" is none of position, heading, time, "));
    }

    #[test]
    fn files_have_texts_and_numbers() {
        let text = "[tolerance]\nposition = \"1mm\"\ntime = 0.25\nclearance = 0\n";
        let expected = Tolerance::EXACT
            .with(Quantity::Position, 0.001)
            .with(Quantity::Time, 0.25)
            .with(Quantity::Clearance, 0.0);
        assert_eq!(in_toml(text), Ok(expected));
        let said = |text: &str| in_toml(text).unwrap_err();
        assert_eq!(said("[tolerances]\n"), "[tolerances] is not known; [tolerance] is");
        assert!(said("[tolerance]\nplace = 1\n").starts_with("tolerance.place: \"place\" is none"));
        assert_eq!(said("[tolerance]\ntime = true\n"), "tolerance.time must be a number or a text");
        assert!(said("tolerance").contains("line 1"));
    }
}
