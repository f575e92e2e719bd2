//! Scenes as JSON, up to their replies.

use schemas::convert;
use schemas::json;
use schemas::message::{Request, RequestContent, RequestKey, SceneRequest};

use crate::limits::small_caps;
use crate::reply::check_reply;

/// A scene in JSON.
pub fn scene(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let scene = match json::read_scene(text) {
        Ok(scene) => scene,
        Err(unreadable) => {
            assert!(!unreadable.refusal.message.is_empty(), "{unreadable:?}");
            return;
        }
    };
    let written = json::scene_to_json(&scene);
    let again = json::read_scene(&written);
    assert!(again.as_ref() == Ok(&scene), "{scene:?}\nbecame {again:?}\nby {written}");

    let key = RequestKey { client: 1, sequence: 2 };
    let mut cells = Vec::new();
    if let Ok(header) = convert::write_scene(&scene, key, 3, &mut cells) {
        let mut read = SceneRequest::empty();
        let done = convert::read_scene(&header, &cells, &mut read);
        assert!(done.is_ok() && read == scene, "{scene:?}\nbecame {read:?}: {done:?}");
    }
    let content = RequestContent::Scene(scene);
    check_reply(&answer::reply_to(&Request { key, sent_ns: 3, content }, &small_caps()));
}
