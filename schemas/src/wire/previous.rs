//! Version 1 of the layout, for clients that are not upgraded yet.
//!
//! A planner serves two versions side by side, each as a service with its own name and
//! type names, so a new field does not disconnect every client: upgrade the planner and
//! its recorders first, then the clients one by one. Version 1's headers are the beginnings of
//! version 2's. It lacks what a request may say of a robot, `bound`, `free_clearance` and
//! `complete` of a trajectory, a leg's rung, a refusal's setting, and the codes `too_costly` and
//! `unknown_free_space`, which it calls `invalid_scene`.
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

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};

use super::{LEG_CELLS, given, present, reported};

/// Its number.
pub const VERSION: u32 = 1;

/// The name of its service on the bus.
pub const PLAN: &str = "clearway/plan";

/// The hash in its type names, `clearway::RequestHeader#...` and `clearway::ReplyHeader#...`.
/// Version 1 took it over the words of its description.
pub const LAYOUT_HASH: u64 = 0x35c7_081f_0ebf_6be2;

/// A request's header: version 2's up to `solids`, as words.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RequestHeader(pub [u64; 34]);

/// The header of a part of a reply: version 2's up to `refusal`, as words. In place of the bits
/// `given` it has 1 or 0 for the id.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ReplyHeader(pub [u64; 19]);

const _: () = {
    assert!(offset_of!(super::RequestHeader, switches) == size_of::<RequestHeader>());
    assert!(offset_of!(super::ReplyHeader, bound) == size_of::<ReplyHeader>());
};

impl Default for RequestHeader {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl Default for ReplyHeader {
    fn default() -> Self {
        Self::zeroed()
    }
}

/// The bits of `given` that version 1 defines.
const GIVEN: u64 = (given::LIMITS << 5) - 1;

/// A bit of `given` that no version defines.
const UNDEFINED: u64 = 1 << 63;

/// `invalid_scene`, and the least code that version 1 does not know.
const INVALID_SCENE: u64 = 0;
const TOO_COSTLY: u64 = 14;

/// Cells of a refusal before its text; version 2 has one more, the setting's length.
const REFUSAL_CELLS: usize = 11;

/// A request in the current version. The payload is the same in both.
pub fn upgrade_request(header: &RequestHeader) -> super::RequestHeader {
    let mut upgraded = super::RequestHeader::default();
    let old = bytemuck::bytes_of(header);
    bytemuck::bytes_of_mut(&mut upgraded)[..old.len()].copy_from_slice(old);
    upgraded.version = match upgraded.version {
        VERSION => super::VERSION,
        // Not a version-1 request, and not to be taken for a good one either.
        super::VERSION => VERSION,
        other => other,
    };
    if upgraded.given & !GIVEN != 0 {
        upgraded.given |= UNDEFINED;
    }
    upgraded
}

/// A part in version 1: its header, and its payload in `old`. It must be one that
/// [`crate::convert::TrajectoryWriter`] or [`crate::convert::write_refusal`] wrote.
pub fn downgrade(header: &super::ReplyHeader, cells: &[u64], old: &mut Vec<u64>) -> ReplyHeader {
    if header.kind == 1 {
        return downgrade_refusal(header, cells, old);
    }
    old.clear();
    old.extend_from_slice(cells);
    downgrade_trajectory(header, old);
    downgrade_header(header)
}

/// The header of a part in version 1.
fn downgrade_header(header: &super::ReplyHeader) -> ReplyHeader {
    let given = header.given & reported::ID;
    let header = super::ReplyHeader { version: VERSION, given, ..*header };
    let bytes = &bytemuck::bytes_of(&header)[..size_of::<ReplyHeader>()];
    bytemuck::pod_read_unaligned(bytes)
}

/// Makes the payload of a trajectory that of version 1, in place.
fn downgrade_trajectory(header: &super::ReplyHeader, cells: &mut [u64]) {
    let before = header.gaps as usize
        + header.route as usize
        + 2 * header.dimension as usize * header.channels as usize;
    let legs = &mut cells[before..][..header.legs as usize * LEG_CELLS];
    for leg in bytemuck::cast_slice_mut::<u64, super::Leg>(legs) {
        (leg.rung, leg.reverse) = (0, 0);
    }
}

/// A refusal in version 1.
fn downgrade_refusal(
    header: &super::ReplyHeader,
    cells: &[u64],
    old: &mut Vec<u64>,
) -> ReplyHeader {
    let (head, rest) = cells.split_at(REFUSAL_CELLS);
    let text: u64 = head[REFUSAL_CELLS - 2..].iter().map(|bytes| bytes.div_ceil(8)).sum();
    old.clear();
    old.push(if head[0] >= TOO_COSTLY { INVALID_SCENE } else { head[0] });
    old.push(head[1] & !present::SETTING);
    old.extend_from_slice(&head[2..]);
    old.extend_from_slice(&rest[1..=text as usize]);
    downgrade_header(&super::ReplyHeader { refusal: old.len() as u32, ..*header })
}
