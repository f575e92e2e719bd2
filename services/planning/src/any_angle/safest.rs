//! The motion with the greatest free clearance.

use super::disc::disc_of;
use super::ladder::{Target, shortest};
use super::measure::cost;
use super::planner::Planner;
use super::{Errand, LEAST_GAP, NoMotion, PRECISION, RobotMotion, bound, refusal};
use crate::budget::{Budget, Spent};

/// Gaps looked at one by one, since more gap need not mean more clearance.
const GAPS: usize = 32;

/// A disc that is wider than the widest by this part is stuck beside an end if there.
const BESIDE: f64 = 1e-6;

/// How often poses are searched.
const MOST_POSES: usize = 3;

/// Finds the motion with the greatest free clearance, and among those within 1e-9 m of it the
/// least costly.
///
/// What has at least some clearance is found for more and more of it, halving; and because a
/// larger gap can lead the robot's ends nearer to a wall, gaps are also tried one by one.
pub(super) fn safest(
    errand: &Errand<'_>,
    planner: &mut Planner,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<(), NoMotion> {
    let mut search =
        SafestSearch { errand, planner, best: None, refused: None, blocked_gap: None, budget };
    match search.try_some().and_then(|()| search.run()) {
        Err(NoMotion::Spent(Spent::Limit { .. })) if search.best.is_some() => {
            if let Some(best) = &mut search.best {
                best.motion.is_complete = false;
            }
        }
        Err(error) => return Err(error),
        Ok(()) => {}
    }
    match search.best {
        Some(best) => {
            *found = best.motion;
            Ok(())
        }
        None => match search.refused {
            Some(refused) => Err(refused),
            None => Err(no_way(errand, search.planner, budget)?),
        },
    }
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
    Target { gap: least, least: Some(least), searches_poses: false }
}

fn with_gap(gap: f64) -> Target {
    Target { gap, least: None, searches_poses: false }
}

/// A motion that was found.
struct Contender {
    /// Its free clearance, metres.
    clearance: f64,
    cost: f64,
    motion: RobotMotion,
}

struct SafestSearch<'a, 'b> {
    errand: &'a Errand<'a>,
    planner: &'a mut Planner,
    best: Option<Contender>,
    refused: Option<NoMotion>,
    /// A gap with which the robot was blocked, metres.
    blocked_gap: Option<f64>,
    budget: &'a Budget<'b>,
}

impl SafestSearch<'_, '_> {
    /// Some gaps first, so that there is a motion if the budget ends.
    fn try_some(&mut self) -> Result<(), NoMotion> {
        let half = self.errand.footprint.width() / 2.0;
        let least = LEAST_GAP * self.errand.floor.extent();
        for gap in [least, half / 8.0, half / 2.0] {
            self.try_target(with_gap(gap))?;
        }
        Ok(())
    }

    fn run(&mut self) -> Result<(), NoMotion> {
        let Self { errand, budget, .. } = *self;
        let half = errand.footprint.width() / 2.0;
        // Nothing keeps more than the widest disc.
        let most = errand.floor.extent();
        let widest = refusal::widest(errand, most, self.planner, budget)?;
        let Some((widest, _)) = widest.filter(|(widest, _)| *widest > half) else {
            return Err(no_way(errand, self.planner, budget)?);
        };
        let (mut low, mut high) = (0.0, widest - half);
        let keeps_all = self.try_target(at_least(high))?;
        // Beside the ends a rectangle can keep more than a disc; in a passage it can't.
        let is_even = disc_of(errand, widest * (1.0 + BESIDE), budget)?.is_even();
        if !keeps_all || !is_even {
            for step in 1..GAPS {
                self.try_target(with_gap(high * step as f64 / GAPS as f64))?;
            }
            self.refine(high / GAPS as f64, high)?;
        }
        if !keeps_all {
            // Where a gap leads nowhere else, poses are searched, whatever the gap.
            if let Some(gap) = self.blocked_gap {
                self.try_target(Target { searches_poses: true, ..with_gap(gap) })?;
            }
            low = self.best_clearance().max(low);
            while high - low > PRECISION {
                let middle = (low + high) / 2.0;
                if middle <= low || middle >= high {
                    break;
                }
                if self.try_target(at_least(middle))? {
                    low = self.best_clearance().max(middle);
                } else {
                    high = middle;
                }
            }
        }
        // Where nothing else helps, poses are searched, for half of the clearance and so on.
        let mut least = high / 2.0;
        for _ in 0..MOST_POSES {
            if self.best.is_some() {
                break;
            }
            self.try_target(Target { searches_poses: true, ..at_least(least) })?;
            least /= 4.0;
        }
        Ok(())
    }

    fn best_clearance(&self) -> f64 {
        self.best.as_ref().map_or(0.0, |best| best.clearance)
    }

    /// Whether there is such a motion; the best is kept.
    fn try_target(&mut self, target: Target) -> Result<bool, NoMotion> {
        let Some(found) = self.find(target)? else { return Ok(false) };
        let is_better = self.best.as_ref().is_none_or(|best| {
            found.clearance > best.clearance + PRECISION
                || (found.clearance >= best.clearance - PRECISION && found.cost < best.cost)
        });
        if is_better {
            self.best = Some(found);
        }
        Ok(true)
    }

    /// The motion that keeps this, if there is one.
    fn find(&mut self, target: Target) -> Result<Option<Contender>, NoMotion> {
        let mut motion = RobotMotion::default();
        match shortest(self.errand, target, self.planner, &mut motion, self.budget) {
            Ok(()) => {}
            Err(NoMotion::Spent(Spent::Limit { .. })) if self.best.is_some() => {
                if let Some(best) = &mut self.best {
                    best.motion.is_complete = false;
                }
                return Ok(None);
            }
            Err(NoMotion::Spent(spent)) => return Err(spent.into()),
            Err(refused) => {
                if matches!(refused, NoMotion::Blocked { .. }) && target.least.is_none() {
                    self.blocked_gap = Some(target.gap);
                    self.refused = Some(refused);
                } else {
                    self.refused.get_or_insert(refused);
                }
                return Ok(None);
            }
        }
        bound::measure_free_clearance(self.errand, &mut motion, self.budget)?;
        let (clearance, cost) = (motion.free_clearance, cost(self.errand, &motion.legs));
        Ok(Some(Contender { clearance, cost, motion }))
    }

    /// Looks between the neighbours of the best gap, by golden sections.
    fn refine(&mut self, step: f64, most: f64) -> Result<(), NoMotion> {
        let Some(gap) = self.best.as_ref().map(|best| best.motion.gap) else {
            return Ok(());
        };
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let (mut low, mut high) = ((gap - step).max(0.0), (gap + step).min(most));
        let clearance_at = |search: &mut Self, gap: f64| -> Result<f64, NoMotion> {
            let Some(found) = search.find(with_gap(gap))? else { return Ok(0.0) };
            let clearance = found.clearance;
            if search.best_clearance() < clearance {
                search.best = Some(found);
            }
            Ok(clearance)
        };
        let mut one = high - GOLDEN * (high - low);
        let mut other = low + GOLDEN * (high - low);
        let mut at_one = clearance_at(self, one)?;
        let mut at_other = clearance_at(self, other)?;
        while high - low > PRECISION * most.max(1.0) {
            if at_one >= at_other {
                (high, other, at_other) = (other, one, at_one);
                one = high - GOLDEN * (high - low);
                if one <= low || one >= other {
                    break;
                }
                at_one = clearance_at(self, one)?;
            } else {
                (low, one, at_one) = (one, other, at_other);
                other = low + GOLDEN * (high - low);
                if other >= high || other <= one {
                    break;
                }
                at_other = clearance_at(self, other)?;
            }
        }
        Ok(())
    }
}
