//! Disassembly paths by table 1, corrected, in two and three dimensions
//! (section 3).
//!
//! Positions are displacements of the body from its assembled state, metres.

use crate::budget::{Budget, Spent};
use crate::free_space::{Chain, Corner};
use crate::geometry::{AxisBox, HalfSpace, Sign, Vector};
use crate::motion::{Curve, Leg, Rule};
use table::{Margin, turn_in};
use thiserror::Error;

mod table;

/// The gap that the body keeps to the sides of a junction (condition 3.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gap<'a, const D: usize> {
    /// One number for every junction and axis, metres.
    Uniform(f64),
    /// One number per axis, metres.
    PerAxis(Vector<D>),
    /// One number per junction, in travel order, and axis, metres.
    PerJunction(&'a [Vector<D>]),
    /// This part, in (0, 1], of the limit of (3.1) at every junction and axis; 1 is [`Gap::Safest`].
    Fraction(f64),
    /// The limit of (3.1) itself: the body in the middle of every junction.
    Safest,
}

/// Why there is no disassembly path. Junctions count from 0 in travel order.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum DisassemblyError {
    /// The chain holds no channel.
    #[error("there are 0 channels, at least 1 is needed")]
    NoChannels,
    /// The assembled body does not lie in the first channel.
    #[error(
        "the body reaches {body} along coordinate {axis}, outside the first channel, which ends at {channel}"
    )]
    BodyOutside {
        /// The coordinate concerned.
        axis: usize,
        /// Coordinate of the body's side that is outside, metres.
        body: f64,
        /// Coordinate of the channel's side that it passes, metres.
        channel: f64,
    },
    /// Condition (2.5) fails; equality counts.
    #[error(
        "junction {junction} is {has} m wide along coordinate {axis}, the body needs more than {needs} m"
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
        "the gap {gap} m at junction {junction} along coordinate {axis} is not between {least} m and {most} m"
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
    /// Not one gap per junction.
    #[error("there are {has} gaps for {needs} junctions")]
    WrongNumberOfGaps {
        /// How many gaps were given.
        has: usize,
        /// How many junctions there are.
        needs: usize,
    },
    /// [`Gap::Fraction`] outside (0, 1].
    #[error("the part {fraction} of the greatest gap is not in ({least}, {most}]")]
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

/// A path of translations, with the gaps it keeps. Reusable memory for
/// [`disassemble`]; what it holds after an error is of no meaning.
#[derive(Debug, Clone, Default)]
pub struct Path<const D: usize> {
    limits: Vec<Vector<D>>,
    gaps: Vec<Vector<D>>,
    legs: Vec<Leg<D>>,
    length: f64,
}

impl<const D: usize> Path<D> {
    /// The limit of (3.1) per junction and axis, metres.
    pub fn limits(&self) -> &[Vector<D>] {
        &self.limits
    }

    /// The gap used per junction and axis, metres; in the order of disassembly
    /// also after [`Path::reverse`].
    pub fn gaps(&self) -> &[Vector<D>] {
        &self.gaps
    }

    /// The legs, all of them lines.
    pub fn legs(&self) -> &[Leg<D>] {
        &self.legs
    }

    /// Length of the whole path, metres.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Turns disassembly into assembly and back: the same way-points in reverse
    /// order, bit for bit. Rule and junction stay with their leg.
    pub fn reverse(&mut self) {
        self.legs.reverse();
        for leg in &mut self.legs {
            leg.curve = leg.curve.reversed().unwrap_or(leg.curve);
        }
    }
}

