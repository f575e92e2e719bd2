//! What one request may cost: steps, bytes, and a flag that stops it.
//!
//! Every loop whose length depends on a request draws from the request's one [`Budget`], so
//! no request takes longer, or more memory, than its [`Allowance`]. Counting is part of the
//! result: the same request under the same allowance is cut short at the same place, on every
//! machine. Only the flag, which a process sets for a deadline, a client that left or its own
//! shutdown, depends on the clock; what it stops is never an answer.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};

use thiserror::Error;

/// What is counted; each has its own limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cap {
    /// Steps of any kind, all answers to the request together. A step takes about 10 ns; what
    /// takes longer counts as several, what is quicker is counted together.
    Steps,
    /// Bytes of working memory held for the request at a time.
    Bytes,
    /// Boxes that solids are cut into.
    Pieces,
    /// Channels made from solids.
    Channels,
    /// Boxes looked at while channels are made.
    ChannelSteps,
    /// Junctions of all channels.
    Junctions,
    /// Pairs of junctions looked at for one route.
    RouteSteps,
}

impl Cap {
    const COUNT: usize = 7;

    /// Its name in [`Allowance`], and in the planner's configuration.
    pub fn name(self) -> &'static str {
        match self {
            Self::Steps => "steps",
            Self::Bytes => "bytes",
            Self::Pieces => "pieces",
            Self::Channels => "channels",
            Self::ChannelSteps => "channel_steps",
            Self::Junctions => "junctions",
            Self::RouteSteps => "route_steps",
        }
    }

    /// What it counts, in words.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Steps => "steps",
            Self::Bytes => "bytes of memory",
            Self::Pieces => "boxes cut from solids",
            Self::Channels => "channels",
            Self::ChannelSteps => "steps to make channels",
            Self::Junctions => "junctions",
            Self::RouteSteps => "steps to find a route",
        }
    }
}

/// The most of each kind that a request may draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Allowance {
    /// See [`Cap::Steps`].
    pub steps: u64,
    /// See [`Cap::Bytes`].
    pub bytes: u64,
    /// See [`Cap::Pieces`].
    pub pieces: u64,
    /// See [`Cap::Channels`].
    pub channels: u64,
    /// See [`Cap::ChannelSteps`].
    pub channel_steps: u64,
    /// See [`Cap::Junctions`].
    pub junctions: u64,
    /// See [`Cap::RouteSteps`].
    pub route_steps: u64,
}

impl Allowance {
    /// No limits, for benches and for callers who know their scenes.
    pub const NONE: Self = Self {
        steps: u64::MAX,
        bytes: u64::MAX,
        pieces: u64::MAX,
        channels: u64::MAX,
        channel_steps: u64::MAX,
        junctions: u64::MAX,
        route_steps: u64::MAX,
    };

    /// The limit of one kind.
    pub fn of(&self, cap: Cap) -> u64 {
        match cap {
            Cap::Steps => self.steps,
            Cap::Bytes => self.bytes,
            Cap::Pieces => self.pieces,
            Cap::Channels => self.channels,
            Cap::ChannelSteps => self.channel_steps,
            Cap::Junctions => self.junctions,
            Cap::RouteSteps => self.route_steps,
        }
    }
}

/// Why planning ends before it is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Spent {
    /// A limit is reached.
    #[error("planning takes more than {most} {}", cap.unit())]
    Limit {
        /// Which.
        cap: Cap,
        /// How much it allows.
        most: u64,
    },
    /// The stop flag is set.
    #[error("planning was stopped")]
    Stopped,
}

/// What is left of a request's limits.
#[derive(Debug)]
pub struct Budget<'a> {
    limits: Allowance,
    drawn: [Cell<u64>; Cap::COUNT],
    /// The most bytes held at a time since the last [`Budget::measure`] began.
    peak: Cell<u64>,
    stop: Option<&'a dyn StopSignal>,
    /// Steps at which the flag is looked at next.
    next_look: Cell<u64>,
    /// Steps that may not be taken for now.
    kept_back: Cell<u64>,
}

/// What a part of a request drew, and what it still held at its end.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Cost {
    steps: u64,
    /// Bytes held at a time.
    peak: u64,
    /// Bytes still held at the end.
    kept: u64,
}

/// Working memory that is given back when this is dropped.
#[derive(Debug)]
pub(crate) struct Held<'a> {
    budget: &'a Budget<'a>,
    bytes: usize,
}

impl<'a> Held<'a> {
    /// Takes `bytes`.
    pub(crate) fn new(budget: &'a Budget<'a>, bytes: usize) -> Result<Self, Spent> {
        budget.hold(bytes)?;
        Ok(Self { budget, bytes })
    }

    /// Holds `bytes` in all, from here on.
    pub(crate) fn resize(&mut self, bytes: usize) -> Result<(), Spent> {
        if bytes > self.bytes {
            self.budget.hold(bytes - self.bytes)?;
        } else {
            self.budget.release(self.bytes - bytes);
        }
        self.bytes = bytes;
        Ok(())
    }

