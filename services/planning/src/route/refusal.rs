//! Finds out why there is no route, and what would have to change.

use super::widest::{Change, Space, Unknown, extent};
use super::{RouteError, Search};
use crate::free_space::{Chain, ChainError};

/// The error that names the worst junction on the best way. `Ok` if nothing is wrong with its
/// junctions: then its channels, which make a chain.
pub(super) fn why_not<const D: usize>(
    search: &Search<'_, D>,
    starts: &[usize],
) -> Result<Vec<usize>, RouteError> {
    let (channels, traveller) = (search.graph.channels(), &search.traveller);
    let space = Space { channels, tree: search.graph.tree(), traveller, room: None };
    let way = space.widest_way(starts, |index| search.ends_in(index), search.budget);
    let way = way.map_err(|unknown| match unknown {
        Unknown::Separate { reached } => RouteError::Separate { reached, channels: channels.len() },
        Unknown::Spent(spent) => spent.into(),
    })?;
    let Some(junction) = way.junction else { return chained(search, way.route) };
    let (first, second) = (way.route[junction], way.route[junction + 1]);
    let (one, other) = (&channels[first], &channels[second]);
    // Two channels that are apart have no junction: report where they are apart.
    let apart = |axis: &usize| extent(one, other, *axis) < 0.0;
    let lack = |axis: &usize| space.lack_along(*axis, extent(one, other, *axis)).metres;
    let axis = (0..D)
        .filter(apart)
        .max_by(|a, b| lack(a).total_cmp(&lack(b)).then(b.cmp(a)))
        .unwrap_or(way.lack.axis);
    let has = extent(one, other, axis);
    let (needs, others) = (traveller.needs_along(axis).0, way.others);
    if has < 0.0 {
        let apart = -has;
        return Err(RouteError::Apart { first, second, junction, axis, needs, apart, others });
    }
    if way.lack.change == Change::Gap {
        let (gap, most) = (traveller.gap_along(axis), (has - needs) / 2.0);
        let least = 0.0;
        return Err(RouteError::GapOutOfRange { first, second, junction, axis, gap, least, most });
    }
    Err(RouteError::JunctionTooSmall { first, second, junction, axis, needs, has, others })
}

/// The route, whose junctions are all large enough, if it makes a chain.
fn chained<const D: usize>(
    search: &Search<'_, D>,
    route: Vec<usize>,
) -> Result<Vec<usize>, RouteError> {
    let channels = search.graph.channels();
    let along: Vec<_> = route.iter().map(|index| channels[*index]).collect();
    let traveller = &search.traveller;
    match Chain::default().build(&along, &traveller.center(), traveller.end, search.budget) {
        Err(ChainError::Spent(spent)) => Err(spent.into()),
        Err(ChainError::Parallel { first, second, axis }) => {
            Err(RouteError::Parallel { first: route[first], second: route[second], axis })
        }
        // Cannot happen: junctions are not empty.
        Err(_) => Err(RouteError::NoChannels),
        Ok(()) => Ok(route),
    }
}
