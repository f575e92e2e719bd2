//! The recorder's files: guarded while they are written, split, compressed, described.

use std::path::PathBuf;

use integration_tests::{LONG, Process, Signal, TestDomain, program, scene, wait_for};
use recording::Reader;
use schemas::message::SceneRequest;
use serde_json::Value;

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

/// Asks from several clients at once.
fn ask_at_once(test: &TestDomain, clients: usize, times: usize) {
    std::thread::scope(|scope| {
        for _ in 0..clients {
            scope.spawn(|| ask(test, times));
        }
    });
}

/// The recordings there that are finished, in order.
fn finished(test: &TestDomain) -> Vec<PathBuf> {
    let folder = test.path("");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_finished = |path: &PathBuf| path.extension().is_some_and(|end| end == "mcap");
    let mut files: Vec<_> = entries.filter(is_finished).collect();
    files.sort();
    files
}

fn info(test: &TestDomain, file: &str) -> Value {
    let said = test.run("replay", &["info", file, "--format", "json"]);
    serde_json::from_str(&said.stdout).unwrap_or_else(|error| panic!("{said:?}: {error}"))
}

#[track_caller]
fn check_fails(recorder: Process, says: &str) {
    let ended = recorder.wait();
    assert_eq!(ended.code, Some(1), "{ended:?}");
    assert!(ended.stderr.contains(says), "{ended:?}");
    assert_eq!(ended.stdout, "", "nothing was recorded");
}

#[test]
fn no_two_recorders_write_one_file() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let first = test.recorder("run.mcap", &[]);
    let name = test.domain().to_string();
    for arguments in [&["--overwrite"][..], &[]] {
        let arguments = [&["--domain", &name, "-o", "run.mcap"], arguments].concat();
        check_fails(test.start("recorder", &arguments, None), "another program is recording to");
    }
    ask(&test, 1);
    assert_eq!(first.stop().stdout, "run.mcap: 3 messages recorded, 0 lost\n");
    assert_eq!(test.run("replay", &["check", "run.mcap"]).code, Some(0));
}

#[test]
fn what_a_killed_recorder_left_is_not_overwritten_unasked() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    test.recorder("run.mcap", &[]).kill();
    let name = test.domain().to_string();
    let arguments = ["--domain", &name, "-o", "run.mcap"];
    let says = "run.mcap.part is left of a recording that was not finished";
    check_fails(test.start("recorder", &arguments, None), says);
    assert_eq!(test.recorder("run.mcap", &["--overwrite"]).stop().code, Some(0));
    assert!(!test.path("run.mcap.part").exists());
}

#[test]
fn a_file_that_is_taken_away_is_noticed() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    std::fs::create_dir(test.path("there")).unwrap();
    let begin = || test.recorder("there/run.mcap", &["--flush", "10ms"]);
    let part = test.path("there/run.mcap.part");

    let recorder = begin();
    std::fs::remove_dir_all(test.path("there")).unwrap();
    ask(&test, 1);
    check_fails(recorder, "the file was removed, moved or replaced while it was being written");
    std::fs::create_dir(test.path("there")).unwrap();

    let recorder = begin();
    std::fs::rename(&part, test.path("there/moved")).unwrap();
    ask(&test, 1);
    check_fails(recorder, "the file was removed, moved or replaced");

    let recorder = begin();
    let file = std::fs::OpenOptions::new().write(true).open(&part).unwrap();
    file.set_len(100).unwrap();
    ask(&test, 1);
    check_fails(recorder, "bytes were written, but the file has");
    assert!(!test.path("there/run.mcap").exists());
}

/// On a small file system of its own, which takes the right to mount one.
#[test]
fn a_full_disk_leaves_a_recording_or_nothing() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let shell = ["unshare", "-m", "sh", "-c"];
    std::fs::create_dir(test.path("disk")).unwrap();
    let mount = "mount -t tmpfs -o size=SIZE none disk";
    if test.shell(&shell, &mount.replace("SIZE", "4k")).wait().code != Some(0) {
        println!("SKIPPED: no file system can be mounted here");
        return;
    }
    let (recorder, replay, name) = (program("recorder"), program("replay"), test.domain());
    let script = |size: &str| {
        let (recorder, replay) = (recorder.display(), replay.display());
        format!(
            "{mount} && {recorder} --domain {name} --flush 10ms --chunk-size 16KiB -o disk/run.mcap; echo code $?
             echo left $(ls disk); {replay} recover disk/run.mcap.part -o whole.mcap; echo code $?",
            mount = mount.replace("SIZE", size),
        )
    };
    // No room for a beginning: nothing is left.
    let ended = test.shell(&shell, &script("4k")).wait();
    assert!(ended.stderr.contains("No space left on device"), "{ended:?}");
    assert!(ended.stdout.starts_with("code 1\nleft\n"), "{ended:?}");
    // Full later: what was flushed is left.
    let mut recorder = test.shell(&shell, &script("1m"));
    recorder.wait_until_it_says("recording");
    let client = test.connect();
    wait_for("the disk to be full", || {
        client.call(&small(), LONG).unwrap();
        recorder.has_ended().then_some(())
    });
    let ended = recorder.wait();
    assert!(ended.stderr.contains("No space left on device"), "{ended:?}");
    assert!(ended.stdout.starts_with("code 1\nleft run.mcap.part\n"), "{ended:?}");
    assert!(recording(&test.path("whole.mcap")).records.len() > 10, "{ended:?}");
}

