//! The form that people write and read.
//!
//! Scenes are read strictly: an unknown field is an error that names it, and every
//! error says where. Replies are written one object to a line.

mod forms;
mod reply;

pub(crate) use forms::one_or_many;
pub use reply::{reply_to_json, write_reply};

use crate::message::{ErrorCode, Refusal, SceneRequest};

/// A scene that can't be read: why, and the id that it seems to have.
#[derive(Debug, Clone, PartialEq)]
pub struct UnreadableScene {
    /// The scene's id, where that much can be read.
    pub id: Option<u64>,
    /// An `invalid_scene` refusal with the field at fault.
    pub refusal: Refusal,
}

/// Reads a scene request.
pub fn read_scene(text: &str) -> Result<SceneRequest, UnreadableScene> {
    let deserializer = &mut serde_json::Deserializer::from_str(text);
    let scene: Result<SceneRequest, _> = serde_path_to_error::deserialize(&mut *deserializer);
    let scene = scene.map_err(|error| {
        let (path, error) = (error.path().to_string(), error.inner());
        let field = match (error.classify(), path.as_str()) {
            (serde_json::error::Category::Data, "." | "?") => "scene".to_owned(),
            (serde_json::error::Category::Data, _) => path,
            _ => "scene".to_owned(),
        };
        let message = match error.classify() {
            serde_json::error::Category::Data => format!("{field}: {error}"),
            _ => format!("not JSON: {error}"),
        };
        unreadable(text, Refusal::invalid(field, message))
    })?;
    deserializer.end().map_err(|error| {
        unreadable(text, Refusal::invalid("scene", format!("not one JSON object: {error}")))
    })?;
    Ok(scene)
}

/// Writes a scene request as people would.
pub fn scene_to_json(scene: &SceneRequest) -> String {
    let mut value = serde_json::to_value(scene).expect("scenes have text keys only");
    without_nulls(&mut value);
    value.to_string()
}

fn unreadable(text: &str, refusal: Refusal) -> UnreadableScene {
    #[derive(serde::Deserialize)]
    struct OnlyId {
        id: Option<u64>,
    }
    debug_assert_eq!(refusal.code, ErrorCode::InvalidScene);
    let id = serde_json::from_str(text).ok().and_then(|OnlyId { id }| id);
    UnreadableScene { id, refusal }
}

fn without_nulls(value: &mut serde_json::Value) {
    if let serde_json::Value::Object(fields) = value {
        fields.retain(|_, field| !field.is_null());
        fields.values_mut().for_each(without_nulls);
    }
}
