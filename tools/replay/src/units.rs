//! Numbers with units, on the command line and in files.

use std::f64::consts::PI;

/// What a number measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Measure {
    /// Metres.
    Length,
    /// Seconds.
    Time,
    /// Radians.
    Angle,
    /// Metres a second.
    Speed,
    /// Radians a second.
    YawRate,
    /// A plain number.
    Number,
}

impl Measure {
    /// The units that it can be given in, each with its size; the first is the default.
    fn units(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::Length => &[("m", 1.0), ("mm", 1e-3), ("um", 1e-6), ("cm", 1e-2), ("km", 1e3)],
            Self::Time => &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)],
            Self::Angle => &[("rad", 1.0), ("mrad", 1e-3), ("deg", PI / 180.0)],
            Self::Speed => &[("m/s", 1.0), ("mm/s", 1e-3)],
            Self::YawRate => &[("rad/s", 1.0), ("deg/s", PI / 180.0)],
            Self::Number => &[],
        }
    }

    /// A finite number with one of the units, or with none: then the default is meant.
    pub(crate) fn parse(self, text: &str) -> Result<f64, String> {
        let text = text.trim();
        let digits = |c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-');
        // An `e` belongs to the number only if digits follow: 1e-3m, but not 1e.
        let mut end = text.find(|c| !digits(c)).unwrap_or(text.len());
        if let Some(exponent) = text[end..].strip_prefix(['e', 'E'])
            && exponent.starts_with(digits)
        {
            end += 1 + exponent.find(|c| !digits(c)).unwrap_or(exponent.len());
        }
        let (number, unit) = text.split_at(end);
        let unit = unit.trim();
        let scale = match self.units().iter().find(|(name, _)| *name == unit) {
            Some((_, scale)) => *scale,
            None if unit.is_empty() => 1.0,
            None => {
                let known: Vec<_> = self.units().iter().map(|(name, _)| *name).collect();
                return Err(match known.is_empty() {
                    true => format!("{text:?} is not a number"),
                    false => format!("{text:?} must be a number in {}", known.join(", ")),
                });
            }
        };
        match number.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value * scale),
            _ => Err(format!("{text:?} is not a number")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_units_or_none() {
        let check = |measure: Measure, text: &str, expected: f64| {
            assert_eq!(measure.parse(text), Ok(expected), "{text}");
        };
        check(Measure::Length, "0.1", 0.1);
        check(Measure::Length, "2mm", 0.002);
        check(Measure::Length, "1e-3m", 1e-3);
        check(Measure::Length, "-1.5E2 m", -150.0);
        check(Measure::Time, "50ms", 0.05);
        check(Measure::Angle, "180deg", PI);
        check(Measure::Speed, "5mm/s", 0.005);
        check(Measure::Number, "3", 3.0);
    }

    #[test]
    fn wrong_numbers_and_units_are_refused() {
        for text in ["", "mm", "1mmm", "1s", "1e", "1e400", "nan", "inf", "1 2"] {
            assert!(Measure::Length.parse(text).is_err(), "{text}");
        }
        let said = Measure::Time.parse("3mm").unwrap_err();
        assert_eq!(said, "\"3mm\" must be a number in s, ms, us, ns");
        assert_eq!(Measure::Number.parse("3m").unwrap_err(), "\"3m\" is not a number");
    }
}
