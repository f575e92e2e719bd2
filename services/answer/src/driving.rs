//! Driving: the rectangular mobile robot through corridors (paper, section 5).

use std::mem;

use planning::budget::Budget;
use planning::clearance::rectangle::Footprint;
use planning::driving::{
    self, Corner, Drive, DrivingError, Gaps, Path, StartTurn, corners_of, limits,
};
use planning::free_space::walls::Walls;
use planning::free_space::{Chain, End};
use planning::geometry::{AxisBox, Vector};
use planning::route::{self, Judgement, Motion, RouteError};
use planning::trajectory::{Limits, Profile, Sampling, Stops};
use schemas::convert::{PartSink, TrajectoryWriter};
use schemas::message::{self, Body, ErrorCode, Gap, Refusal, RequestKey, SceneRequest};
use schemas::wire::ReplyHeader;

use super::cache::Cache;
use super::free_space::FreeSpace;
use super::parts::{self, Parts};
use super::refuse::{self, FLOOR};
use super::{Refused, Wish, Wishes, answer_each, check};

/// Memory for driving tasks.
#[derive(Debug, Default)]
pub(super) struct Driving {
    free_space: FreeSpace<2, route::Driving>,
    course: Course,
    /// Memory for a course that is tried.
    spare: Course,
    /// For which gap the course was found; `None`: for any.
    found_for: Option<Option<f64>>,
    profile: Profile,
}

/// The way through the channels travelled, and what the robot does on it.
#[derive(Debug, Default)]
struct Course {
    chain: Chain<2>,
    corners: Vec<Corner>,
    /// The gap at every corner of the answer at hand, metres.
    gaps: Vec<f64>,
    path: Path,
    /// The safest gap, once it is sought, metres.
    safest: Option<f64>,
}

/// The gaps that an answer is to keep, metres.
#[derive(Debug, Clone, Copy)]
enum Keep<'a> {
    /// This one at every corner.
    Gap(f64),
    /// These.
    Gaps(&'a [Gap]),
    /// This part of the safest.
    Part(f64),
}

/// So small that it makes no guiding circle any larger, metres.
const LEAST_GAP: f64 = f64::MIN_POSITIVE;

/// What all answers to a request share.
struct Terms<'a> {
    budget: &'a Budget<'a>,
    footprint: Footprint,
    start: driving::Pose,
    goal: driving::Goal,
    start_turn: StartTurn,
    limits: Limits,
    sampling: Sampling,
}

impl Driving {
    /// Answers a request for a mobile robot. `Err`: the request as a whole is refused, and
    /// nothing has been sent.
    pub(super) fn answer<S: PartSink>(
        &mut self,
        key: RequestKey,
        scene: &SceneRequest,
        wishes: &Wishes,
        cache: &mut Cache,
        sink: &mut S,
    ) -> Result<Result<(), S::Error>, Refusal> {
        let budget = wishes.budget;
        let terms = Terms::of(scene, budget)?;
        let free_space = &mut self.free_space;
        free_space.read(scene, &FLOOR, budget, cache)?;
        let size = [terms.footprint.width(), terms.footprint.length()];
        free_space.take_in_solids(scene, &FLOOR, &size, budget, cache)?;
        if free_space.is_made() {
            let bounds = *free_space.bounds().expect("checked: solids alone bound no floor");
            free_space.make(bounds, Vector::repeat(terms.footprint.width()), budget, cache)?;
        }
        if !check::has_solids(scene) {
            free_space.wall_in(None, budget, cache)?;
        }
        if !free_space.is_routed() {
            self.course.lead(free_space.travelled(), &terms)?;
        }
        self.found_for = None;

        answer_each(key, scene.id, wishes, sink, |index, last, parts| {
            self.plan(&terms, wishes, index)?;
            Ok(self.send(&terms, wishes.sampled(), last, parts))
        })
    }

    /// Lets go of what belongs to the cache: the request has ended.
    pub(super) fn release(&mut self) {
        self.free_space.release();
    }

    /// Plans one answer; `course` and `profile` then hold it.
    fn plan(&mut self, terms: &Terms<'_>, wishes: &Wishes, index: u32) -> Result<(), Refused> {
        let field = || wishes.field(index);
        let keep = Keep::of(wishes.get(index), field)?;
        let gap = match keep {
            Keep::Gap(gap) => Some(gap),
            Keep::Gaps(_) | Keep::Part(_) => None,
        };
        if !self.free_space.is_routed() || self.found_for == Some(gap) {
            let walls = self.free_space.walls();
            self.course
                .drive(terms, keep, walls)
                .map_err(|error| refuse::driving(field(), error))?;
        } else {
            if let Keep::Gaps(_) = keep {
                let field = field();
                let message = format!("{field}: no gap per corner before the route is known");
                return Err(Refusal::invalid(field, message).into());
            }
            self.found_for = None;
            self.find_course(terms, keep, gap, field)?;
            self.found_for = Some(gap);
        }
        self.profile
            .plan(self.course.path.legs(), &terms.limits, Stops::AtTurns, terms.budget)
            .map_err(refuse::spent)?;
        wishes.check_samples(&self.profile, terms.sampling)
    }

