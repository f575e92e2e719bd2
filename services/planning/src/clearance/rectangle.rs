//! Exact clearance of the rectangular robot over lines, arcs and turns in place.
//!
//! Nothing is sampled. While body and wall are apart, the least distance between
//! them is met between a corner of one and an edge or a corner of the other, and
//! each of these pairs moves on a line or on a circle about the guiding circle's
//! centre: finitely many candidates. Only for a robot that turns while moving
//! the candidates have no closed form; that case is a bounded search
//! ([`TURNING_WHILE_MOVING_BOUND`]).

use thiserror::Error;

use crate::budget::{Budget, Spent};
use crate::clearance::Clearance;
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::Vector;
use crate::motion::Curve;

mod moving;
mod segment;
mod slide;
mod swing;

/// Distances that differ by less than this are one distance, metres: the place
/// reported is the first that comes so close to the least distance.
pub const TIE: f64 = 1e-12;

/// The greatest error of the clearance over a line on which the body also
/// turns, metres; every other clearance is exact to rounding.
pub const TURNING_WHILE_MOVING_BOUND: f64 = 1e-9;

/// The rectangle that a mobile robot covers; its reference point is the centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    width: f64,
    length: f64,
}

/// Why two sides do not make a [`Footprint`].
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("a footprint needs positive sides: width {width} m, length {length} m")]
pub struct FootprintError {
    /// Extent across the heading, metres.
    pub width: f64,
    /// Extent along the heading, metres.
    pub length: f64,
}

impl Footprint {
    /// The rectangle `width` across (the paper's w) and `length` along the
    /// heading (the paper's h), metres; both must be positive and finite.
    pub fn new(width: f64, length: f64) -> Result<Self, FootprintError> {
        let positive = |side: f64| side > 0.0 && side.is_finite();
        if positive(width) && positive(length) {
            Ok(Self { width, length })
        } else {
            Err(FootprintError { width, length })
        }
    }

    /// Extent across the heading, metres.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Extent along the heading, metres.
    pub fn length(&self) -> f64 {
        self.length
    }
}

/// The least distance over a motion and where it is met first. No wall yet:
/// infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Met {
    /// The least distance, metres.
    pub(crate) value: f64,
    /// Where it is met: part of the leg run through, or arc length of the motion.
    pub(crate) along: f64,
    /// The wall point.
    pub(crate) wall: Vector<2>,
    /// Distance at `along`; within [`TIE`] of `value`.
    there: f64,
}

impl Met {
    pub(crate) const NOTHING: Self = Self {
        value: f64::INFINITY,
        along: 0.0,
        wall: Vector::<2>::new(0.0, 0.0),
        there: f64::INFINITY,
    };

    /// Whether a distance can change the answer.
    fn wants(&self, value: f64) -> bool {
        value <= self.value + TIE
    }

    /// Takes a distance that occurs into account.
    pub(crate) fn offer(&mut self, value: f64, along: f64, wall: Vector<2>) {
        if !self.wants(value) {
            return;
        }
        self.value = self.value.min(value);
        if self.there > self.value + TIE || along < self.along {
            (self.there, self.along, self.wall) = (value, along, wall);
        }
    }

    pub(crate) fn clearance(&self) -> Option<Clearance<2>> {
        self.value.is_finite().then_some(Clearance {
            value: self.value,
            at: self.along,
            wall: self.wall,
        })
    }
}

/// Distance of the body at rest to the walls; `None` where there are none.
/// Heading in radians counter-clockwise from +x.
pub fn over_placement(
    footprint: &Footprint,
    position: &Vector<2>,
    heading: f64,
    walls: &Walls<2>,
    budget: &Budget<'_>,
) -> Result<Option<Clearance<2>>, Spent> {
    let curve = Curve::Line { from: *position, to: *position, heading, turned: 0.0 };
    over_curve(footprint, &curve, walls, budget)
}

/// Clearance over one curve; `None` where there are no walls. Lines are
/// travelled along the heading; over a turn in place `at` is 0.
pub fn over_curve(
    footprint: &Footprint,
    curve: &Curve<2>,
    walls: &Walls<2>,
    budget: &Budget<'_>,
) -> Result<Option<Clearance<2>>, Spent> {
    let guess = footprint.width.max(footprint.length);
    let mut met = nearest(footprint, curve, walls, guess, budget)?;
    met.along *= curve.length();
    Ok(met.clearance())
}

/// The next leg begins where this one ends, so it comes about as close.
pub(crate) fn next_guess(met: &Met, guess: f64) -> f64 {
    if met.value.is_finite() { 1.5 * met.value + 0.01 } else { guess }
}

/// The least distance over one curve, `along` as the part of it run through.
/// `guess`: how far to look for walls at first, metres; the result does not
/// depend on it.
pub(crate) fn nearest(
    footprint: &Footprint,
    curve: &Curve<2>,
    walls: &Walls<2>,
    guess: f64,
    budget: &Budget<'_>,
) -> Result<Met, Spent> {
    let near = (walls, guess, budget);
    match *curve {
        Curve::Line { from, to, heading, turned } => {
            if turned == 0.0 {
                let slide = slide::Slide::new(footprint, &from, &to, heading);
                search(near, slide.bounds(), |wall, met| {
                    slide.meet(wall, met);
                    Ok(())
                })
            } else {
                let moving = moving::Moving::new(footprint, &from, &to, heading, turned);
                search(near, moving.bounds(), |wall, met| moving.meet(wall, met, budget))
            }
        }
        Curve::Arc { center, radius, start_angle, sweep } => {
            let swing = swing::Swing::on_arc(footprint, &center, radius, start_angle, sweep);
            search(near, swing.bounds(), |wall, met| {
                swing.meet(wall, met);
                Ok(())
            })
        }
        Curve::Turn { position, from_heading, sweep } => {
            let swing = swing::Swing::in_place(footprint, &position, from_heading, sweep);
            search(near, swing.bounds(), |wall, met| {
                swing.meet(wall, met);
                Ok(())
            })
        }
    }
}

/// Meets all walls that are near enough to matter. Walls farther than the guess
/// are left out at first, so an answer within the guess is the answer.
fn search(
    (walls, guess, budget): (&Walls<2>, f64, &Budget<'_>),
    (min, max): (Vector<2>, Vector<2>),
    meet: impl Fn(&Wall<2>, &mut Met) -> Result<(), Spent>,
) -> Result<Met, Spent> {
    let mut met = Met::NOTHING;
    let mut spent = Ok(());
    walls.near(&min, &max, guess, budget, |_, wall| {
        if spent.is_ok() {
            spent = meet(wall, &mut met);
        }
    })?;
    if met.value > guess {
        met = Met::NOTHING;
        walls.nearest(&min, &max, budget, |_, wall| {
            spent = meet(wall, &mut met);
            if spent.is_ok() { met.value + TIE } else { -1.0 }
        })?;
    }
    spent.map(|()| met)
}

#[cfg(test)]
pub(crate) mod tests;
