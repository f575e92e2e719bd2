//! All maximal free boxes, found by a sweep over the solids.
//!
//! Solids are taken in the order in which they begin along the last axis. The *candidates*
//! are the maximal boxes that are free of the solids taken so far and reach to the far end
//! of the bounds. A solid that reaches into a candidate splits it: into the part before the
//! solid, which no later solid can reach into and which is therefore a channel; the parts
//! beside it; and the part behind it. A part counts only if it is still maximal, that is,
//! if a solid or the bounds touch each of its sides; otherwise the box that it can be
//! extended to comes from another candidate. No box is found twice: if two candidates left
//! the same part, one would contain the other.

use super::axis::Axis;
use super::candidates::Candidates;
use super::part::{Part, RankedSolid, SIGNS};
use crate::budget::{Budget, Cap, Held, Spent};
use crate::geometry::box_tree::BoxTree;
use crate::geometry::{AxisBox, Sign, Vector};

/// Up to this many solids are checked without the index.
const FEW: usize = 16;

/// Steps that sorting one solid or channel takes.
const SORTING: u64 = 10;

/// Steps that a look at a box takes besides the one counted as [`Cap::ChannelSteps`].
const MORE_STEPS: u64 = 4;

/// Reusable memory.
#[derive(Debug, Clone, Default)]
pub(super) struct Sweep<const D: usize> {
    solids: Vec<RankedSolid<D>>,
    axes: Vec<Axis>,
    ends: Vec<(f64, u32)>,
    /// Over the solids, if more than a few sides lie in one place.
    tree: BoxTree<D>,
    candidates: Candidates<D>,
    hit: Vec<Part<D>>,
    found: Vec<Part<D>>,
    /// Boxes looked at and not yet drawn from the budget.
    steps: usize,
}

/// What stays the same during a sweep.
struct SweepTask<'a, const D: usize> {
    bounds: Part<D>,
    body: &'a Vector<D>,
    budget: &'a Budget<'a>,
}

impl<const D: usize> Sweep<D> {
    pub(super) fn run(
        &mut self,
        solids: &[AxisBox<D>],
        bounds: &AxisBox<D>,
        body: &Vector<D>,
        budget: &Budget<'_>,
        channels: &mut Vec<AxisBox<D>>,
    ) -> Result<(), Spent> {
        budget.restart(Cap::ChannelSteps);
        let _for_solids = Held::new(budget, solids.len().saturating_mul(Self::BYTES_PER_SOLID))?;
        let bounds = self.take_in(solids, bounds, budget)?;
        self.candidates.clear();
        self.found.clear();
        self.steps = 0;
        let mut held = Held::new(budget, 0)?;
        self.sweep(&SweepTask { bounds, body, budget }, &mut held)?;

        budget.step(SORTING * self.found.len() as u64)?;
        self.found.sort_unstable();
        let corner = |ranks: &[u32; D]| Vector::from_fn(|axis, _| self.axes[axis].at(ranks[axis]));
        // Cannot fail: extents are positive.
        let boxes =
            self.found.iter().flat_map(|part| AxisBox::new(corner(&part.min), corner(&part.max)));
        channels.extend(boxes);
        Ok(())
    }

