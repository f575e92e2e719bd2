//! What is checked before anything is planned, and the conversion from message types to
//! planning's types, which can't be wrong.

use std::mem;

use planning::budget::Budget;
use planning::geometry::number::Number;
use planning::geometry::polygon::{Polygon, PolygonError};
use planning::geometry::{AxisBox, Direction, Sign, Vector};
use planning::trajectory::{Limits, Sampling};
use schemas::message::{self, Corners, ErrorCode, Refusal, Task};

use crate::refuse::{self, Axes, Refused};
use crate::scene::Scene;

/// The greatest magnitude of a coordinate, metres: its square, and a sum of such, is finite.
const MOST_COORDINATE: f64 = 1e150;

/// The greatest magnitude of a robot's coordinates, in its extents: they round to some 1e-4 of
/// one there.
const MOST_EXTENTS: f64 = 1e12;

/// Fields that do not go together.
pub(crate) fn fields(scene: Scene<'_>) -> Result<(), Refusal> {
    let drive = scene.task == Task::Drive;
    let limits = &scene.limits;
    let stray = [
        ("start_turn", scene.start_turn.is_some() && !drive),
        ("reverse", scene.reverse.is_some() && !drive),
        ("turn_in_place", scene.turn_in_place.is_some() && !drive),
        ("min_turn_radius", scene.min_turn_radius.is_some() && !drive),
        ("turn_cost", scene.turn_cost.is_some() && !drive),
        ("stop_cost", scene.stop_cost.is_some() && !drive),
        ("limits.yaw_rate", limits.yaw_rate.is_some() && !drive),
        ("limits.yaw_acceleration", limits.yaw_acceleration.is_some() && !drive),
        ("limits.lateral_acceleration", limits.lateral_acceleration.is_some() && !drive),
        ("limits.yaw_jerk", limits.yaw_jerk.is_some() && !drive),
        ("stop_at_joints", scene.stop_at_joints.is_some() && !drive),
        ("frames", scene.frames.is_some() && drive),
        ("path", scene.path.is_some() && drive),
        ("exit", !scene.exit.is_empty() && drive),
    ];
    if let Some((field, _)) = stray.into_iter().find(|(_, stray)| *stray) {
        return Err(stray_field(field, scene.task));
    }
    corners(scene)?;
    if !drive {
        way(scene)?;
    }
    let free_space = &scene.free_space;
    if free_space.channels.is_none() {
        if free_space.solids.as_ref().is_none_or(Vec::is_empty) {
            let message = "free_space has neither channels nor solids";
            return Err(Refusal::invalid("free_space", message));
        }
        if free_space.in_order {
            let message = "free_space.in_order is set, but there are no channels";
            return Err(Refusal::invalid("free_space.in_order", message));
        }
    }
    if let Some(deadline) = scene.deadline
        && !(deadline.is_finite() && deadline > 0.0)
    {
        let message =
            format!("deadline is {} s; it must be finite and greater than 0", Number(deadline));
        let refusal = Refusal::invalid("deadline", message);
        return Err(Refusal { has: Some(deadline), least: Some(0.0), ..refusal });
    }
    Ok(())
}

/// How corners can be passed.
fn corners(scene: Scene<'_>) -> Result<(), Refusal> {
    match (scene.task, scene.corners) {
        (Task::Drive, Some(Corners::Sharp)) => {
            let message = "corners: a robot passes corners along arcs; \"sharp\" is for assembly \
                           tasks";
            Err(Refusal::invalid("corners", message))
        }
        _ => Ok(()),
    }
}

/// Which way an assembly task takes, and what is told of it, is asked for channels in travel order.
fn way(scene: Scene<'_>) -> Result<(), Refusal> {
    let channels = scene.free_space.channels.as_deref().unwrap_or_default();
    // One channel has but one order.
    if channels.len() == 1 || (scene.free_space.in_order && !channels.is_empty()) {
        return Ok(());
    }
    let given = [("path", scene.path.is_some()), ("report", scene.report.is_some())];
    let Some((field, _)) = given.into_iter().find(|(_, given)| *given) else { return Ok(()) };
    let message = format!(
        "{field}: in assembly tasks this is for channels in travel order; give \
         free_space.channels with in_order"
    );
    Err(Refusal::invalid(field, message))
}

