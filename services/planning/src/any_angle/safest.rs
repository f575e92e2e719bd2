//! The motion with the greatest free clearance.

use std::cmp::Ordering;

use super::disc::disc_of;
use super::ladder::{LONG, LastRung, Target, poses, set_out, shortest};
use super::lattice;
use super::measure::{cost, measure};
use super::planner::Planner;
use super::taut::TurnRadii;
use super::{Errand, NoMotion, PRECISION, RobotMotion, bound, refusal};
use crate::budget::{Budget, Cap, Spent};
use crate::motion::{Leg, Rung};

/// Gaps looked at one by one, since more gap need not mean more clearance.
const GAPS: usize = 32;

/// A disc that is wider than the widest by this part is stuck beside an end if there.
const BESIDE: f64 = 1e-6;

/// What a rectangle keeps beside an end is mostly less than this times what a disc keeps.
const MUCH_MORE: f64 = 8.0;

/// Gaps about which the best is looked for closely.
const PEAKS: usize = 3;

/// Searches between poses first try to get this part nearer to all that a disc keeps, and then so
/// many times more.
const FIRST_PART: f64 = 1.0 / 4096.0;
const GROWTH: f64 = 6.0;

/// Lines between places to turn may be found for more clearance and not for less: so many steps
/// of this part more than the best are looked at, and that so often.
const STEPS_ON: usize = 8;
const STEP_ON: f64 = 1.0 / 256.0;
const ROUNDS: usize = 4;

/// Searches between poses tell clearances apart by this part of the robot's length, and go on
/// from whole strides of so many steps.
const STEP: f64 = 1.0 / (1_u64 << 30) as f64;
const STRIDE: u64 = 1 << 11;

/// Steps of the budget after which no further search over poses begins.
const MOST_STEPS: u64 = 100_000_000;

/// Searches over poses come as near to the most they can keep as this part of it.
const LAST_PART: f64 = 1e-3;

