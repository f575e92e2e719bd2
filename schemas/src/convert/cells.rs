//! Cells one after the other.

use bytemuck::Pod;
use thiserror::Error;

/// Why memory is not a message.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Malformed {
    /// The message declares more than there is.
    #[error("{what} needs {needs} cells, {has} are left")]
    TooShort {
        /// What was being read.
        what: &'static str,
        /// Cells declared.
        needs: u64,
        /// Cells left.
        has: u64,
    },
    /// There is more memory than the message declares.
    #[error("{left} cells follow the end of the message")]
    TrailingCells {
        /// Cells too many.
        left: u64,
    },
    /// A number is no known code.
    #[error("{what} is {code}; the greatest known value is {greatest}")]
    UnknownCode {
        /// The field.
        what: &'static str,
        /// What was read.
        code: u64,
        /// The greatest known code.
        greatest: u64,
    },
    /// A number contradicts another part of the message.
    #[error("{what} is {has}, must be {needs} {when}")]
    Mismatch {
        /// The field.
        what: &'static str,
        /// What was read.
        has: u64,
        /// What it must be.
        needs: u64,
        /// The reason.
        when: &'static str,
    },
    /// A text is not UTF-8.
    #[error("{what} is not UTF-8 at byte {at}")]
    NotText {
        /// Which text.
        what: &'static str,
        /// The first byte that is not.
        at: u64,
    },
}

/// Fails unless a number agrees with the rest of the message.
pub(super) fn demand(
    what: &'static str,
    has: impl Into<u64>,
    needs: u64,
    when: &'static str,
) -> Result<(), Malformed> {
    match has.into() {
        has if has == needs => Ok(()),
        has => Err(Malformed::Mismatch { what, has, needs, when }),
    }
}

/// Takes cells from the front.
pub(super) struct CellReader<'a> {
    cells: &'a [u64],
}

impl<'a> CellReader<'a> {
    pub(super) fn new(cells: &'a [u64]) -> Self {
        Self { cells }
    }

    /// The next `count` items of `size` cells each. Fails before anything is reserved.
    pub(super) fn take(
        &mut self,
        what: &'static str,
        count: u64,
        size: usize,
    ) -> Result<&'a [u64], Malformed> {
        let has = self.cells.len() as u64;
        match count.checked_mul(size as u64) {
            Some(needs) if needs <= has => {
                let (taken, rest) = self.cells.split_at(needs as usize);
                self.cells = rest;
                Ok(taken)
            }
            needs => Err(Malformed::TooShort { what, needs: needs.unwrap_or(u64::MAX), has }),
        }
    }

    pub(super) fn next(&mut self, what: &'static str) -> Result<u64, Malformed> {
        Ok(self.take(what, 1, 1)?[0])
    }

    /// A count of items that take at least a cell each, so that nobody reserves
    /// memory for more than can be there.
    pub(super) fn count(&mut self, what: &'static str) -> Result<usize, Malformed> {
        let count = self.next(what)?;
        self.expect(what, count)?;
        Ok(count as usize)
    }

    /// Fails unless at least `needs` cells are left.
    pub(super) fn expect(&self, what: &'static str, needs: u64) -> Result<(), Malformed> {
        let has = self.cells.len() as u64;
        if needs <= has { Ok(()) } else { Err(Malformed::TooShort { what, needs, has }) }
    }

    pub(super) fn end(self) -> Result<(), Malformed> {
        match self.cells.len() {
            0 => Ok(()),
            left => Err(Malformed::TrailingCells { left: left as u64 }),
        }
    }
}

/// Fills memory from the front.
#[derive(Debug)]
pub struct CellWriter<'a> {
    cells: &'a mut [u64],
    filled: usize,
}

impl<'a> CellWriter<'a> {
    /// Fills `cells`.
    pub fn new(cells: &'a mut [u64]) -> Self {
        Self { cells, filled: 0 }
    }

    /// Writes one cell.
    #[inline]
    pub fn push(&mut self, cell: u64) {
        self.cells[self.filled] = cell;
        self.filled += 1;
    }

    /// Writes a number.
    #[inline]
    pub fn push_f64(&mut self, value: f64) {
        self.push(value.to_bits());
    }

    /// Writes a structure whose size is a multiple of a cell's.
    #[inline]
    pub fn push_pod<T: Pod>(&mut self, value: &T) {
        let bytes = bytemuck::bytes_of(value);
        let end = self.filled + bytes.len() / 8;
        bytemuck::cast_slice_mut(&mut self.cells[self.filled..end]).copy_from_slice(bytes);
        self.filled = end;
    }

    /// The cells written so far.
    pub fn written(&self) -> &[u64] {
        &self.cells[..self.filled]
    }

    /// How many cells are written.
    pub fn filled(&self) -> usize {
        self.filled
    }
}
