//! Layouts and bytes of this version. A change here is a new version of the messages.

use std::fmt::Write;
use std::mem::offset_of;
use std::path::Path;

use schemas::message::{Request, RequestContent};
use schemas::wire::{self, LAYOUT, Leg, ReplyHeader, RequestHeader, Sample, TapHeader};
use schemas::{codec, convert, topic};

use super::examples::{self, Parts};

macro_rules! fields {
    ($type:ident: $($field:ident)*) => {
        [$((stringify!($field), offset_of!($type, $field))),*]
    };
}

/// Fields with their offsets as C lays out what the text from `begin` on says, up to the
/// next line that is not a list of fields; and the size.
fn described(begin: &str) -> (Vec<(String, usize)>, usize) {
    let at = LAYOUT.find(begin).expect(begin);
    let lines = LAYOUT[at..].lines().skip(1).take_while(|line| line.starts_with("  "));
    let mut depth = 0;
    let mut text = String::new();
    for letter in lines.flat_map(|line| line.chars().chain([' '])) {
        depth += i32::from(letter == '(');
        text.extend((depth == 0).then_some(letter));
        depth -= i32::from(letter == ')');
    }
    let (mut end, mut fields) = (0, Vec::new());
    for field in text.split(',') {
        let (kind, name) = field.trim().split_once(' ').expect("a type and a name");
        let size = match kind {
            "u16" => 2,
            "u32" => 4,
            "u64" | "f64" => 8,
            _ => panic!("{field}"),
        };
        let (name, count) = match name.trim().trim_end_matches(']').split_once('[') {
            Some((name, count)) => (name, count.parse().unwrap()),
            None => (name.trim(), 1),
        };
        let offset = usize::next_multiple_of(end, size);
        fields.push((name.to_owned(), offset));
        end = offset + size * count;
    }
    (fields, end)
}

#[track_caller]
fn check_layout<const N: usize>(begin: &str, fields: [(&str, usize); N], size: usize, ours: usize) {
    let (described, end) = described(begin);
    let fields = fields.map(|(name, offset)| (name.to_owned(), offset));
    assert_eq!(described, fields);
    assert_eq!((end, ours), (size, size));
    assert!(begin.ends_with(&format!("({size} bytes)")), "{begin}");
}

#[test]
fn memory_is_laid_out_as_described() {
    let fields = fields!(RequestHeader:
        version dimension client sequence sent_ns given id task start_turn sampling_kind
        body_kind wish_kind exits wake reserved sampling limits deadline start goal bounds
        curve choices body_points channels solids);
    let begin = "REQUEST  user header: RequestHeader (272 bytes)";
    check_layout(begin, fields, 272, size_of::<RequestHeader>());
    let fields = fields!(ReplyHeader:
        version dimension client sequence sent_ns id has_id last part kind answer answers exit
        gaps_per_junction length duration clearance clearance_at wall gaps route channels legs
        samples refusal);
    let begin = "REPLY PART  user header: ReplyHeader (152 bytes)";
    check_layout(begin, fields, 152, size_of::<ReplyHeader>());
    let fields = fields!(Leg:
        kind table number junction length clearance point to radius start heading sweep);
    check_layout("Leg (112 bytes)", fields, 112, size_of::<Leg>());
    let fields = fields!(Sample: t position heading velocity yaw_rate);
    check_layout("Sample (72 bytes)", fields, 72, size_of::<Sample>());
    let fields = fields!(TapHeader: sequence time_ns kind piece);
    check_layout("TAP  user header: TapHeader (24 bytes)", fields, 24, size_of::<TapHeader>());
}

#[test]
fn sizes_and_names_are_pinned() {
    assert_eq!((wire::VERSION, wire::PART_CELLS), (1, 16_384));
    assert_eq!((wire::LEG_CELLS, wire::SAMPLE_CELLS), (14, 9));
    assert_eq!(align_of::<RequestHeader>().max(align_of::<ReplyHeader>()), 8);
    assert_eq!(topic::layout_hash(), 0x35c7_081f_0ebf_6be2, "has the layout another version?");
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
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/pinned/{name}.txt"));
    if std::env::var_os("PIN").is_some() {
        std::fs::write(&path, form).unwrap();
    }
    let pinned = std::fs::read_to_string(&path).unwrap();
    assert_eq!(form, pinned, "{name} has other bytes than version 1 had");
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
