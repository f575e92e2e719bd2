//! The native part of the Python package `clearway`; see `python/clearway/__init__.py`.

mod block;
mod client;
mod errors;
mod leg;
mod occupancy;
mod recording_file;
mod reply;
mod scene;

use pyo3::prelude::*;

#[pymodule]
fn _clearway(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("ERROR_CODES", errors::codes())?;
    module.add_function(wrap_pyfunction!(occupancy::free_space_of_cells, module)?)?;
    module.add_class::<client::Client>()?;
    module.add_class::<client::Pending>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<reply::Reply>()?;
    module.add_class::<reply::Trajectory>()?;
    module.add_class::<reply::Clearance>()?;
    module.add_class::<reply::Exceeds>()?;
    module.add_class::<leg::Leg>()?;
    module.add_class::<block::Block>()?;
    module.add_class::<recording_file::Recording>()?;
    module.add_class::<recording_file::RecordedRequest>()?;
    module.add_class::<recording_file::RecordedReply>()?;
    Ok(())
}
