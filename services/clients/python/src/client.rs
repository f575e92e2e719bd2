//! Clients and open requests as Python sees them.

use std::os::fd::RawFd;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use clearway_client::{CallError, ClientOptions, Domain, Error, Wait};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::errors;
use crate::reply::Reply;
use crate::scene::prepared;

/// For waits without a limit, seconds.
const EVER: f64 = 1e9;

/// The longest wait between two looks for signals.
const LOOK: Duration = Duration::from_millis(100);

#[pyclass(subclass, frozen, module = "clearway._clearway")]
pub(crate) struct Client {
    /// None once it is closed.
    client: Mutex<Option<clearway_client::Client>>,
}

/// A request being answered. Dropping it cancels the request.
#[pyclass(frozen, module = "clearway")]
pub(crate) struct Pending {
    /// None once it is done.
    pending: Mutex<Option<clearway_client::Pending>>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn seconds(what: &str, time: Option<f64>) -> PyResult<Duration> {
    let time = time.unwrap_or(EVER);
    // A NaN is not less than anything.
    Duration::try_from_secs_f64(if time > EVER { EVER } else { time })
        .map_err(|_| PyValueError::new_err(format!("{what} is {time} s, must be at least 0")))
}

/// Waits without the interpreter, and lets it see signals.
fn wait(
    py: Python<'_>,
    pending: &mut clearway_client::Pending,
    limit: Duration,
) -> PyResult<Reply> {
    let begin = Instant::now();
    let until = begin + limit;
    loop {
        let left = until.saturating_duration_since(Instant::now());
        match py.detach(|| pending.wait(left.min(LOOK))) {
            Ok(reply) => return Ok(Reply::new(reply)),
            Err(Error::Call(CallError::TimedOut { .. })) if left > LOOK => py.check_signals()?,
            Err(Error::Call(CallError::TimedOut { .. })) => {
                let error = CallError::TimedOut { waited: begin.elapsed(), limit };
                return Err(errors::error(py, error.into()));
            }
            Err(error) => return Err(errors::error(py, error)),
        }
    }
}

impl Client {
    fn open(&self, py: Python<'_>) -> PyResult<clearway_client::Client> {
        let client = lock(&self.client).clone();
        client.ok_or_else(|| errors::exception(py, "ClearwayError", "the client is closed"))
    }

    fn begin(&self, scene: &Bound<'_, PyAny>) -> PyResult<clearway_client::Pending> {
        let py = scene.py();
        let (client, scene) = (self.open(py)?, prepared(scene)?);
        py.detach(|| client.start(&scene)).map_err(|error| errors::error(py, error))
    }
}

#[pymethods]
impl Client {
    #[new]
    #[pyo3(signature = (domain = None, *, wait = "hybrid", connect_timeout = 0.0))]
    fn new(
        py: Python<'_>,
        domain: Option<&str>,
        wait: &str,
        connect_timeout: Option<f64>,
    ) -> PyResult<Self> {
        let domain = domain.map_or_else(|| Ok(Domain::default()), Domain::new);
        let domain = domain.map_err(|error| PyValueError::new_err(error.to_string()))?;
        let wait = match wait {
            "hybrid" => Wait::Hybrid,
            "event" => Wait::Event,
            "poll" => Wait::Poll,
            other => {
                let message = format!("wait is {other:?}, must be 'hybrid', 'event' or 'poll'");
                return Err(PyValueError::new_err(message));
            }
        };
        let until = Instant::now() + seconds("connect_timeout", connect_timeout)?;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let options = ClientOptions { wait, patience: left.min(LOOK) };
            match py.detach(|| clearway_client::Client::connect_with(&domain, options)) {
                Ok(client) => return Ok(Self { client: Mutex::new(Some(client)) }),
                Err(_) if left > LOOK => py.check_signals()?,
                Err(error) => return Err(errors::error(py, error)),
            }
        }
    }

    #[getter]
    fn domain(&self, py: Python<'_>) -> PyResult<String> {
        Ok(self.open(py)?.domain().to_string())
    }

    #[pyo3(signature = (scene, timeout = 10.0))]
    fn plan(&self, scene: &Bound<'_, PyAny>, timeout: Option<f64>) -> PyResult<Reply> {
        let limit = seconds("timeout", timeout)?;
        wait(scene.py(), &mut self.begin(scene)?, limit)
    }

