//! Disassembly by Table 1, corrected, in two and three dimensions (section 3).
//!
//! Positions are displacements of the body from its assembled state, metres. The table is in
//! `table.rs`; [`disassemble`] applies it junction by junction.

use crate::budget::{Budget, Spent};
use crate::free_space::{Chain, Junction};
use crate::geometry::number::Number;
use crate::geometry::{AxisBox, HalfSpace, Sign, Vector};
use crate::motion::{Curve, Leg, Rule};
pub use shortest_way::{ShortestWay, shortest_way};
use table::{Margin, turn_in};
use thiserror::Error;

mod shortest_way;
mod table;
mod tour;

/// Steps of the budget that the rule for one junction takes.
const STEPS_PER_CHANNEL: u64 = 2;

/// The gap that the body keeps from the sides of a junction (condition 3.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gap<'a, const D: usize> {
    /// One number for every junction and axis, metres.
    Uniform(f64),
    /// One number per axis, metres.
    PerAxis(Vector<D>),
    /// One number per junction, in travel order, and axis, metres.
    PerJunction(&'a [Vector<D>]),
    /// This part, in (0, 1], of the limit in (3.1) at every junction and axis; 1 is [`Gap::Safest`].
    Fraction(f64),
    /// The limit in (3.1) itself: the body in the middle of every junction.
    Safest,
}

/// Why there is no disassembly path. Junctions are counted from 0 in travel order.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum DisassemblyError {
    /// The chain has no channels.
    #[error("there are 0 channels, at least 1 is needed")]
    NoChannels,
    /// The assembled body does not lie in the first channel.
    #[error(
        "the body reaches {} along coordinate {axis}, outside the first channel, which ends at {}",
        Number(*body), Number(*channel)
    )]
    BodyOutside {
        /// The coordinate along which it reaches out.
        axis: usize,
        /// Coordinate of the side that is outside, metres.
        body: f64,
        /// Coordinate of the channel's side there, metres.
        channel: f64,
    },
    /// Condition (2.5) fails; equality is too small.
    #[error(
        "junction {junction} is {} m wide along coordinate {axis}, the body needs more than {} m",
        Number(*has), Number(*needs)
    )]
    JunctionTooSmall {
        /// The junction.
        junction: usize,
        /// The coordinate along which it is too small.
        axis: usize,
        /// The body's extent, metres.
        needs: f64,
        /// The junction's extent, metres.
        has: f64,
    },
    /// Condition (3.1) fails: `least < gap < most` is required.
    #[error(
        "the gap at junction {junction} along coordinate {axis} is {} m, it must be between {} m and {} m",
        Number(*gap), Number(*least), Number(*most)
    )]
    GapOutOfRange {
        /// The junction.
        junction: usize,
        /// The coordinate.
        axis: usize,
        /// The gap asked for, metres.
        gap: f64,
        /// It must be greater than this, metres.
        least: f64,
        /// It must be less than this, metres.
        most: f64,
    },
    /// The number of gaps differs from that of junctions.
    #[error("there are {has} gaps for {needs} junctions")]
    WrongNumberOfGaps {
        /// How many gaps were given.
        has: usize,
        /// How many junctions there are.
        needs: usize,
    },
    /// [`Gap::Fraction`] outside (0, 1].
    #[error(
        "the fraction {} of the greatest gap must be greater than {} and at most {}",
        Number(*fraction), Number(*least), Number(*most)
    )]
    FractionOutOfRange {
        /// The part asked for.
        fraction: f64,
        /// It must be greater than this.
        least: f64,
        /// It must not be greater than this.
        most: f64,
    },
    /// The budget ended.
    #[error(transparent)]
    Spent(#[from] Spent),
}

/// A place as little beside the way out, in parts of the coordinates, is straight ahead.
const STRAIGHT: f64 = 1e-12;

/// A path of translations and the gaps it keeps. Reusable memory for [`disassemble`];
/// unspecified after an error.
#[derive(Debug, Clone, Default)]
pub struct DisassemblyPath<const D: usize> {
    limits: Vec<Vector<D>>,
    gaps: Vec<Vector<D>>,
    legs: Vec<Leg<D>>,
    length: f64,
}