/// Finds the motion with the greatest free clearance; of those that have it but for rounding, where any
/// heading will do at the goal, that with the greatest clearance there; and of those the
/// shortest, of which the least costly.
pub(super) fn safest(
    errand: &Errand<'_>,
    planner: &mut Planner,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<(), NoMotion> {
    let mut search = SafestSearch::new(errand, None, planner, budget);
    search.search()?;
    let SafestSearch { best, refused, .. } = search;
    match (best, refused) {
        (Some(best), _) => *found = best.motion,
        (None, Some(refused)) => return Err(refused),
        (None, None) => return Err(no_way(errand, planner, budget)?),
    }
    Ok(())
}

/// The least costly motion with at least this free clearance among those that lead to the
/// safest, metres; the refusal if none has it.
pub(super) fn keeping(
    errand: &Errand<'_>,
    (least, refused): (f64, NoMotion),
    planner: &mut Planner,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<(), NoMotion> {
    let mut search = SafestSearch::new(errand, Some(least), planner, budget);
    // Beside an end a rectangle keeps more than a disc, but not that much more.
    let width = errand.footprint.width();
    search.is_brief = matches!(refused, NoMotion::TooNarrow { has, .. }
        if 2.0 * least > MUCH_MORE * (has - width));
    search.search()?;
    match (search.enough, search.spent) {
        (Some(enough), _) => *found = enough.motion,
        (None, Some(spent)) => return Err(spent.into()),
        (None, None) => return Err(refused),
    }
    Ok(())
}

/// Not even the robot's width passes.
fn no_way(
    errand: &Errand<'_>,
    planner: &mut Planner,
    budget: &Budget<'_>,
) -> Result<NoMotion, Spent> {
    refusal::no_way(errand, errand.footprint.width() / 2.0, planner, budget)
}

fn at_least(least: f64) -> Target {
    Target { gap: least, least: Some(least), last: LastRung::Radius }
}

fn with_gap(gap: f64) -> Target {
    Target { gap, least: None, last: LastRung::Aligned }
}

/// Whether a motion of this rung leads from pose to pose.
fn is_between_poses(rung: Option<Rung>) -> bool {
    !matches!(rung, None | Some(Rung::Taut | Rung::Radius))
}

/// How safe a motion is.
#[derive(Debug, Clone, Copy)]
struct Safety {
    /// Its free clearance, metres.
    free: f64,
    /// Its clearance where the way decides what is kept at the goal, metres; otherwise 0.
    clearance: f64,
}

impl Safety {
    const NONE: Self = Self { free: 0.0, clearance: 0.0 };

    /// Which is less, if they differ by more than rounding, metres.
    fn compare(&self, other: &Self, rounding: f64) -> Ordering {
        let parts = [(self.free, other.free), (self.clearance, other.clearance)];
        let differs = |(one, other): &&(f64, f64)| (one - other).abs() > rounding;
        parts.iter().find(differs).map_or(Ordering::Equal, |(one, other)| one.total_cmp(other))
    }
}

/// A motion that was found.
#[derive(Clone)]
struct Contender {
    safety: Safety,
    cost: f64,
    motion: RobotMotion,
}

struct SafestSearch<'a, 'b> {
    errand: &'a Errand<'a>,
    planner: &'a mut Planner,
    /// The greatest free clearance found, metres.
    top: f64,
    /// The best motion of those that have it but for rounding.
    best: Option<Contender>,
    /// What is enough, and the least costly motion that has it.
    least: Option<f64>,
    enough: Option<Contender>,
    refused: Option<NoMotion>,
    /// A gap with which the robot was blocked, metres.
    blocked_gap: Option<f64>,
    /// The largest gap with which the ladder would go on to poses, metres.
    long_gap: f64,
    /// Gaps that were tried for their own sake, and the free clearance of what was found, metres.
    tried: Vec<[f64; 2]>,
    /// Whether gaps alone are tried.
    is_brief: bool,
    /// What ended the search before its end.
    spent: Option<Spent>,
    budget: &'a Budget<'b>,
}

impl<'a, 'b> SafestSearch<'a, 'b> {
    fn new(
        errand: &'a Errand<'a>,
        least: Option<f64>,
        planner: &'a mut Planner,
        budget: &'a Budget<'b>,
    ) -> Self {
        Self {
            errand,
            planner,
            top: 0.0,
            best: None,
            least,
            enough: None,
            refused: None,
            blocked_gap: None,
            long_gap: 0.0,
            tried: Vec::new(),
            is_brief: false,
            spent: None,
            budget,
        }
    }

    /// All of it, or what the budget is enough for.
    fn search(&mut self) -> Result<(), NoMotion> {
        match self.try_some().and_then(|()| self.run()).and_then(|()| self.settle()) {
            Err(NoMotion::Spent(spent @ Spent::Limit { .. })) if self.best.is_some() => {
                self.spent = Some(spent);
                for found in [&mut self.best, &mut self.enough].into_iter().flatten() {
                    found.motion.is_complete = false;
                }
                Ok(())
            }
            result => result,
        }
    }

    /// Some gaps first, so that there is a motion if the budget ends.
    fn try_some(&mut self) -> Result<(), NoMotion> {
        let half = self.errand.footprint.width() / 2.0;
        let least = self.errand.least_gap();
        for gap in [least, half / 8.0, half / 2.0] {
            self.try_target(with_gap(gap))?;
        }
        Ok(())
    }

    /// What is looked for one after the other, until it is found.
    fn run(&mut self) -> Result<(), NoMotion> {
        let Self { errand, budget, .. } = *self;
        let half = errand.footprint.width() / 2.0;
        // Nothing keeps more than the widest disc. It is found to a part of where the search begins.
        let (mut most, extent) = (2.0 * half, errand.floor.extent());
        while most < extent {
            let disc = disc_of(errand, most, budget)?;
            let path = self.planner.bounds.find(errand.floor, &disc, TurnRadii::DISC, budget)?;
            if path.is_none() {
                break;
            }
            most *= 2.0;
        }
        let widest = refusal::widest(errand, most.min(extent), self.planner, budget)?;
        let Some((widest, _)) = widest.filter(|(widest, _)| *widest > half) else {
            return Err(no_way(errand, self.planner, budget)?);
        };
        let most = widest - half;
        let keeps_all = self.try_target(at_least(most))?.is_some();
        // Beside the ends a rectangle can keep more than a disc; in a passage it can't.
        let is_even = disc_of(errand, widest * (1.0 + BESIDE), budget)?.is_even();
        if self.enough.is_some() || keeps_all && is_even {
            return Ok(());
        }
        self.scan(most)?;
        if self.enough.is_some() || keeps_all || self.is_brief {
            return Ok(());
        }
        self.try_larger_circles(most)?;
        if self.enough.is_none() {
            self.try_poses(Rung::Aligned, most, self.step())?;
            self.step_on(most)?;
        }
        // Where a gap leads nowhere else, poses are searched, whatever the gap.
        if self.enough.is_none()
            && let Some(gap) = self.blocked_gap
        {
            self.try_target(Target { last: LastRung::Lattice, ..with_gap(gap) })?;
        }
        let is_from_poses = self
            .best
            .as_ref()
            .is_some_and(|best| best.motion.legs.iter().any(|leg| leg.rung == Some(Rung::Lattice)));
        let most = if is_from_poses { most } else { self.long_gap.min(most) };
        if self.enough.is_none() {
            self.try_poses(Rung::Lattice, most, LAST_PART * most)?;
            self.widen()?;
        }
        Ok(())
    }

    /// The least gap with which a motion is as free as the best: it is the shortest.
    fn settle(&mut self) -> Result<(), NoMotion> {
        let Some(best) = &self.best else { return Ok(()) };
        let (precision, mut gap) = (self.errand.precision(), best.motion.gap);
        // What keeps the gap and no more is not found with less.
        let is_even = (best.safety.free - gap).abs() <= precision;
        if is_even || is_between_poses(self.best_rung()) || self.enough.is_some() {
            return Ok(());
        }
        let free = best.safety.free - precision / 2.0;
        let less = self.tried.iter().filter(|tried| tried[0] < gap && tried[1] < free);
        let Some(mut less) = less.map(|tried| tried[0]).max_by(f64::total_cmp) else {
            return Ok(());
        };
        while gap - less > precision {
            let middle = (less + gap) / 2.0;
            let target = Target { last: LastRung::Radius, ..with_gap(middle) };
            match self.try_target(target)? {
                Some(found) if found.free >= free => gap = middle,
                _ => less = middle,
            }
        }
        Ok(())
    }

    /// Leads the best motion, if it is one of straight legs, farther from the walls.
    fn widen(&mut self) -> Result<(), NoMotion> {
        let Self { errand, budget, .. } = *self;
        let rung = self.best_rung();
        let Some(best) = self.best.as_ref().filter(|_| is_between_poses(rung)) else {
            return Ok(());
        };
        if self.enough.is_some() {
            return Ok(());
        }
        let legs = &best.motion.legs;
        let curves = lattice::widened(errand, legs, budget)?;
        let Some(curves) = curves.and_then(|curves| set_out(errand, curves)) else {
            return Ok(());
        };
        let mut motion = RobotMotion { is_complete: true, ..RobotMotion::default() };
        motion.gap = best.motion.gap;
        let leg = |curve| Leg { curve, junction: None, rule: None, rung };
        let legs = curves.into_iter().map(leg).collect();
        if measure(errand, legs, &mut motion, budget)?.is_empty() {
            self.offer(motion)?;
        }
        Ok(())
    }

    /// Gap by gap, and between the neighbours of the best ones.
    fn scan(&mut self, most: f64) -> Result<(), NoMotion> {
        let (step, precision) = (self.in_strides(most / GAPS as f64), self.errand.precision());
        let mut kept = [Safety::NONE; GAPS];
        for (index, kept) in kept.iter_mut().enumerate().skip(1) {
            let found = self.try_target(with_gap(step * index as f64))?;
            *kept = found.unwrap_or(Safety::NONE);
        }
        let mut peaks: Vec<usize> = (1..GAPS).collect();
        peaks.retain(|&at| {
            let beside = [kept[at - 1], kept.get(at + 1).copied().unwrap_or(Safety::NONE)];
            kept[at].free > 0.0
                && beside.iter().all(|other| kept[at].compare(other, precision).is_ge())
        });
        // Sorting takes an order without a tolerance.
        let order = |at: &usize| kept[*at];
        peaks.sort_by(|one, other| {
            let (one, other) = (order(one), order(other));
            other.free.total_cmp(&one.free).then(other.clearance.total_cmp(&one.clearance))
        });
        for &at in peaks.iter().take(PEAKS) {
            // Clearance grows no faster than the gap.
            if kept[at].free + step > self.best_free() {
                let gap = step * at as f64;
                self.refine((gap - step).max(0.0), (gap + step).min(most))?;
            }
        }
        Ok(())
    }

    /// Motions between poses that keep more than the best so far, up to `most`, until no part of
    /// what is left is greater than `last`; metres.
    ///
    /// What is looked for is a whole number of [steps](Self::step), and measured clearances lead
    /// to whole [`STRIDE`]s, so that rounding does not decide which searches are made.
    fn try_poses(&mut self, rung: Rung, most: f64, last: f64) -> Result<(), NoMotion> {
        let unit = self.step();
        let counted = |clearance: f64| (clearance / unit) as u64;
        let strides = |clearance: f64| counted(clearance) / STRIDE * STRIDE;
        let (low, most, last) = (strides(self.best_free()), counted(most), counted(last).max(1));
        if most <= low + last {
            return Ok(());
        }
        let begun = self.budget.drawn(Cap::Steps);
        let look = |search: &mut Self, least: u64| {
            if search.budget.drawn(Cap::Steps) - begun > MOST_STEPS {
                return Ok(None);
            }
            let found = search.try_search(rung, least as f64 * unit)?;
            Ok::<_, NoMotion>(found.map(|found| strides(found.free).max(least)))
        };
        // A search that finds nothing takes the longest.
        let (mut known, mut high, mut part) = (low, most, FIRST_PART);
        while part < 1.0 && self.enough.is_none() {
            let least = low + ((part * (most - low) as f64) as u64).max(1);
            let Some(found) = look(self, least)? else {
                high = least;
                break;
            };
            known = found;
            part = GROWTH * part.max((known - low) as f64 / (most - low) as f64);
        }
        while low < known && known + last < high && self.enough.is_none() {
            let middle = known.midpoint(high);
            match look(self, middle)? {
                Some(found) => known = found,
                None => high = middle,
            }
        }
        // What is not found with some clearance may be found with more.
        for step in 1..=STEPS_ON {
            let least = high + (step as f64 * STEP_ON * high as f64) as u64;
            if rung == Rung::Lattice && least < most && self.enough.is_none() {
                look(self, least)?;
            }
        }
        Ok(())
    }

    /// A clearance in whole strides, at least one; metres.
    fn in_strides(&self, clearance: f64) -> f64 {
        let stride = STRIDE as f64 * self.step();
        libm::round(clearance / stride).max(1.0) * stride
    }

    /// Searches between poses tell clearances apart by this, metres.
    fn step(&self) -> f64 {
        STEP * self.errand.footprint.length()
    }

    /// Looks for lines with a little more clearance than the best.
    fn step_on(&mut self, most: f64) -> Result<(), NoMotion> {
        for _ in 0..ROUNDS {
            if !is_between_poses(self.best_rung()) {
                break;
            }
            self.widen()?;
            let low = self.best_free();
            for step in 1..=STEPS_ON {
                let least = self.in_strides(low * (1.0 + STEP_ON * step as f64));
                if least < most && self.enough.is_none() {
                    self.try_search(Rung::Aligned, least)?;
                }
            }
            if self.best_free() <= low + self.errand.precision() {
                break;
            }
        }
        Ok(())
    }

    /// Larger circles that keep more than the best so far, up to `most`, halving what is left.
    fn try_larger_circles(&mut self, most: f64) -> Result<(), NoMotion> {
        let (mut low, mut high) = (self.best_free(), most);
        while high - low > self.errand.precision() && self.enough.is_none() {
            let middle = (low + high) / 2.0;
            if middle <= low || middle >= high {
                break;
            }
            match self.try_target(at_least(middle))? {
                Some(found) => low = found.free.max(middle),
                None => high = middle,
            }
        }
        Ok(())
    }

    fn best_rung(&self) -> Option<Rung> {
        self.best.as_ref()?.motion.legs.first()?.rung
    }

    fn best_free(&self) -> f64 {
        self.top
    }

    /// How safe the motion is that keeps this, if there is one.
    fn try_target(&mut self, target: Target) -> Result<Option<Safety>, NoMotion> {
        let mut motion = RobotMotion::default();
        match shortest(self.errand, target, self.planner, &mut motion, self.budget) {
            Ok(()) => {
                let taut = motion.taut_length.unwrap_or(f64::INFINITY);
                if target.least.is_none() && motion.length > LONG * taut {
                    self.long_gap = self.long_gap.max(target.gap);
                }
                let safety = self.offer(motion)?;
                if target.least.is_none() {
                    self.tried.push([target.gap, safety.free]);
                }
                Ok(Some(safety))
            }
            Err(NoMotion::Spent(spent)) => Err(spent.into()),
            Err(refused) => {
                let is_plain = target.least.is_none() && target.last > LastRung::Radius;
                if matches!(refused, NoMotion::Blocked { .. }) && is_plain {
                    self.blocked_gap = Some(target.gap);
                    self.refused = Some(refused);
                } else {
                    self.refused.get_or_insert(refused);
                }
                Ok(None)
            }
        }
    }

    /// How safe a motion between poses is that keeps this, if there is one.
    fn try_search(&mut self, rung: Rung, least: f64) -> Result<Option<Safety>, NoMotion> {
        let mut motion = RobotMotion { is_complete: true, ..RobotMotion::default() };
        let kind = (rung, f64::INFINITY);
        let target = at_least(least);
        if !poses(self.errand, target, kind, self.planner, &mut motion, self.budget)? {
            return Ok(None);
        }
        self.offer(motion).map(Some)
    }

    /// Keeps a motion if it is better; how safe it is.
    fn offer(&mut self, mut motion: RobotMotion) -> Result<Safety, NoMotion> {
        let precision = self.errand.precision();
        bound::measure_free_clearance(self.errand, &mut motion, self.budget)?;
        let free = motion.free_clearance;
        let clearance = match (self.errand.goal.heading, &motion.clearance) {
            (None, Some(clearance)) => clearance.value,
            _ => 0.0,
        };
        let cost = cost(self.errand, &motion.legs);
        let safety = Safety { free, clearance };
        let found = Contender { safety, cost, motion };
        if self.least.is_some_and(|least| free >= least - precision)
            && self.enough.as_ref().is_none_or(|enough| cost < enough.cost)
        {
            self.enough = Some(found.clone());
        }
        self.top = self.top.max(free);
        let least = self.top - precision / 2.0;
        let is_beaten = self.best.as_ref().is_some_and(|best| best.safety.free < least);
        if free >= least
            && (is_beaten
                || self.best.as_ref().is_none_or(|best| found.is_better_than(best, precision)))
        {
            self.best = Some(found);
        }
        Ok(safety)
    }

    /// Looks between two gaps, by golden sections.
    fn refine(&mut self, mut low: f64, mut high: f64) -> Result<(), NoMotion> {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let precision = self.errand.precision();
        let clear_at = |search: &mut Self, gap: f64| -> Result<Safety, NoMotion> {
            let target = Target { last: LastRung::Radius, ..with_gap(gap) };
            Ok(search.try_target(target)?.unwrap_or(Safety::NONE))
        };
        let mut one = high - GOLDEN * (high - low);
        let mut other = low + GOLDEN * (high - low);
        let mut at_one = clear_at(self, one)?;
        let mut at_other = clear_at(self, other)?;
        while high - low > precision {
            if at_one.compare(&at_other, precision).is_ge() {
                (high, other, at_other) = (other, one, at_one);
                one = high - GOLDEN * (high - low);
                if one <= low || one >= other {
                    break;
                }
                at_one = clear_at(self, one)?;
            } else {
                (low, one, at_one) = (one, other, at_other);
                other = low + GOLDEN * (high - low);
                if other >= high || other <= one {
                    break;
                }
                at_other = clear_at(self, other)?;
            }
        }
        Ok(())
    }
}

impl Contender {
    /// Of two that are as free.
    fn is_better_than(&self, other: &Self, rounding: f64) -> bool {
        let apart = self.safety.clearance - other.safety.clearance;
        if apart.abs() > rounding {
            return apart > 0.0;
        }
        let (length, than) = (self.motion.length, other.motion.length);
        if (length - than).abs() > PRECISION * than {
            length < than
        } else {
            self.cost < other.cost
        }
    }
}
