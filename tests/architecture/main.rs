//! The rules of the house: who knows whom, and what no file is or holds.

mod clients;
mod code;
mod modules;
mod names;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand};
use integration_tests::root;

static METADATA: LazyLock<Metadata> = LazyLock::new(|| {
    let mut command = MetadataCommand::new();
    command.current_dir(root()).no_deps().exec().expect("cargo describes the workspace")
});

/// Each of our packages, and what it depends on, by name.
fn dependencies(counts: impl Fn(DependencyKind) -> bool) -> BTreeMap<String, BTreeSet<String>> {
    let names = |package: &cargo_metadata::Package| {
        let counted = package.dependencies.iter().filter(|on| counts(on.kind));
        counted.map(|on| ours(&on.name)).collect()
    };
    METADATA.packages.iter().map(|package| (ours(&package.name), names(package))).collect()
}

/// Our packages by the names of their folders.
fn ours(package: &str) -> String {
    package.strip_prefix("clearway-").unwrap_or(package).to_owned()
}

const SERVICES: [&str; 12] = [
    "schemas",
    "planning",
    "answer",
    "configuration",
    "floor-plan",
    "mesh",
    "bus",
    "client",
    "recording",
    "comparison",
    "program",
    "planner",
];
const TOOLS: [&str; 5] = ["plan", "recorder", "render", "replay", "viewing"];

#[test]
fn dependencies_run_one_way() {
    let allowed: BTreeMap<&str, Vec<&str>> = [
        // Strangers to each other and to everybody.
        ("planning", vec![]),
        ("schemas", vec![]),
        ("bus", vec!["schemas"]),
        // What users build on; plans in its example.
        ("client", vec!["bus", "schemas", "answer"]),
        // The same in other languages.
        ("c", vec!["client"]),
        ("python", vec!["client", "floor-plan", "recording", "schemas"]),
        ("recording", vec!["schemas"]),
        ("floor-plan", vec!["schemas"]),
        ("mesh", vec![]),
        ("answer", vec!["planning", "schemas"]),
        ("configuration", vec!["answer"]),
        // How programs end, print and report: knows none of what they do.
        ("program", vec![]),
        ("planner", vec!["answer", "bus", "configuration", "program", "schemas"]),
        // Draws what it is given; plans in its tests.
        ("render", vec!["schemas", "answer"]),
        // Says what it is given in messages of others.
        ("viewing", vec!["schemas", "render"]),
        // Can plan in its own process; reaches the planner by the bus only.
        (
            "plan",
            vec![
                "schemas",
                "answer",
                "configuration",
                "floor-plan",
                "mesh",
                "bus",
                "program",
                "render",
            ],
        ),
        ("recorder", vec!["schemas", "bus", "recording", "program"]),
        // Plans and compares; asks a running planner only if told.
        ("comparison", vec!["schemas", "recording"]),
        (
            "replay",
            vec![
                "schemas",
                "answer",
                "bus",
                "configuration",
                "comparison",
                "recording",
                "render",
                "viewing",
                "program",
            ],
        ),
        // Runs what the other programs run, by their libraries.
        ("demo", [&SERVICES[..], &TOOLS].concat()),
        // All programs in one.
        ("command", vec!["demo", "plan", "planner", "program", "recorder", "replay"]),
        // Makes what the others' tests compare with.
        ("bless", [&SERVICES[..], &TOOLS, &["fuzz-targets", "integration-tests"]].concat()),
        // Reads what others wrote, by the libraries that read it.
        ("fuzz-targets", vec!["schemas", "answer", "recording", "floor-plan", "mesh"]),
        // Tests know everything.
        ("schema-tests", vec!["answer", "comparison", "schemas"]),
        ("peers", vec!["answer", "floor-plan", "schemas"]),
        ("integration-tests", [&SERVICES[..], &TOOLS, &["demo"]].concat()),
        ("soak", vec!["schemas", "answer", "bus", "program", "integration-tests"]),
        // What users do with their recordings.
        ("recordings-as-tests", vec!["schemas", "answer", "comparison", "configuration"]),
    ]
    .into();
    let depends = dependencies(|_| true);
    let ours: BTreeSet<_> = depends.keys().map(String::as_str).collect();
    assert_eq!(ours, allowed.keys().copied().collect(), "a package has no rule, or a rule none");
    for (package, on) in &depends {
        let known: Vec<_> = on.iter().filter(|on| ours.contains(on.as_str())).collect();
        for on in known {
            assert!(allowed[package.as_str()].contains(&on.as_str()), "{package} knows {on}");
        }
    }
}

#[test]
fn planning_is_pure() {
    let on = &dependencies(|kind| kind == DependencyKind::Normal)["planning"];
    let expected = ["libm", "nalgebra", "robust", "spade", "thiserror"].map(str::to_owned);
    assert_eq!(*on, BTreeSet::from(expected), "no clock, no I/O, no threads, no logging, no serde");
}

/// Only these packages depend on one whose name begins so.
#[track_caller]
fn check_owners(owners: &[&str], prefix: &str) {
    for (package, on) in dependencies(|_| true) {
        let found = on.iter().find(|on| *on == prefix || on.starts_with(&format!("{prefix}-")));
        assert_eq!(found.is_some(), owners.contains(&package.as_str()), "{package} and {prefix}");
    }
}

