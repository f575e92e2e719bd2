//! A part of any shape that leaves its cavity among solids of any shape, in the plane.
//!
//! The part may be where it overlaps no solid: at the displacements outside of the Minkowski sums
//! of the solids' edges and the reflected part. Contact is allowed, so what is free is closed, and
//! may be as narrow as a line: the part slides in a slot that is exactly as wide as it is.
//!
//! Exact and complete: [`Cavity::plan`] finds the shortest way at a margin, and refuses only where
//! there is none (`docs/method.md`, section 14).

use std::cell::RefCell;

use crate::budget::{Budget, Cap, Spent};
use crate::clearance::translating::Body;
use crate::free_space::mouth_of;
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::{AxisBox, Direction, HalfSpace, Sign, Vector, polygon};
use blocks::Blocks;
use shortest::{Out, shortest};
use sums::{Obstacles, SumMargin, Sums};
use widest::{CirclePolygon, closing, cut_near};

mod blocks;
mod convex;
mod shortest;
mod sums;
mod widest;

/// Overlaps of up to this part of the scene's extent are contact: what rounding leaves where a
/// scene is turned.
const CONTACT: f64 = 5e-10;

/// Rounding, as a part of the extent.
const ROUNDING: f64 = 1e-12;

/// A clearance is searched for up to this part of the scene's extent.
const PRECISION: f64 = 1e-11;

/// Clearances that differ by no more than this part of the extent are the same.
const SAME_CLEARANCE: f64 = 1e-9;

/// What is missing is searched for up to this part of the part's width.
const NARROW: f64 = 1e-11;

/// How close a search for a clearance comes before what closes the way is looked at.
const ROUGH: f64 = 1e-2;

/// Times that it is.
const ROUNDS: usize = 4;

/// So many sides a circle gets each time, for what is between two corners.
const MORE_SIDES: usize = 16;

/// What a path is to keep from the walls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Demand<const D: usize> {
    /// This gap along each axis, metres, or from a wall the one that it has at the start.
    Gap(Vector<D>),
    /// This clearance, metres, or from a wall the one that it has at the start.
    AtLeast(f64),
    /// More than this clearance, metres, by more than rounding.
    MoreThan(f64),
    /// This part, in (0, 1], of the greatest clearance that there is.
    Part(f64),
}

/// Why there is no path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoWay<const D: usize> {
    /// The part overlaps a solid at the start.
    Overlap {
        /// The solid, counted in the order of addition.
        solid: usize,
        /// The shortest move out of it, metres, if that is known.
        out: Option<Vector<D>>,
    },
    /// The part reaches out of the bounds.
    OutOfBounds {
        /// The coordinate along which it does.
        axis: usize,
        /// Where it is, metres.
        side: f64,
        /// Where the bounds end, metres.
        end: f64,
    },
    /// There is a path, but it can't keep as much.
    TooMuch {
        /// The part in [0, 1) of what is asked for that it can keep.
        part: f64,
    },
    /// No translation leads out.
    Closed(Option<Narrow>),
    /// The budget ended.
    Spent(Spent),
}

/// The narrowest place of the widest way, where that is too narrow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Narrow {
    /// The solid on one side, counted in the order of addition.
    pub solid: usize,
    /// The unit vector across it.
    pub across: Vector<2>,
    /// How wide the part is along this, metres.
    pub needs: f64,
    /// How wide the place is, metres; 0 where there is none.
    pub has: f64,
    /// It is one for a convex piece of the part, which can't get out even alone, and `needs` is how
    /// wide that is.
    pub is_for_piece: bool,
}

impl<const D: usize> From<Spent> for NoWay<D> {
    fn from(spent: Spent) -> Self {
        Self::Spent(spent)
    }
}

/// A part in its assembled state, made ready.
#[derive(Debug, Clone)]
pub struct MovedPart {
    /// Reflected at the origin.
    pieces: Vec<Vec<Vector<2>>>,
    outlines: Vec<Vec<Vector<2>>>,
    bounds: AxisBox<2>,
}

