//! Assembly tasks: a body that translates out of a part (paper, section 3), or into
//! it by the same way-points in reverse.

use std::mem;

use planning::disassembly::{self, DisassemblyError};
use planning::free_space::End;
use planning::free_space::walls::Complement;
use planning::geometry::{AxisBox, Direction, HalfSpace, Sign, Vector};
use planning::route::{BodyMover, Mover, Router};
use planning::trajectory::Profile;
use planning::translation::{self, NoWay};
use schemas::convert::{Certificate, PartSink, TrajectoryWriter};
use schemas::message::{self, PathChoice, Task};
use schemas::wire::ReplyHeader;

use crate::answers::{Job, Resources, Stop, answer_each};
use crate::check;
use crate::free_space::{Buffers, Explain, FreeSpace, Outlines, Source, closed_to_union};
use crate::parts::{self, Parts};
use crate::refuse::{self, PLANE, Refused, SPACE};
use crate::scene::Scene;
use crate::stop::StopFlag;
use crate::wish::{Gaps, Wish, Wishes};

mod body;
mod course;
pub(crate) mod frames;
mod gap;
mod slide;
mod terms;

use body::BodyBuffers;
use course::Course;
use frames::Ends;
use gap::gap_of;
use slide::{PlaneSlide, Slide};
use terms::Terms;

/// Memory for assembly tasks in `D` dimensions.
#[derive(Debug, Default)]
pub(crate) struct Assembly<const D: usize> {
    body: BodyBuffers<D>,
    buffers: Buffers<D>,
    memory: Memory<D>,
}

#[derive(Debug, Default)]
struct Memory<const D: usize> {
    complement: Complement<D>,
    router: Router<D, BodyMover<D>>,
    gaps: Vec<Vector<D>>,
    course: Course<D>,
    /// Of several exits, the best so far.
    best: Course<D>,
    profile: Profile,
}

/// A part that is too wide by no more than twice this part of its greatest coordinate fits exactly.
const CONTACT: f64 = 1e-9;

/// So many directions lead out of a part in three dimensions.
const MOST_EXITS: usize = 6;

/// An assembly task whose scene has been read and checked.
struct AssemblyJob<'a, 'w, const D: usize> {
    terms: Terms<'a, D>,
    source: Source<'a, D>,
    /// The ways out that the request names, each once; at least one.
    ways: &'w mut WaysOut<'a, D>,
    /// The way out of the answer planned last.
    chosen: usize,
    memory: &'a mut Memory<D>,
    resources: Resources<'a>,
}

type WaysOut<'a, const D: usize> = [Option<WayOut<'a, D>>; MOST_EXITS];

/// A way out of the part, and the free space for it once it is looked at.
struct WayOut<'a, const D: usize> {
    exit: Direction,
    /// As the request names it; `None` if it doesn't.
    name: Option<message::Direction>,
    /// Where the solids end, if they bound the free space.
    mouth: Option<HalfSpace>,
    space: Option<FreeSpace<'a, D>>,
}

impl Assembly<2> {
    /// Answers a request for a body in the plane.
    pub(crate) fn answer<S: PartSink>(
        &mut self,
        scene: Scene<'_>,
        wishes: &Wishes<'_>,
        mut resources: Resources<'_>,
        stop: &StopFlag,
        parts: &mut Parts<'_, S>,
    ) -> Result<(), Stop<S::Error>> {
        let Self { body: memory_of_body, buffers, memory } = self;
        memory_of_body.end();
        let ends = Ends::of(scene)?;
        let given = ends.body.as_ref().unwrap_or(&scene.body);
        let body = memory_of_body.read(given, resources.budget)?;
        let slide = PlaneSlide::default();
        let terms = Terms::new(scene, PLANE, (body, Some(&slide), &ends), wishes)?;
        let source = Source::read(scene, &PLANE, body.is_box(), buffers, &mut resources)?;
        let budget = resources.budget;
        let mut ways = [const { None }; MOST_EXITS];
        let mut job = AssemblyJob::new(terms, source, &mut ways, memory, resources);
        job.find_ways_out()?;
        answer_each(&mut job, wishes, (budget, stop), parts)
    }
}

