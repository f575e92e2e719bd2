//! The recordings in `recordings/`: what was planned then is planned now.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use integration_tests::{TestDomain, root};
use recording::{Compression, Message, Options, Writer};
use schemas::message::ReplyPart;
use sha2::{Digest, Sha256};

use crate::independent::{node, python};
use crate::read::recording;

/// The largest a recording in the repository may be, and one of a single scene, bytes.
const MOST_BYTES: u64 = 1 << 20;
const MOST_OF_ONE: u64 = 64 << 10;

fn of_one() -> Vec<PathBuf> {
    comparison::check::find(&[root().join("recordings/each")]).unwrap()
}

fn golden() -> Vec<PathBuf> {
    let mut found = comparison::check::find(&[root().join("recordings")]).unwrap();
    found.retain(|path| !of_one().contains(path));
    found
}

#[test]
fn recordings_replay_bit_for_bit() {
    let test = TestDomain::new();
    let files = [golden(), of_one()].concat();
    let mut arguments = vec!["check"];
    arguments.extend(files.iter().map(|path| path.to_str().unwrap()));
    let checked = test.run("replay", &arguments);
    assert_eq!((checked.code, checked.stderr.as_str()), (Some(0), ""), "{}", checked.stdout);
}

#[test]
fn generated_files_are_up_to_date() {
    let checked = TestDomain::new().run("bless", &["--check"]);
    assert_eq!(checked.code, Some(0), "run `cargo bless`: {checked:?}");
}

#[test]
fn recordings_are_small_and_described() {
    let readme = std::fs::read_to_string(root().join("recordings/README.md")).unwrap();
    let scenes = integration_tests::scene_files();
    for path in golden().iter().chain(&scenes) {
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(
            readme.contains(&format!("`{name}`")),
            "recordings/README.md has no row for {name}"
        );
        let bytes = path.metadata().unwrap().len();
        assert!(bytes <= MOST_BYTES, "{name} has {bytes} bytes, at most {MOST_BYTES} are allowed");
    }
}

/// Each scene has its own; a difference there is of that scene alone.
#[test]
fn recordings_of_one_scene_are_small() {
    let files = of_one();
    assert!(files.len() > 30);
    for path in files {
        let bytes = path.metadata().unwrap().len();
        assert!(bytes <= MOST_OF_ONE, "{} has {bytes} bytes", path.display());
        assert_eq!(recording(&path).requests().len(), 1, "{}", path.display());
    }
}

/// Copies a recording with `change` made to each part of a reply.
fn tampered(from: &Path, to: &Path, change: impl FnMut(&mut ReplyPart)) {
    copied(from, to, Options::default(), change);
}

fn copied(from: &Path, to: &Path, options: Options, mut change: impl FnMut(&mut ReplyPart)) {
    let mut writer = Writer::create(to, options).unwrap();
    for record in recording(from).records {
        match record.message {
            Message::Request(request) => writer.write_request(&request, record.log_ns).unwrap(),
            Message::Reply(mut part) => {
                change(&mut part);
                writer.write_reply(&part, record.log_ns).unwrap();
            }
        }
    }
    writer.finish().unwrap();
}

#[test]
fn one_changed_bit_is_a_regression_that_says_where() {
    let test = TestDomain::new();
    let original = root().join("recordings/disassembly.mcap");
    tampered(&original, &test.path("same.mcap"), |_| {});
    assert_eq!(test.run("replay", &["check", "same.mcap"]).code, Some(0));

    let (mut parts, mut recorded) = (0, None);
    let mut key = None;
    tampered(&original, &test.path("changed.mcap"), |part| {
        parts += 1;
        if parts == 2 {
            let value = &mut part.content.as_mut().unwrap().samples[17].position[1];
            let before = *value;
            *value = before.next_up();
            recorded = Some((before, *value));
            key = Some((part.key, part.answer));
        }
    });
    let ((planned, changed), (key, answer)) = (recorded.unwrap(), key.unwrap());
    let checked = test.run("replay", &["check", "changed.mcap"]);
    assert_eq!(checked.code, Some(4), "{checked:?}");
    let place = format!("({key}): answer {answer}, sample 17, position[1]: recorded ");
    let line = checked.stdout.lines().find(|line| line.contains(&place));
    let line = line.unwrap_or_else(|| panic!("{place:?} is not in {}", checked.stdout));
    // The values are told with all their digits.
    let (_, values) = line.split_once(&place).unwrap();
    let mut values = values.split([',', ' ']).filter_map(|word| word.parse::<f64>().ok());
    assert_eq!(values.next(), Some(changed), "{line}");
    assert_eq!(values.next(), Some(planned), "{line}");
    let tolerant = test.run("replay", &["check", "changed.mcap", "--tolerance", "1e-12"]);
    assert_eq!(tolerant.code, Some(0), "{tolerant:?}");
}

