//! Assembly tasks: a body that translates out of a part (paper, section 3), or into
//! it by the same way-points in reverse.

use std::mem;

use planning::budget::{Budget, Spent};
use planning::clearance::Clearance;
use planning::clearance::translating::{Body, translating_clearance};
use planning::disassembly::{self, DisassemblyError, Path, disassemble};
use planning::free_space::{Chain, End};
use planning::geometry::{Direction, Sign, Vector};
use planning::motion::Curve;
use planning::route::{Judgement, Motion, Translating};
use planning::trajectory::{Limits, Profile, Sampling, Stops};
use schemas::convert::{PartSink, TrajectoryWriter};
use schemas::message::{self, Gap, Refusal, RequestKey, SceneRequest, Task};
use schemas::wire::ReplyHeader;

use super::cache::Cache;
use super::free_space::FreeSpace;
use super::parts::{self, Parts};
use super::refuse::{self, Axes, PLANE, SPACE};
use super::{Refused, Wish, Wishes, answer_each, check};

/// Memory for assembly tasks in `D` dimensions.
#[derive(Debug, Default)]
pub(super) struct Assembly<const D: usize> {
    body: Vec<Vector<2>>,
    free_space: FreeSpace<D, Translating<D>>,
    chain: Chain<D>,
    /// The exit at hand.
    exit: Option<Direction>,
    exits: Vec<Direction>,
    gaps: Vec<Vector<D>>,
    path: Path<D>,
    /// Of the legs, and of the whole motion; none where there are no walls.
    clearances: Vec<Clearance<D>>,
    clearance: Option<Clearance<D>>,
    profile: Profile,
}

/// What all answers to a request share.
struct Terms<'a, const D: usize> {
    budget: &'a Budget<'a>,
    scene: &'a SceneRequest,
    axes: Axes,
    body: Body<'a, D>,
    limits: Limits,
    sampling: Sampling,
}

impl Assembly<2> {
    /// Answers a request for a body in the plane. `Err`: the request as a whole is
    /// refused, and nothing has been sent.
    pub(super) fn answer<S: PartSink>(
        &mut self,
        key: RequestKey,
        scene: &SceneRequest,
        wishes: &Wishes,
        cache: &mut Cache,
        sink: &mut S,
    ) -> Result<Result<(), S::Error>, Refusal> {
        let budget = wishes.budget;
        self.free_space.read(scene, &PLANE, budget, cache)?;
        match &scene.body {
            message::Body::Polygon(vertices) => {
                let field = || "body.polygon".to_owned();
                let body = check::polygon(field, vertices, &mut self.body, budget)?;
                let terms = Terms::new(scene, PLANE, Body::from_polygon(&body), budget)?;
                self.take_in_solids(&terms, cache)?;
                let answered = self.answer_body(key, &terms, wishes, cache, sink);
                self.body = body.into_vertices();
                answered
            }
            message::Body::Box(sides) => {
                let body = check::axis_box(|| "body.box".to_owned(), &PLANE, sides)?;
                let terms = Terms::new(scene, PLANE, Body::from_box(&body), budget)?;
                self.take_in_solids(&terms, cache)?;
                self.answer_body(key, &terms, wishes, cache, sink)
            }
            message::Body::Footprint(_) => Err(check::wrong_body("body.footprint")),
        }
    }

    fn take_in_solids(&mut self, terms: &Terms<2>, cache: &mut Cache) -> Result<(), Refusal> {
        let size = terms.body.bounds().size();
        let Terms { scene, budget, .. } = terms;
        self.free_space.take_in_solids(scene, &PLANE, size.as_slice(), budget, cache)
    }
}

