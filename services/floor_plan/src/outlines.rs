//! Few polygons instead of many cells.
//!
//! The boundary of a set of cells runs along cell sides. Cells that meet at a corner only are
//! not connected there, so each outline passes such a corner once. What remains are holes: a
//! region around free cells has no outline that is one simple polygon. It is cut along cell
//! sides, at every hole to the left and to the right of its lowest side, each cut as far as the
//! next boundary.
//!
//! After that every piece is a simple polygon. A cut ends at the picture's outside, at a hole
//! whose lowest side is lower, or at one further along the same line. So from every hole two
//! chains of cuts lead outside, one leaving to the left and one to the right, and they share no
//! cut: each cut lies on a circle of cuts and boundaries and has a different piece on either
//! side, and no loop within a piece, nor one closed through a corner that a piece touches
//! twice, can run around a hole without crossing one of its chains.

use crate::cells::{self, CellSet, bit};

/// Simple polygons that don't overlap, counter-clockwise. Their vertices are corners of cells,
/// in cells from the lower left corner of the picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outlines {
    vertices: Vec<[u32; 2]>,
    /// Where each polygon ends in `vertices`.
    ends: Vec<usize>,
}

impl Outlines {
    /// The vertices of each polygon.
    pub fn iter(&self) -> impl Iterator<Item = &[[u32; 2]]> {
        let begins = std::iter::once(0).chain(self.ends.iter().copied());
        self.ends.iter().zip(begins).map(|(end, begin)| &self.vertices[begin..*end])
    }

    /// How many polygons there are.
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// The vertices of all polygons together.
    pub fn vertices(&self) -> usize {
        self.vertices.len()
    }
}

/// Whether straight sides keep the vertices that another polygon has on them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SharedVertices {
    /// Right where sides are parallel to the axes: such a vertex is exactly on the side.
    Dropped,
    /// Right where vertices are rounded: sides that touch stay equal.
    Kept,
}

/// The outlines of a set of cells, or, if it has more than `most` corners, how many.
pub(crate) fn trace(
    cells: &CellSet,
    [width, height]: [usize; 2],
    shared: SharedVertices,
    most: usize,
) -> Result<Outlines, usize> {
    let corners = count_corners(cells, [width, height]);
    if corners > most {
        return Err(corners);
    }
    let mut tracer = Tracer::new(width);
    let cuts = cuts(cells, [width, height]);
    let mut ahead = cuts.as_slice();
    let empty = vec![0; width.div_ceil(64)];
    let mut cut = empty.clone();
    let (mut upper, mut lower) = (empty.clone(), empty.clone());
    for y in 0..=height {
        let below = if y > 0 { cells.row(y - 1) } else { &empty };
        let above = if y < height { cells.row(y) } else { &empty };
        let here = ahead.iter().take_while(|cut| cut.y == y).count();
        let (cuts_here, later) = ahead.split_at(here);
        ahead = later;
        cuts_here.iter().for_each(|range| cells::fill(&mut cut, range.x));
        for index in 0..empty.len() {
            let (a, b, c) = (above[index], below[index], cut[index]);
            upper[index] = a & (!b | c);
            lower[index] = b & (!a | c);
        }
        let kept = if shared == SharedVertices::Kept { cuts_here } else { &[] };
        cells::runs(&upper, width, |run| tracer.side(y, run, Side::Upper, above, kept));
        cells::runs(&lower, width, |run| tracer.side(y, run, Side::Lower, below, kept));
        tracer.connect();
        if !cuts_here.is_empty() {
            cut.fill(0);
        }
    }
    Ok(tracer.follow())
}

/// The corners of the boundary of a set of cells; where two cells touch, the corners of both.
fn count_corners(cells: &CellSet, [width, height]: [usize; 2]) -> usize {
    let empty = vec![0; width.div_ceil(64)];
    let mut corners = 0;
    for y in 0..=height {
        let below = if y > 0 { cells.row(y - 1) } else { &empty };
        let above = if y < height { cells.row(y) } else { &empty };
        let (mut upper_before, mut lower_before) = (0, 0);
        for (above, below) in above.iter().zip(below) {
            let (upper, lower) = (above & !below, below & !above);
            corners += (upper ^ (upper << 1 | upper_before)).count_ones() as usize;
            corners += (lower ^ (lower << 1 | lower_before)).count_ones() as usize;
            (upper_before, lower_before) = (upper >> 63, lower >> 63);
        }
        if width % 64 == 0 {
            corners += (upper_before + lower_before) as usize;
        }
    }
    corners
}

