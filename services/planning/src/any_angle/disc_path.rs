//! The taut path alone.

use super::disc::Disc;
use super::planner::Planner;
use super::taut::TurnRadii;
use crate::budget::{Budget, Spent};
use crate::free_space::floor::Floor;
use crate::free_space::walls::Walls;
use crate::geometry::Vector;

/// The length of the shortest path of a disc, metres; `None` if it can't pass. Its centre keeps
/// the radius from every wall, or the distance at the start or the goal where that is less.
///
/// ```
/// use planning::any_angle::{Planner, disc_path};
/// use planning::budget::Budget;
/// use planning::free_space::floor::Floor;
/// use planning::free_space::walls::{Wall, Walls};
/// use planning::geometry::AxisBox;
///
/// // Past the end of a wall in a room: a tangent, an arc about the end, a tangent.
/// let mut walls = Walls::default();
/// walls.push_inside(&AxisBox::new([-9.0, -9.0].into(), [9.0, 9.0].into())?);
/// walls.push(Wall { from: [0.0, 0.0].into(), to: [0.0, -5.0].into() });
/// let budget = Budget::default();
/// walls.index(&budget)?;
/// let floor = Floor::new(&walls, &budget)?;
/// let ends = [[-3.0, -1.0].into(), [3.0, -1.0].into()];
/// let length = disc_path(&floor, &walls, 0.5, ends, &mut Planner::default(), &budget)?;
/// let tangent = f64::sqrt(10.0 - 0.25);
/// let arc = f64::atan(1.0 / 3.0) + f64::asin(0.5 / f64::sqrt(10.0));
/// assert!((length.expect("a way") - 2.0 * tangent - arc).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn disc_path(
    floor: &Floor,
    walls: &Walls<2>,
    radius: f64,
    ends: [Vector<2>; 2],
    planner: &mut Planner,
    budget: &Budget<'_>,
) -> Result<Option<f64>, Spent> {
    let disc = Disc::new(radius, ends, (walls, floor.rounding()), budget)?;
    let path = planner.taut.find(floor, &disc, TurnRadii::DISC, budget)?;
    Ok(path.map(|path| path.length))
}
