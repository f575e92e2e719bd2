//! What `docs/wire.md` says of names and of the layout.

use std::fmt::Write;

use schemas::topic;
use schemas::wire::{self, previous};

/// The services of the bus and what they carry.
pub(crate) fn services() -> String {
    let mut table = String::from(
        "| service | pattern | who | header | payload |\n\
         |---|---|---|---|---|\n",
    );
    let plan = [
        (topic::PLAN, wire::VERSION, wire::layout_hash()),
        (previous::PLAN, previous::VERSION, previous::LAYOUT_HASH),
    ];
    for (name, version, hash) in plan {
        _ = writeln!(
            table,
            "| `{name}` | request-response | clients of version {version}, planner | \
             `clearway::RequestHeader#{hash:016x}`, `clearway::ReplyHeader#{hash:016x}` | `[u64]`, `[u64]` |"
        );
    }
    let hash = wire::layout_hash();
    _ = writeln!(
        table,
        "| `{}` | publish-subscribe | planner to recorders | `clearway::TapHeader#{hash:016x}` | `[u64]` |",
        topic::TAP
    );
    _ = writeln!(table, "| `{}` | event | clients ring, the planner listens | | |", topic::WAKE);
    _ = writeln!(
        table,
        "| `{}` | event | the planner rings, each client listens | | |",
        topic::ANSWERED
    );
    _ = writeln!(
        table,
        "| `{}` | publish-subscribe | planner to anybody | | `[u8]`: JSON |",
        topic::STATUS
    );
    table
}

/// The layout of the current version.
pub(crate) fn layout() -> String {
    format!("```text\n{}```\n", wire::layout_text())
}
