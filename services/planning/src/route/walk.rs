//! The steps of a search from junction to junction.

use super::label::{Directions, Ending, Entry, Label, NONE, number};
use super::search::{Search, lies_towards};
use super::{Mover, Router, SIGNS, STEPS_PER_WAY, UNKNOWN};
use crate::budget::Spent;
use crate::free_space::{End, Junction, all_axes, longest, proper, towards};
use crate::geometry::Direction;

impl<const D: usize, M: Mover<D>> Router<D, M> {
    /// All first steps out of a channel that contains the traveller.
    pub(super) fn start_in(
        &mut self,
        search: &Search<'_, D>,
        mover: &M,
        first: usize,
    ) -> Result<(), Spent> {
        let channel = &search.graph.channels()[first];
        let start = search.traveller.center();
        if search.ends_in(first) {
            // Any axis will do.
            self.finish(search, mover, first, NONE, 0)?;
        }
        for slot in search.graph.slots(first) {
            self.steps += 1;
            let Some(space) = search.passable(channel, slot) else { continue };
            let center = space.center();
            let possible = or_all::<D>(proper(&space, channel));
            let forced = possible.count_ones() == 1;
            for leaving in 0..D {
                let Some(axis) = longest(possible & !(1 << leaving), &start, &center) else {
                    continue;
                };
                let approach = towards(&start, &center, axis);
                for sign in SIGNS {
                    let leaving = Direction { axis: leaving, sign };
                    let junction = Junction { space, approach, leaving };
                    self.enter(search, mover, (first, slot), &junction, forced, (NONE, 0))?;
                }
            }
        }
        Ok(())
    }

    /// All steps on from a junction.
    pub(super) fn go_on(
        &mut self,
        search: &Search<'_, D>,
        mover: &M,
        index: u32,
        label: &Label<M::State>,
    ) -> Result<(), Spent> {
        let (approach, leaving) = (label.directions.approach(), label.directions.leaving());
        let (graph, before) = (search.graph, label.channel as usize);
        let here = graph.neighbour_at(label.slot as usize);
        let channel = &graph.channels()[here];
        let Some(from) = graph.channels()[before].intersection(channel) else { return Ok(()) };
        let center = from.center();
        let mine = proper(&from, channel);
        // The axis that the channel before needs.
        let taken = if label.directions.is_forced() { 1 << approach.axis } else { 0 };

        if search.ends_in(here) {
            let out = match search.traveller.end {
                End::Exit(exit) => (taken >> exit.axis & 1 == 0).then_some(exit),
                End::Goal(goal) => longest(or_all::<D>(mine) & !taken, &center, &goal)
                    .map(|axis| towards(&center, &goal, axis)),
            };
            if out == Some(leaving) {
                self.finish(search, mover, here, index, label.junctions)?;
            }
        }
        for slot in graph.slots(here) {
            self.steps += 1;
            if graph.neighbour_at(slot) == before {
                continue;
            }
            let neighbour = &graph.channels()[graph.neighbour_at(slot)];
            if !lies_towards(leaving, &center, channel, neighbour) {
                continue;
            }
            let Some(space) = search.passable(channel, slot) else { continue };
            let next = space.center();
            let possible = or_all::<D>(mine | proper(&space, channel)) & !taken;
            for axis in (0..D).filter(|axis| *axis != leaving.axis) {
                if longest(possible & !(1 << axis), &center, &next) != Some(leaving.axis) {
                    continue;
                }
                for sign in SIGNS {
                    let leaving_here = Direction { axis, sign };
                    let junction = Junction { space, approach: leaving, leaving: leaving_here };
                    let forced = possible.count_ones() == 1;
                    let from = (index, label.junctions);
                    self.enter(search, mover, (here, slot), &junction, forced, from)?;
                }
            }
        }
        Ok(())
    }

    /// Opens the label of a step into a junction, if it is useful.
    fn enter(
        &mut self,
        search: &Search<'_, D>,
        mover: &M,
        (channel, slot): (usize, usize),
        junction: &Junction<D>,
        forced: bool,
        (before, junctions): (u32, u32),
    ) -> Result<(), Spent> {
        let onwards = match self.onwards[slot] {
            UNKNOWN => {
                self.onwards[slot] = search.onwards(channel, slot)?;
                self.onwards[slot]
            }
            known => known,
        };
        if onwards >> number(junction.leaving) & 1 == 0 {
            return Ok(()); // A dead end.
        }
        search.budget.step(STEPS_PER_WAY)?;
        let steps = mover.enter(search, &self.labels, before, junction)?.into_iter().flatten();
        // Overflowing numbers do not compare, and the search would not end.
        for step in steps.filter(|step| step.estimate.is_finite()) {
            let label = Label {
                state: step.state,
                length: step.length,
                channel: channel as u32,
                slot: slot as u32,
                before,
                next: self.heads[slot],
                junctions: junctions + 1,
                directions: Directions::new(junction.approach, junction.leaving, forced),
                beaten: false,
            };
            if mover.compare(&mut self.labels, &label, &mut self.looks) {
                search.budget.hold(Self::BYTES_PER_LABEL)?;
                let index = self.labels.len() as u32;
                self.heads[slot] = index;
                let Label { junctions, slot, .. } = label;
                self.labels.push(label);
                self.open.push(Entry { estimate: step.estimate, junctions, slot, label: index });
            }
        }
        Ok(())
    }

    /// Opens the ending out of the last channel or to the goal.
    fn finish(
        &mut self,
        search: &Search<'_, D>,
        mover: &M,
        last: usize,
        before: u32,
        junctions: u32,
    ) -> Result<(), Spent> {
        let length = mover.finish(search, &self.labels, before)?;
        let Some(length) = length.filter(|length| length.is_finite()) else { return Ok(()) };
        search.budget.hold(Self::BYTES_PER_ENDING)?;
        let index = self.ends.len() as u32;
        self.ends.push(Ending { length, channel: last as u32, before });
        self.open.push(Entry { estimate: length, junctions, slot: NONE, label: index });
        Ok(())
    }

    /// A label, and that it is open.
    pub(super) const BYTES_PER_LABEL: usize = size_of::<Label<M::State>>() + size_of::<Entry>();

    /// An ending, and that it is open.
    pub(super) const BYTES_PER_ENDING: usize = size_of::<Ending>() + size_of::<Entry>();
}

fn or_all<const D: usize>(axes: u8) -> u8 {
    if axes == 0 { all_axes::<D>() } else { axes }
}
