//! What a recorder sees.

use std::time::{Duration, Instant};

use bus::{Client, Domain, Server, ServerOptions, TapEvent, TapMessage, TapReader, Wait};
use schemas::convert;
use schemas::message::{Digest, Reply, ReplyAssembler, RequestContent, RequestKey, SceneRequest};

use crate::process::Process;
use crate::support::*;

/// A planner and a client in one thread, so that what comes when is known.
struct Bus {
    server: Server,
    client: Client,
}

impl Bus {
    fn open(domain: &Domain, options: &ServerOptions) -> Self {
        let server = Server::open(domain, options).unwrap();
        Self { server, client: Client::connect(domain, Wait::Poll).unwrap() }
    }

    /// A round trip with a reply of one part: two messages.
    fn call(&mut self, scene: &SceneRequest) -> Reply {
        let mut pending = self.client.send(scene).unwrap();
        let mut incoming = self.server.receive().expect("the request is there");
        incoming.copy(usize::MAX, &mut Vec::new()).unwrap();
        answer(&incoming.header(), &mut incoming).unwrap();
        pending.wait(Instant::now() + LONG).unwrap()
    }

    /// Waits for the heartbeat.
    fn idle(&mut self) {
        let until = Instant::now() + Duration::from_millis(150);
        while Instant::now() < until {
            self.server.wait(None);
        }
    }
}

fn drain(tap: &mut TapReader) -> Vec<TapEvent> {
    std::iter::from_fn(|| tap.receive()).collect()
}

fn lost(events: &[TapEvent]) -> u64 {
    let lost = |event: &TapEvent| match event {
        TapEvent::Lost { messages } => *messages,
        _ => 0,
    };
    events.iter().map(lost).sum()
}

fn messages(events: &[TapEvent]) -> u64 {
    events.iter().filter(|event| matches!(event, TapEvent::Message(_))).count() as u64
}

#[test]
fn requests_and_replies_come_in_bus_order() {
    let test = TestDomain::new();
    let mut bus = Bus::open(&test.domain, &ServerOptions::default());
    let mut tap = TapReader::connect(&test.domain).unwrap();
    for id in 0..20 {
        let scene = scene(id, id * 22);
        let reply = bus.call(&scene);
        let [TapEvent::Message(first), TapEvent::Message(second)] = &drain(&mut tap)[..] else {
            panic!("two messages");
        };
        let TapMessage::Request(request) = first else { panic!("the request comes first") };
        assert_eq!((request.key, &request.content), (reply.key, &RequestContent::Scene(scene)));
        let TapMessage::Reply(part) = second.clone() else { panic!("then the reply") };
        assert_eq!(ReplyAssembler::default().push(part), Ok(Some(reply)));
    }
}

#[test]
fn long_requests_and_replies_are_put_together_again() {
    let test = TestDomain::new();
    let _planner = Planner::start(&test.domain, ServerOptions::default());
    let client = Client::connect(&test.domain, Wait::Hybrid).unwrap();
    let mut tap = TapReader::connect(&test.domain).unwrap();
    let mut scene = scene(1, 20_000);
    scene.free_space.channels =
        Some((0..30_000).map(|index| boxed(index.into(), f64::from(index) + 1.5)).collect());
    let reply = client.call(&scene, LONG).unwrap();
    let mut events = drain(&mut tap).into_iter();
    let Some(TapEvent::Message(TapMessage::Request(request))) = events.next() else {
        panic!("the request comes first");
    };
    assert_eq!(request.content, RequestContent::Scene(scene));
    let mut assembler = ReplyAssembler::default();
    let mut whole = None;
    for event in events {
        let TapEvent::Message(TapMessage::Reply(part)) = event else { panic!("{event:?}") };
        whole = assembler.push(part).unwrap();
    }
    assert_eq!(whole, Some(reply));
    assert_eq!(assembler.parts(), 44);
}

#[test]
fn a_slow_reader_counts_what_it_lost() {
    let test = TestDomain::new();
    let options = ServerOptions { tap_buffer: 8, ..ServerOptions::default() };
    let mut bus = Bus::open(&test.domain, &options);
    let mut tap = TapReader::connect(&test.domain).unwrap();
    bus.call(&scene(0, 1));
    assert_eq!(messages(&drain(&mut tap)), 2);
    for calls in [3, 4, 5, 40] {
        (0..calls).for_each(|id| drop(bus.call(&scene(id, 1))));
        let events = drain(&mut tap);
        let (came, lost) = (messages(&events), lost(&events));
        assert_eq!((came, lost), (8.min(2 * calls), (2 * calls).saturating_sub(8)));
        assert_eq!(matches!(events[0], TapEvent::Lost { .. }), lost > 0, "losses come first");
    }
}

