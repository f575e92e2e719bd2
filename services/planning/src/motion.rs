//! What a body does: legs, in order, each a line, an arc or a turn in place.

use std::f64::consts::{PI, TAU};

use crate::geometry::Vector;

/// A rule of the paper, by table and number (numbering: `docs/errata.md`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Rule {
    /// 1: part assembly (section 3); 2: mobile robot (section 5).
    pub table: u8,
    /// Number of the rule in its table, from 1.
    pub number: u8,
}

/// The curve that the body's reference point follows, and how the body turns on it.
///
/// Positions are metres, angles radians counter-clockwise from +x. In assembly
/// tasks positions are displacements from the assembled state and headings are 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Curve<const D: usize> {
    /// A straight segment.
    Line {
        /// Where it begins.
        from: Vector<D>,
        /// Where it ends.
        to: Vector<D>,
        /// Heading at its end, in (-pi, pi].
        heading: f64,
        /// Signed angle turned on the way, evenly over the length; 0 but for the
        /// paper's turn while moving to the first arriving point.
        turned: f64,
    },
    /// A part of a guiding circle (equation 5.1), in the first two coordinates,
    /// the heading tangent to it.
    Arc {
        /// Centre of the circle.
        center: Vector<D>,
        /// Its radius rho.
        radius: f64,
        /// Angle from the centre to the arriving point, in (-pi, pi].
        start_angle: f64,
        /// Signed angle run through; positive turns left.
        sweep: f64,
    },
    /// A turn in place.
    Turn {
        /// Where.
        position: Vector<D>,
        /// Heading before, in (-pi, pi].
        from_heading: f64,
        /// Signed angle turned; positive turns left.
        sweep: f64,
    },
}

impl<const D: usize> Curve<D> {
    /// Arc length of the reference point's path, metres; 0 for a turn in place.
    pub fn length(&self) -> f64 {
        match self {
            Self::Line { from, to, .. } => (to - from).norm(),
            Self::Arc { radius, sweep, .. } => radius * sweep.abs(),
            Self::Turn { .. } => 0.0,
        }
    }
}

/// One piece of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leg<const D: usize> {
    /// The curve followed.
    pub curve: Curve<D>,
    /// Junction (counted from 0 in travel order) that the leg leads to or turns
    /// in; `None` for what comes after the last one.
    pub junction: Option<usize>,
    /// The rule that chose where the leg ends; `None` where no rule did.
    pub rule: Option<Rule>,
}

/// `angle`, radians, reduced to (-pi, pi] and without a negative zero.
#[inline]
pub fn wrapped(angle: f64) -> f64 {
    let mut angle = angle + 0.0;
    if angle > PI {
        angle -= TAU;
    } else if angle <= -PI {
        angle += TAU;
    }
    if angle.abs() > PI { reduced(angle) } else { angle }
}

/// The reduction of an angle more than one turn away.
#[cold]
fn reduced(angle: f64) -> f64 {
    let angle = angle - TAU * libm::round(angle / TAU);
    if angle <= -PI { PI } else { angle.min(PI) }
}
