//! Codes and what they stand for.

use super::Malformed;

/// The value that a code stands for.
pub(super) fn value<T: Copy>(what: &'static str, table: &[T], code: u64) -> Result<T, Malformed> {
    usize::try_from(code)
        .ok()
        .and_then(|code| table.get(code))
        .copied()
        .ok_or(Malformed::UnknownCode { what, code, greatest: table.len() as u64 - 1 })
}

/// The code that stands for a value.
pub(super) fn code<T: PartialEq>(table: &[T], value: T) -> u32 {
    table.iter().position(|entry| *entry == value).expect("tables are complete") as u32
}
