//! Which channels a motion travels.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::budget::{Budget, Held, Spent};
use crate::clearance::clothoid::PlacedClothoid;
use crate::geometry::box_tree::BoxTree;
use crate::geometry::{AxisBox, Vector, unit};
use crate::motion::{Curve, Leg};

/// Steps of the budget that following a leg in a channel takes.
const STEPS_PER_LEG: u64 = 4;

/// A clothoid is followed along so many arcs in its place. They stray from it by no more than a
/// millionth of its length, which counts as inside.
const PIECES: u32 = 32;

/// More channels than this are indexed.
const FEW: usize = 32;

/// A place on a motion: a leg, and which part of it has been travelled.
type PathPlace = (usize, f64);

/// The channels that a motion travels, in memory that is used again.
#[derive(Debug, Default)]
pub struct ChannelsTravelled {
    route: Vec<usize>,
    index: BoxTree<2>,
}

impl ChannelsTravelled {
    /// The indices of the channels in the order in which the reference point travels them.
    pub fn route(&self) -> &[usize] {
        &self.route
    }

    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        self.route.capacity() * size_of::<usize>() + self.index.bytes()
    }

    /// Finds them: as few as lead on farthest each, of those that lead on equally far the first.
    /// `rounding`: how far outside of a channel counts as inside, metres.
    pub fn find(
        &mut self,
        legs: &[Leg<2>],
        channels: &[AxisBox<2>],
        rounding: f64,
        budget: &Budget<'_>,
    ) -> Result<(), Spent> {
        let Self { route, index: tree } = self;
        route.clear();
        let is_indexed = channels.len() > FEW;
        let held = if is_indexed { BoxTree::<2>::bytes_for(channels.len()) } else { 0 };
        let _held = Held::new(budget, held)?;
        if is_indexed {
            let bounds = |index: usize| (channels[index].min(), channels[index].max());
            tree.build(channels.len(), bounds, budget)?;
        }
        let mut at: PathPlace = (0, 0.0);
        while let Some(leg) = legs.get(at.0) {
            let mut best: Option<(PathPlace, usize)> = None;
            let mut offer = |index: usize| {
                let to = follow(legs, at, &channels[index], rounding, budget)?;
                let is_better = best.is_none_or(|(farthest, first)| {
                    to > farthest || to == farthest && index < first
                });
                if to > at && is_better {
                    best = Some((to, index));
                }
                Ok(())
            };
            if is_indexed {
                let here = point_at(&leg.curve, at.1);
                let mut result = Ok(());
                // Beside a corner of a box by its margin on both axes.
                let reach = 2.0 * rounding;
                tree.visit(&here, &here, reach, budget, |index| {
                    result = result.and_then(|()| offer(index));
                    if result.is_ok() { reach } else { -1.0 }
                })?;
                result?;
            } else {
                budget.step(channels.len() as u64)?;
                (0..channels.len()).try_for_each(offer)?;
            }
            let Some((to, channel)) = best else { break };
            route.push(channel);
            at = to;
        }
        if route.is_empty() {
            // A motion without length.
            let here = legs.first().map(|leg| leg.curve.start());
            let first =
                here.and_then(|here| channels.iter().position(|channel| channel.holds(&here)));
            route.extend(first);
        }
        Ok(())
    }
}

/// The reference point after a part of a curve.
fn point_at(curve: &Curve<2>, part: f64) -> Vector<2> {
    match *curve {
        Curve::Turn { position, .. } => position,
        Curve::Line { from, to, .. } => from + (to - from) * part,
        Curve::Arc { center, radius, start_angle, sweep, .. } => {
            center + unit(start_angle + part * sweep) * radius
        }
        Curve::Clothoid { from, .. } => {
            PlacedClothoid::of(curve).map_or(from, |clothoid| clothoid.at(part))
        }
    }
}

/// How far a motion stays in a channel from a place on.
fn follow(
    legs: &[Leg<2>],
    (mut leg, mut part): PathPlace,
    channel: &AxisBox<2>,
    rounding: f64,
    budget: &Budget<'_>,
) -> Result<PathPlace, Spent> {
    while let Some(next) = legs.get(leg) {
        let is_clothoid = matches!(next.curve, Curve::Clothoid { .. });
        budget.step(STEPS_PER_LEG * u64::from(if is_clothoid { PIECES } else { 1 }))?;
        let to = stays_until(&next.curve, part, channel, rounding);
        if to < 1.0 {
            return Ok((leg, to));
        }
        (leg, part) = (leg + 1, 0.0);
    }
    Ok((leg, 0.0))
}

