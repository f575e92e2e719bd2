//! The shortest way through the junctions of a path by the rules.

use super::tour::{Gate, Tour, shortest_tour};
use super::{DisassemblyPath, out_of_the_mouth};
use crate::budget::{Budget, Spent};
use crate::free_space::Chain;
use crate::geometry::{AxisBox, Vector};
use crate::motion::{Curve, Leg};

/// Lengths that differ by no more than this part of the scene's extent are the same.
const ROUNDING: f64 = 1e-12;

/// The shortest way, and what none is shorter than.
#[derive(Debug, Clone, PartialEq)]
pub struct ShortestWay<const D: usize> {
    /// Those of the path by the rules, where that is the shortest.
    pub legs: Vec<Leg<D>>,
    /// No way through the same junctions that keeps the gap in each is shorter than this, metres. It is
    /// the length of these legs but for rounding.
    pub bound: f64,
}

/// Finds the shortest of all ways of `body` that keep in each junction of `chain` the gap that `path`
/// keeps there, by the rules; and goes on to a goal beyond the mouth, if there is one, as `path` does.
///
/// A way through these channels that keeps the gap from their sides passes the junctions in order, in
/// each of them at a displacement in a box ((3.1) leaves it an interior); and the straight lines
/// between such displacements keep it as well (lemma 1 of `docs/method.md`). So it is the shortest way
/// through boxes in order, a convex problem. What is found is proved by the bound, which follows from
/// directions alone.
///
/// ```
/// use planning::budget::Budget;
/// use planning::disassembly::{DisassemblyPath, Gap, disassemble, shortest_way};
/// use planning::free_space::{Chain, End};
/// use planning::geometry::{AxisBox, Direction, Sign};
///
/// // A cube 0.1 m beside the wall that it is to keep 1 m from. By the rules it comes away from that
/// // wall and goes around the corner; the shortest way leads along the lower side of the junction.
/// let space = |min: [f64; 2], max: [f64; 2]| AxisBox::new(min.into(), max.into());
/// let body = space([0.1, 1.0], [1.1, 2.0])?;
/// let channels = [space([0.0, 0.0], [6.0, 9.0])?, space([0.0, 5.0], [20.0, 9.0])?];
/// let (right, budget) = (Direction { axis: 0, sign: Sign::Positive }, Budget::default());
/// let (mut chain, mut path) = (Chain::default(), DisassemblyPath::default());
/// chain.build(&channels, &body.center(), End::Exit(right), &budget)?;
/// disassemble(&chain, &body, Gap::Uniform(1.0), &mut path, &budget)?;
/// let way = shortest_way(&chain, &body, None, &path, &budget)?;
/// assert!(way.bound <= path.length());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn shortest_way<const D: usize>(
    chain: &Chain<D>,
    body: &AxisBox<D>,
    goal: Option<&Vector<D>>,
    path: &DisassemblyPath<D>,
    budget: &Budget<'_>,
) -> Result<ShortestWay<D>, Spent> {
    let start = Vector::zeros();
    let gates = gates(chain, body, goal, path);
    let Tour { mut bends, bound } = shortest_tour(&start, &gates, budget)?;
    let last = bends.len().checked_sub(2).map_or(start, |before| bends[before].1);
    if let (Some((_, end)), Some(mouth), None) = (bends.last_mut(), chain.mouth(), goal) {
        // Straight out.
        let out = end[mouth.side.axis];
        *end = last;
        end[mouth.side.axis] = out;
    }
    let mut legs = Vec::with_capacity(bends.len());
    let mut from = start;
    for (gate, to) in bends {
        let junction = (gate < chain.junctions().len()).then_some(gate);
        legs.push(Leg { curve: Curve::translation(from, to), junction, rule: None, rung: None });
        from = to;
    }
    let length: f64 = legs.iter().map(|leg| leg.curve.length()).sum();
    let extent = path.legs().iter().map(|leg| leg.curve.end().amax()).fold(0.0, f64::max);
    if path.length() <= length + ROUNDING * extent {
        legs.clear();
        legs.extend_from_slice(path.legs());
    }
    Ok(ShortestWay { bound: rounded(bound, path.length().min(length), ROUNDING * extent), legs })
}

/// The bound, or the length that it proves to be the least but for rounding.
fn rounded(bound: f64, length: f64, rounding: f64) -> f64 {
    if bound >= length - rounding { length } else { bound }
}

/// The boxes of displacements that a way passes: in each junction, at the mouth, and the goal.
fn gates<const D: usize>(
    chain: &Chain<D>,
    body: &AxisBox<D>,
    goal: Option<&Vector<D>>,
    path: &DisassemblyPath<D>,
) -> Vec<Gate<D>> {
    let (least, greatest) = (body.min(), body.max());
    let within = |space: &AxisBox<D>, gap: &Vector<D>, at: &Vector<D>| {
        let (mut min, mut max) = (space.min() + gap - least, space.max() - gap - greatest);
        for axis in 0..D {
            // At the limit in (3.1) nothing is left but the middle.
            if min[axis].partial_cmp(&max[axis]) != Some(std::cmp::Ordering::Less) {
                (min[axis], max[axis]) = (at[axis], at[axis]);
            }
        }
        Gate { min, max }
    };
    let mut gates = Vec::with_capacity(chain.junctions().len() + 2);
    let mut from = Vector::zeros();
    let targets = chain.junctions().iter().zip(path.gaps()).zip(path.legs());
    for ((junction, gap), leg) in targets {
        from = leg.curve.end();
        gates.push(within(&junction.space, gap, &from));
    }
    if let (Some(mouth), Some(channel)) = (chain.mouth(), chain.channels().last()) {
        let gap = path.gaps().last().copied().unwrap_or_else(Vector::zeros);
        let mut gate = within(channel, &gap, &from);
        (gate.min, gate.max) = (gate.min.inf(&from), gate.max.sup(&from));
        let axis = mouth.side.axis;
        let out = out_of_the_mouth((&least, &greatest), &mouth, from)[axis];
        (gate.min[axis], gate.max[axis]) = (out, out);
        gates.push(gate);
    }
    gates.extend(goal.map(|goal| Gate { min: *goal, max: *goal }));
    gates
}
