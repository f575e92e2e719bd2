//! Driving: the rectangular mobile robot through corridors (paper, section 5).

use std::mem;
use std::sync::Arc;

use planning::any_angle::{self, NoMotion, Planner, RobotMotion};
use planning::budget::{Budget, Spent};
use planning::driving::{DrivingError, limits};
use planning::free_space::floor::Floor;
use planning::free_space::walls::{Complement, Walls};
use planning::route::{self, Judgement, RouteError, Router};
use planning::trajectory::{Profile, Stops, smooth_drive};
use schemas::convert::{Certificate, PartSink, TrajectoryWriter};
use schemas::message::{self, ClearanceWish, Corners, ErrorCode, Refusal, SceneRequest};
use schemas::wire::ReplyHeader;

use crate::answers::{Job, Pace, Resources, Stop, answer_each};
use crate::entries::Entry;
use crate::free_space::{Buffers, FreeSpace, given_channels};
use crate::parts::{self, Parts};
use crate::refuse::{self, FLOOR, Refused};
use crate::scene::Scene;
use crate::stop::StopFlag;
use crate::wish::{Wish, Wishes};

mod anywhere;
mod course;
mod errand;
mod smooth;

use anywhere::AnywhereJob;
use course::{Course, KeptGap};
use errand::Errand;

/// Memory for driving tasks.
#[derive(Debug, Default)]
pub(crate) struct Driving {
    buffers: Buffers<2>,
    memory: Memory,
    anywhere: anywhere::Memory,
}

#[derive(Debug, Default)]
struct Memory {
    complement: Complement<2>,
    router: Router<2, route::RobotMover>,
    course: Course,
    /// For a course that is tried.
    spare: Course,
    profile: Profile,
}

/// A driving task whose scene has been read and checked.
struct DrivingJob<'a> {
    errand: Errand,
    pace: Pace,
    /// Whether corners are to be smooth.
    is_smooth: bool,
    space: FreeSpace<'a, 2>,
    walls: Arc<Entry<Walls<2>>>,
    /// For which gap the course was found; `None`: for none yet.
    found_for: Option<AnyGap>,
    /// What full reports are made with.
    certifier: Option<(Floor, Planner)>,
    /// Of the answer at hand, where the request asks for a full report.
    certificate: Option<Certificate>,
    /// The answer at hand, where the rules lead to no free pose at the goal: driven at large.
    at_large: Option<RobotMotion>,
    memory: &'a mut Memory,
    resources: Resources<'a>,
}

/// The gap that a route is found for; `None` where the gap depends on the route.
type AnyGap = Option<f64>;

impl Driving {
    /// Answers a request for a mobile robot.
    pub(crate) fn answer<S: PartSink>(
        &mut self,
        scene: Scene<'_>,
        wishes: &Wishes<'_>,
        mut resources: Resources<'_>,
        stop: &StopFlag,
        parts: &mut Parts<'_, S>,
    ) -> Result<(), Stop<S::Error>> {
        let Self { buffers, memory, anywhere } = self;
        let any_order = is_any_order(scene);
        let errand = Errand::of(scene, any_order)?;
        let is_smooth = scene.corners == Some(Corners::Smooth);
        let stops = match scene.stop_at_joints {
            Some(true) => Stops::AtJoints,
            _ if is_smooth => Stops::AtJoints,
            _ => Stops::AtTurns,
        };
        let pace = Pace::of(scene, wishes, stops)?;
        if any_order {
            let budget = resources.budget;
            let space = (&mut *buffers, &mut memory.complement);
            let mut job = AnywhereJob::new(scene, (errand, pace), space, anywhere, resources)?;
            return answer_each(&mut job, wishes, (budget, stop), parts);
        }
        let mut space = given_channels(scene, &FLOOR, buffers, &mut resources)?;
        let walls = space.walls(None, &mut memory.complement, &mut resources)?.clone();
        if let FreeSpace::InOrder(channels, _) = &space {
            let route = 0..channels.len();
            memory.course.lead(channels, route, &errand, resources.budget)?;
        }
        let (found_for, budget) = (None, resources.budget);
        let mut job = DrivingJob {
            errand,
            pace,
            is_smooth,
            space,
            walls,
            found_for,
            certifier: None,
            certificate: None,
            at_large: None,
            memory,
            resources,
        };
        answer_each(&mut job, wishes, (budget, stop), parts)
    }

    /// The memory that it holds, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { buffers, memory, anywhere } = self;
        let Memory { complement, router, course, spare, profile } = memory;
        let courses = course.bytes() + spare.bytes();
        anywhere.bytes()
            + buffers.bytes()
            + complement.bytes()
            + router.bytes()
            + courses
            + profile.bytes()
    }
}

