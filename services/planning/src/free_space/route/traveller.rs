//! Who looks for a route.

use super::RouteError;
use crate::disassembly::Gap;
use crate::geometry::{AxisBox, Vector};

/// Something that is to find its way: where it is, the room it needs in a
/// junction, and how near the corners it keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Traveller<const D: usize> {
    /// Its corners where it starts, metres; they may be the same.
    pub(super) least: Vector<D>,
    pub(super) greatest: Vector<D>,
    /// A junction must be larger on every axis, metres.
    needs: Vector<D>,
    margin: Margin<D>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Margin<const D: usize> {
    /// (3.1) must hold.
    Gap(Vector<D>),
    /// This part of the limit of (3.1).
    Part(f64),
    /// The limit of (3.1).
    Middle,
    /// This, or up to the middle.
    UpTo(f64),
}

impl<const D: usize> Traveller<D> {
    /// A body in its assembled state that keeps this gap. Junctions where the gap
    /// is not less than the limit of (3.1) are not passed. A gap per junction is
    /// refused: which junctions there will be is not known.
    pub fn body(body: &AxisBox<D>, gap: Gap<'_, D>) -> Result<Self, RouteError> {
        let margin = match gap {
            Gap::Uniform(gap) => Margin::Gap(Vector::repeat(gap)),
            Gap::PerAxis(gaps) => Margin::Gap(gaps),
            Gap::PerJunction(gaps) => return Err(RouteError::GapPerJunction { has: gaps.len() }),
            Gap::Fraction(fraction) if !(fraction > 0.0 && fraction <= 1.0) => {
                return Err(RouteError::FractionOutOfRange { fraction, least: 0.0, most: 1.0 });
            }
            Gap::Fraction(1.0) | Gap::Safest => Margin::Middle,
            Gap::Fraction(fraction) => Margin::Part(fraction),
        };
        if let Margin::Gap(gaps) = margin {
            for axis in 0..D {
                let gap = gaps[axis];
                if gap.is_nan() || gap <= 0.0 {
                    return Err(RouteError::GapNotPositive { axis, gap, least: 0.0 });
                }
            }
        }
        Ok(Self { least: body.min(), greatest: body.max(), needs: body.size(), margin })
    }

    /// A robot whose centre is at `position`, that passes junctions larger than
    /// `needs` on every axis (metres), and turns about corners on guiding circles
    /// with this radius (equation 5.1).
    ///
    /// The route is the one with the shortest polyline through the points where
    /// the bisector of each corner cuts its guiding circle (the middle of the arc
    /// of a full quarter turn), or the middle of a junction that is too small for
    /// that, and through every junction passed. It is not always the one with the
    /// shortest taut path.
    pub fn robot(position: Vector<D>, needs: Vector<D>, radius: f64) -> Self {
        let margin = Margin::UpTo(radius * std::f64::consts::FRAC_1_SQRT_2);
        Self { least: position, greatest: position, needs, margin }
    }

    /// Its middle where it starts, metres.
    pub(super) fn center(&self) -> Vector<D> {
        (self.least + self.greatest) / 2.0
    }

    /// What it is refused for along an axis of a junction of this extent: too small
    /// by (2.5), or by (3.1) for the gap.
    pub(super) fn fits_along(&self, axis: usize, extent: f64) -> bool {
        let fits = extent > self.needs[axis];
        match &self.margin {
            Margin::Gap(gap) => fits && gap[axis] < (extent - self.needs[axis]) / 2.0,
            _ => fits,
        }
    }

    pub(super) fn fits(&self, junction: &AxisBox<D>) -> bool {
        let size = junction.size();
        (0..D).all(|axis| self.fits_along(axis, size[axis]))
    }

    /// The extent that a junction must exceed along an axis, without and with the
    /// gap asked for, metres.
    pub(super) fn needs_along(&self, axis: usize) -> (f64, f64) {
        let needs = self.needs[axis];
        match &self.margin {
            Margin::Gap(gap) => (needs, needs + 2.0 * gap[axis]),
            _ => (needs, needs),
        }
    }

    /// The gap asked for along an axis; 0 where it depends on the junction.
    pub(super) fn gap_along(&self, axis: usize) -> f64 {
        match &self.margin {
            Margin::Gap(gap) => gap[axis],
            _ => 0.0,
        }
    }

    /// The gap it keeps in a junction; `None` for the middle.
    pub(super) fn gap_in(&self, junction: &AxisBox<D>) -> Option<Vector<D>> {
        match self.margin {
            Margin::Gap(gap) => Some(gap),
            Margin::Part(part) => Some((junction.size() - self.needs) / 2.0 * part),
            Margin::Middle => None,
            Margin::UpTo(most) => Some((junction.size() / 2.0).map(|half| half.min(most))),
        }
    }
}
