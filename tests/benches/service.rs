//! The planner as a service, beside iceoryx2 alone and a Unix-domain socket in the same run: round
//! trips by the way to wait, requests per second, a short request beside a long one, the tap.
//!
//! `cargo bench -p integration-tests --bench service [-- round-trip|rate|beside|recorder]`

#[path = "bare.rs"]
mod bare;

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::Barrier;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use bare::{Bare, BareServer, reply_sizes, scene};
use bus::{Client, TapReader, Wait};
use integration_tests::load::endless;
use integration_tests::{LONG, Process, TestDomain};
use schemas::convert::write_scene;
use schemas::message::RequestKey;
use schemas::wire::{ReplyHeader, RequestHeader};

/// Calls in a row, of each kind by turns.
const ROUND: usize = 2_000;
const ROUNDS: usize = 10;

/// How long requests per second are counted.
const COUNTED: Duration = Duration::from_secs(2);

fn main() {
    let parts: [(&str, fn()); 4] = [
        ("round-trip", round_trips),
        ("rate", requests_per_second),
        ("beside", beside_a_long_one),
        ("recorder", with_a_recorder),
    ];
    let chosen: Vec<_> = std::env::args().skip(1).filter(|name| !name.starts_with('-')).collect();
    for (name, part) in parts {
        if chosen.is_empty() || chosen.iter().any(|chosen| chosen == name) {
            part();
        }
    }
}

/// A planner process with these settings.
fn planner(test: &TestDomain, settings: &str) -> Process {
    test.write("planner.toml", settings);
    test.planner(&["--config", "planner.toml"])
}

/// A request as it lies in memory.
fn memory(samples: u64) -> (RequestHeader, Vec<u64>) {
    let mut cells = Vec::new();
    let header = write_scene(&scene(samples), RequestKey::default(), 0, &mut cells);
    (header.expect("one dimension"), cells)
}

fn timed(times: &mut Vec<Duration>, call: impl FnOnce()) {
    let begun = Instant::now();
    call();
    times.push(begun.elapsed());
}

/// Times as many calls as all rounds have.
fn all_timed(mut call: impl FnMut()) -> Vec<Duration> {
    let mut times = Vec::with_capacity(ROUND * ROUNDS);
    for _ in 0..ROUND * ROUNDS {
        timed(&mut times, &mut call);
    }
    times
}

/// Microseconds that so many of the times do not exceed.
fn quantile(times: &mut [Duration], quantile: f64) -> f64 {
    times.sort_unstable();
    let at = (quantile * times.len() as f64) as usize;
    times[at.min(times.len() - 1)].as_secs_f64() * 1e6
}

fn line(what: &str, times: &mut [Duration]) {
    let [half, most, nearly] = [0.5, 0.99, 0.999].map(|at| quantile(times, at));
    println!("{what:<44} {half:>9.1} {most:>9.1} {nearly:>9.1}");
}

fn heading(what: &str) {
    println!("\n{what:<44} {:>9} {:>9} {:>9}", "p50, µs", "p99", "p99.9");
}

/// Sends a request and takes its reply, looking for it without a pause, or giving the core away.
fn poll(client: &Client, (header, cells): &(RequestHeader, Vec<u64>), pause: fn()) {
    let pending = client.send_cells(*header, cells).expect("the planner is up");
    let mut last = false;
    while !last {
        let part = pending.receive(|header, _| header.last != 0).expect("the planner is up");
        last = part.unwrap_or_else(|| {
            pause();
            false
        });
    }
}

/// The same without a planner.
fn poll_bare(client: &bare::BareClient, cells: &[u64], parts: usize, pause: fn()) {
    let request = client.loan_slice_uninit(cells.len()).expect("a slot");
    let pending = request.write_from_slice(cells).send().expect("the server is up");
    for _ in 0..parts {
        while pending.receive().expect("the server is up").is_none() {
            pause();
        }
    }
}

/// Answers what waits, with payloads that are written but not computed.
fn serve_bare(server: &BareServer, reply: &[usize]) {
    while let Some(request) = server.receive().expect("a healthy connection") {
        for cells in reply {
            // While its client has all it can hold.
            while let Ok(response) = request.loan_slice_uninit(*cells) {
                if response.write_from_fn(|at| at as u64).send().is_ok() {
                    break;
                }
            }
        }
    }
}

fn round_trips() {
    heading("round trip");
    for samples in [2, 1_000] {
        let request = memory(samples);
        let reply = reply_sizes(&scene(samples));
        for (name, how) in [("poll", Wait::Poll), ("hybrid", Wait::Hybrid), ("event", Wait::Event)]
        {
            let test = TestDomain::new();
            let _planner = planner(&test, &format!("wait = {name:?}"));
            let client = Client::connect(&test.domain(), how).expect("the planner is up");
            let mut times = all_timed(|| match how {
                Wait::Poll => poll(&client, &request, std::hint::spin_loop),
                _ => {
                    let mut pending =
                        client.send_cells(request.0, &request.1).expect("the planner is up");
                    while !pending.wait_part(Instant::now() + LONG).expect("a part").last {}
                }
            });
            line(&format!("{samples} samples, {name}"), &mut times);
        }
        bare_round_trips(samples, &request.1, &reply);
        socket_round_trips(samples, &request.1, &reply);
    }
}

