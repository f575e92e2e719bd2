//! Cells in metres.

use std::f64::consts::FRAC_PI_2;

use crate::error::CellsError;

/// A yaw this close to a multiple of a quarter turn is that multiple, radians.
const SAME_YAW: f64 = 1e-9;

/// From cells to metres and back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapFrame {
    origin: [f64; 2],
    resolution: f64,
    turn: Turn,
}

/// How the picture is turned about its lower left corner.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Turn {
    /// By quarter turns, 0 to 3.
    Quarters(u8),
    /// By an angle with this cosine and sine.
    Angle { cos: f64, sin: f64 },
}

impl Turn {
    fn new(yaw: f64) -> Self {
        let quarters = (yaw / FRAC_PI_2).round();
        if (yaw - quarters * FRAC_PI_2).abs() <= SAME_YAW {
            return Self::Quarters(quarters.rem_euclid(4.0) as u8);
        }
        Self::Angle { cos: libm::cos(yaw), sin: libm::sin(yaw) }
    }
}

impl MapFrame {
    /// The frame of a map, if all its cells have distinct corners in floating point.
    pub(crate) fn new(
        resolution: f64,
        [x, y, yaw]: [f64; 3],
        [width, height]: [usize; 2],
    ) -> Result<Self, CellsError> {
        let frame = Self { origin: [x, y], resolution, turn: Turn::new(yaw) };
        let [width, height] = [width as u32, height as u32];
        let (min, max) = frame.extent([width, height]);
        let farthest = min.into_iter().chain(max).fold(0.0, |most: f64, c| most.max(c.abs()));
        let apart = match frame.turn {
            // Floating-point numbers are sparsest at one corner or the other.
            Turn::Quarters(_) => [[0, 0], [width - 1, height - 1]].iter().all(|[i, j]| {
                let (a, b) = (frame.place([*i, *j]), frame.place([i + 1, j + 1]));
                a[0] != b[0] && a[1] != b[1]
            }),
            // Each corner is rounded a few times.
            Turn::Angle { .. } => farthest * 16.0 * f64::EPSILON <= resolution,
        };
        if !apart || !farthest.is_finite() {
            let corner = frame.place([width, height]);
            let ends = frame.origin.into_iter().chain(corner);
            let farthest = ends.fold(0.0, |far: f64, c| if c.abs() > far.abs() { c } else { far });
            return Err(CellsError::TooFarOut { resolution, farthest });
        }
        Ok(frame)
    }

    /// The side of a cell, metres.
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// Whether the sides of cells are not parallel to the axes.
    pub fn is_turned(&self) -> bool {
        matches!(self.turn, Turn::Angle { .. })
    }

    /// Where a corner of cells is, metres.
    pub fn place(&self, [i, j]: [u32; 2]) -> [f64; 2] {
        let [i, j] = [f64::from(i), f64::from(j)];
        let Self { origin: [x, y], resolution, turn } = *self;
        let (i, j) = match turn {
            Turn::Quarters(0) => (i, j),
            Turn::Quarters(1) => (-j, i),
            Turn::Quarters(2) => (-i, -j),
            Turn::Quarters(_) => (j, -i),
            Turn::Angle { cos, sin } => {
                let (u, v) = (i * resolution, j * resolution);
                // In this order each coordinate is monotone in i and in j, rounding and all.
                return [x + (u * cos - v * sin), y + (u * sin + v * cos)];
            }
        };
        // Fused: rounded once, and the same on every machine.
        [resolution.mul_add(i, x), resolution.mul_add(j, y)]
    }

    /// Where the middle of a cell is, metres.
    pub fn middle(&self, [x, y]: [u32; 2]) -> [f64; 2] {
        let (a, b) = (self.place([x, y]), self.place([x + 1, y + 1]));
        [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0]
    }

    /// Where a point is in cells: columns and rows from the lower left corner of the picture.
    pub fn locate(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (u, v) =
            ((x - self.origin[0]) / self.resolution, (y - self.origin[1]) / self.resolution);
        match self.turn {
            Turn::Quarters(0) => [u, v],
            Turn::Quarters(1) => [v, -u],
            Turn::Quarters(2) => [-u, -v],
            Turn::Quarters(_) => [-v, u],
            Turn::Angle { cos, sin } => [u * cos + v * sin, v * cos - u * sin],
        }
    }

    /// The least and the greatest coordinates of a picture.
    pub(crate) fn extent(&self, [width, height]: [u32; 2]) -> ([f64; 2], [f64; 2]) {
        let corners = [[0, 0], [width, 0], [width, height], [0, height]].map(|c| self.place(c));
        let [first, ..] = corners;
        let least = |i: usize| corners.iter().fold(first[i], |least, c| least.min(c[i]));
        let greatest = |i: usize| corners.iter().fold(first[i], |most, c| most.max(c[i]));
        ([least(0), least(1)], [greatest(0), greatest(1)])
    }
}
