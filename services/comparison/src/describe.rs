//! Comparisons in words.

use std::fmt;

use crate::compare::AnswerComparison;
use crate::motion::{Change, Deviation, MotionChange};

/// How many of something there are: `1 request`, `2 requests`.
pub fn counted(count: u64, what: &str) -> String {
    let end = if count == 1 { "" } else { "s" };
    format!("{count} {what}{end}")
}

/// Such as `answer 0 moved: position by 0.001 m (sample 4, 0.2 m along), duration -0.5 s`.
impl fmt::Display for AnswerComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { answer, verdict, first, arc_length, motion } = self;
        match answer {
            Some(answer) => write!(f, "answer {answer} {}", verdict.name().replace('_', " "))?,
            None => write!(f, "refusal {}", verdict.name().replace('_', " "))?,
        }
        let changes = motion.as_deref().map(changes).unwrap_or_default();
        if !changes.is_empty() {
            return write!(f, ": {}", changes.join(", "));
        }
        // Nothing that has a number of its own: the first difference tells.
        match (first, arc_length) {
            (Some(first), Some(along)) => write!(f, ": {first}, {along:.3} m along"),
            (Some(first), None) => write!(f, ": {first}"),
            (None, _) => Ok(()),
        }
    }
}

/// What has changed, each with its numbers.
fn changes(motion: &MotionChange) -> Vec<String> {
    let MotionChange {
        position,
        heading,
        time,
        speed,
        length,
        duration,
        clearance,
        route,
        legs,
        samples,
    } = motion;
    let mut changes = Vec::new();
    let largest = [
        ("position", position, "m"),
        ("heading", heading, "rad"),
        ("time", time, "s"),
        ("speed", speed, "m/s"),
    ];
    for (name, deviation, unit) in largest {
        if let Some(Deviation { distance, sample, arc_length }) = deviation {
            let distance = short(*distance);
            changes.push(format!(
                "{name} by {distance} {unit} (sample {sample}, {arc_length:.3} m along)"
            ));
        }
    }
    let signed =
        [("length", length, "m"), ("duration", duration, "s"), ("clearance", clearance, "m")];
    for (name, change, unit) in signed {
        if Change::by(*change) != 0.0 {
            let by = change.by();
            let sign = if by > 0.0 { "+" } else { "" };
            changes.push(format!("{name} {sign}{} {unit}", short(by)));
        }
    }
    if let Some([before, after]) = route {
        changes.push(format!("route {} -> {}", channels(before), channels(after)));
    }
    for (name, [before, after]) in [("legs", legs), ("samples", samples)] {
        if before != after {
            changes.push(format!("{before} -> {after} {name}"));
        }
    }
    changes
}

/// A number to four digits.
pub fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e6).contains(&size) => {
            let decimals = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
            let text = format!("{value:.decimals$}");
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
                false => text,
            }
        }
        _ => format!("{value:.3e}"),
    }
}

/// The channels of a route, the middle of a long one left out.
fn channels(route: &[u64]) -> String {
    const MOST: usize = 12;
    let all: Vec<_> = route.iter().map(u64::to_string).collect();
    match all.len() {
        0 => "none".to_owned(),
        1..=MOST => all.join(" "),
        count => {
            format!("{} ... {} ({count} channels)", all[..4].join(" "), all[count - 4..].join(" "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let said = |value: f64| short(value);
        assert_eq!(said(0.001), "0.001");
        assert_eq!(said(-12.345_678), "-12.35");
        assert_eq!(said(1234.5), "1234");
        assert_eq!(said(5.5e-17), "5.500e-17");
        assert_eq!(said(100.0), "100");
        assert_eq!(said(f64::NAN), "NaN");
    }

    #[test]
    fn long_routes_lose_their_middle() {
        assert_eq!(channels(&[]), "none");
        assert_eq!(channels(&[1, 2]), "1 2");
        let long: Vec<u64> = (0..20).collect();
        assert_eq!(channels(&long), "0 1 2 3 ... 16 17 18 19 (20 channels)");
    }
}