    fn plan_many<'py>(
        &self,
        py: Python<'py>,
        scenes: Vec<Bound<'py, PyAny>>,
        timeout: Option<f64>,
    ) -> PyResult<Bound<'py, PyList>> {
        let limit = seconds("timeout", timeout)?;
        let client = self.open(py)?;
        let all = PyList::new(py, &scenes)?;
        let (mut places, mut known) = (Vec::new(), Vec::new());
        for (place, scene) in scenes.iter().enumerate() {
            match prepared(scene) {
                Ok(scene) => {
                    places.push(place);
                    known.push(scene);
                }
                Err(error) => all.set_item(place, errors::as_answer(py, error)?)?,
            }
        }
        let mut interrupted = None;
        let replies = py.detach(|| {
            client.plan_many_while(&known, limit, LOOK, || {
                interrupted = Python::attach(|py| py.check_signals()).err();
                interrupted.is_none()
            })
        });
        if let Some(error) = interrupted {
            return Err(error);
        }
        for (place, reply) in places.into_iter().zip(replies) {
            match reply {
                Ok(reply) => all.set_item(place, Bound::new(py, Reply::new(reply))?)?,
                Err(error) => {
                    all.set_item(place, errors::as_answer(py, errors::error(py, error))?)?;
                }
            }
        }
        Ok(all)
    }

    /// Connects in advance, so that `count` requests can be open at a time.
    fn reserve(&self, py: Python<'_>, count: usize) -> PyResult<()> {
        let client = self.open(py)?;
        py.detach(|| client.reserve(count)).map_err(|error| errors::error(py, error))
    }

    /// Whether a connection is free, so that `start` need not connect.
    fn is_ready(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.open(py)?.is_ready())
    }

    fn start(&self, scene: &Bound<'_, PyAny>) -> PyResult<Pending> {
        Ok(Pending { pending: Mutex::new(Some(self.begin(scene)?)) })
    }

    fn close(&self, py: Python<'_>) {
        let client = lock(&self.client).take();
        py.detach(|| drop(client));
    }

    fn __enter__(this: Bound<'_, Self>) -> Bound<'_, Self> {
        this
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, py: Python<'_>, _exception: &Bound<'_, PyAny>) {
        self.close(py);
    }
}

#[pymethods]
impl Pending {
    /// The reply, if it is there; else None. Once it has been returned or an error was raised, the
    /// request is done.
    fn poll(&self, py: Python<'_>) -> PyResult<Option<Reply>> {
        let mut pending = self.take(py)?;
        // What comes after this makes the file descriptor readable.
        pending.silence();
        match pending.poll() {
            Ok(Some(reply)) => Ok(Some(Reply::new(reply))),
            Ok(None) => {
                *lock(&self.pending) = Some(pending);
                Ok(None)
            }
            Err(error) => Err(errors::error(py, error)),
        }
    }

    /// Waits for the reply, at most `timeout` seconds. After a `PlanTimeoutError` the request is
    /// still open.
    #[pyo3(signature = (timeout = 10.0))]
    fn wait(&self, py: Python<'_>, timeout: Option<f64>) -> PyResult<Reply> {
        let limit = seconds("timeout", timeout)?;
        let mut pending = self.take(py)?;
        let waited = wait(py, &mut pending, limit);
        if pending.is_open() {
            *lock(&self.pending) = Some(pending);
        }
        waited
    }

    /// Cancels the request.
    fn cancel(&self, py: Python<'_>) {
        let pending = lock(&self.pending).take();
        py.detach(|| drop(pending));
    }

    /// A file descriptor for event loops: when it can be read, `poll`. It is the same and open until
    /// the request is done. Poll every 0.1 s anyway, as planners can die. -1 if the client polls.
    fn fileno(&self) -> RawFd {
        lock(&self.pending).as_ref().and_then(clearway_client::Pending::bell).unwrap_or(-1)
    }
}

impl Pending {
    fn take(&self, py: Python<'_>) -> PyResult<clearway_client::Pending> {
        let pending = lock(&self.pending).take();
        pending.ok_or_else(|| {
            errors::exception(py, "ClearwayError", "the request is done, or used by another thread")
        })
    }
}