impl Assembly<3> {
    /// Answers a request for a body in space; see [`Assembly::<2>::answer`].
    pub(super) fn answer<S: PartSink>(
        &mut self,
        key: RequestKey,
        scene: &SceneRequest,
        wishes: &Wishes,
        cache: &mut Cache,
        sink: &mut S,
    ) -> Result<Result<(), S::Error>, Refusal> {
        let budget = wishes.budget;
        self.free_space.read(scene, &SPACE, budget, cache)?;
        self.free_space.take_in_solids(scene, &SPACE, budget, cache)?;
        match &scene.body {
            message::Body::Box(sides) => {
                let body = check::axis_box(|| "body.box".to_owned(), &SPACE, sides)?;
                let terms = Terms::new(scene, SPACE, Body::from_box(&body), budget)?;
                self.answer_body(key, &terms, wishes, cache, sink)
            }
            message::Body::Polygon(_) => Err(check::flat("body.polygon".to_owned())),
            message::Body::Footprint(_) => Err(check::wrong_body("body.footprint")),
        }
    }
}

impl<'a, const D: usize> Terms<'a, D> {
    fn new(
        scene: &'a SceneRequest,
        axes: Axes,
        body: Body<'a, D>,
        budget: &'a Budget<'a>,
    ) -> Result<Self, Refusal> {
        Ok(Self {
            budget,
            scene,
            axes,
            body,
            limits: check::limits(&scene.limits)?,
            sampling: check::sampling(scene.sampling)?,
        })
    }
}

impl<const D: usize> Assembly<D> {
    /// Lets go of what belongs to the cache: the request has ended.
    pub(super) fn release(&mut self) {
        self.free_space.release();
    }

    /// Answers for a body that is checked, solids being taken in.
    fn answer_body<S: PartSink>(
        &mut self,
        key: RequestKey,
        terms: &Terms<D>,
        wishes: &Wishes,
        cache: &mut Cache,
        sink: &mut S,
    ) -> Result<Result<(), S::Error>, Refusal> {
        self.set_exits(terms)?;
        if let [exit] = self.exits[..] {
            self.prepare(terms, exit, cache)?;
        }
        answer_each(key, terms.scene.id, wishes, sink, |index, last, parts| {
            let exit = self.plan(terms, wishes, index, cache)?;
            Ok(self.send(terms, exit, wishes.sampled(), last, parts))
        })
    }

    /// The ways out that the request names, or up.
    fn set_exits(&mut self, terms: &Terms<D>) -> Result<(), Refusal> {
        self.exits.clear();
        for exit in &terms.scene.exit {
            self.exits.push(check::direction::<D>(&terms.axes, *exit)?);
        }
        if self.exits.is_empty() {
            let up = terms.axes[..D].iter().position(|axis| *axis == 2).unwrap_or(0);
            self.exits.push(Direction { axis: up, sign: Sign::Positive });
        }
        Ok(())
    }

    /// Makes what all ways to an exit have in common.
    fn prepare(
        &mut self,
        terms: &Terms<D>,
        exit: Direction,
        cache: &mut Cache,
    ) -> Result<(), Refusal> {
        let free_space = &mut self.free_space;
        if free_space.is_made() {
            let body = terms.body.bounds();
            let Some(cavity) = free_space.cavity(body, exit) else {
                let message = "free_space.solids bound no cavity";
                return Err(Refusal::invalid("free_space.solids", message));
            };
            free_space.make(cavity, body.size(), terms.budget, cache)?;
            let traveller = Translating::new(body, disassembly::Gap::Safest, End::Exit(exit));
            let traveller = traveller.ok();
            free_space.check_mouth(&terms.axes, &cavity, exit, traveller, terms.budget)?;
        }
        self.exit = Some(exit);
        if self.free_space.is_routed() { Ok(()) } else { self.build_chain(terms, exit, cache) }
    }

    /// Makes the chain of the channels travelled, and the walls where they are the
    /// channels' complement.
    fn build_chain(
        &mut self,
        terms: &Terms<D>,
        exit: Direction,
        cache: &mut Cache,
    ) -> Result<(), Refusal> {
        self.chain
            .build(
                self.free_space.travelled(),
                &terms.body.bounds().center(),
                End::Exit(exit),
                terms.budget,
            )
            .map_err(|error| refuse::chain(&terms.axes, error))?;
        if !check::has_solids(terms.scene) {
            self.free_space.wall_in(self.chain.mouth(), terms.budget, cache)?;
        }
        Ok(())
    }