impl<const D: usize> DisassemblyPath<D> {
    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        let vectors = self.limits.capacity() + self.gaps.capacity();
        vectors * size_of::<Vector<D>>() + self.legs.capacity() * size_of::<Leg<D>>()
    }

    /// The limit in (3.1) per junction and axis, metres.
    pub fn limits(&self) -> &[Vector<D>] {
        &self.limits
    }

    /// The gap per junction and axis, metres; in the order of disassembly even after
    /// [`DisassemblyPath::reverse`].
    pub fn gaps(&self) -> &[Vector<D>] {
        &self.gaps
    }

    /// The legs: lines, and arcs where corners are rounded.
    pub fn legs(&self) -> &[Leg<D>] {
        &self.legs
    }

    /// Length of the whole path, metres.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The path through these displacements, the first of which is where it begins, found without
    /// rules.
    pub fn set_way(&mut self, way: &[Vector<D>]) {
        self.limits.clear();
        self.gaps.clear();
        self.legs.clear();
        self.legs.extend(way.windows(2).map(|ends| without_rule(ends[0], ends[1])));
        self.measure();
    }

    /// Goes on to a place beyond the mouth: straight on where that is ahead along `axis`, the
    /// exit's, otherwise by a leg of its own.
    pub fn go_on(&mut self, to: Vector<D>, axis: usize) {
        let Some(Leg { curve: Curve::Line { to: out, .. }, .. }) = self.legs.last_mut() else {
            return;
        };
        let rounding = STRAIGHT * out.amax().max(to.amax());
        if (0..D).all(|other| other == axis || (out[other] - to[other]).abs() <= rounding) {
            *out = to;
        } else {
            let from = *out;
            self.legs.push(without_rule(from, to));
        }
        self.measure();
    }

    /// Takes other legs between the same ends.
    pub fn set_legs(&mut self, legs: &[Leg<D>]) {
        self.legs.clear();
        self.legs.extend_from_slice(legs);
        self.measure();
    }

    /// Finds the length from the legs.
    fn measure(&mut self) {
        self.length = self.legs.iter().map(|leg| leg.curve.length()).sum();
    }

    /// Turns disassembly into assembly and back: the same way-points in reverse
    /// order, bit for bit. Rule and junction stay with their leg.
    pub fn reverse(&mut self) {
        self.legs.reverse();
        for leg in &mut self.legs {
            leg.curve = leg.curve.reversed();
        }
    }
}

fn without_rule<const D: usize>(from: Vector<D>, to: Vector<D>) -> Leg<D> {
    Leg { curve: Curve::translation(from, to), junction: None, rule: None, rung: None }
}

