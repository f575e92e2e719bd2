//! Which sums lie beside a line, told from what they are sums of.

use super::Shift;
use crate::geometry::Vector;
use crate::geometry::distance::cross;

/// What a bound on a part of a shift is raised by, for rounding.
const ROUNDING: f64 = 1e-9;

/// From where to where something lies, seen along a shift: to its left, and ahead, both as multiples
/// of its length, square metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    left: [f64; 2],
    ahead: [f64; 2],
}

impl Span {
    const NOTHING: Self = Self {
        left: [f64::INFINITY, f64::NEG_INFINITY],
        ahead: [f64::INFINITY, f64::NEG_INFINITY],
    };

    /// Of points, metres.
    pub(super) fn of(points: &[Vector<2>], shift: &Shift) -> Self {
        let along = shift.along();
        points.iter().fold(Self::NOTHING, |Self { left, ahead }, point| Self {
            left: with(left, cross(along, point)),
            ahead: with(ahead, along.dot(point)),
        })
    }

    /// Of the sum of two.
    fn plus(&self, other: &Self) -> Self {
        let sum = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a + c, b + d];
        Self { left: sum(self.left, other.left), ahead: sum(self.ahead, other.ahead) }
    }
}

/// Smaller and quicker than what minds numbers that are none.
fn with([low, high]: [f64; 2], at: f64) -> [f64; 2] {
    [if at < low { at } else { low }, if at > high { at } else { high }]
}

/// How far the pieces of a body reach across a shift of it, and along it.
#[derive(Debug)]
pub(super) struct Spans {
    /// Of each piece with the margin around it, seen from where the shift begins.
    each: Vec<Span>,
    /// To the left, of all of them together.
    left: [f64; 2],
    /// What rounding may add up to.
    guard: f64,
    /// The length of the shift, squared.
    square: f64,
}

impl Spans {
    pub(super) fn new() -> Self {
        Self { each: Vec::new(), left: Span::NOTHING.left, guard: 0.0, square: 0.0 }
    }

    /// Looks along another shift, for pieces and what is around each, and so much rounding, all in
    /// metres.
    pub(super) fn look_along(
        &mut self,
        shift: &Shift,
        (pieces, around): (&[Vec<Vector<2>>], &[Vector<2>]),
        rounding: f64,
    ) {
        let from = Span::of(&[-shift.from], shift).plus(&Span::of(around, shift));
        self.each.clear();
        self.left = Span::NOTHING.left;
        for piece in pieces {
            let span = Span::of(piece, shift).plus(&from);
            self.left = with(with(self.left, span.left[0]), span.left[1]);
            self.each.push(span);
        }
        self.guard = rounding * shift.length();
        self.square = shift.length() * shift.length();
    }

    /// Whether the shift surely passes by the sums of all pieces and something.
    pub(super) fn are_passed_by(&self, one: &Span) -> bool {
        self.is_beside(self.left, one.left)
    }

    /// The most of the shift that may be in the sum of a piece and something; `None` where it surely
    /// passes by.
    pub(super) fn most_within(&self, piece: usize, one: &Span) -> Option<f64> {
        let span = &self.each[piece];
        if self.is_beside(span.left, one.left) {
            return None;
        }
        let [low, high] = span.plus(one).ahead.map(|at| at / self.square);
        // All of it where it has no length.
        Some((high.min(1.0) - low.max(0.0)) * (1.0 + ROUNDING) + ROUNDING)
    }

    fn is_beside(&self, one: [f64; 2], other: [f64; 2]) -> bool {
        one[0] + other[0] > self.guard || one[1] + other[1] < -self.guard
    }
}
