//! A table of the best node in each bin.

/// No node.
pub(super) const NOTHING: u32 = u32::MAX;

/// Open addressing with linear probing; the keys are spread by multiplication (Fibonacci
/// hashing), so that the same keys always lie in the same places.
#[derive(Debug, Default)]
pub(super) struct Table {
    slots: Vec<(u64, u32)>,
    used: usize,
}

impl Table {
    pub(super) fn clear(&mut self) {
        self.slots.fill((0, NOTHING));
        self.used = 0;
    }

    pub(super) fn bytes(&self) -> usize {
        self.slots.capacity() * size_of::<(u64, u32)>()
    }

    pub(super) fn get(&self, key: u64) -> Option<u32> {
        if self.slots.is_empty() {
            return None;
        }
        let (found, value) = self.slots[self.place(key)];
        (found == key && value != NOTHING).then_some(value)
    }

    pub(super) fn set(&mut self, key: u64, value: u32) {
        if 2 * self.used >= self.slots.len() {
            self.grow();
        }
        let place = self.place(key);
        self.used += usize::from(self.slots[place].1 == NOTHING);
        self.slots[place] = (key, value);
    }

    /// Where a key is, or where it belongs.
    fn place(&self, key: u64) -> usize {
        let bits = self.slots.len().trailing_zeros();
        let mut place = (key.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> (64 - bits)) as usize;
        while self.slots[place].1 != NOTHING && self.slots[place].0 != key {
            place = (place + 1) % self.slots.len();
        }
        place
    }

    fn grow(&mut self) {
        let more = (2 * self.slots.len()).max(1 << 10);
        let before = std::mem::replace(&mut self.slots, vec![(0, NOTHING); more]);
        for (key, value) in before {
            if value != NOTHING {
                let place = self.place(key);
                self.slots[place] = (key, value);
            }
        }
    }
}