fn bare_round_trips(samples: u64, cells: &[u64], reply: &[usize]) {
    let (name, stop) =
        (format!("service-{}-{samples}", std::process::id()), AtomicBool::new(false));
    let floor = Bare::new(&name);
    let server = floor.server();
    thread::scope(|scope| {
        let calls = scope.spawn(|| {
            let floor = Bare::new(&name);
            let client = floor.client(cells.len());
            let times = all_timed(|| poll_bare(&client, cells, reply.len(), std::hint::spin_loop));
            stop.store(true, Ordering::Release);
            times
        });
        while !stop.load(Ordering::Acquire) {
            serve_bare(&server, reply);
        }
        line(
            &format!("{samples} samples, iceoryx2 alone, poll"),
            &mut calls.join().expect("calls"),
        );
    });
    drop(server);
    floor.remove(&name);
}

fn socket_round_trips(samples: u64, cells: &[u64], reply: &[usize]) {
    let request = vec![1_u8; size_of_val(cells) + size_of::<RequestHeader>()];
    let reply: usize = reply.iter().map(|cells| cells * 8 + size_of::<ReplyHeader>()).sum();
    let (mut ours, mut theirs) = UnixStream::pair().expect("sockets");
    thread::scope(|scope| {
        let length = request.len();
        scope.spawn(move || {
            let (mut request, reply) = (vec![0; length], vec![1_u8; reply]);
            while theirs.read_exact(&mut request).is_ok() {
                theirs.write_all(&reply).expect("the client is there");
            }
        });
        let mut answer = vec![0; reply];
        let mut times = all_timed(|| {
            ours.write_all(&request).expect("the server is there");
            ours.read_exact(&mut answer).expect("the server is there");
        });
        line(&format!("{samples} samples, bytes over a Unix socket"), &mut times);
        drop(ours);
    });
}

fn requests_per_second() {
    println!("\n{:<44} {:>12}", "1,000 samples, polling and yielding", "requests/s");
    let request = memory(1_000);
    let reply = reply_sizes(&scene(1_000));
    for clients in [1, 8, 64] {
        for workers in [1, 2] {
            let test = TestDomain::new();
            let _planner = planner(&test, &format!("wait = \"poll\"\nworkers = {workers}"));
            let rate = rate(clients, || {
                let client = Client::connect(&test.domain(), Wait::Poll).expect("a place");
                let request = &request;
                move || poll(&client, request, thread::yield_now)
            });
            println!("{:<44} {rate:>12.0}", format!("{clients} clients, {workers} workers"));
        }
        let name = format!("rate-{}-{clients}", std::process::id());
        let (floor, stop) = (Bare::new(&name), AtomicBool::new(false));
        let server = floor.server();
        let rate = thread::scope(|scope| {
            let counted = scope.spawn(|| {
                let counted = rate(clients, || {
                    let floor = Bare::new(&name);
                    let client = floor.client(request.1.len());
                    let (cells, parts) = (&request.1, reply.len());
                    move || {
                        let _lives = &floor;
                        poll_bare(&client, cells, parts, thread::yield_now);
                    }
                });
                stop.store(true, Ordering::Release);
                counted
            });
            while !stop.load(Ordering::Acquire) {
                serve_bare(&server, &reply);
            }
            counted.join().expect("it counts")
        });
        println!("{:<44} {rate:>12.0}", format!("{clients} clients, iceoryx2 alone"));
        drop(server);
        floor.remove(&name);
    }
}

/// Calls per second of so many clients, each in a thread of its own.
fn rate<C: FnMut()>(clients: usize, connect: impl Fn() -> C + Sync) -> f64 {
    let (stop, count, ready) =
        (AtomicBool::new(false), AtomicU64::new(0), Barrier::new(clients + 1));
    thread::scope(|scope| {
        for _ in 0..clients {
            scope.spawn(|| {
                // Ports stay in the thread that made them.
                let mut call = connect();
                ready.wait();
                let mut calls = 0;
                while !stop.load(Ordering::Relaxed) {
                    call();
                    calls += 1;
                }
                count.fetch_add(calls, Ordering::Relaxed);
            });
        }
        ready.wait();
        thread::sleep(COUNTED);
        stop.store(true, Ordering::Relaxed);
    });
    count.load(Ordering::Relaxed) as f64 / COUNTED.as_secs_f64()
}

fn beside_a_long_one() {
    heading("2 samples, hybrid, 1 worker");
    let test = TestDomain::new();
    let _planner = planner(&test, "workers = 1");
    let client = Client::connect(&test.domain(), Wait::Hybrid).expect("the planner is up");
    let busy = Client::connect(&test.domain(), Wait::Hybrid).expect("the planner is up");
    let request = scene(2);
    let calls = |what| {
        line(what, &mut all_timed(|| drop(client.call(&request, LONG).expect("an answer"))));
    };
    calls("alone");
    let mut long = busy.send(&endless(1)).expect("the planner is up");
    long.wait_part(Instant::now() + LONG).expect("it has begun");
    calls("while another client's map is planned");
}

/// What a recorder costs that keeps up. It reads between the calls: on two cores, one that runs
/// beside them would take time from the planner or its client.
fn with_a_recorder() {
    heading("poll");
    let test = TestDomain::new();
    let _planner = planner(&test, "wait = \"poll\"");
    let client = Client::connect(&test.domain(), Wait::Poll).expect("the planner is up");
    for samples in [2, 100, 1_000] {
        let request = memory(samples);
        let (mut without, mut with) = (Vec::new(), Vec::new());
        for _ in 0..ROUNDS {
            for _ in 0..ROUND {
                timed(&mut without, || poll(&client, &request, std::hint::spin_loop));
            }
            let mut recorder = TapReader::connect(&test.domain()).expect("a place for a recorder");
            for _ in 0..ROUND {
                timed(&mut with, || poll(&client, &request, std::hint::spin_loop));
                while recorder.receive().is_some() {}
            }
        }
        line(&format!("{samples} samples, without a recorder"), &mut without);
        line(&format!("{samples} samples, with one"), &mut with);
    }
}
