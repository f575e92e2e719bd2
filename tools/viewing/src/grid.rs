//! Walls as a floor plan: cells that are free or not.

use foxglove::bytes::Bytes;
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{Grid, PackedElementField, Pose, Quaternion, Vector2, Vector3};
use schemas::message::{AxisBox, FreeSpace, Solid};

use crate::Shown;
use crate::place::{Axes, timestamp};
use crate::topics::{Kind, ViewMessage, encoded};

/// The most cells of a floor plan.
pub const MOST_CELLS: u64 = 16_000_000;

/// Why there is no floor plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GridError {
    /// It would be too large.
    #[error(
        "request {index}: a floor plan of {across} m x {up} m has {cells} cells of {cell} m, at most \
         {MOST_CELLS} are allowed"
    )]
    TooLarge {
        /// Counts the recording's requests, from 0.
        index: u64,
        /// Metres.
        across: f64,
        /// Metres.
        up: f64,
        /// How many there would be.
        cells: f64,
        /// The side of a cell, metres.
        cell: f64,
    },
}

/// The floor plan of a scene of two dimensions; none of three, and none of a free space that the
/// request does not carry. A cell is taken if its centre is in a solid or, where there are only
/// channels, in none of them.
pub(crate) fn message(
    shown: &Shown,
    frame: &str,
    cell: f64,
) -> Result<Option<ViewMessage>, GridError> {
    let axes = Axes::of(shown.scene);
    let Some([min, max]) = extent(&shown.scene.free_space) else { return Ok(None) };
    if axes == Axes::Xyz {
        return Ok(None);
    }
    let [across, up] = [max[0] - min[0], max[1] - min[1]];
    let [columns, rows] = [across, up].map(|side| (side / cell).ceil().max(1.0));
    let cells = columns * rows;
    if cells.is_nan() || cells > MOST_CELLS as f64 {
        return Err(GridError::TooLarge { index: shown.index, across, up, cells, cell });
    }
    let raster = Raster { min, cell, columns: columns as usize, rows: rows as usize };
    let taken = raster.taken(&shown.scene.free_space);
    let [x, y, z] = axes.place([min[0], min[1], 0.0]);
    // Rows go up: in upright scenes along z.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let orientation = match axes {
        Axes::Xz => Quaternion { x: half, y: 0.0, z: 0.0, w: half },
        Axes::Xy | Axes::Xyz => Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 },
    };
    let field = PackedElementField {
        name: "occupied".to_owned(),
        offset: 0,
        r#type: NumericType::Uint8.into(),
    };
    let message = Grid {
        timestamp: Some(timestamp(shown.begin_ns)),
        frame_id: frame.to_owned(),
        pose: Some(Pose { position: Some(Vector3 { x, y, z }), orientation: Some(orientation) }),
        column_count: raster.columns as u32,
        cell_size: Some(Vector2 { x: cell, y: cell }),
        row_stride: raster.columns as u32,
        cell_stride: 1,
        fields: vec![field],
        data: Bytes::from(taken),
    };
    Ok(Some(encoded("/viewing/grid", Kind::Grid, shown.begin_ns, &message)))
}

type Outline = Vec<[f64; 2]>;

/// The outlines of solids and channels, in the scene's two coordinates.
fn outlines(space: &FreeSpace) -> (Vec<Outline>, Vec<Outline>) {
    let flat = |p: [f64; 3]| [p[0], p[1]];
    let corners = |min: [f64; 3], max: [f64; 3]| {
        vec![[min[0], min[1]], [max[0], min[1]], [max[0], max[1]], [min[0], max[1]]]
    };
    let of_box = |sides: &AxisBox| corners(sides.min.padded(), sides.max.padded());
    let solids = space.solids.iter().flatten().flat_map(|solid| match solid {
        Solid::Polygon(vertices) => vec![vertices.iter().map(|v| flat(v.padded())).collect()],
        Solid::Box(sides) => vec![of_box(sides)],
        Solid::Boxes(boxes) => boxes.iter().map(of_box).collect(),
    });
    let channels = space.channels.iter().flatten().map(of_box);
    (solids.collect(), channels.collect())
}

/// The bounds, or the box around everything.
fn extent(space: &FreeSpace) -> Option<[[f64; 2]; 2]> {
    if let Some(bounds) = &space.bounds {
        let [min, max] = [bounds.min.padded(), bounds.max.padded()];
        return Some([[min[0], min[1]], [max[0], max[1]]]);
    }
    let (solids, channels) = outlines(space);
    let points = solids.iter().chain(&channels).flatten();
    points.fold(None, |extent: Option<[[f64; 2]; 2]>, p| {
        let [min, max] = extent.unwrap_or([*p, *p]);
        Some([[min[0].min(p[0]), min[1].min(p[1])], [max[0].max(p[0]), max[1].max(p[1])]])
    })
}

