//! What the search for a route keeps.

use crate::geometry::{Direction, Sign};
use std::cmp::Ordering;

/// No label, or no junction.
pub(super) const NONE: u32 = u32::MAX;

/// How a junction is passed: the directions in which it is entered and left, and whether the
/// axis of the channel before was forced. Eight bits, as there are many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Directions(u8);

impl Directions {
    pub(super) fn new(approach: Direction, leaving: Direction, forced: bool) -> Self {
        Self(number(approach) | number(leaving) << 3 | u8::from(forced) << 6)
    }

    pub(super) fn approach(self) -> Direction {
        direction(self.0 & 7)
    }

    pub(super) fn leaving(self) -> Direction {
        direction(self.0 >> 3 & 7)
    }

    pub(super) fn is_forced(self) -> bool {
        self.0 >> 6 & 1 == 1
    }
}

/// The number of a direction along one of up to three axes, from 0.
pub(super) fn number(direction: Direction) -> u8 {
    2 * direction.axis as u8 + u8::from(direction.sign == Sign::Positive)
}

fn direction(number: u8) -> Direction {
    let sign = if number & 1 == 1 { Sign::Positive } else { Sign::Negative };
    Direction { axis: usize::from(number >> 1), sign }
}

/// A way from the start into a junction.
#[derive(Debug, Clone, Copy)]
pub struct Label<S> {
    /// Where the traveller is, in terms of its motion.
    pub(super) state: S,
    /// Length until there, metres.
    pub(super) length: f64,
    /// The channel before the junction.
    pub(super) channel: u32,
    /// The junction, as the channel's slot.
    pub(super) slot: u32,
    /// The label before.
    pub(super) before: u32,
    /// The next label of this slot.
    pub(super) next: u32,
    /// The number of junctions passed.
    pub(super) junctions: u32,
    pub(super) directions: Directions,
    /// Whether another label makes it useless.
    pub(super) beaten: bool,
}

/// A way from the start to the end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ending {
    /// Metres.
    pub(super) length: f64,
    /// The last channel.
    pub(super) channel: u32,
    /// The last label; `NONE` for the start.
    pub(super) before: u32,
}

/// An open label or ending; the greatest comes first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    /// Length so far plus the least that is missing, metres.
    pub(super) estimate: f64,
    pub(super) junctions: u32,
    /// The slot of the label; `NONE` for an ending.
    pub(super) slot: u32,
    pub(super) label: u32,
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |entry: &Self| (entry.junctions, entry.slot, entry.label);
        other.estimate.total_cmp(&self.estimate).then_with(|| key(other).cmp(&key(self)))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Entry {}
