//! Scenes with other values than recorded: `--with limits.speed=0.8`.

use std::str::FromStr;

use schemas::json;
use schemas::message::{Refusal, SceneRequest};
use serde_json::{Map, Value};

/// A field of a scene and what it is set to.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FieldChange {
    /// From the outermost field inwards.
    path: Vec<String>,
    value: Value,
}

impl FromStr for FieldChange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (path, value) =
            text.split_once('=').ok_or("must be a field and its value: limits.speed=0.8")?;
        let path: Vec<_> = path.trim().split('.').map(str::to_owned).collect();
        let is_name = |name: &String| {
            !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        if !path.iter().all(is_name) {
            return Err("a field is names with dots between, such as limits.speed".to_owned());
        }
        // What is no JSON is a text: clearance=safest.
        let value = serde_json::from_str(value.trim());
        let value = value.unwrap_or_else(|_| {
            Value::String(text[text.find('=').unwrap_or(0) + 1..].trim().to_owned())
        });
        Ok(Self { path, value })
    }
}

/// The scene with these changes; an error says why it is no scene with them.
pub(crate) fn changed(
    scene: &SceneRequest,
    changes: &[FieldChange],
) -> Result<SceneRequest, Refusal> {
    let mut tree: Value =
        serde_json::from_str(&json::scene_to_json(scene)).expect("it was just written");
    for FieldChange { path, value } in changes {
        let mut place = &mut tree;
        for name in path {
            if !place.is_object() {
                // What is not there yet, or is of another form.
                *place = Value::Object(Map::new());
            }
            place = &mut place[name.as_str()];
        }
        *place = value.clone();
    }
    json::read_scene(&tree.to_string()).map_err(|unreadable| unreadable.refusal)
}

#[cfg(test)]
mod tests {
    use schemas::message::{ClearanceWish, Gap, Limits};

    use super::*;

    fn change(text: &str) -> SceneRequest {
        changed(&scene(), &[text.parse().unwrap()]).unwrap()
    }

    fn scene() -> SceneRequest {
        let scene = include_str!("../../../recordings/scenes/disassemble-channels.json");
        json::read_scene(scene).unwrap_or_else(|error| panic!("{error:?}"))
    }

    #[test]
    fn a_field_is_set_and_nothing_else_changes() {
        let limits = Limits { speed: Some(0.125), ..scene().limits };
        assert_eq!(change("limits.speed=0.125"), SceneRequest { limits, ..scene() });
        let gap = ClearanceWish::Gap(Gap::Uniform(0.5));
        assert_eq!(change("clearance={\"gap\": 0.5}").clearance, gap);
        assert_eq!(change("clearance=safest").clearance, ClearanceWish::Safest);
        assert_eq!(change("clearance.gap = 0.5").clearance, gap);
        assert_eq!(change("id=null").id, None);
        assert_eq!(changed(&scene(), &[]), Ok(scene()));
    }

    #[test]
    fn what_is_no_scene_is_refused_by_name() {
        let refused = |text: &str| changed(&scene(), &[text.parse().unwrap()]).unwrap_err();
        assert_eq!(refused("limits.sped=1").field.as_deref(), Some("limits.sped"));
        assert!(refused("limits.speed=fast").message.starts_with("limits.speed must be a number"));
    }

    #[test]
    fn wrong_changes_are_explained() {
        for text in ["limits.speed", "=1", "limits..speed=1", "channels[0]=1", ""] {
            assert!(text.parse::<FieldChange>().is_err(), "{text}");
        }
    }
}
