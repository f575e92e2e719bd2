//! Broken and hostile messages: never a panic, never much memory, always a named error.

use proptest::collection::vec;
use proptest::prelude::*;
use schemas::message::{ReplyPart, Request, RequestContent, SceneRequest};
use schemas::wire::{self, ReplyHeader, RequestHeader};
use schemas::{codec, convert, json};

use super::examples::{self, Parts};
use super::memory::peak;
use super::strategies::{finite, key, numbers, part, scene};

/// Replaces, inserts and removes words: index, value, what to do.
type Changes = Vec<(prop::sample::Index, u64, u8)>;

fn word() -> BoxedStrategy<u64> {
    const BORDERS: &[u64] =
        &[u64::MAX, 1 << 61, (1 << 61) + 1, 1 << 63, 1 << 60, 1 << 32, (1 << 32) - 1];
    prop_oneof![
        4 => 0..8_u64,
        2 => (0..8_u64).prop_map(|word| word << 32),
        2 => prop::sample::select(BORDERS),
        1 => any::<u64>(),
    ]
    .boxed()
}

fn changes() -> BoxedStrategy<Changes> {
    vec((any::<prop::sample::Index>(), word(), 0..4_u8), 0..4).boxed()
}

fn change(words: &mut Vec<u64>, changes: &Changes) {
    for (at, word, what) in changes {
        if words.is_empty() {
            words.push(*word);
        }
        let at = at.index(words.len());
        match what {
            0 => words.insert(at, *word),
            1 => drop(words.remove(at)),
            _ => words[at] = *word,
        }
    }
}

/// Memory of fixed size: words are replaced, the rest is cut or filled.
fn change_header<H: bytemuck::Pod>(header: &H, changes: &Changes) -> H {
    let mut words = bytemuck::cast_slice::<u8, u64>(bytemuck::bytes_of(header)).to_vec();
    let length = words.len();
    for (at, word, _) in changes {
        words[at.index(length)] = *word;
    }
    *bytemuck::from_bytes(bytemuck::cast_slice(&words))
}

/// Bytes that reading `cells` may take: the widest is a leg's or a box's form in memory.
fn allowed(cells: &[u64]) -> usize {
    8192 + 16 * size_of_val(cells)
}

fn check_scene(header: &RequestHeader, cells: &[u64]) {
    let mut scene = SceneRequest::empty();
    let (result, bytes) = peak(|| convert::read_scene(header, cells, &mut scene));
    assert!(bytes <= allowed(cells), "{bytes} bytes for {} cells", cells.len());
    match &result {
        Err(malformed) => {
            let refusal = convert::unreadable(malformed);
            assert!(refusal.message.ends_with(&malformed.to_string()), "{}", refusal.message);
        }
        Ok(()) => {
            // What can be read can be written, and is the same again (NaN included).
            let mut again = Vec::new();
            let key = examples::KEY;
            let header = convert::write_scene(&scene, key, 0, &mut again).unwrap();
            let mut read = SceneRequest::empty();
            convert::read_scene(&header, &again, &mut read).unwrap();
            assert_eq!(format!("{read:?}"), format!("{scene:?}"));
        }
    }
    let request = convert::read_request(header, cells);
    if let RequestContent::Unreadable { header: words, cells: kept } = &request.content {
        assert_eq!(kept, cells);
        let same = convert::header_of(words);
        assert_eq!(bytemuck::bytes_of(&same), bytemuck::bytes_of(header));
    } else {
        assert_eq!(result, Ok(()));
    }
    assert_eq!(convert::check_version(header).is_ok(), header.version == wire::VERSION);
}

fn check_part(header: &ReplyHeader, cells: &[u64]) {
    let (result, bytes) = peak(|| convert::read_part(header, cells));
    assert!(bytes <= allowed(cells), "{bytes} bytes for {} cells", cells.len());
    if let Err(malformed) = result {
        assert!(!malformed.to_string().is_empty());
    }
}

/// A Vec takes 1 MiB at most for what is only announced, at most three deep; twice what
/// it needs for what is there, which in memory is up to 10 times longer than in bytes.
fn check_bytes(bytes: &[u8]) {
    for version in 0..=codec::VERSION + 1 {
        let (request, taken) = peak(|| codec::decode_request(version, bytes).map(drop));
        let (reply, more) = peak(|| codec::decode_reply(version, bytes).map(drop));
        let allowed = (4 << 20) + 32 * bytes.len();
        assert!(taken.max(more) <= allowed, "{taken}, {more} bytes for {}", bytes.len());
        for error in [request, reply].into_iter().filter_map(Result::err) {
            assert!(!error.to_string().is_empty());
        }
    }
}