/// A program that reads recordings with nothing of ours, and what it takes before and after the
/// file.
struct Independent {
    program: PathBuf,
    before: PathBuf,
    after: Vec<PathBuf>,
}

#[test]
fn a_reader_in_python_sees_the_same() {
    match python() {
        Some(program) => {
            let before = root().join("tests/system/read_mcap.py");
            check_reader(&Independent { program, before, after: Vec::new() });
        }
        None => println!("SKIPPED: no Python with the package mcap can be had here"),
    }
}

#[test]
fn a_reader_in_javascript_sees_the_same() {
    match node() {
        Some(folder) => {
            let before = root().join("tests/system/read_mcap.mjs");
            check_reader(&Independent { program: "node".into(), before, after: vec![folder] });
        }
        None => println!("SKIPPED: no Node.js with the package @mcap/core can be had here"),
    }
}

fn check_reader(reader: &Independent) {
    let read = |path: &Path| {
        let mut command = Command::new(&reader.program);
        command.arg(&reader.before).arg(path).args(&reader.after).output().unwrap()
    };
    let test = TestDomain::new();
    // Messages of earlier versions have other bytes in this one.
    let newest = b"schema_version\x01\0\0\x003";
    let is_newest = |path: &PathBuf| {
        let bytes = std::fs::read(path).unwrap();
        bytes.windows(newest.len()).any(|text| text == newest)
    };
    let mut files = golden();
    files.retain(is_newest);
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd] {
        let path = test.path(&format!("{compression:?}.mcap"));
        let options = Options { compression, chunk_bytes: 20_000, ..Options::default() };
        copied(&root().join("recordings/driving.mcap"), &path, options, |_| {});
        files.push(path);
    }
    for path in files {
        let bytes = std::fs::read(&path).unwrap();
        let read_damaged = |at: usize| {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1;
            let path = test.path("damaged.mcap");
            std::fs::write(&path, damaged).unwrap();
            read(&path)
        };
        // In the middle of a chunk's messages; else agreement would say nothing of checksums.
        assert!(!read_damaged(bytes.len() / 2).status.success(), "{}", path.display());
        let read = read(&path);
        let said = String::from_utf8_lossy(&read.stderr);
        assert!(read.status.success(), "{}: {said}", path.display());
        let recording = recording(&path);
        let mut expected = String::new();
        let mut hashes: BTreeMap<&str, Sha256> = BTreeMap::new();
        for record in &recording.records {
            let (topic, key) = match &record.message {
                Message::Request(request) => (schemas::topic::REQUEST, request.key),
                Message::Reply(part) => (schemas::topic::REPLY, part.key),
            };
            let bytes = match &record.message {
                Message::Request(request) => schemas::codec::encode(request),
                Message::Reply(part) => schemas::codec::encode(part),
            };
            hashes.entry(topic).or_default().update(&bytes);
            let (log, publish) = (record.log_ns, record.publish_ns);
            let (sequence, length) = (record.sequence, bytes.len());
            expected += &format!(
                "{topic} {sequence} {log} {publish} {} {} {length}\n",
                key.client, key.sequence
            );
        }
        let summary = recording.summary.unwrap();
        let found = String::from_utf8_lossy(&read.stdout).into_owned();
        for (topic, hash) in hashes {
            let digits: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
            expected += &format!("{topic} {digits}\n");
        }
        expected += &format!("{} {} {}\n", summary.recorded, summary.lost, summary.gaps);
        assert_eq!(found, expected, "{}", path.display());
    }
}
