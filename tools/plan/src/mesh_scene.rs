//! Scenes whose bodies and solids are meshes: `{"mesh": "FILE.stl"}` stands for the boxes inside.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};

use mesh::{Block, MeshError, Unit};
use schemas::json::UnreadableScene;
use schemas::message::Refusal;
use serde::Deserialize;
use serde_json::value::RawValue;

/// A scene as far as it can have meshes.
#[derive(Deserialize)]
struct Sketch<'a> {
    id: Option<u64>,
    #[serde(borrow)]
    body: Option<&'a RawValue>,
    #[serde(borrow)]
    free_space: Option<FreeSpaceSketch<'a>>,
}

#[derive(Deserialize)]
struct FreeSpaceSketch<'a> {
    #[serde(borrow)]
    solids: Option<Vec<&'a RawValue>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshFile {
    mesh: PathBuf,
    unit: Option<String>,
}

/// The text of a scene with boxes in place of its meshes, whose files are named from `folder`.
pub(crate) fn with_boxes<'a>(
    text: &'a str,
    folder: &Path,
) -> Result<Cow<'a, str>, UnreadableScene> {
    if !text.contains("\"mesh\"") {
        return Ok(text.into());
    }
    // The reader itself reports what is no scene.
    let Ok(sketch) = serde_json::from_str::<Sketch<'_>>(text) else { return Ok(text.into()) };
    let body = sketch.body.map(|body| ("body".to_owned(), body));
    let solids = sketch.free_space.and_then(|free_space| free_space.solids).unwrap_or_default();
    let solids = solids.into_iter().enumerate();
    let solids = solids.map(|(index, solid)| (format!("free_space.solids[{index}]"), solid));
    let mut places: Vec<(Range<usize>, String)> = Vec::new();
    for (field, value) in body.into_iter().chain(solids) {
        let boxes = boxes_of(value.get(), folder).map_err(|why| {
            let refusal = Refusal::invalid(&*field, format!("{field}: {why}"));
            UnreadableScene { id: sketch.id, refusal }
        })?;
        let begin = value.get().as_ptr() as usize - text.as_ptr() as usize;
        places.extend(boxes.map(|boxes| (begin..begin + value.get().len(), boxes)));
    }
    // From the end, so that earlier places stay.
    places.sort_by_key(|(place, _)| std::cmp::Reverse(place.start));
    let mut text = text.to_owned();
    places.into_iter().for_each(|(place, boxes)| text.replace_range(place, &boxes));
    Ok(text.into())
}

/// The JSON of the boxes in a mesh; none if it is something else.
fn boxes_of(value: &str, folder: &Path) -> Result<Option<String>, String> {
    match serde_json::from_str::<BTreeMap<String, &RawValue>>(value) {
        Ok(fields) if fields.contains_key("mesh") => {}
        _ => return Ok(None),
    }
    let read: MeshFile = serde_json::from_str(value).map_err(|error| error.to_string())?;
    let unit = read.unit.map_or(Ok(Unit::default()), |unit| unit.parse());
    let unit = unit.map_err(|error: MeshError| error.to_string())?;
    let path = folder.join(&read.mesh);
    let blocks = mesh::read(&path, unit);
    let blocks = blocks.map_err(|error| format!("{}: {error}", path.display()))?;
    let mut boxes = String::from("{\"boxes\":[");
    for (index, Block { min, max }) in blocks.iter().enumerate() {
        let comma = if index > 0 { "," } else { "" };
        // Finite numbers look the same in JSON.
        _ = write!(boxes, "{comma}{{\"min\":{min:?},\"max\":{max:?}}}");
    }
    boxes.push_str("]}");
    Ok(Some(boxes))
}
