//! The widest way: of all ways over channels, even those apart, the one whose worst junction
//! falls short least.

use super::Traveller;
use crate::budget::{Budget, Cap, Held, Spent};
use crate::geometry::box_tree::BoxTree;
use crate::geometry::{AxisBox, Vector};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The channels that ways lead over.
pub(super) struct Space<'a, const D: usize> {
    pub(super) channels: &'a [AxisBox<D>],
    /// Indexes the channels.
    pub(super) tree: &'a BoxTree<D>,
    pub(super) traveller: &'a Traveller<D>,
    /// Between solids, the extent that a channel itself must exceed, metres; channels that do not
    /// meet have a wall between them. `None` for given channels: any will do, and those that do
    /// not meet have a junction of negative extent.
    pub(super) room: Option<Vector<D>>,
}

/// What has to change to pass a junction, from the least to the most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Change {
    Nothing,
    /// The gap: the body passes but for (3.1).
    Gap,
    /// The junction: the body does not fit by (2.5).
    Junction,
    /// The wall between.
    Wall,
}

/// By how much a junction falls short.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lack {
    pub(super) change: Change,
    /// What is missing, metres, at least 0; for a wall its thickness, if that is more.
    pub(super) metres: f64,
    /// The axis along which it is most.
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

/// A way over channels.
#[derive(Debug)]
pub(super) struct WidestWay {
    /// Channels in travel order.
    pub(super) route: Vec<usize>,
    /// The shortfall of its worst junction. No way has a better worst junction.
    pub(super) lack: Lack,
    /// The index of that junction in travel order, the first of equals; `None` if no junction
    /// falls short.
    pub(super) junction: Option<usize>,
    /// How many of its other junctions fall short: as few as possible.
    pub(super) others: usize,
}

/// Why no way is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unknown {
    /// The end is not reachable from the start, but this many channels are.
    Separate { reached: usize },
    /// The budget ended.
    Spent(Spent),
}

impl From<Spent> for Unknown {
    fn from(spent: Spent) -> Self {
        Self::Spent(spent)
    }
}

/// The cost of a way so far.
#[derive(Debug, Clone, Copy)]
struct Key {
    lack: Lack,
    /// The number of junctions that fall short.
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

/// The first reach across gaps is at least this part of the whole extent, so that few doublings
/// are needed.
const PART: f64 = 1.0 / 1048576.0;

/// Steps that a pair of channels takes besides the one counted as [`Cap::RouteSteps`].
const MORE_STEPS: u64 = 3;

/// For every channel: the best way there, the channel before, and whether it is done.
const BYTES_PER_CHANNEL: usize = size_of::<(Option<Key>, Option<usize>, bool)>();

/// Whether only this search has come to its end, and what was found before still stands.
pub(super) fn is_of_the_search(spent: &Spent) -> bool {
    matches!(spent, Spent::Limit { cap: Cap::RouteSteps | Cap::Bytes, .. })
}

/// More than the relative rounding of a sum of two numbers.
const ROUNDING: f64 = 1e-12;

/// The common extent of two boxes along an axis, metres; negative if they are apart.
pub(super) fn extent<const D: usize>(one: &AxisBox<D>, other: &AxisBox<D>, axis: usize) -> f64 {
    one.max()[axis].min(other.max()[axis]) - one.min()[axis].max(other.min()[axis])
}

impl<const D: usize> Space<'_, D> {
    /// Finds the widest way from any of `starts` (ascending) to a channel that is an end,
    /// looking at no more than [`Cap::RouteSteps`] pairs of channels. Ties go to the fewest
    /// junctions that fall short, then to the fewest channels, then to the lowest index.
    ///
    /// This is a shortest-path search in which a way is as long as its worst junction. As all
    /// pairs of channels would be too many, it looks only at those no farther apart than a reach
    /// along any axis. A pair farther apart falls short by more than [`Space::reach_for`] says.
    /// So if the result needs no more than the reach, no better way was left out; if it needs
    /// more, a search with that reach leaves none out. Until there is a result, the reach
    /// doubles.
    pub(super) fn widest_way(
        &self,
        starts: &[usize],
        is_end: impl Fn(usize) -> bool,
        budget: &Budget<'_>,
    ) -> Result<WidestWay, Unknown> {
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
                        // Again, now that the worst shortfall is known.
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
                    // The result is a way, though there may be a better one.
                    return match (best, connected) {
                        (Some((_, route)), _) => Ok(self.along(route)),
                        (None, Some(reached)) => Err(Unknown::Separate { reached }),
                        (None, None) => Err(unknown),
                    };
                }
            }
        }
    }

    /// The shortfall of the junction of two channels along its worst axis, the first of equals.
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
            // An opening must also be large enough along the axes on which they are not apart.
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

    /// The shortfall along an axis of a junction with this extent.
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

    /// The shortfall of a channel in which a way begins. That of others shows in their junctions.
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

    /// Pairs farther apart than this along any axis fall short by more, metres.
    fn reach_for(&self, lack: &Lack) -> f64 {
        let apart = match lack.change {
            Change::Nothing | Change::Gap => 0.0,
            // A pair that is apart along an axis falls short by more than what is needed there.
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

    /// The greatest extent of all channels together along any axis, metres.
    fn greatest_extent(&self) -> f64 {
        let corners = self.channels.iter().map(|channel| (channel.min(), channel.max()));
        let all = corners.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)));
        all.map_or(0.0, |(min, max)| (max - min).max())
    }

    /// The best way over pairs no farther apart than the reach. All ways count as at least as
    /// bad as the floor.
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
                spent = budget.draw(Cap::RouteSteps, 1).and_then(|()| budget.step(MORE_STEPS));
                if spent.is_err() { -1.0 } else { 0.0 }
            })?;
            spent?;
            held.resize(for_channels + open.len() * size_of::<Reached>())?;
        }
        Err(Unknown::Separate { reached })
    }

    fn along(&self, route: Vec<usize>) -> WidestWay {
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
        WidestWay { route, lack: worst, junction, others: short.saturating_sub(1) }
    }
}
