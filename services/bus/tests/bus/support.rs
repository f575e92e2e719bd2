//! Domains, planners and processes for tests.

use std::collections::BTreeSet;
use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use bus::{Client, ConnectError, Domain, Incoming, ReplyError, Server, ServerOptions, Wait, Woken};
use iceoryx2::prelude::{Config, FilePath, Node, NodeBuilder, SemanticString, ipc};
use schemas::convert::{self, TrajectoryWriter};
use schemas::message::{
    AxisBox, Body, ClearanceWish, Direction, FreeSpace, Gap, Reply, RequestKey, Sampling,
    SceneRequest, Task, Trajectory,
};
use schemas::wire;
use tempfile::TempDir;

/// A limit that only a hang reaches.
pub(crate) const LONG: Duration = Duration::from_secs(20);

/// A domain that nobody else uses, and that must be empty in the end.
pub(crate) struct TestDomain {
    pub domain: Domain,
    root: TempDir,
    /// Prefixes of its files in memory: new ones each time that somebody comes first.
    prefixes: Mutex<BTreeSet<String>>,
}

impl TestDomain {
    pub(crate) fn new() -> Self {
        let alone = Permissions::from_mode(0o700);
        let root = tempfile::Builder::new().prefix("cw").permissions(alone).tempdir_in("/tmp");
        let root = root.unwrap();
        let domain = Domain::new("test").unwrap().under(root.path());
        Self { domain, root, prefixes: Mutex::default() }
    }

    pub(crate) fn root(&self) -> &Path {
        self.root.path()
    }

    /// The domain as a configuration of iceoryx2.
    fn settings(&self) -> PathBuf {
        self.root().join("test.toml")
    }

    /// Notes what the domain's files in memory are called.
    pub(crate) fn note(&self) {
        let text = std::fs::read_to_string(self.settings()).unwrap_or_default();
        let prefix =
            text.lines().find_map(|line| line.strip_prefix("prefix = \"")?.strip_suffix('"'));
        self.prefixes.lock().unwrap().extend(prefix.map(String::from));
    }

    /// What lies in memory and on disk for this domain.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        self.note();
        let prefixes = self.prefixes.lock().unwrap();
        let named = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            prefixes.iter().any(|prefix| name.starts_with(prefix))
        };
        let mut files: Vec<_> = entries("/dev/shm").into_iter().filter(named).collect();
        let mut directories = entries(self.root());
        while let Some(directory) = directories.pop() {
            if directory.is_dir() {
                directories.extend(entries(&directory));
            }
            files.push(directory);
        }
        files
    }

    /// Joins the domain by iceoryx2's own means, and makes it if nobody is there.
    pub(crate) fn bare_node(&self) -> Node<ipc::Service> {
        if !self.settings().exists() {
            let directory = self.root().join("testtest");
            let text = format!(
                "# A domain of Clearway. As config/iceoryx2.toml it shows the domain to iceoryx2's tools.\n\
                 [global]\nroot-path = {directory:?}\nprefix = \"cw_testtest_\"\n"
            );
            std::fs::write(self.settings(), text).unwrap();
        }
        bare_node(self.root())
    }
}

fn entries(directory: impl AsRef<Path>) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(directory).into_iter().flatten();
    entries.filter_map(|entry| Some(entry.ok()?.path())).collect()
}

impl Drop for TestDomain {
    fn drop(&mut self) {
        self.note();
        // Who was killed clears nothing up.
        self.domain.tidy();
        let left = self.files();
        for path in &left {
            let _ = std::fs::remove_file(path);
            let _ = std::fs::remove_dir_all(path);
        }
        if !std::thread::panicking() {
            assert_eq!(left, Vec::<PathBuf>::new(), "left behind in {}", self.root().display());
        }
    }
}

/// Joins the test's domain under a directory by iceoryx2's own means.
pub(crate) fn bare_node(root: &Path) -> Node<ipc::Service> {
    let file = root.join("test.toml");
    let file = FilePath::new(file.as_os_str().as_encoded_bytes()).unwrap();
    let config = Config::from_file(&file).expect("it is a configuration of iceoryx2");
    NodeBuilder::new().config(&config).create::<ipc::Service>().unwrap()
}

/// A planner in a thread of its own, that ends when this is dropped.
pub(crate) struct Planner {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Planner {
    /// Answers every request with [`trajectory`].
    pub(crate) fn start(domain: &Domain, options: ServerOptions) -> Self {
        Self::start_with(domain, options, |incoming| {
            incoming.copy(usize::MAX, &mut Vec::new()).unwrap();
            answer(&incoming.header(), incoming)
        })
    }

    /// Answers every request as `serve` does.
    pub(crate) fn start_with(
        domain: &Domain,
        options: ServerOptions,
        serve: impl FnMut(&mut Incoming) -> Result<(), ReplyError> + Send + 'static,
    ) -> Self {
        // A client that is gone is no concern of the others.
        Self::start_and_tell(domain, options, serve, |_| {})
    }

    /// The same, and tells how each reply ended.
    pub(crate) fn start_and_tell(
        domain: &Domain,
        options: ServerOptions,
        mut serve: impl FnMut(&mut Incoming) -> Result<(), ReplyError> + Send + 'static,
        mut ended: impl FnMut(Result<(), ReplyError>) + Send + 'static,
    ) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let (ready, opened) = std::sync::mpsc::channel();
        let (domain, stopped) = (domain.clone(), Arc::clone(&stop));
        let thread = std::thread::spawn(move || {
            let mut server = Server::open(&domain, &options).unwrap();
            ready.send(()).unwrap();
            let mut open = OpenReplies::default();
            while !stopped.load(Ordering::Relaxed) {
                assert_eq!(server.wait(open.next_try()), Woken::Look);
                while let Some(mut incoming) = server.receive() {
                    let answered = serve(&mut incoming);
                    open.add(incoming, answered);
                }
                open.flush(&mut ended);
            }
        });
        opened.recv().expect("the planner opens");
        Self { stop, thread: Some(thread) }
    }
}

