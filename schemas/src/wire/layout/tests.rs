//! What the hash depends on, and the text that is kept in the repository.

use super::table::LAYOUT;
use super::*;

type Change = fn(&mut [Field; 2], &mut [Item; 1]);

/// The hash of a layout of one structure and one payload.
fn small(change: impl FnOnce(&mut [Field; 2], &mut [Item; 1])) -> u64 {
    let field = |name, offset| Field {
        name,
        kind: Kind::U32,
        offset,
        count: 1,
        words: Words::None,
        note: "",
    };
    let mut fields = [field("first", 0), field("second", 4)];
    let mut items = [Item {
        name: "list",
        count: "second",
        form: "f64",
        when: "",
        words: Words::Codes(&["one", "two"]),
        note: "metres",
    }];
    change(&mut fields, &mut items);
    let structure = Structure { name: "Header", note: "", size: 8, fields: &fields };
    let payload = Payload { name: "Body", note: "", items: &items };
    let sections = [Section::Structure(structure), Section::Payload(payload)];
    Layout { version: 1, sections: &sections }.hash()
}

#[test]
fn a_corrected_explanation_keeps_the_hash() {
    let corrected = small(|fields, items| {
        fields[0].note = "a better explanation";
        items[0].note = "meters";
    });
    assert_eq!(corrected, small(|_, _| {}));
}

#[test]
fn whatever_a_peer_depends_on_changes_the_hash() {
    let changes: [Change; 10] = [
        |fields, _| (fields[0].offset, fields[1].offset) = (4, 0),
        |fields, _| fields.swap(0, 1),
        |fields, _| fields[0].name = "third",
        |fields, _| fields[0].kind = Kind::F64,
        |fields, _| fields[0].count = 2,
        |fields, _| fields[0].words = Words::Bits(&[("a", 1)]),
        |_, items| items[0].form = "u64",
        |_, items| items[0].count = "first",
        |_, items| items[0].when = "first is 1",
        |_, items| items[0].words = Words::Codes(&["two", "one"]),
    ];
    let mut hashes: Vec<_> = changes.into_iter().map(small).collect();
    hashes.push(small(|_, _| {}));
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), changes.len() + 1);
}

#[test]
fn the_version_is_part_of_the_hash() {
    let of = |version| Layout { version, sections: LAYOUT.sections }.hash();
    assert_ne!(of(LAYOUT.version), of(LAYOUT.version + 1));
}

#[test]
fn the_text_in_the_repository_is_this_layouts() {
    assert_eq!(include_str!("../layout.txt"), text(), "run `cargo bless`");
}