/// Finds the path of `body` (its bounding box in the assembled state) through `chain`, built
/// from the body's centre to an exit: into every junction by its rule of Table 1, then out
/// along the exit until the last side of the body is at the mouth (definition 3.2). In its only
/// channel a body may stick out of the mouth.
///
/// ```
/// use planning::budget::Budget;
/// use planning::disassembly::{DisassemblyPath, Gap, disassemble};
/// use planning::free_space::{Chain, End};
/// use planning::geometry::{AxisBox, Direction, Sign, Vector};
///
/// // Section 4's male part and channels, in (x, z), with a gap of 0.2 m.
/// let space = |min: [f64; 2], max: [f64; 2]| AxisBox::new(min.into(), max.into());
/// let male = space([4.5, 1.01], [6.99, 4.0])?;
/// let channels = [
///     space([4.0, 1.0], [7.0, 6.0])?,
///     space([1.0, 2.0], [7.0, 6.0])?,
///     space([1.0, 2.0], [5.0, 7.0])?,
/// ];
/// let (up, budget) = (Direction { axis: 1, sign: Sign::Positive }, Budget::default());
/// let (mut chain, mut path) = (Chain::default(), DisassemblyPath::default());
/// chain.build(&channels, &male.center(), End::Exit(up), &budget)?;
/// disassemble(&chain, &male, Gap::Uniform(0.2), &mut path, &budget)?;
///
/// // Rule 1 (up, then left), rule 3 (left, then up), and out.
/// let rules: Vec<_> = path.legs().iter().map(|leg| leg.rule.map(|rule| rule.number)).collect();
/// assert_eq!(rules, [Some(1), Some(3), None]);
/// // m1 runs from (4.5, 1.01) by (4.2, 2.2) and (2.31, 2.81) to (2.31, 7).
/// let m1 = Vector::from([4.5, 1.01]) + path.legs()[1].curve.end();
/// assert!((m1 - Vector::from([2.31, 2.81])).norm() < 1e-14);
/// assert!((path.length() - 7.40323366632768).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn disassemble<const D: usize>(
    chain: &Chain<D>,
    body: &AxisBox<D>,
    gap: Gap<'_, D>,
    path: &mut DisassemblyPath<D>,
    budget: &Budget<'_>,
) -> Result<(), DisassemblyError> {
    budget.step(STEPS_PER_CHANNEL * chain.channels().len() as u64)?;
    let (Some(first), Some(mouth)) = (chain.channels().first(), chain.mouth()) else {
        return Err(DisassemblyError::NoChannels);
    };
    check_inside(first, &up_to_the_mouth(chain, &mouth, body))?;
    find_limits(chain, body, &mut path.limits)?;
    find_gaps(gap, &path.limits, &mut path.gaps)?;

    path.legs.clear();
    let centered = matches!(gap, Gap::Safest) || gap == Gap::Fraction(1.0);
    let mut from = Vector::zeros();
    for (index, (junction, gap)) in chain.junctions().iter().zip(&path.gaps).enumerate() {
        let gap = if centered { None } else { Some(gap) };
        let (to, rule) = target(junction, (&body.min(), &body.max()), gap, &from);
        let curve = Curve::translation(from, to);
        path.legs.push(Leg { curve, junction: Some(index), rule: Some(rule), rung: None });
        from = to;
    }
    let to = out_of_the_mouth((&body.min(), &body.max()), &mouth, from);
    path.legs.push(Leg {
        curve: Curve::translation(from, to),
        junction: None,
        rule: None,
        rung: None,
    });
    path.measure();
    Ok(())
}

/// Where the rule for a junction puts a body that comes from the displacement `from`, and the
/// rule. The body is given by its least and greatest corner in the assembled state; `gap`
/// is `None` for the limit in (3.1).
pub(crate) fn target<const D: usize>(
    junction: &Junction<D>,
    (body_min, body_max): (&Vector<D>, &Vector<D>),
    gap: Option<&Vector<D>>,
    from: &Vector<D>,
) -> (Vector<D>, Rule) {
    let turn = turn_in::<D>(junction.approach, junction.leaving);
    let space = &junction.space;
    let Some(gap) = gap else {
        // At the limit in (3.1) both margins mean the middle. Computed directly, it does not
        // suffer from rounding, and legs along an axis stay exactly so.
        return (space.center() - (body_min + body_max) / 2.0, turn.rule);
    };
    let mut to = *from;
    for axis in 0..D {
        // (3.3), from the assembled state: the body's least side at the least margin, or its
        // greatest side at the greatest margin.
        let least = space.min()[axis] + gap[axis] - body_min[axis];
        let greatest = space.max()[axis] - gap[axis] - body_max[axis];
        to[axis] = if axis == turn.horizontal.0 {
            turn.horizontal.1.choose(least, greatest)
        } else if axis == turn.vertical.0 {
            turn.vertical.1.choose(least, greatest)
        } else {
            // The idle axis in three dimensions: any value between is as safe, so hold.
            from[axis].min(greatest).max(least)
        };
    }
    (to, turn.rule)
}

impl Margin {
    /// The displacement for this margin.
    fn choose(self, least: f64, greatest: f64) -> f64 {
        match self {
            Self::Least => least,
            Self::Greatest => greatest,
        }
    }
}

