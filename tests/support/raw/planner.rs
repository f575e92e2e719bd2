//! A planner that lies to its clients.

use std::fs::DirBuilder;
use std::os::unix::fs::DirBuilderExt;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use bus::Domain;
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::{Config, FilePath, Node, NodeBuilder, SemanticString, ipc};
use iceoryx2::service::port_factory::event;
use iceoryx2::service::port_factory::request_response::PortFactory;
use schemas::{topic, wire};

use super::{OtherReply, OtherRequest, Reply, Request};

type Service = PortFactory<ipc::Service, [u64], Request, [u64], Reply>;
type OtherService = PortFactory<ipc::Service, [u64], OtherRequest, [u64], OtherReply>;
type Port = Server<ipc::Service, [u64], Request, [u64], Reply>;
type Failure = Box<dyn std::error::Error>;

/// What is wrong with its replies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lie {
    /// Its messages have another layout.
    Layout,
    /// They say that they are of a version to come.
    Version,
    /// They have fewer cells than their headers say.
    Truncated,
    /// They have more cells.
    Trailing,
    /// The library's own count of cells goes beyond the memory.
    Elements,
}

impl Lie {
    /// All of them, and what a client says.
    pub const ALL: [(Self, &str, &str); 5] = [
        (Self::Layout, "layout", "has another layout of version 2 of the messages"),
        (Self::Version, "version", "version is 99; the greatest known value is 2"),
        (Self::Truncated, "truncated", "samples needs 900 cells, 9 are left"),
        (Self::Trailing, "trailing", "9 cells follow the end of the message"),
        (Self::Elements, "elements", "a part claims 1099511627776 cells, but has at most 4096"),
    ];
}

impl FromStr for Lie {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::ALL.iter().find(|(_, known, _)| *known == name);
        found.map(|(lie, ..)| *lie).ok_or_else(|| format!("{name} is no lie"))
    }
}

/// Answers each request with the same lie.
#[derive(Debug)]
pub struct RawPlanner {
    lie: Lie,
    server: Option<Port>,
    _other: Option<OtherService>,
    _service: Option<Service>,
    _bells: [event::PortFactory<ipc::Service>; 2],
    node: Node<ipc::Service>,
    // Dropped last.
    _files: Files,
}

/// What makes up the domain; removed in the end, as by whoever leaves a domain last.
#[derive(Debug)]
struct Files {
    settings: PathBuf,
    directory: PathBuf,
    prefix: String,
}

impl Drop for Files {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.settings);
        let _ = std::fs::remove_dir_all(&self.directory);
        for entry in std::fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(&self.prefix) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
}

impl RawPlanner {
    /// Begins to serve a domain that nobody is in.
    pub fn open(domain: &Domain, lie: Lie) -> Result<Self, Failure> {
        let root = domain.root()?;
        DirBuilder::new().recursive(true).mode(0o700).create(&root)?;
        let settings = root.join(format!("{}.toml", domain.name()));
        // Eight letters, as domains have them; whoever kills it can tell its files by its process.
        let digits = format!("{:05}", std::process::id() % 100_000);
        let letters = digits.bytes().map(|digit| char::from(digit - b'0' + b'a'));
        let name: String = "raw".chars().chain(letters).collect();
        let directory = root.join(&name);
        let text = format!(
            "# A domain of Clearway. As config/iceoryx2.toml it shows the domain to iceoryx2's tools.\n\
             [global]\nroot-path = {directory:?}\nprefix = \"cw_{name}_\"\n"
        );
        std::fs::write(&settings, text)?;
        let files = Files {
            settings: settings.clone(),
            directory: directory.clone(),
            prefix: format!("cw_{name}_"),
        };
        let settings = FilePath::new(settings.as_os_str().as_encoded_bytes())?;
        let config = Config::from_file(&settings)?;
        let node = NodeBuilder::new().config(&config).create::<ipc::Service>()?;
        let bell = |name: &str| -> Result<_, Failure> {
            Ok(node.service_builder(&name.try_into()?).event().max_nodes(8).create()?)
        };
        let bells = [bell(topic::WAKE)?, bell(topic::ANSWERED)?];
        let plan =
            node.service_builder(&topic::PLAN.try_into()?).request_response::<[u64], [u64]>();
        let (mut service, mut server, mut other) = (None, None, None);
        if lie == Lie::Layout {
            let plan = plan.request_user_header::<OtherRequest>();
            other = Some(plan.response_user_header::<OtherReply>().create()?);
        } else {
            let plan = plan.request_user_header::<Request>().response_user_header::<Reply>();
            let made = plan
                .enable_fire_and_forget_requests(false)
                .enable_safe_overflow_for_requests(false)
                .enable_safe_overflow_for_responses(false)
                .max_servers(1)
                .max_clients(8)
                .max_nodes(12)
                .max_borrowed_responses_per_pending_response(8)
                .create()?;
            server = Some(made.server_builder().initial_max_slice_len(wire::PART_CELLS).create()?);
            service = Some(made);
        }
        Ok(Self {
            lie,
            server,
            _other: other,
            _service: service,
            _bells: bells,
            node,
            _files: files,
        })
    }

    /// Answers what has come, and waits a little.
    pub fn serve(&self) -> Result<(), Failure> {
        if let Some(server) = &self.server {
            while let Some(request) = server.receive()? {
                self.answer(&request)?;
            }
        }
        Ok(self.node.wait(Duration::from_millis(2))?)
    }

    fn answer(
        &self,
        request: &ActiveRequest<ipc::Service, [u64], Request, [u64], Reply>,
    ) -> Result<(), Failure> {
        let asked = request.user_header().0;
        // A trajectory of a gap and a sample.
        let mut header = wire::ReplyHeader {
            version: wire::VERSION,
            dimension: 2,
            client: asked.client,
            sequence: asked.sequence,
            last: 1,
            answers: 1,
            gaps_per_junction: 1,
            gaps: 1,
            samples: 1,
            ..wire::ReplyHeader::default()
        };
        let mut cells = vec![0; 1 + 9];
        match self.lie {
            Lie::Layout => {}
            Lie::Version => header.version = 99,
            Lie::Truncated => header.samples = 100,
            Lie::Trailing => cells.extend([0; 9]),
            Lie::Elements => {}
        }
        let reply = request.loan_slice_uninit(cells.len())?;
        let mut reply = reply.write_from_slice(&cells);
        reply.user_header_mut().0 = header;
        if self.lie == Lie::Elements {
            // Node and server (two cells each), request, count of elements.
            let own = std::ptr::from_ref(reply.header()).cast_mut().cast::<u64>();
            let count = (0..8).find(|at| {
                #[expect(
                    unsafe_code,
                    reason = "a peer can write what it likes into its own memory"
                )]
                // SAFETY: the header has more cells than are looked at before the count is found.
                unsafe {
                    own.add(*at).read() == cells.len() as u64
                }
            });
            let count = count.ok_or("the header has no count of elements")?;
            #[expect(unsafe_code, reason = "a peer can write what it likes into its own memory")]
            // SAFETY: within the header, which this process has mapped to write.
            unsafe {
                own.add(count).write(1 << 40);
            }
        }
        Ok(reply.send()?)
    }
}
