//! The task of a search: junctions that a traveller passes, from its start to the end.

use super::label::number;
use super::{RouteError, SIGNS, Traveller};
use crate::budget::{Budget, Spent};
use crate::free_space::graph::Graph;
use crate::free_space::walls::Walls;
use crate::free_space::{End, mouth_of};
use crate::geometry::{AxisBox, Direction, HalfSpace, Sign, Vector};

/// Channels whose direction is checked in one step.
const OTHERS_PER_STEP: u64 = 16;

/// A task for a search.
pub struct Search<'a, const D: usize> {
    pub(super) graph: &'a Graph<D>,
    pub(super) traveller: Traveller<D>,
    /// For an exit, where the channels that reach farthest along it end.
    pub(super) mouth: Option<HalfSpace>,
    /// The walls, if they are known before the search.
    pub(super) walls: Option<&'a Walls<D>>,
    pub(super) budget: &'a Budget<'a>,
}

/// The mouth of the channels that reach farthest along the exit.
pub(super) fn farthest<const D: usize>(
    channels: &[AxisBox<D>],
    exit: Direction,
) -> Option<HalfSpace> {
    let mouths = channels.iter().map(|channel| mouth_of(channel, exit));
    let reach = |mouth: &HalfSpace| exit.sign.factor() * mouth.bound;
    mouths.reduce(|a, b| if reach(&b) > reach(&a) { b } else { a })
}

impl<const D: usize> Search<'_, D> {
    /// Refills `starts` with the channels that the traveller is in, in ascending order.
    pub(super) fn find_starts(&self, starts: &mut Vec<usize>) -> Result<(), RouteError> {
        let channels = self.graph.channels();
        // What sticks out of the mouth is free.
        let [least, greatest] = [self.traveller.least, self.traveller.greatest]
            .map(|corner| self.mouth.map_or(corner, |mouth| mouth.nearest(corner)));
        starts.clear();
        self.graph.tree().visit(&least, &least, 0.0, self.budget, |index| {
            if channels[index].holds(&least) && channels[index].holds(&greatest) {
                starts.push(index);
            }
            0.0
        })?;
        starts.sort_unstable();
        if starts.is_empty() {
            self.budget.step(channels.len() as u64)?;
            let Traveller { least, greatest, .. } = &self.traveller;
            let (channel, axis, body, end) = nearest(channels, least, greatest);
            return Err(RouteError::StartOutside { channel, axis, body, end });
        }
        Ok(())
    }

    pub(super) fn check_goal(&self) -> Result<(), RouteError> {
        let End::Goal(goal) = self.traveller.end else { return Ok(()) };
        let channels = self.graph.channels();
        let mut found = false;
        self.graph.tree().visit(&goal, &goal, 0.0, self.budget, |_| {
            found = true;
            -1.0
        })?;
        if !found {
            self.budget.step(channels.len() as u64)?;
            let (channel, axis, goal, end) = nearest(channels, &goal, &goal);
            return Err(RouteError::GoalOutside { channel, axis, goal, end });
        }
        Ok(())
    }

    pub(super) fn ends_in(&self, index: usize) -> bool {
        let channel = &self.graph.channels()[index];
        match self.traveller.end {
            End::Exit(exit) => Some(mouth_of(channel, exit)) == self.mouth,
            End::Goal(goal) => channel.holds(&goal),
        }
    }

    /// The directions, as bits, in which another junction or the end lies in the channel
    /// behind a slot.
    pub(super) fn onwards(&self, before: usize, slot: usize) -> Result<u8, Spent> {
        let (graph, here) = (self.graph, self.graph.neighbour_at(slot));
        let directions = (0..D).flat_map(|axis| SIGNS.map(|sign| Direction { axis, sign }));
        if self.ends_in(here) {
            return Ok(directions.fold(0, |bits, direction| bits | 1 << number(direction)));
        }
        let channel = &graph.channels()[here];
        let Some(junction) = graph.channels()[before].intersection(channel) else { return Ok(0) };
        let center = junction.center();
        let mut others = 0;
        let mut onwards = 0;
        for direction in directions {
            let leads_on = graph.slots(here).any(|slot| {
                others += 1;
                let other = graph.neighbour_at(slot);
                other != before
                    && lies_towards(direction, &center, channel, &graph.channels()[other])
            });
            onwards |= u8::from(leads_on) << number(direction);
        }
        self.budget.step(1 + others / OTHERS_PER_STEP)?;
        Ok(onwards)
    }

    /// The junction of a channel with its neighbour, if the traveller fits.
    pub(super) fn passable(&self, channel: &AxisBox<D>, slot: usize) -> Option<AxisBox<D>> {
        let next = &self.graph.channels()[self.graph.neighbour_at(slot)];
        channel.intersection(next).filter(|junction| self.traveller.fits(junction))
    }
}

/// Whether the centre of the junction of two channels lies in that direction from `center`.
pub(super) fn lies_towards<const D: usize>(
    direction: Direction,
    center: &Vector<D>,
    one: &AxisBox<D>,
    other: &AxisBox<D>,
) -> bool {
    let Direction { axis, sign } = direction;
    let (min, max) =
        (one.min()[axis].max(other.min()[axis]), one.max()[axis].min(other.max()[axis]));
    Sign::of((min + max) / 2.0 - center[axis]) == sign
}

/// The channel that the box from `min` to `max` sticks out of least: its index, the axis along
/// which the box sticks out most, and the coordinates of the box's and the channel's side.
fn nearest<const D: usize>(
    channels: &[AxisBox<D>],
    min: &Vector<D>,
    max: &Vector<D>,
) -> (usize, usize, f64, f64) {
    let mut best = (f64::INFINITY, (0, 0, min[0], min[0]));
    for (index, channel) in channels.iter().enumerate() {
        let mut worst = (f64::NEG_INFINITY, (index, 0, min[0], min[0]));
        for axis in 0..D {
            let (low, high) = (channel.min()[axis], channel.max()[axis]);
            for (outside, side, end) in
                [(low - min[axis], min[axis], low), (max[axis] - high, max[axis], high)]
            {
                if outside > worst.0 {
                    worst = (outside, (index, axis, side, end));
                }
            }
        }
        if worst.0 < best.0 {
            best = worst;
        }
    }
    best.1
}
