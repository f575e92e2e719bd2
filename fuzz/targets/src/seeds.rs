//! Valid inputs of each target, made from the scenes in `recordings/scenes`.

use std::convert::Infallible;
use std::fs;
use std::path::{Path, PathBuf};

use ::mesh::Block;
use ::recording::{Options, Writer};
use schemas::codec;
use schemas::convert::{self, CellWriter, Certificate, PartSink};
use schemas::json;
use schemas::message::{
    ClearanceWish, ErrorCode, Refusal, ReplyPart, Request, RequestContent, RequestKey, Rung,
    Sampling, SceneRequest,
};
use schemas::wire::{LEG_CELLS, Leg, ReplyHeader, RequestHeader, SAMPLE_CELLS};

use crate::limits::small_caps;

type Seeds = Vec<(String, Vec<u8>)>;

const KEY: RequestKey = RequestKey { client: 0x5eed, sequence: 1 };
const TIME_NS: u64 = 1_700_000_000_000_000_000;

/// The scenes that seeds are made from.
const SCENES: [&str; 7] = [
    "assemble.json",
    "disassemble.json",
    "disassemble-channels.json",
    "disassemble-solids.json",
    "disassemble-space.json",
    "drive-a.json",
    "drive-b.json",
];

/// The files whose lines are scenes.
const LINES: [&str; 7] = [
    "corners.jsonl",
    "drives.jsonl",
    "no-route.jsonl",
    "refusals.jsonl",
    "routes.jsonl",
    "shortest.jsonl",
    "unions.jsonl",
];

/// Robots anywhere, with all that a request can say of them, and a free space by name.
const ROBOTS: [(&str, &str); 2] = [
    (
        "drive-anywhere",
        r#"{"task": "drive", "free_space": {"solids": [{"polygon": [[2, 2], [5, 3], [4, 6]]}],
        "bounds": {"min": [0, 0], "max": [9, 8]}},
        "body": {"footprint": {"width": 0.6, "front": 0.75, "rear": 0.25}},
        "start": {"position": [1, 2], "heading": 0}, "goal": {"position": [8, 7], "heading": 1.5},
        "reverse": true, "turn_in_place": true, "min_turn_radius": 0.75, "turn_cost": 0.5,
        "stop_cost": 0.125, "report": "full", "sampling": {"count": 5},
        "clearance": {"each": [0.1, {"at_least": 0.05}, "safest"]}}"#,
    ),
    (
        "drive-named",
        r#"{"task": "drive", "free_space": {"named":
        "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f"},
        "body": {"footprint": {"width": 1, "length": 2}},
        "start": {"position": [1, 2], "heading": 0}, "goal": {"position": [3, 4]},
        "clearance": {"at_least": 0.25}}"#,
    ),
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../recordings/scenes")
}