impl MovedPart {
    /// Cuts the body into convex pieces.
    pub fn new(body: &Body<'_, 2>, budget: &Budget<'_>) -> Result<Self, Spent> {
        let outlines = body.outlines();
        let mut pieces = Vec::new();
        for outline in &outlines {
            pieces.append(&mut convex::pieces(outline, budget)?);
        }
        for piece in &mut pieces {
            piece.iter_mut().for_each(|vertex| *vertex = -*vertex);
        }
        Ok(Self { pieces, outlines, bounds: *body.bounds() })
    }
}

/// A part among solids, and where it is out.
#[derive(Debug, Clone, Copy)]
pub struct Cavity<'a> {
    /// The part.
    pub part: &'a MovedPart,
    /// The surfaces of the solids.
    pub walls: &'a Walls<2>,
    /// What the part does not leave but through the mouth.
    pub bounds: AxisBox<2>,
    /// Where the part leaves them: it is out when it is beyond this end of the bounds.
    pub exit: Direction,
}

impl Cavity<'_> {
    /// The displacements through which the shortest way leads out that keeps what is wished for;
    /// the first is none.
    pub fn plan(&self, wish: Demand<2>, budget: &Budget<'_>) -> Result<Vec<Vector<2>>, NoWay<2>> {
        let out = self.out();
        if out.distance <= 0.0 {
            return Ok(vec![Vector::zeros(); 2]);
        }
        self.check_bounds()?;
        let before = budget.drawn(Cap::Bytes);
        let found = self.search(wish, out, budget);
        budget.release(budget.drawn(Cap::Bytes).saturating_sub(before) as usize);
        found
    }

    fn search(
        &self,
        wish: Demand<2>,
        out: Out,
        budget: &Budget<'_>,
    ) -> Result<Vec<Vector<2>>, NoWay<2>> {
        let (limits, blocks) = (self.limits(), RefCell::default());
        let obstacles = self.obstacles(&limits, &blocks);
        self.check_start(obstacles, budget)?;
        let search = DemandSearch { cavity: self, obstacles, out, budget };
        match wish {
            Demand::Gap(gap) => search.keeping(|part| SumMargin::PerAxis(gap * part)),
            Demand::AtLeast(clearance) => {
                let circle = CirclePolygon::new(self.walls, &self.part.pieces);
                search.keeping(|part| circle.margin(clearance * part))
            }
            Demand::MoreThan(clearance) => search.wider(clearance),
            Demand::Part(part) => search.safest(part),
        }
    }

    fn mouth(&self) -> HalfSpace {
        mouth_of(&self.bounds, self.exit)
    }

    fn out(&self) -> Out {
        let exit = self.exit;
        let bounds = &self.part.bounds;
        let last = exit.coordinate(&bounds.min()).min(exit.coordinate(&bounds.max()));
        Out { exit, distance: exit.sign.factor() * self.mouth().bound - last }
    }

    /// The sides of the bounds but for the one with the mouth.
    fn limits(&self) -> [Wall<2>; 3] {
        let HalfSpace { side, bound } = self.mouth();
        let (axis, across) = (side.axis, 1 - side.axis);
        let (min, max) = (self.bounds.min(), self.bounds.max());
        let back = match side.sign {
            Sign::Negative => min[axis],
            Sign::Positive => max[axis],
        };
        let corner = |along: f64, beside: f64| {
            let mut corner = Vector::zeros();
            (corner[axis], corner[across]) = (along, beside);
            corner
        };
        let [low, high] = [min[across], max[across]];
        [
            Wall { from: corner(back, low), to: corner(bound, low) },
            Wall { from: corner(back, high), to: corner(bound, high) },
            Wall { from: corner(back, low), to: corner(back, high) },
        ]
    }

    fn extent(&self) -> f64 {
        let (part, bounds) = (&self.part.bounds, &self.bounds);
        (part.max().sup(&bounds.max()) - part.min().inf(&bounds.min())).amax()
    }

    fn obstacles<'s>(
        &'s self,
        limits: &'s [Wall<2>],
        blocks: &'s RefCell<Blocks>,
    ) -> Obstacles<'s> {
        let (part, bounds) = (&self.part.bounds, &self.bounds);
        let extent = self.extent();
        let farthest = [part.min(), part.max(), bounds.min(), bounds.max()]
            .iter()
            .map(Vector::amax)
            .fold(0.0, f64::max);
        let rounding = (ROUNDING * extent).max(16.0 * f64::EPSILON * farthest);
        Obstacles {
            walls: self.walls,
            blocks,
            limits,
            pieces: &self.part.pieces,
            relaxed: const { &[Vector::<2>::new(0.0, 0.0)] },
            bounds: [-part.max(), -part.min()],
            center: part.center(),
            radius: part.size().norm() / 2.0,
            tolerance: (CONTACT * extent).max(rounding),
            rounding,
        }
    }

    /// What of the part is not beyond the mouth must lie in the bounds.
    fn check_bounds(&self) -> Result<(), NoWay<2>> {
        let tolerance = CONTACT * self.extent();
        let (min, max) = (self.bounds.min(), self.bounds.max());
        let HalfSpace { side, bound } = self.mouth();
        let axis = side.axis;
        let depth = |point: &Vector<2>| side.sign.factor() * (point[axis] - bound);
        let mut worst: Option<(f64, NoWay<2>)> = None;
        let mut check = |point: &Vector<2>| {
            for axis in 0..2 {
                for (outside, end) in
                    [(min[axis] - point[axis], min[axis]), (point[axis] - max[axis], max[axis])]
                {
                    if outside > worst.map_or(tolerance, |(most, _)| most) {
                        worst =
                            Some((outside, NoWay::OutOfBounds { axis, side: point[axis], end }));
                    }
                }
            }
        };
        for (a, b) in self.part.outlines.iter().flat_map(|outline| polygon::edges(outline)) {
            let (before, after) = (depth(&a), depth(&b));
            if before >= 0.0 {
                check(&a);
            }
            if (before > 0.0) != (after > 0.0) && before != after {
                let mut on = a + (b - a) * (before / (before - after));
                on[axis] = bound;
                check(&on);
            }
        }
        worst.map_or(Ok(()), |(_, error)| Err(error))
    }

    fn check_start(&self, obstacles: Obstacles<'_>, budget: &Budget<'_>) -> Result<(), NoWay<2>> {
        let mut sums = Sums::new(obstacles, SumMargin::Contact, budget)?;
        let found = sums.depth(&Vector::zeros(), budget)?;
        sums.release(budget);
        if let Some((wall, out)) = found {
            let solid = self.walls.solid_of(wall).unwrap_or(0);
            return Err(NoWay::Overlap { solid, out: Some(out) });
        }
        // It crosses no wall, so each part of it is inside a solid wholly or not at all.
        for outline in &self.part.outlines {
            let Some(wall) = self.walls.solid_around(&outline[0], budget)? else { continue };
            let is_inside = outline.iter().all(|vertex| {
                // On a wall's line it may be said to be inside.
                matches!(self.walls.depth_in_solid(vertex, budget), Ok(Some((_, depth))) if depth > obstacles.tolerance)
            });
            if is_inside {
                let solid = self.walls.solid_of(wall).unwrap_or(0);
                return Err(NoWay::Overlap { solid, out: None });
            }
        }
        Ok(())
    }
}

