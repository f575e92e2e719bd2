//! The widest way: of all ways over channels, those that are apart included, the one
//! whose worst junction lacks least.

use super::Traveller;
use crate::budget::{Budget, Cap, Held, Spent};
use crate::geometry::box_tree::BoxTree;
use crate::geometry::{AxisBox, Vector};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// What ways lead over.
pub(super) struct Space<'a, const D: usize> {
    pub(super) channels: &'a [AxisBox<D>],
    /// Over the channels.
    pub(super) tree: &'a BoxTree<D>,
    pub(super) traveller: &'a Traveller<D>,
    /// Between solids: what a channel itself must exceed, metres; and between channels that
    /// do not meet there is a wall. Without, they have too small a junction, of negative
    /// extent, and all channels will do.
    pub(super) room: Option<Vector<D>>,
}

/// What has to change for a junction to be passed, the least first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Change {
    Nothing,
    /// The gap: the body passes without (3.1).
    Gap,
    /// The junction: the body does not pass by (2.5).
    Junction,
    /// The wall between.
    Wall,
}

/// By how much the junction of two channels is too small.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lack {
    pub(super) change: Change,
    /// What is missing, metres, not less than 0; of a wall what is too much, if that is more.
    pub(super) metres: f64,
    /// Along which axis most.
    pub(super) axis: usize,
}

const NOTHING: Lack = Lack { change: Change::Nothing, metres: 0.0, axis: 0 };

impl Lack {
    fn order(&self, other: &Self) -> Ordering {
        self.change.cmp(&other.change).then(self.metres.total_cmp(&other.metres))
    }

    /// The worse of two, the first of equals.
    fn or_worse(self, other: Self) -> Self {
        if other.order(&self).is_gt() { other } else { self }
    }
}

/// A way.
#[derive(Debug)]
pub(super) struct Way {
    /// Channels in travel order.
    pub(super) route: Vec<usize>,
    /// What its worst junction lacks. No way has a better worst one.
    pub(super) lack: Lack,
    /// Which junction that is, in travel order; the first of equals. None where
    /// there is none that lacks anything.
    pub(super) junction: Option<usize>,
    /// How many of its other junctions are too small, too: as few as can be.
    pub(super) others: usize,
}

/// Why no way is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unknown {
    /// So many channels hang together with the start.
    Separate { reached: usize },
    /// The budget ended.
    Spent(Spent),
}

impl From<Spent> for Unknown {
    fn from(spent: Spent) -> Self {
        Self::Spent(spent)
    }
}

/// What a way so far is judged by.
#[derive(Debug, Clone, Copy)]
struct Key {
    lack: Lack,
    /// Junctions that are too small.
    short: usize,
    channels: usize,
}

impl Key {
    fn order(&self, other: &Self) -> Ordering {
        let counts = |key: &Self| (key.short, key.channels);
        self.lack.order(&other.lack).then_with(|| counts(self).cmp(&counts(other)))
    }
}

/// A channel reached; the greatest comes first.
#[derive(Debug, Clone, Copy)]
struct Reached {
    key: Key,
    channel: usize,
}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        other.key.order(&self.key).then_with(|| other.channel.cmp(&self.channel))
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

/// The first reach over gaps is at least this part of everything, so that few doublings
/// will do.
const PART: f64 = 1.0 / 1048576.0;

/// Of every channel the best way there, the channel before, and whether it is done with.
const BYTES_PER_CHANNEL: usize = size_of::<(Option<Key>, Option<usize>, bool)>();

/// Whether only this search has come to its end, and what was found before still stands.
pub(super) fn is_of_the_search(spent: &Spent) -> bool {
    matches!(spent, Spent::Limit { cap: Cap::RouteSteps | Cap::Bytes, .. })
}

/// More than what sums of two numbers are rounded by, as a part of them.
const ROUNDING: f64 = 1e-12;

/// The common extent of two boxes along an axis; negative if they are apart.
pub(super) fn extent<const D: usize>(one: &AxisBox<D>, other: &AxisBox<D>, axis: usize) -> f64 {
    one.max()[axis].min(other.max()[axis]) - one.min()[axis].max(other.min()[axis])
}

