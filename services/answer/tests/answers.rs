//! What a workspace did before changes no reply: the same request, the same bytes.

use std::convert::Infallible;

use answer::{CacheStats, Caps, StopFlag, Workspace};
use schemas::convert::{CellWriter, PartSink, write_scene};
use schemas::json::read_scene;
use schemas::message::{ClearanceWish, Direction, RequestKey, SceneRequest, Task, Vector};
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
    let Ok(()) = workspace.answer(&header, &cells, &StopFlag::new(), &mut bytes);
    bytes
}

/// All scenes and refusals of the project, each also with its channels in any order, made from its
/// solids, with several exits, and with negative zeros.
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
    let variants = [Clone::clone, unordered, made, with_exits, negated_zeros];
    let scenes = read.iter().flat_map(|scene| variants.map(|variant| variant(scene)));
    scenes.chain(read.iter().map(|scene| with_exits(&made(scene)))).collect()
}

fn scene(name: &str) -> SceneRequest {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../recordings/scenes/");
    read_scene(&std::fs::read_to_string(format!("{folder}{name}")).unwrap()).unwrap()
}

fn made(scene: &SceneRequest) -> SceneRequest {
    let mut scene = scene.clone();
    if scene.free_space.solids.is_some() {
        (scene.free_space.channels, scene.free_space.in_order) = (None, false);
    }
    scene
}

fn with_exits(scene: &SceneRequest) -> SceneRequest {
    let exits = [Direction::MinusZ, Direction::PlusX, Direction::PlusZ, Direction::MinusX];
    let exit = if scene.task == Task::Drive { vec![] } else { exits.to_vec() };
    SceneRequest { exit, ..scene.clone() }
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
    let mut scenes = scenes();
    // The search for the safest motion among walls takes longest, and keeps nothing of its own.
    let takes_long = |scene: &SceneRequest| {
        let many = scene.free_space.solids.as_ref().is_some_and(|solids| solids.len() > 8);
        scene.task == Task::Drive && (many || scene.clearance == ClearanceWish::Safest)
    };
    scenes.retain(|scene| !takes_long(scene));
    let fresh: Vec<_> =
        scenes.iter().map(|scene| answer(&mut Workspace::default(), scene)).collect();
    // All kept; nothing; the largest not; few at a time.
    for cache in [usize::MAX, 0, 1 << 12, 1 << 14] {
        let mut used = Workspace::new(Caps::default(), cache);
        // Each after itself, after its neighbour, and after all others.
        for round in 0..3 {
            for (scene, expected) in scenes.iter().zip(&fresh) {
                for _ in 0..2 {
                    let same = answer(&mut used, scene) == *expected;
                    assert!(same, "{cache} bytes, round {round}: {scene:?}");
                    assert!(used.cache_stats().bytes <= cache);
                }
            }
        }
    }
}

/// Answers the scenes by turns; how much was found and made in each round.
fn rounds(cache: usize, scenes: &[SceneRequest]) -> [(u64, u64); 3] {
    let mut workspace = Workspace::new(Caps::default(), cache);
    let mut before = CacheStats::default();
    [(); 3].map(|()| {
        for scene in scenes {
            answer(&mut workspace, scene);
        }
        let stats = workspace.cache_stats();
        let round = (stats.hits - before.hits, stats.misses - before.misses);
        before = stats;
        round
    })
}

/// Each of the scenes needs so many things, all of which are made once.
#[track_caller]
fn check_reused(scenes: &[SceneRequest], needs: u64) {
    assert_eq!(rounds(usize::MAX, scenes), [(0, needs), (needs, 0), (needs, 0)]);
    assert_eq!(rounds(0, scenes), [(0, needs); 3], "switched off");
}

#[test]
fn free_spaces_that_alternate_are_made_once() {
    let channels = scene("disassemble-channels.json");
    let drive = scene("drive-a.json");
    let mut solids = scene("disassemble-solids.json");
    solids.exit.clear();
    let space = scene("disassemble-space.json");
    // In order: walls.
    check_reused(&[channels.clone(), drive.clone()], 2);
    // In any order: junctions and walls.
    check_reused(&[unordered(&channels), unordered(&drive)], 4);
    // Solids: walls, and channels with their junctions.
    check_reused(&[solids, space], 4);
}

#[test]
fn channels_in_order_share_their_walls_with_those_in_any() {
    let channels = scene("disassemble-channels.json");
    let found = rounds(usize::MAX, &[unordered(&channels), channels]);
    assert_eq!(found, [(1, 2), (3, 0), (3, 0)]);
}

#[test]
fn bodies_and_gaps_share_a_free_space() {
    let channels = unordered(&scene("disassemble-channels.json"));
    let mut other = scene("disassemble.json");
    (other.free_space.solids, other.free_space.in_order) = (None, false);
    assert_ne!(other.clearance, channels.clearance);
    let [first, ..] = rounds(usize::MAX, &[channels, other]);
    assert_eq!(first, (2, 2));
}

#[test]
fn exits_of_a_request_share_what_they_can() {
    let [first, second, _] = rounds(0, &[with_exits(&made(&scene("disassemble-solids.json")))]);
    // The solids' walls, and the channels of one cavity, whatever its exit and the gap is.
    assert_eq!(first.1, 2, "{first:?}");
    assert!(first.0 > 4, "{first:?}");
    assert_eq!(first, second, "nothing is kept");
}

/// What is found costs as much as what is made: the budget ends at the same place.
#[test]
fn budget_ends_at_the_same_place_whatever_is_kept() {
    let scenes = [
        unordered(&scene("disassemble.json")),
        made(&scene("disassemble-solids.json")),
        unordered(&scene("drive-a.json")),
    ];
    let mut cut_short = 0;
    for scene in &scenes {
        let whole = answer(&mut Workspace::default(), scene);
        for exponent in 0..60 {
            let by = |most: f64| most.powf(f64::from(exponent) / 60.0) as u64;
            for caps in [
                Caps { steps: by(1e4), ..Caps::default() },
                Caps { bytes: by(1e6), ..Caps::default() },
            ] {
                let fresh = answer(&mut Workspace::new(caps, 0), scene);
                cut_short += usize::from(fresh != whole);
                let mut used = Workspace::new(caps, usize::MAX);
                for _ in 0..3 {
                    assert!(answer(&mut used, scene) == fresh, "{caps:?}: {scene:?}");
                }
            }
        }
    }
    assert!(cut_short > 100, "only {cut_short} are cut short");
}