#[test]
fn each_foreign_format_has_one_owner() {
    // The round trip is measured beside that of the bare bus.
    check_owners(&["bus", "integration-tests"], "iceoryx2");
    check_owners(&["recording"], "mcap");
    check_owners(&["schemas"], "bincode");
    check_owners(&["floor-plan"], "image");
    check_owners(&["viewing"], "foxglove");
}

/// Our source files and their text, this package's own included.
fn sources() -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    for package in &METADATA.packages {
        let directory = package.manifest_path.parent().expect("manifests lie in directories");
        find_sources(directory.as_std_path(), &mut files);
    }
    assert!(files.len() > 50, "there are more files than these {}", files.len());
    files
}

fn find_sources(directory: &Path, files: &mut Vec<(PathBuf, String)>) {
    for entry in fs::read_dir(directory).expect("the directory can be read") {
        let path = entry.expect("the directory can be read").path();
        if path.is_dir() && path.file_name().is_some_and(|name| name != "target") {
            find_sources(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).expect("sources are UTF-8");
            files.push((path.strip_prefix(root()).expect("it lies here").to_owned(), text));
        }
    }
}

/// Lines of code, each with its number; comments are left out.
fn code(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().map(str::trim_start).enumerate();
    lines.filter(|(_, line)| !line.starts_with("//")).map(|(index, line)| (index + 1, line))
}

/// The files whose code names a crate.
fn naming(name: &str) -> Vec<PathBuf> {
    let path = format!("{name}::");
    let names = |text: &str| code(text).any(|(_, line)| line.contains(&path));
    sources().into_iter().filter(|(_, text)| names(text)).map(|(path, _)| path).collect()
}

#[test]
fn foreign_formats_are_named_where_they_belong() {
    assert_eq!(naming("bincode"), [Path::new("schemas/src/codec.rs")]);
    // What is compared with it, and who does what our ports would not.
    let bare = ["tests/benches/bare.rs", "tests/support/raw.rs", "tests/support/raw/planner.rs"]
        .map(Path::new);
    for path in naming("iceoryx2") {
        let is_bare = bare.contains(&path.as_path());
        assert!(path.starts_with("services/bus") || is_bare, "{} names it", path.display());
    }
}

#[test]
fn planning_is_the_same_everywhere() {
    for (path, text) in sources() {
        // Tests may.
        let test = path.to_string_lossy().contains("tests");
        if !path.starts_with("services/planning/src") || test {
            continue;
        }
        for (number, line) in code(&text) {
            for word in [
                "std::time",
                "std::fs",
                "std::io",
                "std::thread",
                "HashMap",
                "HashSet",
                "unsafe",
                "mul_add",
                // The system's mathematics, also within nalgebra: libm's is pinned.
                ".sin()",
                ".cos()",
                ".tan()",
                ".sin_cos()",
                ".asin()",
                ".acos()",
                ".atan()",
                ".atan2(",
                ".hypot(",
                ".cbrt()",
                ".exp()",
                ".ln()",
                ".powf(",
                ".angle(",
            ] {
                assert!(!line.contains(word), "{}:{number} names {word}: {line}", path.display());
            }
        }
    }
}

#[test]
fn libraries_print_nothing() {
    for (path, text) in sources() {
        let library = path.starts_with("schemas") || path.starts_with("services");
        let places = ["tests", "benches", "examples", "tests.rs", "main.rs", "build.rs"];
        let may_print = path.iter().any(|part| places.iter().any(|place| part == *place));
        if !library || may_print {
            continue;
        }
        for (number, line) in code(&text) {
            let prints = line.contains("print!(") || line.contains("println!(");
            assert!(!prints, "{}:{number}: {line}", path.display());
        }
    }
}

#[test]
fn files_are_short_and_named_for_what_they_hold() {
    for (path, text) in sources() {
        let lines = text.lines().count();
        assert!(lines < 600, "{} has {lines} lines, at most 599 are allowed", path.display());
        let name = path.file_name().unwrap().to_string_lossy();
        let vague = ["mod.rs", "util.rs", "utils.rs", "helper.rs", "helpers.rs", "common.rs"];
        assert!(!vague.contains(&&*name), "{} says nothing by its name", path.display());
        for (number, line) in code(&text) {
            let vague = ["mod util", "mod helper", "mod common"]
                .iter()
                .any(|word| line.strip_prefix("pub ").unwrap_or(line).starts_with(word));
            assert!(!vague, "{}:{number}: {line}", path.display());
        }
    }
}

#[test]
fn lints_are_expected_with_a_reason_and_never_allowed() {
    for (path, text) in sources() {
        for (number, line) in code(&text) {
            let place = format!("{}:{number}: {line}", path.display());
            assert!(!line.starts_with(concat!("#[al", "low(")), "{place}");
            assert!(!line.starts_with(concat!("#![al", "low(")), "{place}");
            if line.starts_with("#[expect(") || line.starts_with("#![expect(") {
                let attribute: String = text.lines().skip(number - 1).take(6).collect();
                let attribute = attribute.split(")]").next().unwrap_or_default();
                assert!(attribute.contains("reason ="), "{place}");
            }
        }
    }
}