/// Whether the robot may travel its free space in any order, right up to the walls: unless
/// channels are to be travelled in order by the rules, or clearance is measured to solids in them.
fn is_any_order(scene: Scene<'_>) -> bool {
    let message::FreeSpace { channels, in_order, solids, .. } = &scene.free_space;
    let Some(channels) = channels else { return true };
    let has_solids = solids.as_ref().is_some_and(|solids| !solids.is_empty());
    let by_the_rules = *in_order || channels.len() == 1;
    !has_solids && (!by_the_rules || asks_for_more(scene))
}

/// Whether a request asks for what the rules can't do.
fn asks_for_more(scene: Scene<'_>) -> bool {
    let SceneRequest { reverse, turn_in_place, min_turn_radius, clearance, .. } = scene.request;
    *reverse == Some(true)
        || *turn_in_place == Some(false)
        || min_turn_radius.is_some()
        || matches!(clearance, ClearanceWish::AtLeast(_))
}

impl Job for DrivingJob<'_> {
    fn plan(&mut self, wish: &Wish<'_>) -> Result<(), Refused> {
        let kept = KeptGap::of(wish, self.resources.budget)?;
        let gap = match kept {
            KeptGap::Same(gap) => Some(gap),
            KeptGap::Each(_) | KeptGap::Part(_) => None,
        };
        self.at_large = None;
        if self.space.graph().is_none() || self.found_for == Some(gap) {
            let Self { errand, memory, walls, resources, .. } = self;
            match memory.course.drive(errand, kept, walls, resources.budget) {
                Ok(()) => {}
                Err(error) => {
                    // The rules lead to the goal in one direction; another may do.
                    let is_free = matches!(error, DrivingError::GoalTouchesWall { .. })
                        && errand.goal.heading.is_none();
                    let refused = refuse::driving(wish.field(), error);
                    match gap {
                        Some(gap) if is_free => return self.drive_at_large(gap, refused),
                        _ => return Err(refused),
                    }
                }
            }
        } else {
            if let KeptGap::Each(gaps) = kept {
                let error = RouteError::GapPerJunction { has: gaps.len() };
                return Err(refuse::route(&FLOOR, wish.field(), error));
            }
            self.found_for = None;
            self.find(wish, kept, gap)?;
            self.found_for = Some(gap);
        }
        if self.is_smooth {
            self.smooth()?;
        }
        self.certificate = None;
        if self.errand.full_report {
            self.certificate = Some(self.certify()?);
        }
        let Memory { course, profile, .. } = &mut *self.memory;
        let cells = course.gaps.len() + course.route.len();
        self.pace.plan(course.path.legs(), profile, cells, &self.resources)
    }

    fn write<S: PartSink>(&self, last: bool, parts: &mut Parts<'_, S>) -> Result<(), S::Error> {
        if let Some(found) = &self.at_large {
            let Memory { course, profile, .. } = &*self.memory;
            return anywhere::write(found, &course.route, (&self.pace, profile), last, parts);
        }
        let Memory { course: Course { path, gaps, route, .. }, profile, .. } = &*self.memory;
        let legs = path.legs().iter().zip(path.leg_clearances());
        let lists = TrajectoryWriter {
            gaps: gaps.iter().copied(),
            route: route.iter().map(|channel| *channel as u64),
            channels: parts::boxes::<2>(&[]),
            legs: legs.map(|(leg, near)| parts::leg(leg, *near)),
            samples: self.pace.states(path.legs(), profile),
        };
        let fill = |header: &mut ReplyHeader| {
            header.dimension = 2;
            header.gaps_per_junction = 1;
            header.length = path.length();
            header.duration = profile.duration();
            parts::clearance(header, path.clearance().as_ref());
            if let Some(certificate) = self.certificate {
                header.set_certificate(certificate);
            }
            header.set_exceeds(self.pace.exceeded(path.legs(), profile));
            header.set_stops(self.pace.stops_on_the_way(path.legs(), profile));
        };
        parts.trajectory(fill, lists, last)
    }
}

/// The floor among walls, made once.
fn floor_once<'a>(
    known: &'a mut Option<(Floor, Planner)>,
    walls: &Walls<2>,
    budget: &Budget<'_>,
) -> Result<&'a mut (Floor, Planner), Refused> {
    match known {
        Some(known) => Ok(known),
        none => Ok(none.insert((anywhere::floor_among(walls, budget)?, Planner::default()))),
    }
}

