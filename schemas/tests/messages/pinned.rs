//! Bytes of the current version. A change here is a new version of the messages.

use std::fmt::Write;
use std::path::Path;

use schemas::message::{Request, RequestContent};
use schemas::wire::{self, ReplyHeader, RequestHeader};
use schemas::{codec, convert, topic};

use super::examples::{self, Parts};

#[test]
fn sizes_and_names_are_pinned() {
    assert_eq!((wire::VERSION, codec::VERSION, wire::PART_CELLS), (2, 3, 4_096));
    assert_eq!((wire::LEG_CELLS, wire::SAMPLE_CELLS), (14, 9));
    assert_eq!(align_of::<RequestHeader>().max(align_of::<ReplyHeader>()), 8);
    assert_eq!(wire::layout_hash(), 0x8b8a_7a32_156c_5a9f, "has the layout another version?");
    assert_eq!((topic::PLAN, topic::TAP), ("clearway/plan/2", "clearway/tap/2"));
    assert_eq!((topic::WAKE, topic::ANSWERED), ("clearway/wake", "clearway/answered"));
    assert_eq!(
        (codec::REQUEST_NAME, codec::REPLY_NAME),
        ("clearway.Request", "clearway.ReplyPart")
    );
    assert_eq!((topic::REQUEST, topic::REPLY), ("/planner/request", "/planner/reply"));
    assert_eq!((topic::PROFILE, topic::ENCODING), ("planning", "bincode"));
}

fn hex<'a>(rows: impl Iterator<Item = &'a [u8]>) -> String {
    rows.fold(String::new(), |mut text, row| {
        row.iter().for_each(|byte| write!(text, "{byte:02x}").unwrap());
        text + "\n"
    })
}

fn words(words: &[u64]) -> String {
    words.chunks(4).fold(String::new(), |text, row| {
        let row: Vec<_> = row.iter().map(|word| format!("{word:016x}")).collect();
        text + &row.join(" ") + "\n"
    })
}

fn form(header: &[u64], cells: &[u64], bytes: &[u8]) -> String {
    let (header, cells, bytes) = (words(header), words(cells), hex(bytes.chunks(32)));
    format!("header, words of 64 bits\n{header}payload\n{cells}recorded\n{bytes}")
}

/// To pin new bytes, set PIN=1 and look at what changed.
#[track_caller]
fn check_pinned(name: &str, form: &str) {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/pinned/version_3/{name}.txt"));
    if std::env::var_os("PIN").is_some() {
        std::fs::write(&path, form).unwrap();
    }
    let pinned = std::fs::read_to_string(&path).unwrap();
    assert_eq!(form, pinned, "{name} has other bytes than version 3 had");
}

#[test]
fn requests_are_pinned() {
    for (name, text) in examples::SCENES {
        let scene = examples::scene(text);
        let (key, sent_ns) = (examples::KEY, examples::SENT_NS);
        let mut cells = Vec::new();
        let header = convert::write_scene(&scene, key, sent_ns, &mut cells).unwrap();
        let content = RequestContent::Scene(scene);
        let bytes = codec::encode(&Request { key, sent_ns, content });
        let header = bytemuck::cast_slice(bytemuck::bytes_of(&header));
        check_pinned(&format!("request-{name}"), &form(header, &cells, &bytes));
    }
}

#[test]
fn reply_parts_are_pinned() {
    for (name, part) in examples::parts() {
        let mut sink = Parts::default();
        examples::write(&part, &mut sink);
        let [(header, cells)] = sink.0.try_into().unwrap();
        let header = bytemuck::cast_slice(bytemuck::bytes_of(&header));
        check_pinned(&format!("reply-{name}"), &form(header, &cells, &codec::encode(&part)));
    }
}