/// Definition 3.2 with equality: the last side of the body exactly at the mouth, or where it is
/// if that is beyond.
pub(crate) fn out_of_the_mouth<const D: usize>(
    (body_min, body_max): (&Vector<D>, &Vector<D>),
    mouth: &HalfSpace,
    from: Vector<D>,
) -> Vector<D> {
    let axis = mouth.side.axis;
    let last_side = match mouth.side.sign {
        Sign::Negative => body_min[axis],
        Sign::Positive => body_max[axis],
    };
    let mut to = from;
    let out = mouth.bound - last_side;
    to[axis] = match mouth.side.sign {
        Sign::Negative => out.max(from[axis]),
        Sign::Positive => out.min(from[axis]),
    };
    to
}

/// The corners of the body, or in the only channel those of what does not stick out of the mouth:
/// beyond it everything is free.
fn up_to_the_mouth<const D: usize>(
    chain: &Chain<D>,
    mouth: &HalfSpace,
    body: &AxisBox<D>,
) -> [Vector<D>; 2] {
    let corners = [body.min(), body.max()];
    if let [_] = chain.channels() { corners.map(|corner| mouth.nearest(corner)) } else { corners }
}

fn check_inside<const D: usize>(
    channel: &AxisBox<D>,
    [least, greatest]: &[Vector<D>; 2],
) -> Result<(), DisassemblyError> {
    for axis in 0..D {
        if least[axis] < channel.min()[axis] {
            let (body, channel) = (least[axis], channel.min()[axis]);
            return Err(DisassemblyError::BodyOutside { axis, body, channel });
        }
        if greatest[axis] > channel.max()[axis] {
            let (body, channel) = (greatest[axis], channel.max()[axis]);
            return Err(DisassemblyError::BodyOutside { axis, body, channel });
        }
    }
    Ok(())
}

/// Checks condition (2.5) and computes the limit in (3.1): half of the junction's extent
/// beyond the body's.
fn find_limits<const D: usize>(
    chain: &Chain<D>,
    body: &AxisBox<D>,
    limits: &mut Vec<Vector<D>>,
) -> Result<(), DisassemblyError> {
    let size = body.size();
    limits.clear();
    for (index, junction) in chain.junctions().iter().enumerate() {
        let space = junction.space.size();
        for axis in 0..D {
            let (needs, has) = (size[axis], space[axis]);
            // (2.5)
            if has <= needs {
                return Err(DisassemblyError::JunctionTooSmall {
                    junction: index,
                    axis,
                    needs,
                    has,
                });
            }
        }
        limits.push((space - size) / 2.0);
    }
    Ok(())
}

fn find_gaps<const D: usize>(
    gap: Gap<'_, D>,
    limits: &[Vector<D>],
    gaps: &mut Vec<Vector<D>>,
) -> Result<(), DisassemblyError> {
    gaps.clear();
    match gap {
        Gap::Uniform(gap) => gaps.resize(limits.len(), Vector::repeat(gap)),
        Gap::PerAxis(gap) => gaps.resize(limits.len(), gap),
        Gap::PerJunction(given) if given.len() != limits.len() => {
            let (has, needs) = (given.len(), limits.len());
            return Err(DisassemblyError::WrongNumberOfGaps { has, needs });
        }
        Gap::PerJunction(given) => gaps.extend_from_slice(given),
        Gap::Fraction(fraction) => {
            if !(fraction > 0.0 && fraction <= 1.0) {
                let (least, most) = (0.0, 1.0);
                return Err(DisassemblyError::FractionOutOfRange { fraction, least, most });
            }
            gaps.extend(limits.iter().map(|limit| limit * fraction));
            return Ok(());
        }
        Gap::Safest => {
            gaps.extend_from_slice(limits);
            return Ok(());
        }
    }
    for (junction, (gap, limit)) in gaps.iter().zip(limits).enumerate() {
        for axis in 0..D {
            let (gap, least, most) = (gap[axis], 0.0, limit[axis]);
            // (3.1)
            if !(least < gap && gap < most) {
                return Err(DisassemblyError::GapOutOfRange { junction, axis, gap, least, most });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
