//! Names are the interface's: they stand in its document, once each.

use std::collections::BTreeSet;

use schemas::message::{Axis, CurveKind, Direction, ErrorCode, Report, Rung, StartTurn, Task};

const INTERFACE: &str = include_str!("../../../docs/interface.md");

/// All names of a type; each leads back to its value.
macro_rules! names {
    ($Type:ident) => {{
        let names = $Type::ALL.iter().map(|value| {
            assert_eq!($Type::from_name(value.name()), Some(*value));
            assert_eq!(value.to_string(), value.name());
            value.name()
        });
        let names: Vec<&'static str> = names.collect();
        assert_eq!($Type::from_name("Internal"), None);
        assert_eq!($Type::from_name(""), None);
        names
    }};
}

#[test]
fn names_are_snake_case_and_in_the_interface() {
    let types = [
        names!(ErrorCode),
        names!(Task),
        names!(StartTurn),
        names!(CurveKind),
        names!(Axis),
        names!(Report),
        names!(Rung),
    ];
    for names in types {
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "{names:?}");
        for name in names {
            let is_snake = name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_');
            assert!(is_snake, "{name}");
            let quoted = [format!("`{name}`"), format!("\"{name}\"")];
            assert!(quoted.iter().any(|name| INTERFACE.contains(name)), "{name}");
        }
    }
    for name in names!(Direction) {
        assert!(INTERFACE.contains(&format!("\"{name}\"")), "{name}");
    }
}
