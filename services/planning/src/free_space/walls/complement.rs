//! Walls where only channels are free: the boundary of their union (2.3).

use super::{FEW, Wall, Walls};
use crate::budget::{Budget, Held, Spent};
use crate::free_space::Mouth;
use crate::geometry::box_tree::BoxTree;
use crate::geometry::{AxisBox, Sign, Vector};
use std::cmp::Ordering;

/// An uncovered part of a side of a channel.
#[derive(Debug, Clone, Copy)]
struct Piece<const D: usize> {
    /// The axis to which it is perpendicular.
    axis: usize,
    /// On which side of the channel it lies.
    sign: Sign,
    min: Vector<D>,
    max: Vector<D>,
}

/// Channels or pieces compared in one step.
const LOOKS_PER_STEP: u64 = 4;

/// Steps that sorting one piece takes.
const SORTING: u64 = 8;

/// Reusable memory for [`Walls::set_complement`].
#[derive(Debug, Clone, Default)]
pub struct Complement<const D: usize> {
    neighbours: Vec<usize>,
    /// All pieces found, followed by those of the side being worked on.
    pieces: Vec<Piece<D>>,
}

impl<const D: usize> Complement<D> {
    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        self.neighbours.capacity() * size_of::<usize>()
            + self.pieces.capacity() * size_of::<Piece<D>>()
    }

    /// What is in it, bytes.
    #[cfg(test)]
    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.neighbours) + size_of_val(&*self.pieces)
    }
}

impl<const D: usize> Walls<D> {
    /// Replaces all walls by the boundary of the union of `channels` and, beyond a mouth, of the
    /// strip that goes on from the last channel; of the strip's own sides, as much as the mouth's
    /// `reach`. Indexes the walls.
    ///
    /// A part of a side is wall unless a channel or the strip goes on behind it. Pieces in one plane that
    /// continue each other along the last axis are merged; all are sorted by axis, facing and
    /// position. Takes n log n if each channel overlaps few others.
    pub fn set_complement(
        &mut self,
        channels: &[AxisBox<D>],
        mouth: Option<Mouth<D>>,
        memory: &mut Complement<D>,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        self.clear();
        let done = self.try_set_complement(channels, mouth, memory, budget);
        if done.is_err() {
            self.clear();
        }
        done
    }

    fn try_set_complement(
        &mut self,
        channels: &[AxisBox<D>],
        mouth: Option<Mouth<D>>,
        memory: &mut Complement<D>,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let Complement { neighbours, pieces } = memory;
        pieces.clear();
        let [mut for_tree, mut held] = [Held::new(budget, 0)?, Held::new(budget, 0)?];
        // The tree first indexes the channels, later the walls.
        let tree = &mut self.tree;
        if channels.len() > FEW {
            for_tree.resize(BoxTree::<D>::bytes_for(channels.len()))?;
            let bounds = |index: usize| (channels[index].min(), channels[index].max());
            tree.build(channels.len(), bounds, budget)?;
        }
        let strip = mouth.map(|mouth| mouth.strip());
        // The strip's sides come last, so that where it lies on a channel's side that counts.
        let sides = channels.iter().map(|channel| (channel.min(), channel.max()));
        let sides = sides.chain(mouth.and_then(|mouth| mouth.strip_in_reach()));
        for (index, (min, max)) in sides.enumerate() {
            neighbours.clear();
            if channels.len() > FEW {
                tree.visit(&min, &max, 0.0, budget, |other| {
                    neighbours.push(other);
                    0.0
                })?;
                neighbours.sort_unstable();
            } else {
                neighbours.extend(0..channels.len());
            }
            for axis in 0..D {
                for sign in [Sign::Negative, Sign::Positive] {
                    let (mut low, mut high) = (min, max);
                    match sign {
                        Sign::Negative => high[axis] = low[axis],
                        Sign::Positive => low[axis] = high[axis],
                    }
                    // Beyond its reach the strip is open.
                    let is_open = index == channels.len()
                        && mouth.is_some_and(|mouth| mouth.plane.side.axis == axis);
                    if !is_open {
                        let side = Piece { axis, sign, min: low, max: high };
                        budget.step(1 + neighbours.len() as u64 / LOOKS_PER_STEP)?;
                        let around = (&neighbours[..], channels, strip.as_ref());
                        add_uncovered(side, index, around, pieces, (budget, &mut held))?;
                    }
                }
            }
        }
        tree.clear();
        budget.step(SORTING * pieces.len() as u64)?;
        pieces.sort_unstable_by(compare);
        let mut last: Option<Piece<D>> = None;
        for piece in &*pieces {
            match &mut last {
                Some(last) if continues(last, piece) => {
                    last.max[along(piece)] = last.max[along(piece)].max(piece.max[along(piece)]);
                }
                _ => {
                    self.walls.extend(last.map(wall));
                    last = Some(*piece);
                }
            }
        }
        self.walls.extend(last.map(wall));
        self.index(budget)
    }
}

