//! Free space as the paper models it (section 2): channels, and the junctions where one
//! meets the next.
//!
//! [`walls`] is what a body must not touch, [`solids`] finds the channels that solids leave
//! free, and [`graph`] knows which channels meet.

use crate::budget::{Budget, Spent};
use crate::geometry::number::Number;
use crate::geometry::{AxisBox, Direction, HalfSpace, Sign, Vector};
use thiserror::Error;

pub mod floor;
pub mod graph;
pub mod solids;
pub mod walls;

/// Steps of the budget that finding the junction and the axis of one channel takes.
const STEPS_PER_CHANNEL: u64 = 2;

/// How the last channel is left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End<const D: usize> {
    /// Out of the part, in this direction, which gives the last channel its axis.
    Exit(Direction),
    /// At this point inside the last channel, metres.
    Goal(Vector<D>),
}

/// A junction and the two directions in which it is passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Junction<const D: usize> {
    /// `J_i`, the common part of two consecutive channels (equation 2.4).
    pub space: AxisBox<D>,
    /// The direction of travel towards it, along the axis of the channel before.
    pub approach: Direction,
    /// The direction of travel away from it, along the axis of the channel after.
    pub leaving: Direction,
}

/// Why channels make no chain. Channels are counted from 0 in travel order.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ChainError {
    /// There are no channels.
    #[error("there are 0 channels, at least 1 is needed")]
    Empty,
    /// Two consecutive channels have no interior in common.
    #[error(
        "channels {first} and {second} do not overlap along coordinate {axis}: one ends at {}, \
         the other begins at {}",
        Number(*end), Number(*begin)
    )]
    Apart {
        /// Index of the earlier channel.
        first: usize,
        /// Index of the later channel.
        second: usize,
        /// The coordinate along which they are apart or just touch.
        axis: usize,
        /// Greatest coordinate of the lower channel, metres.
        end: f64,
        /// Least coordinate of the upper channel, metres.
        begin: f64,
    },
    /// Two consecutive channels run along the same axis: they form no "L", "T" or "+".
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

/// Channels in travel order (equation 2.3) with their axes and junctions. Reusable memory;
/// empty until built, and after an error.
///
/// ```
/// use planning::budget::Budget;
/// use planning::free_space::{Chain, End};
/// use planning::geometry::{AxisBox, Direction, Sign};
///
/// // Section 4: C_3, C_2, C_1 in (x, z); the exit is up.
/// let channel = |min: [f64; 2], max: [f64; 2]| AxisBox::new(min.into(), max.into());
/// let channels = [
///     channel([4.0, 1.0], [7.0, 6.0])?,
///     channel([1.0, 2.0], [7.0, 6.0])?,
///     channel([1.0, 2.0], [5.0, 7.0])?,
/// ];
/// let up = Direction { axis: 1, sign: Sign::Positive };
/// let mut chain = Chain::default();
/// chain.build(&channels, &[5.745, 2.505].into(), End::Exit(up), &Budget::default())?;
/// // Up, to the left, and up.
/// assert_eq!(chain.axes(), [1, 0, 1]);
/// assert_eq!(chain.junctions()[0].leaving, Direction { axis: 0, sign: Sign::Negative });
/// assert_eq!(chain.mouth().expect("there is an exit").bound, 7.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Chain<const D: usize> {
    channels: Vec<AxisBox<D>>,
    axes: Vec<usize>,
    /// The possible axes of every channel, as bits.
    possible: Vec<u8>,
    junctions: Vec<Junction<D>>,
    exit: Option<Direction>,
    /// Where the walls end, if the last channel reaches farther.
    mouth: Option<HalfSpace>,
}