    /// Finds the channels to travel for a robot that is to keep this gap; none: any.
    fn find_course(
        &mut self,
        terms: &Terms<'_>,
        keep: Keep,
        gap: Option<f64>,
        field: impl Fn() -> String,
    ) -> Result<(), Refused> {
        if let Some(gap) = gap.filter(|gap| gap.is_nan() || *gap == f64::NEG_INFINITY) {
            let error = RouteError::GapNotPositive { axis: 0, gap, least: 0.0 };
            return Err(refuse::route(&FLOOR, field(), error));
        }
        let footprint = &terms.footprint;
        // What the robot needs to turn (docs/method.md 6.4: R(g) < W).
        let needs = limits::outer_radius(footprint, gap.unwrap_or(0.0));
        let sides = (footprint.width(), gap.unwrap_or(0.0));
        let (start, goal) = (terms.start.position, terms.goal.position);
        let mut robot = route::Driving::new(start, goal, Vector::repeat(needs), sides);
        let Self { free_space, spare, .. } = self;
        let mut first = None;
        let found = free_space.find(&mut robot, terms.budget, |channels, walls, _| {
            let refused = match spare.lead(channels, terms) {
                Ok(()) => match spare.judge(terms, keep, walls) {
                    Ok(length) => {
                        return Ok(Judgement::Accepted { length, value: mem::take(spare) });
                    }
                    Err(error) => (
                        Judgement::of_refusal(&error, spare.path.legs())?,
                        refuse::driving(field(), error),
                    ),
                },
                Err(refusal) => (Judgement::Hopeless, refusal.into()),
            };
            first.get_or_insert(refused.1);
            Ok(refused.0)
        });
        let course = found.map_err(|error| match (error, first) {
            (RouteError::Blocked, Some(refused)) => refused,
            (error, _) => {
                let refused = free_space.refuse_route(
                    &FLOOR,
                    field(),
                    error,
                    robot.traveller(),
                    terms.budget,
                );
                with_less_gap(refused, footprint, gap, field)
            }
        })?;
        self.spare = mem::replace(&mut self.course, course);
        Ok(())
    }

    fn send<S: PartSink>(
        &self,
        terms: &Terms<'_>,
        sampled: bool,
        last: bool,
        parts: &mut Parts<S>,
    ) -> Result<(), S::Error> {
        let Self { course: Course { path, gaps, .. }, profile, free_space, .. } = self;
        let samples = sampled.then(|| profile.samples(path.legs(), terms.sampling));
        let legs = path.legs().iter().zip(path.leg_clearances());
        let lists = TrajectoryWriter {
            gaps: gaps.iter().copied(),
            route: free_space.route(),
            channels: free_space.named(),
            legs: legs.map(|(leg, near)| parts::leg(leg, *near)),
            samples: parts::States(samples),
        };
        let fill = |header: &mut ReplyHeader| {
            header.dimension = 2;
            header.gaps_per_junction = 1;
            header.length = path.length();
            header.duration = profile.duration();
            parts::clearance(header, path.clearance().as_ref());
        };
        parts.trajectory(fill, lists, last)
    }
}

impl<'a> Keep<'a> {
    fn of(wish: Wish<'a>, field: impl Fn() -> String) -> Result<Self, Refusal> {
        Ok(match wish {
            Wish::Gap(gap) => Self::Gap(one_number(gap).ok_or_else(|| wrong_gap(field()))?),
            Wish::Gaps(gaps) => {
                for (corner, gap) in gaps.iter().enumerate() {
                    one_number(*gap).ok_or_else(|| wrong_gap(format!("{}[{corner}]", field())))?;
                }
                Self::Gaps(gaps)
            }
            Wish::Safest => Self::Part(1.0),
            Wish::Fraction(fraction) => Self::Part(fraction),
        })
    }
}

impl Course {
    /// Makes the chain of the channels travelled, and its corners.
    fn lead(&mut self, channels: &[AxisBox<2>], terms: &Terms<'_>) -> Result<(), Refusal> {
        let Self { chain, corners, safest, .. } = self;
        *safest = None;
        chain
            .build(channels, &terms.start.position, End::Goal(terms.goal.position), terms.budget)
            .map_err(|error| refuse::chain(&FLOOR, error))?;
        corners_of(chain, corners);
        Ok(())
    }