    fn sweep(&mut self, scene: &SweepTask<'_, D>, held: &mut Held<'_>) -> Result<(), Spent> {
        let SweepTask { bounds, budget, .. } = scene;
        if (0..D).all(|axis| self.is_larger(bounds, axis, scene)) {
            self.insert(*bounds, scene)?;
        }
        let last = D - 1;
        for index in 0..self.solids.len() {
            let solid = self.solids[index].part;
            self.hit.clear();
            self.steps += self.candidates.take(&solid, &mut self.hit);
            for position in 0..self.hit.len() {
                let part = self.hit[position];
                let mut before = part;
                before.max[last] = solid.min[last];
                if self.is_larger(&before, last, scene)
                    && self.is_held(&before, index, scene, last)?
                {
                    self.push(before, budget)?;
                }
                for axis in 0..last {
                    for sign in SIGNS {
                        let mut beside = part;
                        match sign {
                            Sign::Negative => beside.max[axis] = solid.min[axis],
                            Sign::Positive => beside.min[axis] = solid.max[axis],
                        }
                        if self.is_larger(&beside, axis, scene)
                            && self.is_held(&beside, index, scene, axis)?
                        {
                            self.insert(beside, scene)?;
                        }
                    }
                }
                let mut behind = part;
                behind.min[last] = solid.max[last];
                if self.is_larger(&behind, last, scene)
                    && self.is_held(&behind, index, scene, last)?
                {
                    self.insert(behind, scene)?;
                }
                self.draw(budget, held)?;
            }
            self.draw(budget, held)?;
        }
        // What is left are channels up to the far end of the bounds.
        self.hit.clear();
        self.candidates.take(bounds, &mut self.hit);
        for position in 0..self.hit.len() {
            self.push(self.hit[position], budget)?;
        }
        Ok(())
    }

    /// Takes in the solids in the order of the sweep, clipped to the bounds, each once;
    /// returns the bounds.
    fn take_in(
        &mut self,
        solids: &[AxisBox<D>],
        bounds: &AxisBox<D>,
        budget: &Budget<'_>,
    ) -> Result<Part<D>, Spent> {
        budget.step(SORTING * (D + 1) as u64 * solids.len() as u64)?;
        let inside = || solids.iter().filter_map(|solid| solid.intersection(bounds));
        let unknown = Part { min: [0; D], max: [0; D] };
        self.solids.clear();
        self.solids
            .extend(inside().chain([*bounds]).map(|_| RankedSolid { turn: 0, part: unknown }));
        self.axes.resize_with(D, Axis::default);
        for (index, axis) in self.axes.iter_mut().enumerate() {
            let all = inside().chain([*bounds]);
            let extents = all.map(|solid| (solid.min()[index], solid.max()[index]));
            axis.rank(extents, &mut self.ends, |solid, sign, rank| {
                let part = &mut self.solids[solid].part;
                match sign {
                    Sign::Negative => part.min[index] = rank,
                    Sign::Positive => part.max[index] = rank,
                }
            });
        }
        let bounds = self.solids.pop().map_or(unknown, |bounds| bounds.part);
        for solid in &mut self.solids {
            let begin = u64::from(solid.part.min[D - 1]);
            solid.turn = begin << 32 | solid.part.shuffled() >> 32;
        }
        self.solids.sort_unstable();
        self.solids.dedup();
        let solids = &self.solids;
        let axes = self.axes.iter_mut().enumerate();
        let most = axes.map(|(index, axis)| axis.sort_sides(solids, index)).max();
        self.tree.clear();
        if most > Some(FEW) {
            let corner = |ranks: &[u32; D]| Vector::from(ranks.map(f64::from));
            let bounds = |index: usize| {
                let part = &solids[index].part;
                (corner(&part.min), corner(&part.max))
            };
            self.tree.build(solids.len(), bounds, budget)?;
        }
        Ok(bounds)
    }

    /// Draws what was done since the last time.
    fn draw(&mut self, budget: &Budget<'_>, held: &mut Held<'_>) -> Result<(), Spent> {
        let steps = std::mem::take(&mut self.steps) as u64;
        budget.draw(Cap::ChannelSteps, steps)?;
        budget.step(MORE_STEPS * steps)?;
        held.resize(size_of_val(&*self.found) + self.candidates.held())
    }

    /// What solids take on the way, with the index over them.
    const BYTES_PER_SOLID: usize = 67 * D + 56;

    /// The memory that it holds, bytes.
    pub(super) fn bytes(&self) -> usize {
        let solids = self.solids.capacity() * size_of::<RankedSolid<D>>();
        let ends = self.ends.capacity() * size_of::<(f64, u32)>();
        let parts = (self.hit.capacity() + self.found.capacity()) * size_of::<Part<D>>();
        let axes = self.axes.iter().map(Axis::bytes).sum::<usize>();
        solids + ends + parts + axes + self.tree.bytes() + self.candidates.bytes()
    }

