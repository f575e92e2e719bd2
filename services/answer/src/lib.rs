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
mod base_frame;
mod cache;
mod caps;
mod check;
mod driving;
mod entries;
mod free_space;
mod named;
mod parts;
mod refuse;
mod scene;
mod sink;
mod stop;
mod store;
mod uploads;
mod wish;

use std::convert::Infallible;

use planning::budget::Budget;
use schemas::convert::{self, PartSink};
use schemas::message::{
    Refusal, Reply, ReplyPart, Request, RequestContent, RequestKey, SceneRequest, Task,
};
use schemas::wire;

use answers::{Resources, Stop};
use assembly::Assembly;
use cache::Cache;
use driving::Driving;
use parts::{Collect, Keep, Parts};
use scene::Scene;
use sink::{AnySink, SinkFailed, with_any_sink};
use stop::Watched;
use wish::Wishes;

pub use assembly::frames::body_in_fixed_frame;
pub use caps::Caps;
pub use entries::CacheStats;
#[cfg(all(feature = "altered-rules", debug_assertions))]
pub use planning::altered::with_rule_altered;
pub use stop::{StopFlag, StopReason};
pub use store::Store;

/// Memory that a workspace keeps between requests by default, bytes.
pub const CACHE_BYTES: usize = 256 << 20;

/// Answers requests one after another. Between them it keeps buffers, and its [`Store`] what was
/// made from free spaces. Neither changes a reply.
#[derive(Debug)]
pub struct Workspace {
    caps: Caps,
    scene: SceneRequest,
    store: Store,
    cache: Cache,
    buffers: Buffers,
    /// What the store counts for this workspace, bytes.
    counted: usize,
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
        Self::sharing(caps, &Store::new(cache))
    }

    /// A workspace that shares `store` with others.
    pub fn sharing(caps: Caps, store: &Store) -> Self {
        Self {
            caps,
            scene: SceneRequest::empty(),
            store: store.clone(),
            cache: Cache::new(store.clone()),
            buffers: Buffers::default(),
            counted: 0,
        }
    }

    /// Statistics of the cache since its store was made.
    pub fn cache_stats(&self) -> CacheStats {
        self.store.cache_stats()
    }

    /// Memory held, the whole store included, bytes; between requests at most what the store may
    /// keep.
    pub fn bytes(&self) -> usize {
        let kept = self.store.lock();
        kept.entries.stats().bytes + kept.uploads.bytes() + self.own_bytes()
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
        self.answer_while(header, cells, (stop, &|| {}), sink)
    }

    /// The same, and calls `meanwhile` several times in a millisecond. It may set `stop`, or let
    /// the request wait.
    ///
    /// # Errors
    ///
    /// The sink's, if it does not take a part.
    pub fn answer_while<S: PartSink>(
        &mut self,
        header: &wire::RequestHeader,
        cells: &[u64],
        (stop, meanwhile): (&StopFlag, &dyn Fn()),
        sink: &mut S,
    ) -> Result<(), S::Error> {
        let watched = Watched::new(stop, meanwhile);
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
        let Self { caps, scene: request, store, cache, buffers, counted: _ } = self;
        caps.check_cells(cells.len())?;
        convert::check_version(header)?;
        scene::read(header, cells, request, budget)?;
        let named = named::open(&mut request.free_space, store, budget)?;
        let free_space = named.as_deref().unwrap_or(&request.free_space);
        let scene = Scene { request, free_space };
        let dimension = convert::dimension(request, free_space)?;
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
        let most = self.store.most_of_a_buffer();
        self.buffers.count();
        if self.buffers.bytes() > most {
            self.buffers = Buffers::default();
        }
        if scene::bytes(&self.scene) > most {
            self.scene = SceneRequest::empty();
        }
        if self.cache.content_bytes() > most {
            self.cache.release_content();
        }
        let counted = self.own_bytes();
        if counted == self.counted && self.cache.used.was_there() {
            return self.cache.used.clear();
        }
        let mut kept = self.store.lock();
        kept.entries.count_elsewhere(self.counted, counted);
        let evicted = kept.entries.evict(&mut self.cache.used);
        drop(kept);
        drop(evicted);
        self.cache.used.clear();
        self.counted = counted;
    }

    /// Memory of what is reused, whatever it contains.
    fn own_bytes(&self) -> usize {
        self.buffers.bytes() + scene::bytes(&self.scene) + self.cache.content_bytes()
    }
}

impl Drop for Workspace {
    fn drop(&mut self) {
        self.cache.leave(self.counted);
    }
}

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
        Self(Workspace::sharing(*caps, &Store::with_uploads(0, usize::MAX)))
    }

    /// Answers a request.
    pub fn reply_to(&mut self, request: &Request) -> Reply {
        let mut collect = Collect::default();
        self.answer(request, &mut collect);
        collect.reply()
    }

    /// Answers a request with the parts that a planner sends; they carry no time.
    pub fn parts_to(&mut self, request: &Request) -> Vec<ReplyPart> {
        let mut keep = Keep::default();
        self.answer(request, &mut keep);
        keep.parts
    }

    fn answer(&mut self, request: &Request, sink: &mut impl PartSink<Error = Infallible>) {
        let stop = StopFlag::new();
        let Ok(()) = match &request.content {
            // Through memory as on the bus, so that the same is refused in the same words.
            RequestContent::Scene(scene) => {
                let mut cells = Vec::new();
                match convert::write_scene(scene, request.key, request.sent_ns, &mut cells) {
                    Ok(header) => self.0.answer(&header, &cells, &stop, sink),
                    Err(refusal) => {
                        Parts::new(request.key, scene.id, 0, sink).refuse(&refusal, true)
                    }
                }
            }
            RequestContent::Unreadable { header, cells } => {
                self.0.answer(&convert::header_of(header), cells, &stop, sink)
            }
        };
    }
}

/// Answers one request alone, as an [`Answerer`] does.
pub fn reply_to(request: &Request, caps: &Caps) -> Reply {
    Answerer::new(caps).reply_to(request)
}
