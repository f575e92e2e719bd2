//! What a workspace did before changes no reply: the same request, the same bytes.

use std::convert::Infallible;

use planner::Workspace;
use schemas::convert::{CellWriter, PartSink, write_scene};
use schemas::json::read_scene;
use schemas::message::{RequestKey, SceneRequest, Vector};
use schemas::wire::ReplyHeader;

/// All parts, as they would lie in shared memory.
#[derive(Debug, Default, PartialEq)]
struct Bytes(Vec<u8>);

impl PartSink for Bytes {
    type Error = Infallible;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Infallible> {
        let mut payload = vec![0; cells];
        fill(&mut CellWriter::new(&mut payload));
        self.0.extend_from_slice(bytemuck::bytes_of(header));
        self.0.extend_from_slice(bytemuck::cast_slice(&payload));
        Ok(())
    }
}

fn answer(workspace: &mut Workspace, scene: &SceneRequest) -> Bytes {
    let mut cells = Vec::new();
    let header = write_scene(scene, RequestKey::default(), 0, &mut cells).unwrap();
    let mut bytes = Bytes::default();
    let Ok(()) = workspace.answer(&header, &cells, &mut bytes);
    bytes
}

/// All scenes and refusals of the project, each also with its channels shifted a little, with
/// another gap's order of channels, and with negative zeros.
fn scenes() -> Vec<SceneRequest> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../recordings/scenes");
    let mut texts = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("json") => texts.push(std::fs::read_to_string(path).unwrap()),
            Some("jsonl") => {
                let lines = std::fs::read_to_string(path).unwrap();
                texts.extend(lines.lines().map(str::to_owned));
            }
            _ => {}
        }
    }
    texts.sort();
    // The one that goes with a map can't be read alone.
    let read: Vec<_> = texts.iter().filter_map(|text| read_scene(text).ok()).collect();
    assert!(read.len() > 20, "only {} scenes", read.len());
    read.iter().flat_map(|scene| [scene.clone(), unordered(scene), negated_zeros(scene)]).collect()
}

fn unordered(scene: &SceneRequest) -> SceneRequest {
    let mut scene = scene.clone();
    scene.free_space.in_order = false;
    scene
}

fn negated_zeros(scene: &SceneRequest) -> SceneRequest {
    let mut scene = scene.clone();
    for channel in scene.free_space.channels.iter_mut().flatten() {
        for corner in [&mut channel.min, &mut channel.max] {
            let values: Vec<_> =
                corner.as_slice().iter().map(|v| if *v == 0.0 { -0.0 } else { *v }).collect();
            *corner = Vector::new(&values).unwrap();
        }
    }
    scene
}

#[test]
fn a_used_workspace_answers_as_a_new_one() {
    let scenes = scenes();
    let fresh: Vec<_> =
        scenes.iter().map(|scene| answer(&mut Workspace::default(), scene)).collect();
    let mut used = Workspace::default();
    // Each after itself, after its neighbour, and after all others.
    for round in 0..3 {
        for (scene, expected) in scenes.iter().zip(&fresh) {
            for _ in 0..2 {
                assert!(answer(&mut used, scene) == *expected, "round {round}: {scene:?}");
            }
        }
    }
}
