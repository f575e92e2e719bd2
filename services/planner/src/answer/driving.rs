//! Driving: the rectangular mobile robot through corridors (paper, section 5).

use planning::clearance::rectangle::Footprint;
use planning::clearance::walls::{Wall, Walls};
use planning::driving::{
    self, Corner, Drive, DrivingError, Gaps, Path, StartTurn, corners_of, limits,
};
use planning::free_space::route::Traveller;
use planning::free_space::{Chain, End};
use planning::geometry::{AxisBox, Vector};
use planning::trajectory::{Limits, Profile, Sampling, Stops};
use schemas::convert::{PartSink, TrajectoryWriter};
use schemas::message::{self, Body, ErrorCode, Gap, Refusal, RequestKey, SceneRequest};
use schemas::wire::ReplyHeader;

use super::free_space::FreeSpace;
use super::parts::{self, Parts};
use super::refuse::{self, FLOOR};
use super::{Refused, Wish, Wishes, answer_each, check};

/// Memory for driving tasks.
#[derive(Debug, Default)]
pub(super) struct Driving {
    solid: Vec<Vector<2>>,
    free_space: FreeSpace<2>,
    chain: Chain<2>,
    corners: Vec<Corner>,
    walls: Walls<2>,
    /// The gap at every corner of the answer at hand, metres.
    gaps: Vec<f64>,
    path: Path,
    profile: Profile,
}

/// What all answers to a request share.
struct Terms {
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
        sink: &mut S,
    ) -> Result<Result<(), S::Error>, Refusal> {
        let terms = Terms::of(scene)?;
        self.free_space.read(scene, &FLOOR)?;
        let Self { solid, walls, free_space, .. } = self;
        let size = [terms.footprint.width(), terms.footprint.length()];
        check::push_solids(scene, &FLOOR, solid, walls, free_space, &size)?;
        if free_space.is_made() {
            let bounds = *free_space.bounds().expect("checked: solids alone bound no floor");
            push_inside(&bounds, walls);
            free_space.make(bounds, Vector::repeat(terms.footprint.width()))?;
        }
        match check::has_solids(scene) {
            true => walls.index(),
            false => walls.set_complement(free_space.channels(), None),
        }
        if !self.free_space.is_routed() {
            self.build_chain(&terms)?;
        }

        let mut safest = None;
        answer_each(key, scene.id, wishes, sink, |index, last, parts| {
            self.plan(&terms, wishes, index, &mut safest)?;
            Ok(self.send(&terms, wishes.sampled(), last, parts))
        })
    }

    /// Makes the chain of the channels travelled, and its corners.
    fn build_chain(&mut self, terms: &Terms) -> Result<(), Refusal> {
        let Self { chain, free_space, corners, .. } = self;
        chain
            .build(free_space.travelled(), &terms.start.position, End::Goal(terms.goal.position))
            .map_err(|error| refuse::chain(&FLOOR, error))?;
        corners_of(chain, corners);
        Ok(())
    }

    /// Finds the channels to travel for a robot that is to keep this gap; none: any.
    fn find_route(
        &mut self,
        terms: &Terms,
        gap: Option<f64>,
        field: impl Fn() -> String,
    ) -> Result<(), Refused> {
        let footprint = &terms.footprint;
        // What the robot needs to turn (docs/method.md 6.4: R(g) < W), and its guiding circle (5.1).
        let needs = limits::outer_radius(footprint, gap.unwrap_or(0.0));
        let radius = footprint.width() / 2.0 + gap.unwrap_or(0.0);
        let traveller =
            || Ok(Traveller::robot(terms.start.position, Vector::repeat(needs), radius));
        self.free_space
            .find(&FLOOR, &field, traveller, End::Goal(terms.goal.position))
            .map_err(|refused| with_less_gap(refused, footprint, gap, field))?;
        Ok(self.build_chain(terms)?)
    }

    /// Plans one answer; `path`, `gaps` and `profile` then hold it. `safest` is sought
    /// once for all answers that want it.
    fn plan(
        &mut self,
        terms: &Terms,
        wishes: &Wishes,
        index: u32,
        safest: &mut Option<f64>,
    ) -> Result<(), Refused> {
        let wish = wishes.get(index);
        if self.free_space.is_routed() {
            let gap = match wish {
                Wish::Gap(gap) => one_number(gap),
                Wish::Gaps(_) => {
                    let field = wishes.field(index);
                    let message = format!("{field}: no gap per corner before the route is known");
                    return Err(Refusal::invalid(field, message).into());
                }
                Wish::Safest | Wish::Fraction(_) => None,
            };
            self.find_route(terms, gap, || wishes.field(index))?;
        }
        let Self { chain, corners, walls, gaps, path, profile, .. } = self;
        let channels = chain.channels();
        let task = Drive {
            footprint: terms.footprint,
            start: terms.start,
            goal: terms.goal,
            start_turn: terms.start_turn,
            first: channels[0],
            last: channels[channels.len() - 1],
            corners,
            walls,
        };
        let refused = |error: DrivingError| refuse::driving(wishes.field(index), error);
        gaps.clear();
        match wish {
            Wish::Gap(gap) => {
                let gap = one_number(gap).ok_or_else(|| wrong_gap(wishes.field(index)))?;
                gaps.resize(corners.len(), gap);
            }
            Wish::Gaps(list) => {
                for (corner, gap) in list.iter().enumerate() {
                    let field = || format!("{}[{corner}]", wishes.field(index));
                    gaps.push(one_number(*gap).ok_or_else(|| wrong_gap(field()))?);
                }
            }
            wish @ (Wish::Safest | Wish::Fraction(_)) => {
                let safest = match *safest {
                    Some(safest) => safest,
                    None => *safest.insert(driving::safest(&task, path).map_err(refused)?),
                };
                let fraction = if let Wish::Fraction(fraction) = wish { fraction } else { 1.0 };
                gaps.resize(corners.len(), safest * fraction);
            }
        }
        driving::drive(&task, Gaps::PerCorner(gaps), path).map_err(refused)?;
        profile.plan(path.legs(), &terms.limits, Stops::AtTurns);
        wishes.check_samples(profile, terms.sampling)
    }

    fn send<S: PartSink>(
        &self,
        terms: &Terms,
        sampled: bool,
        last: bool,
        parts: &mut Parts<S>,
    ) -> Result<(), S::Error> {
        let Self { path, gaps, profile, free_space, .. } = self;
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

impl Terms {
    fn of(scene: &SceneRequest) -> Result<Self, Refusal> {
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

/// The sides of the bounds, seen from within.
fn push_inside(bounds: &AxisBox<2>, walls: &mut Walls<2>) {
    let (min, max) = (bounds.min(), bounds.max());
    let (right, left) = (Vector::from([max.x, min.y]), Vector::from([min.x, max.y]));
    for (from, to) in [(min, right), (right, max), (left, max), (min, left)] {
        walls.push(Wall { from, to });
    }
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
