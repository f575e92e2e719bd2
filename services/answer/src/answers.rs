//! What all tasks have in common: one answer after the other is planned and written, or refused.

use planning::budget::{Budget, Spent};
use planning::motion::Leg;
use planning::trajectory::{Limits, Profile, Sampling, Stops, YawJumps};
use schemas::convert::PartSink;
use schemas::message::{Corners, ExceededLimit, Exceeds, Refusal};
use schemas::wire::{LEG_CELLS, SAMPLE_CELLS};

use crate::Caps;
use crate::cache::Cache;
use crate::check;
use crate::parts::{Parts, States};
use crate::refuse::{self, Refused};
use crate::scene::Scene;
use crate::stop::StopFlag;
use crate::wish::{Wish, Wishes};

/// What a request draws on: its budget, and what was made for earlier requests.
#[derive(Debug)]
pub(crate) struct Resources<'a> {
    pub(crate) caps: &'a Caps,
    pub(crate) budget: &'a Budget<'a>,
    pub(crate) cache: &'a mut Cache,
}

/// Why answering ends before the last answer is written.
#[derive(Debug)]
pub(crate) enum Stop<E> {
    /// The request as a whole is refused; nothing has been written.
    Refused(Refused),
    /// The sink takes no more.
    Sink(E),
}

impl<E> From<Refused> for Stop<E> {
    fn from(refused: Refused) -> Self {
        Self::Refused(refused)
    }
}

impl<E> From<Refusal> for Stop<E> {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal.into())
    }
}

impl<E> From<Spent> for Stop<E> {
    fn from(spent: Spent) -> Self {
        Self::Refused(spent.into())
    }
}

/// A task whose scene has been read and checked.
pub(crate) trait Job {
    /// Plans an answer, in place of the one before.
    fn plan(&mut self, wish: &Wish<'_>) -> Result<(), Refused>;

    /// Writes the answer planned last.
    fn write<S: PartSink>(&self, last: bool, parts: &mut Parts<'_, S>) -> Result<(), S::Error>;
}

/// Answers every wish in turn. A refusal is written in place of the answer. If only one answer is
/// wished for, or none can be given, the request as a whole is refused.
pub(crate) fn answer_each<S: PartSink>(
    job: &mut impl Job,
    wishes: &Wishes<'_>,
    (budget, stop): (&Budget<'_>, &StopFlag),
    parts: &mut Parts<'_, S>,
) -> Result<(), Stop<S::Error>> {
    let count = wishes.count() as usize;
    for (index, wish) in wishes.iter().enumerate() {
        let last = index + 1 == count;
        let begun = budget.step(1).map_err(Refused::from);
        match begun.and_then(|()| job.plan(&wish)) {
            Ok(()) => job.write(last, parts),
            Err(refused) if !wishes.several() || (index == 0 && refused.is_whole()) => {
                return Err(refused.into());
            }
            Err(refused) => parts.refuse(&refused.into_refusal(stop), last),
        }
        .map_err(Stop::Sink)?;
    }
    Ok(())
}

/// So many cells of a reply are written in the time of a step.
const CELLS_PER_STEP: u64 = 8;

/// How fast the body moves, and at which moments the reply says where it is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pace {
    limits: Limits,
    stops: Stops,
    /// `None`: at none.
    sampling: Option<Sampling>,
    /// Whether the reply says which limit is not obeyed.
    tells_exceeding: bool,
    /// Whether the reply says where the body stops for want of a smooth corner.
    tells_stops: bool,
}

impl Pace {
    /// The limit that a robot's motion does not obey, where the request wants to know.
    pub(crate) fn exceeded<const D: usize>(
        &self,
        legs: &[Leg<D>],
        profile: &Profile,
    ) -> Option<Exceeds> {
        let YawJumps { joints, greatest } =
            self.tells_exceeding.then(|| profile.yaw_jumps(legs)).flatten()?;
        let limit = ExceededLimit::YawAcceleration;
        Some(Exceeds { limit, joints: joints as u64, jump: greatest })
    }

    /// At how many joints the body stops for want of a smooth corner, where the request asks for
    /// such corners.
    pub(crate) fn stops_on_the_way<const D: usize>(
        &self,
        legs: &[Leg<D>],
        profile: &Profile,
    ) -> Option<u64> {
        self.tells_stops.then(|| profile.stops_on_the_way(legs, self.stops) as u64)
    }

    /// How fast the body may move.
    pub(crate) fn limits(&self) -> &Limits {
        &self.limits
    }

    pub(crate) fn of(scene: Scene<'_>, wishes: &Wishes<'_>, stops: Stops) -> Result<Self, Refusal> {
        let limits = check::limits(&scene.limits)?;
        let exceeding = scene.corners.is_some() || scene.report.is_some();
        let sampling = check::sampling(scene.sampling)?;
        let sampling = wishes.sampled().then_some(sampling);
        let tells_stops = scene.corners == Some(Corners::Smooth);
        Ok(Self { limits, stops, sampling, tells_exceeding: exceeding, tells_stops })
    }

    /// Plans the speed along a path. Refuses a trajectory that would have too many samples, and
    /// draws what its reply takes, which has so many `cells` besides the legs and samples.
    pub(crate) fn plan<const D: usize>(
        &self,
        legs: &[Leg<D>],
        profile: &mut Profile,
        cells: usize,
        resources: &Resources<'_>,
    ) -> Result<(), Refused> {
        let Resources { caps, budget, .. } = resources;
        profile.plan(legs, &self.limits, self.stops, budget)?;
        let samples = self.sampling.map_or(0, |sampling| profile.sample_count(sampling));
        if samples > caps.samples {
            return Err(refuse::too_many_samples(samples, caps.samples).into());
        }
        let samples = (samples as usize).saturating_mul(SAMPLE_CELLS);
        let cells = (legs.len() * LEG_CELLS + cells).saturating_add(samples);
        budget.step(cells as u64 / CELLS_PER_STEP)?;
        // The reply is held by whoever receives it, if not here.
        Ok(budget.hold(cells.saturating_mul(size_of::<u64>()))?)
    }

    /// The states of a motion along these legs, to which the profile belongs.
    pub(crate) fn states<'a, const D: usize>(
        &self,
        legs: &'a [Leg<D>],
        profile: &'a Profile,
    ) -> States<'a, D> {
        States::new(self.sampling.map(|sampling| profile.samples(legs, sampling)))
    }
}
