//! Requests and replies arrive whole.

use std::sync::mpsc;
use std::time::{Duration, Instant};

use bus::{Client, Domain, Incoming, ReplyError, Server, ServerOptions, Wait};
use schemas::message::SceneRequest;

use crate::support::*;

/// Sends a scene to a planner that hands back what it read.
#[track_caller]
fn check_arrives(scene: &SceneRequest) {
    let test = TestDomain::new();
    let (read_scenes, arrived) = mpsc::channel();
    let _planner = Planner::start_with(&test.domain, ServerOptions::default(), move |incoming| {
        read_scenes.send(read(incoming)).unwrap();
        answer(&incoming.header(), incoming)
    });
    let client = Client::connect(&test.domain, Wait::Hybrid).unwrap();
    client.call(scene, LONG).unwrap();
    assert_eq!(arrived.recv().unwrap().as_ref(), Ok(scene));
}

#[test]
fn a_scene_arrives_as_it_was_sent() {
    check_arrives(&scene(7, 3));
}

#[test]
fn a_scene_with_100_000_channels_arrives() {
    let mut scene = scene(8, 3);
    scene.free_space.channels =
        Some((0..100_000).map(|index| boxed(index.into(), f64::from(index) + 1.5)).collect());
    check_arrives(&scene);
}

#[test]
fn a_long_reply_arrives_whole() {
    let test = TestDomain::new();
    let _planner = Planner::start(&test.domain, ServerOptions::default());
    let client = Client::connect(&test.domain, Wait::Hybrid).unwrap();
    // 9 cells each, 4,096 cells a part: one part, one and a bit, 220.
    for samples in [0, 1, 455, 456, 100_000] {
        let reply_is = client.call(&scene(samples, samples), LONG).unwrap();
        assert_eq!(reply_is, reply(reply_is.key, samples, samples));
    }
}

#[test]
fn open_requests_are_answered_each() {
    let test = TestDomain::new();
    let options = ServerOptions { requests_per_client: 4, ..ServerOptions::default() };
    let _planner = Planner::start(&test.domain, options);
    let client = Client::connect(&test.domain, Wait::Event).unwrap();
    let until = Instant::now() + LONG;
    let mut open: Vec<_> = (0..4).map(|id| client.send(&scene(id, 2_000 * id)).unwrap()).collect();
    let fifth = client.send(&scene(4, 1)).unwrap_err();
    let said = "4 requests of this client are open, the most this planner takes \
        (`requests_per_client`)";
    assert_eq!(fifth.to_string(), said);
    for (id, pending) in open.iter_mut().enumerate().rev() {
        let key = pending.key();
        let id = id as u64;
        assert_eq!(pending.wait(until).unwrap(), reply(key, id, 2_000 * id));
    }
    drop(open);
    client.call(&scene(5, 1), LONG).unwrap();
}

/// iceoryx2 looks at its clients in the same order each time.
#[test]
fn a_client_that_keeps_asking_starves_nobody() {
    let test = TestDomain::new();
    let options = ServerOptions { requests_per_client: 8, ..ServerOptions::default() };
    let mut server = Server::open(&test.domain, &options).unwrap();
    let [first, second] = [(); 2].map(|()| Client::connect(&test.domain, Wait::Poll).unwrap());
    for (busy, other) in [(&first, &second), (&second, &first)] {
        let mut open = vec![busy.send(&scene(1, 1)).unwrap()];
        let waiting = other.send(&scene(2, 1)).unwrap();
        let turn = (0..6).find(|_| {
            let taken = server.receive().expect("two wait");
            open.push(busy.send(&scene(1, 1)).unwrap());
            taken.header().client == waiting.key().client
        });
        assert!(turn.is_some_and(|turn| turn <= 2), "the other's turn: {turn:?}");
        drop((open, waiting));
        assert!(server.receive().is_none(), "nobody waits");
    }
}

/// A call is to take far less than the net under a wake-up that is slept over. The median
/// says so on a busy machine, too.
fn check_prompt(domain: &Domain, client: Wait, server: Wait) {
    let options = ServerOptions { wait: server, ..ServerOptions::default() };
    let _planner = Planner::start(domain, options);
    let client_port = Client::connect(domain, client).unwrap();
    let call = |id| {
        // The other side has gone to sleep in some of the calls.
        std::thread::sleep(Duration::from_micros(id % 7 * 30));
        let begin = Instant::now();
        client_port.call(&scene(id, 1), LONG).unwrap();
        begin.elapsed()
    };
    let mut took: Vec<_> = (0..100).map(call).collect();
    took.sort_unstable();
    assert!(took[50] < bus::wait::NET / 2, "client {client:?}, server {server:?}: {took:?}");
}

#[test]
fn every_way_to_wait_is_prompt() {
    for client in [Wait::Event, Wait::Hybrid, Wait::Poll] {
        for server in [Wait::Event, Wait::Hybrid, Wait::Poll] {
            let test = TestDomain::new();
            check_prompt(&test.domain, client, server);
        }
    }
}

#[test]
fn a_client_that_drops_its_request_is_no_longer_waited_for() {
    let test = TestDomain::new();
    let mut server = Server::open(&test.domain, &ServerOptions::default()).unwrap();
    let client = Client::connect(&test.domain, Wait::Poll).unwrap();
    let [first, second] = [1, 2].map(|id| client.send(&scene(id, 1)).unwrap());
    let incoming = server.receive().expect("a request");
    assert!(incoming.is_waiting());
    drop(first);
    assert!(!incoming.is_waiting());
    // The client's other request is still open.
    drop(incoming);
    let incoming = server.receive().expect("a request");
    assert!(incoming.is_waiting());
    drop(second);
    assert!(!incoming.is_waiting());
}

#[test]
fn a_client_that_drops_its_request_stops_the_reply() {
    let test = TestDomain::new();
    let (ended, end) = mpsc::channel();
    let options = ServerOptions::default();
    let serve = |incoming: &mut Incoming| answer(&incoming.header(), incoming);
    let _planner = Planner::start_and_tell(&test.domain, options, serve, move |result| {
        ended.send(result).unwrap();
    });
    let client = Client::connect(&test.domain, Wait::Event).unwrap();
    let mut pending = client.send(&scene(1, 100_000)).unwrap();
    pending.wait_part(Instant::now() + LONG).unwrap();
    drop(pending);
    assert_eq!(end.recv().unwrap(), Err(ReplyError::Gone));
    client.call(&scene(2, 1), LONG).unwrap();
}