#[test]
fn nothing_is_lost_between_the_files_of_a_split_recording() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let arguments = ["--split-size", "200kB", "--compression", "lz4", "--chunk-size", "16KiB"];
    let recorder = test.recorder("run.mcap", &arguments);
    ask_at_once(&test, 3, 60);
    let ended = recorder.stop();
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let files = finished(&test);
    assert!(files.len() > 3, "{files:?}");
    let said = format!("run.mcap: 540 messages recorded, 0 lost, in {} files\n", files.len());
    assert_eq!(ended.stdout, said);
    let mut next = 0;
    for path in &files {
        let file = recording(path);
        assert!(file.error.is_none(), "{:?}", file.error);
        for record in file.records {
            assert_eq!(record.sequence, next);
            next += 1;
        }
    }
    assert_eq!(next, 540);
    let names: Vec<_> = files.iter().map(|path| path.to_str().unwrap()).collect();
    let checked = test.run("replay", &[&["check", "--strict"], &names[..]].concat());
    assert!(checked.stdout.ends_with("more: 180 requests, 180 equal\n"), "{checked:?}");
    assert_eq!(checked.code, Some(0), "{checked:?}");
    // One missing in the middle shows.
    let missing = [&["check"], &names[..1], &names[2..]].concat();
    assert_eq!(test.run("replay", &missing).code, Some(3));
}

#[test]
fn each_file_has_the_free_spaces_that_its_requests_name() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let arguments = ["--split-duration", "200ms", "--max-files", "2", "--flush", "10ms"];
    let recorder = test.recorder("run.mcap", &arguments);
    let snapshots = test.recorder("late.mcap", &["--snapshot", "100ms", "--flush", "10ms"]);
    let mut upload = scene("disassemble-channels.json");
    let digest = upload.free_space.digest();
    upload.free_space.named = Some(digest);
    let mut named = upload.clone();
    named.free_space = schemas::message::FreeSpace { named: Some(digest), ..Default::default() };
    let client = test.connect();
    assert!(client.call(&upload, LONG).unwrap().answers.is_ok());
    std::thread::sleep(std::time::Duration::from_millis(200));
    wait_for("the third file", || {
        assert!(client.call(&named, LONG).unwrap().answers.is_ok());
        test.path("run-0003.mcap.part").exists().then_some(())
    });
    snapshots.signal(Signal::USR1);
    wait_for("the snapshot", || test.path("late-0000.mcap").exists().then_some(()));
    recorder.stop();
    snapshots.stop();
    let mut compared = 0;
    for path in finished(&test) {
        let checked = test.run("replay", &["check", path.to_str().unwrap()]);
        // A file can begin or end within an exchange; what is there is as it was planned.
        assert!(matches!(checked.code, Some(0 | 3)), "{checked:?}");
        compared += usize::from(checked.stdout.contains(" equal"));
    }
    assert!(compared > 0, "no file has a whole exchange");
}

#[test]
fn the_oldest_files_are_removed() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let arguments = ["--split-duration", "50ms", "--max-files", "2", "--flush", "10ms"];
    let recorder = test.recorder("run.mcap", &arguments);
    let client = test.connect();
    wait_for("the fifth file", || {
        client.call(&small(), LONG).unwrap();
        test.path("run-0004.mcap.part").exists().then_some(())
    });
    let ended = recorder.stop();
    assert!(ended.stdout.contains("were removed"), "{ended:?}");
    assert_eq!(finished(&test).len(), 2);
    assert!(!test.path("run-0000.mcap").exists());
}

