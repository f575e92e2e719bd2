//! Sizes on the command line: a number with a unit.

/// Units and their bytes.
const UNITS: [(&str, u64); 7] = [
    ("B", 1),
    ("kB", 1_000),
    ("MB", 1_000_000),
    ("GB", 1_000_000_000),
    ("KiB", 1 << 10),
    ("MiB", 1 << 20),
    ("GiB", 1 << 30),
];

/// Reads a size such as `64MiB` or `1.5 GB`.
pub fn parse(text: &str) -> Result<u64, String> {
    let end = text.find(|c: char| c != '.' && !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = (&text[..end], text[end..].trim());
    let bytes = UNITS.iter().find(|(name, _)| name.eq_ignore_ascii_case(unit));
    let number = number.parse::<f64>().ok().filter(|number| number.is_finite());
    let (Some((_, unit)), Some(number)) = (bytes, number) else {
        let units = UNITS.map(|(name, _)| name).join(", ");
        return Err(format!("a size is a number with a unit ({units}), such as 64MiB"));
    };
    let bytes = number * *unit as f64;
    if (1.0..1e18).contains(&bytes) {
        Ok(bytes as u64)
    } else {
        Err("must be at least 1 byte and less than 10^18".to_owned())
    }
}

/// A size for people, such as `81.2 MB`.
pub(crate) fn text(bytes: u64) -> String {
    match UNITS[1..4].iter().rev().find(|(_, unit)| bytes >= *unit) {
        Some((name, unit)) => format!("{:.1} {name}", bytes as f64 / *unit as f64),
        None => format!("{bytes} B"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        assert_eq!(parse("64MiB"), Ok(64 << 20));
        assert_eq!(parse("1.5 GB"), Ok(1_500_000_000));
        assert_eq!(parse("500kb"), Ok(500_000));
        for text in ["64", "MiB", "-1MB", "0B", "1e9B", "1XB", "", "1.2.3MB"] {
            assert!(parse(text).is_err(), "{text}");
        }
        assert_eq!(text(81_230_000), "81.2 MB");
        assert_eq!(text(999), "999 B");
    }
}
