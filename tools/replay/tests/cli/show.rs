//! `replay show`.

use answer::Caps;
use recording::{Options, Writer};
use schemas::json;
use schemas::message::{Refusal, RequestContent};
use serde_json::Value;

use crate::recorded::{Folder, parts, record_named, request};

/// Three requests: a trajectory of 5 ms, a refusal, and one without reply.
fn mixed() -> Folder {
    let folder = Folder::new();
    let mut writer = Writer::create(folder.path("a.mcap"), Options::default()).unwrap();
    for sequence in 0..3 {
        let mut request = request(7, sequence);
        let RequestContent::Scene(scene) = &mut request.content else { unreachable!() };
        if sequence == 1 {
            scene.limits.speed = Some(-1.0);
        }
        request.sent_ns = 1_000;
        writer.write_request(&request, 10_000).unwrap();
        for mut part in parts(answer::reply_to(&request, &Caps::default())) {
            part.sent_ns = 5_001_000;
            if sequence < 2 {
                writer.write_reply(&part, 20_000).unwrap();
            }
        }
    }
    writer.finish().unwrap();
    folder
}

fn rows(folder: &Folder, filters: &[&str]) -> Vec<Value> {
    let arguments = [&["show", "a.mcap", "--format", "json"], filters].concat();
    let (code, out, error) = folder.run(&arguments);
    assert_eq!(code, 3, "a reply is missing: {error}");
    out.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn requests_are_listed_with_their_numbers() {
    let folder = mixed();
    let rows = rows(&folder, &[]);
    let outcomes: Vec<_> = rows.iter().map(|row| row["outcome"].as_str().unwrap()).collect();
    assert_eq!(outcomes, ["planned", "invalid_scene", "no reply"]);
    let planned = answer::reply_to(&request(7, 0), &Caps::default());
    let planned = planned.answers.unwrap()[0].clone().unwrap();
    assert_eq!(rows[0]["length"], planned.length);
    assert_eq!(rows[0]["clearance"], planned.clearance.value);
    assert_eq!(rows[0]["samples"], planned.samples.len());
    assert_eq!((&rows[0]["id"], &rows[0]["took"]), (&0.into(), &0.005.into()));
    assert_eq!((&rows[2]["id"], &rows[2]["took"]), (&2.into(), &Value::Null));

    let (_, text, error) = folder.run(&["show", "a.mcap"]);
    assert!(text.lines().next().unwrap().contains("outcome"), "{text}");
    let row: Vec<_> = text.lines().nth(1).unwrap().split_whitespace().collect();
    assert_eq!(row[..5], ["0", "0", "disassemble", "0", "planned"]);
    assert_eq!(row[row.len() - 2..], ["5.000", "ms"]);
    assert!(error.contains("request 2 (0000000000000007/2) has no reply"), "{error}");
    let (_, csv, _) = folder.run(&["show", "a.mcap", "--format", "csv"]);
    let lines: Vec<_> = csv.lines().collect();
    assert!(lines.iter().all(|line| line.split(',').count() == 14), "{csv}");
    assert!(lines[2].starts_with("1,0000000000000007/1,1,disassemble,,invalid_scene,,"), "{csv}");
}

#[test]
fn filters_choose_requests() {
    let folder = mixed();
    let numbers = |filters: &[&str]| -> Vec<u64> {
        rows(&folder, filters).iter().map(|row| row["request"].as_u64().unwrap()).collect()
    };
    assert_eq!(numbers(&["--id", "0", "--id", "2"]), [0, 2]);
    assert!(numbers(&["--task", "drive"]).is_empty());
    assert_eq!(numbers(&["--task", "disassemble"]), [0, 1, 2]);
    assert_eq!(numbers(&["--error"]), [1]);
    assert_eq!(numbers(&["--error=invalid_scene"]), [1]);
    assert!(numbers(&["--error=no_route"]).is_empty());
    assert_eq!(numbers(&["--where", "length>0"]), [0]);
    assert_eq!(numbers(&["--where", "took<=5ms", "--where", "request>=1"]), [1]);
}

#[test]
fn a_request_is_printed_as_the_scene_it_is() {
    let folder = mixed();
    let (code, out, _) = folder.run(&["show", "a.mcap", "--request", "0"]);
    let RequestContent::Scene(scene) = request(7, 0).content else { unreachable!() };
    assert_eq!((code, json::read_scene(&out).unwrap()), (0, scene));
    let found = "a.mcap has the requests 0 to 2, not 3";
    folder.check(&["show", "a.mcap", "--request", "3"], 1, "", found);
}

#[test]
fn a_reply_is_printed_in_three_forms() {
    let folder = mixed();
    let planned = answer::reply_to(&request(7, 0), &Caps::default());
    let (code, out, _) = folder.run(&["show", "a.mcap", "--reply", "0", "--format", "json"]);
    assert_eq!((code, out.trim_end()), (0, json::reply_to_json(&planned).as_str()));
    let (_, out, _) = folder.run(&["show", "a.mcap", "--reply", "0", "--format", "csv"]);
    let samples = planned.answers.unwrap()[0].as_ref().unwrap().samples.len();
    assert_eq!(out.lines().count(), 1 + samples);
    folder.check(&["show", "a.mcap", "--reply", "1"], 0, "request 1 (id 1): ", "");
    folder.check(&["show", "a.mcap", "--reply", "2"], 3, "", "request 2 has no whole reply");
}

#[test]
fn a_picture_overwrites_nothing() {
    let folder = mixed();
    let draw = ["show", "a.mcap", "--request", "0", "--svg", "a.svg"];
    folder.check(&draw, 0, "", "");
    let drawn = std::fs::read_to_string(folder.path("a.svg")).unwrap();
    assert!(roxmltree::Document::parse(&drawn).is_ok());
    folder.check(&draw, 1, "", "a.svg exists; --overwrite replaces it");
    folder.check(&[&draw[..], &["--overwrite"]].concat(), 0, "", "");
    let over = ["show", "a.mcap", "--request", "0", "--svg", "a.mcap", "--overwrite"];
    folder.check(&over, 1, "", "a.mcap is read from");
    folder.check(&["show", "a.mcap", "--svg", "b.svg"], 1, "", "--request N");
}

#[test]
fn wrong_filters_are_usage_errors() {
    let folder = mixed();
    let check = |arguments: &[&str], said: &str| {
        folder.check(&[&["show", "a.mcap"], arguments].concat(), 2, "", said);
    };
    check(&["--where", "speed<1"], "\"speed\" is none of request, id,");
    check(&["--error=wrong"], "must be one of invalid_scene");
    check(&["--task", "fly"], "must be one of disassemble");
    check(&["--request", "0", "--reply", "0"], "cannot be used with");
    check(&["--request", "0", "--id", "0"], "cannot be used with");
}

#[test]
fn a_free_space_sent_once_is_printed_with_each_scene_that_names_it() {
    let folder = Folder::new();
    let (whole, reply) = record_named(folder.path("a.mcap"));
    let (code, out, _) = folder.run(&["show", "a.mcap", "--request", "1"]);
    assert_eq!((code, json::read_scene(&out).unwrap()), (0, whole));
    let said = |refusal: &Refusal| refusal.message.clone();
    assert!(reply.answers.as_ref().map_err(said).is_ok());
    let (_, out, _) = folder.run(&["show", "a.mcap", "--reply", "1", "--format", "json"]);
    assert_eq!(out.trim_end(), json::reply_to_json(&reply));
}
