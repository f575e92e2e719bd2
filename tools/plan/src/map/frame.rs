//! Cells in metres.

use std::path::Path;

use schemas::message::{AxisBox, Solid};

use super::boxes::CellRange;
use super::{Description, MapError};

/// From indices to metres.
pub(super) struct MapFrame {
    origin: [f64; 2],
    resolution: f64,
}

impl MapFrame {
    /// The frame of a map, if all its cells have distinct corners in floating point.
    pub(super) fn new(
        path: &Path,
        description: &Description,
        width: usize,
        height: usize,
    ) -> Result<Self, MapError> {
        let Description { origin, resolution, .. } = *description;
        let frame = Self { origin, resolution };
        for (axis, cells) in [width, height].into_iter().enumerate() {
            // Floating-point numbers are sparsest at one end or the other.
            let [first, second] = [0, 1].map(|index| frame.coordinate(axis, index));
            let [before, last] = [cells - 1, cells].map(|index| frame.coordinate(axis, index));
            let apart = first < second && before < last && last.is_finite();
            if !apart {
                let farthest = if first.abs() > last.abs() { first } else { last };
                let path = path.to_owned();
                return Err(MapError::TooFarOut { path, resolution, farthest });
            }
        }
        Ok(frame)
    }

    fn coordinate(&self, axis: usize, index: usize) -> f64 {
        // Fused: rounded once, and the same on every machine.
        self.resolution.mul_add(index as f64, self.origin[axis])
    }

    /// The box that cells cover.
    pub(super) fn place(&self, cells: &CellRange) -> AxisBox {
        let corner = |end: usize| {
            [self.coordinate(0, cells.x[end]), self.coordinate(1, cells.y[end])].into()
        };
        AxisBox { min: corner(0), max: corner(1) }
    }

    /// The same, as a solid.
    pub(super) fn solid(&self, cells: &CellRange) -> Solid {
        Solid::Box(self.place(cells))
    }
}
