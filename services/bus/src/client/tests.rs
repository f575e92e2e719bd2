//! A client gets no reply but its own, whoever was in its place before.

use std::cell::OnceCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};

use schemas::convert::PartSink;
use schemas::message::{ErrorCode, Refusal};
use schemas::wire;

use super::*;
use crate::error::ReplyError;
use crate::options::ServerOptions;
use crate::server::{Incoming, Server};
use crate::test_domain::test_domain;

/// Two clients that start with the same request id.
const EARLIER: u64 = 5;
const LATER: u64 = 5 + FIRST_IDS;

fn answer(incoming: &mut Incoming) -> Result<(), ReplyError> {
    let wire::RequestHeader { client, sequence, .. } = incoming.header();
    let mut header = wire::ReplyHeader {
        version: wire::VERSION,
        client,
        sequence,
        answers: 1,
        ..wire::ReplyHeader::default()
    };
    let refusal = Refusal::new(ErrorCode::NoRoute, format!("to {client}"));
    convert::write_refusal(&refusal, &mut header, true, &mut incoming.reply())
}

fn ask(client: &Client) -> Pending {
    client.send_cells(wire::RequestHeader::default(), &[]).unwrap()
}

/// Lets a client ask in a thread of its own until `leave`, which returns when it has left.
fn client_that_leaves(domain: &Domain, nonce: u64) -> impl FnOnce() + use<> {
    let domain = domain.clone();
    let (say, said) = mpsc::channel();
    let (leave, left) = mpsc::channel::<()>();
    let client = std::thread::spawn(move || {
        let client = Client::connect_as(&domain, Wait::Poll, nonce).unwrap();
        let pending = ask(&client);
        say.send(()).unwrap();
        left.recv().unwrap();
        drop(pending);
    });
    said.recv().unwrap();
    move || {
        leave.send(()).unwrap();
        client.join().unwrap();
    }
}

/// While the planner writes its reply to a client, that client leaves, and another comes
/// in its place and asks. `check` sees the second client's request.
fn check_late_reply(earlier: u64, later: u64, check: impl FnOnce(&Pending)) {
    let domain = test_domain();
    let mut server = Server::open(&domain, &ServerOptions::default()).unwrap();
    let leave = client_that_leaves(&domain, earlier);
    let mut incoming = server.receive().expect("the request is there");

    let mut leave = Some(leave);
    let client = OnceCell::new();
    let mut pending = None;
    let header = wire::ReplyHeader { client: earlier, ..wire::ReplyHeader::default() };
    let sent = incoming.reply().part(&header, 0, |_| {
        leave.take().expect("written once")();
        let later = || Client::connect_as(&domain, Wait::Poll, later).unwrap();
        pending = Some(ask(client.get_or_init(later)));
    });
    assert_eq!(sent, Ok(()));
    check(&pending.take().expect("it asked"));
    drop(incoming);

    // Nothing of that is in the way of the next request.
    let mut pending = ask(client.get().expect("it came"));
    while let Some(mut incoming) = server.receive() {
        let _ = answer(&mut incoming);
    }
    let until = Instant::now() + Duration::from_secs(10);
    assert_eq!(pending.wait_part(until).unwrap().key, pending.key());
}

#[test]
fn a_reply_to_an_earlier_client_arrives_on_the_bus() {
    check_late_reply(EARLIER, LATER, |pending| {
        // The hazard itself: iceoryx2 takes it for the reply to this request.
        let part = pending.awaited.receive().unwrap().expect("a part");
        assert_eq!(part.user_header().plain().client, EARLIER);
    });
}

#[test]
fn a_reply_to_an_earlier_client_is_dropped() {
    check_late_reply(EARLIER, LATER, |pending| {
        assert!(pending.awaited.has_response());
        assert!(matches!(pending.receive(|header, _| header.client), Ok(None)));
        assert!(!pending.awaited.has_response());
    });
}

#[test]
fn different_first_ids_keep_it_from_arriving() {
    check_late_reply(EARLIER, LATER + 1, |pending| {
        assert!(pending.awaited.receive().unwrap().is_none());
    });
}

