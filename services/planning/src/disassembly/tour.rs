//! The shortest way that passes through boxes in order.
//!
//! Its length is a convex function of its way-points, each of which has its box. A barrier keeps them
//! inside; Newton's method finds where length and barrier are least together, for a barrier that is
//! lowered until it is no more than rounding. The way-points then are put on the sides that hold them.
//!
//! What no way is shorter than follows from the directions of the legs alone: for any vectors $u_i$ of
//! at most unit length, a leg is at least as long as its product with $u_i$, and the sum of these
//! products is least at corners of the boxes.

use nalgebra::linalg::Cholesky;
use nalgebra::{Const, SMatrix};

use crate::budget::{Budget, Spent};
use crate::geometry::{Sign, Vector};

type Matrix<const D: usize> = SMatrix<f64, D, D>;

/// Parts of the scene's extent, all of these.
/// The barrier at first and at last, and by what it is lowered each time.
const FIRST_BARRIER: f64 = 0.1;
const LAST_BARRIER: f64 = 1e-12;
const LOWERED: f64 = 0.2;

/// A box thinner than this is a place.
const THIN: f64 = 1e-13;

/// A side holds a way-point that presses on it by more than this.
const HELD: f64 = 1e-5;

/// Way-points nearer to each other than this are one.
const SAME_PLACE: f64 = 1e-7;

/// Directions that differ by no more than this are the same.
const STRAIGHT: f64 = 1e-9;

/// A way may miss a box by this.
const MISSED: f64 = 1e-11;

/// Steps of Newton's method for a barrier, and halvings of a step, at most.
const MOST_STEPS: usize = 40;
const MOST_HALVINGS: usize = 30;

/// Steps of the budget that a way-point takes in one of them.
const STEPS_PER_GATE: u64 = 24;

/// Bytes that a way-point takes.
const BYTES_PER_GATE: usize = 640;

/// By this part of its stiffness a spring is made stiffer at first where rounding has made it too soft,
/// and how often.
const STIFFER: f64 = 1e-6;
const MOST_STIFFER: usize = 6;

/// A stiffness that nothing moves.
const RIGID: f64 = 1e20;

/// A box that a way has to pass through; it may be flat, or a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gate<const D: usize> {
    pub(super) min: Vector<D>,
    pub(super) max: Vector<D>,
}

/// The shortest way.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tour<const D: usize> {
    /// Where it bends, and where it ends: the gate, and the place in it.
    pub(super) bends: Vec<(usize, Vector<D>)>,
    /// No way is shorter, metres.
    pub(super) bound: f64,
}

/// The shortest way from `start` through all gates in order, to the last.
pub(super) fn shortest_tour<const D: usize>(
    start: &Vector<D>,
    gates: &[Gate<D>],
    budget: &Budget<'_>,
) -> Result<Tour<D>, Spent> {
    let reach = |gate: &Gate<D>| (gate.min - start).amax().max((gate.max - start).amax());
    let unit = gates.iter().map(reach).fold(0.0, f64::max);
    if unit <= 0.0 {
        let bends = gates.last().map(|_| (gates.len() - 1, *start));
        return Ok(Tour { bends: bends.into_iter().collect(), bound: 0.0 });
    }
    let bytes = gates.len().saturating_mul(BYTES_PER_GATE);
    budget.hold(bytes)?;
    let mut descent = Descent::new(start, gates, unit);
    let found = descent.run(budget);
    budget.release(bytes);
    found?;
    Ok(descent.tour(start, gates, unit))
}

/// A way-point on its way, in units of the scene's extent from the start.
#[derive(Debug, Clone, Copy)]
struct WayPointInGate<const D: usize> {
    at: Vector<D>,
    /// How far it is from the sides of its gate. Kept apart: near a side, the difference of two
    /// coordinates would be rounding.
    low: Vector<D>,
    high: Vector<D>,
    /// Coordinates that do not move.
    fixed: [bool; D],
}

/// The search for the shortest way.
struct Descent<const D: usize> {
    points: Vec<WayPointInGate<D>>,
    barrier: f64,
    /// Of each leg, the first of which begins at the start: its direction, no longer than 1, and its
    /// length, both rounded off by the barrier.
    legs: Vec<(Vector<D>, f64)>,
    steps: Vec<Vector<D>>,
    /// For each way-point what is before it as a spring, and the force from there.
    before: Vec<(Matrix<D>, Vector<D>)>,
}

