//! Clients of version 1 and of version 2 on one planner: the rolling upgrade.

use std::path::Path;
use std::sync::mpsc;
use std::time::Instant;

use bus::{
    Client, ConnectError, Incoming, ReplyError, ReplyOptions, Server, ServerOptions, TapEvent,
    TapMessage, TapReader, Wait,
};
use schemas::convert::{self, Certificate, TrajectoryWriter};
use schemas::message::{ErrorCode, Leg, Refusal, RequestContent, Rung, Trajectory};
use schemas::wire::{self, previous};

use crate::process::Process;
use crate::support::*;
use crate::version_1::{OldClient, OldPlanner};

#[test]
fn old_and_new_clients_are_served_side_by_side() {
    let test = TestDomain::new();
    let _planner = Planner::start(&test.domain, ServerOptions::default());
    let old = OldClient::connect(test.bare_node(), 5);
    let new = Client::connect(&test.domain, Wait::Event).unwrap();
    for id in 0..50 {
        let samples = id * 100;
        let open = new.send(&scene(id, samples)).unwrap();
        assert_eq!(old.call(&scene(id, samples)).content, Ok(trajectory(id, samples)));
        let mut open = open;
        let key = open.key();
        assert_eq!(open.wait(Instant::now() + LONG).unwrap(), reply(key, id, samples));
    }
}

#[test]
fn processes_of_both_versions_talk_to_one_planner() {
    let test = TestDomain::new();
    let planner = Process::start("planner", &test);
    let new = connect(&test.domain, Wait::Event);
    let old = Process::start("client of version 1", &test);
    for id in 0..200 {
        let answer = new.call(&scene(id, 2_000), LONG).unwrap();
        assert_eq!(answer, reply(answer.key, id, 2_000));
    }
    assert!(old.ends_within(LONG), "the old client's replies are those it knows");
    drop(planner);
}

/// The header and payload of a request that a client of version 1 sent.
fn pinned(name: &str) -> (wire::RequestHeader, Vec<u64>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../schemas/tests/pinned/version_1");
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    let (memory, _) = text.split_once("recorded\n").unwrap();
    let (header, cells) = memory.split_once("payload\n").unwrap();
    let words = |text: &str| -> Vec<u64> {
        text.split_whitespace().map(|word| u64::from_str_radix(word, 16).unwrap()).collect()
    };
    let header = words(header.trim_start_matches("header, words of 64 bits\n"));
    (convert::header_of(&header), words(cells))
}

#[test]
fn the_bytes_of_old_requests_are_read() {
    let test = TestDomain::new();
    let (say, said) = mpsc::channel();
    let _planner = Planner::start_with(&test.domain, ServerOptions::default(), move |incoming| {
        say.send((incoming.header(), read(incoming))).unwrap();
        answer(&wire::RequestHeader { sampling: 1, ..incoming.header() }, incoming)
    });
    let old = OldClient::connect(test.bare_node(), 5);
    for name in ["section-4", "assemble-from-solids", "three-dimensions", "drive", "curve"] {
        let (header, cells) = pinned(&format!("request-{name}.txt"));
        assert_eq!(header.version, 1);
        let pending = old.send(header, &cells);
        let (came, scene) = said.recv().unwrap();
        assert_eq!(came, wire::RequestHeader { version: 2, client: 5, wake: 1, ..header });
        assert!(scene.is_ok(), "{name}: {scene:?}");
        let (header, _) = old.receive(&pending);
        assert_eq!((header.version, header.last), (1, 1));
    }
}

fn refuse(incoming: &mut Incoming) -> Result<(), ReplyError> {
    incoming.copy(usize::MAX, &mut Vec::new()).unwrap();
    let wire::RequestHeader { client, sequence, .. } = incoming.header();
    let mut header =
        wire::ReplyHeader { version: wire::VERSION, client, sequence, ..Default::default() };
    convert::write_refusal(&too_costly(), &mut header, true, &mut incoming.reply())
}

fn too_costly() -> Refusal {
    Refusal {
        has: Some(20.0),
        setting: Some("caps.route_steps".to_owned()),
        field: Some("free_space".to_owned()),
        ..Refusal::new(ErrorCode::TooCostly, "more than 20 steps (caps.route_steps)")
    }
}

