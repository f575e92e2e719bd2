//! The way of a robot through the channels it travels.

use planning::budget::Budget;
use planning::driving::{self, Corner, Drive, DrivingError, DrivingPath, corners_of};
use planning::free_space::walls::Walls;
use planning::free_space::{Chain, End};
use planning::geometry::AxisBox;
use schemas::message::{Gap, Refusal};

use super::errand::Errand;
use crate::check;
use crate::refuse::{self, FLOOR, Refused};
use crate::wish::{Gaps, Wish};

/// So small that it makes no guiding circle any larger, metres.
const LEAST_GAP: f64 = f64::MIN_POSITIVE;

/// The channels travelled, and what the robot does in them.
#[derive(Debug, Default)]
pub(super) struct Course {
    /// The indices of the channels travelled, in travel order.
    pub(super) route: Vec<usize>,
    travelled: Vec<AxisBox<2>>,
    chain: Chain<2>,
    corners: Vec<Corner>,
    /// The gap at every corner of the answer at hand, metres.
    pub(super) gaps: Vec<f64>,
    pub(super) path: DrivingPath,
    /// The safest gap, once found, metres.
    safest: Option<f64>,
}

/// The gaps that an answer is to keep, metres.
#[derive(Debug, Clone, Copy)]
pub(super) enum KeptGap<'a> {
    /// This one at every corner.
    Same(f64),
    /// These.
    Each(&'a [Gap]),
    /// This part of the safest.
    Part(f64),
}

impl<'a> KeptGap<'a> {
    pub(super) fn of(wish: &Wish<'a>, budget: &Budget<'_>) -> Result<Self, Refused> {
        Ok(match wish.gaps {
            Gaps::Same(gap) => Self::Same(one_number(gap).ok_or_else(|| wrong_gap(wish.field()))?),
            Gaps::Each(gaps) => {
                budget.step(gaps.len() as u64)?;
                for (corner, gap) in gaps.iter().enumerate() {
                    let field = || format!("{}[{corner}]", wish.field());
                    one_number(*gap).ok_or_else(|| wrong_gap(field()))?;
                }
                Self::Each(gaps)
            }
            Gaps::Fraction(fraction) => Self::Part(fraction),
            Gaps::AtLeast(_) => return Err(check::only_in_any_order(wish.field()).into()),
        })
    }
}

impl Course {
    /// Leads through these of the channels.
    pub(super) fn lead(
        &mut self,
        channels: &[AxisBox<2>],
        route: impl Iterator<Item = usize>,
        errand: &Errand,
        budget: &Budget<'_>,
    ) -> Result<(), Refused> {
        let Self { chain, corners, travelled, safest, .. } = self;
        *safest = None;
        self.route.clear();
        self.route.extend(route);
        travelled.clear();
        travelled.extend(self.route.iter().map(|channel| channels[*channel]));
        chain
            .build(travelled, &errand.start.position, End::Goal(errand.goal.position), budget)
            .map_err(|error| refuse::chain(&FLOOR, error))?;
        corners_of(chain, corners);
        Ok(())
    }

    /// Drives along it, and returns the length that its route is chosen by, metres: that of
    /// the drive, or with the least gap where the gap depends on the route.
    pub(super) fn judge(
        &mut self,
        errand: &Errand,
        kept: KeptGap<'_>,
        walls: &Walls<2>,
        budget: &Budget<'_>,
    ) -> Result<f64, DrivingError> {
        let KeptGap::Part(_) = kept else {
            self.drive(errand, kept, walls, budget)?;
            return Ok(self.path.length());
        };
        let Self { chain, corners, path, .. } = self;
        let task = task(errand, chain, corners, walls);
        driving::route(&task, driving::CornerGaps::Uniform(LEAST_GAP), path, budget)?;
        let length = path.length();
        self.drive(errand, kept, walls, budget)?;
        Ok(length)
    }

    /// Drives along it.
    pub(super) fn drive(
        &mut self,
        errand: &Errand,
        kept: KeptGap<'_>,
        walls: &Walls<2>,
        budget: &Budget<'_>,
    ) -> Result<(), DrivingError> {
        let Self { chain, corners, gaps, path, safest, .. } = self;
        let task = task(errand, chain, corners, walls);
        gaps.clear();
        match kept {
            KeptGap::Same(gap) => gaps.resize(corners.len(), gap),
            KeptGap::Each(given) => gaps.extend(given.iter().copied().filter_map(one_number)),
            KeptGap::Part(part) => {
                let safest = match *safest {
                    Some(safest) => safest,
                    None => *safest.insert(driving::safest(&task, path, budget)?),
                };
                gaps.resize(corners.len(), safest * part);
            }
        }
        driving::drive(&task, driving::CornerGaps::PerCorner(gaps), path, budget)
    }

    /// The memory that it holds, bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { route, travelled, chain, corners, gaps, path, safest: _ } = self;
        route.capacity() * size_of::<usize>()
            + travelled.capacity() * size_of::<AxisBox<2>>()
            + corners.capacity() * size_of::<Corner>()
            + gaps.capacity() * size_of::<f64>()
            + chain.bytes()
            + path.bytes()
    }
}

/// What is asked of a robot that is to travel these channels.
fn task<'a>(
    errand: &Errand,
    chain: &Chain<2>,
    corners: &'a [Corner],
    walls: &'a Walls<2>,
) -> Drive<'a> {
    let channels = chain.channels();
    let Errand { footprint, start, goal, start_turn, .. } = *errand;
    let (first, last) = (channels[0], channels[channels.len() - 1]);
    Drive { footprint, start, goal, start_turn, first, last, corners, walls }
}

/// A robot keeps one gap from a corner, in all directions.
pub(super) fn one_number(gap: Gap) -> Option<f64> {
    match gap {
        Gap::Uniform(gap) => Some(gap),
        Gap::PerAxis(gaps) => match gaps.as_slice() {
            [gap] => Some(*gap),
            _ => None,
        },
    }
}

pub(super) fn wrong_gap(field: String) -> Refusal {
    let message = format!("{field}: a robot keeps one gap from a corner; give one number");
    Refusal::invalid(field, message)
}
