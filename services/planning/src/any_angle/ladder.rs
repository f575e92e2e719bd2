//! The rungs, from the taut path to the lattice, and which of their motions is taken.

use std::mem;

use super::disc::{Disc, disc_of};
use super::lattice::{self, Kept};
use super::legs::legs_of;
use super::measure::{Contact, cost, measure};
use super::planner::Planner;
use super::taut::{TautPath, TurnRadii};
use super::{Abilities, Errand, NoMotion, RobotMotion, backwards, bound, fuse, refusal};
use crate::budget::{Budget, Spent};
use crate::driving::StartTurn;

use crate::motion::{Curve, Leg, Rung};

/// Radii tried between that of the taut path and that at which the robot can turn anywhere.
const RADII: usize = 4;

/// What is no longer than the taut path by this factor is not worth a search for lines between
/// places to turn, ...
pub(super) const NEAR: f64 = 1.02;

/// ... or, by this one, for poses.
pub(super) const LONG: f64 = 1.08;

/// How often the radius at a corner that is in the way is made larger.
const MOST_CHANGES: usize = 8;

/// The last rung that is tried, if nothing before it helps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum LastRung {
    /// Larger circles.
    Radius,
    /// Lines between places to turn.
    Aligned,
    /// The search over poses.
    Lattice,
}

/// Parts of the gap that are tried where nothing is found with all of it, nor by a search.
const LESS_GAP: [f64; 5] = [0.5, 0.25, 0.125, 1.0 / 32.0, 1.0 / 128.0];

/// What a motion must keep.
#[derive(Debug, Clone, Copy)]
pub(super) struct Target {
    /// Where the ladder ends.
    pub(super) last: LastRung,
    /// From the corners that it turns about, metres.
    pub(super) gap: f64,
    /// Its free clearance, metres; `None`: it must not touch.
    pub(super) least: Option<f64>,
}

