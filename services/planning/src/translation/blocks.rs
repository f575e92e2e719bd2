//! What is looked at instead of the solids: convex blocks of them along their surfaces.
//!
//! A body that is outside of a solid can't enter it but across its surface. So what lies deep inside
//! of a solid needs no looking at, and its edges need not be looked at one by one: as many in
//! succession are taken together as turn to one side only around a part of the solid.

use std::ops::Range;

use crate::budget::{Budget, Spent};
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::Vector;
use crate::geometry::orientation::{Side, side_of_line};

/// Solids with more edges are cut into stretches of so many, so that no more of a large one is looked
/// at than what is near.
const STRETCH: usize = 256;

/// Steps that it takes to join an edge to a block.
const STEPS_PER_EDGE: u64 = 8;

/// Bytes that an edge takes in blocks.
const BYTES_PER_EDGE: usize = 64;

/// The index of nothing.
pub(super) const NONE: u32 = u32::MAX;

/// A convex polygon in a solid.
#[derive(Debug, Clone)]
pub(super) struct Block {
    /// Counter-clockwise; two ends where it is flat.
    pub(super) corners: Vec<Vector<2>>,
    /// The walls that are sides of it.
    pub(super) walls: Vec<usize>,
    /// The first wall of its solid.
    pub(super) solid: usize,
}

/// The blocks of those solids that have been looked at.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    /// By wall; `NONE` where nobody has looked.
    of_wall: Vec<u32>,
    blocks: Vec<Block>,
}

impl Blocks {
    /// The block of which a wall is a side; `None` for a wall of no solid.
    pub(super) fn of(
        &mut self,
        walls: &Walls<2>,
        wall: usize,
        budget: &Budget<'_>,
    ) -> Result<Option<usize>, Spent> {
        let Some(solid) = walls.walls_beside(wall) else { return Ok(None) };
        if self.of_wall.is_empty() {
            budget.hold(size_of::<u32>() * walls.as_slice().len())?;
            self.of_wall.resize(walls.as_slice().len(), NONE);
        }
        if self.of_wall[wall] == NONE {
            self.cut(walls, wall, solid, budget)?;
        }
        Ok(Some(self.of_wall[wall] as usize))
    }

    pub(super) fn get(&self, block: usize) -> &Block {
        &self.blocks[block]
    }

    /// Cuts the stretch of a solid in which a wall is.
    fn cut(
        &mut self,
        walls: &Walls<2>,
        wall: usize,
        solid: Range<usize>,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let first = solid.start;
        if let Some(sides) = walls.box_of(wall) {
            let (min, max) = (sides.min(), sides.max());
            let corners = [[min.x, min.y], [max.x, min.y], [max.x, max.y], [min.x, max.y]];
            self.add(corners.map(Vector::from).to_vec(), solid.collect(), first);
            return Ok(());
        }
        let outline = Outline::new(walls, solid.clone(), budget)?;
        let stretch = outline.stretch(wall);
        budget.hold(BYTES_PER_EDGE * stretch.len())?;
        let mut at = outline.beginning(&stretch);
        let end = at + stretch.len();
        while at < end {
            let count = outline.longest_run(at, end - at, budget)?;
            let mut corners: Vec<_> = (at..=at + count).map(|at| outline.vertex(at)).collect();
            if corners.first() == corners.last() {
                corners.pop();
            }
            drop_straight(&mut corners);
            let sides = (at..at + count).map(|at| outline.wall(at)).collect();
            self.add(corners, sides, first);
            at += count;
        }
        Ok(())
    }

    fn add(&mut self, corners: Vec<Vector<2>>, walls: Vec<usize>, solid: usize) {
        let index = u32::try_from(self.blocks.len()).unwrap_or(NONE);
        walls.iter().for_each(|wall| self.of_wall[*wall] = index);
        self.blocks.push(Block { corners, walls, solid });
    }
}

/// The outline of a solid, seen counter-clockwise: edge `at` begins at vertex `at`, both counted around
/// and around.
struct Outline<'a> {
    all: &'a Walls<2>,
    solid: Range<usize>,
    /// Whether its walls are in the other order.
    is_turned: bool,
}

