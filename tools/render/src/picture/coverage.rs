//! The area that very many outlines cover, as few rectangles, pixel by pixel.

use std::fmt::Write;

use super::plot::Pixel;
use super::text::Px;

/// The most rectangles; the pixels grow instead.
const MOST: usize = 2500;

/// Which cells of a grid are covered.
struct Raster {
    cell: f64,
    columns: usize,
    rows: usize,
    /// By row: how much the cover changes from the column before.
    change: Vec<i32>,
}

/// Path data of the area that the outlines cover. With `thin`, even what is narrower than a
/// pixel is visible.
pub(super) fn covered(rings: &[Vec<Pixel>], width: f64, height: f64, thin: bool) -> String {
    let mut cell = 1.0;
    loop {
        let mut grid = Raster::new(width, height, cell);
        let mut crossings = vec![Vec::new(); grid.rows];
        for ring in rings {
            grid.fill(ring, &mut crossings);
            if thin {
                grid.trace(ring);
            }
        }
        let rectangles = grid.rectangles();
        if rectangles.len() <= MOST {
            let mut data = String::new();
            for [x, y, w, h] in rectangles {
                _ = write!(data, "M{} {}h{}v{}h-{}z", Px(x), Px(y), Px(w), Px(h), Px(w));
            }
            return data;
        }
        cell *= 2.0;
    }
}

impl Raster {
    fn new(width: f64, height: f64, cell: f64) -> Self {
        let count = |length: f64| (length / cell).ceil().clamp(1.0, 2000.0) as usize;
        let (columns, rows) = (count(width), count(height));
        Self { cell, columns, rows, change: vec![0; (columns + 1) * rows] }
    }

    /// Covers the cells of a row whose middles are from `begin` to `end`, in cells.
    fn cover(&mut self, row: usize, begin: f64, end: f64) {
        let clamp = |at: f64| (at - 0.5).ceil().clamp(0.0, self.columns as f64) as usize;
        let (begin, end) = (clamp(begin), clamp(end));
        if begin < end {
            let row = row * (self.columns + 1);
            self.change[row + begin] += 1;
            self.change[row + end] -= 1;
        }
    }

    /// Covers the cells whose middles are inside, by the even-odd rule.
    fn fill(&mut self, ring: &[Pixel], crossings: &mut [Vec<f64>]) {
        let (mut least, mut most) = (self.rows, 0);
        for (a, b) in edges(ring) {
            let ([ax, ay], [bx, by]) = (a.map(|c| c / self.cell), b.map(|c| c / self.cell));
            let row = |y: f64| (y - 0.5).ceil().clamp(0.0, self.rows as f64) as usize;
            let (first, last) = (row(ay.min(by)), row(ay.max(by)));
            for (row, crossings) in crossings.iter_mut().enumerate().take(last).skip(first) {
                crossings.push(ax + (row as f64 + 0.5 - ay) / (by - ay) * (bx - ax));
            }
            (least, most) = (least.min(first), most.max(last));
        }
        for (row, crossings) in crossings.iter_mut().enumerate().take(most).skip(least) {
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                self.cover(row, pair[0], pair[1]);
            }
            crossings.clear();
        }
    }

    /// Covers the cells along the outline.
    fn trace(&mut self, ring: &[Pixel]) {
        for (a, b) in edges(ring) {
            let ([ax, ay], [bx, by]) = (a.map(|c| c / self.cell), b.map(|c| c / self.cell));
            let steps = (bx - ax).abs().max((by - ay).abs()).ceil().clamp(1.0, 4000.0) as usize;
            for step in 0..steps {
                let part = step as f64 / steps as f64;
                let (x, y) = (ax + part * (bx - ax), ay + part * (by - ay));
                if y >= 0.0 && (y as usize) < self.rows {
                    self.cover(y as usize, x.floor(), x.floor() + 1.0);
                }
            }
        }
    }

    /// The covered area as (x, y, width, height) in pixels.
    fn rectangles(&self) -> Vec<[f64; 4]> {
        let mut done: Vec<[usize; 4]> = Vec::new();
        // Those that end at the row before, by column, as indices into `done`.
        let (mut above, mut here): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
        for row in 0..self.rows {
            let changes = &self.change[row * (self.columns + 1)..][..=self.columns];
            let (mut depth, mut begin) = (0, 0);
            let mut candidates = above.iter().copied().peekable();
            for (column, change) in changes.iter().enumerate() {
                let was = depth;
                depth += change;
                if was == 0 && depth > 0 {
                    begin = column;
                } else if was > 0 && depth == 0 {
                    while candidates.next_if(|index| done[*index][0] < begin).is_some() {}
                    let same =
                        |index: &usize| done[*index][0] == begin && done[*index][2] == column;
                    let index = candidates.next_if(same).unwrap_or_else(|| {
                        done.push([begin, row, column, row]);
                        done.len() - 1
                    });
                    done[index][3] = row + 1;
                    here.push(index);
                }
            }
            std::mem::swap(&mut above, &mut here);
            here.clear();
        }
        let cell = self.cell;
        let pixels = |[x0, y0, x1, y1]: [usize; 4]| {
            [x0, y0, x1 - x0, y1 - y0].map(|cells| cells as f64 * cell)
        };
        done.into_iter().map(pixels).collect()
    }
}

fn edges(ring: &[Pixel]) -> impl Iterator<Item = (Pixel, Pixel)> {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| (*a, *b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(x: f64, y: f64, w: f64, h: f64) -> Vec<Pixel> {
        vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]]
    }

    #[track_caller]
    fn check_covered(rings: &[Vec<Pixel>], thin: bool, expected: &str) {
        assert_eq!(covered(rings, 100.0, 100.0, thin), expected);
    }

    #[test]
    fn many_tiles_are_one_rectangle() {
        let tiles = (0..2500).map(|i| rectangle(f64::from(i % 50), f64::from(i / 50), 1.0, 1.0));
        let tiles: Vec<_> = tiles.collect();
        check_covered(&tiles, false, "M0.00 0.00h50.00v50.00h-50.00z");
    }

    #[test]
    fn slits_show_where_asked_for() {
        let slit = [rectangle(3.1, 2.0, 0.2, 4.0)];
        check_covered(&slit, false, "");
        check_covered(&slit, true, "M3.00 2.00h1.00v5.00h-1.00z");
    }

    #[test]
    fn a_chessboard_becomes_coarse() {
        let field =
            |i: u32| rectangle(f64::from(2 * (i % 50) + i / 50 % 2), f64::from(i / 50), 1.0, 1.0);
        let board: Vec<_> = (0..5000).map(field).collect();
        assert!(covered(&board, 100.0, 100.0, false).matches('M').count() <= MOST);
    }
}