/// The least costly motion that keeps what is asked for: the taut one, or that of the rungs.
pub(super) fn shortest(
    errand: &Errand<'_>,
    target: Target,
    planner: &mut Planner,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<(), NoMotion> {
    let taut = one_way(errand, target, planner, found, budget);
    let taut_length = found.taut_length;
    let mut best = Best { cost: f64::INFINITY, motion: None, taut_length, is_cut_short: false };
    let blocked = match taut {
        Ok(is_taut) => {
            best.offer(errand, found);
            // What is taut and forwards is only beaten by less turning.
            if is_taut && !errand.abilities.reverse {
                best.take(found);
                return Ok(());
            }
            None
        }
        Err(NoMotion::Blocked { wall, turning, .. }) => Some((wall, turning)),
        Err(error) => return Err(error),
    };
    if errand.abilities.reverse {
        let back = one_way(&backwards::flipped(errand), target, planner, found, budget);
        if best.takes(back)?.is_some() {
            backwards::turn_round(&mut found.legs);
            best.offer(errand, found);
        }
    }
    if target.last >= LastRung::Aligned && best.is_longer_than(NEAR) {
        let other = poses(errand, target, (Rung::Aligned, best.cost), planner, found, budget);
        if best.takes(other)? == Some(true) {
            best.offer(errand, found);
        }
    }
    if target.last == LastRung::Lattice && best.is_longer_than(LONG) {
        let other = poses(errand, target, (Rung::Lattice, best.cost), planner, found, budget);
        if best.takes(other)? == Some(true) {
            best.offer(errand, found);
        }
    }
    let searched = target.last == LastRung::Lattice;
    if searched && best.motion.is_none() && target.least.is_none() {
        for part in LESS_GAP {
            let gap = part * target.gap;
            let other = one_way(errand, Target { gap, ..target }, planner, found, budget);
            if best.takes(other)?.is_some() {
                best.offer(errand, found);
                // What is known bounds motions that keep the whole gap.
                best.taut_length = None;
                break;
            }
        }
    }
    match blocked {
        Some((wall, turning)) if best.motion.is_none() => {
            let resolution = planner.lattice.resolution().filter(|_| searched);
            let reverse_helps = !errand.abilities.reverse
                && searched
                && would_reverse_help(errand, target, planner, found, budget)?;
            Err(NoMotion::Blocked { wall, turning, reverse_helps, resolution })
        }
        _ => {
            best.take(found);
            Ok(())
        }
    }
}

/// The least costly of several motions.
struct Best {
    cost: f64,
    motion: Option<RobotMotion>,
    /// Length of the taut path at the gap, metres.
    taut_length: Option<f64>,
    /// Whether the budget ended before all were looked at.
    is_cut_short: bool,
}

impl Best {
    /// Whether there is no motion yet, or one that is longer than the taut path by a factor.
    fn is_longer_than(&self, factor: f64) -> bool {
        let taut = self.taut_length.unwrap_or(f64::INFINITY);
        self.motion.as_ref().is_none_or(|motion| motion.length > factor * taut)
    }

    fn offer(&mut self, errand: &Errand<'_>, found: &mut RobotMotion) {
        let cost = cost(errand, &found.legs);
        if cost < self.cost {
            self.cost = cost;
            let before = self.motion.replace(mem::take(found));
            *found = before.unwrap_or_default();
        }
    }

    /// A result, unless there is none; where the budget ends after a motion was found, that
    /// stands.
    fn takes<T>(&mut self, result: Result<T, NoMotion>) -> Result<Option<T>, NoMotion> {
        match result {
            Ok(value) => Ok(Some(value)),
            Err(NoMotion::Spent(Spent::Limit { .. })) if self.motion.is_some() => {
                self.is_cut_short = true;
                Ok(None)
            }
            Err(NoMotion::Spent(spent)) => Err(spent.into()),
            Err(_) => Ok(None),
        }
    }

    fn take(self, found: &mut RobotMotion) {
        if let Some(motion) = self.motion {
            let (taut_length, is_complete) = (self.taut_length, !self.is_cut_short);
            *found = RobotMotion { taut_length, is_complete, ..motion };
        }
    }
}

/// Whether a robot that may drive backwards would find a way.
fn would_reverse_help(
    errand: &Errand<'_>,
    target: Target,
    planner: &mut Planner,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<bool, Spent> {
    let abilities = Abilities { reverse: true, ..errand.abilities };
    let errand = Errand { abilities, ..*errand };
    let target = Target { last: LastRung::Aligned, ..target };
    match shortest(&errand, target, planner, found, budget) {
        Ok(()) => Ok(true),
        Err(NoMotion::Spent(spent @ Spent::Stopped)) => Err(spent),
        Err(_) => Ok(false),
    }
}

/// A motion between poses, by straight legs or by all means, that costs less than `most`; whether
/// there is one.
pub(super) fn poses(
    errand: &Errand<'_>,
    target: Target,
    (rung, most): (Rung, f64),
    planner: &mut Planner,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<bool, NoMotion> {
    let search = match rung {
        Rung::Aligned => lattice::aligned,
        _ => lattice::search,
    };
    // With less than the gap only what can't be had with it; a search takes long.
    let all = [target.gap, 0.0];
    let leasts = match rung {
        _ if target.least.is_some() || most.is_finite() => &all[..1],
        Rung::Aligned => &all[..],
        _ => &all[1..],
    };
    for least in leasts.iter().copied() {
        let kept = Kept { least, as_at_ends: target.least.is_some(), most_length: most };
        let Some(curves) = search(errand, kept, &mut planner.lattice, budget)? else {
            continue;
        };
        let Some(curves) = set_out(errand, curves) else { continue };
        let is_reverse = curves.iter().any(Curve::is_reverse);
        let rung = if is_reverse && rung == Rung::Aligned { Rung::Reverse } else { rung };
        let leg = |curve| Leg { curve, junction: None, rule: None, rung: Some(rung) };
        let legs = curves.into_iter().map(leg).collect();
        if fits(errand, target, legs, found, budget)?.is_empty() {
            found.gap = target.gap;
            return Ok(true);
        }
    }
    Ok(false)
}

/// The curves of a robot that takes up its first heading as it is asked to: in place, or on its
/// first line; `None` if it sets out otherwise.
pub(super) fn set_out(errand: &Errand<'_>, mut curves: Vec<Curve<2>>) -> Option<Vec<Curve<2>>> {
    let Some(Curve::Turn { sweep, .. }) = curves.first().copied() else { return Some(curves) };
    if errand.start_turn == StartTurn::InPlace || curves.len() == 1 {
        return Some(curves);
    }
    let first = match curves[1] {
        Curve::Line { from, to, heading, .. } if !curves[1].is_reverse() => {
            Curve::Line { from, to, heading, turned: sweep }
        }
        _ => return None,
    };
    // More than a quarter turn off, it begins backwards.
    if first.is_reverse() && !errand.abilities.reverse {
        return None;
    }
    curves[1] = first;
    curves.remove(0);
    Some(curves)
}

/// The taut motion, or one about larger circles, all forwards; whether it is taut.
fn one_way(
    errand: &Errand<'_>,
    target: Target,
    planner: &mut Planner,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<bool, NoMotion> {
    found.gap = target.gap;
    found.taut_length = None;
    let radius = errand.footprint.width() / 2.0 + target.gap;
    planner.radii.clear();
    let disc = disc_of(errand, radius, budget)?;
    let Some(path) = taut_path(errand, &disc, planner, budget)? else {
        return Err(refusal::no_way(errand, radius, planner, budget)?);
    };
    // With a least turning radius it is longer than need be.
    if errand.abilities.min_turn_radius <= radius {
        found.taut_length = Some(path.length);
    }
    if let Some(path) = fuse::fused(&path, &disc, budget)?
        && fits(errand, target, legs_of(errand, &path, Rung::Taut), found, budget)?.is_empty()
    {
        return Ok(true);
    }
    let contacts = fits(errand, target, legs_of(errand, &path, Rung::Taut), found, budget)?;
    let Some(first) = contacts.first().copied() else { return Ok(true) };
    let blocked = refusal::blocked(errand, found, &first);
    if wider(errand, target, (&disc, path, contacts), planner, found, budget)? {
        return Ok(false);
    }
    Err(blocked)
}

/// The taut path of a disc, with larger radii at some corners.
fn taut_path(
    errand: &Errand<'_>,
    disc: &Disc<'_>,
    planner: &mut Planner,
    budget: &Budget<'_>,
) -> Result<Option<TautPath>, Spent> {
    let Planner { taut, radii, .. } = planner;
    let radii = TurnRadii { least: errand.abilities.min_turn_radius, own: radii };
    taut.find(errand.floor, disc, radii, budget)
}

/// The legs on which a motion does not keep what is asked for; none if it does.
fn fits(
    errand: &Errand<'_>,
    target: Target,
    legs: Vec<Leg<2>>,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<Vec<Contact>, Spent> {
    let mut contacts = measure(errand, legs, found, budget)?;
    if !errand.abilities.turn_in_place {
        let legs = found.legs.iter().enumerate();
        let turns =
            legs.filter(|(_, leg)| matches!(leg.curve, Curve::Turn { sweep, .. } if sweep != 0.0));
        contacts.extend(turns.map(|(leg, _)| Contact { leg, wall: None }));
    }
    if let Some(least) = target.least
        && contacts.is_empty()
    {
        bound::measure_free_clearance(errand, found, budget)?;
        if found.free_clearance < least - errand.precision() {
            let wall = found.clearance.map(|clearance| clearance.wall);
            let near = found.leg_clearances.iter().enumerate();
            let near = near.filter(|(_, clearance)| **clearance < least - errand.precision());
            contacts.extend(near.map(|(leg, _)| Contact { leg, wall }));
        }
    }
    Ok(contacts)
}

/// A motion about larger circles; whether there is one.
fn wider(
    errand: &Errand<'_>,
    target: Target,
    (disc, mut path, mut contacts): (&Disc<'_>, TautPath, Vec<Contact>),
    planner: &mut Planner,
    found: &mut RobotMotion,
    budget: &Budget<'_>,
) -> Result<bool, Spent> {
    let least = disc.radius;
    // Where the turning circle has this room, the robot keeps its gap in any heading.
    let most = errand.footprint.swing_radius() + target.gap;
    let step = (most - least) / RADII as f64;
    // Larger circles only where something is in the way.
    planner.radii.clear();
    for _ in 0..MOST_CHANGES {
        let mut corners = Vec::new();
        for contact in &contacts {
            corners_at(&path, &found.legs, contact.leg, &mut corners);
        }
        corners.sort_unstable();
        corners.dedup();
        budget.step((corners.len() * (1 + planner.radii.len())) as u64)?;
        let mut changed = false;
        for vertex in corners {
            match planner.radii.iter_mut().find(|(other, _)| *other == vertex) {
                Some((_, radius)) => {
                    changed |= *radius < most;
                    *radius = (*radius + step).min(most);
                }
                None => {
                    planner.radii.push((vertex, least + step));
                    changed = true;
                }
            }
        }
        if !changed {
            break;
        }
        let Some(next) = taut_path(errand, disc, planner, budget)? else { break };
        path = next;
        contacts = fits(errand, target, legs_of(errand, &path, Rung::Radius), found, budget)?;
        if contacts.is_empty() {
            return Ok(true);
        }
    }
    planner.radii.clear();
    // And everywhere.
    for level in 1..=RADII {
        let disc = disc_of(errand, least + step * level as f64, budget)?;
        let Some(path) = taut_path(errand, &disc, planner, budget)? else { break };
        let path = fuse::fused(&path, &disc, budget)?.unwrap_or(path);
        let legs = legs_of(errand, &path, Rung::Radius);
        if fits(errand, target, legs, found, budget)?.is_empty() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Appends the corners about which a leg turns, or between which it runs.
fn corners_at(path: &TautPath, legs: &[Leg<2>], leg: usize, corners: &mut Vec<u32>) {
    let turn = |index: usize| path.turns.get(index).map(|turn| turn.vertex);
    let Some(leg) = legs.get(leg) else { return };
    match (leg.curve, leg.junction) {
        (Curve::Arc { .. } | Curve::Clothoid { .. }, Some(junction)) => {
            corners.extend(turn(junction));
        }
        (Curve::Line { .. }, Some(junction)) => {
            corners.extend(junction.checked_sub(1).and_then(turn));
            corners.extend(turn(junction));
        }
        (Curve::Line { .. }, None) => corners.extend(path.turns.last().map(|turn| turn.vertex)),
        (Curve::Turn { .. }, _) => {
            let turns = [path.turns.first(), path.turns.last()];
            corners.extend(turns.into_iter().flatten().map(|turn| turn.vertex));
        }
        (Curve::Arc { .. } | Curve::Clothoid { .. }, None) => {}
    }
}