    /// Drives along it, and returns the length that its route is chosen by, metres: that of
    /// the drive, or with the least gap where the gap depends on the route.
    fn judge(
        &mut self,
        terms: &Terms<'_>,
        keep: Keep,
        walls: &Walls<2>,
    ) -> Result<f64, DrivingError> {
        let Keep::Part(_) = keep else {
            self.drive(terms, keep, walls)?;
            return Ok(self.path.length());
        };
        let Self { chain, corners, path, .. } = self;
        let task = task(terms, chain, corners, walls);
        driving::route(&task, Gaps::Uniform(LEAST_GAP), path, terms.budget)?;
        let length = path.length();
        self.drive(terms, keep, walls)?;
        Ok(length)
    }

    /// Drives along it.
    fn drive(
        &mut self,
        terms: &Terms<'_>,
        keep: Keep,
        walls: &Walls<2>,
    ) -> Result<(), DrivingError> {
        let Self { chain, corners, gaps, path, safest } = self;
        let task = task(terms, chain, corners, walls);
        gaps.clear();
        match keep {
            Keep::Gap(gap) => gaps.resize(corners.len(), gap),
            Keep::Gaps(given) => gaps.extend(given.iter().copied().filter_map(one_number)),
            Keep::Part(part) => {
                let safest = match *safest {
                    Some(safest) => safest,
                    None => *safest.insert(driving::safest(&task, path, terms.budget)?),
                };
                gaps.resize(corners.len(), safest * part);
            }
        }
        driving::drive(&task, Gaps::PerCorner(gaps), path, terms.budget)
    }
}

/// What is asked of a robot that is to travel these channels.
fn task<'a>(
    terms: &Terms<'_>,
    chain: &Chain<2>,
    corners: &'a [Corner],
    walls: &'a Walls<2>,
) -> Drive<'a> {
    let channels = chain.channels();
    Drive {
        footprint: terms.footprint,
        start: terms.start,
        goal: terms.goal,
        start_turn: terms.start_turn,
        first: channels[0],
        last: channels[channels.len() - 1],
        corners,
        walls,
    }
}

impl<'a> Terms<'a> {
    fn of(scene: &SceneRequest, budget: &'a Budget<'a>) -> Result<Self, Refusal> {
        let Body::Footprint(footprint) = &scene.body else {
            return Err(Refusal::invalid("body", "body: a mobile robot's body is a footprint"));
        };
        let footprint = Footprint::new(footprint.width, footprint.length).map_err(|error| {
            let message = format!("body.footprint: {error}");
            let least = error.width.min(error.length);
            Refusal {
                has: Some(least),
                least: Some(0.0),
                ..Refusal::invalid("body.footprint", message)
            }
        })?;
        let Some(start) = scene.start else {
            return Err(Refusal::invalid("start", "start is missing: a drive needs a start pose"));
        };
        let Some(goal) = scene.goal else {
            return Err(Refusal::invalid("goal", "goal is missing: a drive needs a goal"));
        };
        check::finite("start.position", start.position.as_slice())?;
        check::finite("start.heading", &[start.heading])?;
        check::finite("goal.position", goal.position.as_slice())?;
        check::finite("goal.heading", goal.heading.as_slice())?;
        Ok(Self {
            budget,
            footprint,
            start: driving::Pose {
                position: check::vector(&start.position),
                heading: start.heading,
            },
            goal: driving::Goal { position: check::vector(&goal.position), heading: goal.heading },
            start_turn: match scene.start_turn {
                None | Some(message::StartTurn::InPlace) => StartTurn::InPlace,
                Some(message::StartTurn::WhileMoving) => StartTurn::WhileMoving,
            },
            limits: check::limits(&scene.limits)?,
            sampling: check::sampling(scene.sampling)?,
        })
    }
}

/// Where it is too narrow for a robot that keeps this gap, but not for the robot, the gap is
/// at fault.
fn with_less_gap(
    refused: Refused,
    footprint: &Footprint,
    gap: Option<f64>,
    field: impl Fn() -> String,
) -> Refused {
    let Refusal { code: ErrorCode::NoRoute, junction: Some(_), has: Some(width), .. } =
        refused.refusal
    else {
        return refused;
    };
    let Some(gap) = gap.filter(|gap| *gap > 0.0) else { return refused };
    let most = limits::greatest_gap(footprint, width);
    let refusal = if width > limits::least_width(footprint) && most > 0.0 {
        refuse::less_gap(field(), refused.refusal, gap, most)
    } else {
        refused.refusal
    };
    // Another gap may lead another way.
    Refused { refusal, whole: false }
}

/// A robot keeps one gap from a corner, in all directions.
fn one_number(gap: Gap) -> Option<f64> {
    match gap {
        Gap::Uniform(gap) => Some(gap),
        Gap::PerAxis(gaps) => match gaps.as_slice() {
            [gap] => Some(*gap),
            _ => None,
        },
    }
}

fn wrong_gap(field: String) -> Refusal {
    let message = format!("{field}: a robot keeps one gap (one number) from each corner");
    Refusal::invalid(field, message)
}
