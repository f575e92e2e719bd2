//! What can be said of a request before anything is planned, and the steps from
//! message types to planning's types, which can't be wrong.

use std::mem;

use planning::budget::Budget;
use planning::geometry::polygon::{Polygon, PolygonError};
use planning::geometry::{AxisBox, Direction, Sign, Vector};
use planning::trajectory::{Limits, Sampling};
use schemas::message::{self, Refusal, SceneRequest, Solid, Task};

use super::refuse::{self, Axes};

/// Fields that do not go together.
pub(super) fn fields(scene: &SceneRequest) -> Result<(), Refusal> {
    let drive = scene.task == Task::Drive;
    let stray = [
        ("start", scene.start.is_some() && !drive),
        ("goal", scene.goal.is_some() && !drive),
        ("start_turn", scene.start_turn.is_some() && !drive),
        ("exit", !scene.exit.is_empty() && drive),
    ];
    if let Some((field, _)) = stray.into_iter().find(|(_, stray)| *stray) {
        let goes = if drive { "assembly tasks" } else { "task \"drive\"" };
        return Err(Refusal::invalid(field, format!("{field} goes with {goes} only")));
    }
    let free_space = &scene.free_space;
    if free_space.channels.is_none() {
        if free_space.solids.as_ref().is_none_or(Vec::is_empty) {
            let message = "free_space has neither channels nor solids";
            return Err(Refusal::invalid("free_space", message));
        }
        if free_space.in_order {
            let message = "free_space.in_order goes with channels, and there are none";
            return Err(Refusal::invalid("free_space.in_order", message));
        }
        if drive && free_space.bounds.is_none() {
            let message = "free_space.bounds is missing: solids alone do not bound a floor";
            return Err(Refusal::invalid("free_space.bounds", message));
        }
    }
    if let Some(deadline) = scene.deadline
        && !(deadline.is_finite() && deadline > 0.0)
    {
        let message =
            format!("deadline must be a number of seconds greater than 0, not {deadline}");
        return Err(Refusal::invalid("deadline", message));
    }
    Ok(())
}

/// A body that does not go with the task.
pub(super) fn wrong_body(field: &str) -> Refusal {
    Refusal::invalid(field, format!("{field}: the body of an assembly task is a polygon or a box"))
}

/// A polygon in space.
pub(super) fn flat(field: String) -> Refusal {
    let message = format!("{field}: polygons are for two dimensions; in three there are boxes");
    Refusal::invalid(field, message)
}

/// Not one gap for each axis.
pub(super) fn gaps_per_axis(field: String, has: usize, needs: usize) -> Refusal {
    let message = format!("{field} has {has} numbers for {needs} axes");
    let refusal = Refusal::invalid(field, message);
    Refusal { has: Some(has as f64), needs: Some(needs as f64), ..refusal }
}

/// A simple polygon, in the memory of `vertices`; [`Polygon::into_vertices`] gives it back.
pub(super) fn polygon(
    field: impl FnOnce() -> String,
    points: &[message::Vector],
    vertices: &mut Vec<Vector<2>>,
    budget: &Budget<'_>,
) -> Result<Polygon, Refusal> {
    let mut vertices = mem::take(vertices);
    vertices.clear();
    vertices.extend(points.iter().map(vector::<2>));
    Polygon::new(vertices, budget).map_err(|error| match error {
        PolygonError::Spent(error) => refuse::spent(error),
        error => {
            let field = field();
            let message = format!("{field}: {error}");
            Refusal::invalid(field, message)
        }
    })
}

/// Adds the scene's solids to `into`: boxes, checked, and polygons, which are not checked yet
/// and whose field can be asked for.
pub(super) fn push_solids<const D: usize, T>(
    scene: &SceneRequest,
    axes: &Axes,
    into: &mut T,
    push_box: impl Fn(&mut T, &AxisBox<D>) -> Result<(), Refusal>,
    mut push_polygon: impl FnMut(&mut T, &dyn Fn() -> String, &[message::Vector]) -> Result<(), Refusal>,
) -> Result<(), Refusal> {
    for (index, solid) in scene.free_space.solids.iter().flatten().enumerate() {
        match solid {
            Solid::Box(sides) => {
                let field = || format!("free_space.solids[{index}].box");
                push_box(into, &axis_box(field, axes, sides)?)?;
            }
            Solid::Polygon(points) => {
                let field = || format!("free_space.solids[{index}].polygon");
                push_polygon(into, &field, points)?;
            }
        }
    }
    Ok(())
}

