//! Who dies, hangs or dawdles harms nobody else.

use std::process::Command;
use std::sync::mpsc;
use std::time::{Duration, Instant};

use bus::{
    CallError, Client, ConnectError, Incoming, OpenError, ReplyError, ReplyOptions, Server,
    ServerOptions, Wait,
};
use rustix::process::Signal;

use crate::process::Process;
use crate::support::*;

#[test]
fn a_client_that_takes_nothing_holds_nobody_up() {
    let test = TestDomain::new();
    let (ended, end) = mpsc::channel();
    let patience = Duration::from_secs(1);
    let options = ServerOptions { reply: ReplyOptions { patience }, ..ServerOptions::default() };
    let serve = |incoming: &mut Incoming| answer(&incoming.header(), incoming);
    let _planner = Planner::start_and_tell(&test.domain, options, serve, move |result| {
        ended.send(result).unwrap();
    });
    let dawdler = Client::connect(&test.domain, Wait::Event).unwrap();
    let client = Client::connect(&test.domain, Wait::Event).unwrap();
    let mut long = dawdler.send(&scene(1, 100_000)).unwrap();
    let begin = Instant::now();
    for id in 0..20 {
        client.call(&scene(id, 1), LONG).unwrap();
        assert_eq!(end.recv().unwrap(), Ok(()), "the others' replies come first");
    }
    assert_eq!(end.recv().unwrap(), Err(ReplyError::Slow { patience }));
    // The machine may be busy.
    assert!(begin.elapsed() >= patience, "{:?}", begin.elapsed());
    // The dawdler gets what was sent, and then learns that there is no more.
    let failed = long.wait(Instant::now() + LONG);
    assert!(matches!(failed, Err(CallError::GivenUp)), "{failed:?}");
    drop(long);
    dawdler.call(&scene(3, 100_000), LONG).unwrap();
}

/// Whether it was stopped, or the machine paused: what it did not see, it does not hold against clients.
#[test]
fn a_planner_that_is_held_up_itself_gives_nobody_up() {
    let test = TestDomain::new();
    let patience = Duration::from_millis(50);
    let options = ServerOptions { reply: ReplyOptions { patience }, ..ServerOptions::default() };
    let mut server = Server::open(&test.domain, &options).unwrap();
    let client = Client::connect(&test.domain, Wait::Hybrid).unwrap();
    let mut long = client.send(&scene(1, 100_000)).unwrap();
    let mut incoming = server.receive().expect("a request");
    answer(&incoming.header(), &mut incoming).unwrap();
    assert!(incoming.is_held_up());
    std::thread::sleep(4 * patience);
    assert!(incoming.flush().unwrap() > 0);
    let reading = std::thread::spawn(move || long.wait(Instant::now() + LONG));
    while incoming.flush().unwrap() > 0 {}
    let reply = reading.join().unwrap().unwrap();
    assert_eq!(reply.answers.unwrap()[0].as_ref().unwrap().samples.len(), 100_000);
}

/// However fast its parts come.
#[test]
fn a_long_reply_is_not_waited_for_beyond_the_limit() {
    let test = TestDomain::new();
    let _planner = Planner::start(&test.domain, ServerOptions::default());
    let client = Client::connect(&test.domain, Wait::Hybrid).unwrap();
    let mut long = client.send(&scene(1, 100_000)).unwrap();
    let ended = long.wait(Instant::now());
    assert!(matches!(ended, Err(CallError::TimedOut { .. })), "{ended:?}");
}

#[test]
fn a_frozen_client_process_is_given_up() {
    let test = TestDomain::new();
    let _planner = Planner::start(&test.domain, ServerOptions::default());
    let frozen = Process::start("client that waits", &test);
    frozen.signal(Signal::STOP);
    let client = Client::connect(&test.domain, Wait::Event).unwrap();
    for id in 0..20 {
        client.call(&scene(id, 10), LONG).unwrap();
    }
}

#[test]
fn a_killed_client_is_no_longer_waited_for() {
    let test = TestDomain::new();
    let mut server = Server::open(&test.domain, &ServerOptions::default()).unwrap();
    let client = Process::start("client that asks and hangs", &test);
    let until = Instant::now() + LONG;
    let incoming = server.receive().expect("the client has asked");
    assert!(incoming.is_waiting());
    client.kill();
    server.watch(&incoming);
    while incoming.is_waiting() {
        assert!(Instant::now() < until, "it is waited for");
        server.wait(None);
        assert!(server.receive().is_none());
    }
}

#[test]
fn killed_clients_leave_their_places_to_others() {
    let test = TestDomain::new();
    let options = ServerOptions { max_clients: 2, ..ServerOptions::default() };
    let _planner = Planner::start(&test.domain, options);
    for _ in 0..6 {
        Process::start("client that asks and hangs", &test).kill();
    }
    let client = Client::connect(&test.domain, Wait::Event).unwrap();
    client.call(&scene(1, 100_000), LONG).unwrap();
}

