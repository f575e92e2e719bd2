//! From a request to its reply.

mod assembly;
mod check;
mod driving;
mod free_space;
mod parts;
mod refuse;

use planning::trajectory::{Profile, Sampling};
use schemas::convert::{self, PartSink};
use schemas::message::{
    Choice, ClearanceWish, Gap, Refusal, Reply, Request, RequestContent, RequestKey, SceneRequest,
    Task,
};
use schemas::wire;

use assembly::Assembly;
use driving::Driving;
use parts::{Collect, Parts};

/// The most samples in one trajectory.
pub const MOST_SAMPLES: u64 = 1_000_000;

/// The most answers to one request.
const MOST_ANSWERS: u64 = 10_000;

/// The memory that answering takes, kept from one request to the next. It holds no
/// other state: what a workspace did before changes no reply.
#[derive(Debug)]
pub struct Workspace {
    scene: SceneRequest,
    answering: Answering,
}

#[derive(Debug, Default)]
struct Answering {
    plane: Assembly<2>,
    space: Assembly<3>,
    floor: Driving,
}

impl Default for Workspace {
    fn default() -> Self {
        Self { scene: SceneRequest::empty(), answering: Answering::default() }
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
    /// Answers a request as it lies in memory. Whatever is there, there is a reply.
    pub fn answer<S: PartSink>(
        &mut self,
        header: &wire::RequestHeader,
        cells: &[u64],
        sink: &mut S,
    ) -> Result<(), S::Error> {
        let key = RequestKey { client: header.client, sequence: header.sequence };
        let readable = convert::check_version(header).and_then(|()| {
            convert::read_scene(header, cells, &mut self.scene)
                .map_err(|malformed| convert::unreadable(&malformed))
        });
        match readable {
            Ok(()) => self.answering.scene(key, &self.scene, sink),
            Err(refusal) => {
                let id = (header.given & wire::given::ID != 0).then_some(header.id);
                Parts::new(key, id, 0, sink).refuse(&refusal, true)
            }
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
        sink: &mut S,
    ) -> Result<(), S::Error> {
        match self.try_scene(key, scene, sink) {
            Ok(sent) => sent,
            Err(refusal) => Parts::new(key, scene.id, 0, sink).refuse(&refusal, true),
        }
    }

    /// `Err`: the request as a whole is refused, and nothing has been sent.
    fn try_scene<S: PartSink>(
        &mut self,
        key: RequestKey,
        scene: &SceneRequest,
        sink: &mut S,
    ) -> Result<Result<(), S::Error>, Refusal> {
        let dimension = convert::dimension(scene)?;
        check::fields(scene)?;
        let wishes = Wishes::of(&scene.clearance)?;
        match (scene.task, dimension) {
            (Task::Drive, 2) => self.floor.answer(key, scene, &wishes, sink),
            (Task::Drive, _) => {
                Err(Refusal::invalid("task", "task: robots drive in two dimensions"))
            }
            (_, 2) => self.plane.answer(key, scene, &wishes, sink),
            (_, _) => self.space.answer(key, scene, &wishes, sink),
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
        let sent = match answer(index, last, &mut parts) {
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

/// The answers wished for.
struct Wishes<'a> {
    clearance: &'a ClearanceWish,
    count: u32,
}

impl<'a> Wishes<'a> {
    fn of(clearance: &'a ClearanceWish) -> Result<Self, Refusal> {
        let (field, count) = match clearance {
            ClearanceWish::Each(choices) => ("clearance.each", choices.len() as u64),
            ClearanceWish::Curve(points) => ("clearance.curve", *points),
            _ => ("clearance", 1),
        };
        if (1..=MOST_ANSWERS).contains(&count) {
            return Ok(Self { clearance, count: count as u32 });
        }
        let message =
            format!("{field} asks for {count} answers, from 1 to {MOST_ANSWERS} can be had");
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
            samples if self.sampled() && samples > MOST_SAMPLES => {
                Err(refuse::too_many_samples(samples).into())
            }
            _ => Ok(()),
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

/// Answers a request in this process: the same answers, bit for bit, as a planner
/// gives over the bus.
pub fn reply_to(request: &Request) -> Reply {
    let mut workspace = Workspace::default();
    let mut collect = Collect::default();
    let Ok(()) = match &request.content {
        RequestContent::Scene(scene) => workspace.answering.scene(request.key, scene, &mut collect),
        RequestContent::Unreadable { header, cells } => {
            workspace.answer(&convert::header_of(header), cells, &mut collect)
        }
    };
    collect.reply()
}