impl Drop for Planner {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let ended = self.thread.take().map(JoinHandle::join);
        if !std::thread::panicking() {
            assert!(ended.is_none_or(|ended| ended.is_ok()), "the planner failed");
        }
    }
}

/// Replies whose clients have not taken all of them.
#[derive(Default)]
pub(crate) struct OpenReplies(Vec<(Incoming, Result<(), ReplyError>)>);

impl OpenReplies {
    /// What is written, with how that went.
    pub(crate) fn add(&mut self, incoming: Incoming, answered: Result<(), ReplyError>) {
        self.0.push((incoming, answered));
    }

    /// When to try to send more.
    pub(crate) fn next_try(&self) -> Option<Instant> {
        (!self.0.is_empty()).then(|| Instant::now() + Duration::from_millis(1))
    }

    /// Sends what there is room for, and tells of the replies that ended.
    pub(crate) fn flush(&mut self, mut ended: impl FnMut(Result<(), ReplyError>)) {
        self.0.retain_mut(|(incoming, answered)| {
            let left = answered.clone().and_then(|()| incoming.flush());
            if left.as_ref().is_ok_and(|left| *left > 0) {
                return true;
            }
            ended(left.map(drop));
            false
        });
    }
}

/// Waits for a planner to come up in another process.
pub(crate) fn connect(domain: &Domain, how: Wait) -> Client {
    let until = Instant::now() + LONG;
    loop {
        match Client::connect(domain, how) {
            Ok(client) => return client,
            Err(ConnectError::NoPlanner { .. }) if Instant::now() < until => {
                std::thread::sleep(Duration::from_millis(5));
            }
            Err(error) => panic!("{error}"),
        }
    }
}

/// A scene; the answer has this many samples.
pub(crate) fn scene(id: u64, samples: u64) -> SceneRequest {
    SceneRequest {
        id: Some(id),
        task: Task::Disassemble,
        free_space: FreeSpace {
            channels: Some(vec![boxed(4.0, 6.0), boxed(1.0, 5.0)]),
            in_order: true,
            ..FreeSpace::default()
        },
        body: Body::Polygon(vec![[4.5, 1.01].into(), [4.5, 4.0].into(), [6.99, 4.0].into()]),
        exit: vec![Direction::PlusZ],
        clearance: ClearanceWish::Gap(Gap::Uniform(0.2)),
        sampling: Some(Sampling::Count(samples)),
        ..SceneRequest::empty()
    }
}

pub(crate) fn boxed(min: f64, max: f64) -> AxisBox {
    AxisBox { min: [min, min + 1.0].into(), max: [max, max + 2.0].into() }
}

/// The answer to `scene(id, samples)`.
pub(crate) fn trajectory(id: u64, samples: u64) -> Trajectory {
    Trajectory {
        dimension: 2,
        gaps_per_junction: 2,
        length: id as f64,
        gaps: vec![0.1, 0.2],
        route: vec![id, 1],
        clearance: schemas::message::Clearance { wall: [1.0, 2.0].into(), ..Default::default() },
        samples: (0..samples).map(|index| sample(id, index)).collect(),
        ..Trajectory::default()
    }
}

fn sample(id: u64, index: u64) -> wire::Sample {
    let (id, t) = (id as f64, index as f64);
    wire::Sample { t, position: [id, t, 0.0], heading: -t, velocity: [t, id, 0.0], yaw_rate: id }
}

/// The reply to `scene(id, samples)`.
pub(crate) fn reply(key: RequestKey, id: u64, samples: u64) -> Reply {
    Reply { key, id: Some(id), answers: Ok(vec![Ok(trajectory(id, samples))]) }
}

/// Answers a request with [`trajectory`].
pub(crate) fn answer(
    header: &wire::RequestHeader,
    incoming: &mut Incoming,
) -> Result<(), ReplyError> {
    let trajectory = trajectory(header.id, header.sampling);
    let mut head = wire::ReplyHeader {
        version: wire::VERSION,
        dimension: 2,
        client: header.client,
        sequence: header.sequence,
        id: header.id,
        given: wire::reported::ID,
        answers: 1,
        gaps_per_junction: trajectory.gaps_per_junction,
        length: trajectory.length,
        wall: trajectory.clearance.wall.padded(),
        ..wire::ReplyHeader::default()
    };
    TrajectoryWriter {
        gaps: trajectory.gaps.iter().copied(),
        route: trajectory.route.iter().copied(),
        channels: std::iter::empty(),
        legs: std::iter::empty(),
        samples: trajectory.samples.iter().copied(),
    }
    .write(&mut head, true, &mut incoming.reply())
}

/// Reads a request as the planner does.
pub(crate) fn read(incoming: &mut Incoming) -> Result<SceneRequest, convert::Malformed> {
    let mut cells = Vec::new();
    let header = incoming.copy(usize::MAX, &mut cells).unwrap();
    let mut scene = SceneRequest::empty();
    convert::read_scene(&header, &cells, &mut scene).map(|()| scene)
}
