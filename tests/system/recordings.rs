//! The recorder's files: guarded while they are written, split, compressed, described.

use std::path::PathBuf;

use integration_tests::{LONG, Process, Signal, TestDomain, program, scene, wait_for};
use schemas::message::{AxisBox, Digest, FreeSpace, Sampling, SceneRequest, Solid};
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
    let said = "replies.mcap: 10 messages recorded, 0 lost, 5 left out\n";
    assert_eq!(replies.stop().stdout, said);
    let its = info(&test, "replies.mcap");
    assert_eq!((&its["lost"], &its["left_out"]), (&Value::from(0), &Value::from(5)));
    assert_eq!(its["description"]["topics"], "reply");
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
    for name in ["version", "revision", "layout", "host", "domain", "id"] {
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
fn a_snapshot_takes_no_more_memory_than_it_may() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let arguments = ["--snapshot", "1h", "--snapshot-size", "1MB", "--flush", "10ms"];
    let mut recorder = test.recorder("run.mcap", &arguments);
    ask(&test, 100);
    recorder.wait_until_it_says("take more than 1.0 MB; the oldest go first");
    recorder.signal(Signal::USR1);
    wait_for("the snapshot", || test.path("run-0000.mcap").exists().then_some(()));
    // From here on there is room again.
    ask(&test, 1);
    std::thread::sleep(std::time::Duration::from_millis(50));
    recorder.signal(Signal::USR1);
    wait_for("the snapshot", || test.path("run-0001.mcap").exists().then_some(()));
    let ended = recorder.stop();
    assert_eq!(ended.code, Some(0), "{ended:?}");
    assert!(ended.stderr.contains("the snapshot has "), "{ended:?}");
    let path = test.path("run-0000.mcap");
    assert!(path.metadata().unwrap().len() < 1_100_000);
    let kept = recording(&path);
    let exchanges = kept.replies().len();
    assert!((5..100).contains(&exchanges), "{exchanges}");
    let shortened = |file| info(&test, file)["description"]["shortened"].clone();
    assert!(shortened("run-0000.mcap").as_str().unwrap().contains("of 3600s"));
    assert_eq!(shortened("run-0001.mcap"), Value::Null);
    assert_eq!(recording(&test.path("run-0001.mcap")).records.len(), 3);
}

/// Asks for long replies at once, so that never none is open.
fn ask_without_pause(test: &TestDomain) {
    let mut long = small();
    long.sampling = Some(Sampling::Count(5_000));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let client = test.connect();
                for _ in 0..6 {
                    assert!(client.call(&long, LONG).unwrap().answers.is_ok());
                }
            });
        }
    });
}

#[test]
fn a_split_within_an_exchange_is_told() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let recorder = test.recorder("run.mcap", &["--split-size", "150kB", "--chunk-size", "16KiB"]);
    ask_without_pause(&test);
    assert_eq!(recorder.stop().code, Some(0));
    let files = finished(&test);
    let names: Vec<_> = files.iter().map(|path| path.to_str().unwrap()).collect();
    assert!(names.len() > 20, "{names:?}");
    let all = test.run("replay", &[&["check"], &names[..]].concat());
    assert!(all.stdout.ends_with("more: 24 requests, 24 equal\n"), "{all:?}");
    assert_eq!((all.code, all.stderr.as_str()), (Some(0), ""));
    // Replies are longer than a file.
    let one = test.run("replay", &["check", names[10]]);
    assert_eq!(one.code, Some(3), "{one:?}");
    let says = |text| one.stderr.contains(text);
    let before = says("which is in a file before this one");
    assert!(before || says("goes on in a file after this one"), "{one:?}");
    assert!(!says("is not in the recording") && !says("has no reply"), "{one:?}");
    assert!(!says("is cut off"), "{one:?}");
    // Files of which none says so miss them.
    let missing = test.run("replay", &["check", names[10], names[12]]);
    assert!(missing.stderr.contains("the recorder missed"), "{missing:?}");
}

/// A scene whose free space has a name, with that and without, and the name.
fn named(mut scene: SceneRequest) -> (SceneRequest, SceneRequest, String) {
    let name = scene.free_space.digest();
    scene.free_space.named = Some(name);
    let mut by_name = scene.clone();
    by_name.free_space = FreeSpace { named: Some(name), ..FreeSpace::default() };
    (scene, by_name, name.to_string())
}

#[test]
fn free_spaces_sent_before_the_recorder_came_are_recorded() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let (upload, by_name, name) = named(small());
    let (other, other_by_name, _) = named(scene("drive-office-boxes.json"));
    let client = test.connect();
    for scene in [&upload, &other, &by_name] {
        assert!(client.call(scene, LONG).unwrap().answers.is_ok());
    }
    // Each recorder that comes is told.
    for file in ["first.mcap", "second.mcap"] {
        let recorder = test.recorder(file, &[]);
        for _ in 0..3 {
            for scene in [&by_name, &other_by_name] {
                assert!(client.call(scene, LONG).unwrap().answers.is_ok());
            }
        }
        let mut unknown = by_name.clone();
        unknown.free_space.named = Some(Digest([7; 32]));
        assert!(client.call(&unknown, LONG).unwrap().answers.is_err());
        let ended = recorder.stop();
        assert_eq!((ended.code, ended.stderr.contains(&name)), (Some(0), false), "{ended:?}");
        let checked = test.run("replay", &["check", file]);
        assert!(checked.stdout.contains("7 requests, 6 equal"), "{checked:?}");
        assert_eq!(checked.code, Some(0), "{checked:?}");
    }
}

#[test]
fn a_free_space_that_no_recorder_can_be_told_is_named() {
    let test = TestDomain::new();
    test.write("planner.toml", "tap_buffer = 8");
    let _planner = test.planner(&["--config", "planner.toml"]);
    // Far away, and more of them than half of the buffer takes.
    let mut large = small();
    let far = |index: u32| {
        let at = 1_000.0 + 2.0 * f64::from(index);
        let vector = |x: f64| [x, x].into();
        Solid::Box(AxisBox { min: vector(at), max: vector(at + 1.0) })
    };
    large.free_space.solids = Some((0..6_000).map(far).collect());
    let (upload, by_name, name) = named(large);
    let client = test.connect();
    assert!(client.call(&upload, LONG).unwrap().answers.is_ok());
    let recorder = test.recorder("run.mcap", &[]);
    assert!(client.call(&by_name, LONG).unwrap().answers.is_ok());
    std::thread::sleep(std::time::Duration::from_millis(50));
    let ended = recorder.stop();
    assert_eq!(ended.code, Some(3), "{ended:?}");
    assert!(
        ended.stderr.contains(&format!("free space {name}, which is not recorded")),
        "{ended:?}"
    );
    assert_eq!(info(&test, "run.mcap")["missing_free_spaces"], serde_json::json!([name]));
    let checked = test.run("replay", &["check", "run.mcap"]);
    assert_eq!(checked.code, Some(3), "{checked:?}");
    let says = format!("free space {name} is not in the recording: 1 of its requests");
    assert!(checked.stderr.contains(&says), "{checked:?}");
}
