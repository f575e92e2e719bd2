//! Messages that are missing.

/// Finds messages missing by their sequence numbers.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Gaps {
    next: u32,
    pub(crate) lost: u64,
    pub(crate) gaps: u64,
    /// Whether the message before is missing.
    in_gap: bool,
}

impl Gaps {
    /// Begins to count at this number.
    pub(crate) fn begin(&mut self, sequence: u64) {
        self.next = sequence as u32;
    }

    /// How many messages are missing before the one with this number. Numbers wrap
    /// around; one that goes back begins a new count and says nothing of losses.
    pub(crate) fn before(&mut self, sequence: u32) -> u64 {
        let lost = self.up_to(sequence);
        self.next = sequence.wrapping_add(1);
        self.in_gap = false;
        lost
    }

    /// How many messages are missing where the next one will have this number.
    pub(crate) fn up_to(&mut self, sequence: u32) -> u64 {
        let ahead = sequence.wrapping_sub(self.next);
        self.next = sequence;
        let lost = if ahead <= u32::MAX / 2 { u64::from(ahead) } else { 0 };
        self.lost += lost;
        self.gaps += u64::from(lost > 0 && !self.in_gap);
        self.in_gap |= lost > 0;
        lost
    }

    /// Whether the numbers have come further than this one.
    pub(crate) fn is_past(&self, sequence: u32) -> bool {
        sequence.wrapping_sub(self.next) > u32::MAX / 2
    }

    /// The number of the next message, which `near` is close to.
    pub(crate) fn next_near(&self, near: u64) -> u64 {
        let behind = (near as u32).wrapping_sub(self.next) as i32;
        near.wrapping_sub(i64::from(behind) as u64)
    }
}
