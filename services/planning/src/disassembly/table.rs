//! Table 1, corrected (`docs/errata.md`): the side of a junction at which a rule puts the body.

use crate::geometry::{Direction, Sign};
use crate::motion::Rule;

/// The side of the junction that the body keeps its gap to, along one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Margin {
    /// `min M = min J + gap`.
    Least,
    /// `max M = max J - gap`.
    Greatest,
}

impl Margin {
    const LEFT: Self = Self::Least;
    const RIGHT: Self = Self::Greatest;
    const DOWN: Self = Self::Least;
    const UP: Self = Self::Greatest;
}

/// A rule, with the coordinates of its plane filled in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Turn {
    pub(super) rule: Rule,
    /// The horizontal coordinate of the plane, and the margin on it.
    pub(super) horizontal: (usize, Margin),
    /// The vertical coordinate of the plane, and the margin on it.
    pub(super) vertical: (usize, Margin),
}

const LEFT: Sign = Sign::Negative;
const RIGHT: Sign = Sign::Positive;
const DOWN: Sign = Sign::Negative;
const UP: Sign = Sign::Positive;

/// The rule for passing a junction between two channels along different axes.
///
/// In two dimensions the plane is (x, z). In three dimensions rules 1 to 8 apply in (x, z), 9
/// to 16 are the same in (y, z), and 17 to 24 the same in (x, y).
pub(super) fn turn_in<const D: usize>(approach: Direction, leaving: Direction) -> Turn {
    let horizontal = approach.axis.min(leaving.axis);
    let vertical = approach.axis.max(leaving.axis);
    // Rules 1 to 4 are the paper's, with the second condition of 3 and 4 on x. Rules 5 to 8
    // are for motion in the negative z direction, which (3.2) excludes.
    let (number, left_or_right, down_or_up) = if approach.axis == vertical {
        match (approach.sign, leaving.sign) {
            (UP, LEFT) => (1, Margin::LEFT, Margin::DOWN),
            (UP, RIGHT) => (2, Margin::RIGHT, Margin::DOWN),
            (DOWN, LEFT) => (5, Margin::LEFT, Margin::UP),
            (DOWN, RIGHT) => (6, Margin::RIGHT, Margin::UP),
        }
    } else {
        match (approach.sign, leaving.sign) {
            (LEFT, UP) => (3, Margin::RIGHT, Margin::UP),
            (RIGHT, UP) => (4, Margin::LEFT, Margin::UP),
            (LEFT, DOWN) => (7, Margin::RIGHT, Margin::DOWN),
            (RIGHT, DOWN) => (8, Margin::LEFT, Margin::DOWN),
        }
    };
    #[cfg(all(feature = "altered-rules", debug_assertions))]
    let left_or_right = match (crate::altered::is_altered(number), left_or_right) {
        (true, Margin::Least) => Margin::Greatest,
        (true, Margin::Greatest) => Margin::Least,
        (false, by_table) => by_table,
    };
    let plane = match (D, horizontal, vertical) {
        (3, 1, 2) => 1,
        (3, 0, 1) => 2,
        _ => 0,
    };
    Turn {
        rule: Rule { table: 1, number: plane * 8 + number },
        horizontal: (horizontal, left_or_right),
        vertical: (vertical, down_or_up),
    }
}
