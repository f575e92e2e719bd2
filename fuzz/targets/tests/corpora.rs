//! Each target on its corpus and on some mutations of it.

use std::fs;
use std::path::Path;

use clearway_fuzz_targets::{Failure, TARGETS, run, search};

/// The mutations of each target: the same ones on every run.
const MUTATIONS: u64 = 500;

#[track_caller]
fn check(name: &str) {
    let target = TARGETS.into_iter().find(|target| target.name == name).expect(name);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(target.corpus());
    let mut paths: Vec<_> =
        fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty(), "{} is empty", folder.display());
    let mut corpus = Vec::new();
    for path in paths {
        let input = fs::read(&path).unwrap();
        if let Err(failure) = run(&target, &input) {
            panic!("{}: {failure:?}", path.display());
        }
        corpus.push(input);
    }
    if let Err(failure) = search(&target, &corpus, MUTATIONS, 1) {
        panic!("{failure:?}\nthe input is in {}", saved(name, &failure));
    }
}

/// The file that holds the input.
fn saved(name: &str, failure: &Failure) -> String {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz-{name}"));
    fs::write(&path, &failure.input).unwrap();
    path.display().to_string()
}

#[test]
fn requests_in_memory_are_answered() {
    check("border");
}

#[test]
fn floor_plans_are_read_or_refused() {
    check("floor_plan");
}

#[test]
fn meshes_are_read_or_refused() {
    check("mesh");
}

#[test]
fn recorded_messages_are_decoded_or_refused() {
    check("message");
}

#[test]
fn recordings_are_read_and_recovered() {
    check("recording");
}

#[test]
fn parts_of_replies_are_read_or_refused() {
    check("reply");
}

#[test]
fn scenes_are_answered() {
    check("scene");
}

#[test]
fn every_target_is_tested_and_built_by_cargo_fuzz() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let manifest = fs::read_to_string(here.join("../Cargo.toml")).unwrap();
    let this = include_str!("corpora.rs");
    for target in TARGETS {
        assert!(
            this.contains(&format!("check(\"{}\")", target.name)),
            "{} has no test",
            target.name
        );
        let bin = format!("name = \"{}\"", target.name);
        assert!(manifest.contains(&bin), "fuzz/Cargo.toml has no program {}", target.name);
        assert!(here.join(format!("../fuzz_targets/{}.rs", target.name)).exists());
    }
}
