//! The whole path once, and the pictures that came of it.

use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};

use integration_tests::{Signal, TestDomain, kill_group, kill_process, program, wait_for};

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
    assert!(again.stderr.contains("already contains a demo"), "{}", again.stderr);
}

#[test]
fn a_signal_ends_a_demo_and_its_processes() {
    for moment in ["out", "out/demo.mcap.part"] {
        // Ctrl-C reaches planner and recorder too, a service manager's SIGTERM the demo alone.
        assert_eq!(interrupted(moment, Signal::INT, kill_group), Some(130), "{moment}");
        assert_eq!(interrupted(moment, Signal::TERM, kill_process), Some(143), "{moment}");
    }
}

/// The exit code of a demo that gets a signal once a file or folder is there.
fn interrupted(moment: &str, signal: Signal, send: fn(&Child, Signal)) -> Option<i32> {
    const TRIES: usize = 10;
    for _ in 0..TRIES {
        let test = TestDomain::new();
        let mut demo = Command::new(program("demo"))
            .args(["-o", "out"])
            .current_dir(test.path(""))
            .env(bus::ROOT_VARIABLE, test.root())
            .stdout(Stdio::null())
            .process_group(0)
            .spawn()
            .unwrap();
        wait_for(moment, || test.path(moment).exists().then_some(()));
        send(&demo, signal);
        let code = demo.wait().unwrap().code();
        assert!(test.left().is_empty(), "{:?}", test.left());
        // A demo may be done before the signal comes.
        if code != Some(0) {
            return code;
        }
    }
    panic!("{TRIES} demos were done before the signal came");
}