impl<const D: usize> Space<'_, D> {
    /// Finds the widest way from any of `starts` (ascending) to a channel that is an
    /// end, looking at no more pairs of channels than [`Cap::RouteSteps`]. Of equal ways
    /// it is the one with the fewest junctions that are too small, then with the fewest
    /// channels, then with the lowest index.
    ///
    /// It is a shortest-path search where a way is as long as its worst junction. All
    /// pairs of channels would be too many, so it looks only at those that are no
    /// farther apart than a reach along any axis. A pair that is farther apart lacks
    /// more than [`Space::reach_for`] says; so if what was found needs no more than the
    /// reach, no pair left out is part of a better way, and if it needs more, then
    /// with that reach nothing better is left out. Until something is found, the
    /// reach is doubled.
    pub(super) fn widest_way(
        &self,
        starts: &[usize],
        is_end: impl Fn(usize) -> bool,
        budget: &Budget<'_>,
    ) -> Result<Way, Unknown> {
        budget.restart(Cap::RouteSteps);
        budget.step(self.channels.len() as u64)?;
        let whole = self.greatest_extent();
        let mut reach = 0.0;
        let mut best: Option<(Lack, Vec<usize>)> = None;
        let mut connected = None;
        loop {
            let search = |floor| self.search(starts, &is_end, (reach, floor), budget);
            match search(NOTHING) {
                Ok((lack, route)) => {
                    let needed = self.reach_for(&lack);
                    if needed <= reach {
                        // The same, now that what must be borne is known.
                        let route = match search(lack) {
                            Ok((_, better)) => better,
                            Err(Unknown::Spent(spent)) if !is_of_the_search(&spent) => {
                                return Err(spent.into());
                            }
                            Err(_) => route,
                        };
                        return Ok(self.along(route));
                    }
                    best = Some((lack, route));
                    reach = needed;
                }
                Err(Unknown::Separate { reached }) => {
                    let connected = *connected.get_or_insert(reached);
                    if reached == self.channels.len() || reach > whole {
                        return Err(Unknown::Separate { reached: connected });
                    }
                    reach = (2.0 * reach).max(self.least_need()).max(whole * PART);
                }
                Err(Unknown::Spent(spent)) if !is_of_the_search(&spent) => {
                    return Err(spent.into());
                }
                Err(unknown) => {
                    // What was found is a way, though there may be a better one.
                    return match (best, connected) {
                        (Some((_, route)), _) => Ok(self.along(route)),
                        (None, Some(reached)) => Err(Unknown::Separate { reached }),
                        (None, None) => Err(unknown),
                    };
                }
            }
        }
    }

    /// How much the junction of two channels lacks; if several axes do, the worst of
    /// them, the first of equals.
    pub(super) fn lack(&self, one: &AxisBox<D>, other: &AxisBox<D>) -> Lack {
        let mut worst = NOTHING;
        let (mut apart, mut most_apart) = (0.0_f64, None);
        for axis in 0..D {
            let has = extent(one, other, axis);
            worst = worst.or_worse(self.lack_along(axis, has));
            if self.room.is_some() && has <= 0.0 && most_apart.is_none_or(|_| -has > apart) {
                (apart, most_apart) = (-has, Some(axis));
            }
        }
        match most_apart {
            None => worst,
            // An opening must be large enough across as well, as far as the axes
            // along which they are not apart say.
            Some(axis) => {
                let across = (0..D)
                    .filter(|axis| extent(one, other, *axis) > 0.0)
                    .map(|axis| self.lack_along(axis, extent(one, other, axis)))
                    .filter(|lack| lack.change == Change::Junction);
                let metres = across.fold(apart, |most, lack| most.max(lack.metres));
                Lack { change: Change::Wall, metres, axis }
            }
        }
    }

    /// How much a junction with this extent lacks along an axis.
    pub(super) fn lack_along(&self, axis: usize, has: f64) -> Lack {
        let (needs, with_gap) = self.traveller.needs_along(axis);
        let (change, metres) = if has <= needs {
            (Change::Junction, needs - has)
        } else if !self.traveller.fits_along(axis, has) {
            (Change::Gap, with_gap - has)
        } else {
            (Change::Nothing, 0.0)
        };
        Lack { change, metres: metres.max(0.0), axis }
    }

    /// How much a channel lacks in which a way begins. What others lack, their junctions do.
    pub(super) fn lack_of(&self, channel: &AxisBox<D>) -> Lack {
        let Some(room) = self.room else { return NOTHING };
        let size = channel.size();
        let lacks = (0..D).filter(|axis| size[*axis] <= room[*axis]).map(|axis| Lack {
            change: Change::Junction,
            metres: room[axis] - size[axis],
            axis,
        });
        lacks.fold(NOTHING, Lack::or_worse)
    }

    /// Pairs that are farther apart than this along any axis lack more.
    fn reach_for(&self, lack: &Lack) -> f64 {
        let apart = match lack.change {
            Change::Nothing | Change::Gap => 0.0,
            // A pair that is apart along an axis lacks what is needed there, and more.
            Change::Junction if self.room.is_some() => 0.0,
            Change::Junction => (lack.metres - self.least_need()).max(0.0),
            Change::Wall => lack.metres,
        };
        if apart > 0.0 { apart + ROUNDING * lack.metres } else { 0.0 }
    }

    fn least_need(&self) -> f64 {
        let needs = (0..D).map(|axis| self.traveller.needs_along(axis).0);
        needs.fold(f64::INFINITY, f64::min).max(0.0)
    }

    /// The greatest extent of all channels together, along any axis.
    fn greatest_extent(&self) -> f64 {
        let corners = self.channels.iter().map(|channel| (channel.min(), channel.max()));
        let all = corners.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)));
        all.map_or(0.0, |(min, max)| (max - min).max())
    }

    /// The best way over pairs that are no farther apart than the reach, all ways
    /// being taken as at least as bad as the floor.
    fn search(
        &self,
        starts: &[usize],
        is_end: impl Fn(usize) -> bool,
        (reach, floor): (f64, Lack),
        budget: &Budget<'_>,
    ) -> Result<(Lack, Vec<usize>), Unknown> {
        let channels = self.channels;
        budget.step(channels.len() as u64)?;
        let for_channels = channels.len().saturating_mul(BYTES_PER_CHANNEL);
        let mut held = Held::new(budget, for_channels)?;
        let mut best: Vec<Option<Key>> = vec![None; channels.len()];
        let mut before: Vec<Option<usize>> = vec![None; channels.len()];
        let mut done = vec![false; channels.len()];
        let mut open = BinaryHeap::new();
        for &channel in starts {
            let own = self.lack_of(&channels[channel]);
            let short = usize::from(own.change != Change::Nothing);
            let key = Key { lack: floor.or_worse(own), short, channels: 1 };
            best[channel] = Some(key);
            open.push(Reached { key, channel });
        }
        let mut reached = 0;
        while let Some(Reached { key, channel }) = open.pop() {
            if std::mem::replace(&mut done[channel], true) {
                continue;
            }
            reached += 1;
            if is_end(channel) {
                let mut route = vec![channel];
                let mut at = channel;
                while let Some(previous) = before[at] {
                    route.push(previous);
                    at = previous;
                }
                route.reverse();
                return Ok((key.lack, route));
            }
            let this = &channels[channel];
            let (min, max) = (this.min().add_scalar(-reach), this.max().add_scalar(reach));
            let mut spent = Ok(());
            self.tree.visit(&min, &max, 0.0, budget, |next| {
                if !done[next] {
                    let lack = self.lack(this, &channels[next]);
                    let short = key.short + usize::from(lack.change != Change::Nothing);
                    let lack = key.lack.or_worse(lack);
                    let key = Key { lack, short, channels: key.channels + 1 };
                    if best[next].is_none_or(|known| key.order(&known).is_lt()) {
                        best[next] = Some(key);
                        before[next] = Some(channel);
                        open.push(Reached { key, channel: next });
                    }
                }
                spent = budget.draw(Cap::RouteSteps, 1);
                if spent.is_err() { -1.0 } else { 0.0 }
            })?;
            spent?;
            held.resize(for_channels + open.len() * size_of::<Reached>())?;
        }
        Err(Unknown::Separate { reached })
    }

    fn along(&self, route: Vec<usize>) -> Way {
        let (mut worst, mut junction, mut short) = (NOTHING, None, 0_usize);
        for (index, pair) in route.windows(2).enumerate() {
            let [first, second] = *pair else { continue };
            let lack = self.lack(&self.channels[first], &self.channels[second]);
            if lack.change == Change::Nothing {
                continue;
            }
            short += 1;
            if junction.is_none() || lack.order(&worst).is_gt() {
                (worst, junction) = (lack, Some(index));
            }
        }
        Way { route, lack: worst, junction, others: short.saturating_sub(1) }
    }
}
