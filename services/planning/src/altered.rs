//! Another rule in Table 1, for tests of what compares replies. Only debug builds with the feature
//! `altered-rules` have it, so that no program that is released can plan by anything but the rules.

use std::cell::Cell;

thread_local! {
    static ALTERED: Cell<Option<u8>> = const { Cell::new(None) };
}

/// Runs `plan`. What it plans on this thread follows Table 1 with rule `number`, of 1 to 8, altered:
/// the body goes to the other side of the junction, left for right.
pub fn with_rule_altered<T>(number: u8, plan: impl FnOnce() -> T) -> T {
    let before = ALTERED.replace(Some(number));
    let planned = plan();
    ALTERED.set(before);
    planned
}

pub(crate) fn is_altered(number: u8) -> bool {
    ALTERED.get() == Some(number)
}
