//! Which rows `replay show` lists.

use schemas::message::{ErrorCode, Task};

use super::rows::Row;
use crate::units::Measure;

/// What `--error` asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Refused {
    Any,
    With(ErrorCode),
}

pub(crate) fn refused(text: &str) -> Result<Refused, String> {
    match (text, ErrorCode::from_name(text)) {
        ("any", _) => Ok(Refused::Any),
        (_, Some(code)) => Ok(Refused::With(code)),
        _ => Err(format!("must be one of {}", ErrorCode::NAMES.join(", "))),
    }
}

pub(crate) fn task(text: &str) -> Result<Task, String> {
    Task::from_name(text).ok_or_else(|| format!("must be one of {}", Task::NAMES.join(", ")))
}

/// A number of a row, by its name.
#[derive(Debug, Clone, Copy)]
struct Field {
    name: &'static str,
    measure: Measure,
    value: fn(&Row) -> Option<f64>,
}

const FIELDS: [Field; 11] = [
    field("request", Measure::Number, |row| Some(row.request as f64)),
    field("id", Measure::Number, |row| row.id.map(|id| id as f64)),
    field("answer", Measure::Number, |row| row.answer.map(|answer| answer as f64)),
    field("length", Measure::Length, |row| row.motion.map(|motion| motion.length)),
    field("clearance", Measure::Length, |row| row.motion.map(|motion| motion.clearance)),
    field("free_clearance", Measure::Length, |row| row.motion?.free_clearance),
    field("bound", Measure::Length, |row| row.motion?.bound),
    field("duration", Measure::Time, |row| row.motion.map(|motion| motion.duration)),
    field("took", Measure::Time, |row| row.took),
    field("legs", Measure::Number, |row| row.motion.map(|motion| motion.legs as f64)),
    field("samples", Measure::Number, |row| row.motion.map(|motion| motion.samples as f64)),
];

const fn field(name: &'static str, measure: Measure, value: fn(&Row) -> Option<f64>) -> Field {
    Field { name, measure, value }
}

#[derive(Debug, Clone, Copy)]
struct Operator {
    text: &'static str,
    holds: fn(f64, f64) -> bool,
}

#[expect(clippy::float_cmp, reason = "whoever writes = means it")]
const OPERATORS: [Operator; 6] = [
    Operator { text: "<=", holds: |a, b| a <= b },
    Operator { text: ">=", holds: |a, b| a >= b },
    Operator { text: "!=", holds: |a, b| a != b },
    Operator { text: "<", holds: |a, b| a < b },
    Operator { text: ">", holds: |a, b| a > b },
    Operator { text: "=", holds: |a, b| a == b },
];

/// A comparison such as `clearance<0.1`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Condition {
    field: Field,
    operator: Operator,
    number: f64,
}

impl Condition {
    pub(crate) fn holds(&self, row: &Row) -> bool {
        (self.field.value)(row).is_some_and(|value| (self.operator.holds)(value, self.number))
    }
}

impl std::str::FromStr for Condition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let at = text.find(['<', '>', '=', '!']).ok_or("must have one of < <= > >= = !=")?;
        let (name, rest) = text.split_at(at);
        let name = name.trim();
        let operator = OPERATORS.into_iter().find(|operator| rest.starts_with(operator.text));
        let operator = operator.ok_or("must have one of < <= > >= = !=")?;
        let field = FIELDS.into_iter().find(|field| field.name == name).ok_or_else(|| {
            let names = FIELDS.map(|field| field.name).join(", ");
            format!("{name:?} is none of {names}")
        })?;
        // == is what programmers write.
        let number = rest[operator.text.len()..].trim_start_matches('=');
        Ok(Self { field, operator, number: field.measure.parse(number)? })
    }
}

#[cfg(test)]
mod tests {
    use super::super::rows::Motion;
    use super::*;

    fn row() -> Row {
        let motion = Motion {
            length: 7.5,
            clearance: 0.05,
            free_clearance: None,
            bound: None,
            duration: 2.0,
            legs: 3,
            samples: 101,
        };
        Row { id: Some(7), answer: Some(0), motion: Some(motion), ..Row::default() }
    }

    #[track_caller]
    fn check(text: &str, expected: bool) {
        let condition: Condition = text.parse().unwrap();
        assert_eq!(condition.holds(&row()), expected, "{text}");
    }

    #[test]
    fn numbers_are_compared_in_their_units() {
        check("clearance<0.1", true);
        check("clearance < 50mm", false);
        check("clearance<=50mm", true);
        check("duration > 1999ms", true);
        check("id=7", true);
        check("id==7", true);
        check("id!=7", false);
        check("samples>=102", false);
    }

    #[test]
    fn what_has_no_such_number_is_not_listed() {
        check("bound<100", false);
        check("bound!=100", false);
        let refused = Row { motion: None, ..row() };
        assert!(!"length>0".parse::<Condition>().unwrap().holds(&refused));
    }

    #[test]
    fn wrong_conditions_are_explained() {
        let said = |text: &str| text.parse::<Condition>().unwrap_err();
        assert!(said("clearence<1").starts_with("\"clearence\" is none of request, id, "));
        assert_eq!(said("clearance"), "must have one of < <= > >= = !=");
        assert_eq!(said("clearance!1"), "must have one of < <= > >= = !=");
        assert_eq!(said("duration<3mm"), "\"3mm\" must be a number in s, ms, us, ns");
        assert!(said("length<").contains("is not a number"));
    }
}
