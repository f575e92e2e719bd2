//! From a scene request to its reply: one pure function.
//!
//! [`Workspace::answer`] does all the work. It reads no clock and no files, and what it keeps
//! between requests changes no reply. So a recorded request, answered again under the same
//! [`Caps`], gives the same bytes; [`reply_to`] does that.
//!
//! All answers to a request draw from one budget. A [`StopFlag`] stops a request from outside.
//!
//! This crate knows planning and the messages. It does not know the bus, recordings, the
//! configuration file, the command line, logging, clocks or threads: the caller passes the caps,
//! the memory of the request, a sink for the reply, and a flag that stops it.
//!
//! ```
//! use answer::{Caps, reply_to};
//! use schemas::json;
//! use schemas::message::{Request, RequestContent, RequestKey};
//!
//! let scene = json::read_scene(
//!     r#"{ "task": "drive",
//!          "free_space": { "channels": [{ "min": [0, 0], "max": [10, 3] }], "in_order": true },
//!          "body": { "footprint": { "width": 1.0, "length": 1.5 } },
//!          "start": { "position": [2, 1.5], "heading": 0 },
//!          "goal": { "position": [8, 1.5] },
//!          "clearance": { "gap": 0.2 } }"#,
//! )
//! .unwrap();
//! let content = RequestContent::Scene(scene);
//! let request = Request { key: RequestKey::default(), sent_ns: 0, content };
//! let reply = reply_to(&request, &Caps::default());
//! let trajectory = reply.answers.unwrap().remove(0).unwrap();
//! assert_eq!(trajectory.length, 6.0);
//! ```

mod answers;
mod assembly;
mod cache;
mod caps;
mod check;
mod driving;
mod free_space;
mod parts;
mod refuse;
mod scene;
mod sink;
mod stop;
mod uploads;
mod wish;

use planning::budget::Budget;
use schemas::convert::{self, PartSink};
use schemas::message::{Refusal, Reply, Request, RequestContent, RequestKey, SceneRequest, Task};
use schemas::wire;

use answers::{Resources, Stop};
use assembly::Assembly;
use cache::Cache;
use driving::Driving;
use parts::{Collect, Parts};
use sink::{AnySink, SinkFailed, with_any_sink};
use stop::Watched;
use uploads::Uploads;
use wish::Wishes;

pub use cache::CacheStats;
pub use caps::Caps;
pub use stop::{StopFlag, StopReason};

/// Memory that a workspace keeps between requests by default, bytes.
pub const CACHE_BYTES: usize = 256 << 20;

/// Answers requests one after another. Between them it keeps buffers and a cache of what it made
/// from free spaces. Neither changes a reply.
#[derive(Debug)]
pub struct Workspace {
    caps: Caps,
    scene: SceneRequest,
    uploads: Uploads,
    cache: Cache,
    buffers: Buffers,
}

/// Buffers for the answers to a request.
#[derive(Debug, Default)]
struct Buffers {
    plane: Assembly<2>,
    space: Assembly<3>,
    floor: Driving,
    /// Memory of each as counted last, bytes.
    bytes: [usize; 3],
    /// The one used since.
    used: Option<usize>,
}

impl Default for Workspace {
    /// A workspace with the planner's default settings.
    fn default() -> Self {
        Self::new(Caps::default(), CACHE_BYTES)
    }
}

impl Workspace {
    /// A workspace for requests that cost no more than `caps`, which keeps at most `cache` bytes
    /// from one request to the next.
    pub fn new(caps: Caps, cache: usize) -> Self {
        Self::with_uploads(caps, cache, cache / BUFFERS_SHARE)
    }

    /// The same, with a bound of its own for named free spaces, bytes.
    fn with_uploads(caps: Caps, cache: usize, uploads: usize) -> Self {
        Self {
            caps,
            scene: SceneRequest::empty(),
            uploads: Uploads::new(uploads),
            cache: Cache::new(cache),
            buffers: Buffers::default(),
        }
    }

    /// Statistics of the cache since the workspace was made.
    pub fn cache_stats(&self) -> CacheStats {
        self.cache.stats()
    }

