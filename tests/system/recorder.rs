//! The recorder: what it keeps when it is killed, stopped, frozen or too slow.

use integration_tests::{Ended, LONG, Process, Signal, TestDomain, scene, wait_for};
use recording::{ReadError, Summary};
use schemas::message::SceneRequest;

use crate::read::recording;

/// A scene whose reply has one part.
fn small() -> SceneRequest {
    scene("disassemble-channels.json")
}

fn ask(test: &TestDomain, times: usize) {
    let client = test.connect();
    for _ in 0..times {
        assert!(client.call(&small(), LONG).unwrap().answers.is_ok());
    }
}

/// How many replies of a recording that is being written can be read.
fn readable(test: &TestDomain) -> usize {
    recording(&test.path("run.mcap.part")).replies().len()
}

/// Recovers the recording of a recorder that was killed; `replies` are whole.
fn check_recovered(test: &TestDomain, replies: usize) {
    assert!(!test.path("run.mcap").exists(), "it is not finished");
    let checked = test.run("replay", &["check", "run.mcap.part"]);
    assert_eq!(checked.code, Some(3), "{checked:?}");
    assert!(checked.stderr.contains("the recording is cut"), "{checked:?}");
    let recovered = test.run("replay", &["recover", "run.mcap.part", "-o", "whole.mcap"]);
    assert_eq!(recovered.code, Some(0), "{recovered:?}");
    // Also under the name that it was to have, without harm to what is read.
    let left = std::fs::read(test.path("run.mcap.part")).unwrap();
    let under_its_name = ["recover", "run.mcap.part", "-o", "run.mcap", "--overwrite"];
    assert_eq!(test.run("replay", &under_its_name).code, Some(0));
    assert!(std::fs::read(test.path("run.mcap.part")).unwrap() == left);
    assert_eq!(test.run("replay", &["check", "run.mcap"]).code, Some(0));
    let whole = test.run("replay", &["check", "whole.mcap"]);
    let stdout = format!("whole.mcap: {replies} requests, {replies} equal\n");
    assert_eq!(whole, Ended { code: Some(0), stdout, stderr: String::new() });
}

#[test]
fn a_killed_recorder_has_written_what_came_before_the_last_flush() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let recorder = test.recorder("run.mcap", &["--flush", "20ms"]);
    ask(&test, 5);
    wait_for("the flush", || (readable(&test) == 5).then_some(()));
    recorder.kill();
    let left = recording(&test.path("run.mcap.part"));
    assert_eq!(left.records.len(), 15);
    assert!(matches!(left.error, Some(ReadError::Cut { .. })), "{:?}", left.error);
    check_recovered(&test, 5);
}

#[test]
fn a_killed_recorder_loses_what_came_after_the_last_flush() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let recorder = test.recorder("run.mcap", &["--flush", "1h"]);
    ask(&test, 5);
    recorder.kill();
    assert_eq!(readable(&test), 0, "else the other test shows nothing");
}

#[test]
fn a_recorder_killed_under_load_leaves_no_gap() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let recorder = test.recorder("run.mcap", &["--flush", "20ms"]);
    let client = test.connect();
    let mut asked = 0;
    wait_for("ten flushed replies", || {
        for _ in 0..5 {
            client.call(&small(), LONG).unwrap();
            asked += 1;
        }
        (readable(&test) >= 10).then_some(())
    });
    let flushed = readable(&test);
    client.call(&small(), LONG).unwrap();
    recorder.kill();
    let left = recording(&test.path("run.mcap.part"));
    assert!(matches!(left.error, Some(ReadError::Cut { .. })), "{:?}", left.error);
    for (sequence, record) in left.records.iter().enumerate() {
        assert_eq!(record.sequence as usize, sequence);
    }
    let replies = left.replies().len();
    assert!((flushed..=asked + 1).contains(&replies), "{flushed} flushed, {replies} left");
}

fn check_finishes(signal: Signal) {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let recorder = test.recorder("run.mcap", &["--flush", "1h"]);
    ask(&test, 3);
    recorder.signal(signal);
    let ended = recorder.wait();
    assert_eq!(ended.code, Some(0));
    assert_eq!(ended.stdout, "run.mcap: 9 messages recorded, 0 lost\n");
    let file = recording(&test.path("run.mcap"));
    assert_eq!(file.summary, Some(Summary { recorded: 9, lost: 0, gaps: 0, left_out: 0 }));
    assert!(file.error.is_none());
}

#[test]
fn sigint_and_sigterm_finish_the_file() {
    check_finishes(Signal::INT);
    check_finishes(Signal::HUP);
    check_finishes(Signal::TERM);
}

#[test]
fn it_stops_by_itself_when_its_time_is_up() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let ended = test.recorder("run.mcap", &["--for", "50ms"]).wait();
    assert_eq!(ended.stdout, "run.mcap: 0 messages recorded, 0 lost\n");
    assert_eq!(ended.code, Some(0));
}

#[test]
fn an_existing_file_is_not_overwritten() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let path = test.write("run.mcap", "precious");
    let name = test.domain().to_string();
    let refused = test.run("recorder", &["--domain", &name, "-o", "run.mcap"]);
    assert_eq!((refused.code, refused.stdout.as_str()), (Some(1), ""));
    assert!(refused.stderr.contains("run.mcap exists already"), "{refused:?}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "precious");

    let recorder = test.recorder("run.mcap", &["--overwrite"]);
    ask(&test, 1);
    assert_eq!(recorder.stop().code, Some(0));
    assert_eq!(recording(&path).records.len(), 3);
}