impl<const D: usize> Descent<D> {
    fn new(start: &Vector<D>, gates: &[Gate<D>], unit: f64) -> Self {
        let point = |gate: &Gate<D>| {
            let (min, max) = ((gate.min - start) / unit, (gate.max - start) / unit);
            let half = (max - min) / 2.0;
            let fixed = std::array::from_fn(|axis| half[axis].is_nan() || half[axis] <= THIN);
            WayPointInGate { at: (min + max) / 2.0, low: half, high: half, fixed }
        };
        Self {
            points: gates.iter().map(point).collect(),
            barrier: FIRST_BARRIER,
            legs: Vec::with_capacity(gates.len()),
            steps: vec![Vector::zeros(); gates.len()],
            before: Vec::with_capacity(gates.len()),
        }
    }

    fn run(&mut self, budget: &Budget<'_>) -> Result<(), Spent> {
        let work = STEPS_PER_GATE * self.points.len() as u64;
        loop {
            for _ in 0..MOST_STEPS {
                budget.step(work)?;
                let decrement = self.find_step();
                if decrement.is_nan()
                    || decrement <= 1e-3 * self.barrier
                    || !self.take_step(decrement)
                {
                    break;
                }
            }
            if self.barrier <= LAST_BARRIER {
                self.measure_legs();
                return Ok(());
            }
            self.barrier = (self.barrier * LOWERED).max(LAST_BARRIER);
        }
    }

    fn measure_legs(&mut self) {
        self.legs.clear();
        let mut from = Vector::zeros();
        for point in &self.points {
            let along = point.at - from;
            let length = (along.norm_squared() + self.barrier * self.barrier).sqrt();
            self.legs.push((along / length, length));
            from = point.at;
        }
    }

    /// The change of direction at a way-point: the force of its legs.
    fn turn(&self, index: usize) -> Vector<D> {
        let after = self.legs.get(index + 1).map_or(Vector::zeros(), |leg| leg.0);
        self.legs[index].0 - after
    }

    /// How stiff a leg is against moving one of its ends.
    fn stiffness(&self, leg: usize) -> Matrix<D> {
        let (direction, length) = self.legs[leg];
        (Matrix::identity() - direction * direction.transpose()) / length
    }

    /// Newton's step: each way-point on springs, those before it taken together. Returns by how much
    /// the sum would fall, twice.
    fn find_step(&mut self) -> f64 {
        self.measure_legs();
        self.before.clear();
        let barrier = self.barrier;
        let mut gradients = 0.0;
        for index in 0..self.points.len() {
            let WayPointInGate { low, high, fixed, .. } = self.points[index];
            let turn = self.turn(index);
            let leg = self.stiffness(index);
            let (mut spring, mut force) = match index.checked_sub(1) {
                None => (leg, Vector::zeros()),
                Some(last) => {
                    let (before, pull) = self.before[last];
                    let Some(both) = factors(before + leg) else { return f64::NAN };
                    // In series: never a difference, which would be rounding.
                    let series = leg * both.solve(&before);
                    ((series + series.transpose()) / 2.0, leg * both.solve(&pull))
                }
            };
            for axis in 0..D {
                if fixed[axis] {
                    spring[(axis, axis)] += RIGID;
                    continue;
                }
                let (low, high) = (low[axis], high[axis]);
                spring[(axis, axis)] += barrier / (low * low) + barrier / (high * high);
                force[axis] -= turn[axis] - barrier / low + barrier / high;
            }
            self.before.push((spring, force));
        }
        for index in (0..self.points.len()).rev() {
            let (spring, force) = self.before[index];
            let (spring, force) = match self.steps.get(index + 1) {
                None => (spring, force),
                Some(after) => {
                    let leg = self.stiffness(index + 1);
                    (spring + leg, force + leg * after)
                }
            };
            let Some(spring) = factors(spring) else { return f64::NAN };
            let mut step = spring.solve(&force);
            let WayPointInGate { low, high, fixed, .. } = self.points[index];
            let turn = self.turn(index);
            for axis in 0..D {
                if fixed[axis] {
                    step[axis] = 0.0;
                } else {
                    let slope = turn[axis] - barrier / low[axis] + barrier / high[axis];
                    gradients += slope * step[axis];
                }
            }
            self.steps[index] = step;
        }
        -gradients
    }

    /// Length and barrier.
    fn sum(&self, part: f64) -> f64 {
        let mut from = Vector::zeros();
        let mut sum = 0.0;
        for (point, step) in self.points.iter().zip(&self.steps) {
            let at = point.at + step * part;
            sum += ((at - from).norm_squared() + self.barrier * self.barrier).sqrt();
            from = at;
            for axis in (0..D).filter(|axis| !point.fixed[*axis]) {
                let (low, high) = (point.low[axis], point.high[axis]);
                let step = step[axis] * part;
                sum -= self.barrier * (libm::log(low + step) + libm::log(high - step));
            }
        }
        sum
    }