    /// What it holds, bytes: for the solids without and with the index over them, and
    /// for each channel.
    #[cfg(test)]
    pub(super) fn memory(&self) -> [usize; 3] {
        let solids = size_of_val(&*self.solids) + size_of_val(&*self.ends);
        let solids = solids + self.axes.iter().map(Axis::memory).sum::<usize>();
        let tree = self.tree.memory();
        [solids, solids + tree, size_of::<Part<D>>()]
    }

    /// Whether a part is larger than the body along an axis.
    fn is_larger(&self, part: &Part<D>, axis: usize, scene: &SweepTask<'_, D>) -> bool {
        let at = |rank| self.axes[axis].at(rank);
        at(part.max[axis]) - at(part.min[axis]) > scene.body[axis].max(0.0)
    }

    fn push(&mut self, part: Part<D>, budget: &Budget<'_>) -> Result<(), Spent> {
        budget.check(Cap::Channels, self.found.len() + 1)?;
        self.found.push(part);
        Ok(())
    }

    /// Whether a part left by the solid `newest` is touched on every side by a solid taken so
    /// far or by the bounds.
    ///
    /// The sides across `cut`, where it was cut, need no check, nor does the far side along
    /// the sweep.
    fn is_held(
        &mut self,
        part: &Part<D>,
        newest: usize,
        scene: &SweepTask<'_, D>,
        cut: usize,
    ) -> Result<bool, Spent> {
        for axis in (0..D).filter(|axis| *axis != cut) {
            let signs = if axis == D - 1 { &SIGNS[..1] } else { &SIGNS };
            for sign in signs {
                if !self.is_touched(part, newest, scene, axis, *sign)? {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Whether a solid up to `newest`, or the bounds, touches this side of a part.
    fn is_touched(
        &mut self,
        part: &Part<D>,
        newest: usize,
        scene: &SweepTask<'_, D>,
        axis: usize,
        sign: Sign,
    ) -> Result<bool, Spent> {
        let at = part.side(axis, sign);
        if at == scene.bounds.side(axis, sign) {
            return Ok(true);
        }
        let facing = self.axes[axis].facing(sign, at);
        if facing.len() <= FEW {
            // A solid that reached further would reach into the part.
            let touches = |index: &u32| {
                let solid = &self.solids[*index as usize].part;
                *index as usize <= newest
                    && (0..D).all(|other| other == axis || solid.overlaps(part, other))
            };
            let found = facing.iter().any(touches);
            self.steps += facing.len();
            return Ok(found);
        }
        let (mut min, mut max) = (part.min, part.max);
        // No solid taken so far begins later.
        let last = D - 1;
        max[last] = max[last].min(min[last].max(self.solids[newest].part.min[last]));
        (min[axis], max[axis]) = (at, at);
        let [min, max] = [min, max].map(|ranks| Vector::from(ranks.map(f64::from)));
        let (solids, steps) = (&self.solids, &mut self.steps);
        let mut found = false;
        self.tree.visit(&min, &max, 0.0, scene.budget, |index| {
            *steps += 1;
            let solid = &solids[index].part;
            let goes_on = match sign {
                Sign::Negative => solid.min[axis] < at && at <= solid.max[axis],
                Sign::Positive => solid.min[axis] <= at && at < solid.max[axis],
            };
            found = index <= newest
                && goes_on
                && (0..D).all(|other| other == axis || solid.overlaps(part, other));
            if found { -1.0 } else { 0.0 }
        })?;
        Ok(found)
    }

    fn insert(&mut self, part: Part<D>, scene: &SweepTask<'_, D>) -> Result<(), Spent> {
        self.candidates.insert(part, &scene.bounds, scene.budget)
    }
}
