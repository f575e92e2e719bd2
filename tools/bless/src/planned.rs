//! Replies planned in this process.

use schemas::message::{Reply, Request, RequestContent, RequestKey, SceneRequest};

/// Plans a scene in this process.
pub(crate) fn planned(scene: &SceneRequest) -> Reply {
    let content = RequestContent::Scene(scene.clone());
    let request = Request { key: RequestKey::default(), sent_ns: 0, content };
    answer::reply_to(&request, &answer::Caps::default())
}
