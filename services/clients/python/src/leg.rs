//! Legs as plain objects.

use clearway_client::message::{self, Curve, Vector};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// A piece of a path. Metres; radians counter-clockwise from +x. What a kind of leg does not have is
/// None: a line has `from_`, `to`, `heading` and `turned`, an arc `center`, `radius`, `start_angle`
/// and `sweep`, a turn in place `position`, `from_heading`, `to_heading` and `sweep`, a clothoid `from_`,
/// `to`, `from_heading`, `to_heading`, `start_curvature` and `end_curvature`.
#[pyclass(frozen, get_all, module = "clearway")]
#[derive(Default)]
pub(crate) struct Leg {
    /// `"line"`, `"arc"`, `"turn"` or `"clothoid"`.
    kind: String,
    /// Where a line begins.
    from_: Option<Py<PyTuple>>,
    /// Where it ends.
    to: Option<Py<PyTuple>>,
    /// Heading at its end.
    heading: Option<f64>,
    /// Signed angle turned on the way.
    turned: Option<f64>,
    /// Centre of an arc.
    center: Option<Py<PyTuple>>,
    /// Its radius.
    radius: Option<f64>,
    /// Angle from its centre to the arriving point.
    start_angle: Option<f64>,
    /// Signed angle run through, positive to the left.
    sweep: Option<f64>,
    /// Where a turn is.
    position: Option<Py<PyTuple>>,
    /// Heading before it.
    from_heading: Option<f64>,
    /// Heading after it.
    to_heading: Option<f64>,
    /// Radians turned per metre where a clothoid begins, positive to the left.
    start_curvature: Option<f64>,
    /// The same where it ends.
    end_curvature: Option<f64>,
    /// Arc length.
    length: f64,
    /// Least distance to the walls on it: exact, but on a clothoid certified from below; infinite
    /// without walls.
    clearance: f64,
    /// The junction it leads to or turns in, counted from 0 in travel order.
    junction: Option<u64>,
    /// The paper's rule that chose it.
    rule: Option<String>,
    /// How it was found.
    rung: Option<String>,
    /// Whether the robot drives it backwards.
    reverse: bool,
}

/// Coordinates as a tuple.
pub(crate) fn point<'py>(py: Python<'py>, at: &Vector) -> PyResult<Bound<'py, PyTuple>> {
    PyTuple::new(py, at.as_slice())
}

impl Leg {
    pub(crate) fn new(py: Python<'_>, leg: &message::Leg) -> PyResult<Self> {
        let point = |at: &Vector| Ok::<_, PyErr>(Some(point(py, at)?.unbind()));
        let message::Leg { curve, length, clearance, junction, rule, reverse, rung } = *leg;
        let all = Self {
            kind: curve.kind().to_string(),
            length,
            clearance,
            junction,
            rule: rule.map(|rule| rule.to_string()),
            rung: rung.map(|rung| rung.to_string()),
            reverse,
            ..Self::default()
        };
        Ok(match curve {
            Curve::Line { from, to, heading, turned } => Self {
                from_: point(&from)?,
                to: point(&to)?,
                heading: Some(heading),
                turned: Some(turned),
                ..all
            },
            Curve::Arc { center, radius, start_angle, sweep } => Self {
                center: point(&center)?,
                radius: Some(radius),
                start_angle: Some(start_angle),
                sweep: Some(sweep),
                ..all
            },
            Curve::Turn { position, from_heading, to_heading, sweep } => Self {
                position: point(&position)?,
                from_heading: Some(from_heading),
                to_heading: Some(to_heading),
                sweep: Some(sweep),
                ..all
            },
            Curve::Clothoid { from, to, from_heading, to_heading, curvatures, length: _ } => Self {
                from_: point(&from)?,
                to: point(&to)?,
                from_heading: Some(from_heading),
                to_heading: Some(to_heading),
                start_curvature: Some(curvatures[0]),
                end_curvature: Some(curvatures[1]),
                ..all
            },
        })
    }
}

#[pymethods]
impl Leg {
    fn __repr__(&self) -> String {
        format!("<Leg {} of {:.3} m>", self.kind, self.length)
    }
}