    /// Goes as much of the step as the sides of the gates and the sum allow. Whether it went.
    fn take_step(&mut self, decrement: f64) -> bool {
        let mut part: f64 = 1.0;
        for (point, step) in self.points.iter().zip(&self.steps) {
            for axis in (0..D).filter(|axis| !point.fixed[*axis]) {
                let nearer = if step[axis] < 0.0 { point.low[axis] } else { point.high[axis] };
                part = part.min(0.9 * nearer / step[axis].abs());
            }
        }
        let now = self.sum(0.0);
        for _ in 0..MOST_HALVINGS {
            if self.sum(part) <= now - 0.1 * part * decrement + 1e-15 * now.abs() {
                for (point, step) in self.points.iter_mut().zip(&self.steps) {
                    point.at += step * part;
                    point.low += step * part;
                    point.high -= step * part;
                }
                return true;
            }
            part *= 0.5;
        }
        false
    }

    /// The way that was found, put on the sides that hold it.
    fn tour(&self, start: &Vector<D>, gates: &[Gate<D>], unit: f64) -> Tour<D> {
        let placed: Vec<(Vector<D>, usize)> = self
            .points
            .iter()
            .zip(gates)
            .map(|(point, gate)| self.place(point, gate, (start, unit)))
            .collect();
        let bends = bends(start, &placed, unit);
        let bends = match passes(start, &bends, gates, MISSED * unit) {
            true => bends,
            false => placed.iter().enumerate().map(|(gate, (at, _))| (gate, *at)).collect(),
        };
        let mut from = *start;
        let mut length = 0.0;
        for (_, at) in &bends {
            length += (at - from).norm();
            from = *at;
        }
        let directions: Vec<Vector<D>> = self.legs.iter().map(|leg| leg.0).collect();
        let bound = bound(start, &directions, gates);
        let bound = bound.max(self.bound_of(start, &bends, gates, directions));
        Tour { bends, bound: bound.min(length) }
    }

    /// Where a way-point is in metres, on the sides that hold it; and how many do.
    fn place(
        &self,
        point: &WayPointInGate<D>,
        gate: &Gate<D>,
        (start, unit): (&Vector<D>, f64),
    ) -> (Vector<D>, usize) {
        let mut at = start + point.at * unit;
        let mut held = 0;
        for axis in 0..D {
            let side = match self.held_by(point, axis) {
                Some(Sign::Negative) => gate.min[axis],
                Some(Sign::Positive) => gate.max[axis],
                None => continue,
            };
            (at[axis], held) = (side, held + 1);
        }
        (at, held)
    }

    /// The side of its gate that holds a way-point along an axis.
    fn held_by(&self, point: &WayPointInGate<D>, axis: usize) -> Option<Sign> {
        if point.fixed[axis] || self.barrier / point.low[axis] > HELD {
            Some(Sign::Negative)
        } else if self.barrier / point.high[axis] > HELD {
            Some(Sign::Positive)
        } else {
            None
        }
    }

    /// Directions of legs without length: as those beside them along axes that hold nothing between.
    /// By the descent they are known to rounding over the barrier only.
    fn settle(&self, directions: &mut [Vector<D>]) {
        let is_place = |leg: usize| self.legs[leg].1 <= SAME_PLACE;
        for leg in (1..directions.len()).filter(|leg| is_place(*leg)) {
            let (before, after) = directions.split_at_mut(leg);
            for (axis, along) in after[0].iter_mut().enumerate() {
                if self.held_by(&self.points[leg - 1], axis).is_none() {
                    *along = before[leg - 1][axis];
                }
            }
        }
        for leg in (0..directions.len().saturating_sub(1)).rev().filter(|leg| is_place(*leg)) {
            let (before, after) = directions.split_at_mut(leg + 1);
            for (axis, along) in before[leg].iter_mut().enumerate() {
                if self.held_by(&self.points[leg], axis).is_none() {
                    *along = after[0][axis];
                }
            }
        }
        for direction in directions {
            *direction /= direction.norm().max(1.0);
        }
    }