/// Up to which part of a curve, from one on, it stays in a channel.
fn stays_until(curve: &Curve<2>, from: f64, channel: &AxisBox<2>, rounding: f64) -> f64 {
    let margin = Vector::repeat(rounding);
    let (low, high) = (channel.min() - margin, channel.max() + margin);
    let is_inside = |point: &Vector<2>| {
        (0..2).all(|axis| low[axis] <= point[axis] && point[axis] <= high[axis])
    };
    match *curve {
        Curve::Turn { position, .. } => {
            if is_inside(&position) {
                1.0
            } else {
                from
            }
        }
        Curve::Line { from: begin, to: end, .. } => {
            if !is_inside(&point_at(curve, from)) {
                return from;
            }
            let mut leaves = 1.0_f64;
            for axis in 0..2 {
                let way = end[axis] - begin[axis];
                let side = if way > 0.0 { high[axis] } else { low[axis] };
                if way != 0.0 {
                    leaves = leaves.min((side - begin[axis]) / way);
                }
            }
            leaves.max(from)
        }
        Curve::Arc { center, radius, start_angle, sweep, .. } => {
            let at = |part: f64| point_at(curve, part);
            if !is_inside(&at(from)) {
                return from;
            }
            let mut leaves = 1.0_f64;
            for axis in 0..2 {
                for side in [low[axis], high[axis]] {
                    let cosine = (side - center[axis]) / radius;
                    if cosine.abs() > 1.0 {
                        continue;
                    }
                    // Seen from +x, or from +y.
                    let middle = if axis == 0 { 0.0 } else { FRAC_PI_2 };
                    let half = libm::acos(cosine);
                    for angle in [middle - half, middle + half] {
                        let turn = (angle - start_angle) * sweep.signum() / TAU;
                        let part = (turn - turn.floor()) * TAU / sweep.abs();
                        // Just beyond, it is outside, or it only touches.
                        let beyond = at((part + 1e-9).min(1.0));
                        if part > from && part < leaves && !is_inside(&beyond) {
                            leaves = part;
                        }
                    }
                }
            }
            leaves
        }
        Curve::Clothoid { .. } => {
            let Some(clothoid) = PlacedClothoid::of(curve) else { return from };
            let place = |piece: u32| f64::from(piece) / f64::from(PIECES);
            for (low, high) in (0..PIECES).map(|piece| (place(piece), place(piece + 1))) {
                if high <= from {
                    continue;
                }
                let osculating = clothoid.osculating([low, high]);
                let begin = ((from - low) / (high - low)).max(0.0);
                let margin = rounding + osculating.apart;
                let until = stays_until(&osculating.curve, begin, channel, margin);
                if until < 1.0 {
                    return (low + until * (high - low)).max(from);
                }
            }
            1.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::Cap;

    fn channel(min: [f64; 2], max: [f64; 2]) -> AxisBox<2> {
        AxisBox::new(min.into(), max.into()).unwrap()
    }

    /// A staircase of corridors, travelled up; each is there twice, and long ones lie aside.
    #[test]
    fn indexed_channels_are_those_looked_at_one_by_one() {
        let mut channels = Vec::new();
        for step in 0..40 {
            let at = f64::from(step) * 4.0;
            channels.push(channel([at - 1.0, at - 1.0], [at + 5.0, at + 1.0]));
            channels.push(channel([at + 3.0, at - 1.0], [at + 5.0, at + 5.0]));
            channels.push(channel([at - 1.0, at - 1.0], [at + 5.0, at + 1.0]));
            channels.push(channel([at + 3.0, -9.0], [at + 5.0, -8.0]));
        }
        let legs_to = |steps: i32| -> Vec<Leg<2>> {
            let corner =
                |index: i32| Vector::from([f64::from((index + 1) / 2), f64::from(index / 2)]) * 4.0;
            let line = |index: i32| {
                let (from, to) = (corner(index), corner(index + 1));
                let way = to - from;
                let heading = libm::atan2(way.y, way.x);
                let curve = Curve::Line { from, to, heading, turned: 0.0 };
                Leg { curve, junction: None, rule: None, rung: None }
            };
            (0..steps).map(line).collect()
        };
        let mut travelled = ChannelsTravelled::default();
        let mut find = |legs: &[Leg<2>], channels: &[AxisBox<2>]| {
            let budget = Budget::default();
            travelled.find(legs, channels, 1e-9, &budget).unwrap();
            (travelled.route().to_vec(), budget.drawn(Cap::Steps))
        };
        let expected: Vec<_> = (0..40).flat_map(|step| [4 * step, 4 * step + 1]).collect();
        for steps in [1, 2, 7, 16] {
            let (route, _) = find(&legs_to(steps), &channels);
            assert_eq!(route, expected[..steps as usize]);
            // Few enough to be looked at one by one.
            assert_eq!(find(&legs_to(steps), &channels[..FEW]).0, route);
        }
        // Not legs times channels.
        let (route, steps) = find(&legs_to(80), &channels);
        assert_eq!(route, expected);
        assert!(steps < 80 * 100, "{steps}");
    }
}
