//! What a round trip through the planner costs beside a bare one: iceoryx2
//! request-response with the same payload sizes, in the same run, both sides polling.
//!
//! `cargo bench -p integration-tests --bench round_trip`

#[path = "bare.rs"]
mod bare;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use answer::{StopFlag, Workspace};
use bare::{Bare, reply_sizes, scene};
use bus::{Client, Domain, Server, ServerOptions, Wait};
use schemas::convert::write_scene;
use schemas::message::RequestKey;
use schemas::wire::{ReplyHeader, RequestHeader};

/// Rounds of both, alternating, so that a noisy moment hits both.
const ROUNDS: usize = 40;
const CALLS: usize = 500;

fn main() {
    println!("medians of {} calls; both sides poll\n", ROUNDS * CALLS);
    println!(
        "{:>8} {:>9} {:>9} {:>10} {:>10} {:>7}",
        "samples", "request", "reply", "bare", "planner", "ratio"
    );
    for samples in [2, 100, 1_000, 3_000] {
        measure(samples);
    }
}

fn measure(samples: u64) {
    let name = format!("bench-{}-{samples}", std::process::id());
    let domain = Domain::new(&name).expect("letters, digits and hyphens");
    let scene = scene(samples);
    let mut cells = Vec::new();
    let header = write_scene(&scene, RequestKey::default(), 0, &mut cells).expect("one dimension");
    let reply = reply_sizes(&scene);
    let stop = AtomicBool::new(false);
    let mut bare_times = Vec::with_capacity(ROUNDS * CALLS);
    let mut planner_times = Vec::with_capacity(ROUNDS * CALLS);

    let options = ServerOptions { wait: Wait::Poll, ..ServerOptions::default() };
    let mut server = Server::open(&domain, &options).expect("a domain of its own");
    let bare = Bare::new(&name);
    let bare_server = bare.server();
    std::thread::scope(|scope| {
        // Ports stay in the thread that made them.
        let clients = scope.spawn(|| {
            let client = Client::connect(&domain, Wait::Poll).expect("the server is up");
            let bare = Bare::new(&name);
            let bare_client = bare.client(cells.len());
            for _ in 0..ROUNDS {
                for _ in 0..CALLS {
                    let begin = Instant::now();
                    let request = bare_client.loan_slice_uninit(cells.len()).expect("a slot");
                    let pending =
                        request.write_from_slice(&cells).send().expect("the server is up");
                    for _ in 0..reply.len() {
                        while pending.receive().expect("the server is up").is_none() {
                            std::hint::spin_loop();
                        }
                    }
                    bare_times.push(begin.elapsed());
                }
                for _ in 0..CALLS {
                    let begin = Instant::now();
                    let pending = client.send_cells(header, &cells).expect("the server is up");
                    let mut last = false;
                    while !last {
                        let part = pending.receive(|header, _| header.last != 0);
                        last = part.expect("the server is up").unwrap_or(false);
                    }
                    planner_times.push(begin.elapsed());
                }
            }
            stop.store(true, Ordering::Release);
        });
        let mut workspace = Workspace::default();
        let mut memory = Vec::new();
        while !stop.load(Ordering::Acquire) {
            if let Some(mut incoming) = server.receive() {
                let header = incoming.copy(usize::MAX, &mut memory).expect("it is there");
                workspace
                    .answer(&header, &memory, &StopFlag::new(), &mut incoming.reply())
                    .expect("the client waits");
                incoming.finish().expect("the client waits");
            }
            if let Some(request) = bare_server.receive().expect("a healthy connection") {
                for cells in &reply {
                    let response = request.loan_slice_uninit(*cells).expect("a slot");
                    response.write_from_fn(|at| at as u64).send().expect("the client waits");
                }
            }
        }
        clients.join().expect("the clients' side");
    });
    drop(bare_server);
    bare.remove(&name);
    let (bare, planner) = (median(&mut bare_times), median(&mut planner_times));
    println!(
        "{samples:>8} {:>7} B {:>7} B {:>7.2} µs {:>7.2} µs {:>7.2}",
        cells.len() * 8 + size_of::<RequestHeader>(),
        reply.iter().map(|cells| cells * 8 + size_of::<ReplyHeader>()).sum::<usize>(),
        bare * 1e6,
        planner * 1e6,
        planner / bare
    );
}

fn median(times: &mut [Duration]) -> f64 {
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64()
}