#[test]
fn messages_that_a_frozen_recorder_missed_are_counted_and_reported() {
    let test = TestDomain::new();
    test.write("planner.toml", "tap_buffer = 8");
    let _planner = test.planner(&["--config", "planner.toml"]);
    let recorder = test.recorder("run.mcap", &[]);
    ask(&test, 2);
    wait_for("the flush", || (readable(&test) == 2).then_some(()));
    recorder.signal(Signal::STOP);
    ask(&test, 20);
    recorder.signal(Signal::CONT);
    let ended = recorder.stop();

    let file = recording(&test.path("run.mcap"));
    let summary = file.summary.expect("the file is finished");
    assert_eq!(summary.recorded + summary.lost, 66, "{summary:?}");
    assert!(summary.lost > 0 && summary.gaps == 1, "{summary:?}");
    let last = file.records.last().unwrap().sequence;
    assert_eq!(u64::from(last) + 1, 66, "the gap shows in the file where it is");
    assert_eq!(ended.code, Some(3));
    let Summary { recorded, lost, .. } = summary;
    assert_eq!(ended.stdout, format!("run.mcap: {recorded} messages recorded, {lost} lost\n"));
    let checked = test.run("replay", &["check", "run.mcap"]);
    assert_eq!(checked.code, Some(3), "{checked:?}");
    assert!(checked.stderr.contains(&format!("missed {lost} messages")), "{checked:?}");
}

/// A frozen recorder misses the end of one planner and the beginning of the next.
fn check_restart(end: fn(Process)) {
    let test = TestDomain::new();
    test.write("planner.toml", "tap_buffer = 8");
    let planner = test.planner(&["--unsupervised", "--config", "planner.toml"]);
    let recorder = test.recorder("run.mcap", &[]);
    ask(&test, 2);
    wait_for("the flush", || (readable(&test) == 2).then_some(()));
    recorder.signal(Signal::STOP);
    ask(&test, 12);
    end(planner);
    let _planner = test.planner(&["--unsupervised", "--config", "planner.toml"]);
    ask(&test, 11);
    recorder.signal(Signal::CONT);
    let ended = recorder.stop();

    let file = recording(&test.path("run.mcap"));
    let summary = file.summary.expect("the file is finished");
    assert!(summary.lost > 0, "{summary:?}");
    assert_eq!(summary.recorded + summary.lost, 3 * (2 + 12 + 11), "{summary:?}");
    assert_eq!(ended.code, Some(3), "{ended:?}");
}

#[test]
fn what_is_lost_while_the_planner_restarts_is_counted() {
    check_restart(|planner| drop(planner.stop()));
    check_restart(|planner| drop(planner.kill()));
}

#[test]
fn it_says_that_the_planner_is_gone() {
    let test = TestDomain::new();
    let planner = test.planner(&["--unsupervised"]);
    let mut recorder = test.recorder("run.mcap", &[]);
    let leaving = test.recorder("other.mcap", &["--exit-with-planner"]);
    ask(&test, 1);
    planner.kill();
    recorder.wait_until_it_says("the planner is gone");
    let left = leaving.wait();
    assert_eq!(left.stdout, "other.mcap: 3 messages recorded, 0 lost\n");
    assert_eq!(left.code, Some(0));
    let _planner = test.planner(&["--unsupervised"]);
    recorder.wait_until_it_says("a planner is there again");
    ask(&test, 1);
    assert_eq!(recorder.stop().stdout, "run.mcap: 6 messages recorded, 0 lost\n");
}

#[test]
fn it_waits_for_a_planner_to_come_up() {
    let test = TestDomain::new();
    let name = test.domain().to_string();
    let arguments = ["--domain", &name, "-o", "run.mcap", "--wait", "1h"];
    let mut recorder: Process = test.start("recorder", &arguments, None);
    recorder.wait_until_it_says("waiting for a planner");
    let _planner = test.planner(&[]);
    recorder.wait_until_it_says("recording");
    ask(&test, 1);
    assert_eq!(recorder.stop().stdout, "run.mcap: 3 messages recorded, 0 lost\n");
}

#[test]
fn a_signal_ends_its_wait() {
    for signal in [Signal::INT, Signal::TERM] {
        let test = TestDomain::new();
        let name = test.domain().to_string();
        let arguments = ["--domain", &name, "-o", "run.mcap", "--wait", "1h"];
        let mut recorder = test.start("recorder", &arguments, None);
        recorder.wait_until_it_says("waiting for a planner");
        recorder.signal(signal);
        let ended = recorder.wait();
        assert_eq!((ended.code, ended.stdout.as_str()), (Some(1), ""));
        assert!(ended.stderr.contains("no planner runs in domain"), "{ended:?}");
        assert!(!test.path("run.mcap").exists(), "nothing was recorded");
    }
}

#[test]
fn it_says_when_there_is_no_planner() {
    let test = TestDomain::new();
    let name = test.domain().to_string();
    let arguments = ["--domain", &name, "-o", "run.mcap", "--wait", "1ms"];
    let ended = test.run("recorder", &arguments);
    assert_eq!((ended.code, ended.stdout.as_str()), (Some(1), ""));
    assert!(ended.stderr.contains(&format!("no planner runs in domain {name}")), "{ended:?}");
}