#[test]
fn a_client_that_has_left_is_not_written_to() {
    let domain = test_domain();
    let mut server = Server::open(&domain, &ServerOptions::default()).unwrap();
    let leave = client_that_leaves(&domain, EARLIER);
    let mut incoming = server.receive().expect("the request is there");
    leave();
    let header = wire::ReplyHeader::default();
    let sent = incoming.reply().part(&header, 0, |_| panic!("nobody is there to write to"));
    assert_eq!(sent, Err(ReplyError::Gone));
}

/// The late reply's end also ends the later client's request, which looks as if the planner
/// were gone. Calls ask again.
#[test]
fn a_call_survives_the_end_of_an_earlier_request() {
    let domain = test_domain();
    let mut server = Server::open(&domain, &ServerOptions::default()).unwrap();
    let leave = client_that_leaves(&domain, EARLIER);
    let mut incoming = server.receive().expect("the request is there");

    let mut leave = Some(leave);
    let mut calling = None;
    let header = wire::ReplyHeader { client: EARLIER, ..wire::ReplyHeader::default() };
    let _ = incoming.reply().part(&header, 0, |_| {
        leave.take().expect("written once")();
        let (say, said) = mpsc::channel();
        let domain = domain.clone();
        calling = Some(std::thread::spawn(move || {
            let later = Client::connect_as(&domain, Wait::Event, LATER).unwrap();
            say.send(()).unwrap();
            later.call(&SceneRequest::empty(), Duration::from_secs(10)).unwrap()
        }));
        said.recv().unwrap();
        std::thread::sleep(Duration::from_millis(20));
    });
    drop(incoming);
    let calling = calling.expect("it came");
    while !calling.is_finished() {
        server.wait(None);
        while let Some(mut incoming) = server.receive() {
            let _ = answer(&mut incoming);
        }
    }
    let reply = calling.join().unwrap();
    assert_eq!(reply.key, RequestKey { client: LATER, sequence: 1 }, "asked again");
    assert_eq!(reply.answers.unwrap()[0].as_ref().unwrap_err().message, format!("to {LATER}"));
}

/// Many short-lived clients in one place, all with the same first request id, and a planner that
/// answers late: what any of them takes is its own. `BUS_STRESS` is for how many seconds.
#[test]
fn short_lived_clients_take_no_other_clients_replies() {
    let seconds = std::env::var("BUS_STRESS").map_or(2, |seconds| seconds.parse().unwrap());
    let domain = test_domain();
    let (opened, open) = mpsc::channel();
    let stop = Arc::new(AtomicBool::new(false));
    let (there, stopped) = (domain.clone(), Arc::clone(&stop));
    let planner = std::thread::spawn(move || {
        let mut server = Server::open(&there, &ServerOptions::default()).unwrap();
        opened.send(()).unwrap();
        let mut late = 0;
        while !stopped.load(Ordering::Relaxed) {
            server.wait(None);
            while let Some(mut incoming) = server.receive() {
                late = (late + 7) % 60;
                std::thread::sleep(Duration::from_millis(late));
                let _ = answer(&mut incoming);
            }
        }
    });
    open.recv().unwrap();
    let until = Instant::now() + Duration::from_secs(seconds);
    let (mut own, mut foreign) = (0, 0);
    for nonce in (0..).map(|count: u64| count * FIRST_IDS) {
        if Instant::now() > until {
            break;
        }
        let client = Client::connect_as(&domain, Wait::Event, nonce).unwrap();
        let pending = client.send_cells(wire::RequestHeader::default(), &[]).unwrap();
        let patience = Instant::now() + Duration::from_millis(nonce / FIRST_IDS * 11 % 80);
        while Instant::now() < patience {
            match pending.awaited.receive() {
                Ok(Some(part)) if pending.accept(part.user_header().plain()) => {
                    assert_eq!(part.user_header().plain().client, nonce);
                    own += 1;
                }
                Ok(Some(part)) => {
                    assert_ne!(part.user_header().plain().client, nonce);
                    foreign += 1;
                }
                _ => std::thread::sleep(Duration::from_millis(1)),
            }
        }
    }
    stop.store(true, Ordering::Relaxed);
    planner.join().unwrap();
    println!("{own} own replies, {foreign} of other clients dropped");
    assert!(own > 0);
}
