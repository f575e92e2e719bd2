//! Peers that write what they like into shared memory, and processes that are killed.

use std::time::{Duration, Instant};

use bus::{CallError, Client, Wait};
use clearway_client::Scene;
use fastrand::Rng;
use integration_tests::load::short;
use integration_tests::raw::{
    CHANNEL, ELEMENTS, End, Lie, Memory, OwnFields, RawClient, RawPlanner,
};
use integration_tests::{
    LONG, Signal, TestDomain, kill_pid, scene, scene_files, serving, wait_for,
};
use schemas::json::read_scene;
use schemas::message::SceneRequest;

/// Sends a request of four cells, after `spoil` has had the library's own fields of it.
fn send_raw(test: &TestDomain, spoil: impl FnOnce(&mut OwnFields)) {
    let client = RawClient::connect(&test.domain()).unwrap();
    let memory = Memory { cells: vec![0; 4], ..Memory::default() };
    let pending = client.send(&memory, spoil).unwrap();
    pending.end(Duration::from_millis(100), || {});
}

fn small(id: u64) -> SceneRequest {
    SceneRequest { id: Some(id), ..scene("disassemble-channels.json") }
}

fn check_serves(test: &TestDomain) {
    let reply =
        wait_for("a planner that serves", || match Client::connect(&test.domain(), Wait::Hybrid) {
            Ok(client) => client.call(&small(1), LONG).ok(),
            Err(_) => None,
        });
    assert!(reply.answers.is_ok());
}

#[test]
fn a_false_count_of_elements_is_refused_without_harm() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let before = serving(&test);
    for count in [1 << 20, 1 << 40, u64::MAX / 8, u64::MAX] {
        send_raw(&test, |header| {
            assert_eq!(header[ELEMENTS], 4, "the header is as expected");
            header[ELEMENTS] = count;
        });
        check_serves(&test);
    }
    assert_eq!(serving(&test), before, "the serving process lives on");
}

/// Payloads sent to one planner; `CLEARWAY_PAYLOADS` asks for more.
const PAYLOADS: u32 = 10_000;

/// Whatever is written into a request, also while it is read: it is answered or refused, and so is
/// everybody else's, by the same process.
#[test]
fn nonsense_is_refused_and_harms_nobody() {
    let payloads =
        std::env::var("CLEARWAY_PAYLOADS").map_or(PAYLOADS, |text| text.parse().unwrap());
    let test = TestDomain::new();
    // Nonsense that makes sense after all shall not take long.
    let caps = "[caps]\nsteps = 1_000_000\nsamples = 5_000\nanswers = 50\nbytes = 67_108_864";
    test.write("planner.toml", caps);
    let planner = test.planner(&["--config", "planner.toml"]);
    let before = serving(&test);
    let scenes: Vec<_> = scene_files()
        .iter()
        .map(|path| Memory::of(&read_scene(&std::fs::read_to_string(path).unwrap()).unwrap()))
        .collect();
    let honest = test.connect();
    let expected = honest.call(&short(1), LONG).unwrap().answers.unwrap();
    let peer = RawClient::connect(&test.domain()).unwrap();
    let mut rng = Rng::with_seed(7);
    let mut warm = 0;
    for number in 0..payloads {
        let mut memory = scenes[rng.usize(..scenes.len())].clone();
        let (changes, lies) = (rng.u8(..4) == 0, rng.u8(..50) == 0);
        if !changes {
            memory.spoil(&mut rng);
        }
        let elements = rng.u64(..) >> rng.u8(..64);
        let pending = peer.send(&memory, |own| {
            if lies {
                own[ELEMENTS] = elements;
            }
        });
        let pending = pending.expect("one is open at a time");
        let scribble = || {
            if changes {
                pending.scribble(&mut rng);
            }
        };
        let end = pending.end(LONG, scribble);
        assert_eq!(end, End::Whole, "payload {number}: {memory:?}");
        if number % 100 == 0 {
            assert_eq!(honest.call(&short(1), LONG).unwrap().answers.as_ref(), Ok(&expected));
        }
        if number == payloads / 4 {
            warm = resident(before);
        }
    }
    let after = resident(before);
    assert_eq!(serving(&test), before, "the serving process lives on");
    println!("{payloads} payloads; {warm} kB after a quarter of them, {after} kB in the end");
    assert!(after < warm + 16_384, "{after} kB, after a quarter of them {warm} kB");
    drop((honest, peer));
    assert_eq!(planner.stop().code, Some(0));
}

