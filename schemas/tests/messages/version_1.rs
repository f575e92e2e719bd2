//! Version 1, for ever: its bytes in `pinned/version_1` never change, and what is read
//! from them and written to old clients stays the same.

use std::path::Path;

use proptest::prelude::*;
use schemas::message::{ErrorCode, Refusal, Request, RequestContent, SceneRequest, Trajectory};
use schemas::wire::{ReplyHeader, RequestHeader, previous};
use schemas::{codec, convert};

use super::examples::{self, Parts};
use super::strategies::{numbers, refusal, trajectory};

/// A pinned message: header and payload in memory, and as recorded.
struct Pinned {
    header: Vec<u64>,
    cells: Vec<u64>,
    recorded: Vec<u8>,
}

fn pinned(name: &str) -> Pinned {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/pinned/version_1/{name}.txt"));
    let text = std::fs::read_to_string(path).unwrap();
    let (memory, recorded) = text.split_once("recorded\n").unwrap();
    let (header, cells) = memory.split_once("payload\n").unwrap();
    let words = |text: &str| -> Vec<u64> {
        text.split_whitespace().map(|word| u64::from_str_radix(word, 16).unwrap()).collect()
    };
    let digits: String = recorded.split_whitespace().collect();
    let byte = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).unwrap();
    Pinned {
        header: words(header.trim_start_matches("header, words of 64 bits\n")),
        cells: words(cells),
        recorded: (0..digits.len()).step_by(2).map(byte).collect(),
    }
}

/// A request's header as a planner of the current version sees it.
fn upgraded(words: &[u64]) -> RequestHeader {
    previous::upgrade_request(&previous::RequestHeader(words.try_into().unwrap()))
}

#[test]
fn requests_of_old_clients_are_read() {
    for (name, text) in &examples::SCENES[..examples::OLD_SCENES] {
        let Pinned { header, cells, .. } = pinned(&format!("request-{name}"));
        let header = upgraded(&header);
        assert_eq!(convert::check_version(&header), Ok(()), "{name}");
        let mut scene = SceneRequest::empty();
        convert::read_scene(&header, &cells, &mut scene).unwrap();
        assert_eq!(scene, examples::scene(text), "{name}");
    }
}

#[test]
fn requests_of_no_known_version_are_refused() {
    let Pinned { mut header, .. } = pinned("request-drive");
    for version in [0, 2, 3, u64::from(u32::MAX)] {
        header[0] = header[0] >> 32 << 32 | version;
        let header = upgraded(&header);
        let refusal = convert::check_version(&header).unwrap_err();
        assert_eq!(refusal.code, ErrorCode::UnsupportedVersion);
    }
}

/// A part as an old client gets it.
fn downgraded(part: &(ReplyHeader, Vec<u64>)) -> (previous::ReplyHeader, Vec<u64>) {
    let (header, cells) = part;
    let mut old = Vec::new();
    let header = previous::downgrade(header, cells, &mut old);
    (header, old)
}

#[test]
fn replies_to_old_clients_are_pinned() {
    let parts = examples::parts();
    for (name, part) in &parts[..examples::OLD_PARTS] {
        let mut sink = Parts::default();
        examples::write(part, &mut sink);
        let (header, cells) = downgraded(&sink.0[0]);
        let pinned = pinned(&format!("reply-{name}"));
        assert_eq!((&header.0[..], &cells), (&pinned.header[..], &pinned.cells), "{name}");
    }
}

/// Version 2's header with what version 1's says.
fn header_of_old(old: previous::ReplyHeader) -> ReplyHeader {
    let mut words = [0; size_of::<ReplyHeader>() / 8];
    words[..old.0.len()].copy_from_slice(&old.0);
    let header: ReplyHeader = bytemuck::cast(words);
    assert_eq!((header.version, header.given & !1), (1, 0));
    ReplyHeader { version: 2, ..header }
}

/// Reads a refusal of version 1: version 2 has one cell more, the setting's length.
fn read_old(header: previous::ReplyHeader, mut cells: Vec<u64>) -> Refusal {
    let header = header_of_old(header);
    assert_eq!(header.refusal as usize, cells.len());
    cells.insert(11, 0);
    let header = ReplyHeader { refusal: cells.len() as u32, ..header };
    convert::read_part(&header, &cells).unwrap().content.unwrap_err()
}

proptest! {
    #[test]
    fn refusals_reach_old_clients_without_what_is_new(refusal in refusal(&numbers())) {
        let mut sink = Parts::default();
        examples::write(&examples::of_answer(Err(refusal.clone())), &mut sink);
        let (header, cells) = downgraded(&sink.0[0]);
        let code = match refusal.code {
            ErrorCode::TooCostly | ErrorCode::UnknownFreeSpace => ErrorCode::InvalidScene,
            code => code,
        };
        prop_assert_eq!(read_old(header, cells), Refusal { code, setting: None, ..refusal });
    }

    #[test]
    fn trajectories_reach_old_clients_without_what_is_new(trajectory in trajectory(numbers())) {
        let mut sink = Parts::default();
        examples::write(&examples::of_answer(Ok(trajectory.clone())), &mut sink);
        let (header, cells) = downgraded(&sink.0[0]);
        let mut expected = Trajectory {
            bound: None, complete: true, free_clearance: None, exceeds: None, stops: None, ..trajectory
        };
        for leg in &mut expected.legs {
            (leg.reverse, leg.rung) = (false, None);
        }
        let read = convert::read_part(&header_of_old(header), &cells).unwrap();
        prop_assert_eq!(read.content, Ok(expected));
    }
}

#[test]
fn old_recordings_are_read() {
    let (key, sent_ns) = (examples::KEY, examples::SENT_NS);
    for (name, text) in &examples::SCENES[..examples::OLD_SCENES] {
        let content = RequestContent::Scene(examples::scene(text));
        let request = codec::decode_request(1, &pinned(&format!("request-{name}")).recorded);
        assert_eq!(request.unwrap(), Request { key, sent_ns, content }, "{name}");
    }
    for (name, part) in &examples::parts()[..examples::OLD_PARTS] {
        let read = codec::decode_reply(1, &pinned(&format!("reply-{name}")).recorded);
        assert_eq!(read.unwrap(), *part, "{name}");
    }
}

#[test]
fn an_unreadable_request_of_an_old_recording_is_answered_as_it_was() {
    let recorded = |version: u64| {
        let header = vec![2 << 32 | version, 3];
        let content = RequestContent::Unreadable { header, cells: vec![5] };
        let bytes = codec::encode(&Request { key: examples::KEY, sent_ns: 0, content });
        match codec::decode_request(1, &bytes).unwrap().content {
            RequestContent::Unreadable { header, .. } => header,
            content => panic!("{content:?}"),
        }
    };
    let own = recorded(1);
    assert_eq!(own[..2], [2 << 32 | 2, 3], "the planner's own version");
    assert_eq!(own.len() * 8, size_of::<RequestHeader>());
    for other in [0, 2, 9] {
        assert_ne!(recorded(other)[0] as u32, 2, "refused then, refused now");
    }
}

#[test]
fn later_versions_are_refused_with_both_numbers() {
    let bytes = codec::encode(&examples::of_answer(Err(examples::refusal())));
    for version in [0, 4] {
        let expected = format!("the message has version {version}; versions 1 to 3 are supported");
        assert_eq!(codec::decode_reply(version, &bytes).unwrap_err().to_string(), expected);
        assert_eq!(codec::decode_request(version, &bytes).unwrap_err().to_string(), expected);
    }
}
