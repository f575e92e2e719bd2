//! Few large boxes instead of many cells.

use super::grid::OccupancyGrid;

/// A rectangle of cells: from the first index to before the second.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CellRange {
    pub(super) x: [usize; 2],
    pub(super) y: [usize; 2],
}

impl CellRange {
    fn area(&self) -> usize {
        (self.x[1] - self.x[0]) * (self.y[1] - self.y[0])
    }
}

/// Disjoint rectangles that together are a grid's solid cells.
///
/// Greedy: the lowest, then leftmost remaining cell is the lower left corner of the next
/// rectangle. It grows over remaining cells either first right, then up, or first up, then
/// right, whichever covers more (if equal, the former). Every cell is visited a few times at
/// most.
pub(super) struct Boxes {
    /// The remaining cells.
    grid: OccupancyGrid,
    /// No cell before this index remains.
    from: usize,
}

impl Boxes {
    /// The rectangles of a grid.
    pub(super) fn of(grid: OccupancyGrid) -> Self {
        Self { grid, from: 0 }
    }

    fn row(&self, y: usize, [from, to]: [usize; 2]) -> &[bool] {
        &self.grid.solid[y * self.grid.width..][from..to]
    }

    fn row_left(&self, y: usize, x: [usize; 2]) -> bool {
        self.row(y, x).iter().all(|solid| *solid)
    }

    fn column_left(&self, x: usize, [from, to]: [usize; 2]) -> bool {
        (from..to).all(|y| self.grid.solid[y * self.grid.width + x])
    }

    fn right_then_up(&self, x: usize, y: usize) -> CellRange {
        let row = self.row(y, [x, self.grid.width]);
        let length = row.iter().position(|solid| !solid).unwrap_or(row.len());
        let columns = [x, x + length];
        let top = (y + 1..self.grid.height).find(|above| !self.row_left(*above, columns));
        CellRange { x: columns, y: [y, top.unwrap_or(self.grid.height)] }
    }

    fn up_then_right(&self, x: usize, y: usize) -> CellRange {
        let top = (y + 1..self.grid.height).find(|above| !self.row_left(*above, [x, x + 1]));
        let rows = [y, top.unwrap_or(self.grid.height)];
        let right = (x + 1..self.grid.width).find(|beside| !self.column_left(*beside, rows));
        CellRange { x: [x, right.unwrap_or(self.grid.width)], y: rows }
    }
}

impl Iterator for Boxes {
    type Item = CellRange;

    fn next(&mut self) -> Option<CellRange> {
        let ahead = self.grid.solid[self.from..].iter().position(|solid| *solid)?;
        self.from += ahead;
        let (x, y) = (self.from % self.grid.width, self.from / self.grid.width);
        let (wide, high) = (self.right_then_up(x, y), self.up_then_right(x, y));
        let cells = if high.area() > wide.area() { high } else { wide };
        for y in cells.y[0]..cells.y[1] {
            self.grid.solid[y * self.grid.width..][cells.x[0]..cells.x[1]].fill(false);
        }
        Some(cells)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Drawn as people see it, the last row has the least y.
    fn grid(rows: &[&str]) -> OccupancyGrid {
        let solid =
            rows.iter().rev().flat_map(|row| row.bytes().map(|cell| cell == b'#')).collect();
        OccupancyGrid { width: rows[0].len(), height: rows.len(), solid }
    }

    #[track_caller]
    fn check(rows: &[&str], expected: &[([usize; 2], [usize; 2])]) {
        let boxes: Vec<_> = Boxes::of(grid(rows)).map(|cells| (cells.x, cells.y)).collect();
        assert_eq!(boxes, expected);
    }

    #[test]
    fn a_full_grid_is_one_box() {
        check(&["###", "###"], &[([0, 3], [0, 2])]);
    }

    #[test]
    fn an_empty_grid_has_none() {
        check(&["..", ".."], &[]);
    }

    #[test]
    fn a_corner_goes_to_the_longer_wall() {
        check(&["#..", "#..", "#..", "###"], &[([0, 1], [0, 4]), ([1, 3], [0, 1])]);
        check(&["#....", "#####"], &[([0, 5], [0, 1]), ([0, 1], [1, 2])]);
        check(&["#.", "##"], &[([0, 2], [0, 1]), ([0, 1], [1, 2])]);
    }

    #[test]
    fn a_frame_is_four_boxes() {
        check(
            &["####", "#..#", "#..#", "####"],
            &[([0, 4], [0, 1]), ([0, 1], [1, 4]), ([3, 4], [1, 4]), ([1, 3], [3, 4])],
        );
    }

    fn grids() -> impl Strategy<Value = OccupancyGrid> {
        let sizes = (1usize..24, 1usize..24, 0.0..1.0);
        sizes.prop_flat_map(|(width, height, density)| {
            let cells = prop::collection::vec(prop::bool::weighted(density), width * height);
            cells.prop_map(move |solid| OccupancyGrid { width, height, solid })
        })
    }

    proptest! {
        #[test]
        fn boxes_are_disjoint_and_cover_exactly_what_is_solid(grid in grids()) {
            let mut times = vec![0; grid.solid.len()];
            for cells in Boxes::of(grid.clone()) {
                for y in cells.y[0]..cells.y[1] {
                    for x in cells.x[0]..cells.x[1] {
                        times[y * grid.width + x] += 1;
                    }
                }
            }
            let expected: Vec<_> = grid.solid.iter().map(|solid| i32::from(*solid)).collect();
            prop_assert_eq!(times, expected);
        }

        #[test]
        fn boxes_can_not_grow(grid in grids()) {
            // What was left when a box was made is what it and the later ones cover.
            let boxes: Vec<_> = Boxes::of(grid.clone()).collect();
            let mut left = grid.clone();
            for cells in boxes {
                let before = Boxes::of(left.clone());
                prop_assert!(cells.x[1] == grid.width || !before.column_left(cells.x[1], cells.y));
                prop_assert!(cells.y[1] == grid.height || !before.row_left(cells.y[1], cells.x));
                for y in cells.y[0]..cells.y[1] {
                    left.solid[y * grid.width..][cells.x[0]..cells.x[1]].fill(false);
                }
            }
        }
    }
}
