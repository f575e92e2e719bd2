//! Replies as Python sees them.

use std::sync::Arc;

use clearway_client::message;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyList, PyTuple};

use crate::block::Block;
use crate::errors;
use crate::leg::{Leg, point};

/// A reply: an answer for each clearance asked for.
#[pyclass(frozen, module = "clearway")]
pub(crate) struct Reply {
    reply: Arc<clearway_client::Reply>,
    answers: PyOnceLock<Py<PyTuple>>,
}

/// A planned and sampled motion. Metres, radians and seconds.
#[pyclass(frozen, module = "clearway")]
pub(crate) struct Trajectory {
    reply: Arc<clearway_client::Reply>,
    index: usize,
    blocks: PyOnceLock<Py<PyTuple>>,
    samples: PyOnceLock<Py<PyAny>>,
}

/// How close a body comes to the walls, and where.
#[pyclass(frozen, get_all, module = "clearway")]
pub(crate) struct Clearance {
    /// Exact least distance over the whole motion, metres; infinite without walls.
    value: f64,
    /// Arc length where it is met, metres.
    at: f64,
    /// The wall point that is that close, metres.
    wall: Py<PyTuple>,
}

/// A limit that a motion does not obey.
#[pyclass(frozen, get_all, module = "clearway")]
pub(crate) struct Exceeds {
    /// The limit: `"yaw_acceleration"`, where the yaw rate jumps because the curvature does.
    limit: String,
    /// At how many joints of legs.
    joints: u64,
    /// The greatest jump there, radians per second.
    jump: f64,
}

impl Reply {
    pub(crate) fn new(reply: clearway_client::Reply) -> Self {
        Self { reply: Arc::new(reply), answers: PyOnceLock::new() }
    }
}

#[pymethods]
impl Reply {
    /// The scene's id.
    #[getter]
    fn id(&self) -> Option<u64> {
        self.reply.id()
    }

    /// Whether all samples are where the planner wrote them, in shared memory. A client with many
    /// replies alive copies the later ones, so that the planner has room to write.
    #[getter]
    fn is_shared(&self) -> bool {
        self.reply.is_shared()
    }

    /// An answer for each clearance asked for: a `Trajectory`, or the `RefusedError` that says why
    /// there is none.
    #[getter]
    fn answers(&self, py: Python<'_>) -> PyResult<Py<PyTuple>> {
        let answers = self.answers.get_or_try_init(py, || {
            let answers = self.reply.answers().iter().enumerate();
            let answers: Vec<_> = answers
                .map(|(index, answer)| match answer {
                    Ok(_) => Ok(Bound::new(py, self.trajectory(index))?.into_any()),
                    Err(refused) => errors::refused(py, refused),
                })
                .collect::<PyResult<_>>()?;
            Ok::<_, PyErr>(PyTuple::new(py, answers)?.unbind())
        });
        Ok(answers?.clone_ref(py))
    }

    /// The trajectories, one for each clearance asked for. Raises the first `RefusedError` if an
    /// answer is one; `answers` has the others.
    #[getter]
    fn trajectories(&self, py: Python<'_>) -> PyResult<Py<PyTuple>> {
        self.reply.trajectories().map_err(|refused| errors::error(py, refused.into()))?;
        self.answers(py)
    }

    /// The reply as JSON, as `plan --format json` prints it.
    fn to_json(&self, py: Python<'_>) -> String {
        py.detach(|| self.reply.to_json())
    }

    fn __repr__(&self) -> String {
        format!("<Reply with {} answers>", self.reply.answers().len())
    }
}

impl Reply {
    fn trajectory(&self, index: usize) -> Trajectory {
        let (blocks, samples) = (PyOnceLock::new(), PyOnceLock::new());
        Trajectory { reply: Arc::clone(&self.reply), index, blocks, samples }
    }
}

impl Trajectory {
    fn said(&self) -> &clearway_client::Trajectory {
        self.reply.answers()[self.index].as_ref().expect("only these are made")
    }
}

#[pymethods]
impl Trajectory {
    /// Arc length, metres.
    #[getter]
    fn length(&self) -> f64 {
        self.said().length()
    }

    /// Seconds.
    #[getter]
    fn duration(&self) -> f64 {
        self.said().duration()
    }

    /// How close the body comes to the walls, and where.
    #[getter]
    fn clearance(&self, py: Python<'_>) -> PyResult<Clearance> {
        let message::Clearance { value, at, wall } = *self.said().clearance();
        Ok(Clearance { value, at, wall: point(py, &wall)?.unbind() })
    }

