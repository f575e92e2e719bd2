//! What a round trip through the planner costs beside a bare one: iceoryx2
//! request-response with the same payload sizes, in the same run, both sides polling.
//!
//! `cargo bench -p integration-tests --bench round_trip`

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use answer::{StopFlag, Workspace};
use bus::{Client, Domain, Server, ServerOptions, Wait};
use iceoryx2::prelude::{
    AllocationStrategy, Config, FileName, NodeBuilder, SemanticString, ZeroCopySend, ipc,
};
use iceoryx2::service::port_factory::request_response::PortFactory;
use schemas::convert::{CellWriter, PartSink, write_scene};
use schemas::json::read_scene;
use schemas::message::{ClearanceWish, Gap, RequestKey, Sampling, SceneRequest};
use schemas::wire::{PART_CELLS, ReplyHeader, RequestHeader};

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

/// Section 4 at gap 0.2, with this many samples.
fn scene(samples: u64) -> SceneRequest {
    let text = include_str!("../../recordings/scenes/disassemble-channels.json");
    SceneRequest {
        clearance: ClearanceWish::Gap(Gap::Uniform(0.2)),
        sampling: Some(Sampling::Count(samples)),
        ..read_scene(text).expect("the project's own scene")
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
    drop((bare_server, bare));
    remove_last_file(&name);
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

/// iceoryx2 leaves a file of 16 bytes behind in every domain.
fn remove_last_file(name: &str) {
    let prefix = bare_prefix(name);
    for entry in std::fs::read_dir("/dev/shm").expect("shared memory is a directory") {
        let entry = entry.expect("it can be read");
        if entry.file_name().to_string_lossy().starts_with(&prefix) {
            std::fs::remove_file(entry.path()).expect("the file is ours");
        }
    }
    let global = Config::default().global;
    for directory in [global.node_dir(), global.service_dir()] {
        // If it is not empty, somebody else is there.
        let _ = std::fs::remove_dir(directory.to_string());
    }
}

fn bare_prefix(name: &str) -> String {
    format!("bare_{name}_")
}

fn median(times: &mut [Duration]) -> f64 {
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64()
}

/// Cells of each part of the planner's reply.
fn reply_sizes(scene: &SceneRequest) -> Vec<usize> {
    struct Sizes(Vec<usize>);
    impl PartSink for Sizes {
        type Error = std::convert::Infallible;

        fn part(
            &mut self,
            _: &ReplyHeader,
            cells: usize,
            fill: impl FnOnce(&mut CellWriter),
        ) -> Result<(), Self::Error> {
            fill(&mut CellWriter::new(&mut vec![0; cells]));
            self.0.push(cells);
            Ok(())
        }
    }
    let mut cells = Vec::new();
    let header = write_scene(scene, RequestKey::default(), 0, &mut cells).expect("one dimension");
    let mut sizes = Sizes(Vec::new());
    let Ok(()) = Workspace::default().answer(&header, &cells, &StopFlag::new(), &mut sizes);
    sizes.0
}

/// The floor: iceoryx2 alone, headers of the same sizes, payloads written but not computed.
struct Bare {
    service: BareService,
}

impl Bare {
    fn new(name: &str) -> Self {
        let mut config = Config::default();
        config.global.prefix = FileName::new(bare_prefix(name).as_bytes()).expect("a name");
        let node = NodeBuilder::new().config(&config).create::<ipc::Service>().expect("a node");
        let options = ServerOptions::default();
        let service = node
            .service_builder(&"bare".try_into().expect("a name"))
            .request_response::<[u64], [u64]>()
            .request_user_header::<BareRequest>()
            .response_user_header::<BareReply>()
            .enable_safe_overflow_for_requests(false)
            .enable_safe_overflow_for_responses(false)
            .max_servers(1)
            // As the planner's: every look at a port looks at each of its places.
            .max_clients(options.max_clients)
            .max_active_requests_per_client(options.requests_per_client)
            .max_response_buffer_size(8)
            .open_or_create()
            .expect("a service of its own");
        Self { service }
    }

    fn server(&self) -> BareServer {
        self.service
            .server_builder()
            .initial_max_slice_len(PART_CELLS)
            .allocation_strategy(AllocationStrategy::Static)
            .create()
            .expect("the only server")
    }

    fn client(&self, cells: usize) -> BareClient {
        self.service.client_builder().initial_max_slice_len(cells).create().expect("a place")
    }
}

/// As long as a [`RequestHeader`], in arrays that have a default.
#[derive(Debug, Default, Clone, Copy, ZeroCopySend)]
#[repr(C)]
struct BareRequest {
    first: [u64; 32],
    rest: [u64; size_of::<RequestHeader>() / 8 - 32],
}

/// As long as a [`ReplyHeader`].
type BareReply = [u64; size_of::<ReplyHeader>() / 8];

type BareService = PortFactory<ipc::Service, [u64], BareRequest, [u64], BareReply>;
type BareServer =
    iceoryx2::port::server::Server<ipc::Service, [u64], BareRequest, [u64], BareReply>;
type BareClient =
    iceoryx2::port::client::Client<ipc::Service, [u64], BareRequest, [u64], BareReply>;
