//! The body of an assembly task, read and checked.

use planning::budget::Budget;
use planning::clearance::translating::Body;
use planning::geometry::polygon::Polygon;
use planning::geometry::{AxisBox, Vector};
use schemas::message;

use crate::check;
use crate::refuse::{Axes, PLANE, Refused, SPACE};

/// Memory for a body.
#[derive(Debug, Default)]
pub(super) struct BodyBuffers<const D: usize> {
    outline: Vec<Vector<2>>,
    boxes: Vec<AxisBox<D>>,
    polygon: Option<Polygon>,
}

impl<const D: usize> BodyBuffers<D> {
    /// The memory that it holds, bytes.
    pub(super) fn bytes(&self) -> usize {
        let polygon = self.polygon.as_ref().map_or(0, |polygon| polygon.vertices().len());
        let outline = (self.outline.capacity() + polygon) * size_of::<Vector<2>>();
        outline + self.boxes.capacity() * size_of::<AxisBox<D>>()
    }

    /// Takes back the memory of what was read.
    pub(super) fn end(&mut self) {
        if let Some(polygon) = self.polygon.take() {
            self.outline = polygon.into_vertices();
        }
    }

    fn union(
        &mut self,
        given: &[message::AxisBox],
        axes: &Axes,
        budget: &Budget<'_>,
    ) -> Result<Body<'_, D>, Refused> {
        budget.step(given.len() as u64)?;
        budget.hold(size_of_val(given))?;
        self.boxes.clear();
        for (index, sides) in given.iter().enumerate() {
            let field = || format!("body.boxes[{index}]");
            self.boxes.push(check::axis_box(field, axes, sides)?);
        }
        Body::from_boxes(&self.boxes).ok_or_else(|| check::no_boxes("body.boxes").into())
    }
}

impl BodyBuffers<2> {
    /// Reads a body in the plane.
    pub(super) fn read(
        &mut self,
        body: &message::Body,
        budget: &Budget<'_>,
    ) -> Result<Body<'_, 2>, Refused> {
        Ok(match body {
            message::Body::Polygon(points) => {
                let field = || "body.polygon".to_owned();
                let checked = check::polygon(field, points, &mut self.outline, budget)?;
                Body::from_polygon(self.polygon.insert(checked))
            }
            message::Body::Box(sides) => {
                Body::from_box(&check::axis_box(|| "body.box".to_owned(), &PLANE, sides)?)
            }
            message::Body::Boxes(boxes) => return self.union(boxes, &PLANE, budget),
            message::Body::Footprint(_) => return Err(check::wrong_body("body.footprint").into()),
        })
    }
}

impl BodyBuffers<3> {
    /// Reads a body in space.
    pub(super) fn read(
        &mut self,
        body: &message::Body,
        budget: &Budget<'_>,
    ) -> Result<Body<'_, 3>, Refused> {
        Ok(match body {
            message::Body::Box(sides) => {
                Body::from_box(&check::axis_box(|| "body.box".to_owned(), &SPACE, sides)?)
            }
            message::Body::Boxes(boxes) => return self.union(boxes, &SPACE, budget),
            message::Body::Polygon(_) => return Err(check::flat("body.polygon".to_owned()).into()),
            message::Body::Footprint(_) => return Err(check::wrong_body("body.footprint").into()),
        })
    }
}

/// The boxes of a union that is narrower by rounding, with these bounds. What is too thin to be
/// narrower stays as it is.
pub(super) fn narrower_boxes<const D: usize>(
    body: &Body<'_, D>,
    bounds: &AxisBox<D>,
) -> Vec<AxisBox<D>> {
    let play = bounds.min() - body.bounds().min();
    let narrower =
        |part: &AxisBox<D>| AxisBox::new(part.min() + play, part.max() - play).unwrap_or(*part);
    body.boxes().iter().map(narrower).collect()
}
