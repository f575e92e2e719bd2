//! What would have to change for there to be a route.

use super::{RouteError, Search, Traveller};
use crate::free_space::{Chain, ChainError};
use crate::geometry::{AxisBox, Vector};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The channel that the box from `min` to `max` is least outside of: the channel,
/// the axis along which it is farthest outside, and the coordinates of its side
/// and the channel's there.
pub(super) fn nearest<const D: usize>(
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

/// A channel reached by a way that is too small by `lacks` somewhere (metres,
/// negative infinity if nowhere); the greatest comes first.
#[derive(Debug, Clone, Copy)]
struct Reached {
    lacks: f64,
    channels: usize,
    channel: usize,
}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |reached: &Self| (reached.channels, reached.channel);
        other.lacks.total_cmp(&self.lacks).then_with(|| key(other).cmp(&key(self)))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Reached {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Reached {}

/// The bottleneck: of all ways over channels that meet or touch, the one whose
/// smallest junction lacks least. `Ok`: it lacks nothing, and these channels make a chain.
pub(super) fn why_not<const D: usize>(
    search: &Search<'_, D>,
    starts: &[usize],
    most_steps: usize,
) -> Result<Vec<usize>, RouteError> {
    let channels = search.graph.channels();
    let mut before: Vec<Option<usize>> = vec![None; channels.len()];
    let mut best = vec![f64::INFINITY; channels.len()];
    let mut done = vec![false; channels.len()];
    let mut open = BinaryHeap::new();
    for &channel in starts {
        best[channel] = f64::NEG_INFINITY;
        open.push(Reached { lacks: f64::NEG_INFINITY, channels: 1, channel });
    }
    let (mut reached, mut steps) = (0, 0);
    while let Some(Reached { lacks, channels: hops, channel }) = open.pop() {
        if std::mem::replace(&mut done[channel], true) {
            continue;
        }
        reached += 1;
        if search.ends_in(channel) {
            let mut route = vec![channel];
            let mut at = channel;
            while let Some(previous) = before[at] {
                route.push(previous);
                at = previous;
            }
            route.reverse();
            return bottleneck(search, route);
        }
        let this = &channels[channel];
        search.graph.tree().visit(&this.min(), &this.max(), 0.0, |next| {
            steps += 1;
            if !done[next] {
                let (_, lack) = lack(search, this, &channels[next]);
                let lacks = lacks.max(lack);
                if lacks < best[next] {
                    best[next] = lacks;
                    before[next] = Some(channel);
                    open.push(Reached { lacks, channels: hops + 1, channel: next });
                }
            }
            if steps > most_steps { -1.0 } else { 0.0 }
        });
        if steps > most_steps {
            return Err(RouteError::TooManySteps { has: steps, most: most_steps });
        }
    }
    Err(RouteError::Separate { reached, channels: channels.len() })
}

/// By how much the junction of two channels that meet or touch is too small, and
/// along which axis most; negative infinity if it is not.
fn lack<const D: usize>(
    search: &Search<'_, D>,
    one: &AxisBox<D>,
    other: &AxisBox<D>,
) -> (usize, f64) {
    let mut worst = (0, f64::NEG_INFINITY);
    for axis in 0..D {
        let has = extent(one, other, axis);
        if search.traveller.fits_along(axis, has) {
            continue;
        }
        let lack = (search.traveller.needs_along(axis).1 - has).max(0.0);
        if lack > worst.1 {
            worst = (axis, lack);
        }
    }
    worst
}

fn extent<const D: usize>(one: &AxisBox<D>, other: &AxisBox<D>, axis: usize) -> f64 {
    one.max()[axis].min(other.max()[axis]) - one.min()[axis].max(other.min()[axis])
}

fn bottleneck<const D: usize>(
    search: &Search<'_, D>,
    route: Vec<usize>,
) -> Result<Vec<usize>, RouteError> {
    let (channels, traveller) = (search.graph.channels(), &search.traveller);
    let mut worst = (f64::NEG_INFINITY, None);
    for pair in route.windows(2) {
        let [first, second] = *pair else { continue };
        let (axis, lack) = lack(search, &channels[first], &channels[second]);
        if lack > worst.0 {
            worst = (lack, Some((first, second, axis)));
        }
    }
    let Some((first, second, axis)) = worst.1 else { return chained(search, route) };
    let has = extent(&channels[first], &channels[second], axis);
    let (needs, with_gap) = traveller.needs_along(axis);
    if has > needs && needs < with_gap {
        let (gap, most) = (traveller.gap_along(axis), (has - needs) / 2.0);
        return Err(RouteError::GapOutOfRange { first, second, axis, gap, least: 0.0, most });
    }
    Err(RouteError::JunctionTooSmall { first, second, axis, needs, has })
}

/// All junctions of the route are large enough: does it make a chain?
fn chained<const D: usize>(
    search: &Search<'_, D>,
    route: Vec<usize>,
) -> Result<Vec<usize>, RouteError> {
    let channels = search.graph.channels();
    let along: Vec<_> = route.iter().map(|index| channels[*index]).collect();
    let Traveller { end, .. } = search.traveller;
    match Chain::default().build(&along, &search.traveller.center(), end) {
        Err(ChainError::Parallel { first, second, axis }) => {
            Err(RouteError::Parallel { first: route[first], second: route[second], axis })
        }
        // Not met: junctions are not empty.
        Err(_) => Err(RouteError::NoChannels),
        Ok(()) => Ok(route),
    }
}