fn check_text(text: &str) {
    let (result, taken) = peak(|| json::read_scene(text));
    let allowed = 16384 + 100 * text.len();
    assert!(taken <= allowed, "{taken} bytes for {} of text", text.len());
    match result {
        Ok(scene) => assert_eq!(json::read_scene(&json::scene_to_json(&scene)), Ok(scene)),
        Err(unreadable) => {
            let refusal = unreadable.refusal;
            let field = refusal.field.expect("a field");
            assert!(!field.is_empty());
            let named = refusal.message.starts_with(&field) || field == "scene";
            assert!(named, "{field}: {}", refusal.message);
        }
    }
}

/// 2,000 cases, or as many as `PROPTEST_CASES` asks for.
fn many() -> ProptestConfig {
    let config = ProptestConfig::default();
    ProptestConfig { cases: config.cases.max(2000), ..config }
}

proptest! {
    #![proptest_config(many())]

    #[test]
    fn any_memory_as_a_scene(
        header in vec(word(), size_of::<RequestHeader>() / 8), cells in vec(word(), 0..40),
    ) {
        let header = convert::header_of(&header);
        check_scene(&header, &cells);
        let known = RequestHeader {
            version: wire::VERSION, dimension: 2 + header.dimension % 2, given: header.given % (1 << 33),
            task: header.task % 3, body_kind: header.body_kind % 4, start_turn: 0,
            sampling_kind: 0, wish_kind: header.wish_kind % 3, exits: header.exits % 2,
            path: header.path % 2, switches: header.switches % 8, report: 0, corners: header.corners % 2,
            sample_frame: header.sample_frame % 2, ..header
        };
        check_scene(&known, &cells);
    }

    #[test]
    fn changed_memory_as_a_scene(
        scene in scene(numbers()), header_changes in changes(), cell_changes in changes(),
    ) {
        let mut cells = Vec::new();
        let header = convert::write_scene(&scene, examples::KEY, 0, &mut cells).unwrap();
        change(&mut cells, &cell_changes);
        check_scene(&header, &cells);
        check_scene(&change_header(&header, &header_changes), &cells);
    }

    #[test]
    fn changed_memory_as_a_reply(
        part in part(numbers()), header_changes in changes(), cell_changes in changes(),
    ) {
        let mut sink = Parts::default();
        examples::write(&part, &mut sink);
        let [(header, mut cells)] = sink.0.try_into().unwrap();
        change(&mut cells, &cell_changes);
        check_part(&header, &cells);
        check_part(&change_header(&header, &header_changes), &cells);
    }

    #[test]
    fn any_bytes_as_messages(bytes: Vec<u8>, words in vec(word(), 0..40)) {
        for bytes in [bytes.as_slice(), bytemuck::cast_slice(&words)] {
            check_bytes(bytes);
        }
    }

    #[test]
    fn changed_bytes_as_messages(
        key in key(), scene in scene(numbers()), part in part(numbers()),
        changes in vec((any::<prop::sample::Index>(), word(), any::<bool>()), 0..4),
    ) {
        let content = RequestContent::Scene(scene);
        let mut request = codec::encode(&Request { key, sent_ns: 0, content });
        let mut reply = codec::encode(&part);
        for (at, word, long) in changes {
            for bytes in [&mut request, &mut reply] {
                let at = at.index(bytes.len());
                let changed = word.to_le_bytes();
                let length = if long { 8.min(bytes.len() - at) } else { 1 };
                bytes[at..at + length].copy_from_slice(&changed[..length]);
            }
        }
        check_bytes(&request);
        check_bytes(&reply);
    }

    #[test]
    fn any_text_as_a_scene(text: String, json in "[\\[\\]{}:,\"0-9eE+.a-z \\\\-]{0,80}") {
        check_text(&text);
        check_text(&json);
    }

    #[test]
    fn changed_text_as_a_scene(
        scene in scene(finite()),
        changes in vec((any::<prop::sample::Index>(), text_piece(), any::<bool>()), 0..4),
    ) {
        let mut text = json::scene_to_json(&scene);
        for (at, piece, replace) in changes {
            let at = text.floor_char_boundary(at.index(text.len()));
            let end = if replace { text.ceil_char_boundary(at + 1) } else { at };
            text.replace_range(at..end, &piece);
        }
        check_text(&text);
    }

    #[test]
    fn cut_messages_are_refused(scene in scene(numbers()), at: prop::sample::Index) {
        let content = RequestContent::Scene(scene.clone());
        let bytes = codec::encode(&Request { key: examples::KEY, sent_ns: 0, content });
        let cut = at.index(bytes.len());
        prop_assert!(codec::decode::<Request>(&bytes[..cut]).is_err());
        let mut cells = Vec::new();
        let header = convert::write_scene(&scene, examples::KEY, 0, &mut cells).unwrap();
        if !cells.is_empty() {
            let cut = at.index(cells.len());
            prop_assert!(convert::read_scene(&header, &cells[..cut], &mut SceneRequest::empty()).is_err());
        }
        cells.push(0);
        prop_assert!(convert::read_scene(&header, &cells, &mut SceneRequest::empty()).is_err());
    }
}