    /// Memory held, bytes; between requests at most the `cache` given to [`Workspace::new`].
    pub fn bytes(&self) -> usize {
        self.cache.stats().bytes + self.buffer_bytes()
    }

    /// Answers the request in memory and writes the reply to `sink`, whatever that memory holds.
    ///
    /// A request that costs more than the caps allow is refused as `too_costly`; one that `stop`
    /// ends, as `deadline_exceeded` or `overloaded`. Answers found before stand.
    ///
    /// # Errors
    ///
    /// The sink's, if it does not take a part.
    ///
    /// ```
    /// use answer::{StopFlag, Workspace};
    /// use schemas::convert::{CellWriter, PartSink};
    /// use schemas::wire::{ReplyHeader, RequestHeader};
    ///
    /// /// Counts the parts of a reply.
    /// struct Count(usize);
    ///
    /// impl PartSink for Count {
    ///     type Error = std::convert::Infallible;
    ///
    ///     fn part(
    ///         &mut self,
    ///         _: &ReplyHeader,
    ///         cells: usize,
    ///         fill: impl FnOnce(&mut CellWriter),
    ///     ) -> Result<(), Self::Error> {
    ///         fill(&mut CellWriter::new(&mut vec![0; cells]));
    ///         self.0 += 1;
    ///         Ok(())
    ///     }
    /// }
    ///
    /// // A request with nothing in it is refused, in one part.
    /// let mut count = Count(0);
    /// let header = RequestHeader::default();
    /// Workspace::default().answer(&header, &[], &StopFlag::new(), &mut count).unwrap();
    /// assert_eq!(count.0, 1);
    /// ```
    pub fn answer<S: PartSink>(
        &mut self,
        header: &wire::RequestHeader,
        cells: &[u64],
        stop: &StopFlag,
        sink: &mut S,
    ) -> Result<(), S::Error> {
        self.answer_while(header, cells, (stop, &|| true), sink)
    }

    /// The same as long as somebody wants the reply: when `is_wanted` says no, `stop` is set. It is
    /// asked several times in a millisecond.
    ///
    /// # Errors
    ///
    /// The sink's, if it does not take a part.
    pub fn answer_while<S: PartSink>(
        &mut self,
        header: &wire::RequestHeader,
        cells: &[u64],
        (stop, is_wanted): (&StopFlag, &dyn Fn() -> bool),
        sink: &mut S,
    ) -> Result<(), S::Error> {
        let watched = Watched::new(stop, is_wanted);
        with_any_sink(sink, |sink| self.answer_any(header, cells, (stop, &watched), sink))
    }