    /// The bound by the directions of the way itself, where it is more than a place.
    fn bound_of(
        &self,
        start: &Vector<D>,
        bends: &[(usize, Vector<D>)],
        gates: &[Gate<D>],
        mut directions: Vec<Vector<D>>,
    ) -> f64 {
        let (mut from, mut first) = (*start, 0);
        for (gate, at) in bends {
            let along = at - from;
            let length = along.norm();
            let legs = self.legs[first..=*gate].iter().zip(&mut directions[first..=*gate]);
            for ((_, reach), direction) in legs {
                if length > 0.0 && *reach > SAME_PLACE {
                    *direction = along / length;
                }
            }
            (from, first) = (*at, gate + 1);
        }
        self.settle(&mut directions);
        bound(start, &directions, gates)
    }
}

/// The factors of a matrix that is positive definite but for rounding: then a little stiffer, which
/// makes a step shorter and no worse in direction.
fn factors<const D: usize>(matrix: Matrix<D>) -> Option<Cholesky<f64, Const<D>>> {
    let mut more = 0.0;
    for _ in 0..MOST_STIFFER {
        if let Some(factors) = Cholesky::new(matrix + Matrix::identity() * more) {
            return Some(factors);
        }
        more = (more * 1e3).max(STIFFER * matrix.diagonal().amin());
    }
    None
}

/// What no way through the gates is shorter than, by these directions of its legs.
fn bound<const D: usize>(start: &Vector<D>, directions: &[Vector<D>], gates: &[Gate<D>]) -> f64 {
    let mut sum = 0.0;
    for (index, gate) in gates.iter().enumerate() {
        let after = directions.get(index + 1).copied().unwrap_or_else(Vector::zeros);
        let turn = directions[index] - after;
        for axis in 0..D {
            let side = if turn[axis] < 0.0 { gate.max[axis] } else { gate.min[axis] };
            sum += turn[axis] * (side - start[axis]);
        }
    }
    sum
}

/// The places at which the way bends, of all that it passes, and its end.
fn bends<const D: usize>(
    start: &Vector<D>,
    placed: &[(Vector<D>, usize)],
    unit: f64,
) -> Vec<(usize, Vector<D>)> {
    let last = placed.len() - 1;
    let mut found: Vec<(usize, Vector<D>, usize)> = Vec::new();
    for (gate, (at, held)) in placed.iter().enumerate() {
        if *held == 0 && gate != last {
            continue;
        }
        match found.last_mut() {
            // One place: as the sides that hold more of it have it.
            Some((known, place, of)) if (*place - at).norm() <= SAME_PLACE * unit => {
                if held > of || gate == last {
                    (*known, *place, *of) = (gate, *at, *held);
                }
            }
            _ => found.push((gate, *at, *held)),
        }
    }
    let mut bends: Vec<(usize, Vector<D>)> = Vec::new();
    for (index, (gate, at, _)) in found.iter().enumerate() {
        let from = bends.last().map_or(*start, |bend| bend.1);
        let before = (at - from).try_normalize(0.0);
        let after = found.get(index + 1).and_then(|next| (next.1 - at).try_normalize(0.0));
        let is_bend = match (before, after) {
            (Some(before), Some(after)) => (after - before).norm() > STRAIGHT,
            (None, Some(_)) => false,
            (_, None) => true,
        };
        if is_bend {
            bends.push((*gate, *at));
        }
    }
    bends
}

/// Whether a way passes all gates in order, to within `slack`, metres.
fn passes<const D: usize>(
    start: &Vector<D>,
    bends: &[(usize, Vector<D>)],
    gates: &[Gate<D>],
    slack: f64,
) -> bool {
    let (mut leg, mut since) = (0, 0.0);
    gates.iter().all(|gate| {
        while leg < bends.len() {
            let from = leg.checked_sub(1).map_or(*start, |before| bends[before].1);
            if let Some(at) = enters((&from, &bends[leg].1), gate, since, slack) {
                since = at;
                return true;
            }
            (leg, since) = (leg + 1, 0.0);
        }
        false
    })
}

/// Where a leg first is in a gate, from 0 to 1 and not before `since`.
fn enters<const D: usize>(
    (from, to): (&Vector<D>, &Vector<D>),
    gate: &Gate<D>,
    since: f64,
    slack: f64,
) -> Option<f64> {
    let (mut first, mut last) = (since, 1.0_f64);
    for axis in 0..D {
        let (low, high) = (gate.min[axis] - slack, gate.max[axis] + slack);
        let along = to[axis] - from[axis];
        if along.abs() <= slack {
            if !(low - slack..=high + slack).contains(&from[axis]) {
                return None;
            }
            continue;
        }
        let (a, b) = ((low - from[axis]) / along, (high - from[axis]) / along);
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    (first <= last).then_some(first)
}