fn text_piece() -> BoxedStrategy<String> {
    const PIECES: &[&str] = &[
        "",
        ",",
        "[",
        "]",
        "{",
        "}",
        ":",
        "\"",
        "null",
        "-",
        "1e999",
        "NaN",
        "0",
        "{\"min\":1}",
        "\"id\":1,",
        "[[1]]",
        "\\u0000",
        "é",
        "true",
    ];
    prop_oneof![prop::sample::select(PIECES).prop_map(str::to_owned), ".{0,3}"].boxed()
}

#[test]
fn announced_texts_take_no_memory() {
    let mut bytes = codec::encode(&examples::of_answer(Err(examples::invalid())));
    // The message's count of bytes stands behind its code.
    let at = bytes.windows(16).position(|bytes| bytes.ends_with(b"clearanc")).unwrap();
    bytes[at..at + 8].copy_from_slice(&(200_u64 << 20).to_le_bytes());
    let (result, taken) = peak(|| codec::decode::<ReplyPart>(&bytes));
    assert!(result.is_err());
    assert!(taken < 4096, "{taken} bytes");
}

#[test]
fn bytes_behind_a_message_are_refused() {
    let mut bytes = codec::encode(&examples::of_answer(Ok(examples::driving())));
    let used = bytes.len();
    bytes.push(0);
    let error = codec::decode::<ReplyPart>(&bytes).unwrap_err();
    let said = format!("the message ends after {used} of {} bytes", used + 1);
    assert_eq!(error.to_string(), said);
}

#[track_caller]
fn check_scene_refused(text: &str, change: impl FnOnce(&mut RequestHeader), expected: &str) {
    let mut cells = Vec::new();
    let scene = examples::scene(text);
    let mut header = convert::write_scene(&scene, examples::KEY, 0, &mut cells).unwrap();
    change(&mut header);
    let error = convert::read_scene(&header, &cells, &mut SceneRequest::empty()).unwrap_err();
    assert_eq!(error.to_string(), expected);
}

