//! The program on recordings whole, changed, incomplete, cut and damaged.

mod check;
mod export;
// Their planners are those of debug builds.
#[cfg(debug_assertions)]
mod mutations;
mod page;
mod recorded;
mod rewrite;
mod show;

use std::collections::BTreeMap;
use std::process::{Command, Stdio};

use answer::Caps;
use assert_cmd::cargo::cargo_bin;
use recording::{Options, Writer};
use schemas::message::{ErrorCode, Refusal, Request, RequestContent};
use serde_json::{Value, json};

use recorded::{Folder, keep, parts, record, request, samples};

#[test]
fn equal_replies_are_equal() {
    let folder = Folder::with("a.mcap", keep);
    folder.check(&["check", "a.mcap"], 0, "a.mcap: 3 requests, 3 equal\n", "");
    folder.check(&["check", "."], 0, "3 equal", "");
}

#[test]
fn the_first_difference_is_a_regression() {
    let folder = Folder::with("a.mcap", |part| {
        if part.key.sequence == 1 {
            samples(part)[4].position[1] += 0.001;
            samples(part)[5].t += 1.0;
        }
        true
    });
    let said = "a.mcap: request 1 (0000000000000007/1): answer 0, sample 4, position[1]: recorded ";
    folder.check(&["check", "a.mcap"], 4, said, "");
    folder.check(&["check", "a.mcap"], 4, "3 requests, 2 equal, 1 different", "");
    folder.check(&["check", "a.mcap", "--tolerance", "0.01"], 4, "sample 5, t: recorded", "");
    folder.check(&["check", "a.mcap", "--tolerance", "1"], 0, "3 equal", "");

    let (code, out, _) = folder.run(&["check", "a.mcap", "--format", "json"]);
    let out: Value = serde_json::from_str(&out).unwrap();
    let difference = &out["files"][0]["differences"][0];
    assert_eq!(code, 4);
    assert_eq!(difference["request"], 1);
    assert_eq!(difference["list"], "sample");
    assert_eq!(difference["index"], 4);
    assert_eq!(difference["field"], "position[1]");
}

#[test]
fn a_missing_reply_is_lost_data() {
    let folder = Folder::with("a.mcap", |part| part.key.sequence != 1);
    let said = "request 1 (0000000000000007/1) has no reply";
    folder.check(&["check", "a.mcap"], 3, "3 requests, 2 equal, 1 incomplete", said);

    let folder = Folder::with("a.mcap", |part| {
        part.last &= part.key.sequence != 1;
        true
    });
    folder.check(&["check", "a.mcap"], 3, "1 incomplete", "is cut off after 1 parts");

    let folder = Folder::with("a.mcap", |part| {
        part.part += u32::from(part.key.sequence == 1);
        true
    });
    folder.check(&["check", "a.mcap"], 3, "1 incomplete", "part 0 of the reply is missing");

    let folder = Folder::with("a.mcap", |part| {
        part.key.client += u64::from(part.key.sequence == 1);
        true
    });
    folder.check(&["check", "a.mcap"], 3, "2 incomplete", "which is not in the recording");
}

#[test]
fn a_cut_recording_is_lost_data_and_recovered() {
    let folder = Folder::with("a.mcap", keep);
    let bytes = std::fs::read(folder.path("a.mcap")).unwrap();
    std::fs::write(folder.path("cut.mcap"), &bytes[..bytes.len() / 2]).unwrap();
    folder.check(&["check", "cut.mcap"], 3, "equal, cut", "the recording is cut");
    folder.check(&["info", "cut.mcap"], 3, "the recording is cut", "");
    folder.check(
        &["recover", "cut.mcap", "-o", "b.mcap"],
        3,
        "messages recovered, 0 missing",
        "a record claims more bytes than the file has left",
    );
    folder.check(&["check", "b.mcap"], 0, "equal", "");
    folder.check(&["recover", "cut.mcap", "-o", "b.mcap"], 1, "", "b.mcap exists already");
    folder.check(&["recover", "cut.mcap", "-o", "b.mcap", "--overwrite"], 3, "recovered", "");
}

