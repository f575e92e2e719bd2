//! What keeps every input cheap.

use answer::Caps;

/// Caps under which no request takes long.
pub(crate) fn small_caps() -> Caps {
    Caps {
        cells: 1 << 14,
        steps: 1 << 20,
        bytes: 1 << 24,
        answers: 8,
        samples: 2_000,
        pieces: 2_000,
        channels: 500,
        channel_steps: 1 << 16,
        junctions: 2_000,
        route_steps: 1 << 14,
    }
}
