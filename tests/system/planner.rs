//! The planner's process: how it starts, ends, dies, waits and serves many.

use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use bus::{CallError, Client, Wait};
use integration_tests::{
    LONG, Signal, TestDomain, kill_pid, scene, scene_files, serving, wait_for,
};
use schemas::message::{
    Choice, ClearanceWish, Gap, Reply, Request, RequestContent, RequestKey, SceneRequest,
};

/// Section 4 at a gap of its own, with its own id.
fn numbered(id: u64) -> SceneRequest {
    let gap = Gap::Uniform(0.001 * (1 + id % 250) as f64);
    let clearance = ClearanceWish::Each(vec![Choice::Gap(gap), Choice::Safest]);
    SceneRequest { id: Some(id), clearance, ..scene("disassemble.json") }
}

/// The reply that a scene must have.
fn expected(key: RequestKey, scene: &SceneRequest) -> Reply {
    let content = RequestContent::Scene(scene.clone());
    answer::reply_to(&Request { key, sent_ns: 0, content }, &answer::Caps::default())
}

#[track_caller]
fn check_planned(client: &Client, scene: &SceneRequest) {
    let reply = client.call(scene, LONG).unwrap();
    assert!(reply == expected(reply.key, scene), "scene {:?} has the reply to another", scene.id);
    assert_eq!(reply.id, scene.id);
}

#[test]
fn a_signal_ends_an_idle_planner() {
    for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
        let test = TestDomain::new();
        let planner = test.planner(&[]);
        planner.signal(signal);
        let ended = planner.wait();
        assert_eq!((ended.code, ended.stdout.as_str()), (Some(0), ""), "{}", ended.stderr);
        assert!(test.left().is_empty(), "{:?}", test.left());
    }
}

#[test]
fn a_signal_ends_a_planner_under_load() {
    for signal in [Signal::INT, Signal::TERM] {
        let test = TestDomain::new();
        let planner = test.planner(&[]);
        let answered = AtomicU64::new(0);
        let connected = AtomicU64::new(0);
        let load = |id: u64| {
            let client = test.connect();
            connected.fetch_add(1, Ordering::Relaxed);
            loop {
                // A call would wait for the next planner.
                let scene = numbered(id);
                match client
                    .send(&scene)
                    .and_then(|mut pending| pending.wait(std::time::Instant::now() + LONG))
                {
                    Ok(reply) => assert_eq!(reply.id, Some(id)),
                    Err(CallError::PlannerLost) => return,
                    Err(error) => panic!("{error}"),
                }
                answered.fetch_add(1, Ordering::Relaxed);
            }
        };
        thread::scope(|scope| {
            for id in 0..3 {
                scope.spawn(move || load(id));
            }
            wait_for("clients", || (connected.load(Ordering::Relaxed) == 3).then_some(()));
            wait_for("load", || (answered.load(Ordering::Relaxed) > 100).then_some(()));
            planner.signal(signal);
            let ended = planner.wait();
            assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        });
        assert!(test.left().is_empty(), "{:?}", test.left());
    }
}

#[test]
fn a_second_planner_is_refused() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let name = test.domain().to_string();
    let second = test.run("planner", &["--domain", &name]);
    assert_eq!((second.code, second.stdout.as_str()), (Some(1), ""));
    let said = format!("planner: another planner serves domain {name}\n");
    assert!(second.stderr.ends_with(&said), "{second:?}");
    check_planned(&test.connect(), &numbered(1));
}

#[test]
fn planners_of_other_domains_are_strangers() {
    let (test, other) = (TestDomain::new(), TestDomain::new());
    let _planner = test.planner(&[]);
    let absent = other.plan(&[scene_files()[0].to_str().unwrap()]);
    assert_eq!(absent.code, Some(1));
    assert!(absent.stderr.contains("no planner runs in domain"), "{absent:?}");
}

#[test]
fn every_way_to_wait_serves_and_ends() {
    for wait in ["event", "hybrid", "poll"] {
        let test = TestDomain::new();
        test.write("planner.toml", &format!("wait = {wait:?}"));
        let planner = test.planner(&["--config", "planner.toml"]);
        for how in [Wait::Event, Wait::Hybrid, Wait::Poll] {
            let client = Client::connect(&test.domain(), how).unwrap();
            (0..3).for_each(|id| check_planned(&client, &numbered(id)));
        }
        let ended = planner.stop();
        assert_eq!(ended.code, Some(0), "{wait}: {}", ended.stderr);
    }
}

