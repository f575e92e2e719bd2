//! A file, looked at anywhere.

use std::io::{self, Read, Seek, SeekFrom};

use crate::error::ReadError;
use crate::fields::{Fields, RECORD_HEAD};

/// A file, looked at anywhere; a piece of it is kept.
pub(crate) struct Source<R> {
    input: R,
    /// Bytes of the file.
    pub(crate) length: u64,
    piece: Vec<u8>,
    /// Where the piece begins.
    start: u64,
}

/// Bytes read at a time.
const PIECE: usize = 256 << 10;

impl<R: Read + Seek> Source<R> {
    pub(crate) fn new(mut input: R) -> Result<Self, ReadError> {
        let length = input.seek(SeekFrom::End(0));
        let length = length.map_err(|source| ReadError::Io { offset: 0, source })?;
        Ok(Self { input, length, piece: Vec::new(), start: 0 })
    }

    /// `count` bytes from `at` on; none if the file ends before.
    pub(crate) fn get(&mut self, at: u64, count: usize) -> Result<Option<&[u8]>, ReadError> {
        if at.checked_add(count as u64).is_none_or(|end| end > self.length) {
            return Ok(None);
        }
        let is_there =
            at >= self.start && at + count as u64 <= self.start + self.piece.len() as u64;
        if !is_there {
            let bytes = (count.max(PIECE) as u64).min(self.length - at);
            self.piece.clear();
            self.start = at;
            let read = self
                .input
                .seek(SeekFrom::Start(at))
                .and_then(|_| (&mut self.input).take(bytes).read_to_end(&mut self.piece))
                .map_err(|source| ReadError::Io { offset: at, source })?;
            if read < count {
                let source = io::ErrorKind::UnexpectedEof.into();
                return Err(ReadError::Io { offset: at, source });
            }
        }
        let from = (at - self.start) as usize;
        Ok(Some(&self.piece[from..from + count]))
    }

    /// Opcode and length of the record at `at`; none if the file ends before its head or inside it.
    pub(crate) fn head(&mut self, at: u64) -> Result<Option<(u8, u64)>, ReadError> {
        let Some(head) = self.get(at, RECORD_HEAD)? else { return Ok(None) };
        let mut fields = Fields(head);
        let (Some(opcode), Some(length)) = (fields.u8(), fields.u64()) else { return Ok(None) };
        let end = (at + RECORD_HEAD as u64).checked_add(length);
        Ok(end.filter(|end| *end <= self.length).map(|_| (opcode, length)))
    }

    /// The body of the record at `at`, if it is whole and no longer than `most`.
    pub(crate) fn body(&mut self, at: u64, most: usize) -> Result<Option<&[u8]>, ReadError> {
        let length = self.head(at)?.and_then(|(_, length)| usize::try_from(length).ok());
        match length.filter(|length| *length <= most) {
            Some(length) => self.get(at + RECORD_HEAD as u64, length),
            None => Ok(None),
        }
    }

    /// Where `pattern` is next, from `at` on.
    pub(crate) fn find(&mut self, pattern: &[u8], mut at: u64) -> Result<Option<u64>, ReadError> {
        loop {
            // What is at hand first: else each find would read anew.
            let at_hand = (self.start + self.piece.len() as u64).saturating_sub(at);
            let is_at_hand = at >= self.start && at_hand >= pattern.len() as u64;
            let count = if is_at_hand { at_hand } else { PIECE as u64 };
            let count = (self.length.saturating_sub(at)).min(count) as usize;
            if count < pattern.len() {
                return Ok(None);
            }
            let Some(bytes) = self.get(at, count)? else { return Ok(None) };
            let mut from = 0;
            while let Some(next) = bytes[from..].iter().position(|byte| *byte == pattern[0]) {
                from += next;
                match bytes[from..].get(..pattern.len()) {
                    Some(found) if found == pattern => return Ok(Some(at + from as u64)),
                    Some(_) => from += 1,
                    None => break,
                }
            }
            // What could begin at the end is looked at again.
            at += (count - pattern.len() + 1) as u64;
        }
    }
}