fn wall<const D: usize>(piece: Piece<D>) -> Wall<D> {
    Wall { from: piece.min, to: piece.max }
}

/// The least and the greatest corner of a box.
type Extent<const D: usize> = (Vector<D>, Vector<D>);

/// Adds the parts of a side behind which no other channel goes on.
fn add_uncovered<const D: usize>(
    side: Piece<D>,
    owner: usize,
    (neighbours, channels, strip): (&[usize], &[AxisBox<D>], Option<&Extent<D>>),
    pieces: &mut Vec<Piece<D>>,
    (budget, held): (&Budget<'_>, &mut Held<'_>),
) -> Result<(), Spent> {
    let begin = pieces.len();
    pieces.push(side);
    let at = side.min[side.axis];
    let others = neighbours.iter().filter(|index| **index != owner);
    let others = others.map(|index| (*index, (channels[*index].min(), channels[*index].max())));
    let strip = strip.filter(|_| owner != channels.len()).map(|strip| (channels.len(), *strip));
    for (index, (min, max)) in others.chain(strip) {
        #[cfg(test)]
        crate::geometry::work::look();
        let (near, far) = (min[side.axis], max[side.axis]);
        let goes_on = match side.sign {
            Sign::Positive => near <= at && at < far,
            Sign::Negative => near < at && at <= far,
        };
        let same_side = match side.sign {
            Sign::Positive => at == far,
            Sign::Negative => at == near,
        };
        // Of two sides in one place that of the earlier channel counts.
        if goes_on || (same_side && index < owner) {
            let count = pieces.len();
            budget.step(1 + (count - begin) as u64 / LOOKS_PER_STEP)?;
            let mut kept = begin;
            for piece in begin..count {
                let piece = pieces[piece];
                if !cut(piece, &min, &max, pieces) {
                    pieces[kept] = piece;
                    kept += 1;
                }
            }
            // Close up: kept pieces, then the parts of those cut.
            pieces.drain(kept..count);
            held.resize(size_of_val(&**pieces))?;
            if pieces.len() == begin {
                break;
            }
        }
    }
    Ok(())
}

/// Appends the parts of `piece` beside the box, if the box covers any of it.
fn cut<const D: usize>(
    mut piece: Piece<D>,
    min: &Vector<D>,
    max: &Vector<D>,
    parts: &mut Vec<Piece<D>>,
) -> bool {
    let mut across = (0..D).filter(|axis| *axis != piece.axis);
    if !across.all(|axis| min[axis] < piece.max[axis] && max[axis] > piece.min[axis]) {
        return false;
    }
    for axis in (0..D).filter(|axis| *axis != piece.axis) {
        if piece.min[axis] < min[axis] {
            let mut part = piece;
            part.max[axis] = min[axis];
            piece.min[axis] = min[axis];
            parts.push(part);
        }
        if max[axis] < piece.max[axis] {
            let mut part = piece;
            part.min[axis] = max[axis];
            piece.max[axis] = max[axis];
            parts.push(part);
        }
    }
    true
}

/// The axis along which pieces are merged: the last in their plane.
fn along<const D: usize>(piece: &Piece<D>) -> usize {
    if piece.axis == D - 1 { D - 2 } else { D - 1 }
}

fn compare<const D: usize>(a: &Piece<D>, b: &Piece<D>) -> Ordering {
    let mut order = a.axis.cmp(&b.axis).then(a.sign.cmp(&b.sign));
    order = order.then(a.min[a.axis].total_cmp(&b.min[a.axis]));
    let last = along(a);
    for axis in (0..D).filter(|axis| *axis != a.axis && *axis != last) {
        order = order
            .then(a.min[axis].total_cmp(&b.min[axis]))
            .then(a.max[axis].total_cmp(&b.max[axis]));
    }
    order.then(a.min[last].total_cmp(&b.min[last]))
}

/// Whether `next` lies in the same strip as `piece` and begins no later than that ends.
fn continues<const D: usize>(piece: &Piece<D>, next: &Piece<D>) -> bool {
    let last = along(piece);
    piece.axis == next.axis
        && piece.sign == next.sign
        && (0..D)
            .filter(|axis| *axis != last)
            .all(|axis| piece.min[axis] == next.min[axis] && piece.max[axis] == next.max[axis])
        && next.min[last] <= piece.max[last]
}