/// What a horizontal side bounds from which side.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    /// The cells above it.
    Upper,
    /// The cells below it.
    Lower,
}

/// Half of the corner between a horizontal and a vertical side.
struct Corner {
    x: usize,
    vertex: u32,
    /// Whether the vertical side is above.
    up: bool,
    /// Whether the horizontal side leads here; else it begins here.
    arrives: bool,
}

struct Tracer {
    vertices: Vec<[u32; 2]>,
    /// The vertex after each.
    next: Vec<u32>,
    /// By column, the lower end of the vertical side that is not complete, and whether a
    /// horizontal side leads there.
    open: Vec<(u32, bool)>,
    /// Of the current line.
    corners: Vec<Corner>,
}

impl Tracer {
    fn new(width: usize) -> Self {
        let open = vec![(0, false); width + 1];
        Self { vertices: Vec::new(), next: Vec::new(), open, corners: Vec::new() }
    }

    fn vertex(&mut self, x: usize, y: usize) -> u32 {
        let vertex = self.vertices.len() as u32;
        self.vertices.push([x as u32, y as u32]);
        self.next.push(vertex);
        vertex
    }

    /// A horizontal side at `y` of the cells in `row`, those above or below it.
    fn side(&mut self, y: usize, [from, to]: [usize; 2], side: Side, row: &[u64], kept: &[Cut]) {
        let beside = [from.checked_sub(1), Some(to)];
        let width = self.open.len() - 1;
        let filled = beside.map(|x| x.is_some_and(|x| x < width && bit(row, x)));
        // Solid is to the left: above a side that leads right, below one that leads left.
        let ups = filled.map(|filled| filled == (side == Side::Lower));
        let first = self.vertex(from, y);
        let mut before = first;
        let on_the_way = kept.iter().flat_map(|cut| cut.x).filter(|x| from < *x && *x < to);
        for x in on_the_way {
            let middle = self.vertex(x, y);
            self.link(side, before, middle);
            before = middle;
        }
        let last = self.vertex(to, y);
        self.link(side, before, last);
        let leads_right = side == Side::Upper;
        self.corners.push(Corner { x: from, vertex: first, up: ups[0], arrives: !leads_right });
        self.corners.push(Corner { x: to, vertex: last, up: ups[1], arrives: leads_right });
    }

    fn link(&mut self, side: Side, left: u32, right: u32) {
        match side {
            Side::Upper => self.next[left as usize] = right,
            Side::Lower => self.next[right as usize] = left,
        }
    }

    /// Completes the vertical sides that end at the current line and opens those that begin.
    fn connect(&mut self) {
        for corner in self.corners.iter().filter(|corner| !corner.up) {
            let (other, other_arrives) = self.open[corner.x];
            debug_assert_ne!(corner.arrives, other_arrives, "a vertical side leads on");
            let (from, to) = match corner.arrives {
                true => (corner.vertex, other),
                false => (other, corner.vertex),
            };
            self.next[from as usize] = to;
        }
        for corner in self.corners.drain(..).filter(|corner| corner.up) {
            self.open[corner.x] = (corner.vertex, corner.arrives);
        }
    }

    /// The polygons, each from its lowest leftmost vertex, from the lowest up.
    fn follow(self) -> Outlines {
        let mut is_done = vec![false; self.vertices.len()];
        let mut outlines =
            Outlines { vertices: Vec::with_capacity(self.vertices.len()), ends: Vec::new() };
        for begin in 0..self.vertices.len() {
            let mut at = begin;
            while !is_done[at] {
                is_done[at] = true;
                outlines.vertices.push(self.vertices[at]);
                at = self.next[at] as usize;
            }
            if outlines.ends.last().copied().unwrap_or(0) < outlines.vertices.len() {
                outlines.ends.push(outlines.vertices.len());
            }
        }
        outlines
    }
}

/// A cut along a line of cell sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Cut {
    y: usize,
    x: [usize; 2],
}