#[test]
fn one_client_too_many_is_refused() {
    let test = TestDomain::new();
    let options = ServerOptions { max_clients: 2, ..ServerOptions::default() };
    let _planner = Planner::start(&test.domain, options);
    let connect = || Client::connect(&test.domain, Wait::Hybrid);
    let clients = [connect().unwrap(), connect().unwrap()];
    let third = connect();
    assert!(matches!(third, Err(ConnectError::Full { .. })), "{third:?}");
    clients.iter().for_each(|client| drop(client.call(&scene(1, 1), LONG).unwrap()));
    drop(clients);
    connect().unwrap();
}

#[test]
fn a_call_notices_within_its_limit_that_the_planner_was_killed() {
    let test = TestDomain::new();
    let planner = Process::start("planner that answers nothing", &test);
    let client = connect(&test.domain, Wait::Hybrid);
    let limit = Duration::from_millis(1500);
    let begin = Instant::now();
    let killer = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(200));
        planner.kill();
    });
    let failed = client.call(&scene(1, 1), limit);
    assert!(matches!(failed, Err(CallError::PlannerLost)), "{failed:?}");
    assert!(begin.elapsed() < limit + Duration::from_secs(1), "{:?}", begin.elapsed());
    killer.join().unwrap();
}

#[test]
fn a_call_waits_for_a_planner_that_does_not_answer_until_its_limit() {
    let test = TestDomain::new();
    let _planner = Process::start("planner that answers nothing", &test);
    let client = connect(&test.domain, Wait::Event);
    let failed = client.call(&scene(1, 1), Duration::from_millis(300));
    assert!(matches!(failed, Err(CallError::TimedOut { .. })), "{failed:?}");
}

/// A request may have killed its planner: it is not sent to the next one.
#[test]
fn the_call_of_a_killed_planner_is_not_repeated() {
    let test = TestDomain::new();
    let planner = Process::start("planner that answers nothing", &test);
    let client = connect(&test.domain, Wait::Event);
    let mut pending = client.send(&scene(1, 3)).unwrap();
    planner.kill();
    let another = Process::start("planner", &test);
    let failed = pending.wait(Instant::now() + LONG);
    assert!(matches!(failed, Err(CallError::PlannerLost)), "{failed:?}");
    drop(pending);
    let reply_is = client.call(&scene(2, 3), LONG).unwrap();
    assert_eq!(reply_is, reply(reply_is.key, 2, 3));
    assert_eq!(reply_is.key.sequence, 1);
    drop(another);
}

#[test]
fn a_planner_that_leaves_and_comes_back_is_found_again() {
    let test = TestDomain::new();
    let planner = Planner::start(&test.domain, ServerOptions::default());
    let client = Client::connect(&test.domain, Wait::Hybrid).unwrap();
    client.call(&scene(1, 1), LONG).unwrap();
    drop(planner);
    let failed = client.call(&scene(2, 1), Duration::from_millis(50));
    assert!(matches!(failed, Err(CallError::PlannerLost)), "{failed:?}");
    let _planner = Planner::start(&test.domain, ServerOptions::default());
    client.call(&scene(3, 2_000), LONG).unwrap();
}

#[test]
fn a_second_planner_is_refused() {
    let test = TestDomain::new();
    let _planner = Planner::start(&test.domain, ServerOptions::default());
    let second = Server::open(&test.domain, &ServerOptions::default());
    assert!(matches!(&second, Err(OpenError::AnotherPlanner(domain)) if *domain == test.domain));
    Client::connect(&test.domain, Wait::Hybrid).unwrap().call(&scene(1, 1), LONG).unwrap();
}

#[test]
fn no_planner_is_said_so() {
    let test = TestDomain::new();
    let client = Client::connect(&test.domain, Wait::Hybrid);
    assert!(matches!(client, Err(ConnectError::NoPlanner { .. })), "{client:?}");
}

/// Ends a planner with a client and a recorder in its domain by a signal.
fn check_signal(part: &str, signal: Signal) {
    let test = TestDomain::new();
    let planner = Process::start(part, &test);
    connect(&test.domain, Wait::Event).call(&scene(1, 1), LONG).unwrap();
    let recorder = Process::start("recorder", &test);
    // By itself it takes 0.1 s at most, but the machine may be busy.
    for (name, process) in [(part, planner), ("recorder", recorder)] {
        process.signal(signal);
        assert!(process.ends_within(LONG), "{name} did not end");
    }
    assert_eq!(test.files(), Vec::<std::path::PathBuf>::new(), "left behind");
}

#[test]
fn signals_end_a_planner_and_nothing_is_left() {
    check_signal("planner", Signal::TERM);
    check_signal("planner", Signal::INT);
    check_signal("planner", Signal::HUP);
    check_signal("polling planner", Signal::TERM);
}

#[test]
fn started_by_nohup_a_planner_outlives_its_terminal() {
    let test = TestDomain::new();
    let planner = Process::start_by(Command::new("nohup"), "planner", &test);
    planner.signal(Signal::HUP);
    let client = connect(&test.domain, Wait::Event);
    for id in 0..20 {
        client.call(&scene(id, 1), LONG).unwrap();
        std::thread::sleep(Duration::from_millis(10));
    }
    planner.signal(Signal::TERM);
    assert!(planner.ends_within(Duration::from_secs(2)), "it did not end");
}
