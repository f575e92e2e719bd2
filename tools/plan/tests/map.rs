//! `plan --map`.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../recordings/scenes")
}

fn plan(arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("plan").unwrap();
    command.current_dir(scenes()).args(["--local", "--format", "json"]).args(arguments);
    command
}

/// The replies printed, one a line.
fn replies(command: &mut Command) -> Vec<serde_json::Value> {
    let output = command.output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn the_map_is_the_free_space_of_every_scene() {
    let scene = fs::read_to_string(scenes().join("drive-office.json")).unwrap();
    let line = scene.replace('\n', " ").replace("\"id\": 14", "\"id\": 13");
    let mut command = plan(&["--map", "office.yaml", "drive-office.json", "drive-a.json", "-"]);
    let replies = replies(command.write_stdin(format!("{line}\n\n{line}\n")));
    let ids: Vec<_> = replies.iter().map(|reply| reply["id"].as_u64()).collect();
    assert_eq!(ids, [Some(14), Some(10), Some(13), Some(13)]);
    // That scene has channels.
    assert_eq!(replies[1]["error"]["field"], "free_space");
    for index in [0, 2, 3] {
        assert_eq!(replies[index]["trajectories"].as_array().unwrap().len(), 3);
    }
    assert_eq!(replies[2], replies[3]);
}

#[test]
fn without_a_map_the_free_space_is_missing() {
    let replies = replies(&mut plan(&["drive-office.json"]));
    let message = replies[0]["error"]["message"].as_str().unwrap();
    assert!(message.contains("free_space is missing"), "{message}");
}

#[test]
fn an_unreadable_map_ends_the_program() {
    let output = plan(&["--map", "drive-a.json", "drive-office.json"]).output().unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0));
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(message, "plan: drive-a.json: image is missing\n");
}

/// A map of 20 x 8 cells of 0.5 m: a floor between walls, with `shade` in a strip across it.
fn strip(folder: &Path, shade: u8, yaml: &str) -> PathBuf {
    let mut picture = b"P5\n20 8\n255\n".to_vec();
    for y in 0..8 {
        picture.extend((0..20).map(|x| match (x, y) {
            (0 | 19, _) | (_, 0 | 7) => 0,
            (9 | 10, _) => shade,
            _ => 254,
        }));
    }
    fs::write(folder.join("strip.pgm"), picture).unwrap();
    let path = folder.join("strip.yaml");
    let common = "image: strip.pgm\nresolution: 0.5\nnegate: 0\noccupied_thresh: 0.65\n";
    fs::write(&path, format!("{common}{yaml}")).unwrap();
    path
}

/// A drive along the middle of that map.
const ALONG: &str = r#"{ "id": 4, "task": "drive",
    "body": { "footprint": { "width": 0.4, "length": 0.6 } },
    "start": { "position": [2.0, 2.0], "heading": 0 }, "goal": { "position": [8.0, 2.0] },
    "clearance": { "gap": 0.1 }, "sampling": { "count": 5 } }"#;

fn along(map: &Path, more: &[&str]) -> (serde_json::Value, String) {
    let mut command = plan(&["--map", map.to_str().unwrap(), "-"]);
    let output = command.args(more).write_stdin(ALONG).output().unwrap();
    let reply = serde_json::from_slice(&output.stdout).unwrap();
    (reply, String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_drive_over_grey_cells_is_noted() {
    let folder = tempfile::tempdir().unwrap();
    let map = strip(folder.path(), 205, "origin: [0, 0, 0]\nfree_thresh: 0.25\n");
    let (reply, note) = along(&map, &[]);
    assert!(reply["trajectories"][0]["length"].as_f64().unwrap() >= 6.0, "{reply}");
    // The robot is 0.4 m wide, on the side that two rows of cells have in common.
    let expected = "plan: note: scene 1 (line 1) (id 4): the robot passes over 4 cells that \
                    free_thresh 0.25 makes free although they are as grey as unknown, first at \
                    (4.750, 1.750) m; free_thresh 0.196 closes them\n";
    assert_eq!(note, expected);
    let (_, note) = along(&map, &["--unknown", "free"]);
    assert_eq!(note, "");
    let map = strip(folder.path(), 254, "origin: [0, 0, 0]\nfree_thresh: 0.25\n");
    assert_eq!(along(&map, &[]).1, "");
}

#[test]
fn unknown_cells_are_closed_unless_they_are_free() {
    let folder = tempfile::tempdir().unwrap();
    let map = strip(folder.path(), 205, "origin: [0, 0, 0]\nfree_thresh: 0.196\n");
    let (reply, _) = along(&map, &[]);
    assert_eq!(reply["error"]["code"], "no_route", "{reply}");
    let (same, _) = along(&map, &["--unknown", "occupied"]);
    assert_eq!(same, reply);
    let (reply, note) = along(&map, &["--unknown", "free"]);
    assert!(reply["trajectories"][0]["length"].as_f64().unwrap() >= 6.0, "{reply}");
    assert_eq!(note, "");
}

#[test]
fn start_and_goal_are_in_the_frame_of_a_turned_map() {
    // Turned by a quarter about (4, 0), the floor runs up; the scene is turned with it.
    let folder = tempfile::tempdir().unwrap();
    let plain = strip(folder.path(), 254, "origin: [0, 0, 0]\nfree_thresh: 0.196\n");
    let (straight, _) = along(&plain, &[]);
    let yaml = "origin: [4, 0, \"1.5707963267948966\"]\nfree_thresh: 0.196\n";
    let turned = strip(folder.path(), 254, yaml);
    let scene = ALONG
        .replace("\"heading\": 0", "\"heading\": 1.5707963267948966")
        .replace("[8.0, 2.0]", "[2.0, 8.0]");
    let replies = replies(plan(&["--map", turned.to_str().unwrap(), "-"]).write_stdin(scene));
    let length = |reply: &serde_json::Value| reply["trajectories"][0]["length"].as_f64().unwrap();
    let value = |reply: &serde_json::Value| {
        reply["trajectories"][0]["clearance"]["value"].as_f64().unwrap()
    };
    assert!((length(&replies[0]) - length(&straight)).abs() < 1e-9, "{replies:?}");
    assert!((value(&replies[0]) - value(&straight)).abs() < 1e-9, "{replies:?}");
}

#[test]
fn unknown_needs_a_map() {
    let output = plan(&["--unknown", "free", "drive-a.json"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}