/// A field of another task.
pub(crate) fn stray_field(field: impl Into<String>, task: Task) -> Refusal {
    let field = field.into();
    let message = match task {
        Task::Drive => format!("{field} is not a field of task \"drive\", but of assembly tasks"),
        _ => format!("{field} is not a field of assembly tasks, but of task \"drive\""),
    };
    Refusal::invalid(field, message)
}

/// A number that must be at least 0; `unit` is its unit.
pub(crate) fn not_negative(field: &str, value: f64, unit: &str) -> Result<(), Refusal> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    let message = format!("{field} is {} {unit}; it must be finite and at least 0", Number(value));
    let refusal = Refusal::invalid(field, message);
    Err(Refusal { has: Some(value), needs: Some(0.0), ..refusal })
}

/// A field that has no effect on channels in travel order.
pub(crate) fn only_in_any_order(field: impl Into<String>) -> Refusal {
    let field = field.into();
    let message = format!(
        "{field} is only for free space in any order: solids, or channels without in_order and \
         without solids"
    );
    Refusal::invalid(field, message)
}

/// A body that does not go with the task.
pub(crate) fn wrong_body(field: &str) -> Refusal {
    let message =
        format!("{field}: in an assembly task the body is a polygon, a box or a union of boxes");
    Refusal::invalid(field, message)
}

/// A polygon in space.
pub(crate) fn flat(field: String) -> Refusal {
    let message = format!("{field}: polygons are for two dimensions; use boxes in three");
    Refusal::invalid(field, message)
}

/// A union without any box.
pub(crate) fn no_boxes(field: impl Into<String>) -> Refusal {
    let field = field.into();
    let message = format!("{field} has 0 boxes; at least 1 is needed");
    let refusal = Refusal::invalid(field, message);
    Refusal { has: Some(0.0), needs: Some(1.0), ..refusal }
}

/// Not one gap for each axis.
pub(crate) fn gaps_per_axis(field: String, has: usize, needs: usize) -> Refusal {
    let message = format!("{field} has {has} numbers; give one, or {needs}, one per axis");
    let refusal = Refusal::invalid(field, message);
    Refusal { has: Some(has as f64), needs: Some(needs as f64), ..refusal }
}

/// A simple polygon, in the memory of `vertices`; [`Polygon::into_vertices`] gives it back. Points
/// that repeat the one before, or close the outline, are left out.
pub(crate) fn polygon(
    field: impl Fn() -> String,
    points: &[message::Vector],
    vertices: &mut Vec<Vector<2>>,
    budget: &Budget<'_>,
) -> Result<Polygon, Refused> {
    budget.step(points.len() as u64)?;
    let mut vertices = mem::take(vertices);
    vertices.clear();
    vertices.extend(points.iter().map(vector::<2>));
    if vertices.iter().any(|vertex| vertex.amax() > MOST_COORDINATE) {
        for (index, vertex) in vertices.iter().enumerate() {
            in_range(|| format!("{}[{index}]", field()), vertex.as_slice())?;
        }
    }
    let given = vertices.len();
    vertices.dedup();
    if vertices.len() > 1 && vertices.first() == vertices.last() {
        vertices.pop();
    }
    let repeats = given - vertices.len();
    let made = Polygon::new(vertices, budget).or_else(|error| match error {
        PolygonError::Spent(_) => Err(error),
        // What is wrong otherwise is said of the points as they are given.
        _ if repeats > 0 => Polygon::new(points.iter().map(vector::<2>).collect(), budget),
        _ => Err(error),
    });
    made.map_err(|error| match error {
        PolygonError::Spent(spent) => spent.into(),
        error => {
            let field = field();
            let message = format!("{field}: {error}");
            Refusal::invalid(field, message).into()
        }
    })
}

/// Refuses a cavity that none of its channels leads out of along the exit.
pub(crate) fn mouth<const D: usize>(
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

/// Refuses numbers that are not finite.
pub(crate) fn finite(field: &str, values: &[f64]) -> Result<(), Refusal> {
    match values.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => Err(Refusal::invalid(field, format!("{field}: {value} is not finite"))),
    }
}