    /// Distance that the body keeps from all walls but those that it is closer to at the start or
    /// the goal, metres; None where it is not reported.
    #[getter]
    fn free_clearance(&self) -> Option<f64> {
        self.said().free_clearance()
    }

    /// Length of the shortest curve with the same free clearance, metres: no drive is shorter. None
    /// where it is not reported.
    #[getter]
    fn bound(&self) -> Option<f64> {
        self.said().bound()
    }

    /// Whether the search ended by itself and not because its budget was spent.
    #[getter]
    fn complete(&self) -> bool {
        self.said().is_complete()
    }

    /// The limit that the motion does not obey: an `Exceeds`. None where there is no such limit, and
    /// where the request neither has `corners` nor asks for a full report.
    #[getter]
    fn exceeds(&self) -> Option<Exceeds> {
        let message::Exceeds { limit, joints, jump } = self.said().exceeds()?;
        Some(Exceeds { limit: limit.to_string(), joints, jump })
    }

    /// At how many joints of legs the body stops because no smooth corner fits, with `corners:
    /// "smooth"`; otherwise None.
    #[getter]
    fn stops(&self) -> Option<u64> {
        self.said().stops()
    }

    /// The way out that was taken, if the request gave several.
    #[getter]
    fn exit(&self) -> Option<String> {
        self.said().exit().map(|exit| exit.to_string())
    }

    /// How many coordinates points have, 2 or 3. Those of samples are padded with zeros.
    #[getter]
    fn dimension(&self) -> usize {
        self.said().dimension()
    }

    /// The gaps used at every junction in travel order, metres: a number for robots, one per axis
    /// for parts.
    #[getter]
    fn gap<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        match self.said().gaps() {
            (gaps, 0 | 1) => PyTuple::new(py, gaps),
            (gaps, each) => {
                let gaps = gaps.chunks(each).map(|gap| PyTuple::new(py, gap));
                PyTuple::new(py, gaps.collect::<PyResult<Vec<_>>>()?)
            }
        }
    }

    /// Indices of the channels travelled, in travel order.
    #[getter]
    fn route<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.said().route())
    }

    /// The channels, if the planner made them: the corners of each, metres.
    #[getter]
    fn channels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let channels = self.said().channels().iter();
        let channels = channels
            .map(|channel| (point(py, &channel.min)?, point(py, &channel.max)?).into_pyobject(py));
        PyTuple::new(py, channels.collect::<PyResult<Vec<_>>>()?)
    }

    /// The pieces of the path.
    #[getter]
    fn legs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let legs = self.said().legs().iter().map(|leg| Bound::new(py, Leg::new(py, leg)?));
        PyList::new(py, legs.collect::<PyResult<Vec<_>>>()?)
    }

    /// The samples, part by part: read-only numpy arrays with the fields `t` (s), `position` (m),
    /// `heading` (rad), `velocity` (m/s) and `yaw_rate` (rad/s). They show shared memory, which is
    /// kept for as long as an array of it lives, even when the client is closed.
    #[getter]
    fn blocks(&self, py: Python<'_>) -> PyResult<Py<PyTuple>> {
        let blocks = self.blocks.get_or_try_init(py, || {
            let array = py.import("clearway._arrays")?.getattr("array")?;
            let blocks = self.said().blocks().iter();
            let blocks = blocks.map(|block| array.call1((Block { block: block.clone() },)));
            Ok::<_, PyErr>(PyTuple::new(py, blocks.collect::<PyResult<Vec<_>>>()?)?.unbind())
        });
        Ok(blocks?.clone_ref(py))
    }

    /// All samples as one read-only array: the only block without a copy, several with one.
    #[getter]
    fn samples(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let samples = self.samples.get_or_try_init(py, || {
            let join = py.import("clearway._arrays")?.getattr("join")?;
            Ok::<_, PyErr>(join.call1((self.blocks(py)?,))?.unbind())
        });
        Ok(samples?.clone_ref(py))
    }

    fn __repr__(&self) -> String {
        let said = self.said();
        let (length, duration) = (said.length(), said.duration());
        let clearance = said.clearance().value;
        format!("<Trajectory of {length:.3} m in {duration:.3} s, {clearance:.3} m from the walls>")
    }
}

#[pymethods]
impl Exceeds {
    fn __repr__(&self) -> String {
        let Self { limit, joints, jump } = self;
        format!("<Exceeds {limit} at {joints} joints, by {jump:.3} rad/s>")
    }
}

#[pymethods]
impl Clearance {
    fn __repr__(&self) -> String {
        format!("<Clearance of {:.3} m>", self.value)
    }
}
