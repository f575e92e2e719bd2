//! Recordings of version 1, for ever: files written by its writer, byte for byte. Three are still the
//! golden recordings of today; the others, whose replies have changed since, lie beside this test.

use std::path::{Path, PathBuf};

use recording::{Message, Options, Reader, Record, recover};
use schemas::message::{ReplyAssembler, RequestContent};

/// Name, CRC-32, requests.
const FILES: [(&str, u32, usize); 6] = [
    ("disassembly", 0xf7e5_3dc2, 3),
    ("driving", 0x6ed6_c787, 6),
    ("free-space", 0x4da5_d89c, 3),
    ("no-route", 0x33cc_924a, 13),
    ("refusals", 0x0f7c_ade2, 11),
    ("routes", 0xc99b_ddc9, 4),
];

fn path(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let beside = folder.join(format!("tests/version_1/{name}.mcap"));
    if beside.exists() { beside } else { folder.join(format!("../../recordings/{name}.mcap")) }
}

fn records(path: &Path) -> Vec<Record> {
    let mut reader = Reader::open(path).unwrap();
    let records: Vec<_> = reader.by_ref().map(Result::unwrap).collect();
    let summary = reader.summary().expect("finished");
    assert_eq!((summary.recorded, summary.lost), (records.len() as u64, 0));
    records
}

#[test]
fn recordings_of_version_1_are_unchanged_and_read() {
    for (name, checksum, requests) in FILES {
        let bytes = std::fs::read(path(name)).unwrap();
        assert_eq!(
            crc32fast::hash(&bytes),
            checksum,
            "{name} is no longer the file of version 1: put that one back beside this test"
        );
        let mut found = 0;
        let mut assembler = ReplyAssembler::default();
        for record in records(&path(name)) {
            match record.message {
                Message::Request(request) => {
                    found += 1;
                    assert!(matches!(request.content, RequestContent::Scene(_)), "{name}");
                }
                Message::Reply(part) => {
                    if let Err(refusal) = &part.content {
                        assert_eq!(refusal.setting, None, "version 1 has none");
                    }
                    if assembler.push(part).unwrap().is_some() {
                        assembler = ReplyAssembler::default();
                    }
                }
            }
        }
        assert_eq!((found, assembler.parts()), (requests, 0), "{name}");
    }
}

#[test]
fn a_recovered_recording_of_version_1_holds_the_same_messages() {
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().join("recovered.mcap");
    for (name, _, _) in FILES {
        let recovered = recover(&path(name), &to, false, Options::overwriting()).unwrap();
        assert!(recovered.reason.is_none(), "{name}: {:?}", recovered.reason);
        assert_eq!(records(&to), records(&path(name)), "{name}");
        let text = String::from_utf8_lossy(&std::fs::read(&to).unwrap()).into_owned();
        assert!(text.contains("schema_version"), "{name} is written in the newest version");
    }
}