/// Cells in rows, from the lower left.
struct Raster {
    min: [f64; 2],
    /// The side of a cell.
    cell: f64,
    columns: usize,
    rows: usize,
}

impl Raster {
    /// 1 for each cell that is taken, 0 for the others.
    fn taken(&self, space: &FreeSpace) -> Vec<u8> {
        let (solids, channels) = outlines(space);
        let carved = solids.is_empty();
        let mut cells = vec![u8::from(carved); self.columns * self.rows];
        for outline in if carved { &channels } else { &solids } {
            self.fill(&mut cells, outline, u8::from(!carved));
        }
        cells
    }

    /// Sets the cells whose centres lie in an outline.
    fn fill(&self, cells: &mut [u8], outline: &[[f64; 2]], value: u8) {
        // Where the outline crosses the middle of each row that it reaches.
        let mut crossings: Vec<Vec<f64>> = Vec::new();
        let lowest = outline.iter().fold(f64::INFINITY, |least, p| least.min(p[1]));
        let first = self.row_from(lowest);
        for (index, a) in outline.iter().enumerate() {
            let b = &outline[(index + 1) % outline.len()];
            let [low, high] = if a[1] <= b[1] { [a, b] } else { [b, a] };
            // Half open: a vertex counts for one of its edges.
            for row in self.row_from(low[1])..self.row_from(high[1]) {
                let y = self.min[1] + (row as f64 + 0.5) * self.cell;
                let x = low[0] + (y - low[1]) / (high[1] - low[1]) * (high[0] - low[0]);
                let at = row - first;
                if crossings.len() <= at {
                    crossings.resize(at + 1, Vec::new());
                }
                crossings[at].push(x);
            }
        }
        for (row, xs) in crossings.iter_mut().enumerate() {
            xs.sort_by(f64::total_cmp);
            for pair in xs.chunks_exact(2) {
                let begin = (first + row) * self.columns;
                let [from, to] =
                    [pair[0], pair[1]].map(|x| self.first_from(x - self.min[0], self.columns));
                cells[begin + from..begin + to.max(from)].fill(value);
            }
        }
    }

    /// The first row whose middle is at `y` or above.
    fn row_from(&self, y: f64) -> usize {
        self.first_from(y - self.min[1], self.rows)
    }

    /// The first of `count` cells whose middle is `offset` or farther from the first's begin.
    fn first_from(&self, offset: f64, count: usize) -> usize {
        // Saturates.
        ((offset / self.cell - 0.5).ceil().max(0.0) as usize).min(count)
    }
}

#[cfg(test)]
mod tests {
    use schemas::message::Vector;

    use super::*;

    fn raster(columns: usize, rows: usize) -> Raster {
        Raster { min: [0.0, 0.0], cell: 1.0, columns, rows }
    }

    fn polygon(vertices: &[[f64; 2]]) -> Solid {
        Solid::Polygon(vertices.iter().copied().map(Vector::from).collect())
    }

    fn rows(raster: &Raster, space: &FreeSpace) -> Vec<String> {
        let taken = raster.taken(space);
        let row =
            |cells: &[u8]| cells.iter().map(|cell| if *cell == 1 { '#' } else { '.' }).collect();
        taken.chunks(raster.columns).map(row).collect()
    }

    #[test]
    fn cells_with_their_centre_in_a_solid_are_taken() {
        // A triangle, a box with an edge just past the centres, and one that reaches out.
        let solids = vec![
            polygon(&[[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]]),
            Solid::Box(AxisBox { min: [3.4, 1.4].into(), max: [4.6, 2.4].into() }),
            Solid::Box(AxisBox { min: [4.0, 3.0].into(), max: [9.0, 9.0].into() }),
        ];
        let space = FreeSpace { solids: Some(solids), ..FreeSpace::default() };
        assert_eq!(rows(&raster(5, 4), &space), ["##...", "#..##", ".....", "....#"]);
    }

    #[test]
    fn what_is_no_channel_is_taken_where_there_are_only_channels() {
        let channel = |min: [f64; 2], max: [f64; 2]| AxisBox { min: min.into(), max: max.into() };
        let channels = vec![channel([0.0, 0.0], [3.0, 1.0]), channel([2.0, 0.0], [3.0, 3.0])];
        let space = FreeSpace { channels: Some(channels), ..FreeSpace::default() };
        assert_eq!(rows(&raster(4, 3), &space), ["...#", "##.#", "##.#"]);
        assert_eq!(extent(&space), Some([[0.0, 0.0], [3.0, 3.0]]));
    }
}
