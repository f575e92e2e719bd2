//! Scenes and replies as JSON.
//!
//! One set of types with serde reads and writes both; the published JSON Schemas
//! (`schemas/json/*.schema.json`, feature `json-schema`) are generated from the same types.
//!
//! Reading is strict: unknown fields, repeated fields and wrong types are errors that name
//! the field as a path such as `free_space.channels[3].min[1]`. `null` is the same as a field
//! left out. JSON has no infinity and no NaN; these numbers are written as `null`.

mod clearance;
mod digest;
mod fault;
mod footprint;
mod half_space;
mod leg;
mod read;
mod reply;
mod scene;
#[cfg(feature = "json-schema")]
pub mod schema;
mod trajectory;
mod tree;
mod values;

use std::io;

use thiserror::Error;

use crate::message::{Refusal, Reply, SceneRequest};
use fault::Fault;
use reply::ReplyJson;
use scene::SceneJson;

/// A scene that can't be read: why, and the id that it seems to have.
#[derive(Debug, Clone, PartialEq)]
pub struct UnreadableScene {
    /// The scene's id, if that much can be read.
    pub id: Option<u64>,
    /// A refusal with the code `invalid_scene` that names the field at fault.
    pub refusal: Refusal,
}

/// A reply that can't be read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct UnreadableReply {
    /// The field at fault, as a path.
    pub field: String,
    /// What is wrong with it.
    pub message: String,
}

/// Reads a scene request.
///
/// ```
/// use schemas::json;
/// use schemas::message::Task;
///
/// let text = r#"{
///     "task": "disassemble",
///     "free_space": { "channels": [{ "min": [4, 1], "max": [7, 6] }] },
///     "body": { "box": { "min": [4.5, 1], "max": [6.5, 4] } },
///     "clearance": { "gap": 0.2 }
/// }"#;
/// let scene = json::read_scene(text).unwrap();
/// assert_eq!(scene.task, Task::Disassemble);
///
/// let unreadable = json::read_scene(&text.replace("0.2", "\"wide\"")).unwrap_err();
/// assert_eq!(
///     unreadable.refusal.message,
///     "clearance.gap must be a number or a list of 1 to 3 numbers, not the text \"wide\""
/// );
/// ```
pub fn read_scene(text: &str) -> Result<SceneRequest, UnreadableScene> {
    let check = half_space::check_plane;
    read(text, "scene", check, SceneJson::into_message).map_err(|(field, message)| {
        UnreadableScene { id: tree::find_id(text), refusal: Refusal::invalid(field, message) }
    })
}

/// Reads a reply. Its key is zero, which JSON does not carry, as it does not carry which
/// way a robot turned that turned by half a turn in place (to the left, then), nor, where there are
/// no gaps, how many there are for each junction (1, then).
///
/// ```
/// use schemas::json;
/// use schemas::message::ErrorCode;
///
/// let text = r#"{"id":7,"error":{"code":"no_route","message":"...","needs":2.5,"has":2.25}}"#;
/// let reply = json::read_reply(text).unwrap();
/// assert_eq!(reply.answers.as_ref().unwrap_err().code, ErrorCode::NoRoute);
/// assert_eq!(json::reply_to_json(&reply), text);
/// ```
pub fn read_reply(text: &str) -> Result<Reply, UnreadableReply> {
    read(text, "reply", |_| Ok(()), ReplyJson::into_message)
        .map_err(|(field, message)| UnreadableReply { field, message })
}

/// Reads through a tree, which `check` sees once its forms are right; an error is the field at
/// fault and the message.
fn read<J, M>(
    text: &str,
    root: &str,
    check: fn(&tree::Node<'_>) -> Result<(), Fault>,
    into_message: fn(J) -> Result<M, Fault>,
) -> Result<M, (String, String)>
where
    J: for<'de> serde::Deserialize<'de>,
{
    let tree = tree::parse(text, root).map_err(|fault| (fault.path, fault.message))?;
    let message = read::read(&tree).and_then(into_message);
    message.and_then(|message| check(&tree).map(|()| message)).map_err(|fault| fault.tell(root))
}

/// Writes a scene request on one line.
pub fn scene_to_json(scene: &SceneRequest) -> String {
    serde_json::to_string(&SceneJson::from(scene)).expect("a String takes any text")
}

/// Writes a reply as one JSON object, without a line end.
pub fn write_reply(reply: &Reply, writer: impl io::Write) -> io::Result<()> {
    Ok(serde_json::to_writer(writer, &ReplyJson::from(reply))?)
}

/// A reply as one JSON object on one line.
///
/// ```
/// use schemas::json;
/// use schemas::message::{ErrorCode, Refusal, Reply, RequestKey};
///
/// let refusal = Refusal { has: Some(2.4), ..Refusal::new(ErrorCode::NoRoute, "blocked") };
/// let reply = Reply { key: RequestKey::default(), id: Some(7), answers: Err(refusal) };
/// assert_eq!(
///     json::reply_to_json(&reply),
///     r#"{"id":7,"error":{"code":"no_route","message":"blocked","has":2.4}}"#
/// );
/// ```
pub fn reply_to_json(reply: &Reply) -> String {
    serde_json::to_string(&ReplyJson::from(reply)).expect("a String takes any text")
}
