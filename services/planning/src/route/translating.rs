//! The mover of a body: it translates by Table 1.

use super::label::Label;
use super::mover::{Mover, SearchStep};
use super::traveller::Traveller;
use super::{RouteError, Search};
use crate::budget::Spent;
use crate::disassembly::{Gap, out_of_the_mouth, target};
use crate::free_space::{End, Junction};
use crate::geometry::{AxisBox, Vector};

/// A body that translates into every junction by a rule of Table 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyMover<const D: usize> {
    traveller: Traveller<D>,
    margin: KeptGap,
}

/// The gap kept in a junction.
#[derive(Debug, Clone, Copy, PartialEq)]
enum KeptGap {
    /// The traveller's gap; (3.1) must hold.
    Gap,
    /// This part of the limit in (3.1).
    Part(f64),
    /// The limit in (3.1).
    Middle,
    /// This many metres, or the middle if there is less.
    UpTo(f64),
}

impl<const D: usize> BodyMover<D> {
    /// A body in its assembled state that keeps this gap. It does not pass junctions where
    /// the gap is not less than the limit in (3.1). Gaps per junction are an error, since the
    /// junctions are not known yet.
    pub fn new(body: &AxisBox<D>, gap: Gap<'_, D>, end: End<D>) -> Result<Self, RouteError> {
        let (margin, gap) = match gap {
            Gap::Uniform(gap) => (KeptGap::Gap, Vector::repeat(gap)),
            Gap::PerAxis(gaps) => (KeptGap::Gap, gaps),
            Gap::PerJunction(gaps) => return Err(RouteError::GapPerJunction { has: gaps.len() }),
            Gap::Fraction(fraction) if !(fraction > 0.0 && fraction <= 1.0) => {
                return Err(RouteError::FractionOutOfRange { fraction, least: 0.0, most: 1.0 });
            }
            Gap::Fraction(1.0) | Gap::Safest => (KeptGap::Middle, Vector::zeros()),
            Gap::Fraction(fraction) => (KeptGap::Part(fraction), Vector::zeros()),
        };
        if margin == KeptGap::Gap {
            for axis in 0..D {
                let gap = gap[axis];
                if gap.is_nan() || gap <= 0.0 {
                    return Err(RouteError::GapNotPositive { axis, gap, least: 0.0 });
                }
            }
        }
        let (least, greatest) = (body.min(), body.max());
        let traveller = Traveller { least, greatest, needs: body.size(), gap, end };
        Ok(Self { traveller, margin })
    }

    /// A traveller without extent that stays this far from the corners along every axis, metres,
    /// or in the middle if there is less.
    pub(super) fn with_margin(traveller: Traveller<D>, margin: f64) -> Self {
        Self { traveller, margin: KeptGap::UpTo(margin) }
    }

    /// The gap it keeps in a junction; `None` for the middle.
    fn gap_in(&self, junction: &AxisBox<D>) -> Option<Vector<D>> {
        match self.margin {
            KeptGap::Gap => Some(self.traveller.gap),
            KeptGap::Part(part) => Some((junction.size() - self.traveller.needs) / 2.0 * part),
            KeptGap::Middle => None,
            KeptGap::UpTo(most) => Some((junction.size() / 2.0).map(|half| half.min(most))),
        }
    }

    /// The end of a path that comes from `from`.
    fn destination(&self, search: &Search<'_, D>, from: &Vector<D>) -> Vector<D> {
        let Traveller { least, greatest, .. } = &self.traveller;
        match (self.traveller.end, &search.mouth) {
            (End::Goal(goal), _) => goal - self.traveller.center(),
            (End::Exit(_), Some(mouth)) => out_of_the_mouth((least, greatest), mouth, *from),
            (End::Exit(_), None) => *from,
        }
    }
}

/// Displacement and length so far.
fn so_far<const D: usize>(labels: &[Label<Vector<D>>], from: u32) -> (Vector<D>, f64) {
    labels.get(from as usize).map_or((Vector::zeros(), 0.0), |label| (label.state, label.length))
}

impl<const D: usize> Mover<D> for BodyMover<D> {
    /// The displacement from the assembled state, metres.
    type State = Vector<D>;

    fn traveller(&self) -> &Traveller<D> {
        &self.traveller
    }

    fn enter(
        &self,
        search: &Search<'_, D>,
        labels: &[Label<Vector<D>>],
        from: u32,
        junction: &Junction<D>,
    ) -> Result<[Option<SearchStep<Vector<D>>>; 2], Spent> {
        let Traveller { least, greatest, .. } = &self.traveller;
        let (from, length) = so_far(labels, from);
        let gap = self.gap_in(&junction.space);
        let (at, _) = target(junction, (least, greatest), gap.as_ref(), &from);
        let length = length + (at - from).norm();
        // The straight line to the mouth or the goal.
        let missing = (self.destination(search, &at) - at).norm();
        Ok([Some(SearchStep { state: at, length, estimate: length + missing }), None])
    }

    fn finish(
        &self,
        search: &Search<'_, D>,
        labels: &[Label<Vector<D>>],
        from: u32,
    ) -> Result<Option<f64>, Spent> {
        let (from, length) = so_far(labels, from);
        Ok(Some(length + (self.destination(search, &from) - from).norm()))
    }

    /// In three dimensions the idle coordinate of a rule depends on the whole way before. So a
    /// way is beaten only if it is longer by more than the distance between the two places,
    /// which the other could bridge at once.
    fn compare(
        &self,
        labels: &mut [Label<Vector<D>>],
        new: &Label<Vector<D>>,
        looks: &mut usize,
    ) -> bool {
        let mut at = new.next;
        while let Some(known) = labels.get_mut(at as usize) {
            at = known.next;
            *looks += 1;
            if known.directions == new.directions && !known.beaten {
                let apart = (known.state - new.state).abs().sum();
                if known.length + apart <= new.length {
                    return false;
                }
                known.beaten = new.length + apart <= known.length;
            }
        }
        true
    }
}