impl Assembly<3> {
    /// Answers a request for a body in space.
    pub(crate) fn answer<S: PartSink>(
        &mut self,
        scene: Scene<'_>,
        wishes: &Wishes<'_>,
        mut resources: Resources<'_>,
        stop: &StopFlag,
        parts: &mut Parts<'_, S>,
    ) -> Result<(), Stop<S::Error>> {
        let Self { body: memory_of_body, buffers, memory } = self;
        let ends = Ends::of(scene)?;
        let given = ends.body.as_ref().unwrap_or(&scene.body);
        let body = memory_of_body.read(given, resources.budget)?;
        let terms = Terms::new(scene, SPACE, (body, None, &ends), wishes)?;
        let source = Source::read(scene, &SPACE, true, buffers, &mut resources)?;
        let budget = resources.budget;
        let mut ways = [const { None }; MOST_EXITS];
        let mut job = AssemblyJob::new(terms, source, &mut ways, memory, resources);
        job.find_ways_out()?;
        answer_each(&mut job, wishes, (budget, stop), parts)
    }
}

impl<const D: usize> Assembly<D> {
    /// The memory that it holds, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { body, buffers, memory } = self;
        let Memory { complement, router, gaps, course, best, profile } = memory;
        let vectors = body.bytes() + gaps.capacity() * size_of::<Vector<D>>();
        let courses = course.bytes() + best.bytes();
        vectors + buffers.bytes() + complement.bytes() + router.bytes() + courses + profile.bytes()
    }
}

impl<'a, 'w, const D: usize> AssemblyJob<'a, 'w, D> {
    fn new(
        terms: Terms<'a, D>,
        source: Source<'a, D>,
        ways: &'w mut WaysOut<'a, D>,
        memory: &'a mut Memory<D>,
        resources: Resources<'a>,
    ) -> Self {
        memory.course.forget();
        memory.best.forget();
        Self { terms, source, ways, chosen: 0, memory, resources }
    }

    /// Finds the ways out that the request names.
    fn find_ways_out(&mut self) -> Result<(), Refused> {
        let Self { terms, source, ways, resources, .. } = self;
        let mut add = |exit: Direction, name| {
            let known =
                |way: &&mut Option<WayOut<'_, D>>| way.as_ref().is_none_or(|way| way.exit == exit);
            if let Some(way) = ways.iter_mut().find(known) {
                way.get_or_insert_with(|| {
                    let mouth = source.mouth(exit, terms.body.is_union());
                    WayOut { exit, name, mouth, space: None }
                });
            }
        };
        for name in &terms.scene.exit {
            add(check::direction::<D>(&terms.axes, *name)?, Some(*name));
        }
        if terms.scene.exit.is_empty() {
            let up = terms.axes[..D].iter().position(|axis| *axis == 2).unwrap_or(0);
            add(Direction { axis: up, sign: Sign::Positive }, None);
        }
        if let [Some(only), None, ..] = ways
            && !matches!(source, Source::Outlines(_))
        {
            let whole = (only.exit, terms.body.bounds());
            // A part that fits exactly may find no channel; that is told later.
            match terms.open(whole, source, Explain::Fully, resources) {
                Err(refused) if refused.may_be_for_rounding(terms.body.is_union()) => {}
                opened => only.space = Some(opened?),
            }
        }
        Ok(())
    }

    /// Finds the path of an answer. Where there are several ways out, it is the shortest, or, where
    /// the safest is wished for, the shortest of those with the most room.
    fn find(&mut self, wish: &Wish<'_>) -> Result<(), Refused> {
        let mut best: Option<usize> = None;
        let count = self.ways.iter().flatten().count();
        if count > 1 {
            for at in 0..count {
                match self.find_by(at, wish, Explain::No) {
                    Ok(()) => {
                        if best.is_none() || self.is_better(wish) {
                            best = Some(at);
                            mem::swap(&mut self.memory.course, &mut self.memory.best);
                        }
                    }
                    Err(refused) if refused.is_final() => return Err(refused),
                    // Ignored if another exit works.
                    Err(_) => {}
                }
            }
        }
        if let Some(at) = best {
            mem::swap(&mut self.memory.course, &mut self.memory.best);
            self.chosen = at;
            return Ok(());
        }
        // The first that is refused says why, unless a part that fits exactly gets out elsewhere.
        let mut first: Option<Refused> = None;
        for at in 0..count {
            self.chosen = at;
            match self.find_by(at, wish, Explain::Fully) {
                Err(refused) if refused.is_final() || !refused.is_for_rounding() => {
                    return Err(first.unwrap_or(refused));
                }
                Err(refused) => first = first.or(Some(refused)),
                Ok(()) => return Ok(()),
            }
        }
        first.map_or(Ok(()), Err)
    }

