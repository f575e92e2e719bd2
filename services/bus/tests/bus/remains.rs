//! What programs leave behind that were killed at any time: nothing, within seconds.

use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use bus::{Client, ConnectError, Server, ServerOptions, Wait};

use crate::process::Process;
use crate::support::*;

/// How many are killed; CLEARWAY_KILLS in the environment says otherwise.
const KILLS: u64 = 60;

fn kills() -> u64 {
    std::env::var("CLEARWAY_KILLS").map_or(KILLS, |kills| kills.parse().expect("a number"))
}

/// Kills a client that comes and goes, at a random moment of the first 20 ms.
fn kill_one(test: &TestDomain, random: &mut fastrand::Rng) {
    let client = Process::start("client that comes and goes", test);
    std::thread::sleep(Duration::from_micros(random.u64(..20_000)));
    client.kill();
}

#[test]
fn what_killed_clients_leave_is_removed_by_the_living() {
    let test = TestDomain::new();
    let _planner = Process::start("planner", &test);
    // Once somebody was there, as a planner keeps what it has opened.
    connect(&test.domain, Wait::Event).call(&scene(1, 1), LONG).unwrap();
    let before = test.files();
    let mut random = fastrand::Rng::with_seed(7);
    let mut most = 0;
    for _ in 0..kills() {
        kill_one(&test, &mut random);
        most = most.max(test.files().len());
    }
    assert!(most > before.len(), "nobody was killed while it was there");
    let until = Instant::now() + Duration::from_secs(5);
    let left = || -> Vec<PathBuf> {
        test.files().into_iter().filter(|path| !before.contains(path)).collect()
    };
    while !left().is_empty() {
        assert!(Instant::now() < until, "left behind: {:#?}", left());
        std::thread::sleep(Duration::from_millis(10));
    }
    connect(&test.domain, Wait::Event).call(&scene(2, 1), LONG).unwrap();
}

/// Connections of clients with the planner.
fn connections(test: &TestDomain) -> usize {
    let is_one = |path: &PathBuf| path.extension().is_some_and(|kind| kind == "connection");
    test.files().into_iter().filter(is_one).count()
}

#[test]
fn a_client_leaves_nothing_at_a_planner_that_took_over() {
    let test = TestDomain::new();
    let first = Process::start("planner", &test);
    let client = connect(&test.domain, Wait::Event);
    client.call(&scene(1, 1), LONG).unwrap();
    first.kill();
    let mut second = Server::open(&test.domain, &ServerOptions::default()).unwrap();
    drop(client.send(&scene(2, 1)).unwrap());
    let left = std::thread::spawn(move || drop(client));
    // Time to leave too early.
    std::thread::sleep(Duration::from_millis(100));
    while !left.is_finished() {
        second.see_who_left();
        assert!(second.receive().is_none(), "it was dropped");
    }
    second.see_who_left();
    assert_eq!(connections(&test), 0);
}

/// iceoryx2 may lose track of what is held of a client that has left.
#[test]
fn a_client_leaves_when_nothing_of_it_is_held() {
    let test = TestDomain::new();
    let mut server = Server::open(&test.domain, &ServerOptions::default()).unwrap();
    let client = connect(&test.domain, Wait::Event);
    let pending = client.send(&scene(1, 1)).unwrap();
    let held = server.receive().expect("a request");
    drop(pending);
    let left = std::thread::spawn(move || drop(client));
    while !server.has_work() {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(server.receive().is_none(), "it wants to leave");
    // Time to leave too early.
    std::thread::sleep(Duration::from_millis(100));
    assert!(!left.is_finished());
    server.see_who_left();
    drop(held);
    assert!(server.has_work());
    assert!(server.receive().is_none());
    left.join().unwrap();
    server.see_who_left();
    assert_eq!(connections(&test), 0);
}

#[test]
fn a_client_killed_before_its_request_is_taken_leaves_nothing() {
    let test = TestDomain::new();
    let mut server = Server::open(&test.domain, &ServerOptions::default()).unwrap();
    let client = Process::start("client that asks twice and hangs", &test);
    // Its memory is open here from now on.
    drop(server.receive().expect("its first request"));
    assert!(connections(&test) > 0);
    client.kill();
    server.sweep();
    server.see_who_left();
    assert!(server.receive().is_none(), "nobody waits");
    assert_eq!(connections(&test), 0);
}

#[test]
fn what_the_last_left_is_removed_by_the_next() {
    let mut random = fastrand::Rng::with_seed(8);
    for _ in 0..kills().div_ceil(20) {
        let test = TestDomain::new();
        let planner = Process::start("planner", &test);
        kill_one(&test, &mut random);
        planner.kill();
        let there = test.files();
        assert!(there.len() > 10, "only {there:?}");
        let next = Client::connect(&test.domain, Wait::Event);
        assert!(matches!(next, Err(ConnectError::NoPlanner { .. })), "{next:?}");
        assert_eq!(test.files(), Vec::<PathBuf>::new());
    }
}

/// iceoryx2 waits for memory that is being made for as long as it takes.
#[test]
fn memory_that_the_dead_were_making_holds_nobody_up() {
    let test = TestDomain::new();
    let _planner = Process::start("planner", &test);
    Process::start("client that asks and hangs", &test).kill();
    let connections: Vec<_> = test.files();
    let connections =
        connections.iter().filter(|path| path.extension() == Some("connection".as_ref()));
    let mut count = 0;
    for path in connections {
        // The planner still uses the old one.
        std::fs::remove_file(path).unwrap();
        let new = std::fs::File::create_new(path).unwrap();
        new.set_permissions(std::fs::Permissions::from_mode(0o200)).unwrap();
        count += 1;
    }
    assert!(count > 0, "the client was connected");
    connect(&test.domain, Wait::Event).call(&scene(1, 1), LONG).unwrap();
}

#[test]
fn a_planner_that_was_killed_while_it_started_is_in_nobodys_way() {
    let mut random = fastrand::Rng::with_seed(9);
    let test = TestDomain::new();
    let first = Process::start("planner", &test);
    // It stays, and so does the domain.
    let stays = connect(&test.domain, Wait::Event);
    drop(first);
    for _ in 0..kills().div_ceil(6) {
        let starts = Process::begin("planner", &test);
        std::thread::sleep(Duration::from_micros(random.u64(..20_000)));
        starts.kill();
    }
    let _planner = Process::start("planner", &test);
    stays.call(&scene(1, 1), LONG).unwrap();
    connect(&test.domain, Wait::Event).call(&scene(2, 1), LONG).unwrap();
}
