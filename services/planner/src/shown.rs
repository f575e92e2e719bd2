//! Free spaces that recorders are shown, because they were sent before those came.

use answer::Store;
use bus::Server;
use schemas::convert;
use schemas::message::{Digest, RequestKey, SceneRequest};

/// Recorders see the free space of this name, before a request that only names it.
pub(crate) fn show(server: &Server, store: &Store, name: Digest) {
    if !server.recorders_lack(name) {
        return;
    }
    // A name that nobody knows is refused, and nobody misses its free space.
    let Some(known) = store.named(name) else { return };
    let scene = SceneRequest { free_space: (*known).clone(), ..SceneRequest::empty() };
    let mut cells = Vec::new();
    match convert::write_scene(&scene, RequestKey::default(), bus::now_ns(), &mut cells) {
        Ok(header) => server.show_free_space(name, &header, &cells),
        Err(refusal) => tracing::warn!(%name, reason = refusal.message, "can't show a free space"),
    }
}
