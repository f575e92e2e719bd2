//! The first difference of two replies.
//!
//! Codes, fields and numbers are compared; the wording of a refusal's message is for people
//! and may change. Every message type is destructured in full, so that a new field does not
//! compile until it is compared.

mod fields;
mod number;

use std::fmt;

use schemas::message::{ErrorCode, Refusal, Reply};

use fields::Comparer;

/// How equal numbers must be.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Tolerance {
    /// Bit for bit.
    #[default]
    Exact,
    /// Up to this far apart, in metres, radians and seconds alike; headings modulo a whole
    /// turn.
    Within(f64),
}

/// How a recorded reply compares with the one that should equal it.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// They are equal.
    Equal {
        /// Refusals whose messages are worded differently.
        reworded: usize,
    },
    /// They differ, first here.
    Different(Box<Difference>),
    /// The recorded reply depends on load, not only on the request: its deadline had passed,
    /// or the planner was overloaded.
    NotRepeatable,
}

/// The first difference of two replies.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Where they differ.
    pub path: FieldPath,
    /// What was recorded there; numbers with 17 significant digits.
    pub recorded: String,
    /// What the other reply has there.
    pub planned: String,
    /// How far apart the numbers are, if they are numbers.
    pub distance: Option<f64>,
}

/// Where in a reply a field is.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FieldPath {
    /// The answer, from 0.
    pub answer: Option<usize>,
    /// A list of the answer's trajectory, in the singular, and an index in it.
    pub item: Option<(&'static str, usize)>,
    /// The field.
    pub field: String,
}

impl fmt::Display for FieldPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(answer) = self.answer {
            write!(f, "answer {answer}, ")?;
        }
        if let Some((list, index)) = self.item {
            write!(f, "{list} {index}, ")?;
        }
        f.write_str(&self.field)
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { path, recorded, planned, distance } = self;
        write!(f, "{path}: recorded {recorded}, planned {planned}")?;
        match distance {
            Some(distance) if distance.is_finite() => write!(f, " ({distance:.2e} apart)"),
            _ => Ok(()),
        }
    }
}

/// Compares two replies, field by field in the order of the message.
pub fn compare(recorded: &Reply, planned: &Reply, tolerance: Tolerance) -> Outcome {
    if recorded.answers.as_ref().is_err_and(is_not_repeatable) {
        return Outcome::NotRepeatable;
    }
    let mut reworded = 0;
    match Comparer::new(tolerance, &mut reworded).replies(recorded, planned) {
        Ok(()) => Outcome::Equal { reworded },
        Err(difference) => Outcome::Different(difference),
    }
}

/// Whether a refusal depends on the clock, on load, or on what the planner still knew.
fn is_not_repeatable(refusal: &Refusal) -> bool {
    use ErrorCode::{DeadlineExceeded, Overloaded, UnknownFreeSpace};
    matches!(refusal.code, DeadlineExceeded | Overloaded | UnknownFreeSpace)
}

#[cfg(test)]
mod tests;
