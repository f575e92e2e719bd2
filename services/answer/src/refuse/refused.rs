//! A refusal, and how much of the request it refuses.

use planning::budget::Spent;
use schemas::message::{ErrorCode, Refusal};

use super::cost;
use crate::stop::StopFlag;

/// What is missing counts as rounding up to this part of what is needed.
const ROUNDING: f64 = 1e-8;

/// Why an answer is refused, and how much of the request with it.
#[derive(Debug)]
pub(crate) enum Refused {
    /// This answer; another gap may do.
    Answer(Refusal),
    /// The request as a whole: no gap would help.
    Request(Refusal),
    /// The request's budget has ended.
    Spent(Spent),
}

impl From<Refusal> for Refused {
    fn from(refusal: Refusal) -> Self {
        Self::Answer(refusal)
    }
}

impl From<Spent> for Refused {
    fn from(spent: Spent) -> Self {
        Self::Spent(spent)
    }
}

impl Refused {
    /// A refusal that refuses the request as a whole, or one answer only.
    pub(super) fn new(refusal: Refusal, whole: bool) -> Self {
        if whole { Self::Request(refusal) } else { Self::Answer(refusal) }
    }

    /// The same, for the request as a whole.
    pub(crate) fn whole(self) -> Self {
        match self {
            Self::Answer(refusal) => Self::Request(refusal),
            whole => whole,
        }
    }

    /// Whether the answers that follow would be refused for the same reason.
    pub(crate) fn is_whole(&self) -> bool {
        matches!(self, Self::Request(_)) || self.is_final()
    }

    /// Whether nothing is left for the answers that follow.
    pub(crate) fn is_final(&self) -> bool {
        matches!(self, Self::Spent(spent) if cost::is_final(spent))
    }

    /// Whether all that is missing is less than rounding: a part may fit exactly.
    pub(crate) fn is_for_rounding(&self) -> bool {
        let (Self::Answer(refusal) | Self::Request(refusal)) = self else { return false };
        let Refusal { code, needs, has, .. } = refusal;
        let (needs, has) = match code {
            ErrorCode::NoRoute | ErrorCode::JunctionTooSmall => (*needs, *has),
            // It reaches so deep into a solid.
            ErrorCode::BodyOutsideFreeSpace if needs.is_none() => (*has, Some(0.0)),
            ErrorCode::BodyOutsideFreeSpace => (*needs, *has),
            _ => return false,
        };
        match (needs, has) {
            (Some(needs), Some(has)) => (needs - has).abs() <= ROUNDING * needs.abs().max(1e-3),
            _ => false,
        }
    }

    /// The same, or nothing says how much is missing: there is no route for a union of boxes.
    pub(crate) fn may_be_for_rounding(&self, is_union: bool) -> bool {
        let (Self::Answer(refusal) | Self::Request(refusal)) = self else { return false };
        self.is_for_rounding()
            || (is_union && refusal.code == ErrorCode::NoRoute && refusal.needs.is_none())
    }

    /// What the reply says. `stop` knows why a request was stopped.
    pub(crate) fn into_refusal(self, stop: &StopFlag) -> Refusal {
        match self {
            Self::Answer(refusal) | Self::Request(refusal) => refusal,
            Self::Spent(spent) => cost::spent(spent, stop.reason()),
        }
    }
}
