//! A map's YAML.

use std::path::{Path, PathBuf};

use saphyr::{LoadableYamlNode, Yaml};

use crate::error::MapError;

/// A map's YAML. Unknown fields are ignored: other tools keep theirs in the same file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Description {
    /// Path of the picture; if relative, from the YAML's folder.
    pub(crate) image: PathBuf,
    /// The side of a cell, metres.
    pub(crate) resolution: f64,
    /// The lower left corner of the map, metres, and its turn about it, radians.
    pub(crate) origin: [f64; 3],
    /// Whether bright cells are occupied.
    pub(crate) negate: bool,
    /// Cells with a greater occupancy are occupied.
    pub(crate) occupied: f64,
    /// Cells with a lower occupancy are free.
    pub(crate) free: f64,
    /// How shades become occupancies.
    pub(crate) mode: Mode,
}

/// How shades become occupancies; see the table in [`crate`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Free, occupied, or unknown.
    Trinary,
    /// As [`Mode::Trinary`], with values in between; transparent cells are unknown.
    Scale,
    /// The shade is a percentage.
    Raw,
}

impl Description {
    /// Reads the YAML `text` of the file `path`.
    pub(crate) fn read(path: &Path, text: &str) -> Result<Self, MapError> {
        let not_yaml = |cause| MapError::NotYaml { path: path.to_owned(), cause };
        let documents = Yaml::load_from_str(text).map_err(|error| not_yaml(error.to_string()))?;
        let fields = match documents.as_slice() {
            [one] if one.is_mapping() => YamlFields { path, document: one },
            [_] => return Err(not_yaml("expected a mapping".to_owned())),
            _ => return Err(not_yaml(format!("{} documents, expected one", documents.len()))),
        };
        let image = fields.get("image")?;
        let image = match image.as_str() {
            Some(name) if !name.is_empty() => path.with_file_name(name),
            _ => return Err(fields.wrong("image", "the name of a picture", image)),
        };
        let resolution =
            fields.number("resolution", "a number of metres greater than 0", |value| {
                value > 0.0 && value.is_finite()
            })?;
        let from_0_to_1 = |value| (0.0..=1.0).contains(&value);
        let free = fields.number("free_thresh", "a number from 0 to 1", from_0_to_1)?;
        let occupied = fields.number("occupied_thresh", "a number from 0 to 1", from_0_to_1)?;
        if free > occupied {
            return Err(MapError::Thresholds { path: path.to_owned(), free, occupied });
        }
        let origin = fields.origin()?;
        let (negate, mode) = (fields.negate()?, fields.mode()?);
        Ok(Self { image, resolution, origin, negate, occupied, free, mode })
    }
}

struct YamlFields<'a> {
    path: &'a Path,
    document: &'a Yaml<'a>,
}

impl<'a> YamlFields<'a> {
    fn get(&self, field: &'static str) -> Result<&'a Yaml<'a>, MapError> {
        self.document
            .as_mapping_get(field)
            .ok_or_else(|| MapError::Missing { path: self.path.to_owned(), field })
    }

    fn wrong(&self, field: &'static str, expected: &'static str, has: &Yaml) -> MapError {
        MapError::Field { path: self.path.to_owned(), field, expected, has: written(has) }
    }

    fn number(
        &self,
        field: &'static str,
        expected: &'static str,
        fits: impl Fn(f64) -> bool,
    ) -> Result<f64, MapError> {
        let value = self.get(field)?;
        number(value)
            .filter(|number| fits(*number))
            .ok_or_else(|| self.wrong(field, expected, value))
    }

    fn origin(&self) -> Result<[f64; 3], MapError> {
        let value = self.get("origin")?;
        let numbers: Option<Vec<f64>> = value
            .as_sequence()
            .and_then(|list| list.iter().map(number).collect())
            .filter(|list: &Vec<f64>| list.iter().all(|number| number.is_finite()));
        numbers
            .and_then(|list| list.try_into().ok())
            .ok_or_else(|| self.wrong("origin", "three finite numbers, [x, y, yaw]", value))
    }

    fn negate(&self) -> Result<bool, MapError> {
        let value = self.get("negate")?;
        let word = value.as_str().map(|word| word.trim().to_ascii_lowercase());
        match (value.as_bool(), value.as_integer(), word.as_deref()) {
            (Some(negate), ..) => Ok(negate),
            (_, Some(0), _) | (.., Some("0" | "false" | "no" | "off" | "n")) => Ok(false),
            (_, Some(1), _) | (.., Some("1" | "true" | "yes" | "on" | "y")) => Ok(true),
            _ => Err(self.wrong("negate", "0 or 1", value)),
        }
    }

    fn mode(&self) -> Result<Mode, MapError> {
        let Some(value) = self.document.as_mapping_get("mode") else { return Ok(Mode::Trinary) };
        match value.as_str().map(str::to_ascii_lowercase).as_deref() {
            Some("trinary") => Ok(Mode::Trinary),
            Some("scale") => Ok(Mode::Scale),
            Some("raw") => Ok(Mode::Raw),
            _ => Err(self.wrong("mode", "trinary, scale or raw", value)),
        }
    }
}

/// A number, in quotes or not: the map server reads both.
fn number(value: &Yaml) -> Option<f64> {
    let quoted = || {
        let text = value.as_str()?.trim();
        // Only digits: "nan" and "infinity" are words.
        text.bytes().any(|byte| byte.is_ascii_digit()).then(|| text.parse().ok())?
    };
    value
        .as_floating_point()
        .or_else(|| value.as_integer().map(|integer| integer as f64))
        .or_else(quoted)
}

