//! Who may plan now.
//!
//! More requests can be in hand than there are workers: one that takes long lets others have its
//! turn, and goes on later. So a short request waits for a slice of a long one, not for its end.

use std::collections::VecDeque;

/// A place in the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Place(u64);

/// A number of turns, and the line for them. First come, first served.
#[derive(Debug)]
pub(crate) struct Turns {
    free: usize,
    next: u64,
    line: VecDeque<Place>,
}

impl Turns {
    pub(crate) fn new(turns: usize) -> Self {
        Self { free: turns, next: 0, line: VecDeque::new() }
    }

    /// Asks for a turn: has it at once (`None`), or a place in the line.
    pub(crate) fn ask(&mut self) -> Option<Place> {
        if self.free > 0 {
            self.free -= 1;
            return None;
        }
        Some(self.line_up())
    }

    /// Whoever has a turn lets the first in the line have it, and lines up again. `None`: nobody
    /// waits, and it goes on.
    pub(crate) fn pass_on(&mut self) -> Option<Place> {
        self.line.pop_front()?;
        Some(self.line_up())
    }

    /// Whoever has a turn needs it no longer.
    pub(crate) fn give_back(&mut self) {
        // The first in the line has it from now on.
        if self.line.pop_front().is_none() {
            self.free += 1;
        }
    }

    /// Whether whoever lined up here still waits.
    pub(crate) fn waits(&self, place: Place) -> bool {
        self.line.contains(&place)
    }

    /// Leaves the line. Whether it had waited still: if not, it has a turn.
    pub(crate) fn leave(&mut self, place: Place) -> bool {
        let waited = self.waits(place);
        self.line.retain(|other| *other != place);
        waited
    }

    fn line_up(&mut self) -> Place {
        let place = Place(self.next);
        self.next += 1;
        self.line.push_back(place);
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What a thread is doing.
    #[derive(Debug, Clone, Copy, PartialEq)]
    enum Doing {
        Nothing,
        Waiting(Place),
        Planning,
    }

    proptest! {
        /// Threads that do anything in any order: never more plan than there are turns, no turn is
        /// lost while somebody waits, and who waits is served in order.
        #[test]
        fn turns_are_neither_lost_nor_doubled(
            turns in 1..4_usize,
            steps in proptest::collection::vec((0..6_usize, 0..4_u8), 0..200),
        ) {
            let mut state = Turns::new(turns);
            let mut threads = [Doing::Nothing; 6];
            for (thread, step) in steps {
                let doing = &mut threads[thread];
                *doing = match (*doing, step) {
                    (Doing::Nothing, 0) => state.ask().map_or(Doing::Planning, Doing::Waiting),
                    (Doing::Planning, 1) => state.pass_on().map_or(Doing::Planning, Doing::Waiting),
                    (Doing::Planning, 2) => {
                        state.give_back();
                        Doing::Nothing
                    }
                    (Doing::Waiting(place), 3) => match state.leave(place) {
                        true => Doing::Nothing,
                        false => Doing::Planning,
                    },
                    (doing, _) => doing,
                };
                for doing in &mut threads {
                    if let Doing::Waiting(place) = *doing && !state.waits(place) {
                        *doing = Doing::Planning;
                    }
                }
                let planning = threads.iter().filter(|doing| **doing == Doing::Planning).count();
                let waiting = threads.iter().filter(|doing| matches!(doing, Doing::Waiting(_))).count();
                prop_assert!(planning <= turns);
                prop_assert!(waiting == 0 || planning == turns);
                prop_assert_eq!(planning + state.free, turns);
            }
        }
    }

    #[test]
    fn the_line_is_served_in_order() {
        let mut turns = Turns::new(1);
        assert_eq!(turns.ask(), None);
        let [first, second] = [(); 2].map(|()| turns.ask().unwrap());
        let long = turns.pass_on().unwrap();
        assert!(!turns.waits(first) && turns.waits(second) && turns.waits(long));
        turns.give_back();
        assert!(!turns.waits(second) && turns.waits(long));
        turns.give_back();
        assert!(!turns.waits(long));
        assert_eq!(turns.pass_on(), None);
    }
}
