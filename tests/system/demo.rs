//! The whole path once, and the pictures that came of it.

use std::fs;

use integration_tests::{TestDomain, root};

#[test]
fn two_demos_run_at_once() {
    let test = TestDomain::new();
    let demos = ["one", "two"].map(|folder| test.start("demo", &["-o", folder], None));
    for (demo, folder) in demos.into_iter().zip(["one", "two"]) {
        let ended = demo.wait();
        assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
        // Section 4 both ways at three gaps, two corridors at four.
        for (task, gaps) in [("disassemble", 3), ("assemble", 3), ("drive A", 4), ("drive B", 4)] {
            let rows = ended
                .stdout
                .lines()
                .filter(|line| line.trim_start().starts_with(&format!("{task}  ")));
            assert_eq!(rows.count(), gaps, "{}", ended.stdout);
        }
        assert!(ended.stdout.contains("154 requests, 154 equal"), "{}", ended.stdout);
        for file in ["demo.mcap", "disassemble.svg", "assemble.svg", "drive-a.svg", "drive-b.svg"] {
            assert!(test.path(folder).join(file).exists(), "{folder} has no {file}");
        }
    }
    // What is there is not written over.
    let again = test.run("demo", &["-o", "one"]);
    assert_eq!(again.code, Some(1));
    assert!(again.stderr.contains("holds a demo already"), "{}", again.stderr);
}

#[test]
fn the_documents_show_what_is_drawn_today() {
    let test = TestDomain::new();
    for name in ["disassemble", "drive-a", "drive-b"] {
        let scene = root().join(format!("recordings/scenes/{name}.json"));
        let picture = format!("{name}.svg");
        let arguments = ["--local", scene.to_str().unwrap(), "--svg", &picture];
        assert_eq!(test.run("plan", &arguments).code, Some(0));
        let drawn = fs::read_to_string(test.path(&picture)).unwrap();
        let shown = fs::read_to_string(root().join("docs").join(&picture)).unwrap();
        assert!(drawn == shown, "docs/{picture} is out of date: draw it anew with plan --svg");
    }
}