    /// Plans one answer; `path`, `clearances` and `profile` then hold it. Where there are
    /// several exits, it is the one with the shortest path, and its exit is returned.
    fn plan(
        &mut self,
        terms: &Terms<D>,
        wishes: &Wishes,
        index: u32,
        cache: &mut Cache,
    ) -> Result<Option<message::Direction>, Refused> {
        let wish = wishes.get(index);
        let exit = match self.exits[..] {
            [_] => {
                self.find_path(terms, wish, cache, || wishes.field(index))?;
                None
            }
            _ => Some(self.shortest(terms, wish, cache, || wishes.field(index))?),
        };
        let Self { path, clearances, clearance, .. } = self;
        if terms.scene.task == Task::Assemble {
            // Measured on the way out: the reverse is exact in every number.
            path.reverse();
            clearances.reverse();
            if let Some(near) = clearance {
                near.at = path.length() - near.at;
            }
        }
        self.profile
            .plan(self.path.legs(), &terms.limits, Stops::EveryLeg, terms.budget)
            .map_err(refuse::spent)?;
        wishes.check_samples(&self.profile, terms.sampling)?;
        Ok(exit)
    }

    fn shortest(
        &mut self,
        terms: &Terms<D>,
        wish: Wish,
        cache: &mut Cache,
        field: impl Fn() -> String + Copy,
    ) -> Result<message::Direction, Refused> {
        let mut best: Option<(f64, usize)> = None;
        let mut first_refused = None;
        // An exit that does not do is no matter if another does.
        self.free_space.explains = false;
        for index in 0..self.exits.len() {
            let found = self
                .prepare(terms, self.exits[index], cache)
                .map_err(|refusal| Refused { refusal, whole: true })
                .and_then(|()| self.find_path(terms, wish, cache, field));
            match found {
                Ok(()) if best.is_none_or(|(length, _)| self.path.length() < length) => {
                    best = Some((self.path.length(), index));
                }
                Ok(()) => {}
                Err(_) => {
                    first_refused.get_or_insert(index);
                }
            }
        }
        self.free_space.explains = true;
        let index = best.map(|(_, index)| index).or(first_refused).unwrap_or(0);
        self.prepare(terms, self.exits[index], cache)
            .map_err(|refusal| Refused { refusal, whole: true })?;
        self.find_path(terms, wish, cache, field)?;
        Ok(terms.scene.exit[index])
    }

    /// The path to the exit that is prepared, and its clearance.
    fn find_path(
        &mut self,
        terms: &Terms<D>,
        wish: Wish,
        cache: &mut Cache,
        field: impl Fn() -> String,
    ) -> Result<(), Refused> {
        let mut gaps = mem::take(&mut self.gaps);
        let found = self.find_path_with(terms, wish, &mut gaps, cache, field);
        self.gaps = gaps;
        found
    }

