//! Scenes whose free space is a map.

use std::collections::BTreeMap;

use schemas::json::{self, UnreadableScene};
use schemas::message::{FreeSpace, Refusal, SceneRequest, Task};
use serde::de::IgnoredAny;

/// Reads a `drive` scene that leaves out its free space, which is `map`.
pub fn read_scene(text: &str, map: &FreeSpace) -> Result<SceneRequest, UnreadableScene> {
    // What is not an object is best told so by the reader itself.
    let Ok(fields) = serde_json::from_str::<BTreeMap<String, IgnoredAny>>(text) else {
        return json::read_scene(text);
    };
    if fields.contains_key("free_space") {
        let message = "free_space: the scene has its own and --map gives another; leave one out";
        let id = json::read_scene(text).map_or_else(|error| error.id, |scene| scene.id);
        return Err(UnreadableScene { id, refusal: Refusal::invalid("free_space", message) });
    }
    // At the end, so that errors stay at the lines and columns where people see them.
    let mut text = text.trim_end().to_owned();
    text.pop();
    text.push_str(if fields.is_empty() { "" } else { "," });
    text.push_str("\"free_space\":{}}");
    let mut scene = json::read_scene(&text)?;
    if scene.task != Task::Drive {
        let message = "task: a map is for task \"drive\" only";
        return Err(UnreadableScene { id: scene.id, refusal: Refusal::invalid("task", message) });
    }
    scene.free_space = map.clone();
    Ok(scene)
}
