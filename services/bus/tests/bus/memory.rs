//! Shared memory is measured before it is used.

use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;

use bus::{Client, OpenError, Server, ServerOptions, Wait, most_memory};

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

/// Files that could still lack memory.
fn sparse(test: &TestDomain) -> Vec<PathBuf> {
    let is_sparse = |path: &PathBuf| {
        let found = path.metadata().unwrap();
        found.blocks() * 512 < found.len()
    };
    let files = test.files().into_iter();
    files.filter(|path| path.starts_with("/dev/shm") && is_sparse(path)).collect()
}

#[test]
fn reserved_memory_is_there_from_the_start() {
    let test = TestDomain::new();
    let options = ServerOptions { max_clients: 2, tap_buffer: 16, ..Default::default() };
    let server = Server::open(&test.domain, &options).unwrap();
    assert!(sparse(&test).len() > 2);
    drop(server);
    let server = Server::open(&test.domain, &ServerOptions { reserve: true, ..options }).unwrap();
    assert_eq!(sparse(&test), Vec::<PathBuf>::new());
    // Clients take theirs when they connect.
    let client = Client::connect(&test.domain, Wait::Poll).unwrap();
    assert!(test.files().iter().any(|path| path.to_string_lossy().ends_with("__0.data")));
    assert_eq!(sparse(&test), Vec::<PathBuf>::new());
    drop((client, server));
}