    /// Whether the path found last is better than the best so far, to another way out.
    fn is_better(&self, wish: &Wish<'_>) -> bool {
        let Memory { course, best, .. } = &*self.memory;
        if !matches!(wish.gaps, Gaps::Fraction(1.0)) {
            return course.path.length() < best.path.length();
        }
        let bounds = self.terms.body.bounds();
        let same = CONTACT * bounds.min().amax().max(bounds.max().amax());
        course.is_safer_than(best, same)
    }

    /// The channels made for the answer planned last.
    fn made(&self) -> &[AxisBox<D>] {
        let way = self.ways[self.chosen].as_ref();
        way.and_then(|way| way.space.as_ref()).map_or(&[], FreeSpace::made)
    }

    /// Finds the path to one way out, and its clearance: through channels, or between the solids'
    /// outlines where there are none, or where channels are too narrow for a part that fits
    /// exactly.
    fn find_by(&mut self, at: usize, wish: &Wish<'_>, explain: Explain) -> Result<(), Refused> {
        let outlines = match (self.terms.slide, self.source.outlines()) {
            (Some(slide), Some(outlines)) => Some((slide, outlines)),
            _ => None,
        };
        let Some((slide, outlines)) = outlines else {
            let found = self.find_through((at, None), wish, explain);
            return match found {
                Err(refused) if refused.may_be_for_rounding(self.terms.body.is_union()) => self
                    .fit_through(at, wish)
                    .map_err(|error| if error.is_final() { error } else { refused }),
                found => found,
            };
        };
        if matches!(self.source, Source::Outlines(_)) {
            return self.slide_out(at, wish, (slide, &outlines));
        }
        let found = self.find_through((at, None), wish, explain);
        match &found {
            Err(refused) if refused.is_for_rounding() => {
                match self.slide_out(at, wish, (slide, &outlines)) {
                    Err(error) if !error.is_final() => found,
                    slid => slid,
                }
            }
            Ok(()) if matches!(wish.gaps, Gaps::Fraction(1.0)) => {
                self.look_for_more_room(at, wish, (slide, &outlines))
            }
            _ => found,
        }
    }

    /// The safest path through channels may be none of the safest of all: then finds that.
    fn look_for_more_room(
        &mut self,
        at: usize,
        wish: &Wish<'_>,
        (slide, outlines): (&dyn Slide<D>, &Outlines<D>),
    ) -> Result<(), Refused> {
        let Self { terms, ways, memory, resources, .. } = self;
        let (Some(way), Some(known)) = (&ways[at], memory.course.room()) else { return Ok(()) };
        let more = translation::Demand::MoreThan(known.1);
        match slide.find(&terms.body, outlines, way.exit, more, resources.budget) {
            Ok(_) => {}
            Err(NoWay::Spent(spent)) => return Err(spent.into()),
            Err(_) => return Ok(()),
        }
        self.slide_out(at, wish, (slide, outlines))?;
        if self.memory.course.room().is_none_or(|found| found > known) {
            return Ok(());
        }
        self.find_through((at, None), wish, Explain::No)
    }

    /// Finds the path of a part that fits exactly: through channels for one that is narrower by
    /// rounding.
    fn fit_through(&mut self, at: usize, wish: &Wish<'_>) -> Result<(), Refused> {
        let bounds = self.terms.body.bounds();
        let (min, max) = (bounds.min(), bounds.max());
        let play = Vector::repeat(CONTACT * min.amax().max(max.amax()));
        let Ok(narrower) = AxisBox::new(min + play, max - play) else { return Ok(()) };
        let found = self.find_through((at, Some(narrower)), wish, Explain::No);
        if let (Err(_), Some(way)) = (&found, &mut self.ways[at]) {
            way.space = None;
        }
        found
    }