/// A file that went through another tool: no checksums.
#[test]
fn what_no_checksum_covers_is_said_and_refused_on_demand() {
    let folder = Folder::with("a.mcap", keep);
    let bytes = std::fs::read(folder.path("a.mcap")).unwrap();
    let mut copied = Vec::new();
    let (mut at, mut records) = (8, 0);
    // Chunks without their marks, checksums and index.
    copied.extend(&bytes[..8]);
    while at < bytes.len() - 8 {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        let mut record = bytes[at..at + 9 + length].to_vec();
        match record[0] {
            1 => copied.extend(record),
            6 => {
                record[9 + 24..9 + 28].fill(0);
                copied.extend(record);
                records += 1;
            }
            _ => {}
        }
        at += 9 + length;
    }
    copied.extend([0x0f, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    copied.extend([2, 20, 0, 0, 0, 0, 0, 0, 0]);
    copied.extend([0; 20]);
    copied.extend(&bytes[..8]);
    assert_eq!(records, 4);
    std::fs::write(folder.path("b.mcap"), copied).unwrap();
    folder.check(&["check", "b.mcap"], 0, "3 equal", "no checksum covers");
    folder.check(&["check", "b.mcap", "--strict"], 1, "3 equal", "no checksum covers");
    folder.check(&["info", "b.mcap", "--strict"], 1, "no checksum covers", "no checksum covers");
    folder.check(&["check", "a.mcap", "--strict"], 0, "3 equal", "");
    folder.check(&["recover", "b.mcap", "-o", "c.mcap"], 1, "", "no intact chunk of messages");
    let arguments = ["recover", "b.mcap", "-o", "c.mcap", "--unverified"];
    folder.check(&arguments, 3, "6 messages recovered, 0 missing", "no checksum covers a chunk");
    folder.check(&["info", "c.mcap"], 0, "unverified_parts", "");
}

#[test]
fn a_damaged_recording_is_a_failure() {
    let folder = Folder::with("a.mcap", keep);
    let mut bytes = std::fs::read(folder.path("a.mcap")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    std::fs::write(folder.path("damaged.mcap"), &bytes).unwrap();
    folder.check(&["check", "damaged.mcap"], 1, "unreadable before its end", "the checksum of");
    folder.check(&["recover", "damaged.mcap", "-o", "b.mcap"], 3, "2 missing in 1 gaps", "damaged");
    folder.check(&["check", "b.mcap"], 3, "2 equal", "the recorder missed 2 messages");
}

#[test]
fn a_check_of_nothing_fails() {
    let folder = Folder::new();
    folder.check(&["check", "."], 1, "", ".: contains no *.mcap files");
    folder.check(&["check", "none.mcap"], 1, "", "none.mcap: No such file");
    Writer::create(folder.path("empty.mcap"), Options::default()).unwrap().finish().unwrap();
    folder.check(&["check", "empty.mcap"], 1, "0 requests", "replay: nothing to compare");
    folder.check(&["info", "empty.mcap"], 0, "finished", "");
}

#[test]
fn wrong_arguments_are_a_usage_error() {
    let folder = Folder::new();
    folder.check(&["check"], 2, "", "Usage:");
    folder.check(&["check", "a.mcap", "--tolerance", "-1"], 2, "", "");
    folder.check(
        &["check", "a.mcap", "--tolerance", "NaN"],
        2,
        "",
        "must be a number, 0 or greater",
    );
    for option in [&["--domain", "x"], &["--wait", "1s"], &["--timeout", "1s"]] {
        folder.check(&[&["check", "a.mcap"], &option[..]].concat(), 2, "", "--via-bus");
    }
    folder.check(&["--help"], 0, "Exit codes:", "");
}

#[test]
fn two_runs_of_the_same_requests_are_compared() {
    let folder = Folder::with("a.mcap", keep);
    record(&folder.path("b.mcap"), 8, keep);
    record(&folder.path("c.mcap"), 8, |part| {
        samples(part)[2].t += 0.5;
        part.key.sequence != 2
    });
    folder.check(&["diff", "a.mcap", "b.mcap"], 0, "3 equal, 0 different, 0 only in a.mcap", "");
    let place = "pair 0 (0000000000000007/0 and 0000000000000008/0): answer 0, sample 2, t: ";
    folder.check(&["diff", "a.mcap", "c.mcap"], 4, place, "request 2");
    folder.check(
        &["diff", "a.mcap", "c.mcap"],
        4,
        "2 different, 1 only in a.mcap, 0 only in c.mcap",
        "",
    );
    let tolerant = ["diff", "a.mcap", "c.mcap", "--tolerance", "0.5"];
    folder.check(&tolerant, 4, "2 equal, 0 different, 1 only in a.mcap", "");
}

#[test]
fn rerecorded_requests_are_paired_by_their_ids() {
    let folder = Folder::with("a.mcap", keep);
    // Another client asks in the other order, at another speed.
    let mut writer = Writer::create(folder.path("b.mcap"), Options::default()).unwrap();
    for sequence in 0..3 {
        let mut request = request(9, sequence);
        let RequestContent::Scene(scene) = &mut request.content else { unreachable!() };
        scene.id = Some(2 - sequence);
        scene.limits.speed = Some(if sequence == 0 { 0.25 } else { 1.0 });
        writer.write_request(&request, 1).unwrap();
        for part in parts(answer::reply_to(&request, &Caps::default())) {
            writer.write_reply(&part, 2).unwrap();
        }
    }
    writer.finish().unwrap();
    let (code, out, _) = folder.run(&["diff", "a.mcap", "b.mcap", "--format", "json"]);
    let out: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((code, &out["equal"], &out["different"]), (4, &json!(2), &json!(1)), "{out}");
    let answer = &out["answers"][0];
    assert_eq!(
        (&answer["id"], &answer["request"], &answer["other_request"]),
        (&json!(2), &json!(2), &json!(0))
    );
    assert_eq!(
        (&answer["verdict"], &answer["motion"]["length"]["change"]),
        (&json!("moved"), &json!(0.0))
    );
    let (code, out, _) = folder.run(&["diff", "a.mcap", "b.mcap", "--format", "junit"]);
    let document = roxmltree::Document::parse(&out).unwrap();
    assert_eq!((code, elements(&document, "testcase").len()), (4, 3));
    assert_eq!(elements(&document, "failure").len(), 1);
}

#[test]
fn differences_are_printed_as_json() {
    let folder = Folder::with("a.mcap", keep);
    record(&folder.path("b.mcap"), 8, |part| {
        samples(part)[2].t += 0.5;
        part.key.sequence == 0
    });
    let (code, out, _) = folder.run(&["diff", "a.mcap", "b.mcap", "--format", "json"]);
    let out: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(code, 4);
    assert_eq!((&out["equal"], &out["different"]), (&json!(0), &json!(1)));
    let difference = &out["differences"][0];
    assert_eq!(difference["keys"], json!(["0000000000000007/0", "0000000000000008/0"]));
    assert_eq!((&difference["field"], &difference["index"]), (&json!("t"), &json!(2)));
    assert_eq!(out["only_in_a"], json!(["0000000000000007/1", "0000000000000007/2"]));
    assert_eq!(out["only_in_b"], json!([]));
}

/// Attributes of the elements with this name.
fn elements(document: &roxmltree::Document, name: &str) -> Vec<BTreeMap<String, String>> {
    let named = document.descendants().filter(|node| node.has_tag_name(name));
    let attributes = |node: roxmltree::Node| {
        let each = node.attributes().map(|at| (at.name().to_owned(), at.value().to_owned()));
        each.collect()
    };
    named.map(attributes).collect()
}

#[test]
fn junit_has_a_suite_for_each_file_and_a_case_for_each_request() {
    // One reply differs, one depends on load, one is missing, and the file's name needs
    // escapes.
    let name = "<a> & \"b\".mcap";
    let folder = Folder::with(name, |part| {
        match part.key.sequence {
            0 => samples(part)[4].position[1] += 0.001,
            1 => {
                part.content = Err(Refusal::new(ErrorCode::Overloaded, "too many requests"));
                part.answers = 0;
            }
            _ => return false,
        }
        true
    });
    let (code, out, _) = folder.run(&["check", name, "--format", "junit"]);
    assert_eq!(code, 4);
    let document = roxmltree::Document::parse(&out).unwrap();
    for tag in ["testsuites", "testsuite"] {
        let [counts] = &elements(&document, tag)[..] else { panic!("{out}") };
        let count = |what: &str| counts[what].as_str();
        let counts = ["tests", "failures", "errors", "skipped"].map(count);
        assert_eq!(counts, ["3", "1", "1", "1"], "{tag}");
    }
    assert_eq!(elements(&document, "testsuite")[0]["name"], name);
    let cases = elements(&document, "testcase");
    let names: Vec<_> = cases.iter().map(|case| case["name"].as_str()).collect();
    let expected =
        ["request 0 (0000000000000007/0)", "request 1 (0000000000000007/1)", "recording 0"];
    assert_eq!(names, expected);
    assert!(cases.iter().all(|case| case["classname"] == name));
    let message = |tag: &str| elements(&document, tag)[0]["message"].clone();
    assert!(message("failure").starts_with("answer 0, sample 4, position[1]: recorded "));
    assert_eq!(message("skipped"), "depends on load");
    assert_eq!(message("error"), "request 2 (0000000000000007/2) has no reply");
}

#[test]
fn wording_is_not_compared() {
    let mut refused = Request { sent_ns: 0, ..request(7, 0) };
    let RequestContent::Scene(scene) = &mut refused.content else { unreachable!() };
    scene.limits.speed = Some(-1.0);
    let folder = Folder::new();
    let record = |name: &str, change: fn(&mut Refusal)| {
        let mut writer = Writer::create(folder.path(name), Options::default()).unwrap();
        writer.write_request(&refused, 1).unwrap();
        for mut part in parts(answer::reply_to(&refused, &Caps::default())) {
            change(part.content.as_mut().unwrap_err());
            writer.write_reply(&part, 2).unwrap();
        }
        writer.finish().unwrap();
    };
    record("same.mcap", |_| {});
    record("reworded.mcap", |refusal| refusal.message = "in other words".into());
    record("field.mcap", |refusal| refusal.field = Some("body".into()));
    folder.check(&["check", "same.mcap"], 0, "same.mcap: 1 request, 1 equal\n", "");
    let said = "reworded.mcap: 1 request, 1 equal (1 worded differently)\n";
    folder.check(&["check", "reworded.mcap"], 0, said, "");
    folder.check(&["check", "reworded.mcap", "--format", "json"], 0, "\"reworded\": 1,\n", "");
    let said = "1 equal (1 worded differently), 0 different";
    folder.check(&["diff", "same.mcap", "reworded.mcap"], 0, said, "");
    let said = "error.field: recorded body, planned limits.speed";
    folder.check(&["check", "field.mcap"], 4, said, "");
}

#[test]
fn a_recording_is_described() {
    let folder = Folder::with("a.mcap", keep);
    let (code, out, _) = folder.run(&["info", "a.mcap", "--format", "json"]);
    let out: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(code, 0);
    assert_eq!((&out["requests"], &out["clients"]), (&json!(3), &json!(1)));
    assert_eq!((&out["replies"], &out["parts"]), (&json!(3), &json!(3)));
    assert_eq!((&out["first_ns"], &out["last_ns"]), (&json!(10_000), &json!(20_002)));
    assert_eq!((&out["finished"], &out["error"]), (&json!(true), &Value::Null));
    folder.check(
        &["info", "a.mcap"],
        0,
        "requests  3 from 1 client\nreplies   3 whole, in 3 parts",
        "",
    );
}

#[test]
fn what_is_no_file_is_not_described() {
    let folder = Folder::new();
    for format in ["text", "json"] {
        let arguments = ["info", "none.mcap", "--format", format];
        let (code, out, said) = folder.run(&arguments);
        assert_eq!((code, out.as_str()), (1, ""));
        assert!(said.starts_with("none.mcap: ") && said.contains("No such file"), "{said}");
        assert_eq!(folder.run(&["info", ".", "--format", format]).1, "");
    }
}

#[test]
fn a_reader_that_stops_early_is_no_failure() {
    let folder = Folder::with("a.mcap", keep);
    let mut child = Command::new(cargo_bin!("replay"))
        .args(["check", "--format", "json"])
        .arg(folder.path("a.mcap"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}