/// Finds the path of `body` (its bounding box in the assembled state) through
/// `chain`, built from the body's centre to an exit: into every junction by the
/// rule of table 1 that applies, then out along the exit until the body's least
/// coordinate along it is at the mouth (definition 3.2).
pub fn disassemble<const D: usize>(
    chain: &Chain<D>,
    body: &AxisBox<D>,
    gap: Gap<'_, D>,
    path: &mut Path<D>,
    budget: &Budget<'_>,
) -> Result<(), DisassemblyError> {
    budget.step(chain.channels().len() as u64)?;
    let (Some(first), Some(mouth)) = (chain.channels().first(), chain.mouth()) else {
        return Err(DisassemblyError::NoChannels);
    };
    check_inside(first, body)?;
    find_limits(chain, body, &mut path.limits)?;
    find_gaps(gap, &path.limits, &mut path.gaps)?;

    path.legs.clear();
    let centered = matches!(gap, Gap::Safest) || gap == Gap::Fraction(1.0);
    let mut from = Vector::zeros();
    for (index, (corner, gap)) in chain.corners().iter().zip(&path.gaps).enumerate() {
        let gap = if centered { None } else { Some(gap) };
        let (to, rule) = target(corner, (&body.min(), &body.max()), gap, &from);
        let (junction, rule) = (Some(index), Some(rule));
        path.legs.push(Leg { curve: Curve::translation(from, to), junction, rule });
        from = to;
    }
    let to = out_of_the_mouth((&body.min(), &body.max()), &mouth, from);
    path.legs.push(Leg { curve: Curve::translation(from, to), junction: None, rule: None });
    path.length = path.legs.iter().map(|leg| leg.curve.length()).sum();
    Ok(())
}

/// Where the rule for a corner puts a body that comes from the displacement `from`,
/// given its least and greatest corner in the assembled state, and the rule.
/// `gap` is `None` at the limit of (3.1).
pub(crate) fn target<const D: usize>(
    corner: &Corner<D>,
    (body_min, body_max): (&Vector<D>, &Vector<D>),
    gap: Option<&Vector<D>>,
    from: &Vector<D>,
) -> (Vector<D>, Rule) {
    let turn = turn_in::<D>(corner.approach, corner.leaving);
    let junction = &corner.junction;
    let Some(gap) = gap else {
        // At the limit of (3.1) both margins mean the middle, said without
        // rounding, so that legs along an axis stay exactly so.
        return (junction.center() - (body_min + body_max) / 2.0, turn.rule);
    };
    let mut to = *from;
    for axis in 0..D {
        // (3.3), from the assembled state: where the body's least side is
        // at the least margin, and its greatest side at the greatest one.
        let least = junction.min()[axis] + gap[axis] - body_min[axis];
        let greatest = junction.max()[axis] - gap[axis] - body_max[axis];
        to[axis] = if axis == turn.horizontal.0 {
            turn.horizontal.1.choose(least, greatest)
        } else if axis == turn.vertical.0 {
            turn.vertical.1.choose(least, greatest)
        } else {
            // Idle in three dimensions: any value between is as safe; hold.
            from[axis].min(greatest).max(least)
        };
    }
    (to, turn.rule)
}

impl Margin {
    /// The displacement that this margin asks for.
    fn choose(self, least: f64, greatest: f64) -> f64 {
        match self {
            Self::Least => least,
            Self::Greatest => greatest,
        }
    }
}

/// Definition 3.2, closed: the body's last side exactly at the mouth.
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
    to[axis] = mouth.bound - last_side;
    to
}

fn check_inside<const D: usize>(
    channel: &AxisBox<D>,
    body: &AxisBox<D>,
) -> Result<(), DisassemblyError> {
    for axis in 0..D {
        if body.min()[axis] < channel.min()[axis] {
            let (body, channel) = (body.min()[axis], channel.min()[axis]);
            return Err(DisassemblyError::BodyOutside { axis, body, channel });
        }
        if body.max()[axis] > channel.max()[axis] {
            let (body, channel) = (body.max()[axis], channel.max()[axis]);
            return Err(DisassemblyError::BodyOutside { axis, body, channel });
        }
    }
    Ok(())
}

/// Condition (2.5), and the limit of (3.1): half of what a junction is larger
/// than the body.
fn find_limits<const D: usize>(
    chain: &Chain<D>,
    body: &AxisBox<D>,
    limits: &mut Vec<Vector<D>>,
) -> Result<(), DisassemblyError> {
    let size = body.size();
    limits.clear();
    for (junction, corner) in chain.corners().iter().enumerate() {
        let space = corner.junction.size();
        for axis in 0..D {
            let (needs, has) = (size[axis], space[axis]);
            // (2.5)
            if has <= needs {
                return Err(DisassemblyError::JunctionTooSmall { junction, axis, needs, has });
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