    /// Leaves it taken: the memory outlives this.
    pub(crate) fn keep(mut self) {
        self.bytes = 0;
    }
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        self.budget.release(self.bytes);
    }
}

/// Steps between two looks at the stop flag.
const STEPS_PER_LOOK: u64 = 1 << 10;

/// What ends a request from outside. It is looked at once in so many steps.
pub trait StopSignal: std::fmt::Debug {
    /// Whether the request is to end.
    fn is_set(&self) -> bool;
}

impl StopSignal for AtomicBool {
    fn is_set(&self) -> bool {
        self.load(Ordering::Relaxed)
    }
}

impl Default for Budget<'_> {
    fn default() -> Self {
        Self::new(Allowance::NONE)
    }
}

impl<'a> Budget<'a> {
    /// A whole budget that nothing stops.
    pub fn new(limits: Allowance) -> Self {
        Self {
            limits,
            drawn: Default::default(),
            peak: Cell::new(0),
            stop: None,
            next_look: Cell::new(0),
            kept_back: Cell::new(0),
        }
    }

    /// A whole budget that ends when `stop` is set.
    pub fn with_stop(limits: Allowance, stop: &'a dyn StopSignal) -> Self {
        Self { stop: Some(stop), ..Self::new(limits) }
    }

    /// The limits it began with.
    pub fn allowance(&self) -> &Allowance {
        &self.limits
    }

    /// What has been drawn of one kind.
    pub fn drawn(&self, cap: Cap) -> u64 {
        self.drawn[cap as usize].get()
    }

    /// Takes `count` steps.
    #[inline]
    pub fn step(&self, count: u64) -> Result<(), Spent> {
        let drawn = &self.drawn[Cap::Steps as usize];
        let steps = drawn.get().saturating_add(count);
        drawn.set(steps);
        if steps >= self.next_look.get() { self.look(steps) } else { Ok(()) }
    }

    /// Takes `count` of a kind, each of which is a step as well.
    #[inline]
    pub fn draw(&self, cap: Cap, count: u64) -> Result<(), Spent> {
        self.count(cap, count)?;
        self.step(count)
    }

    /// Runs a search that may take all but a part of the steps that are left, one of `share`, so that
    /// what it found can be measured and written if it is cut short.
    pub fn keeping_back<T>(&self, share: u64, run: impl FnOnce() -> T) -> T {
        let left = self.limits.steps.saturating_sub(self.drawn(Cap::Steps));
        let before = self.kept_back.replace(left / share.max(1));
        self.next_look.set(0);
        let result = run();
        self.kept_back.set(before);
        self.next_look.set(0);
        result
    }

    /// Resets one counter: its limit applies to a part of the request.
    pub fn restart(&self, cap: Cap) {
        self.drawn[cap as usize].set(0);
    }

    /// Takes `bytes` of working memory; nothing, if that would be more than there is.
    #[inline]
    pub fn hold(&self, bytes: usize) -> Result<(), Spent> {
        let held = &self.drawn[Cap::Bytes as usize];
        let total = held.get().saturating_add(bytes as u64);
        if total > self.limits.bytes {
            return Err(Spent::Limit { cap: Cap::Bytes, most: self.limits.bytes });
        }
        held.set(total);
        self.peak.set(self.peak.get().max(total));
        Ok(())
    }

    /// Gives `bytes` back.
    #[inline]
    pub fn release(&self, bytes: usize) {
        let held = &self.drawn[Cap::Bytes as usize];
        held.set(held.get().saturating_sub(bytes as u64));
    }

    /// Refuses more of one kind than its limit, without drawing any.
    #[inline]
    pub fn check(&self, cap: Cap, count: usize) -> Result<(), Spent> {
        let most = self.limits.of(cap);
        if count as u64 <= most { Ok(()) } else { Err(Spent::Limit { cap, most }) }
    }

    /// Runs `run` and returns what it drew. Where its result is used again, as from a cache,
    /// [`Budget::repeat`] draws the same, so that a reply does not depend on what was kept.
    pub fn measure<T>(&self, run: impl FnOnce() -> T) -> (T, Cost) {
        let [steps, held] = [Cap::Steps, Cap::Bytes].map(|cap| self.drawn(cap));
        let before = self.peak.replace(held);
        let result = run();
        let peak = self.peak.get();
        self.peak.set(before.max(peak));
        let cost = Cost {
            steps: self.drawn(Cap::Steps) - steps,
            peak: peak - held,
            kept: self.drawn(Cap::Bytes).saturating_sub(held),
        };
        (result, cost)
    }