#[test]
fn contradictions_are_refused() {
    let [
        (_, section_4),
        (_, solids),
        (_, spatial),
        (_, drive),
        _,
        (_, curve),
        (_, anywhere),
        _,
        _,
        (_, unions),
    ] = examples::SCENES;
    let known = "; the greatest known value is";
    check_scene_refused(
        section_4,
        |header| header.dimension = 1,
        &format!("dimension is 1{known} 3"),
    );
    check_scene_refused(
        section_4,
        |header| header.dimension = 4,
        &format!("dimension is 4{known} 3"),
    );
    check_scene_refused(
        section_4,
        |header| header.given = 1 << 33,
        &format!("given is 8589934592{known} 8589934591"),
    );
    check_scene_refused(
        unions,
        |header| header.body_points = 3,
        "body_points is 3, must be 2 for boxes",
    );
    check_scene_refused(unions, |header| header.body_kind = 4, &format!("body_kind is 4{known} 3"));
    check_scene_refused(anywhere, |header| header.report = 1, &format!("report is 1{known} 0"));
    check_scene_refused(anywhere, |header| header.switches = 8, &format!("switches is 8{known} 7"));
    check_scene_refused(section_4, |header| header.task = 3, &format!("task is 3{known} 2"));
    check_scene_refused(
        section_4,
        |header| {
            header.given |= schemas::wire::given::PATH;
            header.path = 7;
        },
        &format!("path is 7{known} 1"),
    );
    let twice = "choices is 2, must be 1 for a single clearance";
    check_scene_refused(section_4, |header| header.choices = 2, twice);
    let none = "channels is 3, must be 0 if none are given";
    check_scene_refused(section_4, |header| header.given &= !schemas::wire::given::CHANNELS, none);
    let none = "solids is 2, must be 0 if none are given";
    check_scene_refused(solids, |header| header.given &= !schemas::wire::given::SOLIDS, none);
    let corners = "body_points is 1, must be 2 for a box";
    check_scene_refused(spatial, |header| header.body_points = 1, corners);
    let planar = "dimension is 3, must be 2 for a footprint";
    check_scene_refused(drive, |header| header.dimension = 3, planar);
    let points = "body_points is 2, must be 1 for a footprint";
    check_scene_refused(drive, |header| header.body_points = 2, points);
    let one = "choices is 1, must be 0 for a curve";
    check_scene_refused(curve, |header| header.choices = 1, one);
    let cells = "channels needs 18446744073709551615 cells, 12 are left";
    check_scene_refused(section_4, |header| header.channels = u64::MAX, cells);
    check_scene_refused(
        section_4,
        |header| header.channels = 2,
        "4 cells follow the end of the message",
    );
}

#[test]
fn the_worst_texts_take_a_hundred_times_their_length() {
    for entry in ["0", "[]", "{}", "\"\"", "\"\\n\"", "{\"\":0}", "{\"x\":0}", "[[]]"] {
        let entries = vec![entry; 100_000].join(",");
        check_text(&format!("[{entries}]"));
        let each = format!("{{\"each\":[{entries}]}}");
        check_text(&examples::SECTION_4.replace("{ \"gap\": 0.2 }", &each));
    }
    let fields: Vec<_> = (0..100_000).map(|number| format!("\"{number}\":0")).collect();
    check_text(&format!("{{{}}}", fields.join(",")));
    check_text(&format!("{{{}}}", vec!["\"id\":0"; 100_000].join(",")));
}

#[test]
fn the_shortest_items_take_little_memory() {
    let header = RequestHeader {
        version: wire::VERSION,
        dimension: 2,
        given: schemas::wire::given::CHANNELS | schemas::wire::given::SOLIDS,
        ..RequestHeader::default()
    };
    let count = 100_000_u64;
    let cells = |cells: &[u64]| cells.repeat(count as usize);
    let exits = RequestHeader { exits: count as u32, wish_kind: 2, ..header };
    check_scene(&exits, &cells(&[0]));
    let safest = RequestHeader { choices: count, wish_kind: 1, ..header };
    check_scene(&safest, &cells(&[2]));
    let no_gaps = RequestHeader { choices: count, wish_kind: 1, ..header };
    check_scene(&no_gaps, &cells(&[1, 0]));
    check_scene(&RequestHeader { choices: 1, ..header }, &[&[1, count], &*cells(&[0, 0])].concat());
    let vertices = RequestHeader { body_points: count, wish_kind: 2, ..header };
    check_scene(&vertices, &cells(&[0, 0]));
    let polygons = RequestHeader { solids: count, wish_kind: 2, ..header };
    check_scene(&polygons, &cells(&[0, 0]));
    let channels = RequestHeader { channels: count, wish_kind: 2, ..header };
    check_scene(&channels, &cells(&[0; 4]));
}

#[test]
fn announced_lists_take_a_mebibyte_at_most() {
    let mut bytes = codec::encode(&examples::of_answer(Ok(examples::assembly())));
    let gaps = bytes.windows(8).position(|bytes| bytes == 4_u64.to_le_bytes()).unwrap();
    bytes[gaps..gaps + 8].copy_from_slice(&(1_u64 << 40).to_le_bytes());
    let (result, taken) = peak(|| codec::decode::<ReplyPart>(&bytes));
    assert!(result.is_err());
    assert!(taken <= (1 << 20) + 4096, "{taken} bytes");
}
