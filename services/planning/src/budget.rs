//! What one request may cost: steps, bytes, and a flag that stops it.
//!
//! Every loop whose length depends on a request draws from the request's one [`Budget`], so
//! no request takes longer, or more memory, than its [`Limits`] allow. Counting is part of the
//! result: the same request under the same limits is cut short at the same place, on every
//! machine. Only the flag, which a process sets for a deadline, a client that left or its own
//! shutdown, depends on the clock; what it stops is never an answer.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};

use thiserror::Error;

/// What is counted, each against a limit of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cap {
    /// Steps of any kind, all answers to the request together.
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
}

/// The most of each kind that a request may draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
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

impl Limits {
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
    #[error("more than {most} {cap:?}")]
    Limit {
        /// Which.
        cap: Cap,
        /// How much it allows.
        most: u64,
    },
    /// The stop flag is set.
    #[error("stopped")]
    Stopped,
}

/// What is left of a request's limits.
#[derive(Debug)]
pub struct Budget<'a> {
    limits: Limits,
    drawn: [Cell<u64>; Cap::COUNT],
    stop: Option<&'a AtomicBool>,
    /// Steps at which the flag is looked at next.
    next_look: Cell<u64>,
}

/// The stop flag is looked at once in so many steps.
const STEPS_PER_LOOK: u64 = 1 << 10;

impl Default for Budget<'_> {
    fn default() -> Self {
        Self::new(Limits::NONE)
    }
}

impl<'a> Budget<'a> {
    /// A whole budget that nothing stops.
    pub fn new(limits: Limits) -> Self {
        Self { limits, drawn: Default::default(), stop: None, next_look: Cell::new(0) }
    }

    /// A whole budget that ends when `stop` is set.
    pub fn with_stop(limits: Limits, stop: &'a AtomicBool) -> Self {
        Self { stop: Some(stop), ..Self::new(limits) }
    }

    /// The limits it began with.
    pub fn limits(&self) -> &Limits {
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

    /// Begins to count one kind anew: its limit is for a part of the request.
    pub fn restart(&self, cap: Cap) {
        self.drawn[cap as usize].set(0);
    }

    /// Takes `bytes` of working memory.
    #[inline]
    pub fn hold(&self, bytes: u64) -> Result<(), Spent> {
        self.count(Cap::Bytes, bytes)
    }

    /// Gives `bytes` back.
    #[inline]
    pub fn release(&self, bytes: u64) {
        let held = &self.drawn[Cap::Bytes as usize];
        held.set(held.get().saturating_sub(bytes));
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
        if steps > most {
            return Err(Spent::Limit { cap: Cap::Steps, most });
        }
        if self.stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            return Err(Spent::Stopped);
        }
        // Whatever comes first: the limit, or the next look at the flag.
        self.next_look.set(steps.saturating_add(STEPS_PER_LOOK).min(most.saturating_add(1)));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> Limits {
        Limits { steps: 5_000, route_steps: 100, bytes: 64, ..Limits::NONE }
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
        budget.release(65);
        budget.hold(64).unwrap();
    }

    #[test]
    fn a_set_flag_ends_a_loop_soon() {
        let stop = AtomicBool::new(false);
        let budget = Budget::with_stop(Limits::NONE, &stop);
        budget.step(1).unwrap();
        stop.store(true, Ordering::Relaxed);
        let steps = (0..).find(|_| budget.step(1).is_err()).unwrap();
        assert!(steps <= STEPS_PER_LOOK, "{steps} steps after the flag was set");
        assert_eq!(budget.step(STEPS_PER_LOOK), Err(Spent::Stopped));
    }
}
