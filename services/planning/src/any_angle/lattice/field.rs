//! How far it is to the goal at least: a grid search for the disc inside the footprint.

use std::collections::BinaryHeap;

use super::probe::Probe;
use crate::any_angle::queue::Queued;
use crate::budget::{Budget, Held, Spent};
use crate::geometry::Vector;
use crate::geometry::distance::distance_segment_segment;

/// A cell is this part of the footprint's width.
const CELLS_PER_WIDTH: f64 = 4.0;

/// Over more cells than this the grid is made coarser.
const MOST_CELLS: f64 = 2e6;

/// The search goes this much farther than to the start, so that detours are known as well.
const BEYOND: f64 = 1.5;

/// Distances are known up to the turning circle's radius and so many cells.
const REACH: f64 = 4.0;

/// With so many cells around the turning circle a place is open: poses need not be told apart
/// finely there.
const OPEN: f64 = 2.5;

/// Steps of the budget that a cell, and one of its neighbours, takes.
const STEPS_PER_CELL: u64 = 8;

/// Half of the diagonal of a cell of side 1.
const HALF_DIAGONAL: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Moves in 16 directions: to the eight neighbours and as a knight. Paths along them are at most
/// [`DETOUR`] times as long as straight ones.
const MOVES: [(i64, i64, f64); 16] = {
    const DIAGONAL: f64 = std::f64::consts::SQRT_2;
    const KNIGHT: f64 = 2.236_067_977_499_79;
    [
        (1, 0, 1.0),
        (2, 1, KNIGHT),
        (1, 1, DIAGONAL),
        (1, 2, KNIGHT),
        (0, 1, 1.0),
        (-1, 2, KNIGHT),
        (-1, 1, DIAGONAL),
        (-2, 1, KNIGHT),
        (-1, 0, 1.0),
        (-2, -1, KNIGHT),
        (-1, -1, DIAGONAL),
        (-1, -2, KNIGHT),
        (0, -1, 1.0),
        (1, -2, KNIGHT),
        (1, -1, DIAGONAL),
        (2, -1, KNIGHT),
    ]
};

/// See [`MOVES`].
pub(super) const DETOUR: f64 = 1.028;

/// A grid over everything, with the start in the middle of a cell.
#[derive(Debug, Default)]
pub(super) struct Field {
    /// Side of a cell, metres.
    pub(super) step: f64,
    /// The place of the first cell in the grid through the start.
    first: [i64; 2],
    size: [i64; 2],
    /// Distance of each cell's middle from the walls, up to `reach`; NaN where not known yet.
    clear: Vec<f64>,
    reach: f64,
    /// Whether those distances are of the scene at hand.
    is_known: bool,
    /// The way from each cell's middle to the goal, metres; infinite where not known.
    to_goal: Vec<f64>,
    heap: BinaryHeap<Queued>,
}

impl Field {
    pub(super) fn bytes(&self) -> usize {
        (self.clear.capacity() + self.to_goal.capacity()) * size_of::<f64>()
            + self.heap.capacity() * size_of::<Queued>()
    }

    /// To be called before it is built in another scene.
    pub(super) fn forget(&mut self) {
        self.is_known = false;
    }