#[test]
fn a_long_request_that_lost_a_piece_is_one_loss() {
    let test = TestDomain::new();
    let options = ServerOptions { tap_buffer: 8, ..ServerOptions::default() };
    let mut bus = Bus::open(&test.domain, &options);
    let mut tap = TapReader::connect(&test.domain).unwrap();
    bus.call(&scene(0, 1));
    drain(&mut tap);
    // Eight pieces and a reply: the first piece is lost.
    let mut scene = scene(1, 1);
    scene.free_space.channels = Some(vec![boxed(0.0, 1.0); 30_000]);
    bus.call(&scene);
    let events = drain(&mut tap);
    assert_eq!((messages(&events), lost(&events)), (1, 1));
}

#[test]
fn the_heartbeat_shows_a_loss_at_the_end() {
    let test = TestDomain::new();
    let options = ServerOptions { tap_buffer: 1, ..ServerOptions::default() };
    let mut bus = Bus::open(&test.domain, &options);
    let mut tap = TapReader::connect(&test.domain).unwrap();
    bus.call(&scene(0, 1));
    let events = drain(&mut tap);
    assert_eq!(messages(&events), 1, "the reply pushed the request out: {events:?}");
    // Two more messages, and the heartbeat pushes both out.
    bus.call(&scene(1, 1));
    bus.idle();
    let events = drain(&mut tap);
    assert_eq!((messages(&events), lost(&events)), (0, 2));
}

#[test]
fn a_restarted_planner_is_seen() {
    let test = TestDomain::new();
    let planner = Process::start("planner", &test);
    let client = connect(&test.domain, Wait::Event);
    let mut tap = TapReader::connect(&test.domain).unwrap();
    client.call(&scene(0, 1), LONG).unwrap();
    assert_eq!(messages(&drain(&mut tap)), 2);
    planner.kill();
    let _planner = Process::start("planner", &test);
    client.call(&scene(1, 1), LONG).unwrap();
    let events = drain(&mut tap);
    assert_eq!(events[0], TapEvent::Restarted);
    assert_eq!((messages(&events), lost(&events)), (2, 0));
}

#[test]
fn a_recorder_that_hangs_slows_nobody() {
    let test = TestDomain::new();
    let options = ServerOptions { tap_buffer: 4, max_recorders: 1, ..ServerOptions::default() };
    let mut bus = Bus::open(&test.domain, &options);
    let recorder = Process::start("recorder", &test);
    recorder.signal(rustix::process::Signal::STOP);
    let begin = Instant::now();
    (0..1_000).for_each(|id| drop(bus.call(&scene(id, 1))));
    assert!(begin.elapsed() < Duration::from_secs(5), "{:?}", begin.elapsed());
    recorder.kill();
    let _another = TapReader::connect(&test.domain).expect("the place is free again");
}

#[test]
fn each_recorder_is_shown_a_named_free_space_once() {
    let test = TestDomain::new();
    let mut bus = Bus::open(&test.domain, &ServerOptions::default());
    let mut upload = scene(1, 1);
    upload.free_space.channels = Some((0..3_000).map(|at| boxed(at.into(), 1e4)).collect());
    let name = upload.free_space.digest();
    upload.free_space.named = Some(name);
    assert!(!bus.server.recorders_lack(name), "nobody listens");
    let mut cells = Vec::new();
    let header = convert::write_scene(&upload, RequestKey::default(), 7, &mut cells).unwrap();
    assert!(cells.len() > 8_192, "it comes in pieces");
    let mut taps = Vec::new();
    for _ in 0..2 {
        taps.push(TapReader::connect(&test.domain).unwrap());
        assert!(bus.server.recorders_lack(name));
        assert!(bus.server.recorders_lack(Digest([7; 32])));
        bus.server.show_free_space(name, &header, &cells);
        assert!(!bus.server.recorders_lack(name));
        bus.call(&scene(2, 1));
        for tap in &mut taps {
            let events = drain(tap);
            let [TapEvent::FreeSpace(shown), ..] = &events[..] else { panic!("{events:?}") };
            assert_eq!(shown.content, RequestContent::Scene(upload.clone()));
            // It is none of the messages that are counted.
            assert_eq!((events.len(), messages(&events), lost(&events)), (3, 2, 0));
            assert_eq!(tap.waiting(), 0);
        }
    }
}

#[test]
fn a_free_space_that_would_push_messages_out_is_not_shown() {
    let test = TestDomain::new();
    let options = ServerOptions { tap_buffer: 4, ..ServerOptions::default() };
    let mut bus = Bus::open(&test.domain, &options);
    let mut tap = TapReader::connect(&test.domain).unwrap();
    let mut upload = scene(1, 1);
    upload.free_space.channels = Some((0..3_000).map(|at| boxed(at.into(), 1e4)).collect());
    let mut cells = Vec::new();
    let header = convert::write_scene(&upload, RequestKey::default(), 7, &mut cells).unwrap();
    bus.call(&scene(2, 1));
    bus.server.show_free_space(upload.free_space.digest(), &header, &cells);
    assert_eq!(messages(&drain(&mut tap)), 2);
}