    /// Draws what was measured. Draws nothing and returns false where that is more than is
    /// left: to be cut short at the same place as without the result, make it again.
    pub fn repeat(&self, cost: &Cost) -> bool {
        let [steps, held] = [Cap::Steps, Cap::Bytes].map(|cap| &self.drawn[cap as usize]);
        let all_steps = steps.get().saturating_add(cost.steps);
        let peak = held.get().saturating_add(cost.peak);
        let enough = all_steps <= self.limits.steps && peak <= self.limits.bytes;
        if enough {
            steps.set(all_steps);
            held.set(held.get() + cost.kept);
            self.peak.set(self.peak.get().max(peak));
        }
        enough
    }

    #[inline]
    fn count(&self, cap: Cap, count: u64) -> Result<(), Spent> {
        let drawn = &self.drawn[cap as usize];
        let total = drawn.get().saturating_add(count);
        drawn.set(total);
        let most = self.limits.of(cap);
        if total <= most { Ok(()) } else { Err(Spent::Limit { cap, most }) }
    }

    #[cold]
    fn look(&self, steps: u64) -> Result<(), Spent> {
        let most = self.limits.steps;
        let now = most.saturating_sub(self.kept_back.get());
        if steps > now {
            return Err(Spent::Limit { cap: Cap::Steps, most });
        }
        if self.stop.is_some_and(StopSignal::is_set) {
            return Err(Spent::Stopped);
        }
        // Whatever comes first: the limit, or the next look at the flag.
        self.next_look.set(steps.saturating_add(STEPS_PER_LOOK).min(now.saturating_add(1)));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> Allowance {
        Allowance { steps: 5_000, route_steps: 100, bytes: 64, ..Allowance::NONE }
    }

    #[test]
    fn the_limit_itself_is_allowed_and_one_more_is_not() {
        let budget = Budget::new(limits());
        budget.step(4_999).unwrap();
        budget.step(1).unwrap();
        assert_eq!(budget.step(1), Err(Spent::Limit { cap: Cap::Steps, most: 5_000 }));
        // It stays spent.
        assert_eq!(budget.step(0), Err(Spent::Limit { cap: Cap::Steps, most: 5_000 }));
    }

    #[test]
    fn one_kind_is_limited_by_itself_and_counts_as_steps() {
        let budget = Budget::new(limits());
        budget.draw(Cap::RouteSteps, 100).unwrap();
        assert_eq!(budget.drawn(Cap::Steps), 100);
        let spent = Spent::Limit { cap: Cap::RouteSteps, most: 100 };
        assert_eq!(budget.draw(Cap::RouteSteps, 1), Err(spent));
        budget.restart(Cap::RouteSteps);
        budget.draw(Cap::RouteSteps, 100).unwrap();
    }

    #[test]
    fn memory_can_be_given_back() {
        let budget = Budget::new(limits());
        budget.hold(64).unwrap();
        assert_eq!(budget.hold(1), Err(Spent::Limit { cap: Cap::Bytes, most: 64 }));
        budget.release(40);
        let mut held = Held::new(&budget, 30).unwrap();
        assert_eq!(held.resize(41), Err(Spent::Limit { cap: Cap::Bytes, most: 64 }));
        held.resize(40).unwrap();
        drop(held);
        Held::new(&budget, 10).unwrap().keep();
        assert_eq!(budget.drawn(Cap::Bytes), 34);
    }

    #[test]
    fn repeating_draws_what_was_measured() {
        let work = |budget: &Budget<'_>| -> Result<(), Spent> {
            budget.step(1_500)?;
            let _for_a_while = Held::new(budget, 20)?;
            budget.hold(3)
        };
        let [made, repeated] = [Budget::new(limits()), Budget::new(limits())];
        let (done, cost) = made.measure(|| work(&made));
        done.unwrap();
        assert!(repeated.repeat(&cost));
        for cap in [Cap::Steps, Cap::Bytes] {
            assert_eq!(made.drawn(cap), repeated.drawn(cap));
        }
        // A third time there are steps enough, and a fourth time there are not.
        assert!(repeated.repeat(&cost) && repeated.repeat(&cost));
        assert!(!repeated.repeat(&cost) && work(&repeated).is_err());
        // Nor is there memory, if only for a while.
        let full = Budget::new(limits());
        full.hold(42).unwrap();
        assert!(!full.repeat(&cost));
        assert_eq!((full.drawn(Cap::Steps), full.drawn(Cap::Bytes)), (0, 42));
        assert!(work(&full).is_err());
    }

    #[test]
    fn a_set_flag_ends_a_loop_soon() {
        let stop = AtomicBool::new(false);
        let budget = Budget::with_stop(Allowance::NONE, &stop);
        budget.step(1).unwrap();
        stop.store(true, Ordering::Relaxed);
        let steps = (0..).find(|_| budget.step(1).is_err()).unwrap();
        assert!(steps <= STEPS_PER_LOOK, "{steps} steps after the flag was set");
        assert_eq!(budget.step(STEPS_PER_LOOK), Err(Spent::Stopped));
    }
}