    /// The same, in memory for a gap per junction.
    fn find_path_with(
        &mut self,
        terms: &Terms<D>,
        wish: Wish,
        memory: &mut Vec<Vector<D>>,
        cache: &mut Cache,
        field: impl Fn() -> String,
    ) -> Result<(), Refused> {
        let gap = match wish {
            Wish::Gap(Gap::Uniform(gap)) => disassembly::Gap::Uniform(gap),
            Wish::Gap(Gap::PerAxis(gaps)) => disassembly::Gap::PerAxis(
                per_axis(&gaps)
                    .ok_or_else(|| check::gaps_per_axis(field(), gaps.dimension(), D))?,
            ),
            Wish::Gaps(gaps) => {
                memory.clear();
                for (junction, gap) in gaps.iter().enumerate() {
                    let gap = match gap {
                        Gap::Uniform(gap) => Vector::repeat(*gap),
                        Gap::PerAxis(gaps) => per_axis(gaps).ok_or_else(|| {
                            let field = format!("{}[{junction}]", field());
                            check::gaps_per_axis(field, gaps.dimension(), D)
                        })?,
                    };
                    memory.push(gap);
                }
                disassembly::Gap::PerJunction(memory)
            }
            Wish::Safest => disassembly::Gap::Safest,
            Wish::Fraction(fraction) => disassembly::Gap::Fraction(fraction),
        };
        if let Some(exit) = self.exit.filter(|_| self.free_space.is_routed()) {
            let mut body = Translating::new(terms.body.bounds(), gap, End::Exit(exit))
                .map_err(|error| refuse::route(&terms.axes, field(), error))?;
            let found = self.free_space.find(&mut body, terms.budget, |_, _, length| {
                Ok(Judgement::Accepted { length, value: () })
            });
            found.map_err(|error| {
                let traveller = body.traveller();
                self.free_space.refuse_route(&terms.axes, field(), error, traveller, terms.budget)
            })?;
            self.build_chain(terms, exit, cache)?;
        }
        let found =
            disassemble(&self.chain, terms.body.bounds(), gap, &mut self.path, terms.budget);
        found.map_err(|error| {
            let whole = matches!(
                error,
                DisassemblyError::NoChannels
                    | DisassemblyError::BodyOutside { .. }
                    | DisassemblyError::JunctionTooSmall { .. }
            );
            Refused { refusal: refuse::disassembly(&terms.axes, field(), error), whole }
        })?;
        let Self { path, free_space, clearances, .. } = self;
        let walls = free_space.walls();
        self.clearance =
            translating_clearance(&terms.body, walls, path.legs(), clearances, terms.budget)
                .map_err(refuse::spent)?;
        match self.clearance {
            Some(near)
                if near.value <= 0.0 && !self.is_contact(terms).map_err(refuse::spent)? =>
            {
                Err(refuse::wall_in_the_way(&near).into())
            }
            _ => Ok(()),
        }
    }

    /// Whether a clearance of 0 is no more than contact, because the body stays where no solid
    /// is: in the channels (lemma 1 of docs/method.md) and, at the end, beyond the mouth.
    fn is_contact(&self, terms: &Terms<D>) -> Result<bool, Spent> {
        // All other walls are the channels' own sides.
        if !check::has_solids(terms.scene) {
            return Ok(true);
        }
        let (walls, budget) = (self.free_space.walls(), terms.budget);
        let Some(Curve::Line { to, .. }) = self.path.legs().last().map(|leg| leg.curve) else {
            return Ok(false);
        };
        // Channels made from the solids are free of them.
        if !self.free_space.is_made() {
            for channel in self.chain.channels() {
                if !walls.is_free(channel, budget)? {
                    return Ok(false);
                }
            }
        }
        walls.is_free(&terms.body.bounds().translated(&to), budget)
    }

    fn send<S: PartSink>(
        &self,
        terms: &Terms<D>,
        exit: Option<message::Direction>,
        sampled: bool,
        last: bool,
        parts: &mut Parts<S>,
    ) -> Result<(), S::Error> {
        let Self { path, clearances, clearance, profile, free_space, .. } = self;
        let legs = path.legs();
        let lists = TrajectoryWriter {
            gaps: (0..path.gaps().len() * D).map(|at| path.gaps()[at / D][at % D]),
            route: free_space.route(),
            channels: free_space.named(),
            legs: legs.iter().zip(clearances.iter()).map(|(leg, near)| parts::leg(leg, near.value)),
            samples: parts::States(sampled.then(|| profile.samples(legs, terms.sampling))),
        };
        let fill = |header: &mut ReplyHeader| {
            header.dimension = D as u32;
            header.gaps_per_junction = D as u32;
            header.exit = ReplyHeader::exit_code(exit);
            header.length = path.length();
            header.duration = profile.duration();
            parts::clearance(header, clearance.as_ref());
        };
        parts.trajectory(fill, lists, last)
    }
}

fn per_axis<const D: usize>(gaps: &message::Vector) -> Option<Vector<D>> {
    (gaps.dimension() == D).then(|| check::vector(gaps))
}