    fn answer_any(
        &mut self,
        header: &wire::RequestHeader,
        cells: &[u64],
        (stop, watched): (&StopFlag, &Watched<'_>),
        sink: &mut AnySink<'_>,
    ) -> Result<(), SinkFailed> {
        let budget = Budget::with_stop(self.caps.limits(), watched);
        let answered = self.try_answer(header, cells, &budget, stop, sink);
        self.end_request();
        match answered {
            Ok(()) => Ok(()),
            Err(Stop::Sink(error)) => Err(error),
            Err(Stop::Refused(refused)) => Self::refuse(header, &refused.into_refusal(stop), sink),
        }
    }

    /// Refuses a request as a whole.
    pub fn refuse<S: PartSink>(
        header: &wire::RequestHeader,
        refusal: &Refusal,
        sink: &mut S,
    ) -> Result<(), S::Error> {
        let id = (header.given & wire::given::ID != 0).then_some(header.id);
        Parts::new(key(header), id, 0, sink).refuse(refusal, true)
    }

    fn try_answer(
        &mut self,
        header: &wire::RequestHeader,
        cells: &[u64],
        budget: &Budget<'_>,
        stop: &StopFlag,
        sink: &mut AnySink<'_>,
    ) -> Result<(), Stop<SinkFailed>> {
        let Self { caps, scene, uploads, cache, buffers } = self;
        caps.check_cells(cells.len())?;
        convert::check_version(header)?;
        scene::read(header, cells, scene, budget)?;
        uploads.open(&mut scene.free_space, budget)?;
        let dimension = convert::dimension(scene)?;
        check::fields(scene)?;
        let wishes = Wishes::of(&scene.clearance, caps)?;
        let parts = &mut Parts::new(key(header), scene.id, wishes.count(), sink);
        let resources = Resources { caps, budget, cache };
        let kind = match (scene.task, dimension) {
            (Task::Drive, _) => FLOOR,
            (_, 2) => PLANE,
            (_, _) => SPACE,
        };
        buffers.used = Some(kind);
        match (scene.task, dimension) {
            (Task::Drive, 2) => buffers.floor.answer(scene, &wishes, resources, stop, parts),
            (Task::Drive, _) => {
                let message = "task: \"drive\" is for two dimensions; this scene has three";
                Err(Refusal::invalid("task", message).into())
            }
            (_, 2) => buffers.plane.answer(scene, &wishes, resources, stop, parts),
            (_, _) => buffers.space.answer(scene, &wishes, resources, stop, parts),
        }
    }

    /// Frees what may not be kept.
    fn end_request(&mut self) {
        self.uploads.close(&mut self.scene.free_space);
        let most = self.cache.most_bytes() / BUFFERS_SHARE;
        self.buffers.count();
        let (mut buffers, mut scene) = (self.buffers.bytes(), scene::bytes(&self.scene));
        if buffers > most {
            self.buffers = Buffers::default();
            buffers = 0;
        }
        if scene > most {
            self.scene = SceneRequest::empty();
            scene = scene::bytes(&self.scene);
        }
        if self.cache.content_bytes() > most {
            self.cache.release_content();
        }
        let read = scene + self.uploads.bytes() + self.cache.content_bytes();
        self.cache.end_request(buffers + read);
    }

    /// Memory of what is reused, whatever it contains.
    fn buffer_bytes(&self) -> usize {
        let scene = scene::bytes(&self.scene) + self.uploads.bytes();
        self.buffers.bytes() + scene + self.cache.content_bytes()
    }
}

/// Each kind of buffer may keep this fraction (1/4) of the cache's bound.
const BUFFERS_SHARE: usize = 4;

/// Indices of [`Buffers::bytes`].
const PLANE: usize = 0;
const SPACE: usize = 1;
const FLOOR: usize = 2;

impl Buffers {
    /// Counts the memory of those that a request used: a look at each vector of all three would be
    /// some 4 % of a small request.
    fn count(&mut self) {
        if let Some(used) = self.used.take() {
            self.bytes[used] = match used {
                PLANE => self.plane.bytes(),
                SPACE => self.space.bytes(),
                _ => self.floor.bytes(),
            };
        }
    }

    fn bytes(&self) -> usize {
        self.bytes.iter().sum()
    }
}

fn key(header: &wire::RequestHeader) -> RequestKey {
    RequestKey { client: header.client, sequence: header.sequence }
}

/// Answers requests in this process, one after the other, bit for bit as a planner with these
/// caps does over the bus. From one request to the next it keeps named free spaces, all of them,
/// and nothing else.
#[derive(Debug)]
pub struct Answerer(Workspace);

impl Answerer {
    /// Answers requests that cost no more than `caps`.
    pub fn new(caps: &Caps) -> Self {
        Self(Workspace::with_uploads(*caps, 0, usize::MAX))
    }

    /// Answers a request.
    pub fn reply_to(&mut self, request: &Request) -> Reply {
        let mut collect = Collect::default();
        let stop = StopFlag::new();
        let Ok(()) = match &request.content {
            // Through memory as on the bus, so that the same is refused in the same words.
            RequestContent::Scene(scene) => {
                let mut cells = Vec::new();
                match convert::write_scene(scene, request.key, request.sent_ns, &mut cells) {
                    Ok(header) => self.0.answer(&header, &cells, &stop, &mut collect),
                    Err(refusal) => {
                        Parts::new(request.key, scene.id, 0, &mut collect).refuse(&refusal, true)
                    }
                }
            }
            RequestContent::Unreadable { header, cells } => {
                self.0.answer(&convert::header_of(header), cells, &stop, &mut collect)
            }
        };
        collect.reply()
    }
}

/// Answers one request alone, as an [`Answerer`] does.
pub fn reply_to(request: &Request, caps: &Caps) -> Reply {
    Answerer::new(caps).reply_to(request)
}
