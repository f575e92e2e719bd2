//! From a scene request to its reply: one pure function.
//!
//! [`Workspace::answer`] is all that happens to a request. What it keeps between requests changes
//! no reply, and it reads no clock and no files, so a recorded request answered anew under the same
//! [`Caps`] gives the same bytes: [`reply_to`].

mod assembly;
mod cache;
mod caps;
mod check;
mod driving;
mod free_space;
mod parts;
mod refuse;

use planning::budget::Budget;
use planning::trajectory::{Profile, Sampling};
use schemas::convert::{self, PartSink};
use schemas::message::{
    Choice, ClearanceWish, Gap, Refusal, Reply, Request, RequestContent, RequestKey, SceneRequest,
    Task,
};
use schemas::wire;

use assembly::Assembly;
use cache::Cache;
use driving::Driving;
use parts::{Collect, Parts};

pub use cache::CacheStats;
pub use caps::Caps;

/// The default of what a workspace keeps, bytes.
pub const CACHE_BYTES: usize = 256 << 20;

/// What answering takes, kept from one request to the next: memory, and a cache of what
/// was made from free spaces. It holds no other state: what a workspace did before changes no reply.
#[derive(Debug)]
pub struct Workspace {
    caps: Caps,
    scene: SceneRequest,
    answering: Answering,
}

#[derive(Debug)]
struct Answering {
    cache: Cache,
    plane: Assembly<2>,
    space: Assembly<3>,
    floor: Driving,
}

impl Default for Workspace {
    /// With the defaults of the planner's configuration.
    fn default() -> Self {
        Self::new(Caps::default(), CACHE_BYTES)
    }
}

/// One answer that is wished for, whichever way the request says it.
#[derive(Debug, Clone, Copy)]
enum Wish<'a> {
    Gap(Gap),
    Gaps(&'a [Gap]),
    Safest,
    /// A point of the trade-off curve: this part of the greatest gap, no samples.
    Fraction(f64),
}

impl Workspace {
    /// An empty one, for requests that cost no more than `caps`. It keeps what it made from
    /// free spaces in at most `cache` bytes.
    pub fn new(caps: Caps, cache: usize) -> Self {
        let answering = Answering {
            cache: Cache::new(cache),
            plane: Assembly::default(),
            space: Assembly::default(),
            floor: Driving::default(),
        };
        Self { caps, scene: SceneRequest::empty(), answering }
    }

    /// What was there already for the requests so far, and what is kept for the next.
    pub fn cache_stats(&self) -> CacheStats {
        self.answering.cache.stats()
    }

    /// Answers a request as it lies in memory. Whatever is there, there is a reply.
    pub fn answer<S: PartSink>(
        &mut self,
        header: &wire::RequestHeader,
        cells: &[u64],
        sink: &mut S,
    ) -> Result<(), S::Error> {
        let key = RequestKey { client: header.client, sequence: header.sequence };
        let Self { caps, scene, answering } = self;
        let readable = (caps.check_cells(cells.len()))
            .and_then(|()| convert::check_version(header))
            .and_then(|()| {
                convert::read_scene(header, cells, scene)
                    .map_err(|malformed| convert::unreadable(&malformed))
            });
        match readable {
            Ok(()) => answering.scene(key, scene, caps, sink),
            Err(refusal) => Self::refuse(header, &refusal, sink),
        }
    }

    /// Refuses a request as a whole.
    pub fn refuse<S: PartSink>(
        header: &wire::RequestHeader,
        refusal: &Refusal,
        sink: &mut S,
    ) -> Result<(), S::Error> {
        let key = RequestKey { client: header.client, sequence: header.sequence };
        let id = (header.given & wire::given::ID != 0).then_some(header.id);
        Parts::new(key, id, 0, sink).refuse(refusal, true)
    }
}

impl Answering {
    fn scene<S: PartSink>(
        &mut self,
        key: RequestKey,
        scene: &SceneRequest,
        caps: &Caps,
        sink: &mut S,
    ) -> Result<(), S::Error> {
        let sent = match self.try_scene(key, scene, caps, sink) {
            Ok(sent) => sent,
            Err(refusal) => Parts::new(key, scene.id, 0, sink).refuse(&refusal, true),
        };
        self.plane.release();
        self.space.release();
        self.floor.release();
        self.cache.end_request();
        sent
    }

    /// `Err`: the request as a whole is refused, and nothing has been sent.
    fn try_scene<S: PartSink>(
        &mut self,
        key: RequestKey,
        scene: &SceneRequest,
        caps: &Caps,
        sink: &mut S,
    ) -> Result<Result<(), S::Error>, Refusal> {
        let dimension = convert::dimension(scene)?;
        check::fields(scene)?;
        let budget = Budget::new(caps.limits());
        let wishes = Wishes::of(&scene.clearance, caps, &budget)?;
        match (scene.task, dimension) {
            (Task::Drive, 2) => self.floor.answer(key, scene, &wishes, &mut self.cache, sink),
            (Task::Drive, _) => {
                Err(Refusal::invalid("task", "task: robots drive in two dimensions"))
            }
            (_, 2) => self.plane.answer(key, scene, &wishes, &mut self.cache, sink),
            (_, _) => self.space.answer(key, scene, &wishes, &mut self.cache, sink),
        }
    }
}

/// A refused answer.
struct Refused {
    refusal: Refusal,
    /// Whether no gap would help, so that the request as a whole is refused.
    whole: bool,
}

