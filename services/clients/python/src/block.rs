//! Samples as a buffer.

use std::ffi::{c_int, c_void};

use clearway_client::Sample;
use pyo3::exceptions::PyBufferError;
use pyo3::ffi;
use pyo3::prelude::*;

/// Samples that follow each other: a read-only buffer of 9 float64 for each, `t`, `position` (3),
/// `heading`, `velocity` (3) and `yaw_rate`. In shared memory they stay there for as long as this
/// lives, or anything that was made of it.
#[pyclass(frozen, module = "clearway")]
pub(crate) struct Block {
    pub(crate) block: clearway_client::Block,
}

#[pymethods]
impl Block {
    /// Whether the samples are where the planner wrote them, in shared memory.
    #[getter]
    fn is_shared(&self) -> bool {
        self.block.is_shared()
    }

    fn __len__(&self) -> usize {
        self.block.samples().len()
    }

    #[expect(unsafe_code, reason = "the buffer protocol is one of C")]
    unsafe fn __getbuffer__(
        this: Bound<'_, Self>,
        view: *mut ffi::Py_buffer,
        flags: c_int,
    ) -> PyResult<()> {
        let samples: &[Sample] = this.get().block.samples();
        let (begin, bytes) = (samples.as_ptr(), size_of_val(samples));
        // SAFETY: they lie where they are until the block is dropped, which the view keeps alive.
        let filled = unsafe {
            ffi::PyBuffer_FillInfo(
                view,
                this.as_ptr(),
                begin.cast_mut().cast::<c_void>(),
                bytes as ffi::Py_ssize_t,
                1,
                flags,
            )
        };
        match filled {
            0 => Ok(()),
            _ => Err(PyErr::take(this.py())
                .unwrap_or_else(|| PyBufferError::new_err("samples can't be written"))),
        }
    }
}