/// A value as shown in messages.
fn written(value: &Yaml) -> String {
    if let Some(list) = value.as_sequence() {
        return format!("[{}]", list.iter().map(written).collect::<Vec<_>>().join(", "));
    }
    if let Some(text) = value.as_str() {
        return format!("{text:?}");
    }
    match (number(value), value.as_bool()) {
        (Some(number), _) => number.to_string(),
        (_, Some(flag)) => flag.to_string(),
        _ if value.is_null() => "nothing".to_owned(),
        _ => "a value of another type".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OFFICE: &str = "image: office.pgm\nresolution: 0.05\norigin: [-1, 2.5, 0.0]\n\
                          negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

    fn read(text: &str) -> Result<Description, MapError> {
        Description::read(Path::new("maps/office.yaml"), text)
    }

    #[test]
    fn fields_are_read_and_mode_may_be_left_out() {
        let office = Description {
            image: PathBuf::from("maps/office.pgm"),
            resolution: 0.05,
            origin: [-1.0, 2.5, 0.0],
            negate: false,
            occupied: 0.65,
            free: 0.196,
            mode: Mode::Trinary,
        };
        assert_eq!(read(OFFICE).unwrap(), office);
        let inverted = read(&OFFICE.replace("negate: 0", "negate: true\nmode: Scale")).unwrap();
        assert_eq!(inverted, Description { negate: true, mode: Mode::Scale, ..office });
    }

    #[test]
    fn numbers_may_be_quoted() {
        let quoted = "image: office.pgm\nresolution: \"0.05\"\norigin: ['-1', \"2.5\", ' 0 ']\n\
                      negate: \"0\"\noccupied_thresh: '0.65'\nfree_thresh: \"1.96e-1\"\n";
        assert_eq!(read(quoted).unwrap(), read(OFFICE).unwrap());
    }

    #[test]
    fn negate_is_a_number_or_a_word() {
        let negate = |word: &str| read(&OFFICE.replace("negate: 0", word)).unwrap().negate;
        for word in ["negate: '1'", "negate: 1", "negate: yes", "negate: True", "negate: \"on\""] {
            assert!(negate(word), "{word}");
        }
        for word in ["negate: '0'", "negate: no", "negate: FALSE", "negate: 'off'"] {
            assert!(!negate(word), "{word}");
        }
    }

    #[test]
    fn a_yaw_is_read() {
        let turned = read(&OFFICE.replace(", 0.0]", ", 1.57]")).unwrap();
        assert_eq!(turned.origin, [-1.0, 2.5, 1.57]);
    }

    #[test]
    fn fields_of_other_tools_are_ignored() {
        let more = format!("# saved by hand\n{OFFICE}elevation_image: up.pgm\n");
        assert_eq!(read(&more).unwrap(), read(OFFICE).unwrap());
    }

    #[test]
    fn an_absolute_picture_stays_where_it_is() {
        let there = read(&OFFICE.replace("office.pgm", "/srv/office.pgm")).unwrap();
        assert_eq!(there.image, Path::new("/srv/office.pgm"));
    }

    /// With `from` replaced by `to`, the YAML is refused with this message.
    #[track_caller]
    fn check(from: &str, to: &str, message: &str) {
        assert!(OFFICE.contains(from));
        let error = read(&OFFICE.replace(from, to)).unwrap_err();
        assert_eq!(error.to_string(), format!("maps/office.yaml: {message}"));
    }

    #[test]
    fn errors_name_the_file_the_field_and_what_it_has() {
        check("0.05", "-0.05", "resolution must be a number of metres greater than 0, not -0.05");
        check("0.05", ".inf", "resolution must be a number of metres greater than 0, not inf");
        check("0.05", "", "resolution must be a number of metres greater than 0, not nothing");
        check("0.65", "1.5", "occupied_thresh must be a number from 0 to 1, not 1.5");
        check("0.196", ".nan", "free_thresh must be a number from 0 to 1, not NaN");
        check("0.196", "low", "free_thresh must be a number from 0 to 1, not \"low\"");
        check("0.196", "0.7", "free_thresh 0.7 must not exceed occupied_thresh 0.65");
        check(", 0.0]", "]", "origin must be three finite numbers, [x, y, yaw], not [-1, 2.5]");
        check(
            ", 0.0]",
            ", .nan]",
            "origin must be three finite numbers, [x, y, yaw], not [-1, 2.5, NaN]",
        );
        check("negate: 0", "negate: 3", "negate must be 0 or 1, not 3");
        check(
            "negate: 0",
            "negate: 0\nmode: gray",
            "mode must be trinary, scale or raw, not \"gray\"",
        );
        check("office.pgm", "''", "image must be the name of a picture, not \"\"");
        check("negate: 0\n", "", "negate is missing");
        check(
            ", 0.0]",
            ", .inf]",
            "origin must be three finite numbers, [x, y, yaw], not [-1, 2.5, inf]",
        );
        check("0.65", "\"1.5\"", "occupied_thresh must be a number from 0 to 1, not \"1.5\"");
        check("0.05", "'nan'", "resolution must be a number of metres greater than 0, not \"nan\"");
    }

    #[test]
    fn invalid_yaml_is_refused() {
        for text in ["", "image: a\n---\nimage: b\n", "- 1\n", "just words", "image: [", "a: *b"] {
            let error = read(text).unwrap_err();
            assert!(matches!(error, MapError::NotYaml { .. }), "{text:?}: {error}");
        }
    }
}