/// Whether the walls are the request's solids, not the channels' complement.
pub(super) fn has_solids(scene: &SceneRequest) -> bool {
    scene.free_space.solids.as_ref().is_some_and(|solids| !solids.is_empty())
}

/// Refuses a cavity that none of its channels leads out of along the exit.
pub(super) fn mouth<const D: usize>(
    axes: &Axes,
    channels: &[AxisBox<D>],
    cavity: &AxisBox<D>,
    exit: Direction,
) -> Result<(), Refusal> {
    let reach =
        |sides: &AxisBox<D>| exit.coordinate(&sides.min()).max(exit.coordinate(&sides.max()));
    let has = channels.iter().map(reach).fold(f64::NEG_INFINITY, f64::max);
    let needs = reach(cavity);
    if channels.is_empty() || has >= needs {
        return Ok(());
    }
    Err(refuse::no_mouth(axes, exit, needs, has))
}

/// Refuses numbers that are none.
pub(super) fn finite(field: &str, values: &[f64]) -> Result<(), Refusal> {
    match values.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => {
            Err(Refusal::invalid(field, format!("{field}: {value} is not a finite number")))
        }
    }
}

/// A point of the scene's dimension. No coordinate is a negative zero, so that what is equal
/// has equal bits: what is kept from one request to the next is compared.
pub(super) fn vector<const D: usize>(point: &message::Vector) -> Vector<D> {
    Vector::from_iterator(point.padded().into_iter().take(D).map(|value| value + 0.0))
}

/// A box with an interior.
pub(super) fn axis_box<const D: usize>(
    field: impl FnOnce() -> String,
    axes: &Axes,
    sides: &message::AxisBox,
) -> Result<AxisBox<D>, Refusal> {
    AxisBox::new(vector(&sides.min), vector(&sides.max))
        .map_err(|error| refuse::axis_box(field(), axes, error))
}

/// The direction as planning counts coordinates.
pub(super) fn direction<const D: usize>(
    axes: &Axes,
    direction: message::Direction,
) -> Result<Direction, Refusal> {
    use message::Direction::{MinusX, MinusY, MinusZ, PlusX, PlusY, PlusZ};
    let (axis, sign) = match direction {
        PlusX => (0, Sign::Positive),
        MinusX => (0, Sign::Negative),
        PlusY => (1, Sign::Positive),
        MinusY => (1, Sign::Negative),
        PlusZ => (2, Sign::Positive),
        MinusZ => (2, Sign::Negative),
    };
    match axes[..D].iter().position(|candidate| *candidate == axis) {
        Some(axis) => Ok(Direction { axis, sign }),
        None => Err(Refusal::invalid("exit", "exit: scenes in two dimensions have axes x and z")),
    }
}

/// The limits, with the documented defaults where none are given.
pub(super) fn limits(limits: &message::Limits) -> Result<Limits, Refusal> {
    let default = Limits::default();
    Limits::new(
        limits.speed.unwrap_or(default.speed()),
        limits.acceleration.unwrap_or(default.acceleration()),
        limits.yaw_rate.unwrap_or(default.yaw_rate()),
        limits.yaw_acceleration.unwrap_or(default.yaw_acceleration()),
        limits.lateral_acceleration.unwrap_or(default.lateral_acceleration()),
    )
    .map_err(refuse::limit)
}

/// The sampling, every 0.02 s where none is given.
pub(super) fn sampling(sampling: Option<message::Sampling>) -> Result<Sampling, Refusal> {
    match sampling.unwrap_or(message::Sampling::Period(0.02)) {
        message::Sampling::Period(seconds) => Sampling::period(seconds),
        message::Sampling::Spacing(metres) => Sampling::spacing(metres),
        message::Sampling::Count(count) => Sampling::count(count),
    }
    .map_err(refuse::sampling)
}