fn text(name: &str) -> String {
    let path = folder().join(name);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All scenes as text, with names.
pub(crate) fn scene() -> Seeds {
    let mut seeds = Vec::new();
    for name in SCENES {
        seeds.push((stem(name), text(name).into_bytes()));
    }
    for name in LINES {
        for (index, line) in text(name).lines().enumerate() {
            seeds.push((format!("{}-{index}", stem(name)), line.into()));
        }
    }
    seeds.extend(ROBOTS.map(|(name, text)| (name.to_owned(), text.into())));
    seeds
}

fn stem(name: &str) -> String {
    name.split('.').next().unwrap_or_default().to_owned()
}

fn scenes() -> Vec<(String, SceneRequest)> {
    let read = |(name, text): (String, Vec<u8>)| {
        let text = String::from_utf8(text).expect("scenes are UTF-8");
        (name, json::read_scene(&text).expect("the repository's scenes can be read"))
    };
    scene().into_iter().map(read).collect()
}

/// A request in memory: its header, then its cells.
pub(crate) fn border() -> Seeds {
    let seed = |(name, scene): (String, SceneRequest)| (name, memory(&scene));
    scenes().into_iter().map(seed).collect()
}

fn request_cells(scene: &SceneRequest) -> (RequestHeader, Vec<u64>) {
    let mut cells = Vec::new();
    let header = convert::write_scene(scene, KEY, TIME_NS, &mut cells);
    (header.expect("the repository's scenes fit into memory"), cells)
}

fn memory(scene: &SceneRequest) -> Vec<u8> {
    let (header, cells) = request_cells(scene);
    [bytemuck::bytes_of(&header), bytemuck::cast_slice(&cells)].concat()
}

/// An exchange: a name, the scene, and the parts of its reply as they lie in memory.
type Exchange = (String, SceneRequest, Vec<(ReplyHeader, Vec<u64>)>);

/// A short exchange of each kind.
fn exchanges() -> Vec<Exchange> {
    let mut exchanges = Vec::new();
    for (name, mut scene) in scenes() {
        if !["assemble", "disassemble-space", "drive-a"].contains(&&*name) {
            continue;
        }
        scene.sampling = Some(Sampling::Count(5));
        if let ClearanceWish::Each(choices) = &mut scene.clearance {
            choices.truncate(1);
        }
        let (header, cells) = request_cells(&scene);
        let mut parts = Parts(Vec::new());
        let (mut workspace, stop) =
            (answer::Workspace::new(small_caps(), 0), answer::StopFlag::new());
        let Ok(()) = workspace.answer(&header, &cells, &stop, &mut parts);
        exchanges.push((name, scene, parts.0));
    }
    let (_, scene, _) = exchanges[0].clone();
    // Made here, so that a message in other words leaves the seeds as they are.
    let refusal = Refusal {
        field: Some("body.polygon[3]".to_owned()),
        junction: Some(1),
        axis: Some(0),
        needs: Some(2.5),
        has: Some(2.25),
        ..Refusal::new(ErrorCode::JunctionTooSmall, "needs 2.5 m, has 2.25 m")
    };
    let mut parts = Parts(Vec::new());
    let Ok(()) = answer::Workspace::refuse(&request_cells(&scene).0, &refusal, &mut parts);
    exchanges.push(certified(&exchanges));
    exchanges.push(("refusal".to_owned(), scene, parts.0));
    exchanges
}

/// The robot's exchange with what a trajectory has beside its path. Made here, so that another
/// path leaves the seeds as they are.
fn certified(exchanges: &[Exchange]) -> Exchange {
    let robot = exchanges.iter().find(|(name, ..)| name == "drive-a");
    let (_, scene, mut parts) = robot.expect("a robot's exchange").clone();
    for (header, cells) in &mut parts {
        header.set_certificate(Certificate {
            bound: Some(19.5),
            free_clearance: Some(0.25),
            complete: false,
        });
        let after = LEG_CELLS * header.legs as usize + SAMPLE_CELLS * header.samples as usize;
        let legs = cells.len() - after..cells.len() - SAMPLE_CELLS * header.samples as usize;
        let legs: &mut [Leg] = bytemuck::cast_slice_mut(&mut cells[legs]);
        for (leg, rung) in legs.iter_mut().zip(Rung::ALL.iter().cycle()) {
            (leg.rung, leg.reverse) = (Leg::rung_code(Some(*rung)), 1);
        }
    }
    ("drive-certified".to_owned(), scene, parts)
}

fn request(scene: SceneRequest) -> Request {
    Request { key: KEY, sent_ns: TIME_NS, content: RequestContent::Scene(scene) }
}

/// Takes parts as they are.
struct Parts(Vec<(ReplyHeader, Vec<u64>)>);

impl PartSink for Parts {
    type Error = Infallible;

    fn part(
        &mut self,
        header: &ReplyHeader,
        cells: usize,
        fill: impl FnOnce(&mut CellWriter),
    ) -> Result<(), Infallible> {
        let mut memory = vec![0; cells];
        fill(&mut CellWriter::new(&mut memory));
        self.0.push((*header, memory));
        Ok(())
    }
}

/// Replies: for each part the number of its cells, its header, its cells.
pub(crate) fn reply() -> Seeds {
    let seed = |(name, _, parts): Exchange| {
        let mut bytes = Vec::new();
        for (header, cells) in parts {
            bytes.extend((cells.len() as u32).to_le_bytes());
            bytes.extend(bytemuck::bytes_of(&header));
            bytes.extend(bytemuck::cast_slice::<u64, u8>(&cells));
        }
        (name, bytes)
    };
    exchanges().into_iter().map(seed).collect()
}

fn recorded(parts: &[(ReplyHeader, Vec<u64>)]) -> Vec<ReplyPart> {
    let read = |(header, cells): &(ReplyHeader, Vec<u64>)| {
        let part = convert::read_part(header, cells).expect("what was just written");
        ReplyPart { sent_ns: TIME_NS + 1, ..part }
    };
    parts.iter().map(read).collect()
}

/// Recorded messages: 0 and a request, 1 and a part of a reply.
pub(crate) fn message() -> Seeds {
    let mut seeds = Vec::new();
    for (name, scene, parts) in exchanges() {
        for (index, part) in recorded(&parts).iter().enumerate() {
            let bytes = [vec![1], codec::encode(part)].concat();
            seeds.push((format!("{name}-part-{index}"), bytes));
        }
        let bytes = [vec![0], codec::encode(&request(scene))].concat();
        seeds.push((format!("{name}-request"), bytes));
    }
    seeds
}

/// Recordings of one exchange each, and what an unfinished one has.
pub(crate) fn recording() -> Seeds {
    let mut seeds = Vec::new();
    for (name, scene, parts) in exchanges().into_iter().rev().take(3) {
        let mut bytes = Vec::new();
        let options = Options { id: Some(0x5eed), ..Options::default() };
        let mut writer = Writer::new(&mut bytes, options).expect("memory takes bytes");
        writer.write_request(&request(scene), TIME_NS + 2).expect("memory takes bytes");
        writer.flush().expect("memory takes bytes");
        writer.lost(3);
        for part in &recorded(&parts) {
            writer.write_reply(part, TIME_NS + 3).expect("memory takes bytes");
        }
        writer.finish().expect("memory takes bytes");
        let cut = bytes[..bytes.len() * 3 / 4].to_vec();
        seeds.push((name.clone(), bytes));
        seeds.push((format!("{name}-cut"), cut));
    }
    seeds
}

/// Floor plans: the YAML, a zero byte, the picture.
pub(crate) fn floor_plan() -> Seeds {
    let office = text("office.yaml");
    let office: String = office
        .lines()
        .filter(|line| !line.contains("image"))
        .fold(String::new(), |text, line| text + line + "\n");
    let binary =
        [b"P5\n4 3\n255\n".as_slice(), &[0, 254, 254, 254, 205, 0, 254, 254, 0, 0, 0, 254]];
    let plain = b"P2 3 2 255 0 254 254 254 254 100\n".as_slice();
    let raw = "resolution: 0.05\norigin: [1.5, -2, 0]\nnegate: 1\nmode: raw\n\
               occupied_thresh: 0.65\nfree_thresh: 0.196\n";
    // Rings, one of which touches itself at a corner.
    let rings = [
        b"P5\n5 5\n255\n".as_slice(),
        &[0, 0, 0, 0, 205, 0, 254, 254, 0, 0, 0, 254, 0, 254, 0, 0, 0, 0, 0, 254, 254, 0],
        &[254, 254, 254],
    ];
    let turned = "resolution: '0.05'\norigin: [1.5, -2, \"0.5\"]\nnegate: 0\n\
                  occupied_thresh: 0.65\nfree_thresh: 0.25\n";
    // 3 x 2 pixels of 24 bits, each row padded to 12 bytes.
    let bitmap = [
        b"BM\x4e\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x03\0\0\0\x02\0\0\0\x01\0\x18\0".as_slice(),
        b"\0\0\0\0\x18\0\0\0\x13\x0b\0\0\x13\x0b\0\0\0\0\0\0\0\0\0\0",
        &[0, 0, 0, 254, 254, 254, 0, 0, 0, 0, 0, 0],
        &[254, 254, 254, 254, 254, 254, 205, 205, 205, 0, 0, 0],
    ];
    let quarter = "resolution: 1\norigin: [0, 0, 1.5707963267948966]\nnegate: no\nmode: scale\n\
                   occupied_thresh: 0.65\nfree_thresh: 0.196\n";
    vec![
        ("bitmap".to_owned(), [quarter.as_bytes(), &[0], &bitmap.concat()].concat()),
        ("office".to_owned(), [office.as_bytes(), &[0], &binary.concat()].concat()),
        ("raw".to_owned(), [raw.as_bytes(), &[0], plain].concat()),
        ("turned".to_owned(), [turned.as_bytes(), &[0], &rings.concat()].concat()),
    ]
}

/// Meshes: boxes, one above the other, as text and binary.
pub(crate) fn mesh() -> Seeds {
    let boxes = [([0.0, 0.0, 0.0], [12.5, 40.0, 30.0]), ([4.0, 10.0, 20.0], [8.0, 20.0, 50.0])];
    let corners: Vec<_> = boxes
        .into_iter()
        .flat_map(|(min, max)| Block { min, max }.surface())
        .map(|triangle| triangle.map(|corner| corner.map(|number| number as f32)))
        .collect();
    let mut text = "solid steps\n".to_owned();
    let mut binary = [&[0; 80][..], &(corners.len() as u32).to_le_bytes()].concat();
    for triangle in &corners {
        text += "facet normal 0 0 0\nouter loop\n";
        binary.extend([0; 12]);
        for [x, y, z] in triangle {
            text += &format!("vertex {x} {y} {z}\n");
            binary.extend([x, y, z].into_iter().flat_map(|number| number.to_le_bytes()));
        }
        text += "endloop\nendfacet\n";
        binary.extend([0; 2]);
    }
    text += "endsolid steps\n";
    vec![("binary".to_owned(), binary), ("text".to_owned(), text.into_bytes())]
}