impl<const D: usize> Chain<D> {
    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        self.channels.capacity() * size_of::<AxisBox<D>>()
            + self.axes.capacity() * size_of::<usize>()
            + self.possible.capacity()
            + self.junctions.capacity() * size_of::<Junction<D>>()
    }

    /// Makes the junctions of `channels` (equation 2.4) and finds the directions in which
    /// each is entered and left.
    ///
    /// The axis of a channel is the coordinate in which a junction is a proper part of it. If
    /// several qualify, it is the one along which the centres of the junctions before and
    /// after are farthest apart (at the ends: `start`, the centre of the body, and a goal),
    /// then the lowest; if none does (a channel inside its neighbour), all qualify. An exit
    /// gives the last channel its axis. Consecutive channels never have the same axis; only
    /// candidates that leave an axis to every channel before are considered.
    pub fn build(
        &mut self,
        channels: &[AxisBox<D>],
        start: &Vector<D>,
        end: End<D>,
        budget: &Budget<'_>,
    ) -> Result<(), ChainError> {
        self.clear();
        budget.step(STEPS_PER_CHANNEL * channels.len() as u64)?;
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

    /// The axis of every channel, in travel order.
    pub fn axes(&self) -> &[usize] {
        &self.axes
    }

    /// The junctions, in travel order, one fewer than there are channels.
    pub fn junctions(&self) -> &[Junction<D>] {
        &self.junctions
    }

    /// The direction in which the last channel is travelled.
    pub fn exit(&self) -> Option<Direction> {
        self.exit
    }

    /// The half-space up to where the last channel ends along the exit, or to the mouth in it
    /// (definition 3.2, read as the mouth of the last channel).
    pub fn mouth(&self) -> Option<HalfSpace> {
        self.mouth.or_else(|| Some(mouth_of(self.channels.last()?, self.exit?)))
    }

    /// The mouth and the channel that ends there, for a body that goes on beyond it by `reach`,
    /// metres.
    pub fn mouth_and_channel(&self, reach: f64) -> Option<Mouth<D>> {
        Some(Mouth { plane: self.mouth()?, channel: *self.channels.last()?, reach })
    }

    /// Puts the mouth into the last channel, which goes on beyond the walls: a body that sticks
    /// out of them needs a channel that holds it.
    pub fn set_mouth(&mut self, mouth: HalfSpace) {
        self.mouth = Some(mouth);
    }

    fn clear(&mut self) {
        self.channels.clear();
        self.axes.clear();
        self.possible.clear();
        self.junctions.clear();
        (self.exit, self.mouth) = (None, None);
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
            let space =
                pair[0].intersection(&pair[1]).ok_or_else(|| apart(first, &pair[0], &pair[1]))?;
            // Directions follow once the axes are known.
            let unknown = Direction { axis: 0, sign: Sign::Positive };
            self.junctions.push(Junction { space, approach: unknown, leaving: unknown });
        }
        self.find_axes(start, end)?;

        let mut from = *start;
        for index in 0..self.junctions.len() {
            let here = self.junctions[index].space.center();
            let approach = towards(&from, &here, self.axes[index]);
            if let Some(before) = index.checked_sub(1) {
                self.junctions[before].leaving = approach;
            }
            self.junctions[index].approach = approach;
            from = here;
        }
        let exit = match end {
            End::Exit(direction) => direction,
            End::Goal(goal) => towards(&from, &goal, self.axes[channels.len() - 1]),
        };
        if let Some(last) = self.junctions.last_mut() {
            last.leaving = exit;
        }
        self.exit = Some(exit);
        Ok(())
    }

    /// Forwards: the axes that each channel can have so that one is left to all before it.
    /// Backwards: the best of these for each.
    fn find_axes(&mut self, start: &Vector<D>, end: End<D>) -> Result<(), ChainError> {
        let last = self.channels.len() - 1;
        let mut before: u8 = 0;
        for index in 0..=last {
            let candidates = match end {
                End::Exit(exit) if index == last => 1 << exit.axis,
                _ => self.candidates(index),
            };
            // If the channel before has two axes left, any axis here leaves it one.
            let possible = if before.count_ones() <= 1 { candidates & !before } else { candidates };
            if possible == 0 {
                let axis = before.trailing_zeros() as usize;
                return Err(ChainError::Parallel { first: index - 1, second: index, axis });
            }
            self.possible.push(possible);
            before = possible;
        }
        let mut to = match end {
            // Not used: the exit alone decides.
            End::Exit(_) => self.channels[last].center(),
            End::Goal(goal) => goal,
        };
        let mut after = 0;
        self.axes.resize(last + 1, 0);
        for index in (0..=last).rev() {
            let from = match index.checked_sub(1) {
                Some(before) => self.junctions[before].space.center(),
                None => *start,
            };
            let axis = longest(self.possible[index] & !after, &from, &to).unwrap_or(0);
            self.axes[index] = axis;
            after = 1 << axis;
            to = from;
        }
        Ok(())
    }

    /// The coordinates in which a junction is a proper part of the channel, as bits; all of
    /// them if there are none.
    fn candidates(&self, index: usize) -> u8 {
        let channel = &self.channels[index];
        let before = index.checked_sub(1).and_then(|before| self.junctions.get(before));
        let after = self.junctions.get(index);
        let junctions = before.into_iter().chain(after);
        let bits = junctions.fold(0, |bits, junction| bits | proper(&junction.space, channel));
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

/// The axis in `possible` along which `from` and `to` are farthest apart, the lowest of
/// equals.
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

/// Where a body leaves the last of the channels. If these are all that is known to be free, what
/// is free beyond is the strip that goes on from that channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mouth<const D: usize> {
    /// The half-space before the mouth.
    pub plane: HalfSpace,
    /// The channel that ends there.
    pub channel: AxisBox<D>,
    /// How far the body goes on beyond the mouth with its last side, metres. As long as that is at
    /// the mouth, the sides of the strip are no nearer than those of the channel.
    pub reach: f64,
}

impl<const D: usize> Mouth<D> {
    /// The least and the greatest corner of the strip, which has no end.
    fn strip(&self) -> (Vector<D>, Vector<D>) {
        self.strip_for(f64::INFINITY)
    }

    /// The part of it of which the sides matter.
    fn strip_in_reach(&self) -> Option<(Vector<D>, Vector<D>)> {
        (self.reach > 0.0).then(|| self.strip_for(self.reach))
    }

    fn strip_for(&self, length: f64) -> (Vector<D>, Vector<D>) {
        let HalfSpace { side: Direction { axis, sign }, bound } = self.plane;
        let (mut min, mut max) = (self.channel.min(), self.channel.max());
        (min[axis], max[axis]) = match sign {
            Sign::Negative => (bound, bound + length),
            Sign::Positive => (bound - length, bound),
        };
        (min, max)
    }
}

/// The half-space up to where a channel ends along `exit`.
pub fn mouth_of<const D: usize>(channel: &AxisBox<D>, exit: Direction) -> HalfSpace {
    let bound = match exit.sign {
        Sign::Positive => channel.max()[exit.axis],
        Sign::Negative => channel.min()[exit.axis],
    };
    HalfSpace { side: Direction { axis: exit.axis, sign: exit.sign.opposite() }, bound }
}

/// The direction along `axis` from one point to the other.
pub(crate) fn towards<const D: usize>(from: &Vector<D>, to: &Vector<D>, axis: usize) -> Direction {
    Direction { axis, sign: Sign::of(to[axis] - from[axis]) }
}

fn apart<const D: usize>(index: usize, a: &AxisBox<D>, b: &AxisBox<D>) -> ChainError {
    let gap =
        |axis: &usize| a.min()[*axis].max(b.min()[*axis]) - a.max()[*axis].min(b.max()[*axis]);
    // Report the coordinate along which they are farthest apart.
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