impl From<Refusal> for Refused {
    fn from(refusal: Refusal) -> Self {
        Self { refusal, whole: false }
    }
}

/// Sends an answer to each wish: `answer` plans the one with this index and sends it, told
/// whether it is the last. `Err`: the request as a whole is refused, and nothing has
/// been sent.
fn answer_each<'a, S: PartSink>(
    key: RequestKey,
    id: Option<u64>,
    wishes: &Wishes,
    sink: &'a mut S,
    mut answer: impl FnMut(u32, bool, &mut Parts<'a, S>) -> Result<Result<(), S::Error>, Refused>,
) -> Result<Result<(), S::Error>, Refusal> {
    let mut parts = Parts::new(key, id, wishes.count, sink);
    for index in 0..wishes.count {
        let last = index + 1 == wishes.count;
        let begun = wishes.budget.step(1).map_err(|spent| refuse::spent(spent).into());
        let sent = match begun.and_then(|()| answer(index, last, &mut parts)) {
            Ok(sent) => sent,
            Err(refused) if !wishes.several() || (refused.whole && index == 0) => {
                return Err(refused.refusal);
            }
            Err(refused) => parts.refuse(&refused.refusal, last),
        };
        if sent.is_err() {
            return Ok(sent);
        }
    }
    Ok(Ok(()))
}

/// The answers wished for, and what they may cost.
struct Wishes<'a> {
    clearance: &'a ClearanceWish,
    count: u32,
    caps: &'a Caps,
    /// Of the request as a whole.
    budget: &'a Budget<'a>,
}

impl<'a> Wishes<'a> {
    fn of(
        clearance: &'a ClearanceWish,
        caps: &'a Caps,
        budget: &'a Budget<'a>,
    ) -> Result<Self, Refusal> {
        let (field, count) = match clearance {
            ClearanceWish::Each(choices) => ("clearance.each", choices.len() as u64),
            ClearanceWish::Curve(points) => ("clearance.curve", *points),
            _ => ("clearance", 1),
        };
        let most = caps.answers;
        if (1..=most).contains(&count) {
            return Ok(Self { clearance, count: count as u32, caps, budget });
        }
        let message = format!("{field} asks for {count} answers, from 1 to {most} can be had");
        Err(Refusal::invalid(field, message))
    }

    /// Whether one refused answer is not the whole reply.
    fn several(&self) -> bool {
        matches!(self.clearance, ClearanceWish::Each(_) | ClearanceWish::Curve(_))
    }

    fn sampled(&self) -> bool {
        !matches!(self.clearance, ClearanceWish::Curve(_))
    }

    /// Refuses a trajectory that would have too many samples, before any is made.
    fn check_samples(&self, profile: &Profile, sampling: Sampling) -> Result<(), Refused> {
        match profile.sample_count(sampling) {
            samples if self.sampled() && samples > self.caps.samples => {
                Err(refuse::too_many_samples(samples, self.caps.samples).into())
            }
            samples => {
                // The reply is held by whoever receives it, if not here.
                let bytes = samples as usize * size_of::<wire::Sample>();
                let held = self.budget.hold(if self.sampled() { bytes } else { 0 });
                held.map_err(|spent| refuse::spent(spent).into())
            }
        }
    }

    fn get(&self, index: u32) -> Wish<'a> {
        match self.clearance {
            ClearanceWish::Gap(gap) => Wish::Gap(*gap),
            ClearanceWish::Gaps(gaps) => Wish::Gaps(gaps),
            ClearanceWish::Safest => Wish::Safest,
            ClearanceWish::Each(choices) => match &choices[index as usize] {
                Choice::Gap(gap) => Wish::Gap(*gap),
                Choice::Gaps(gaps) => Wish::Gaps(gaps),
                Choice::Safest => Wish::Safest,
            },
            ClearanceWish::Curve(points) => Wish::Fraction(f64::from(index + 1) / *points as f64),
        }
    }

    /// The field that says the answer's gap.
    fn field(&self, index: u32) -> String {
        match self.clearance {
            ClearanceWish::Gap(_) => "clearance.gap".to_owned(),
            ClearanceWish::Gaps(_) => "clearance.gaps".to_owned(),
            ClearanceWish::Each(_) => format!("clearance.each[{index}]"),
            ClearanceWish::Safest | ClearanceWish::Curve(_) => "clearance".to_owned(),
        }
    }
}

/// Answers a request in this process: the same answers, bit for bit, as a planner with
/// these caps gives over the bus. Nothing is kept from one request to the next.
pub fn reply_to(request: &Request, caps: &Caps) -> Reply {
    let mut workspace = Workspace::new(*caps, 0);
    let mut collect = Collect::default();
    let Ok(()) = match &request.content {
        // By way of its memory, so that nothing is refused otherwise than over the bus.
        RequestContent::Scene(scene) => {
            let mut cells = Vec::new();
            match convert::write_scene(scene, request.key, request.sent_ns, &mut cells) {
                Ok(header) => workspace.answer(&header, &cells, &mut collect),
                Err(refusal) => {
                    Parts::new(request.key, scene.id, 0, &mut collect).refuse(&refusal, true)
                }
            }
        }
        RequestContent::Unreadable { header, cells } => {
            workspace.answer(&convert::header_of(header), cells, &mut collect)
        }
    };
    collect.reply()
}