#[test]
fn what_version_1_does_not_know_is_told_in_its_words() {
    let test = TestDomain::new();
    let _planner = Planner::start_with(&test.domain, ServerOptions::default(), refuse);
    let mut tap = TapReader::connect(&test.domain).unwrap();

    let old = OldClient::connect(test.bare_node(), 5);
    let (header, cells) = old.receive(&old.ask(&scene(1, 1)));
    assert_eq!((header.version, header.kind, header.last), (1, 1, 1));
    assert_eq!(header.refusal as usize, cells.len());
    let [code, present, _, _, _, has, _, _, _, message, field, ..] = cells[..] else {
        panic!("{cells:?}");
    };
    let (has_bit, field_bit) = (1 << 3, 1 << 7);
    assert_eq!((code, present, has), (0, has_bit | field_bit, 20_f64.to_bits()));
    let text = bytemuck::cast_slice::<u64, u8>(&cells[11..]);
    let message_cells = message.div_ceil(8) as usize * 8;
    assert_eq!(&text[..message as usize], too_costly().message.as_bytes());
    assert_eq!(&text[message_cells..][..field as usize], b"free_space");
    assert_eq!(text.len(), message_cells + field.div_ceil(8) as usize * 8, "and nothing more");

    let new = Client::connect(&test.domain, Wait::Event).unwrap();
    let reply = new.call(&scene(2, 1), LONG).unwrap();
    assert_eq!(reply.answers, Err(too_costly()));

    // Recorders see the current version, whoever asked.
    let events: Vec<_> = std::iter::from_fn(|| tap.receive()).collect();
    assert_eq!(events.len(), 4, "{events:?}");
    for (index, event) in events.into_iter().enumerate() {
        match event {
            TapEvent::Message(TapMessage::Request(request)) => {
                let scene = scene(1 + index as u64 / 2, 1);
                assert_eq!(request.content, RequestContent::Scene(scene));
            }
            TapEvent::Message(TapMessage::Reply(part)) => {
                assert_eq!(part.content, Err(too_costly()));
            }
            other => panic!("{other:?}"),
        }
    }
}

/// Answers with all that a trajectory of version 2 has.
fn answer_in_full(incoming: &mut Incoming) -> Result<(), ReplyError> {
    incoming.copy(usize::MAX, &mut Vec::new()).unwrap();
    let wire::RequestHeader { client, sequence, .. } = incoming.header();
    let mut header = wire::ReplyHeader {
        version: wire::VERSION,
        dimension: 2,
        client,
        sequence,
        answers: 1,
        gaps_per_junction: 1,
        ..wire::ReplyHeader::default()
    };
    let certificate = Certificate { bound: Some(2.0), free_clearance: Some(0.5), complete: false };
    header.set_certificate(certificate);
    let leg = wire::Leg {
        kind: 1,
        rung: wire::Leg::rung_code(Some(Rung::Reverse)),
        reverse: 1,
        junction: u64::MAX,
        radius: 1.5,
        ..wire::Leg::default()
    };
    TrajectoryWriter {
        gaps: std::iter::once(0.1),
        route: [3, 4].into_iter(),
        channels: std::iter::once(boxed(1.0, 5.0)),
        legs: [leg, wire::Leg { radius: 2.5, ..leg }].into_iter(),
        samples: std::iter::once(wire::Sample { t: 1.0, ..wire::Sample::default() }),
    }
    .write(&mut header, true, &mut incoming.reply())
}

#[test]
fn trajectories_reach_old_clients_without_what_is_new() {
    let test = TestDomain::new();
    let _planner = Planner::start_with(&test.domain, ServerOptions::default(), answer_in_full);
    let mut tap = TapReader::connect(&test.domain).unwrap();
    let new = Client::connect(&test.domain, Wait::Event).unwrap();
    let whole = new.call(&scene(1, 1), LONG).unwrap().answers.unwrap().remove(0).unwrap();
    assert_eq!((whole.bound, whole.free_clearance, whole.complete), (Some(2.0), Some(0.5), false));
    assert!(whole.legs.iter().all(|leg| leg.reverse && leg.rung == Some(Rung::Reverse)));

    let old = OldClient::connect(test.bare_node(), 5).call(&scene(2, 1)).content.unwrap();
    let legs = whole.legs.iter().map(|leg| Leg { reverse: false, rung: None, ..*leg });
    let expected = Trajectory {
        bound: None,
        free_clearance: None,
        complete: true,
        legs: legs.collect(),
        ..whole.clone()
    };
    assert_eq!(old, expected);

    // Recorders see all of it, whoever asked.
    let replies = std::iter::from_fn(|| tap.receive()).filter_map(|event| match event {
        TapEvent::Message(TapMessage::Reply(part)) => Some(part.content.unwrap()),
        _ => None,
    });
    assert_eq!(replies.collect::<Vec<_>>(), [whole.clone(), whole]);
}

