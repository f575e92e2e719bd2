//! The number of coordinates of a scene's points.

use crate::message::{AxisBox, Body, FreeSpace, Refusal, SceneRequest, Solid, Vector};

/// How many coordinates the points of a scene in this free space have: 2 or 3, the same for all.
pub fn dimension(scene: &SceneRequest, free_space: &FreeSpace) -> Result<u32, Refusal> {
    let mut points = Points { dimension: 0 };
    match &scene.body {
        Body::Polygon(vertices) => points.list("body.polygon", vertices)?,
        Body::Box(sides) => points.axis_box("body.box", sides)?,
        Body::Footprint(_) => points.dimension = 2,
        Body::Boxes(boxes) => points.boxes("body.boxes", boxes)?,
    }
    let FreeSpace { channels, solids, bounds, .. } = free_space;
    for (index, channel) in channels.iter().flatten().enumerate() {
        points.axis_box(format_args!("free_space.channels[{index}]"), channel)?;
    }
    for (index, solid) in solids.iter().flatten().enumerate() {
        match solid {
            Solid::Polygon(vertices) => {
                points.list(format_args!("free_space.solids[{index}].polygon"), vertices)?;
            }
            Solid::Box(sides) => {
                points.axis_box(format_args!("free_space.solids[{index}].box"), sides)?;
            }
            Solid::Boxes(boxes) => {
                points.boxes(format_args!("free_space.solids[{index}].boxes"), boxes)?;
            }
        }
    }
    if let Some(bounds) = bounds {
        points.axis_box("free_space.bounds", bounds)?;
    }
    for (field, position) in [
        ("start.position", scene.start.map(|start| start.position)),
        ("goal.position", scene.goal.map(|goal| goal.position)),
        ("frames.fixed.position", scene.frames.map(|frames| frames.fixed.position)),
        (
            "frames.fixed_at_end.position",
            scene.frames.and_then(|frames| frames.fixed_at_end).map(|pose| pose.position),
        ),
        (
            "frames.moving.position",
            scene.frames.and_then(|frames| frames.moving).map(|pose| pose.position),
        ),
    ] {
        if let Some(position) = position {
            points.point(field, &position)?;
        }
    }
    // A scene without points is refused later, for what it lacks.
    Ok(points.dimension.max(2) as u32)
}

struct Points {
    dimension: usize,
}

impl Points {
    fn point(&mut self, field: impl std::fmt::Display, point: &Vector) -> Result<(), Refusal> {
        if self.dimension == 0 {
            self.dimension = point.dimension().max(2);
        }
        if point.dimension() == self.dimension {
            Ok(())
        } else {
            Err(wrong_dimension(field, self.dimension, point.dimension()))
        }
    }

    fn list(&mut self, field: impl std::fmt::Display, points: &[Vector]) -> Result<(), Refusal> {
        for (index, point) in points.iter().enumerate() {
            self.point(format_args!("{field}[{index}]"), point)?;
        }
        Ok(())
    }

    fn axis_box(&mut self, field: impl std::fmt::Display, sides: &AxisBox) -> Result<(), Refusal> {
        self.point(format_args!("{field}.min"), &sides.min)?;
        self.point(format_args!("{field}.max"), &sides.max)
    }

    fn boxes(&mut self, field: impl std::fmt::Display, boxes: &[AxisBox]) -> Result<(), Refusal> {
        for (index, sides) in boxes.iter().enumerate() {
            self.axis_box(format_args!("{field}[{index}]"), sides)?;
        }
        Ok(())
    }
}

fn wrong_dimension(field: impl std::fmt::Display, needs: usize, has: usize) -> Refusal {
    Refusal::invalid(
        field.to_string(),
        format!("{field} has {has} coordinates, but this scene's points have {needs}"),
    )
}
