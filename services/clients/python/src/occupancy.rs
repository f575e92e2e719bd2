//! Maps of cells as free space.

use floor_plan::{FloorPlan, UnknownCells};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use schemas::message::{AxisBox, FreeSpace, Solid};

/// The free space of an occupancy grid as a scene has it, with its name; see
/// `clearway.free_space_of_grid`. A cell is a byte of `cells`.
#[pyfunction]
pub(crate) fn free_space_of_cells<'py>(
    py: Python<'py>,
    cells: &[u8],
    size: [u32; 2],
    resolution: f64,
    origin: [f64; 3],
    free_most: u8,
    unknown: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let unknown = match unknown {
        "occupied" => UnknownCells::Occupied,
        "free" => UnknownCells::Free,
        other => {
            let message = format!("unknown is {other:?}, must be 'occupied' or 'free'");
            return Err(PyValueError::new_err(message));
        }
    };
    let (space, name) = py
        .detach(|| {
            let cells = bytemuck::cast_slice(cells);
            let plan =
                FloorPlan::from_occupancy(cells, size, resolution, origin, free_most, unknown)?;
            let space = plan.free_space();
            let name = space.digest();
            Ok((space, name))
        })
        .map_err(|error: floor_plan::CellsError| PyValueError::new_err(error.to_string()))?;
    let FreeSpace { solids, bounds, .. } = space;
    let made = PyDict::new(py);
    made.set_item("named", name.to_string())?;
    let polygons = PyList::empty(py);
    for solid in solids.unwrap_or_default() {
        if let Solid::Polygon(outline) = solid {
            let points: Vec<_> = outline.iter().map(|point| point.as_slice()).collect();
            let polygon = PyDict::new(py);
            polygon.set_item("polygon", points)?;
            polygons.append(polygon)?;
        }
    }
    made.set_item("solids", polygons)?;
    if let Some(AxisBox { min, max }) = bounds {
        let bounds = PyDict::new(py);
        bounds.set_item("min", min.as_slice())?;
        bounds.set_item("max", max.as_slice())?;
        made.set_item("bounds", bounds)?;
    }
    Ok(made)
}
