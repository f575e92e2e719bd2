//! `export`: for viewers, as samples, as ROS messages.

use std::path::Path;

use recording::{Aside, Reader};
use serde_json::Value;

use crate::recorded::{Folder, keep, record_named};

fn lines(folder: &Folder, name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(folder.path(name)).unwrap();
    text.lines().map(str::to_owned).collect()
}

/// Messages of other channels.
fn others(path: &Path) -> Vec<Aside> {
    let mut reader = Reader::open(path).unwrap();
    reader.keep_foreign();
    reader.by_ref().for_each(|record| drop(record.unwrap()));
    let mut asides = reader.take_asides();
    asides.retain(|aside| matches!(aside, Aside::Foreign { .. }));
    asides
}

/// Recorded with changed replies, exported and blessed: what viewers show stays, and is said to.
#[test]
fn blessing_keeps_messages_of_other_channels() {
    let folder = Folder::with("a.mcap", |part| {
        part.content.iter_mut().for_each(|motion| motion.length += 1.0);
        true
    });
    let (code, _, _) = folder.run(&["export", "a.mcap", "-o", "v.mcap"]);
    assert_eq!(code, 0);
    let before = others(&folder.path("v.mcap"));
    let said = format!("v.mcap: {} messages of other channels kept as they are", before.len());
    folder.check(&["bless", "v.mcap", "--uncommitted"], 0, "3 of 3 replies accepted", &said);
    assert_eq!(others(&folder.path("v.mcap")), before);
    folder.check(&["check", "v.mcap"], 0, "3 requests, 3 equal\n", "");
}

#[test]
fn what_is_exported_is_a_recording_still() {
    let folder = Folder::with("a.mcap", keep);
    let export = ["export", "a.mcap", "-o", "v.mcap"];
    folder.check(&export, 0, "v.mcap: 3 requests, ", "the motions of 2 requests begin before");
    folder.check(&["check", "v.mcap", "--strict"], 0, "v.mcap: 3 requests, 3 equal\n", "");
    folder.check(&["info", "v.mcap"], 0, "messages of other channels", "");
    // Exported again, it has them once.
    folder.check(&["export", "v.mcap", "-o", "w.mcap"], 0, "w.mcap: 3 requests", "");
    let size = |name: &str| std::fs::metadata(folder.path(name)).unwrap().len();
    assert_eq!(size("v.mcap"), size("w.mcap"));
    // What is made of it keeps them, or says that it does not.
    let others = others(&folder.path("v.mcap"));
    assert!(!others.is_empty());
    folder.check(&["merge", "v.mcap", "-o", "m.mcap"], 0, "messages of other channels kept", "");
    assert_eq!(self::others(&folder.path("m.mcap")), others);
    let extract = ["extract", "v.mcap", "--request", "0", "-o", "e.mcap"];
    let said = format!("v.mcap: {} messages of other channels left out", others.len());
    folder.check(&extract, 0, "messages of other channels left out", &said);
    assert_eq!(self::others(&folder.path("e.mcap")), []);
    let (code, _, said) = folder.run(&["export", "a.mcap", "-o", "x.mcap", "--apart"]);
    assert_eq!((code, said.as_str()), (0, ""), "nothing overlaps");
}

#[test]
fn nothing_is_overwritten_unasked() {
    let folder = Folder::with("a.mcap", keep);
    for (option, name) in [("-o", "v.mcap"), ("--csv", "s.csv"), ("--ros", "r.jsonl")] {
        let export = ["export", "a.mcap", option, name];
        folder.check(&export, 0, name, "");
        let said = format!("{name} exists; --overwrite replaces it");
        folder.check(&export, 1, "", &said);
        folder.check(&[&export[..], &["--overwrite"]].concat(), 0, name, "");
        folder.check(&["export", "a.mcap", option, "a.mcap", "--overwrite"], 1, "", "is read from");
    }
    let twice = ["export", "a.mcap", "--csv", "x", "--ros", "x"];
    folder.check(&twice, 1, "", "x is to be written twice");
    folder.check(&["export", "a.mcap"], 2, "", "--output");
    folder.check(&["export", "a.mcap", "-o", "y.mcap", "--grid", "0"], 2, "", "greater than 0");
    folder.check(&["export", "none.mcap", "-o", "y.mcap"], 1, "", "none.mcap: ");
    // Left by a recorder that was killed; it is not ours to remove.
    std::fs::write(folder.path("z.mcap.part"), "").unwrap();
    let none = ["export", "a.mcap", "--id", "9", "-o", "z.mcap"];
    folder.check(&none, 1, "", "nothing written");
    assert!(folder.path("z.mcap.part").exists());
    let none = ["export", "a.mcap", "--id", "9", "-o", "y.mcap", "--csv", "y.csv"];
    folder.check(&none, 1, "", "a.mcap has no such request with a reply; nothing written");
    let grid = ["export", "a.mcap", "-o", "y.mcap", "--grid", "1um"];
    folder.check(&grid, 1, "", "request 0: a floor plan of 6 m x 6 m has 36000000000000 cells");
    for name in ["y.mcap", "y.mcap.part", "y.csv"] {
        assert!(!folder.path(name).exists(), "{name}");
    }
}