/// A connected region of cells outside the set.
#[derive(Clone, Copy)]
struct Region {
    /// Whether it reaches the border of the picture: then it is no hole.
    is_open: bool,
    /// The line of its lowest sides, and how far they reach.
    y: usize,
    x: [usize; 2],
}

impl Region {
    fn join(self, other: Self) -> Self {
        let is_open = self.is_open || other.is_open;
        let (y, x) = match self.y.cmp(&other.y) {
            std::cmp::Ordering::Less => (self.y, self.x),
            std::cmp::Ordering::Greater => (other.y, other.x),
            std::cmp::Ordering::Equal => {
                (self.y, [self.x[0].min(other.x[0]), self.x[1].max(other.x[1])])
            }
        };
        Self { is_open, y, x }
    }
}

/// Regions found row by row, united where they turn out to be connected.
#[derive(Default)]
struct Regions {
    parents: Vec<u32>,
    regions: Vec<Region>,
}

impl Regions {
    fn add(&mut self, region: Region) -> u32 {
        let label = self.parents.len() as u32;
        self.parents.push(label);
        self.regions.push(region);
        label
    }

    fn root(&mut self, mut label: u32) -> u32 {
        while self.parents[label as usize] != label {
            let parent = self.parents[label as usize];
            // Halve the way for the next one.
            self.parents[label as usize] = self.parents[parent as usize];
            label = parent;
        }
        label
    }

    fn unite(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (self.root(a), self.root(b));
        let (root, child) = (a.min(b), a.max(b));
        if root != child {
            self.parents[child as usize] = root;
            let joined = self.regions[root as usize].join(self.regions[child as usize]);
            self.regions[root as usize] = joined;
        }
        root
    }
}

/// The cuts that leave no hole in a set of cells, from the lowest, each line's from the left.
fn cuts(cells: &CellSet, [width, height]: [usize; 2]) -> Vec<Cut> {
    let mut regions = Regions::default();
    let (mut before, mut current): (Vec<([usize; 2], u32)>, Vec<_>) = (Vec::new(), Vec::new());
    let mut free = vec![0; width.div_ceil(64)];
    for y in 0..height {
        for (free, cells) in free.iter_mut().zip(cells.row(y)) {
            *free = !cells;
        }
        if width % 64 != 0
            && let Some(last) = free.last_mut()
        {
            *last &= !(u64::MAX << (width % 64));
        }
        let mut below = before.iter().peekable();
        current.clear();
        cells::runs(&free, width, |x| {
            let is_open = y == 0 || y + 1 == height || x[0] == 0 || x[1] == width;
            let region = Region { is_open, y, x };
            let mut label = None;
            while let Some((other, other_label)) = below.peek() {
                if other[1] > x[0] && other[0] < x[1] {
                    label = Some(match label {
                        None => *other_label,
                        Some(label) => regions.unite(label, *other_label),
                    });
                }
                // The run below may reach further than this one.
                if other[1] > x[1] {
                    break;
                }
                below.next();
            }
            let label = match label {
                None => regions.add(region),
                Some(label) => {
                    let root = regions.root(label);
                    let joined = regions.regions[root as usize].join(region);
                    regions.regions[root as usize] = joined;
                    root
                }
            };
            current.push((x, label));
        });
        std::mem::swap(&mut before, &mut current);
    }
    let roots =
        regions.parents.iter().enumerate().filter(|(label, root)| *label == **root as usize);
    let holes = roots.map(|(label, _)| regions.regions[label]).filter(|region| !region.is_open);
    let mut cuts = Vec::new();
    for Region { y, x: [left, right], .. } in holes {
        let whole = |x: usize| bit(cells.row(y), x) && bit(cells.row(y - 1), x);
        let from = (0..left).rev().find(|x| !whole(*x)).map_or(0, |x| x + 1);
        let to = (right..width).find(|x| !whole(*x)).unwrap_or(width);
        cuts.extend([[from, left], [right, to]].map(|x| Cut { y, x }));
    }
    cuts.retain(|cut| cut.x[0] < cut.x[1]);
    cuts.sort_unstable();
    // Two holes on one line have the cut between them in common.
    cuts.dedup();
    cuts
}

#[cfg(test)]
mod tests;
