//! Memory that nobody should write.

use std::sync::mpsc;
use std::time::Instant;

use bus::{Client, ConnectError, ServerOptions, Wait};
use iceoryx2::service::builder::request_response::RequestResponseOpenError;
use proptest::prelude::*;
use schemas::convert;
use schemas::message::RequestKey;
use schemas::wire::RequestHeader;

use crate::support::*;

/// Headers from noise; mostly with small counts, so that not all fail at once.
fn header() -> impl Strategy<Value = RequestHeader> {
    let word = prop_oneof![4 => 0..4u64, 1 => any::<u64>(), 1 => Just(u64::MAX)];
    let words = proptest::collection::vec(word, size_of::<RequestHeader>() / 8);
    (words, any::<bool>()).prop_map(|(words, two)| {
        let mut header: RequestHeader = bytemuck::pod_read_unaligned(bytemuck::cast_slice(&words));
        if two {
            (header.version, header.dimension) = (schemas::wire::VERSION, 2);
            (header.task, header.exits, header.body_kind, header.wish_kind) = (0, 0, 0, 0);
        }
        header
    })
}

fn cells() -> impl Strategy<Value = Vec<u64>> {
    let cell = prop_oneof![4 => 0..4u64, 1 => any::<u64>(), 1 => Just(u64::MAX)];
    proptest::collection::vec(cell, 0..200)
}

#[test]
fn noise_is_refused_and_harms_nobody() {
    let test = TestDomain::new();
    let (say, said) = mpsc::channel();
    let _planner = Planner::start_with(&test.domain, ServerOptions::default(), move |incoming| {
        say.send((incoming.header(), incoming.cells(), read(incoming))).unwrap();
        answer(&RequestHeader { sampling: 1, ..incoming.header() }, incoming)
    });
    let client = Client::connect(&test.domain, Wait::Hybrid).unwrap();
    let readable = std::cell::Cell::new(0);
    proptest!(ProptestConfig::with_cases(2_000), |(header in header(), cells in cells())| {
        let mut pending = client.send_cells(header, &cells).unwrap();
        let key = pending.key();
        pending.wait(Instant::now() + LONG).unwrap();
        let (came, length, scene) = said.recv().unwrap();
        prop_assert_eq!(RequestKey { client: came.client, sequence: came.sequence }, key);
        prop_assert_eq!(length, cells.len());
        if let Ok(scene) = scene {
            // What can be read takes no more than a small multiple of what was sent.
            readable.set(readable.get() + 1);
            let solids = scene.free_space.solids.iter().flatten().count();
            let channels = scene.free_space.channels.iter().flatten().count();
            prop_assert!(solids + channels + scene.exit.len() <= cells.len());
        }
        // The recorder reads the same memory.
        convert::read_request(&header, &cells);
    });
    client.call(&scene(1, 1), LONG).unwrap();
}

/// A client of another layout, by iceoryx2's own ports.
mod other {
    use iceoryx2::prelude::*;

    #[derive(Debug, Default, Clone, Copy, ZeroCopySend)]
    #[repr(C)]
    #[type_name("clearway::RequestHeader#0000000000000000")]
    pub(crate) struct RequestHeader([u64; 32], [u64; 26]);

    #[derive(Debug, Default, Clone, Copy, ZeroCopySend)]
    #[repr(C)]
    #[type_name("clearway::ReplyHeader#0000000000000000")]
    pub(crate) struct ReplyHeader([u64; 24]);

    pub(crate) type Builder = iceoryx2::service::builder::request_response::Builder<
        [u64],
        RequestHeader,
        [u64],
        ReplyHeader,
        ipc::Service,
    >;
}

/// The planning service of the other layout, opened or created.
fn other_service<T>(test: &TestDomain, open: impl FnOnce(other::Builder) -> T) -> T {
    assert_eq!(size_of::<other::RequestHeader>(), size_of::<RequestHeader>());
    assert_eq!(size_of::<other::ReplyHeader>(), size_of::<schemas::wire::ReplyHeader>());
    let node = test.bare_node();
    open(
        node.service_builder(&schemas::topic::PLAN.try_into().unwrap())
            .request_response::<[u64], [u64]>()
            .request_user_header::<other::RequestHeader>()
            .response_user_header::<other::ReplyHeader>(),
    )
}

#[test]
fn a_client_of_another_layout_does_not_connect() {
    let test = TestDomain::new();
    let _planner = Planner::start(&test.domain, ServerOptions::default());
    let opened = other_service(&test, |builder| builder.open().map(drop));
    assert_eq!(opened, Err(RequestResponseOpenError::IncompatibleRequestOrResponseType));
}

#[test]
fn a_planner_of_another_layout_is_told_apart_from_none() {
    let test = TestDomain::new();
    let _planner = other_service(&test, |builder| builder.create().unwrap());
    let client = Client::connect(&test.domain, Wait::Hybrid);
    assert!(matches!(client, Err(ConnectError::OtherLayout { .. })), "{client:?}");
}