#[test]
fn neither_version_starves_the_other() {
    let test = TestDomain::new();
    let options = ServerOptions { requests_per_client: 4, ..ServerOptions::default() };
    let mut server = Server::open(&test.domain, &options).unwrap();
    let old = OldClient::connect(test.bare_node(), 5);
    let new = Client::connect(&test.domain, Wait::Poll).unwrap();
    let _old: Vec<_> = (0..4).map(|id| old.ask(&scene(id, 1))).collect();
    let _new: Vec<_> = (0..4).map(|id| new.send(&scene(id, 1)).unwrap()).collect();
    let next = || server.receive().map(|incoming| incoming.header().client == 5);
    let old: Vec<_> = std::iter::from_fn(next).collect();
    assert_eq!(old, [false, true, false, true, false, true, false, true]);
}

#[test]
fn clients_of_both_versions_share_the_places() {
    let test = TestDomain::new();
    let options = ServerOptions { max_clients: 2, ..ServerOptions::default() };
    let _planner = Planner::start(&test.domain, options);
    let old = OldClient::connect(test.bare_node(), 5);
    let new = Client::connect(&test.domain, Wait::Event).unwrap();
    let third = Client::connect(&test.domain, Wait::Event).unwrap_err();
    let name = test.domain.name();
    let said = format!(
        "2 clients are connected in domain {name}, the most this planner takes (`max_clients`)"
    );
    assert_eq!(third.to_string(), said);
    drop(old);
    let _third = Client::connect(&test.domain, Wait::Event).unwrap();
    new.call(&scene(1, 1), LONG).unwrap();
}

#[test]
fn an_older_planner_is_told_apart_from_none() {
    let test = TestDomain::new();
    let planner = OldPlanner::start(test.bare_node());
    let expected = ConnectError::OlderPlanner { domain: test.domain.clone(), planner: 1 };
    assert_eq!(Client::connect(&test.domain, Wait::Event).unwrap_err(), expected);
    assert_eq!(TapReader::connect(&test.domain).unwrap_err(), expected);
    let second = Server::open(&test.domain, &ServerOptions::default()).unwrap_err();
    assert_eq!(second.to_string(), format!("another planner serves domain {}", test.domain));
    drop(planner);
    let absent = Client::connect(&test.domain, Wait::Event).unwrap_err();
    assert_eq!(absent, ConnectError::NoPlanner { domain: test.domain.clone() });
}

/// The planner is upgraded while a client of version 1 keeps its connection.
#[test]
fn a_connected_old_client_outlives_the_upgrade() {
    let test = TestDomain::new();
    let planner = OldPlanner::start(test.bare_node());
    let old = OldClient::connect(test.bare_node(), 5);
    drop(planner);
    let _planner = Planner::start(&test.domain, ServerOptions::default());
    assert_eq!(old.call(&scene(7, 3)).content, Ok(trajectory(7, 3)));
    let new = Client::connect(&test.domain, Wait::Event).unwrap();
    new.call(&scene(1, 1), LONG).unwrap();
}

/// An old client that takes nothing does not hold up new ones.
#[test]
fn a_slow_old_client_holds_nobody_up() {
    let test = TestDomain::new();
    let options = ServerOptions {
        max_clients: 2,
        reply: ReplyOptions { patience: LONG },
        ..ServerOptions::default()
    };
    let long = 100_000;
    let _planner = Planner::start(&test.domain, options);
    let old = OldClient::connect(test.bare_node(), 5);
    let new = Client::connect(&test.domain, Wait::Event).unwrap();
    let _pending = old.ask(&scene(1, long));
    new.call(&scene(2, 1), LONG / 2).unwrap();
}

#[test]
fn the_frozen_names_are_those_of_version_1() {
    assert_eq!((previous::VERSION, previous::PLAN), (1, "clearway/plan"));
    assert_eq!(previous::LAYOUT_HASH, 0x35c7_081f_0ebf_6be2);
}
