//! Two replies compared, answer by answer.
//!
//! Codes, fields and numbers are compared; the wording of a refusal's message is for people
//! and may change. Every message type is destructured in full, so that a new field does not
//! compile until it is compared.

mod fields;
mod number;

use std::fmt;

use schemas::message::{Answer, ErrorCode, Refusal, Reply};

use crate::motion::{self, MotionChange};
use crate::tolerance::Tolerance;
use fields::Comparer;

/// How a recorded reply compares with the one that should equal it.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// They are equal, or all differences are within tolerance.
    Equal {
        /// Refusals whose messages are worded differently.
        reworded: usize,
    },
    /// They differ by more than the tolerance, first here.
    Different(Box<Difference>),
    /// The recorded reply depends on load, not only on the request: its deadline had passed,
    /// or the planner was overloaded.
    NotRepeatable,
}

/// How an answer compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Bit for bit the same.
    Equal,
    /// The recorded answer depends on load and is not compared.
    NotRepeatable,
    /// Different, within tolerance.
    Within,
    /// Beyond tolerance: a motion that is another, or a refusal.
    Moved,
    /// There was no motion and there is one now.
    Appeared,
    /// There was a motion and there is none now.
    Vanished,
}

impl Verdict {
    /// Whether the answer is beyond tolerance.
    pub const fn is_regression(self) -> bool {
        matches!(self, Self::Moved | Self::Appeared | Self::Vanished)
    }

    /// The word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::NotRepeatable => "not_repeatable",
            Self::Within => "within",
            Self::Moved => "moved",
            Self::Appeared => "appeared",
            Self::Vanished => "vanished",
        }
    }
}

/// How an answer compares, with numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct AnswerComparison {
    /// The answer, from 0; `None` for the refusal of a request as a whole.
    pub answer: Option<usize>,
    /// How it compares.
    pub verdict: Verdict,
    /// The first difference beyond tolerance or, if there is none, the first.
    pub first: Option<Box<Difference>>,
    /// How far along the recorded path that is, metres, if it is on the path.
    pub arc_length: Option<f64>,
    /// How far the motions are apart, if both are there and differ.
    pub motion: Option<Box<MotionChange>>,
}

/// How two replies compare.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// As a whole.
    pub outcome: Outcome,
    /// Answer by answer; one entry if both replies refuse the request as a whole.
    pub answers: Vec<AnswerComparison>,
}

/// A difference of two replies.
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
pub fn compare(recorded: &Reply, planned: &Reply, tolerance: &Tolerance) -> Comparison {
    if recorded.answers.as_ref().is_err_and(depends_on_load) {
        return Comparison { outcome: Outcome::NotRepeatable, answers: Vec::new() };
    }
    let mut whole = Comparer::new(tolerance, None);
    let difference = whole.replies(recorded, planned).err();
    let mut found = Found { reworded: whole.reworded, first: difference, answers: Vec::new() };
    match (&recorded.answers, &planned.answers) {
        (Ok(recorded), Ok(planned)) => {
            for index in 0..recorded.len().max(planned.len()) {
                found.answer(index, [recorded.get(index), planned.get(index)], tolerance);
            }
            let counts = Comparer::new(tolerance, None).counts(recorded.len(), planned.len());
            found.first = found.first.or(counts.err());
        }
        (Err(_), Err(_)) => found.answers.push(AnswerComparison {
            answer: None,
            verdict: match (&found.first, &whole.within) {
                (Some(_), _) => Verdict::Moved,
                (None, Some(_)) => Verdict::Within,
                (None, None) => Verdict::Equal,
            },
            first: found.first.clone().or(whole.within),
            arc_length: None,
            motion: None,
        }),
        // Refused as a whole: each answer is.
        (Ok(recorded), Err(refusal)) => {
            let refused = Err(refusal.clone());
            for (index, answer) in recorded.iter().enumerate() {
                found.answer(index, [Some(answer), Some(&refused)], tolerance);
            }
        }
        (Err(refusal), Ok(planned)) => {
            let refused = Err(refusal.clone());
            for (index, answer) in planned.iter().enumerate() {
                found.answer(index, [Some(&refused), Some(answer)], tolerance);
            }
        }
    }
    let outcome = match found.first {
        None => Outcome::Equal { reworded: found.reworded },
        Some(difference) => Outcome::Different(difference),
    };
    Comparison { outcome, answers: found.answers }
}

/// What has been found so far.
struct Found {
    reworded: usize,
    /// The first difference beyond tolerance.
    first: Option<Box<Difference>>,
    answers: Vec<AnswerComparison>,
}

impl Found {
    /// Compares the answers with this index; one of them may be missing.
    fn answer(&mut self, index: usize, answers: [Option<&Answer>; 2], tolerance: &Tolerance) {
        let mut comparer = Comparer::new(tolerance, Some(index));
        let compared = match answers {
            [Some(recorded), Some(planned)] => comparer.answers(recorded, planned),
            _ => Ok(()),
        };
        self.reworded += comparer.reworded;
        let beyond = compared.err();
        let verdict = match answers {
            [Some(Err(refusal)), Some(_)] if depends_on_load(refusal) => Verdict::NotRepeatable,
            [Some(Ok(_)), None | Some(Err(_))] => Verdict::Vanished,
            [None | Some(Err(_)), Some(Ok(_))] => Verdict::Appeared,
            [None, _] | [_, None] => Verdict::Moved,
            _ if beyond.is_some() => Verdict::Moved,
            _ if comparer.within.is_some() => Verdict::Within,
            _ => Verdict::Equal,
        };
        if let (None, Some(beyond)) = (&self.first, &beyond) {
            self.first = Some(beyond.clone());
        }
        let first = beyond.or(comparer.within);
        let (mut arc_length, mut motion) = (None, None);
        if let [Some(Ok(recorded)), Some(Ok(planned))] = answers
            && let Some(first) = &first
        {
            arc_length = first.path.item.and_then(|item| motion::arc_length(recorded, item));
            motion = Some(Box::new(MotionChange::between(recorded, planned)));
        }
        self.answers.push(AnswerComparison {
            answer: Some(index),
            verdict,
            first,
            arc_length,
            motion,
        });
    }
}

/// Whether a refusal depends on the clock, on load, or on what the planner still knew.
pub fn depends_on_load(refusal: &Refusal) -> bool {
    use ErrorCode::{DeadlineExceeded, Overloaded, UnknownFreeSpace};
    matches!(refusal.code, DeadlineExceeded | Overloaded | UnknownFreeSpace)
}

#[cfg(test)]
mod tests;
