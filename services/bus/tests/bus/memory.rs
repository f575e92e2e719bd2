//! Shared memory is measured before it is used.

use bus::{OpenError, Server, ServerOptions, most_memory};

use crate::support::*;

/// What the planner's files can grow to is what was announced, or a little less.
#[track_caller]
fn check_announced(options: &ServerOptions) {
    let test = TestDomain::new();
    let server = Server::open(&test.domain, options).unwrap();
    let sizes = test.files().into_iter().filter(|path| path.starts_with("/dev/shm"));
    let created: u64 = sizes.map(|path| path.metadata().unwrap().len()).sum();
    let announced = most_memory(options);
    assert!(created <= announced, "{created} bytes created, {announced} announced");
    assert!(announced < created + created / 20 + (1 << 20), "{created}, {announced}");
    drop(server);
}

#[test]
fn the_announced_memory_is_what_can_be_used() {
    let default = ServerOptions::default();
    assert!(default.max_clients >= 64 && most_memory(&default) <= 128_000_000);
    check_announced(&ServerOptions::default());
    let (max_clients, requests_per_client, tap_buffer) = (3, 1, 16);
    let small =
        ServerOptions { max_clients, requests_per_client, tap_buffer, ..Default::default() };
    check_announced(&small);
    check_announced(&ServerOptions { max_recorders: 5, ..small });
}

#[test]
fn settings_that_ask_for_too_much_are_refused() {
    let test = TestDomain::new();
    let options = ServerOptions { tap_buffer: 1 << 40, ..ServerOptions::default() };
    let Err(OpenError::SharedMemory { needs, free }) = Server::open(&test.domain, &options) else {
        panic!("there is no such memory");
    };
    assert_eq!(needs, most_memory(&options));
    assert!(free < needs);
}
