//! Free space as the paper models it (section 2): channels, and the junctions
//! where each meets the next.

use crate::budget::{Budget, Spent};
use crate::geometry::{AxisBox, Direction, HalfSpace, Sign, Vector};
use thiserror::Error;

pub mod graph;
pub mod solids;
pub mod walls;

/// How the last channel is left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End<const D: usize> {
    /// Out of the part, in this direction, which gives the last channel its axis.
    Exit(Direction),
    /// At this point inside it, metres.
    Goal(Vector<D>),
}

/// A junction and the two directions in which it is passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner<const D: usize> {
    /// `J_i`, the common part of two consecutive channels (equation 2.4).
    pub junction: AxisBox<D>,
    /// The direction of travel towards it, along the axis of the channel before.
    pub approach: Direction,
    /// The direction of travel away from it, along the axis of the channel after.
    pub leaving: Direction,
}

/// Why channels do not make a chain. Channels count from 0 in travel order.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ChainError {
    /// There is no channel.
    #[error("there are 0 channels, at least 1 is needed")]
    Empty,
    /// Two consecutive channels have no common interior.
    #[error(
        "channels {first} and {second} do not overlap along coordinate {axis}: one ends at {end}, \
         the other begins at {begin}"
    )]
    Apart {
        /// Index of the earlier channel.
        first: usize,
        /// Index of the later channel.
        second: usize,
        /// The coordinate along which they are apart or only touch.
        axis: usize,
        /// Greatest coordinate of the channel on the lesser side, metres.
        end: f64,
        /// Least coordinate of the channel on the greater side, metres.
        begin: f64,
    },
    /// Two consecutive channels run along the same axis, so that they do not
    /// make an "L", a "T" or a "+".
    #[error("channels {first} and {second} both run along coordinate {axis}")]
    Parallel {
        /// Index of the earlier channel.
        first: usize,
        /// Index of the later channel.
        second: usize,
        /// The axis of both.
        axis: usize,
    },
    /// The budget ended.
    #[error(transparent)]
    Spent(#[from] Spent),
}

/// Channels in travel order (equation 2.3) with their axes and junctions.
///
/// Built again and again in the same memory; empty until built, and after an error.
#[derive(Debug, Clone, Default)]
pub struct Chain<const D: usize> {
    channels: Vec<AxisBox<D>>,
    axes: Vec<usize>,
    /// For every channel the axes it can have, as bits.
    possible: Vec<u8>,
    corners: Vec<Corner<D>>,
    exit: Option<Direction>,
}

impl<const D: usize> Chain<D> {
    /// Makes the junctions of `channels` (equation 2.4) and finds in which
    /// direction each is reached and left.
    ///
    /// The axis of a channel is the coordinate in which a junction is a proper
    /// part of it. Where several qualify, it is the one with the greatest
    /// distance between the centres of the junctions before and after
    /// (at the ends: from `start`, the middle of the body, and to a goal), then
    /// the lowest; where none does (a channel inside its neighbour), all
    /// qualify. An exit gives the last channel its axis. Consecutive channels
    /// never get the same axis; of the candidates only those are considered
    /// that leave all channels before one of their own.
    pub fn build(
        &mut self,
        channels: &[AxisBox<D>],
        start: &Vector<D>,
        end: End<D>,
        budget: &Budget<'_>,
    ) -> Result<(), ChainError> {
        self.clear();
        budget.step(channels.len() as u64)?;
        let result = self.try_build(channels, start, end);
        if result.is_err() {
            self.clear();
        }
        result
    }

    /// The channels, in travel order.
    pub fn channels(&self) -> &[AxisBox<D>] {
        &self.channels
    }

    /// For every channel the coordinate along which it runs.
    pub fn axes(&self) -> &[usize] {
        &self.axes
    }

    /// The junctions, in travel order, one fewer than there are channels.
    pub fn corners(&self) -> &[Corner<D>] {
        &self.corners
    }

    /// The direction in which the last channel is travelled.
    pub fn exit(&self) -> Option<Direction> {
        self.exit
    }

    /// The half-space that ends where the last channel ends along the exit:
    /// what lies outside it is free (definition 3.2, read as the mouth of the
    /// last channel).
    pub fn mouth(&self) -> Option<HalfSpace> {
        Some(mouth_of(self.channels.last()?, self.exit?))
    }

    fn clear(&mut self) {
        self.channels.clear();
        self.axes.clear();
        self.possible.clear();
        self.corners.clear();
        self.exit = None;
    }

