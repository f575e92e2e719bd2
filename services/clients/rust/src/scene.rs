//! Scenes as they are sent.

use std::sync::Arc;

use schemas::message::{RequestKey, SceneRequest};
use schemas::{convert, json, wire};

use crate::error::Refused;

/// A scene, laid out once to be sent any number of times.
///
/// If its free space has its name beside it ([`Scene::with_name`]), the name is sent alone, and the
/// free space itself only to a planner that does not know it.
#[derive(Debug, Clone)]
pub struct Scene {
    prepared: Arc<Prepared>,
}

#[derive(Debug)]
struct Prepared {
    scene: SceneRequest,
    whole: Message,
    /// The same with nothing of the free space but the name.
    with_name_alone: Option<Message>,
}

/// A request in the layout of shared memory.
#[derive(Debug)]
pub(crate) struct Message {
    pub(crate) header: wire::RequestHeader,
    pub(crate) cells: Vec<u64>,
}

impl Scene {
    /// Reads a scene from JSON.
    pub fn from_json(text: &str) -> Result<Self, Refused> {
        Self::new(json::read_scene(text).map_err(|unreadable| unreadable.refusal)?)
    }

    /// Prepares a scene.
    pub fn new(scene: SceneRequest) -> Result<Self, Refused> {
        let whole = Message::of(&scene)?;
        let space = &scene.free_space;
        let is_named =
            space.named.is_some() && (space.channels.is_some() || space.solids.is_some());
        let with_name_alone =
            is_named.then(|| Message::of(&scene.with_name_alone())).transpose()?;
        Ok(Self { prepared: Arc::new(Prepared { scene, whole, with_name_alone }) })
    }

    /// The same scene with the name of its free space, which is worth while for large free spaces
    /// that are planned in often.
    pub fn with_name(&self) -> Result<Self, Refused> {
        let mut scene = self.prepared.scene.clone();
        scene.free_space.named = Some(scene.free_space.digest());
        Self::new(scene)
    }

    /// The scene as a value.
    pub fn request(&self) -> &SceneRequest {
        &self.prepared.scene
    }

    pub(crate) fn whole(&self) -> &Message {
        &self.prepared.whole
    }

    /// What to send first.
    pub(crate) fn shortest(&self) -> &Message {
        self.prepared.with_name_alone.as_ref().unwrap_or(&self.prepared.whole)
    }
}

impl Message {
    fn of(scene: &SceneRequest) -> Result<Self, Refused> {
        let mut cells = Vec::new();
        let header = convert::write_scene(scene, RequestKey::default(), 0, &mut cells)?;
        Ok(Self { header, cells })
    }
}