    /// Finds the path to one way out between the solids' outlines, and its clearance.
    fn slide_out(
        &mut self,
        at: usize,
        wish: &Wish<'_>,
        (slide, outlines): (&dyn Slide<D>, &Outlines<D>),
    ) -> Result<(), Refused> {
        let Self { terms, ways, memory, resources, .. } = self;
        let Memory { gaps, course, .. } = &mut **memory;
        let Terms { axes, body, ends, .. } = &*terms;
        let Some(WayOut { exit, .. }) = &ways[at] else { return Ok(()) };
        let budget = resources.budget;
        let asked = match (wish.gaps, gap_of(wish, gaps, budget)) {
            (Gaps::AtLeast(clearance), _) => {
                check::gap(&wish.field(), clearance)?;
                translation::Demand::AtLeast(clearance)
            }
            (_, gap) => match gap? {
                disassembly::Gap::Uniform(gap) => translation::Demand::Gap(Vector::repeat(gap)),
                disassembly::Gap::PerAxis(gap) => translation::Demand::Gap(gap),
                disassembly::Gap::Fraction(part) => translation::Demand::Part(part),
                disassembly::Gap::Safest => translation::Demand::Part(1.0),
                disassembly::Gap::PerJunction(gaps) => {
                    return Err(refuse::no_junctions(wish.field(), gaps.len()).into());
                }
            },
        };
        if let translation::Demand::Gap(gap) = asked {
            for value in gap.iter() {
                check::gap(&wish.field(), *value)?;
            }
        }
        let way = slide
            .find(body, outlines, *exit, asked, budget)
            .map_err(|error| refuse::no_way(axes, wish.field(), asked, error))?;
        course.take(&way);
        if let (Some(outside), Some(out)) = (ends.outside, way.last()) {
            let short = exit.coordinate(out) - exit.coordinate(&outside);
            if short > 0.0 {
                let task = terms.scene.task;
                return Err(refuse::short_of_the_mouth(axes, task, *exit, short));
            }
            course.go_on(outside, exit.axis);
        }
        let walls = outlines.walls();
        let near = course.measure(body, walls, budget)?;
        if let Some(near) = near
            && ends.outside.is_some()
            && !course.is_free_outside(body, walls, budget)?
        {
            return Err(refuse::wall_in_the_way(&near).into());
        }
        if let Some(shape) = terms.corner_shape() {
            course.round((body, shape), walls, budget)?;
        }
        Ok(())
    }

