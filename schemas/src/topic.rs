//! Names on the bus and in recordings.

use crate::wire;

/// The service that answers scene requests.
pub const PLAN: &str = "clearway/plan";
/// The event by which clients wake the planner.
pub const WAKE: &str = "clearway/wake";
/// The event by which the planner wakes its clients.
pub const ANSWERED: &str = "clearway/answered";
/// The planner's copy of all traffic, for recorders.
pub const TAP: &str = "clearway/tap";

/// Topic of recorded requests.
pub const REQUEST: &str = "/planner/request";
/// Topic of recorded reply parts.
pub const REPLY: &str = "/planner/reply";
/// Profile of recordings.
pub const PROFILE: &str = "planning";
/// Message and schema encoding of recordings.
pub const ENCODING: &str = "bincode";

/// Names the layout of messages in shared memory: FNV-1a over [`wire::LAYOUT`].
///
/// It stands in the type names on the bus: the same name and size with different
/// fields would connect silently.
pub const fn layout_hash() -> u64 {
    let text = wire::LAYOUT.as_bytes();
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut index = 0;
    while index < text.len() {
        hash = (hash ^ text[index] as u64).wrapping_mul(0x0000_0100_0000_01b3);
        index += 1;
    }
    hash
}
