//! A scene as a search between poses sees it.
//!
//! The start pose is the origin and heads along x, the unit is the robot's length, and all numbers
//! are rounded to a grid. A scene that is turned, moved or given in another unit is the same there
//! to the last bit, and so is all that a search decides, ties included. What it finds is brought
//! back to the scene as it is, with its goal as it is, and checked there.

use crate::any_angle::{Abilities, Costs, Errand};
use crate::budget::{Budget, Cap, Spent};
use crate::clearance::rectangle::Footprint;
use crate::driving::{Goal, Pose};
use crate::free_space::floor::{Floor, FloorError};
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::distance::distance_point_segment;
use crate::geometry::{Vector, unit, unrotated};
use crate::motion::wrapped;

/// Coordinates are multiples of this, in lengths of the robot. It is coarse enough that the rounding
/// of coordinates 10^6 m away hardly ever decides, and fine enough not to matter.
const GRID: f64 = 1.0 / (1_u64 << 19) as f64;

/// So are sizes, angles and costs, which have no origin.
const FINE_GRID: f64 = 1.0 / (1_u64 << 30) as f64;

/// A search keeps so much more from the walls than it is asked for: walls, goal and motions move by
/// the grid.
pub(super) const SLACK: f64 = 4.0 * GRID;

/// Steps of the budget that a wall takes.
const STEPS_PER_WALL: u64 = 2;

/// A scene in its own frame.
#[derive(Debug)]
pub(super) struct OwnScene {
    walls: Walls<2>,
    floor: Floor,
    footprint: Footprint,
    goal: Goal,
    /// The robot's length, metres.
    pub(super) length: f64,
    /// Memory taken from the budget, bytes.
    held: usize,
}

impl OwnScene {
    /// That of an errand; `None` if its walls enclose nothing.
    pub(super) fn of(errand: &Errand<'_>, budget: &Budget<'_>) -> Result<Option<Self>, Spent> {
        let Errand { footprint, start, goal, .. } = errand;
        let before = budget.drawn(Cap::Bytes);
        let length = footprint.length();
        let axis = unit(start.heading);
        let place = |point: &Vector<2>| {
            let point = unrotated(&(point - start.position), &axis);
            point.map(|x| on_grid(x / length, GRID))
        };
        let met = walls_met(errand, budget)?;
        budget.step(met.len() as u64 * STEPS_PER_WALL)?;
        let mut walls = Walls::default();
        for (wall, _) in errand.walls.as_slice().iter().zip(met).filter(|(_, is_met)| *is_met) {
            walls.push(Wall { from: place(&wall.from), to: place(&wall.to) });
        }
        walls.index(budget)?;
        let floor = match Floor::new(&walls, budget) {
            Ok(floor) => floor,
            Err(FloorError::Spent(spent)) => return Err(spent),
            Err(FloorError::Empty) => return Ok(None),
        };
        budget.hold(floor.bytes())?;
        let sides = [footprint.width(), footprint.front(), footprint.rear()];
        let [width, front, rear] = sides.map(|side| on_grid(side / length, FINE_GRID));
        let heading = goal
            .heading
            .map(|heading| wrapped(on_grid(wrapped(heading - start.heading), FINE_GRID)));
        Ok(Some(Self {
            walls,
            floor,
            // Sides that vanish on the grid are as good as they are.
            footprint: Footprint::offset(width, front, rear).unwrap_or(*footprint),
            goal: Goal { position: place(&goal.position), heading },
            length,
            held: (budget.drawn(Cap::Bytes) - before) as usize,
        }))
    }

    /// The errand there.
    pub(super) fn errand(&self, errand: &Errand<'_>) -> Errand<'_> {
        let Self { walls, floor, footprint, goal, .. } = self;
        let Abilities { min_turn_radius, .. } = errand.abilities;
        let Costs { turn, stop } = errand.costs;
        let fine = |metres: f64| on_grid(metres / self.length, FINE_GRID);
        Errand {
            footprint: *footprint,
            start: Pose { position: Vector::zeros(), heading: 0.0 },
            goal: *goal,
            start_turn: errand.start_turn,
            abilities: Abilities { min_turn_radius: fine(min_turn_radius), ..errand.abilities },
            costs: Costs { turn: fine(turn), stop: fine(stop) },
            walls,
            floor,
        }
    }

    /// A distance there, with what a search keeps beside it.
    pub(super) fn kept(&self, metres: f64) -> f64 {
        on_grid(metres / self.length, FINE_GRID) + SLACK
    }

    /// A length there that is not less.
    pub(super) fn at_most(&self, metres: f64) -> f64 {
        on_grid(metres / self.length + GRID, GRID)
    }

    /// Gives back the memory that it has taken.
    pub(super) fn release(&self, budget: &Budget<'_>) {
        budget.release(self.held);
    }
}

/// Which walls can be met from the start. Others, such as the bounds around walls that enclose the
/// start, need not be turned with the scene, and must not matter.
fn walls_met(errand: &Errand<'_>, budget: &Budget<'_>) -> Result<Vec<bool>, Spent> {
    let Errand { walls, floor, start, .. } = errand;
    let mut met = vec![false; walls.as_slice().len()];
    // Where walls cross, the floor's vertices are rounded.
    let reach = 4.0 * floor.rounding();
    for ends in floor.reachable(&start.position, budget)?.border {
        let [from, to] = ends.map(|vertex| floor.vertex(vertex));
        let middle = (from + to) / 2.0;
        walls.near(&middle, &middle, reach, budget, |index, wall| {
            met[index] |= distance_point_segment(&middle, (&wall.from, &wall.to)) <= reach;
        })?;
    }
    Ok(met)
}

fn on_grid(x: f64, grid: f64) -> f64 {
    libm::round(x / grid) * grid
}