/// A search for one answer.
struct DemandSearch<'a> {
    cavity: &'a Cavity<'a>,
    obstacles: Obstacles<'a>,
    out: Out,
    budget: &'a Budget<'a>,
}

impl DemandSearch<'_> {
    fn way(&self, margin: SumMargin) -> Result<Option<Vec<Vector<2>>>, Spent> {
        let mut sums = Sums::new(self.obstacles, margin, self.budget)?;
        let way = shortest(&mut sums, self.out, self.budget);
        sums.release(self.budget);
        way
    }

    /// The shortest way that keeps all of a margin.
    fn keeping(&self, margin: impl Fn(f64) -> SumMargin) -> Result<Vec<Vector<2>>, NoWay<2>> {
        if let Some(way) = self.way(margin(1.0))? {
            return Ok(way);
        }
        if self.way(SumMargin::Contact)?.is_none() {
            return Err(NoWay::Closed(self.narrowest()?));
        }
        let (mut least, mut most) = (0.0, 1.0);
        let way = self.widen((&mut least, &mut most), PRECISION, &margin)?;
        // There may be less room where the part comes out.
        if let Some(end) = way.as_ref().and_then(|way| way.last()) {
            let relaxed = [Vector::zeros(), *end];
            let obstacles = Obstacles { relaxed: &relaxed, ..self.obstacles };
            let search = DemandSearch { obstacles, ..*self };
            if let Some(way) = search.way(margin(1.0))? {
                return Ok(way);
            }
            most = 1.0;
            search.widen((&mut least, &mut most), PRECISION, &margin)?;
        }
        Err(NoWay::TooMuch { part: least })
    }

    /// Raises `least`, for which there is a way, and lowers `most`, until they differ by no more
    /// than a part of `most`; finds the last way, `None` where `least` was not raised.
    fn widen(
        &self,
        (least, most): (&mut f64, &mut f64),
        precision: f64,
        margin: impl Fn(f64) -> SumMargin,
    ) -> Result<Option<Vec<Vector<2>>>, Spent> {
        let mut way = None;
        let finest = PRECISION * *most;
        while *most - *least > finest.max(precision * *most) {
            let middle = f64::midpoint(*least, *most);
            match self.way(margin(middle))? {
                Some(found) => (*least, way) = (middle, Some(found)),
                None => *most = middle,
            }
        }
        Ok(way)
    }

    /// A way with more than this clearance.
    fn wider(&self, clearance: f64) -> Result<Vec<Vector<2>>, NoWay<2>> {
        let Self { cavity, budget, .. } = *self;
        let walls = cut_near(cavity.walls, &cavity.part.outlines, cavity.extent(), budget)?;
        let blocks = RefCell::default();
        let obstacles = Obstacles { walls: &walls, blocks: &blocks, ..self.obstacles };
        let search = DemandSearch { obstacles, ..*self };
        let circle = CirclePolygon::new(cavity.walls, &cavity.part.pieces);
        let more = clearance + SAME_CLEARANCE * cavity.extent();
        search.way(circle.margin(more))?.ok_or(NoWay::Closed(None))
    }

    /// The shortest of the ways with the greatest clearance, or with this part of it.
    fn safest(&self, part: f64) -> Result<Vec<Vector<2>>, NoWay<2>> {
        let Self { cavity, budget, .. } = *self;
        let Some(mut way) = self.way(SumMargin::Contact)? else {
            return Err(NoWay::Closed(self.narrowest()?));
        };
        let extent = cavity.extent();
        let walls = cut_near(cavity.walls, &cavity.part.outlines, extent, budget)?;
        let blocks = RefCell::default();
        let obstacles = Obstacles { walls: &walls, blocks: &blocks, ..self.obstacles };
        let search = DemandSearch { obstacles, ..*self };
        let mut circle = CirclePolygon::new(cavity.walls, &cavity.part.pieces);
        // Roughly at first.
        let rounding = SAME_CLEARANCE * extent;
        let Some(found) = search.way(circle.margin(rounding))? else { return Ok(way) };
        way = found;
        let (mut widest, mut most) = (rounding, extent);
        let margin = |radius: f64| circle.margin(radius);
        if let Some(found) = search.widen((&mut widest, &mut most), ROUGH, margin)? {
            way = found;
        }
        // A polygon is wider than its circle, so there may be room for more.
        most *= CirclePolygon::BEYOND;
        for round in 0..ROUNDS {
            let closing = closing(&way, &obstacles, (widest, most), budget)?;
            closing.iter().take(MORE_SIDES).for_each(|(_, across)| circle.add(across));
            let (mut open, mut closed) = (0, closing.len());
            while open < closed {
                let middle = usize::midpoint(open, closed);
                match search.way(circle.margin(closing[middle].0))? {
                    Some(found) => (widest, way, open) = (closing[middle].0, found, middle + 1),
                    None => (most, closed) = (closing[middle].0, middle),
                }
            }
            match search.way(circle.margin(widest + rounding))? {
                None => break,
                Some(found) if round + 1 < ROUNDS => (widest, way) = (widest + rounding, found),
                Some(_) => {
                    let margin = |radius: f64| circle.margin(radius);
                    let found = search.widen((&mut widest, &mut most), PRECISION, margin)?;
                    way = found.unwrap_or(way);
                }
            }
        }
        if part < 1.0 {
            let less = search.way(circle.margin(widest * part))?;
            way = less.unwrap_or(way);
        }
        Ok(way)
    }

    /// The narrowest place of the widest way: of all convex pieces of the part, each moved alone, for
    /// the one that lacks most. `None` if each of them would get out.
    fn narrowest(&self) -> Result<Option<Narrow>, Spent> {
        let pieces = self.obstacles.pieces;
        let (mut lacks, mut narrowest) = (0.0, None);
        for piece in pieces {
            let obstacles = Obstacles { pieces: std::slice::from_ref(piece), ..self.obstacles };
            let alone = DemandSearch { obstacles, ..*self };
            if pieces.len() > 1 {
                let less = if lacks > 0.0 { SumMargin::Overlap(lacks) } else { SumMargin::Contact };
                if alone.way(less)?.is_some() {
                    continue;
                }
            }
            if let Some((missing, narrow)) = alone.narrowest_of_piece(piece, lacks)? {
                (lacks, narrowest) = (missing, Some(narrow));
            }
        }
        Ok(narrowest)
    }

    /// The narrowest place of the widest way for a convex piece that lacks more than so much, and how
    /// much that is: it would get out if it were smaller by this on all sides. `None` if it lacks less,
    /// or would not get out either way.
    fn narrowest_of_piece(
        &self,
        piece: &[Vector<2>],
        lacks: f64,
    ) -> Result<Option<(f64, Narrow)>, Spent> {
        let half = convex::normals(piece)
            .map(|(normal, reach)| (reach + convex::support(piece, &-normal)) / 2.0)
            .fold(f64::INFINITY, f64::min);
        let (mut least, mut most) = (self.obstacles.tolerance.max(lacks).min(half), half);
        let mut narrow = None;
        while most - least > NARROW * half {
            let middle = f64::midpoint(least, most);
            let mut sums = Sums::new(self.obstacles, SumMargin::Overlap(middle), self.budget)?;
            let way = shortest(&mut sums, self.out, self.budget)?;
            sums.release(self.budget);
            if let Some(way) = way {
                most = middle;
                narrow = sums.deepest(&way);
            } else {
                least = middle;
            }
        }
        // However thin, it would not get out: its length is in the way.
        let narrow = narrow.filter(|_| half - most > 2.0 * self.obstacles.tolerance);
        Ok(narrow.map(|(wall, across)| {
            let needs = convex::support(piece, &across) + convex::support(piece, &-across);
            let solid = self.obstacles.walls.solid_of(wall).unwrap_or(0);
            let has = (needs - 2.0 * most).max(0.0);
            let is_for_piece = self.cavity.part.pieces.len() > 1;
            (most, Narrow { solid, across, needs, has, is_for_piece })
        }))
    }
}

#[cfg(test)]
mod tests;
