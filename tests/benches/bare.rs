//! The floor of both benches: iceoryx2 alone, with the sizes of the planner's messages.

use answer::{StopFlag, Workspace};
use bus::ServerOptions;
use iceoryx2::prelude::{
    AllocationStrategy, Config, FileName, NodeBuilder, SemanticString, ZeroCopySend, ipc,
};
use iceoryx2::service::port_factory::request_response::PortFactory;
use schemas::convert::{CellWriter, PartSink, write_scene};
use schemas::json::read_scene;
use schemas::message::{ClearanceWish, Gap, RequestKey, Sampling, SceneRequest};
use schemas::wire::{PART_CELLS, ReplyHeader, RequestHeader};

/// Section 4 at gap 0.2, with this many samples.
pub(crate) fn scene(samples: u64) -> SceneRequest {
    let text = include_str!("../../recordings/scenes/disassemble-channels.json");
    SceneRequest {
        clearance: ClearanceWish::Gap(Gap::Uniform(0.2)),
        sampling: Some(Sampling::Count(samples)),
        ..read_scene(text).expect("the project's own scene")
    }
}

/// Cells of each part of the planner's reply.
pub(crate) fn reply_sizes(scene: &SceneRequest) -> Vec<usize> {
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
pub(crate) struct Bare {
    service: BareService,
}

impl Bare {
    pub(crate) fn new(name: &str) -> Self {
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
            // Each client brings a node of its own; one is the server's, one whoever removes it.
            .max_nodes(options.max_clients + 2)
            .max_active_requests_per_client(options.requests_per_client)
            .max_response_buffer_size(8)
            .open_or_create()
            .expect("a service of its own");
        Self { service }
    }

    pub(crate) fn server(&self) -> BareServer {
        self.service
            .server_builder()
            .initial_max_slice_len(PART_CELLS)
            .allocation_strategy(AllocationStrategy::Static)
            .create()
            .expect("the only server")
    }

    pub(crate) fn client(&self, cells: usize) -> BareClient {
        self.service.client_builder().initial_max_slice_len(cells).create().expect("a place")
    }

    /// Leaves; iceoryx2 leaves a file of 16 bytes behind.
    pub(crate) fn remove(self, name: &str) {
        drop(self.service);
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
}

/// As long as a [`RequestHeader`], in arrays that have a default.
#[derive(Debug, Default, Clone, Copy, ZeroCopySend)]
#[repr(C)]
pub(crate) struct BareRequest {
    first: [u64; 32],
    rest: [u64; size_of::<RequestHeader>() / 8 - 32],
}

/// As long as a [`ReplyHeader`].
pub(crate) type BareReply = [u64; size_of::<ReplyHeader>() / 8];

pub(crate) type BareService = PortFactory<ipc::Service, [u64], BareRequest, [u64], BareReply>;
pub(crate) type BareServer =
    iceoryx2::port::server::Server<ipc::Service, [u64], BareRequest, [u64], BareReply>;
pub(crate) type BareClient =
    iceoryx2::port::client::Client<ipc::Service, [u64], BareRequest, [u64], BareReply>;

fn bare_prefix(name: &str) -> String {
    format!("bare_{name}_")
}