    /// Finds the path to one way out through channels, and its clearance: for the part, or for one
    /// that is narrower than it.
    fn find_through(
        &mut self,
        (at, narrower): (usize, Option<AxisBox<D>>),
        wish: &Wish<'_>,
        explain: Explain,
    ) -> Result<(), Refused> {
        let Self { terms, source, ways, memory, resources, .. } = self;
        let Memory { complement, router, gaps, course, .. } = &mut **memory;
        let Terms { axes, body, ends, .. } = &*terms;
        let Some(WayOut { exit, mouth, space, .. }) = &mut ways[at] else { return Ok(()) };
        let exit = *exit;
        let bounds = narrower.as_ref().unwrap_or(body.bounds());
        let space = match (space, narrower) {
            (Some(space), None) => space,
            (other, _) => other.insert(terms.open((exit, bounds), source, explain, resources)?),
        };
        let budget = resources.budget;
        let gap = gap_of(wish, gaps, budget)?;
        match space.graph() {
            None => course
                .follow_all(space.channels(), body, exit, budget)
                .map_err(|error| refuse::chain(axes, error).whole())?,
            Some(graph) => {
                let mut mover = BodyMover::new(bounds, gap, End::Exit(exit))
                    .map_err(|error| refuse::route(axes, wish.field(), error))?;
                if let Err(error) = router.find(graph, &mut mover, budget) {
                    let error = (wish.field(), error);
                    return Err(match (source, &*space, explain) {
                        (Source::Solids(_), ..) if body.is_union() => {
                            closed_to_union(axes, error.0, error.1)
                        }
                        (Source::Solids(cut), FreeSpace::Made(made), Explain::Fully) => {
                            cut.refuse_route(made, axes, error, mover.traveller(), resources)
                        }
                        _ => refuse::route(axes, error.0, error.1),
                    });
                }
                course
                    .follow(graph.channels(), router.route(), body, exit, budget)
                    .map_err(|error| refuse::chain(axes, error))?;
                if let Some(mouth) = *mouth {
                    course.set_mouth(mouth);
                }
            }
        }
        // All other walls are the channels' own sides.
        let (has_solids, is_made) = (space.has_solids(), !space.made().is_empty());
        let reach = match ends.outside {
            Some(outside) => course
                .beyond_the_mouth(body, &outside)
                .map_err(|short| refuse::short_of_the_mouth(axes, terms.scene.task, exit, short))?,
            None => 0.0,
        };
        let walls = space.walls(course.mouth(reach), complement, resources)?;
        let mut found = course.disassemble(body.bounds(), gap, budget);
        if let (Err(DisassemblyError::JunctionTooSmall { .. }), Some(narrower)) = (found, narrower)
        {
            found = course.disassemble(&narrower, gap, budget);
        }
        found.map_err(|error| refuse::disassembly(axes, wish.field(), error))?;
        if let Some(outside) = ends.outside {
            course.go_on(outside, exit.axis);
        }
        let takes_shortest = terms.scene.path == Some(PathChoice::Shortest);
        if takes_shortest || terms.scene.report.is_some() {
            course.shorten(body.bounds(), ends.outside.as_ref(), takes_shortest, budget)?;
        }
        let near = course.measure(body, walls, budget)?;
        let checked = match near {
            Some(near)
                if ends.outside.is_some() && !course.is_free_outside(body, walls, budget)? =>
            {
                Err(refuse::wall_in_the_way(&near).into())
            }
            Some(near)
                if near.value <= 0.0
                    && has_solids
                    && !course.is_contact(body, walls, is_made, budget)? =>
            {
                Err(refuse::wall_in_the_way(&near).into())
            }
            _ => Ok(()),
        };
        if let (Ok(()), Some(shape)) = (&checked, terms.corner_shape()) {
            course.round((body, shape), walls, budget)?;
        }
        checked
    }
}

impl<const D: usize> Job for AssemblyJob<'_, '_, D> {
    fn plan(&mut self, wish: &Wish<'_>) -> Result<(), Refused> {
        self.find(wish)?;
        let made = 2 * D * self.made().len();
        let Self { terms, memory, resources, .. } = self;
        let Memory { course, profile, .. } = &mut **memory;
        if terms.scene.task == Task::Assemble {
            course.reverse();
        }
        let cells = course.cells() + made;
        terms.pace.plan(course.path.legs(), profile, cells, resources)
    }

    fn write<S: PartSink>(&self, last: bool, parts: &mut Parts<'_, S>) -> Result<(), S::Error> {
        let Memory { course, profile, .. } = &*self.memory;
        let Course { path, clearances, clearance, route, bound, .. } = course;
        let bound = bound.filter(|_| self.terms.scene.report.is_some());
        let (legs, ends) = (path.legs(), self.terms.ends);
        let way = self.ways[self.chosen].as_ref();
        let made = self.made();
        let is_choice = self.terms.scene.exit.len() > 1;
        let exit = way.and_then(|way| way.name).filter(|_| is_choice);
        let lists = TrajectoryWriter {
            gaps: (0..path.gaps().len() * D).map(|at| path.gaps()[at / D][at % D]),
            route: route.iter().map(|channel| *channel as u64),
            channels: parts::boxes(made),
            legs: legs
                .iter()
                .zip(clearances.iter())
                .map(|(leg, near)| parts::leg(&ends.tell(leg), near.value)),
            samples: self.terms.pace.states(legs, profile).told_by(ends.teller(legs, profile)),
        };
        let fill = |header: &mut ReplyHeader| {
            header.dimension = D as u32;
            header.gaps_per_junction = D as u32;
            header.exit = ReplyHeader::exit_code(exit);
            header.length = path.length();
            header.duration = profile.duration();
            parts::clearance(header, clearance.as_ref());
            header.set_certificate(Certificate { bound, free_clearance: None, complete: true });
            header.set_stops(self.terms.pace.stops_on_the_way(legs, profile));
        };
        parts.trajectory(fill, lists, last)
    }
}