#[test]
fn it_records_as_much_as_it_is_told() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let recorder = test.recorder("run.mcap", &["--max-messages", "7"]);
    let replies = test.recorder("replies.mcap", &["--topics", "reply", "--compression", "zstd"]);
    ask(&test, 5);
    assert_eq!(recorder.wait().stdout, "run.mcap: 7 messages recorded, 0 lost\n");
    assert_eq!(recording(&test.path("run.mcap")).records.len(), 7);
    assert_eq!(replies.stop().stdout, "replies.mcap: 10 messages recorded, 0 lost\n");
    let file = recording(&test.path("replies.mcap"));
    assert_eq!((file.requests().len(), file.records.len()), (0, 10));
    assert_eq!(info(&test, "replies.mcap")["statuses"], 0);

    let name = test.domain().to_string();
    let wrong = |arguments: &[&str]| {
        let arguments = [&["--domain", &name, "-o", "x.mcap"], arguments].concat();
        test.run("recorder", &arguments).code
    };
    assert_eq!(wrong(&["--split-size", "10"]), Some(2), "no unit");
    assert_eq!(wrong(&["--max-files", "0"]), Some(2));
    assert_eq!(wrong(&["--topics", "camera"]), Some(2));
    assert_eq!(wrong(&["--snapshot-on", "no_route"]), Some(2), "without --snapshot");
    assert_eq!(wrong(&["--snapshot", "1s", "--snapshot-on", "no_rute"]), Some(2));
    assert_eq!(wrong(&["--min-free-space", "999999GB", "--duration", "1h"]), Some(1));
    assert_eq!(recording(&test.path("x.mcap")).records.len(), 0, "finished while there was room");
}

#[test]
fn a_recording_says_how_it_was_made() {
    let test = TestDomain::new();
    test.write("planner.toml", "queue = 77\n[caps]\nsamples = 4321");
    let _planner = test.planner(&["--config", "planner.toml"]);
    let recorder = test.recorder("run.mcap", &["--flush", "10ms"]);
    ask(&test, 1);
    wait_for("the flush", || {
        (recording(&test.path("run.mcap.part")).records.len() == 3).then_some(())
    });
    // A crash keeps it.
    recorder.kill();
    let info = info(&test, "run.mcap.part");
    let description = &info["description"];
    assert!(info["statuses"].as_u64().unwrap() >= 1, "{info}");
    for name in ["version", "layout", "host", "domain", "id"] {
        assert!(description[name].is_string(), "{name}: {description}");
    }
    assert!(description["command"].as_str().unwrap().contains("--flush 10ms"), "{description}");
    let config: Value = serde_json::from_str(description["config"].as_str().unwrap()).unwrap();
    assert_eq!((&config["queue"], &config["caps"]["samples"]), (&77.into(), &4321.into()));
}

#[test]
fn a_snapshot_has_what_came_before_the_event() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let arguments = ["--snapshot", "1h", "--snapshot-on", "invalid_scene", "--flush", "10ms"];
    let recorder = test.recorder("run.mcap", &arguments);
    ask(&test, 2);
    std::thread::sleep(std::time::Duration::from_millis(50));
    assert!(finished(&test).is_empty());
    recorder.signal(Signal::USR1);
    wait_for("the snapshot", || test.path("run-0000.mcap").exists().then_some(()));
    let mut refused = small();
    refused.limits.speed = Some(-1.0);
    ask(&test, 1);
    assert!(test.connect().call(&refused, LONG).unwrap().answers.is_err());
    wait_for("the snapshot", || test.path("run-0001.mcap").exists().then_some(()));
    let ended = recorder.stop();
    assert_eq!(ended.stdout, "run.mcap: 11 messages recorded, 0 lost, in 2 snapshots\n");
    let counts =
        finished(&test).iter().map(|path| recording(path).records.len()).collect::<Vec<_>>();
    assert_eq!(counts, [6, 5]);
}

#[test]
fn a_killed_recorder_has_all_that_its_last_mark_tells_of() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let client = test.connect();
    let mut kills = 0;
    for compression in ["none", "lz4", "zstd"] {
        for (chunk, split) in [("1KiB", "1GB"), ("1MiB", "1GB"), ("16KiB", "100kB")] {
            let name = format!("{compression}-{chunk}.mcap");
            let options = ["--flush", "5ms", "--compression", compression];
            let sizes = ["--chunk-size", chunk, "--split-size", split];
            let recorder = test.recorder(&name, &[options, sizes].concat());
            // Some moment: whatever the recorder does just then.
            for _ in 0..20 + 7 * kills {
                client.call(&small(), LONG).unwrap();
            }
            recorder.kill();
            kills += 1;
            let stem = name.strip_suffix(".mcap").unwrap();
            let mut expected = 0;
            for index in 0.. {
                let path = |end: &str| test.path(&format!("{stem}-{index:04}.mcap{end}"));
                let (path, is_last) = match path("").exists() {
                    true => (path(""), false),
                    false => (path(".part"), true),
                };
                if !path.exists() {
                    // Killed between two files.
                    break;
                }
                // Killed while it began the next one.
                let Ok(mut reader) = Reader::open(&path) else { break };
                for record in reader.by_ref().map_while(Result::ok) {
                    assert_eq!(u64::from(record.sequence), expected, "{name}");
                    expected += 1;
                }
                let Some(beat) = reader.heartbeat() else { break };
                assert_eq!(reader.lost(), 0);
                assert!(beat.sequence <= expected && beat.announced >= beat.sequence, "{beat:?}");
                if is_last {
                    break;
                }
                assert_eq!(beat.sequence, expected);
            }
            assert!(expected > 0, "{name}: nothing was recorded in time");
        }
    }
}
