//! Which channels a motion travels.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::budget::{Budget, Spent};
use crate::geometry::{AxisBox, Vector, unit};
use crate::motion::{Curve, Leg};

/// Steps of the budget that following a leg in a channel takes.
const STEPS_PER_LEG: u64 = 4;

/// A place on a motion: a leg, and which part of it has been travelled.
type PathPlace = (usize, f64);

/// Puts into `route` the indices of channels in the order in which the reference point travels
/// them, as few as lead on farthest each. `rounding`: how far outside of a channel counts as inside, metres.
pub fn channels_travelled(
    legs: &[Leg<2>],
    channels: &[AxisBox<2>],
    rounding: f64,
    route: &mut Vec<usize>,
    budget: &Budget<'_>,
) -> Result<(), Spent> {
    route.clear();
    let mut at: PathPlace = (0, 0.0);
    while at.0 < legs.len() {
        let mut best: Option<(PathPlace, usize)> = None;
        for (index, channel) in channels.iter().enumerate() {
            budget.step(1)?;
            let to = follow(legs, at, channel, rounding, budget)?;
            if to > at && best.is_none_or(|(farthest, _)| to > farthest) {
                best = Some((to, index));
            }
        }
        let Some((to, channel)) = best else { break };
        route.push(channel);
        at = to;
    }
    if route.is_empty() {
        // A motion without length.
        let here = legs.first().map(|leg| leg.curve.start());
        let first = here.and_then(|here| channels.iter().position(|channel| channel.holds(&here)));
        route.extend(first);
    }
    Ok(())
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
        budget.step(STEPS_PER_LEG)?;
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
            if !is_inside(&(begin + (end - begin) * from)) {
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
            let at = |part: f64| center + unit(start_angle + part * sweep) * radius;
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
    }
}