/// Memory of a process that it shares with nobody, kB.
fn resident(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

/// iceoryx2 panics where it takes such a request.
#[test]
fn a_false_channel_costs_the_serving_process_only() {
    let test = TestDomain::new();
    let mut planner = test.planner(&["--log-format", "json"]);
    for _ in 0..2 {
        let before = serving(&test);
        send_raw(&test, |header| header[CHANNEL] = 100);
        planner.wait_until_it_says("starting another");
        check_serves(&test);
        assert_ne!(serving(&test), before);
    }
    // Panics are objects as well, but for what an abort says without us.
    let said = planner.stderr();
    let lines = said.lines().filter(|line| !line.contains("non-unwinding panic"));
    let objects = lines.map(serde_json::from_str::<serde_json::Value>);
    let messages: Vec<_> = objects.map(|object| object.expect(&said)["message"].clone()).collect();
    assert!(messages.iter().any(|said| said.to_string().contains("panicked at")), "{said}");
}

#[test]
fn requests_of_a_serving_process_that_dies_are_lost_at_once() {
    let test = TestDomain::new();
    let mut planner = test.planner(&[]);
    let client = test.connect();
    let frozen = serving(&test);
    kill_pid(frozen, Signal::STOP);
    let mut pending = client.send(&small(1)).unwrap();
    let begun = Instant::now();
    kill_pid(frozen, Signal::KILL);
    let lost = pending.wait(Instant::now() + LONG);
    println!("lost {:?} after the planner was killed", begun.elapsed());
    match lost {
        Err(CallError::PlannerLost) => {}
        other => panic!("{other:?}"),
    }
    drop(pending);
    planner.wait_until_it_says("starting another");
    // The next serving process takes over, also for clients that were connected before.
    let reply = wait_for("an answer", || client.call(&small(2), LONG).ok());
    assert!(reply.answers.is_ok());
    println!("served {:?} after", begun.elapsed());
    drop(client);
    let ended = planner.stop();
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(test.left().is_empty(), "{:?}", test.left());
}

#[test]
fn a_planner_that_lies_is_told_from_one_that_does_not() {
    let scene = Scene::new(small(1)).unwrap();
    for (lie, name, said) in Lie::ALL {
        let test = TestDomain::new();
        let planner = RawPlanner::open(&test.domain(), lie).unwrap();
        let asked = std::thread::spawn({
            let (domain, scene) = (test.domain(), scene.clone());
            move || clearway_client::Client::connect(&domain)?.plan(&scene, LONG)
        });
        while !asked.is_finished() {
            planner.serve().unwrap();
        }
        let error = asked.join().unwrap().unwrap_err();
        assert!(error.to_string().contains(said), "{name}: {error}");
    }
}

/// Clients that are known, send, and leave before the planner has looked are lost to iceoryx2. Many of
/// them cost nothing in the end: while no client is connected, the same process opens its ports anew.
#[test]
fn clients_that_leave_unseen_do_not_wear_a_planner_out() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let process = serving(&test);
    let descriptors = || std::fs::read_dir(format!("/proc/{process}/fd")).unwrap().count();
    let honest = test.connect();
    assert!(honest.call(&small(1), LONG).unwrap().answers.is_ok());
    let before = descriptors();
    let memory = Memory::of(&small(2));
    for _ in 0..3 {
        let known = (0..16).map(|_| {
            let client = wait_for("a place", || RawClient::connect(&test.domain()));
            let pending = client.send(&memory, |_| {}).unwrap();
            assert_eq!(pending.end(LONG, || {}), End::Whole);
            client
        });
        let known: Vec<_> = known.collect();
        kill_pid(process, Signal::STOP);
        for client in known {
            drop(client.send(&memory, |_| {}));
        }
        kill_pid(process, Signal::CONT);
        assert!(honest.call(&small(3), LONG).unwrap().answers.is_ok());
    }
    assert!(descriptors() >= before + 48, "iceoryx2 has mended this: see docs/upstream.md");
    drop(honest);
    wait_for("descriptors", || (descriptors() < before + 10).then_some(()));
    check_serves(&test);
    assert_eq!(serving(&test), process, "the serving process lives on");
}
