//! What the programs say, where they say it, and how they exit.

use std::process::{Command, Stdio};

use configuration::Config;
use integration_tests::{Ended, TestDomain, program, root};

fn scene_path(name: &str) -> String {
    root().join("recordings/scenes").join(name).to_str().unwrap().to_owned()
}

/// `plan --local` with these arguments.
fn plan(test: &TestDomain, arguments: &[&str]) -> Ended {
    test.run("plan", &[&["--local"], arguments].concat())
}

#[test]
fn help_names_the_exit_codes() {
    let test = TestDomain::new();
    for (name, codes) in [
        ("planner", &["0 ended by a signal", "1 failure", "2 usage"][..]),
        ("plan", &["0 every scene has a trajectory", "1 a scene was refused", "2 usage"]),
        ("recorder", &["0 done", "1 failure", "2 usage", "3 messages were lost"]),
        ("replay", &["0  done", "1  failure", "2  usage", "3  data was lost", "4  regression"]),
    ] {
        let help = test.run(name, &["--help"]);
        assert_eq!((help.code, help.stderr.as_str()), (Some(0), ""), "{name}");
        // Lines are wrapped to the terminal's width.
        let text = help.stdout.replace('\n', " ");
        assert!(text.contains("Exit codes:"), "{name}: {text}");
        assert!(codes.iter().all(|code| text.contains(code)), "{name}: {text}");
        let version = test.run(name, &["--version"]);
        let begins = format!("{name} {}", env!("CARGO_PKG_VERSION"));
        assert!(version.stdout.starts_with(&begins), "{version:?}");
    }
}

#[test]
fn help_of_the_planner_lists_all_settings_with_their_defaults() {
    let test = TestDomain::new();
    let help = test.run("planner", &["--help"]).stdout;
    let (_, listed) = help.split_once("with their defaults:\n").unwrap();
    let (listed, _) = listed.split_once("\n\n").unwrap();
    let read = Config::read(&test.write("planner.toml", listed)).unwrap();
    assert_eq!(read, Config::default());
    let debug = format!("{:?}", Config::default());
    let settings = debug.matches(": ").count() - 1;
    assert_eq!(listed.matches(" = ").count(), settings, "one is missing: {listed}");
}

#[test]
fn wrong_arguments_are_usage_errors() {
    let test = TestDomain::new();
    for (name, arguments) in [
        ("planner", &["--colour"][..]),
        ("planner", &["--domain", "../up"]),
        ("planner", &["scene.json"]),
        ("plan", &[]),
        ("plan", &["scene.json", "--format", "xml"]),
        ("plan", &["scene.json", "--timeout", "10"]),
        ("plan", &["scene.json", "--domain", ""]),
        ("plan", &["scene.json", "--config", "planner.toml"]),
        ("plan", &["scene.json", "--local", "--timeout", "10s"]),
        ("recorder", &[]),
        ("recorder", &["-o", "run.mcap", "--flush", "soon"]),
        ("replay", &[]),
        ("replay", &["rewind"]),
        ("replay", &["recover", "run.mcap"]),
    ] {
        let ended = test.run(name, arguments);
        assert_eq!((ended.code, ended.stdout.as_str()), (Some(2), ""), "{name} {arguments:?}");
        assert!(ended.stderr.contains("--help"), "{name} {arguments:?}: {}", ended.stderr);
    }
}

#[test]
fn without_a_planner_plan_says_what_to_do() {
    let test = TestDomain::new();
    let ended = test.plan(&[&scene_path("disassemble.json")]);
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(1), ""));
    let (name, root) = (test.domain(), test.root());
    let said = format!(
        "plan: no planner runs in domain {name} under {} (start one with `planner --domain {name}`)",
        root.display()
    );
    assert!(ended.stderr.starts_with(&said), "{}", ended.stderr);
}

#[test]
fn files_that_cannot_be_read_are_failures() {
    let test = TestDomain::new();
    let ended = plan(&test, &["nowhere.json"]);
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(1), ""));
    assert!(ended.stderr.contains("can't read nowhere.json: No such file"), "{}", ended.stderr);
    std::fs::write(test.path("binary.json"), [0xff, 0xfe]).unwrap();
    let ended = plan(&test, &["binary.json"]);
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(1), ""));
    assert!(ended.stderr.contains("can't read binary.json"), "{}", ended.stderr);
}

#[test]
fn text_has_a_row_for_each_answer_and_the_legs_of_one() {
    let test = TestDomain::new();
    let ended = plan(&test, &[&scene_path("disassemble.json")]);
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
    for said in ["(id 7): disassemble", "6.919200 m", "7.403234 m", "8.509942 m", "0.255/0.505"] {
        assert!(ended.stdout.contains(said), "{}", ended.stdout);
    }
    let ended = plan(&test, &[&scene_path("disassemble-channels.json")]);
    for said in ["table 1, rule 1, junction 0", "table 1, rule 3, junction 1", "(-0.300, 1.190)"] {
        assert!(ended.stdout.contains(said), "{}", ended.stdout);
    }
    test.write("bad.json", "{}");
    let ended = plan(&test, &["bad.json"]);
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(1), ""));
    assert!(ended.stdout.contains("refused, invalid_scene: task is missing"), "{ended:?}");
}

#[test]
fn a_reader_that_stops_early_is_no_failure() {
    let test = TestDomain::new();
    // More than a pipe holds, so that writing fails.
    let scene = scene_path("disassemble.json");
    let scenes = vec![scene.as_str(); 20];
    for format in ["text", "json", "csv"] {
        let mut plan = Command::new(program("plan"))
            .args(["--local", "--format", format])
            .args(&scenes)
            .current_dir(test.path(""))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(plan.stdout.take());
        let ended = plan.wait_with_output().unwrap();
        assert_eq!(String::from_utf8_lossy(&ended.stderr), "", "{format}");
        assert_eq!(ended.status.code(), Some(0), "{format}");
    }
}