#[test]
fn bad_settings_are_refused_by_name() {
    let test = TestDomain::new();
    let name = test.domain().to_string();
    let check = |text: Option<&str>, says: &[&str]| {
        text.map(|text| test.write("planner.toml", text));
        let ended = test.run("planner", &["--domain", &name, "--config", "planner.toml"]);
        assert_eq!((ended.code, ended.stdout.as_str()), (Some(1), ""), "{text:?}");
        let said = says.iter().all(|said| ended.stderr.contains(said));
        assert!(said && ended.stderr.contains("planner.toml"), "{text:?}: {}", ended.stderr);
    };
    check(None, &["can't read", "No such file"]);
    check(Some("wait ="), &["line 1, column 7"]);
    check(Some("wait = \"soon\""), &["unknown variant `soon`", "`event`, `hybrid`, `poll`"]);
    check(Some("colour = 1"), &["unknown field `colour`", "`tap_buffer`"]);
    check(Some("max_clients = 0"), &["max_clients is 0", "between 1 and 1024"]);
    check(Some("max_clients = 1025"), &["max_clients is 1025", "between 1 and 1024"]);
    check(Some("max_clients = -1"), &["max_clients", "-1"]);
    check(Some("requests_per_client = 65"), &["requests_per_client is 65", "between 1 and 64"]);
    check(Some("max_recorders = 17"), &["max_recorders is 17", "between 1 and 16"]);
    check(Some("tap_buffer = 0"), &["tap_buffer is 0", "between 1 and 1048576"]);
    check(Some("patience = -0.5"), &["patience is -0.5", "between 0 and 60"]);
    check(Some("patience = nan"), &["patience is NaN", "between 0 and 60"]);
    check(Some("cache = -1"), &["cache", "-1"]);
    check(
        Some("cache = 2000000000000"),
        &["cache is 2000000000000", "between 0 and 1099511627776"],
    );
    check(Some("[caps]\nsamples = 1"), &["caps.samples is 1;", "between 2 and 1099511627776"]);
    check(Some("[caps]\nchannels = 0"), &["caps.channels is 0", "between 1 and 2147483648"]);
    check(Some("[caps]\ncolour = 1"), &["unknown field `colour`", "`route_steps`"]);
}

#[test]
fn settings_beyond_the_shared_memory_are_refused() {
    let test = TestDomain::new();
    test.write(
        "planner.toml",
        "max_clients = 1024\nrequests_per_client = 64\ntap_buffer = 1048576\nmax_recorders = 16",
    );
    let name = test.domain().to_string();
    let ended = test.run("planner", &["--domain", &name, "--config", "planner.toml"]);
    assert_eq!(ended.code, Some(1));
    assert!(ended.stderr.contains("bytes free, these settings can need"), "{ended:?}");
}

/// It may be that the request has killed it: the caller decides.
#[test]
fn a_call_says_at_once_that_its_planner_was_lost() {
    let test = TestDomain::new();
    let planner = test.planner(&[]);
    let client = test.connect();
    // Frozen, it takes requests and answers none.
    kill_pid(serving(&test), Signal::STOP);
    let mut pending = client.send(&numbered(42)).unwrap();
    planner.kill();
    let lost = pending.wait(std::time::Instant::now() + LONG);
    assert!(matches!(lost, Err(CallError::PlannerLost)), "{lost:?}");
    drop(pending);
    let _planner = test.planner(&[]);
    check_planned(&client, &numbered(43));
}

#[test]
fn clients_get_their_own_replies() {
    let test = TestDomain::new();
    let _planner = test.planner(&[]);
    let recorder = test.recorder("run.mcap", &[]);
    thread::scope(|scope| {
        for place in 0..4 {
            let test = &test;
            scope.spawn(move || {
                let how = [Wait::Event, Wait::Hybrid, Wait::Poll][place as usize % 3];
                let client = Client::connect(&test.domain(), how).unwrap();
                (0..25).for_each(|round| check_planned(&client, &numbered(1000 * place + round)));
            });
        }
        let file = scene_files()[place_of_disassemble()].clone();
        let arguments = ["--format", "json", file.to_str().unwrap()];
        let alone = test.run("plan", &[&["--local"], &arguments[..]].concat());
        for _ in 0..3 {
            assert_eq!(test.plan(&arguments), alone);
        }
    });
    assert_eq!(recorder.stop().code, Some(0));
    let replayed = test.run("replay", &["check", "run.mcap"]);
    assert_eq!(replayed.stdout, "run.mcap: 103 requests, 103 equal\n");
}

fn place_of_disassemble() -> usize {
    let named = |path: &std::path::PathBuf| path.ends_with("disassemble.json");
    scene_files().iter().position(named).expect("it is there")
}
