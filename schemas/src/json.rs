//! The form that people write and read.
//!
//! Scenes are read strictly: an unknown field is an error that names it, and every
//! error says where. Replies are written one object to a line. JSON knows neither
//! infinity nor NaN: such numbers are written as `null`.

mod read;
mod reply;
mod scene;
mod tree;

pub use reply::{reply_to_json, write_reply};
pub use scene::scene_to_json;

use crate::message::{Refusal, SceneRequest};

/// A scene that can't be read: why, and the id that it seems to have.
#[derive(Debug, Clone, PartialEq)]
pub struct UnreadableScene {
    /// The scene's id, where that much can be read.
    pub id: Option<u64>,
    /// An `invalid_scene` refusal with the field at fault.
    pub refusal: Refusal,
}

/// Reads a scene request. `null` stands for a field that is not given.
pub fn read_scene(text: &str) -> Result<SceneRequest, UnreadableScene> {
    tree::parse(text)
        .and_then(|tree| read::scene(&tree))
        .map_err(|refusal| UnreadableScene { id: tree::find_id(text), refusal })
}
