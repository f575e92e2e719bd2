//! Recorders killed at random moments: what their files hold, and what they say is missing.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Barrier, Mutex};
use std::time::Duration;

use comparison::exchanges;
use fastrand::Rng;
use integration_tests::{LONG, TestDomain, scene};
use recording::{Options, Reader, RecoverError, recover};

/// How many are killed, and with which moments; in the environment, `CLEARWAY_KILLS` and
/// `CLEARWAY_SEED` say otherwise.
const KILLS: u64 = 27;
const SEED: u64 = 11;

/// Messages of a call: the request, and a reply in two parts.
const MESSAGES: u64 = 3;

const CLIENTS: usize = 2;

fn given(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().expect("a number"))
}

/// Kills a recorder that writes to `NAME.mcap` while clients ask. When their calls ended, by the
/// clock of the system, in nanoseconds.
fn kill_one(test: &TestDomain, name: &str, options: &[&str], moment: Duration) -> Vec<u64> {
    let recorder = test.recorder(&format!("{name}.mcap"), options);
    let (is_over, begin) = (AtomicBool::new(false), Barrier::new(CLIENTS + 1));
    let ended = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..CLIENTS {
            scope.spawn(|| {
                let (client, small) = (test.connect(), scene("disassemble-channels.json"));
                begin.wait();
                while !is_over.load(Ordering::Relaxed) {
                    assert!(client.call(&small, LONG).unwrap().answers.is_ok());
                    ended.lock().unwrap().push(bus::now_ns());
                }
            });
        }
        begin.wait();
        std::thread::sleep(moment);
        recorder.kill();
        is_over.store(true, Ordering::Relaxed);
    });
    ended.into_inner().unwrap()
}

/// The files that it left, in order, and whether each is finished.
fn left(test: &TestDomain, name: &str) -> Vec<(PathBuf, bool)> {
    let file = |index: u64| {
        let whole = test.path(&format!("{name}-{index:04}.mcap"));
        let part = whole.with_extension("mcap.part");
        let file = if whole.exists() { (whole, true) } else { (part, false) };
        Some(file).filter(|(path, _)| path.exists())
    };
    (0..).map_while(file).collect()
}

/// Checks the files of a killed recorder against the calls that `ended`. How many messages they
/// have, and how many they lack.
fn check(test: &TestDomain, name: &str, ended: &[u64]) -> (u64, u64) {
    let sent = ended.len() as u64 * MESSAGES;
    let mut files = left(test, name);
    // The newest may not even have a beginning.
    files.retain(|(path, _)| Reader::open(path).is_ok());
    assert!(files.last().is_some_and(|(_, is_whole)| !is_whole), "{name}: {files:?} look finished");
    let (mut read, mut next, mut last) = (0, 0, None);
    for (index, (path, is_whole)) in files.iter().enumerate() {
        let mut reader = Reader::open(path).unwrap();
        let mut here = 0;
        for record in reader.by_ref().map_while(Result::ok) {
            if here == 0 && !files[..index].iter().all(|(_, is_whole)| *is_whole) {
                panic!("{name}: a file has messages before the one in front of it is finished");
            }
            assert_eq!(u64::from(record.sequence), next, "{name}");
            (next, here) = (next + 1, here + 1);
        }
        assert_eq!(reader.lost(), 0, "{name}");
        let Some(beat) = reader.heartbeat() else { continue };
        assert!(
            beat.sequence <= next.max(reader.begin().unwrap()),
            "{name}: {beat:?}, read {next}"
        );
        assert!(beat.announced <= sent, "{name}: {beat:?}, but {sent} were sent");
        // What had been sent when it last looked is there, or known to be missing.
        let before = ended.iter().filter(|when| **when <= beat.time_ns).count() as u64;
        assert!(before * MESSAGES <= beat.announced, "{name}: {beat:?} after {before} calls");
        if *is_whole {
            assert_eq!(beat.sequence, next, "{name}: a finished file has all");
        } else {
            recovers(test, path, here);
        }
        (read, last) = (read + here, Some(beat.announced.max(last.unwrap_or(0))));
    }
    let paths: Vec<_> = files.into_iter().map(|(path, _)| path).collect();
    let contents = exchanges::read_all(&paths, |_| {}, |_| {});
    let lacks = contents.lost() + contents.unrecorded();
    assert_eq!(read + lacks, last.unwrap_or(0).max(read), "{name}");
    assert!(read <= sent, "{name}: {read} of {sent}");
    (read, sent - read)
}

/// All that can be read of a file is recovered.
fn recovers(test: &TestDomain, path: &Path, messages: u64) {
    match recover(path, &test.path("whole.mcap"), false, Options::overwriting()) {
        Ok(recovered) => {
            assert_eq!(recovered.summary.recorded, messages, "{recovered:?}");
            assert_eq!(recovered.unreadable, 0, "{recovered:?}");
        }
        Err(RecoverError::Nothing { .. }) => assert_eq!(messages, 0),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn killed_recorders_say_what_they_have_lost() {
    let seed = given("CLEARWAY_SEED", SEED);
    println!("CLEARWAY_SEED={seed}");
    let (mut random, test) = (Rng::with_seed(seed), TestDomain::new());
    let _planner = test.planner(&[]);
    let (mut recorded, mut lost) = (0, 0);
    for kill in 0..given("CLEARWAY_KILLS", KILLS) {
        let compression = ["none", "lz4", "zstd"][kill as usize % 3];
        let sizes = [("1KiB", "1GB"), ("1MiB", "300kB"), ("16KiB", "100kB")];
        let (chunk, split) = sizes[kill as usize / 3 % 3];
        let flush = format!("{}ms", [1, 5, 50][random.usize(..3)]);
        let moment = Duration::from_micros(random.u64(..80_000));
        let name = format!("{kill}-{compression}-{chunk}-{split}-{flush}-{moment:?}");
        let how = ["--flush", &flush, "--compression", compression];
        let sizes = ["--chunk-size", chunk, "--split-size", split];
        let ended = kill_one(&test, &name, &[how, sizes].concat(), moment);
        let (has, lacks) = check(&test, &name, &ended);
        (recorded, lost) = (recorded + has, lost + lacks);
    }
    assert!(recorded > 0 && lost > 0, "{recorded} recorded, {lost} lost: nothing was to be seen");
}
