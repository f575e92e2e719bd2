//! Version 1 of the layout, for clients that are not upgraded yet.
//!
//! A planner serves two versions side by side, each as a service with its own name and
//! type names, so a new field does not disconnect every client: upgrade the planner and
//! its recorders first, then the clients one by one. Version 1 has the structures of
//! version 2; it lacks a refusal's setting and the code `too_costly`, which it calls
//! `invalid_scene`.
//!
//! This module is the whole difference between the versions: the crate `bus` serves both
//! with one code path and asks here what to change on the way in and out.
//!
//! # Adding version 3
//!
//! 1. Version 1 ends here: delete what this file holds, and the tests of its shared memory.
//!    (Recordings of version 1 stay readable; see [`crate::codec`].)
//! 2. Freeze version 2 here: its number, service name (the present
//!    [`topic::PLAN`](crate::topic::PLAN)), layout hash as a literal, and copies of the
//!    structures that version 3 changes; the type aliases below stay for the others.
//! 3. Change [`wire`](super), raise [`wire::VERSION`](super::VERSION), give `topic::PLAN`
//!    and `topic::TAP` new names, and write the translations here. The compiler and
//!    `PIN=1 cargo test -p clearway-schemas` find the rest.

use super::present;

/// Its number.
pub const VERSION: u32 = 1;

/// The name of its service on the bus.
pub const PLAN: &str = "clearway/plan";

/// The hash in its type names, `clearway::RequestHeader#...` and `clearway::ReplyHeader#...`.
/// Version 1 took it over the words of its description.
pub const LAYOUT_HASH: u64 = 0x35c7_081f_0ebf_6be2;

/// Unchanged in version 2.
pub type RequestHeader = super::RequestHeader;

/// Unchanged in version 2.
pub type ReplyHeader = super::ReplyHeader;

/// `invalid_scene`, and what version 1 does not know.
const INVALID_SCENE: u64 = 0;
const TOO_COSTLY: u64 = 14;

/// Cells of a refusal before its text; version 2 has one more, the setting's length.
const REFUSAL_CELLS: usize = 11;

/// A request in the current version. The payload is the same in both.
pub fn upgrade_request(header: &RequestHeader) -> super::RequestHeader {
    let version = match header.version {
        VERSION => super::VERSION,
        // Not a version-1 request, and not to be taken for a good one either.
        super::VERSION => VERSION,
        other => other,
    };
    super::RequestHeader { version, ..*header }
}

/// Whether a part's payload is the same in both versions.
pub fn same_payload(header: &super::ReplyHeader) -> bool {
    header.kind != 1
}

/// The header of a part in version 1.
pub fn downgrade_header(header: &super::ReplyHeader) -> ReplyHeader {
    ReplyHeader { version: VERSION, ..*header }
}

/// A refusal in version 1: its header, and its payload in `old`. The part must be one
/// that [`crate::convert::write_refusal`] wrote.
pub fn downgrade_refusal(
    header: &super::ReplyHeader,
    cells: &[u64],
    old: &mut Vec<u64>,
) -> ReplyHeader {
    let (head, rest) = cells.split_at(REFUSAL_CELLS);
    let text: u64 = head[REFUSAL_CELLS - 2..].iter().map(|bytes| bytes.div_ceil(8)).sum();
    old.clear();
    old.push(if head[0] == TOO_COSTLY { INVALID_SCENE } else { head[0] });
    old.push(head[1] & !present::SETTING);
    old.extend_from_slice(&head[2..]);
    old.extend_from_slice(&rest[1..=text as usize]);
    ReplyHeader { refusal: old.len() as u32, ..downgrade_header(header) }
}
