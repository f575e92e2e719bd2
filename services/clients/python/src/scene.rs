//! Scenes from what Python has them in.

use pyo3::prelude::*;
use schemas::json;

use crate::errors;

/// Scene(scene)
/// --
///
/// A scene, prepared to be planned any number of times.
///
/// `scene` is a mapping or a dataclass with the fields of a scene, or a JSON text. Lengths are in
/// metres, angles in radians, times in seconds. Raises `InvalidScene` if it is none.
#[pyclass(frozen, module = "clearway")]
pub(crate) struct Scene {
    pub(crate) scene: clearway_client::Scene,
}

#[pymethods]
impl Scene {
    #[new]
    fn new(scene: &Bound<'_, PyAny>) -> PyResult<Self> {
        prepared(scene).map(|scene| Self { scene })
    }

    /// The same scene with the name of its free space: it is then sent only to planners that do not
    /// know it, which is worth while for maps.
    fn with_name(&self, py: Python<'_>) -> PyResult<Self> {
        let named = py.detach(|| self.scene.with_name());
        named.map(|scene| Self { scene }).map_err(|refused| errors::error(py, refused.into()))
    }

    /// The scene as JSON.
    fn to_json(&self) -> String {
        json::scene_to_json(self.scene.request())
    }

    fn __repr__(&self) -> String {
        format!("Scene({:?})", self.to_json())
    }
}

/// The scene that an object stands for.
pub(crate) fn prepared(scene: &Bound<'_, PyAny>) -> PyResult<clearway_client::Scene> {
    if let Ok(scene) = scene.cast::<Scene>() {
        return Ok(scene.get().scene.clone());
    }
    let py = scene.py();
    let text: String = match scene.extract::<String>() {
        Ok(text) => text,
        Err(_) => py.import("clearway._scenes")?.getattr("to_json")?.call1((scene,))?.extract()?,
    };
    let read = py.detach(|| clearway_client::Scene::from_json(&text));
    read.map_err(|refused| errors::error(py, refused.into()))
}
