//! A robot among walls at any angle: free space from solids, floor plans, or channels in any order.

use std::sync::{Arc, Weak};

use planning::any_angle::{self, ChannelsTravelled, Planner, RobotMotion};
use planning::budget::Budget;
use planning::free_space::floor::{Floor, FloorError};
use planning::free_space::walls::{Complement, Walls};
use planning::geometry::AxisBox;
use planning::trajectory::Profile;
use schemas::convert::{Certificate, PartSink, TrajectoryWriter};
use schemas::message::{Corners, Refusal};
use schemas::wire::ReplyHeader;

use super::course::{one_number, wrong_gap};
use super::errand::Errand;
use super::smooth;
use crate::answers::{Job, Pace, Resources};
use crate::cache::{Cached, Kind};
use crate::check;
use crate::entries::Entry;
use crate::free_space::{Buffers, floor_walls};
use crate::parts::{self, Parts};
use crate::refuse::{self, Refused};
use crate::scene::Scene;
use crate::wish::{Gaps, Wish};

impl Cached for Floor {
    fn bytes(&self) -> usize {
        Self::bytes(self)
    }
}

/// Memory for robots among walls at any angle.
#[derive(Debug, Default)]
pub(super) struct Memory {
    planner: Planner,
    /// The floor that the planner knows. Only the cache keeps floors; as long as this names one,
    /// no other has its address.
    floor: Weak<Entry<Floor>>,
    found: RobotMotion,
    /// The greatest free clearance, once found, metres.
    safest: Option<f64>,
    travelled: ChannelsTravelled,
    profile: Profile,
}

impl Memory {
    /// The memory that it holds, bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { planner, found, profile, travelled, .. } = self;
        planner.bytes() + found.bytes() + profile.bytes() + travelled.bytes()
    }
}

/// A driving task among walls at any angle whose scene has been read and checked.
pub(super) struct AnywhereJob<'a> {
    errand: Errand,
    pace: Pace,
    /// Whether corners are to be smooth.
    is_smooth: bool,
    walls: Arc<Entry<Walls<2>>>,
    floor: Arc<Entry<Floor>>,
    /// The request's channels, if it has any.
    channels: &'a [AxisBox<2>],
    memory: &'a mut Memory,
    resources: Resources<'a>,
}

