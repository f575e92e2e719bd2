//! Taking in a request's solids: as walls, or cut into boxes.

use planning::budget::{Budget, Spent};
use planning::free_space::solids::{Solids, SolidsError};
use planning::free_space::walls::Walls;
use planning::geometry::{AxisBox, Vector};
use schemas::message::{self, Refusal, Solid};

use crate::check;
use crate::refuse::{Axes, Refused};
use crate::scene::Scene;

/// Something that takes in solids, one by one.
pub(crate) trait TakeSolids<const D: usize> {
    /// A box, checked; or another box of the solid before.
    fn take_box(&mut self, solid: &AxisBox<D>, goes_on: bool) -> Result<(), Refused>;

    /// A polygon by its vertices, not checked yet.
    fn take_polygon(
        &mut self,
        field: &dyn Fn() -> String,
        points: &[message::Vector],
    ) -> Result<(), Refused>;

    /// There are no more.
    fn close(&mut self) -> Result<(), Refused> {
        Ok(())
    }
}

/// The solids' surfaces become walls.
pub(crate) struct Surfaces<'a, const D: usize> {
    pub(crate) walls: &'a mut Walls<D>,
    /// What lies outside of this is wall as well.
    pub(crate) within: Option<AxisBox<D>>,
    pub(crate) outline: &'a mut Vec<Vector<2>>,
    pub(crate) budget: &'a Budget<'a>,
}

/// The solids, whose sides are parallel to the axes, are cut into boxes.
pub(crate) struct Pieces<'a, const D: usize> {
    pub(crate) solids: &'a mut Solids<D>,
    pub(crate) outline: &'a mut Vec<Vector<2>>,
    pub(crate) budget: &'a Budget<'a>,
}

impl<const D: usize> Surfaces<'_, D> {
    fn push(&mut self, solid: &AxisBox<D>, goes_on: bool) {
        match goes_on {
            true => self.walls.push_more(solid),
            false => self.walls.push_box(solid),
        }
    }
}

impl<const D: usize> Pieces<'_, D> {
    fn push(&mut self, solid: &AxisBox<D>, goes_on: bool) -> Result<(), Spent> {
        match goes_on {
            true => self.solids.push_more(*solid, self.budget),
            false => self.solids.push_box(*solid, self.budget),
        }
    }
}

impl TakeSolids<2> for Surfaces<'_, 2> {
    fn take_box(&mut self, solid: &AxisBox<2>, goes_on: bool) -> Result<(), Refused> {
        self.push(solid, goes_on);
        Ok(())
    }

    fn take_polygon(
        &mut self,
        field: &dyn Fn() -> String,
        points: &[message::Vector],
    ) -> Result<(), Refused> {
        let solid = check::polygon(field, points, self.outline, self.budget)?;
        self.walls.push_polygon(&solid);
        *self.outline = solid.into_vertices();
        Ok(())
    }

    fn close(&mut self) -> Result<(), Refused> {
        if let Some(within) = &self.within {
            self.walls.push_inside(within);
        }
        Ok(self.walls.index(self.budget)?)
    }
}

impl TakeSolids<3> for Surfaces<'_, 3> {
    fn take_box(&mut self, solid: &AxisBox<3>, goes_on: bool) -> Result<(), Refused> {
        self.push(solid, goes_on);
        Ok(())
    }

    fn take_polygon(
        &mut self,
        field: &dyn Fn() -> String,
        _: &[message::Vector],
    ) -> Result<(), Refused> {
        Err(check::flat(field()).into())
    }

    fn close(&mut self) -> Result<(), Refused> {
        Ok(self.walls.index(self.budget)?)
    }
}

impl TakeSolids<2> for Pieces<'_, 2> {
    fn take_box(&mut self, solid: &AxisBox<2>, goes_on: bool) -> Result<(), Refused> {
        Ok(self.push(solid, goes_on)?)
    }

    fn take_polygon(
        &mut self,
        field: &dyn Fn() -> String,
        points: &[message::Vector],
    ) -> Result<(), Refused> {
        let solid = check::polygon(field, points, self.outline, self.budget)?;
        let pushed = self.solids.push_polygon(&solid, self.budget);
        *self.outline = solid.into_vertices();
        pushed.map_err(|error| match error {
            SolidsError::Spent(spent) => spent.into(),
            SolidsError::Slanted { .. } => {
                let field = field();
                let message = format!("{field}: {error}");
                Refusal::invalid(field, message).into()
            }
        })
    }
}

impl TakeSolids<3> for Pieces<'_, 3> {
    fn take_box(&mut self, solid: &AxisBox<3>, goes_on: bool) -> Result<(), Refused> {
        Ok(self.push(solid, goes_on)?)
    }

    fn take_polygon(
        &mut self,
        field: &dyn Fn() -> String,
        _: &[message::Vector],
    ) -> Result<(), Refused> {
        Err(check::flat(field()).into())
    }
}

/// Takes in the scene's solids.
pub(super) fn take_all<const D: usize>(
    scene: Scene<'_>,
    axes: &Axes,
    mut into: impl TakeSolids<D>,
    budget: &Budget<'_>,
) -> Result<(), Refused> {
    for (index, solid) in scene.free_space.solids.iter().flatten().enumerate() {
        budget.step(1)?;
        match solid {
            Solid::Box(sides) => {
                let field = || format!("free_space.solids[{index}].box");
                into.take_box(&check::axis_box(field, axes, sides)?, false)?;
            }
            Solid::Boxes(boxes) => {
                if boxes.is_empty() {
                    return Err(check::no_boxes(format!("free_space.solids[{index}].boxes")).into());
                }
                budget.step(boxes.len() as u64)?;
                for (part, sides) in boxes.iter().enumerate() {
                    let field = || format!("free_space.solids[{index}].boxes[{part}]");
                    into.take_box(&check::axis_box(field, axes, sides)?, part > 0)?;
                }
            }
            Solid::Polygon(points) => {
                let field = || format!("free_space.solids[{index}].polygon");
                into.take_polygon(&field, points)?;
            }
        }
    }
    into.close()
}