    fn try_build(
        &mut self,
        channels: &[AxisBox<D>],
        start: &Vector<D>,
        end: End<D>,
    ) -> Result<(), ChainError> {
        if channels.is_empty() {
            return Err(ChainError::Empty);
        }
        self.channels.extend_from_slice(channels);
        for (first, pair) in channels.windows(2).enumerate() {
            // (2.4)
            let junction =
                pair[0].intersection(&pair[1]).ok_or_else(|| apart(first, &pair[0], &pair[1]))?;
            // Directions follow once the axes are known.
            let unknown = Direction { axis: 0, sign: Sign::Positive };
            self.corners.push(Corner { junction, approach: unknown, leaving: unknown });
        }
        self.find_axes(start, end)?;

        let mut from = *start;
        for index in 0..self.corners.len() {
            let here = self.corners[index].junction.center();
            let approach = towards(&from, &here, self.axes[index]);
            if let Some(before) = index.checked_sub(1) {
                self.corners[before].leaving = approach;
            }
            self.corners[index].approach = approach;
            from = here;
        }
        let exit = match end {
            End::Exit(direction) => direction,
            End::Goal(goal) => towards(&from, &goal, self.axes[channels.len() - 1]),
        };
        if let Some(last) = self.corners.last_mut() {
            last.leaving = exit;
        }
        self.exit = Some(exit);
        Ok(())
    }

    /// Forwards: which axes each channel can have so that all before it have
    /// one of their own. Backwards: the best of these for each.
    fn find_axes(&mut self, start: &Vector<D>, end: End<D>) -> Result<(), ChainError> {
        let last = self.channels.len() - 1;
        let mut before: u8 = 0;
        for index in 0..=last {
            let candidates = match end {
                End::Exit(exit) if index == last => 1 << exit.axis,
                _ => self.candidates(index),
            };
            // With two axes left before, any axis here leaves one of them there.
            let possible = if before.count_ones() <= 1 { candidates & !before } else { candidates };
            if possible == 0 {
                let axis = before.trailing_zeros() as usize;
                return Err(ChainError::Parallel { first: index - 1, second: index, axis });
            }
            self.possible.push(possible);
            before = possible;
        }
        let mut to = match end {
            // Unused: the exit alone decides.
            End::Exit(_) => self.channels[last].center(),
            End::Goal(goal) => goal,
        };
        let mut after = 0;
        self.axes.resize(last + 1, 0);
        for index in (0..=last).rev() {
            let from = match index.checked_sub(1) {
                Some(before) => self.corners[before].junction.center(),
                None => *start,
            };
            let axis = longest(self.possible[index] & !after, &from, &to).unwrap_or(0);
            self.axes[index] = axis;
            after = 1 << axis;
            to = from;
        }
        Ok(())
    }

    /// The coordinates in which a junction is a proper part of the channel, as
    /// bits; all of them where there is none.
    fn candidates(&self, index: usize) -> u8 {
        let channel = &self.channels[index];
        let before = index.checked_sub(1).and_then(|before| self.corners.get(before));
        let after = self.corners.get(index);
        let corners = before.into_iter().chain(after);
        let bits = corners.fold(0, |bits, corner| bits | proper(&corner.junction, channel));
        if bits == 0 { all_axes::<D>() } else { bits }
    }
}

/// The coordinates in which `part` is a proper part of `channel`, as bits.
pub(crate) fn proper<const D: usize>(part: &AxisBox<D>, channel: &AxisBox<D>) -> u8 {
    (0..D).fold(0, |bits, axis| {
        let less = part.min()[axis] > channel.min()[axis] || part.max()[axis] < channel.max()[axis];
        bits | u8::from(less) << axis
    })
}

pub(crate) const fn all_axes<const D: usize>() -> u8 {
    (1 << D) - 1
}

/// Of the axes in `possible` the one along which `from` and `to` are farthest
/// apart, the lowest if several are.
pub(crate) fn longest<const D: usize>(
    possible: u8,
    from: &Vector<D>,
    to: &Vector<D>,
) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for axis in (0..D).filter(|axis| possible >> axis & 1 == 1) {
        let distance = (to[axis] - from[axis]).abs();
        if best.is_none_or(|(_, most)| distance > most) {
            best = Some((axis, distance));
        }
    }
    best.map(|(axis, _)| axis)
}

/// The half-space that ends where a channel ends along `exit`.
pub(crate) fn mouth_of<const D: usize>(channel: &AxisBox<D>, exit: Direction) -> HalfSpace {
    let bound = match exit.sign {
        Sign::Positive => channel.max()[exit.axis],
        Sign::Negative => channel.min()[exit.axis],
    };
    HalfSpace { side: Direction { axis: exit.axis, sign: exit.sign.opposite() }, bound }
}

/// The direction along `axis` that leads from one point to the other.
pub(crate) fn towards<const D: usize>(from: &Vector<D>, to: &Vector<D>, axis: usize) -> Direction {
    Direction { axis, sign: Sign::of(to[axis] - from[axis]) }
}

fn apart<const D: usize>(index: usize, a: &AxisBox<D>, b: &AxisBox<D>) -> ChainError {
    let gap =
        |axis: &usize| a.min()[*axis].max(b.min()[*axis]) - a.max()[*axis].min(b.max()[*axis]);
    // The coordinate along which they are farthest apart says most.
    let axis = (0..D).max_by(|i, j| gap(i).total_cmp(&gap(j)).then(j.cmp(i))).unwrap_or(0);
    ChainError::Apart {
        first: index,
        second: index + 1,
        axis,
        end: a.max()[axis].min(b.max()[axis]),
        begin: a.min()[axis].max(b.min()[axis]),
    }
}

#[cfg(test)]
pub(crate) mod random;
#[cfg(test)]
mod tests;