/// Refuses finite coordinates, or sizes, that are too large to be reckoned with.
pub(crate) fn in_range(field: impl FnOnce() -> String, values: &[f64]) -> Result<(), Refusal> {
    let (least, most) = (-MOST_COORDINATE, MOST_COORDINATE);
    let is_too_large = |value: &&f64| value.is_finite() && value.abs() > most;
    let Some(value) = values.iter().find(is_too_large) else { return Ok(()) };
    let field = field();
    let message = format!(
        "{field}: {value:e} m is out of range; it must be between {least:e} m and {most:e} m"
    );
    let refusal = Refusal::invalid(field, message);
    Err(Refusal { has: Some(*value), least: Some(least), most: Some(most), ..refusal })
}

/// Refuses a place so far out that rounding is no longer small beside the body, whose greatest
/// extent is `size`.
pub(crate) fn not_far_out(field: &str, place: &[f64], size: f64) -> Result<(), Refusal> {
    let most = size * MOST_EXTENTS;
    let Some(value) = place.iter().find(|value| value.abs() > most) else { return Ok(()) };
    let message = format!(
        "{field}: {} m is too far out to tell where a body of {} m touches a wall; it must be \
         between {} m and {} m",
        Number(*value),
        Number(size),
        Number(-most),
        Number(most)
    );
    let refusal = Refusal::invalid(field, message);
    Err(Refusal { has: Some(*value), least: Some(-most), most: Some(most), ..refusal })
}

/// A point of the scene's dimension. No coordinate is a negative zero, so that what is equal
/// has equal bits: what is kept from one request to the next is compared.
pub(crate) fn vector<const D: usize>(point: &message::Vector) -> Vector<D> {
    Vector::from_iterator(point.padded().into_iter().take(D).map(|value| value + 0.0))
}

/// A box with an interior.
pub(crate) fn axis_box<const D: usize>(
    field: impl FnOnce() -> String,
    axes: &Axes,
    sides: &message::AxisBox,
) -> Result<AxisBox<D>, Refusal> {
    let (min, max) = (vector::<D>(&sides.min), vector::<D>(&sides.max));
    match AxisBox::new(min, max) {
        Err(error) => Err(refuse::axis_box(field(), axes, error)),
        Ok(sides) => in_range(field, &[min.min(), max.max()]).map(|()| sides),
    }
}

/// The direction as planning counts coordinates.
pub(crate) fn direction<const D: usize>(
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
        None => {
            Err(Refusal::invalid("exit", "exit: in two dimensions the axes are x and z, not y"))
        }
    }
}

/// The limits, with the documented defaults where none are given.
pub(crate) fn limits(limits: &message::Limits) -> Result<Limits, Refusal> {
    let default = Limits::default();
    Limits::new(
        limits.speed.unwrap_or(default.speed()),
        limits.acceleration.unwrap_or(default.acceleration()),
        limits.yaw_rate.unwrap_or(default.yaw_rate()),
        limits.yaw_acceleration.unwrap_or(default.yaw_acceleration()),
        limits.lateral_acceleration.unwrap_or(default.lateral_acceleration()),
    )
    .and_then(|made| made.with_jerk(limits.jerk, limits.yaw_jerk))
    .map_err(refuse::limit)
}

/// The sampling, every 0.02 s where none is given.
pub(crate) fn sampling(sampling: Option<message::Sampling>) -> Result<Sampling, Refusal> {
    match sampling.unwrap_or(message::Sampling::Period(0.02)) {
        message::Sampling::Period(seconds) => Sampling::period(seconds),
        message::Sampling::Spacing(metres) => Sampling::spacing(metres),
        message::Sampling::Count(count) => Sampling::count(count),
    }
    .map_err(refuse::sampling)
}

/// Refuses a gap that is not positive.
pub(crate) fn gap(field: &str, gap: f64) -> Result<(), Refusal> {
    if gap > 0.0 && gap.is_finite() {
        return Ok(());
    }
    let message =
        format!("{field}: a gap of {} m; it must be finite and greater than 0", Number(gap));
    let refusal = Refusal {
        field: Some(field.to_owned()),
        ..Refusal::new(ErrorCode::GapOutOfRange, message)
    };
    Err(Refusal { has: Some(gap), least: Some(0.0), ..refusal })
}
