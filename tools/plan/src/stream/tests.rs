use proptest::prelude::*;

use super::*;

fn read(text: &[u8], most: usize) -> Vec<(SceneText, Option<RangeInclusive<u64>>)> {
    let mut scenes = Scenes::new(text, most);
    let mut found = Vec::new();
    while let Some(scene) = scenes.next().unwrap() {
        let skipped = scenes.skipped();
        found.push((scene, skipped));
    }
    found
}

/// The texts of the scenes that are JSON, and what is wrong with the others.
fn texts(text: &str) -> Vec<String> {
    let told = |(scene, _): (SceneText, _)| match scene.fault {
        None => scene.text,
        Some(fault) => fault.to_string(),
    };
    read(text.as_bytes(), MOST_BYTES).into_iter().map(told).collect()
}

#[track_caller]
fn check(text: &str, expected: &[&str]) {
    assert_eq!(texts(text), expected, "{text:?}");
}

#[test]
fn lines_objects_and_pretty_objects_are_scenes() {
    check("", &[]);
    check(" \r\n\t\n", &[]);
    check("{\"a\":1}\n\n{\"b\":2}\n", &["{\"a\":1}", "{\"b\":2}"]);
    check("{}{} {}", &["{}", "{}", "{}"]);
    check("{\n  \"a\": [\n    1\n  ]\n}\n{\n}", &["{\n  \"a\": [\n    1\n  ]\n}", "{\n}"]);
    check("[7]\n7\n\"{\"", &["[7]", "7", "\"{\""]);
    check(r#"{"a":"}\"{"}{}"#, &[r#"{"a":"}\"{"}"#, "{}"]);
}

#[test]
fn a_scene_knows_its_line() {
    let lines: Vec<_> =
        read(b"{}\n\n{\n\n}\n{}", 100).iter().map(|(scene, _)| scene.line).collect();
    assert_eq!(lines, [1, 3, 6]);
}

#[test]
fn faults_are_placed_in_the_stream() {
    let word = "invalid JSON at line 1, column 11: key must be a string";
    check("{\"id\": 7, nonsense\n{}", &[word, "{}"]);
    check(
        "{}\n  {\"a\":\n 1,,}",
        &["{}", "invalid JSON at line 3, column 4: key must be a string"],
    );
    check("nonsense\n{}", &["invalid JSON at line 1, column 2: expected ident", "{}"]);
    check("{\"a\":1e999}\n{}", &["invalid JSON at line 1, column 11: number out of range", "{}"]);
    check("{} nonsense", &["{}", "invalid JSON at line 1, column 5: expected ident"]);
    check("}\n{}", &["invalid JSON at line 1, column 1: expected value", "{}"]);
}

#[test]
fn a_line_that_is_cut_off_does_not_swallow_the_next() {
    let found = texts("{\"id\": 1, \"task\":\n{\"id\": 2}\n{\"id\": 3}\n");
    assert_eq!(found[0], "invalid JSON at line 3, column 1: expected `,` or `}`");
    assert_eq!(found[1..], ["{\"id\": 2}", "{\"id\": 3}"]);
    let found = texts("{\"id\": 1,\n");
    assert_eq!(found, ["invalid JSON at line 2, column 1: EOF while parsing a value"]);
    let found = texts("[\n{\"id\": 1}\n");
    assert_eq!(found.len(), 2);
    assert_eq!(found[1], "{\"id\": 1}");
}

#[test]
fn the_rest_of_a_broken_pretty_object_is_skipped() {
    let text = b"{\n  \"id\": 1,,\n  \"task\": \"drive\"\n}\n\n{\n  \"id\": 2\n}\n";
    let found = read(text, 100);
    assert_eq!(found.len(), 2);
    assert_eq!(found[0].0.fault.as_ref().unwrap().line, 2);
    assert_eq!(found[1].0, SceneText { line: 6, text: "{\n  \"id\": 2\n}".into(), fault: None });
    assert_eq!(found[1].1, Some(3..=4));
}

#[test]
fn what_is_too_long_is_refused_and_the_next_is_read() {
    let text = "{\"a\":\"aaaaaaaaaaaaaaaaaaaaaaaaa\"}\n{}\n";
    let found = read(text.as_bytes(), 10);
    assert_eq!(
        found[0].0.fault.as_ref().unwrap().what,
        "longer than 10 bytes, the most for one scene"
    );
    assert!(found[0].0.text.len() <= 11);
    assert_eq!(found[1].0.text, "{}");
    assert_eq!(found.len(), 2);
}

#[test]
fn bytes_that_are_not_text_are_refused() {
    let found = read(b"{\"a\":\"\xff\"}\n\xfe\n{}", 100);
    let faults: Vec<_> = found.iter().map(|(scene, _)| scene.fault.is_some()).collect();
    assert_eq!(faults, [true, true, false]);
}

#[test]
fn a_byte_order_mark_is_left_to_the_reader_of_scenes() {
    let found = read("\u{feff}{}\n{}".as_bytes(), 100);
    assert_eq!(found[0].0, SceneText { line: 1, text: "\u{feff}{}".into(), fault: None });
    assert_eq!(found[1].0.text, "{}");
}

/// Fails when more is read than it holds.
struct Reluctant<'a>(&'a [u8]);

impl Read for Reluctant<'_> {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        panic!("it is buffered")
    }
}

impl BufRead for Reluctant<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        assert!(!self.0.is_empty(), "the scene is complete");
        Ok(self.0)
    }

    fn consume(&mut self, amount: usize) {
        self.0 = &self.0[amount..];
    }
}

#[test]
fn nothing_is_read_beyond_the_last_bracket_or_the_first_fault() {
    let mut scenes = Scenes::new(Reluctant(b"{\"a\": [\n1]\n}"), 100);
    assert_eq!(scenes.next().unwrap().unwrap().text, "{\"a\": [\n1]\n}");
    for broken in ["{\"a\": nonsense", "{\"a\":[{\"b\":\"c\n", "[[{,", "{\"a\":tru\n", "[1 2"] {
        let mut scenes = Scenes::new(Reluctant(broken.as_bytes()), 100);
        assert!(scenes.next().unwrap().unwrap().fault.is_some(), "{broken:?}");
    }
}

#[test]
fn failures_to_read_are_passed_on() {
    struct Failing;
    impl Read for Failing {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other("unplugged"))
        }
    }
    let text = b"{} {\"a\"".chain(io::BufReader::new(Failing));
    let mut scenes = Scenes::new(text, 100);
    assert_eq!(scenes.next().unwrap().unwrap().text, "{}");
    assert_eq!(scenes.next().unwrap_err().to_string(), "unplugged");
}

proptest! {
    /// Whatever comes: it ends, and JSON Lines give a scene for each line.
    #[test]
    fn anything_ends(bytes in prop::collection::vec(prop::sample::select(
        b"{}[]\",:\\ \n\t1ae\xff".to_vec()), 0..200)) {
        let found = read(&bytes, 50);
        let lines = bytes.split(|byte| *byte == b'\n').count();
        prop_assert!(found.len() <= bytes.len().max(lines));
    }

    #[test]
    fn broken_lines_between_whole_ones_lose_none(broken in prop::collection::vec(
        prop::sample::select(vec!["{", "{\"a\":", "nonsense", "[1,", "{\"a\":\"", "{\"a\" 1}"]), 0..8)) {
        let text: String = broken.iter().map(|line| format!("{line}\n{{\"good\":1}}\n")).collect();
        let found = texts(&text);
        let good = found.iter().filter(|text| *text == "{\"good\":1}").count();
        prop_assert_eq!(good, broken.len(), "{:?}", found);
    }
}
