//! Peers that write what they like into shared memory, and processes that are killed.

use std::time::{Duration, Instant};

use bus::{CallError, Client, Wait};
use iceoryx2::prelude::*;
use integration_tests::{LONG, Signal, TestDomain, kill_pid, scene, serving, wait_for};
use schemas::message::SceneRequest;

/// A request's header in version 1, which every planner serves as well.
#[derive(Debug, Default, Clone, Copy, ZeroCopySend)]
#[repr(C)]
#[type_name("clearway::RequestHeader#35c7081f0ebf6be2")]
struct RawRequest([[u64; 17]; 2]);

#[derive(Debug, Default, Clone, Copy, ZeroCopySend)]
#[repr(C)]
#[type_name("clearway::ReplyHeader#35c7081f0ebf6be2")]
struct RawReply([u64; 19]);

/// Where iceoryx2 keeps its own fields of a request (`service/header/request_response.rs`), in
/// cells of 8 bytes: node and client (two each), channel, request, count of elements.
const CHANNEL: usize = 4;
const ELEMENTS: usize = 6;

/// Sends a request of `cells` cells, after `spoil` has had iceoryx2's header of it.
fn send_raw(test: &TestDomain, cells: usize, spoil: impl FnOnce(&mut [u64; 8])) {
    let settings = test.root().join(format!("{}.toml", test.domain().name()));
    let settings = FilePath::new(settings.as_os_str().as_encoded_bytes()).unwrap();
    let config = Config::from_file(&settings).unwrap();
    let node = NodeBuilder::new().config(&config).create::<ipc::Service>().unwrap();
    let service = node
        .service_builder(&"clearway/plan".try_into().unwrap())
        .request_response::<[u64], [u64]>()
        .request_user_header::<RawRequest>()
        .response_user_header::<RawReply>()
        .open()
        .unwrap();
    let client = service.client_builder().initial_max_slice_len(cells.max(1)).create().unwrap();
    let request = client.loan_slice_uninit(cells).unwrap().write_from_fn(|_| 0);
    let header = std::ptr::from_ref(request.header()).cast_mut().cast::<[u64; 8]>();
    #[expect(unsafe_code, reason = "a peer can write what it likes into its own memory")]
    // SAFETY: the header is 64 bytes of memory that this process has mapped to write, and nothing
    // here reads it meanwhile.
    unsafe {
        let mut words = header.read();
        spoil(&mut words);
        header.write(words);
    }
    let pending = request.send();
    // It stays until the planner has had a look.
    std::thread::sleep(Duration::from_millis(100));
    drop(pending);
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
        send_raw(&test, 4, |header| {
            assert_eq!(header[ELEMENTS], 4, "the header is as expected");
            header[ELEMENTS] = count;
        });
        check_serves(&test);
    }
    assert_eq!(serving(&test), before, "the serving process lives on");
}

/// iceoryx2 panics where it takes such a request.
#[test]
fn a_false_channel_costs_the_serving_process_only() {
    let test = TestDomain::new();
    let mut planner = test.planner(&[]);
    for _ in 0..2 {
        let before = serving(&test);
        send_raw(&test, 4, |header| header[CHANNEL] = 100);
        planner.wait_until_it_says("starting another");
        check_serves(&test);
        assert_ne!(serving(&test), before);
    }
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
