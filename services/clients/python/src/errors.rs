//! Errors as the exceptions of `clearway._errors`.

use clearway_client::message::{Axis, ErrorCode, Refusal};
use clearway_client::{CallError, ConnectError, Error, Refused};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The codes of refusals.
pub(crate) fn codes() -> Vec<String> {
    ErrorCode::ALL.iter().map(ToString::to_string).collect()
}

/// An exception of this class.
pub(crate) fn exception(py: Python<'_>, class: &str, message: &str) -> PyErr {
    let made = py.import("clearway._errors").and_then(|errors| {
        let class = errors.getattr(class)?;
        class.call1((message,))
    });
    made.map_or_else(|error| error, PyErr::from_value)
}

pub(crate) fn error(py: Python<'_>, error: Error) -> PyErr {
    let class = match &error {
        Error::Refused(refused) => {
            return match self::refused(py, refused) {
                Ok(exception) => PyErr::from_value(exception),
                Err(error) => error,
            };
        }
        Error::Connect(ConnectError::NoPlanner { .. }) => "NoPlannerError",
        Error::Connect(_) => "ConnectError",
        Error::Call(CallError::TimedOut { .. }) => "PlanTimeoutError",
        Error::Call(CallError::PlannerLost) => "PlannerLostError",
        Error::Call(CallError::Forked) => "ForkedError",
        Error::Call(_) => "CallError",
    };
    exception(py, class, &error.to_string())
}

/// A refusal as what stands in the place of a reply; other errors remain errors.
pub(crate) fn as_answer(py: Python<'_>, error: PyErr) -> PyResult<Bound<'_, PyAny>> {
    let refused = py.import("clearway._errors")?.getattr("RefusedError")?;
    if error.is_instance(py, &refused) {
        Ok(error.into_value(py).into_bound(py).into_any())
    } else {
        Err(error)
    }
}

/// A refusal as an exception.
pub(crate) fn refused<'py>(py: Python<'py>, refused: &Refused) -> PyResult<Bound<'py, PyAny>> {
    let Refusal { code, message, field, junction, axis, needs, has, least, most, heading, setting } =
        refused.refusal();
    let numbers = PyDict::new(py);
    numbers.set_item("field", field)?;
    numbers.set_item("junction", junction)?;
    let axis = axis.and_then(|axis| Axis::ALL.get(axis as usize)).map(ToString::to_string);
    numbers.set_item("axis", axis)?;
    for (name, number) in
        [("needs", needs), ("has", has), ("least", least), ("most", most), ("heading", heading)]
    {
        numbers.set_item(name, number)?;
    }
    numbers.set_item("setting", setting)?;
    let made = py.import("clearway._errors")?.getattr("refused")?;
    made.call((code.to_string(), message), Some(&numbers))
}
