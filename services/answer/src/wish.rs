//! The answers that a request asks for.

use schemas::message::{Choice, ClearanceWish, Gap, Refusal};

use crate::Caps;
use crate::refuse;

/// The gaps of one answer, whichever way the request states them.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Gaps<'a> {
    /// One for all junctions.
    Same(Gap),
    /// One per junction, in travel order.
    Each(&'a [Gap]),
    /// This fraction of the greatest, in (0, 1].
    Fraction(f64),
    /// None given: the shortest motion with at least this free clearance, metres.
    AtLeast(f64),
}

/// All answers to a request.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wishes<'a> {
    clearance: &'a ClearanceWish,
    count: u32,
}

/// One of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wish<'a> {
    pub(crate) gaps: Gaps<'a>,
    clearance: &'a ClearanceWish,
    index: u32,
}

impl<'a> Wishes<'a> {
    pub(crate) fn of(clearance: &'a ClearanceWish, caps: &Caps) -> Result<Self, Refusal> {
        let (field, count) = match clearance {
            ClearanceWish::Each(choices) => ("clearance.each", choices.len() as u64),
            ClearanceWish::Curve(points) => ("clearance.curve", *points),
            _ => ("clearance", 1),
        };
        match u32::try_from(count) {
            Ok(narrow) if (1..=caps.answers).contains(&count) => {
                Ok(Self { clearance, count: narrow })
            }
            _ => Err(refuse::answers(field, count, caps.answers)),
        }
    }

    /// How many answers there are, at least 1.
    pub(crate) fn count(&self) -> u32 {
        self.count
    }

    /// Whether one refused answer is not the whole reply.
    pub(crate) fn several(&self) -> bool {
        matches!(self.clearance, ClearanceWish::Each(_) | ClearanceWish::Curve(_))
    }

    /// Whether the answers have samples.
    pub(crate) fn sampled(&self) -> bool {
        !matches!(self.clearance, ClearanceWish::Curve(_))
    }

    /// The answers, in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Wish<'a>> + use<'a> {
        let Self { clearance, count } = *self;
        let gaps = move |index: u32| match clearance {
            ClearanceWish::Gap(gap) => Gaps::Same(*gap),
            ClearanceWish::Gaps(gaps) => Gaps::Each(gaps),
            ClearanceWish::Safest => Gaps::Fraction(1.0),
            ClearanceWish::AtLeast(clearance) => Gaps::AtLeast(*clearance),
            ClearanceWish::Each(choices) => match &choices[index as usize] {
                Choice::Gap(gap) => Gaps::Same(*gap),
                Choice::Gaps(gaps) => Gaps::Each(gaps),
                Choice::Safest => Gaps::Fraction(1.0),
                Choice::AtLeast(clearance) => Gaps::AtLeast(*clearance),
            },
            ClearanceWish::Curve(points) => Gaps::Fraction(f64::from(index + 1) / *points as f64),
        };
        (0..count).map(move |index| Wish { gaps: gaps(index), clearance, index })
    }
}

impl Wish<'_> {
    /// Which part of the greatest free clearance is asked for, evenly spaced from 0 to all of it.
    pub(crate) fn part_of_safest(&self) -> f64 {
        match self.clearance {
            ClearanceWish::Curve(points) if *points > 1 => {
                f64::from(self.index) / (*points - 1) as f64
            }
            _ => 1.0,
        }
    }

    /// The field of the request that asks for this answer.
    pub(crate) fn field(&self) -> String {
        match self.clearance {
            ClearanceWish::Gap(_) => "clearance.gap".to_owned(),
            ClearanceWish::Gaps(_) => "clearance.gaps".to_owned(),
            ClearanceWish::AtLeast(_) => "clearance.at_least".to_owned(),
            ClearanceWish::Each(_) => format!("clearance.each[{}]", self.index),
            ClearanceWish::Safest | ClearanceWish::Curve(_) => "clearance".to_owned(),
        }
    }
}