    /// Covers all walls, the start and the goal, and finds the way from everywhere to the goal.
    /// `None` if there is none from the start; otherwise the memory that it takes meanwhile.
    pub(super) fn build<'a>(&mut self, probe: &Probe<'a>) -> Result<Option<Held<'a>>, Spent> {
        let held = self.lay_out(probe)?;
        self.search(probe)?;
        Ok(self.to_goal(&Vector::zeros()).is_finite().then_some(held))
    }

    /// The least way from a point to the goal, metres; infinite if none is known.
    pub(super) fn to_goal(&self, point: &Vector<2>) -> f64 {
        self.cell(point).map_or(f64::INFINITY, |cell| self.to_goal[cell])
    }

    /// The distance of a point from the walls is at least, and at most, this, metres; at most
    /// infinite where they are far. It is a quick answer.
    pub(super) fn clear_about(
        &mut self,
        probe: &Probe<'_>,
        point: &Vector<2>,
    ) -> Result<[f64; 2], Spent> {
        let Some(cell) = self.cell(point) else { return Ok([0.0, f64::INFINITY]) };
        let apart = (point - self.middle(cell)).norm();
        let clear = self.clear(probe, cell)?;
        let most = if clear < self.reach { clear + apart } else { f64::INFINITY };
        Ok([clear - apart, most])
    }

    /// Whether a place is open if its distance from the walls is at least this.
    pub(super) fn is_open(&self, clear: f64, probe: &Probe<'_>) -> bool {
        clear >= probe.swing + OPEN * self.step
    }

    fn lay_out<'a>(&mut self, probe: &Probe<'a>) -> Result<Held<'a>, Spent> {
        let walls = probe.errand.walls.as_slice();
        probe.budget.step(walls.len() as u64)?;
        let (mut low, mut high) = (Vector::<2>::zeros(), Vector::<2>::zeros());
        let ends = walls.iter().flat_map(|wall| [&wall.from, &wall.to]);
        for point in ends.map(|end| probe.in_frame(end)).chain([probe.goal]) {
            (low, high) = (low.inf(&point), high.sup(&point));
        }
        // No way that is short enough leads beyond.
        let center = probe.goal / 2.0;
        let reach = Vector::repeat(DETOUR * probe.most_length / 2.0);
        if probe.most_length.is_finite() {
            (low, high) = (low.sup(&(center - reach)), high.inf(&(center + reach)));
        }
        let step = probe.errand.footprint.width() / CELLS_PER_WIDTH;
        let margin = Vector::repeat(2.0 * probe.swing + 2.0 * step);
        (low, high) = (low - margin, high + margin);
        let before = (self.step, self.first, self.size);
        let size = high - low;
        self.step = step.max((size.x * size.y / MOST_CELLS).sqrt());
        self.step = self.step.max(size.amax() / MOST_CELLS);
        for axis in 0..2 {
            self.first[axis] = (low[axis] / self.step).floor() as i64;
            self.size[axis] = (high[axis] / self.step).ceil() as i64 - self.first[axis] + 1;
        }
        let cells = (self.size[0] * self.size[1]) as usize;
        probe.budget.step(cells as u64 / 8)?;
        let held = Held::new(probe.budget, 2 * cells * size_of::<f64>())?;
        self.find_clear_to(probe.swing + REACH * self.step, before, cells);
        self.to_goal.clear();
        self.to_goal.resize(cells, f64::INFINITY);
        self.heap.clear();
        Ok(held)
    }

    /// Distances are to be known up to `reach`. Those of the search before stay, if it was on the
    /// same grid in the same scene.
    fn find_clear_to(&mut self, reach: f64, before: (f64, [i64; 2], [i64; 2]), cells: usize) {
        if self.is_known && before == (self.step, self.first, self.size) {
            if reach > self.reach {
                let known = self.reach;
                let beyond = self.clear.iter_mut().filter(|clear| **clear >= known);
                beyond.for_each(|clear| *clear = f64::NAN);
                self.reach = reach;
            }
            return;
        }
        self.is_known = true;
        self.reach = reach;
        self.clear.clear();
        self.clear.resize(cells, f64::NAN);
    }

    fn cell(&self, point: &Vector<2>) -> Option<usize> {
        let place = |axis: usize| libm::round(point[axis] / self.step) as i64;
        self.cell_at([place(0), place(1)])
    }

    fn cell_at(&self, place: [i64; 2]) -> Option<usize> {
        let at = [place[0] - self.first[0], place[1] - self.first[1]];
        let is_inside = (0..2).all(|axis| 0 <= at[axis] && at[axis] < self.size[axis]);
        is_inside.then(|| (at[1] * self.size[0] + at[0]) as usize)
    }

    fn place(&self, cell: usize) -> [i64; 2] {
        let cell = cell as i64;
        [cell % self.size[0] + self.first[0], cell / self.size[0] + self.first[1]]
    }

    fn middle(&self, cell: usize) -> Vector<2> {
        let [x, y] = self.place(cell);
        Vector::<2>::new(x as f64 * self.step, y as f64 * self.step)
    }

    fn clear(&mut self, probe: &Probe<'_>, cell: usize) -> Result<f64, Spent> {
        if self.clear[cell].is_nan() {
            self.clear[cell] = probe.distance(&self.middle(cell), self.reach)?;
        }
        Ok(self.clear[cell])
    }

    /// From the goal outwards.
    fn search(&mut self, probe: &Probe<'_>) -> Result<(), Spent> {
        let Some(start) = self.cell(&Vector::zeros()) else { return Ok(()) };
        // A cell is passed if the disc fits anywhere in it.
        let spare = HALF_DIAGONAL * self.step;
        let needs = probe.inner - spare;
        let around = libm::round(probe.goal.x / self.step) as i64;
        let beside = libm::round(probe.goal.y / self.step) as i64;
        for place in (-1..=1).flat_map(|x| (-1..=1).map(move |y| [around + x, beside + y])) {
            let Some(cell) = self.cell_at(place) else { continue };
            let middle = self.middle(cell);
            let is_goal = place == [around, beside];
            if is_goal || !crosses_wall(probe, &probe.goal, &middle)? {
                self.offer((middle - probe.goal).norm(), cell);
            }
        }
        let mut most = f64::INFINITY;
        // Ways on the grid are longer, and end in the middle of cells.
        let longest = DETOUR * probe.most_length + 4.0 * self.step;
        while let Some(Queued { least: way, index: cell }) = self.heap.pop() {
            if way > self.to_goal[cell] {
                continue;
            }
            if way > most {
                break;
            }
            if cell == start {
                most = BEYOND * way + 8.0 * probe.swing;
            }
            probe.budget.step(STEPS_PER_CELL)?;
            let [x, y] = self.place(cell);
            let here = self.clear(probe, cell)?;
            for (right, up, length) in MOVES {
                let Some(next) = self.cell_at([x + right, y + up]) else { continue };
                let further = way + length * self.step;
                if further >= self.to_goal[next] || further + self.middle(next).norm() > longest {
                    continue;
                }
                let there = self.clear(probe, next)?;
                if there < needs
                    && next != start
                    && there < probe.inner_at(&self.middle(next)) - spare
                {
                    continue;
                }
                if here + there <= length * self.step
                    && crosses_wall(probe, &self.middle(cell), &self.middle(next))?
                {
                    continue;
                }
                self.offer(further, next);
            }
        }
        Ok(())
    }

    fn offer(&mut self, way: f64, cell: usize) {
        if way < self.to_goal[cell] {
            self.to_goal[cell] = way;
            self.heap.push(Queued { least: way, index: cell });
        }
    }
}

fn crosses_wall(probe: &Probe<'_>, from: &Vector<2>, to: &Vector<2>) -> Result<bool, Spent> {
    let [from, to] = [from, to].map(|point| probe.in_world(point));
    let budget: &Budget<'_> = probe.budget;
    let (mut crosses, mut looks) = (false, 0);
    probe.errand.walls.near_line((&from, &to), 0.0, budget, |_, wall| {
        looks += 1;
        crosses = distance_segment_segment((&from, &to), (&wall.from, &wall.to)).distance <= 0.0;
        !crosses
    })?;
    budget.step(looks)?;
    Ok(crosses)
}