impl DrivingJob<'_> {
    /// Drives in the same channels without the rules; if that does not do either, `refused` stands.
    fn drive_at_large(&mut self, gap: f64, refused: Refused) -> Result<(), Refused> {
        let Self { errand, walls, certifier, memory, pace, is_smooth, resources, .. } = self;
        let (budget, mut found) = (resources.budget, RobotMotion::default());
        let (floor, planner) = floor_once(certifier, walls, budget)?;
        let task = errand.among(walls, floor);
        match any_angle::drive(&task, any_angle::Wish::Gap(gap), planner, &mut found, budget) {
            Ok(()) => {}
            Err(NoMotion::Spent(Spent::Stopped)) => return Err(Spent::Stopped.into()),
            Err(_) => return Err(refused),
        }
        if *is_smooth {
            let task = (&*errand, pace.limits());
            smooth::smooth(task, (walls, floor), planner, &mut found, budget)?;
        }
        let Memory { course, profile, .. } = &mut **memory;
        pace.plan(&found.legs, profile, 1 + course.route.len(), resources)?;
        self.at_large = Some(found);
        Ok(())
    }

    /// Puts smooth turns in place of the arcs of the answer at hand.
    fn smooth(&mut self) -> Result<(), Refused> {
        let Self { errand, walls, memory, pace, resources, .. } = self;
        let path = &mut memory.course.path;
        let task = smooth::smooth_driving(errand, walls, pace.limits());
        let smoothed = smooth_drive(&task, path.legs(), resources.budget)?;
        path.set_legs(smoothed.legs, smoothed.leg_clearances, smoothed.clearance);
        Ok(())
    }

    /// The free clearance and the bound of the answer at hand.
    fn certify(&mut self) -> Result<Certificate, Refused> {
        let Self { errand, walls, certifier, memory, resources, .. } = self;
        let budget = resources.budget;
        let (floor, planner) = floor_once(certifier, walls, budget)?;
        let path = &memory.course.path;
        let mut motion = RobotMotion {
            legs: path.legs().to_vec(),
            length: path.length(),
            clearance: path.clearance(),
            is_complete: true,
            ..RobotMotion::default()
        };
        any_angle::certify(&errand.among(walls, floor), planner, &mut motion, budget)?;
        Ok(anywhere::certificate(&motion))
    }

    /// Finds the channels to travel for a robot that is to keep this gap; `None`: any.
    fn find(&mut self, wish: &Wish<'_>, kept: KeptGap<'_>, gap: AnyGap) -> Result<(), Refused> {
        if let Some(gap) = gap.filter(|gap| gap.is_nan() || *gap == f64::NEG_INFINITY) {
            let error = RouteError::GapNotPositive { axis: 0, gap, least: 0.0 };
            return Err(refuse::route(&FLOOR, wish.field(), error));
        }
        let Self { errand, space, walls, memory, resources, .. } = self;
        let Memory { router, course, spare, .. } = &mut **memory;
        let Some(graph) = space.graph() else { return Ok(()) };
        let mut robot = errand.robot(gap.unwrap_or(0.0));
        let budget = resources.budget;
        let mut first = None;
        let found = router.find_judged(graph, Some(walls), &mut robot, budget, |route, _| {
            let led = spare.lead(graph.channels(), route.iter().copied(), errand, budget);
            let (judgement, refused) = match led {
                Ok(()) => match spare.judge(errand, kept, walls, budget) {
                    Ok(length) => {
                        return Ok(Judgement::Accepted { length, value: mem::take(spare) });
                    }
                    Err(error) => (
                        Judgement::of_refusal(&error, spare.path.legs())?,
                        refuse::driving(wish.field(), error),
                    ),
                },
                Err(Refused::Spent(spent)) => return Err(spent),
                Err(refused) => (Judgement::Hopeless, refused),
            };
            first.get_or_insert(refused);
            Ok(judgement)
        });
        let found = found.map_err(|error| match (error, first) {
            (RouteError::Blocked, Some(refused)) => refused,
            (error, _) => {
                let refused = refuse::route(&FLOOR, wish.field(), error);
                with_less_gap(refused, errand, gap, wish)
            }
        })?;
        *spare = mem::replace(course, found);
        Ok(())
    }
}

/// Where it is too narrow for a robot that keeps this gap, but not for the robot, the gap is
/// at fault.
fn with_less_gap(refused: Refused, errand: &Errand, gap: AnyGap, wish: &Wish<'_>) -> Refused {
    let Some(gap) = gap.filter(|gap| *gap > 0.0) else { return refused };
    let too_narrow = match refused {
        Refused::Request(refusal) if is_narrow(&refusal) => refusal,
        other => return other,
    };
    let footprint = &errand.footprint;
    let width = too_narrow.has.unwrap_or(0.0);
    let most = limits::greatest_gap(footprint, width);
    // Another gap may lead another way.
    Refused::Answer(if width > limits::least_width(footprint) && most > 0.0 {
        refuse::less_gap(wish.field(), too_narrow, gap, most)
    } else {
        too_narrow
    })
}

/// Whether a route would lead through a junction that is too narrow.
fn is_narrow(refusal: &Refusal) -> bool {
    refusal.code == ErrorCode::NoRoute && refusal.junction.is_some() && refusal.has.is_some()
}
