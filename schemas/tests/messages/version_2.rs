//! Recordings of version 2, for ever: what `pinned/version_2` has is read as what it said.

use std::path::Path;

use schemas::codec;
use schemas::message::{Request, RequestContent};

use super::examples;

fn recorded(name: &str) -> Vec<u8> {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/pinned/version_2/{name}.txt"));
    let text = std::fs::read_to_string(path).unwrap();
    let digits: String = text.split_whitespace().collect();
    let byte = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).unwrap();
    (0..digits.len()).step_by(2).map(byte).collect()
}

#[test]
fn old_recordings_are_read() {
    let (key, sent_ns) = (examples::KEY, examples::SENT_NS);
    for (name, text) in &examples::SCENES[..examples::SCENES_OF_VERSION_2] {
        let content = RequestContent::Scene(examples::scene(text));
        let request = codec::decode_request(2, &recorded(&format!("request-{name}")));
        assert_eq!(request.unwrap(), Request { key, sent_ns, content }, "{name}");
    }
    for (name, part) in examples::parts() {
        let read = codec::decode_reply(2, &recorded(&format!("reply-{name}")));
        assert_eq!(read.unwrap(), part, "{name}");
    }
}
