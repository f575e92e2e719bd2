//! Recordings as Python reads them.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use clearway_client::Refused;
use pyo3::prelude::*;
use recording::{Message, Reader};
use schemas::message::{self, ReplyAssembler, RequestContent, RequestKey};

use crate::errors;
use crate::reply::Reply;
use crate::scene::Scene;

/// A recording that is being read: an iterator over its requests and replies, in bus order.
#[pyclass(frozen, module = "clearway")]
pub(crate) struct Recording {
    reading: Mutex<Reading>,
}

struct Reading {
    reader: Reader,
    /// Replies of which the last part has not come.
    open: BTreeMap<RequestKey, ReplyAssembler>,
}

/// A recorded request.
#[pyclass(frozen, get_all, module = "clearway")]
pub(crate) struct RecordedRequest {
    /// Its client and number; the reply has the same.
    key: (u64, u64),
    /// When it was sent, nanoseconds since the Unix epoch.
    sent_ns: u64,
    /// The scene; None if what was sent is none.
    scene: Option<Py<Scene>>,
}

/// A recorded reply.
#[pyclass(frozen, get_all, module = "clearway")]
pub(crate) struct RecordedReply {
    /// The client and number of its request.
    key: (u64, u64),
    /// When its last part was sent, nanoseconds since the Unix epoch.
    sent_ns: u64,
    /// The reply; None if the request was refused.
    reply: Option<Py<Reply>>,
    /// The `RefusedError` that says why; None if it was not refused.
    refusal: Option<Py<PyAny>>,
}

impl Recording {
    fn look<T>(&self, take: impl FnOnce(&mut Reading) -> T) -> T {
        take(&mut self.reading.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[pymethods]
impl Recording {
    #[new]
    fn new(py: Python<'_>, path: std::path::PathBuf) -> PyResult<Self> {
        let failed = |error: recording::ReadError| {
            let message = format!("{}: {error}", path.display());
            errors::exception(py, "RecordingError", &message)
        };
        let reader = py.detach(|| Reader::open(&path)).map_err(failed)?;
        Ok(Self { reading: Mutex::new(Reading { reader, open: BTreeMap::new() }) })
    }

    /// Messages that are missing, as far as it is read.
    #[getter]
    fn lost(&self) -> u64 {
        self.look(|reading| reading.reader.lost())
    }

    /// Replies of which the last part has not come, as far as it is read.
    #[getter]
    fn unfinished(&self) -> usize {
        self.look(|reading| reading.open.len())
    }

    fn __iter__(this: Bound<'_, Self>) -> Bound<'_, Self> {
        this
    }

    fn __next__<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let failed = |message: String| errors::exception(py, "RecordingError", &message);
        loop {
            let next = py.detach(|| self.look(|reading| reading.reader.next()));
            let Some(record) = next else { return Ok(None) };
            match record.map_err(|error| failed(error.to_string()))?.message {
                Message::Request(request) => return request_of(py, request).map(Some),
                Message::Reply(part) => {
                    let (key, last, sent_ns) = (part.key, part.last, part.sent_ns);
                    let reply = self.look(|Reading { open, .. }| {
                        // The rest of a reply whose beginning was lost is no reply.
                        if part.part != 0 && !open.contains_key(&key) {
                            return Ok(None);
                        }
                        let reply = open.entry(key).or_default().push(part);
                        if last || reply.is_err() {
                            open.remove(&key);
                        }
                        reply
                    });
                    if let Some(reply) = reply.map_err(|error| failed(error.to_string()))? {
                        return reply_of(py, sent_ns, reply).map(Some);
                    }
                }
            }
        }
    }
}

fn request_of(py: Python<'_>, request: message::Request) -> PyResult<Bound<'_, PyAny>> {
    let scene = match request.content {
        RequestContent::Scene(scene) => clearway_client::Scene::new(scene).ok(),
        RequestContent::Unreadable { .. } => None,
    };
    let scene = scene.map(|scene| Py::new(py, Scene { scene })).transpose()?;
    let key = (request.key.client, request.key.sequence);
    let request = RecordedRequest { key, sent_ns: request.sent_ns, scene };
    Ok(Bound::new(py, request)?.into_any())
}

fn reply_of(py: Python<'_>, sent_ns: u64, reply: message::Reply) -> PyResult<Bound<'_, PyAny>> {
    let key = (reply.key.client, reply.key.sequence);
    let (reply, refusal) = match clearway_client::Reply::try_from(reply) {
        Ok(reply) => (Some(Py::new(py, Reply::new(reply))?), None),
        Err(refused) => (None, Some(refusal_of(py, &refused)?)),
    };
    Ok(Bound::new(py, RecordedReply { key, sent_ns, reply, refusal })?.into_any())
}

fn refusal_of(py: Python<'_>, refused: &Refused) -> PyResult<Py<PyAny>> {
    Ok(errors::refused(py, refused)?.unbind())
}