impl<'a> Outline<'a> {
    fn new(all: &'a Walls<2>, solid: Range<usize>, budget: &Budget<'_>) -> Result<Self, Spent> {
        budget.step(solid.len() as u64 / STEPS_PER_EDGE)?;
        let mut outline = Self { all, solid, is_turned: false };
        // At its lowest corner it is convex.
        let count = outline.solid.len();
        let lowest = (0..count)
            .min_by(|a, b| {
                let (a, b) = (outline.vertex(*a), outline.vertex(*b));
                a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x))
            })
            .unwrap_or(0);
        outline.is_turned = outline.turn([lowest + count - 1, lowest, lowest + 1]) == Side::Right;
        Ok(outline)
    }

    fn wall(&self, edge: usize) -> usize {
        let at = edge % self.solid.len();
        if self.is_turned { self.solid.end - 1 - at } else { self.solid.start + at }
    }

    fn vertex(&self, at: usize) -> Vector<2> {
        let Wall { from, to } = self.all.as_slice()[self.wall(at)];
        if self.is_turned { to } else { from }
    }

    fn turn(&self, [a, b, c]: [usize; 3]) -> Side {
        side_of_line(&self.vertex(a), &self.vertex(b), &self.vertex(c))
    }

    /// The edges that are cut together with a wall.
    fn stretch(&self, wall: usize) -> Range<usize> {
        let count = self.solid.len();
        let at = if self.is_turned { self.solid.end - 1 - wall } else { wall - self.solid.start };
        let first = at - at % STRETCH;
        first..count.min(first + STRETCH)
    }

    /// Where to begin with a stretch: at a corner of a whole outline that is not convex.
    fn beginning(&self, stretch: &Range<usize>) -> usize {
        let count = self.solid.len();
        if stretch.len() < count {
            return stretch.start;
        }
        let is_reflex = |at: &usize| self.turn([at + count - 1, *at, at + 1]) == Side::Right;
        stretch.clone().find(is_reflex).unwrap_or(stretch.start)
    }

    /// How many edges, from `first` on and at most so many, are sides of one convex polygon in the
    /// solid, the line from the last to the first being its only other side.
    fn longest_run(&self, first: usize, most: usize, budget: &Budget<'_>) -> Result<usize, Spent> {
        let mut count = 1;
        while count < most && self.goes_on(first, first + count, budget)? {
            count += 1;
        }
        Ok(count)
    }

    /// Whether the polygon between the vertices `first` and `last` may have the edge that follows.
    fn goes_on(&self, first: usize, last: usize, budget: &Budget<'_>) -> Result<bool, Spent> {
        budget.step(STEPS_PER_EDGE)?;
        let next = last + 1;
        if self.turn([last - 1, last, next]) == Side::Right {
            return Ok(false);
        }
        if next - first == self.solid.len() {
            return Ok(self.turn([last, first, first + 1]) == Side::Left);
        }
        let ears = [[first, last, next], [last, next, first], [next, first, first + 1]];
        if ears.iter().any(|corner| self.turn(*corner) != Side::Left) {
            return Ok(false);
        }
        let [a, b, c] = [first, last, next].map(|at| self.vertex(at));
        let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        let mut is_empty = true;
        self.all.near(&low, &high, 0.0, budget, |index, wall| {
            let vertex = wall.from;
            is_empty &= !self.solid.contains(&index)
                || [a, b, c].contains(&vertex)
                || [(a, b), (b, c), (c, a)]
                    .iter()
                    .any(|(from, to)| side_of_line(from, to, &vertex) == Side::Right);
        })?;
        Ok(is_empty)
    }
}

/// Leaves out the corners at which a convex polygon goes straight on.
fn drop_straight(corners: &mut Vec<Vector<2>>) {
    let all = std::mem::take(corners);
    let count = all.len();
    if count < 3 {
        *corners = all;
        return;
    }
    let is_corner = |at: &usize| {
        let (before, after) = (&all[(at + count - 1) % count], &all[(at + 1) % count]);
        side_of_line(before, &all[*at], after) != Side::On
    };
    corners.extend((0..count).filter(is_corner).map(|at| all[at]));
}