impl<'a> AnywhereJob<'a> {
    pub(super) fn new(
        scene: Scene<'_>,
        (errand, pace): (Errand, Pace),
        (buffers, complement): (&'a mut Buffers<2>, &mut Complement<2>),
        memory: &'a mut Memory,
        mut resources: Resources<'a>,
    ) -> Result<Self, Refused> {
        let walls = floor_walls(scene, buffers, complement, &mut resources)?;
        let channels = scene.free_space.channels.is_some().then(|| buffers.channels());
        let Resources { budget, cache, .. } = &mut resources;
        let kind = if channels.is_some() { Kind::ChannelsFloor } else { Kind::SolidsFloor };
        cache.describe_again(kind, 2);
        errand.check_inside(scene, channels, &walls, budget)?;
        let floor: Arc<Entry<Floor>> = cache.get(budget, || floor_among(&walls, budget))?;
        if memory.floor.as_ptr() != Arc::as_ptr(&floor) {
            memory.planner.forget();
            memory.floor = Arc::downgrade(&floor);
        }
        memory.safest = None;
        let channels = channels.unwrap_or_default();
        let is_smooth = scene.corners == Some(Corners::Smooth);
        Ok(Self { errand, pace, is_smooth, walls, floor, channels, memory, resources })
    }

    /// What is wished for; the greatest free clearance is found once.
    fn wished(&mut self, wish: &Wish<'_>) -> Result<any_angle::Wish, Refused> {
        let field = wish.field();
        match wish.gaps {
            Gaps::Same(gap) => {
                let gap = one_number(gap).ok_or_else(|| wrong_gap(field.clone()))?;
                check::gap(&field, gap)?;
                Ok(any_angle::Wish::Gap(gap))
            }
            Gaps::AtLeast(least) => {
                check::not_negative(&field, least, "m")?;
                Ok(any_angle::Wish::AtLeast(least))
            }
            Gaps::Each(gaps) => Err(refuse::gap_per_junction(field, gaps.len()).into()),
            Gaps::Fraction(_) => {
                let part = wish.part_of_safest();
                if part == 1.0 {
                    return Ok(any_angle::Wish::Safest);
                }
                let safest = match self.memory.safest {
                    Some(safest) => safest,
                    None => {
                        self.drive(any_angle::Wish::Safest, wish)?;
                        *self.memory.safest.insert(self.memory.found.free_clearance)
                    }
                };
                Ok(any_angle::Wish::AtLeast(part * safest))
            }
        }
    }

    fn drive(&mut self, wished: any_angle::Wish, wish: &Wish<'_>) -> Result<(), Refused> {
        let Self { errand, walls, floor, memory, resources, .. } = self;
        let task = errand.among(walls, floor);
        any_angle::drive(&task, wished, &mut memory.planner, &mut memory.found, resources.budget)
            .map_err(|error| refuse::no_motion(wish.field(), &task, wished, error))
    }
}

/// The floor among walls.
pub(super) fn floor_among(walls: &Walls<2>, budget: &Budget<'_>) -> Result<Floor, Refused> {
    Floor::new(walls, budget).map_err(|error| match error {
        FloorError::Spent(spent) => spent.into(),
        error => Refusal::invalid("free_space", format!("free_space: {error}")).into(),
    })
}

/// What a reply says of how good a motion is.
pub(super) fn certificate(motion: &RobotMotion) -> Certificate {
    Certificate {
        bound: Some(motion.bound),
        free_clearance: Some(motion.free_clearance),
        complete: motion.is_complete,
    }
}

impl Job for AnywhereJob<'_> {
    fn plan(&mut self, wish: &Wish<'_>) -> Result<(), Refused> {
        let wished = self.wished(wish)?;
        self.drive(wished, wish)?;
        if self.is_smooth {
            let Self { errand, pace, walls, floor, memory, resources, .. } = self;
            let Memory { planner, found, .. } = &mut **memory;
            let task = (&*errand, pace.limits());
            smooth::smooth(task, (walls, floor), planner, found, resources.budget)?;
        }
        let Memory { found, profile, travelled, .. } = &mut *self.memory;
        let (rounding, budget) = (self.floor.rounding(), self.resources.budget);
        travelled.find(&found.legs, self.channels, rounding, budget)?;
        self.pace.plan(&found.legs, profile, 1 + travelled.route().len(), &self.resources)
    }

    fn write<S: PartSink>(&self, last: bool, parts: &mut Parts<'_, S>) -> Result<(), S::Error> {
        let Memory { found, profile, travelled, .. } = &*self.memory;
        write(found, travelled.route(), (&self.pace, profile), last, parts)
    }
}

/// Writes a motion.
pub(super) fn write<S: PartSink>(
    found: &RobotMotion,
    route: &[usize],
    (pace, profile): (&Pace, &Profile),
    last: bool,
    parts: &mut Parts<'_, S>,
) -> Result<(), S::Error> {
    let corners = found.legs.iter().filter_map(|leg| leg.junction).max().map_or(0, |at| at + 1);
    let legs = found.legs.iter().zip(&found.leg_clearances);
    let lists = TrajectoryWriter {
        gaps: std::iter::repeat_n(found.gap, corners),
        route: route.iter().map(|channel| *channel as u64),
        channels: parts::boxes::<2>(&[]),
        legs: legs.map(|(leg, near)| parts::leg(leg, *near)),
        samples: pace.states(&found.legs, profile),
    };
    let fill = |header: &mut ReplyHeader| {
        header.dimension = 2;
        header.gaps_per_junction = 1;
        header.length = found.length;
        header.duration = profile.duration();
        parts::clearance(header, found.clearance.as_ref());
        header.set_certificate(certificate(found));
        header.set_exceeds(pace.exceeded(&found.legs, profile));
        header.set_stops(pace.stops_on_the_way(&found.legs, profile));
    };
    parts.trajectory(fill, lists, last)
}