#[test]
fn some_requests_are_selected() {
    let folder = Folder::with("a.mcap", keep);
    let export = |more: &[&str], said: &str| {
        let arguments = [&["export", "a.mcap", "-o", "v.mcap", "--overwrite"], more].concat();
        folder.check(&arguments, 0, said, "");
        let (_, out, _) = folder.run(&["check", "v.mcap"]);
        out
    };
    assert_eq!(export(&["--request", "1"], "1 request"), "v.mcap: 1 request, 1 equal\n");
    assert_eq!(export(&["--id", "0", "--id", "2"], "2 requests"), "v.mcap: 2 requests, 2 equal\n");
    let both = ["--task", "disassemble", "--id", "1", "--request", "1"];
    assert_eq!(export(&both, "1 request"), "v.mcap: 1 request, 1 equal\n");
    folder.check(
        &["export", "a.mcap", "--task", "drive", "-o", "w.mcap"],
        1,
        "",
        "no such request",
    );
}

#[test]
fn named_free_spaces_are_shown() {
    let folder = Folder::new();
    record_named(folder.path("a.mcap"));
    let grid = ["--grid", "1m", "--apart"];
    let whole = [&["export", "a.mcap", "-o", "v.mcap"], &grid[..]].concat();
    folder.check(&whole, 0, "v.mcap: 2 requests", "");
    let one = [&["export", "a.mcap", "-o", "w.mcap", "--request", "1"], &grid[..]].concat();
    folder.check(&one, 0, "w.mcap: 1 request", "");
    folder.check(&["check", "v.mcap", "w.mcap"], 0, "w.mcap: 1 request, 1 equal", "");
}

#[test]
fn samples_are_rows_and_ros_messages() {
    let folder = Folder::with("a.mcap", keep);
    let export = ["export", "a.mcap", "--csv", "s.csv", "--ros", "r.jsonl", "--frame", "part"];
    folder.check(&export, 0, "s.csv: 3 requests, ", "");
    let rows = lines(&folder, "s.csv");
    assert_eq!(rows[0], "scene,id,answer,t,x,y,z,heading,vx,vy,vz,yaw_rate");
    let motions = lines(&folder, "r.jsonl");
    assert_eq!(motions.len(), 3);
    let of_second = rows.iter().filter(|row| row.starts_with("1,1,0,")).collect::<Vec<_>>();
    let second: Value = serde_json::from_str(&motions[1]).unwrap();
    assert_eq!((&second["request"], &second["id"]), (&1.into(), &1.into()));
    let (path, trajectory) = (&second["path"], &second["trajectory"]);
    // The reply was sent 5,000 ns after the epoch.
    let stamp = serde_json::json!({ "stamp": { "sec": 0, "nanosec": 5_000 }, "frame_id": "part" });
    assert_eq!((&path["header"], &trajectory["header"]), (&stamp, &stamp));
    let (poses, points) =
        (path["poses"].as_array().unwrap(), trajectory["points"].as_array().unwrap());
    assert_eq!((poses.len(), points.len()), (of_second.len(), of_second.len()));
    for (row, (pose, point)) in of_second.iter().zip(poses.iter().zip(points)) {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let xyz = |value: &Value| ["x", "y", "z"].map(|axis| value[axis].as_f64().unwrap());
        let place = [cells[4], cells[5], cells[6]];
        assert_eq!(xyz(&pose["pose"]["position"]), place);
        assert_eq!(xyz(&point["transforms"][0]["translation"]), place);
        assert_eq!(xyz(&point["velocities"][0]["linear"]), [cells[8], cells[9], cells[10]]);
        let time = |value: &Value| {
            value["sec"].as_u64().unwrap() * 1_000_000_000 + value["nanosec"].as_u64().unwrap()
        };
        let t = (cells[3] * 1e9).round() as u64;
        assert_eq!(time(&point["time_from_start"]), t);
        assert_eq!(time(&pose["header"]["stamp"]), 5_000 + t);
    }
}
