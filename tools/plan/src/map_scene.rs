//! Scenes whose free space is a map.

use std::collections::BTreeMap;

use schemas::json::{self, UnreadableScene};
use schemas::message::{FreeSpace, Refusal, SceneRequest, Task};
use serde::de::IgnoredAny;

/// Reads a `drive` scene that has no free space of its own: `map` is its free space.
pub(crate) fn read_scene(text: &str, map: &FreeSpace) -> Result<SceneRequest, UnreadableScene> {
    // The reader itself reports what is not an object.
    let fields = match serde_json::from_str::<BTreeMap<String, IgnoredAny>>(text) {
        Ok(fields) if !fields.is_empty() => fields,
        _ => return json::read_scene(text),
    };
    if fields.contains_key("free_space") {
        let message = "free_space is given by the scene and by --map; leave one out";
        let id = json::read_scene(text).map_or_else(|error| error.id, |scene| scene.id);
        return Err(UnreadableScene { id, refusal: Refusal::invalid("free_space", message) });
    }
    // Appended, so that errors keep their lines and columns.
    let mut text = text.trim_end().to_owned();
    text.pop();
    text.push_str(",\"free_space\":{}}");
    let mut scene = json::read_scene(&text)?;
    if scene.task != Task::Drive {
        let message = "task must be \"drive\" with --map";
        return Err(UnreadableScene { id: scene.id, refusal: Refusal::invalid("task", message) });
    }
    scene.free_space = map.clone();
    Ok(scene)
}

#[cfg(test)]
mod tests {
    use schemas::message::AxisBox;

    use super::*;

    const SCENE: &str = r#"{ "id": 3, "task": "drive",
        "body": { "footprint": { "width": 1, "length": 1 } },
        "clearance": "safest" }
    "#;

    fn map() -> FreeSpace {
        let bounds = Some(AxisBox { min: [0.0, 0.0].into(), max: [9.0, 9.0].into() });
        FreeSpace { solids: Some(Vec::new()), bounds, ..FreeSpace::default() }
    }

    #[test]
    fn the_map_is_the_free_space() {
        let scene = read_scene(SCENE, &map()).unwrap();
        assert_eq!((scene.id, scene.free_space), (Some(3), map()));
    }

    #[track_caller]
    fn check(text: &str, id: Option<u64>, field: &str, message: &str) {
        let error = read_scene(text, &map()).unwrap_err();
        assert_eq!(error.id, id);
        assert_eq!(error.refusal.field.as_deref(), Some(field));
        assert_eq!(error.refusal.message, message);
    }

    #[test]
    fn a_scene_with_its_own_free_space_is_refused() {
        let message = "free_space is given by the scene and by --map; leave one out";
        for own in ["{}", "null", r#"{"channels": []}"#] {
            let text = SCENE.replacen('{', &format!("{{ \"free_space\": {own},"), 1);
            check(&text, Some(3), "free_space", message);
        }
    }

    #[test]
    fn an_assembly_scene_is_refused() {
        let text = SCENE.replace("drive", "assemble");
        check(&text, Some(3), "task", "task must be \"drive\" with --map");
    }

    #[test]
    fn errors_keep_their_lines_and_columns() {
        for text in ["", "7", "[]", "{", "{}", "{ \"id\": 1, }", "{ \"id\": 1, \"id\": 2 }", "{}{}"]
        {
            let (with, without) = (read_scene(text, &map()), json::read_scene(text));
            assert_eq!(with, without, "{text:?}");
        }
        let text = SCENE.replace("\"body\"", "\"bodies\"");
        let message = json::read_scene(&text).unwrap_err().refusal.message;
        assert!(message.contains("bodies is not a known field"), "{message}");
        check(&text, Some(3), "bodies", &message);
    }
}
