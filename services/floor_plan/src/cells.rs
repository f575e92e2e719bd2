//! Sets of cells, a bit each.

/// A set of a picture's cells. Rows run from the least y to the greatest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct CellSet {
    width: usize,
    words_per_row: usize,
    words: Vec<u64>,
}

impl CellSet {
    /// The empty set.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let words_per_row = width.div_ceil(64);
        Self { width, words_per_row, words: vec![0; words_per_row * height] }
    }

    /// A row, 64 cells a word, from the least x; bits beyond the width are 0.
    pub(crate) fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.words_per_row..][..self.words_per_row]
    }

    pub(crate) fn row_mut(&mut self, y: usize) -> &mut [u64] {
        &mut self.words[y * self.words_per_row..][..self.words_per_row]
    }

    pub(crate) fn contains(&self, x: usize, y: usize) -> bool {
        x < self.width && bit(self.row(y), x)
    }

    pub(crate) fn len(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.words.iter().all(|word| *word == 0)
    }
}

pub(crate) fn bit(words: &[u64], x: usize) -> bool {
    words[x / 64] >> (x % 64) & 1 == 1
}

/// The runs of cells in a row of `width` cells: from the first to before the last.
pub(crate) fn runs(words: &[u64], width: usize, mut each: impl FnMut([usize; 2])) {
    let (mut before, mut from) = (0, None);
    for (index, word) in words.iter().enumerate() {
        // Where a run begins or ends.
        let mut changes = word ^ (word << 1 | before);
        before = word >> 63;
        while changes != 0 {
            let x = index * 64 + changes.trailing_zeros() as usize;
            changes &= changes - 1;
            match from.take() {
                None => from = Some(x),
                Some(from) => each([from, x]),
            }
        }
    }
    if let Some(from) = from {
        each([from, width]);
    }
}

/// Adds the cells `from..to` to a row.
pub(crate) fn fill(words: &mut [u64], [from, to]: [usize; 2]) {
    for (index, word) in words.iter_mut().enumerate().take(to.div_ceil(64)).skip(from / 64) {
        let low = u64::MAX << from.saturating_sub(index * 64);
        let high = to - index * 64;
        *word |= if high < 64 { low & !(u64::MAX << high) } else { low };
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn runs_fill_what_they_were_found_in(row in prop::collection::vec(any::<bool>(), 1..200)) {
            let mut words = vec![0u64; row.len().div_ceil(64)];
            for (x, _) in row.iter().enumerate().filter(|(_, is_in)| **is_in) {
                words[x / 64] |= 1 << (x % 64);
            }
            let (mut again, mut end) = (vec![0; words.len()], None);
            runs(&words, row.len(), |run| {
                assert!(run[0] < run[1] && Some(run[0]) > end, "{run:?} after {end:?}");
                end = Some(run[1]);
                fill(&mut again, run);
            });
            prop_assert_eq!(&again, &words);
            prop_assert!((0..row.len()).all(|x| bit(&words, x) == row[x]));
        }
    }
}
