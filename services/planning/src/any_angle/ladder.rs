//! The rungs, from the taut path to the lattice, and which of their motions is taken.

use std::f64::consts::FRAC_PI_2;
use std::mem;

use super::disc::Disc;
use super::measure::{Contact, cost, measure};
use super::taut::{TautPath, TautSearch};
use super::{CONTACT, Errand, Found, NoMotion, PRECISION, Wish, bound, refusal, safest};
use crate::budget::{Budget, Spent};
use crate::clearance::rectangle::clearance_rectangle_pose;
use crate::driving::{SAME_HEADING, StartTurn, shortest_turn};
use crate::geometry::Vector;
use crate::motion::{Curve, Leg, Rung, wrapped};

/// Lines up to this length are left out, metres: the arcs beside them touch.
const NO_LINE: f64 = 1e-12;

/// Radii tried between that of the taut path and that at which the robot can turn anywhere.
const RADII: usize = 4;

/// How often the radius at a corner that is in the way is made larger.
const MOST_CHANGES: usize = 16;

/// What a motion must keep.
#[derive(Debug, Clone, Copy)]
pub(super) struct Target {
    /// From the corners that it turns about, metres.
    pub(super) gap: f64,
    /// Its free clearance, metres; `None`: it must not touch.
    pub(super) least: Option<f64>,
}

/// Memory that is used again from one motion to the next.
#[derive(Debug, Default)]
pub struct Planner {
    pub(super) taut: TautSearch,
    spare: Found,
    /// Corners with a radius of their own, metres.
    radii: Vec<(u32, f64)>,
}

impl Planner {
    /// The memory that it holds, bytes.
    pub fn bytes(&self) -> usize {
        self.taut.bytes()
    }

    /// To be called before it is used with another floor.
    pub fn forget(&mut self) {
        self.taut.forget();
    }
}

/// Finds the motion that is wished for.
pub fn drive(
    errand: &Errand<'_>,
    wish: Wish,
    planner: &mut Planner,
    found: &mut Found,
    budget: &Budget<'_>,
) -> Result<(), NoMotion> {
    check_ends(errand, budget)?;
    match wish {
        Wish::Gap(gap) => shortest(errand, Target { gap, least: None }, planner, found, budget)?,
        Wish::AtLeast(least) => {
            let target = Target { gap: least, least: Some(least) };
            shortest(errand, target, planner, found, budget)?;
        }
        Wish::Safest => safest::safest(errand, planner, found, budget)?,
    }
    bound::certify(errand, planner, found, budget)
}

/// Refuses a start or a goal where the robot touches a wall.
fn check_ends(errand: &Errand<'_>, budget: &Budget<'_>) -> Result<(), NoMotion> {
    let Errand { footprint, start, goal, walls, .. } = errand;
    let ends = [(start.position, Some(start.heading), false), (goal.position, goal.heading, true)];
    for (position, heading, at_goal) in ends {
        let Some(heading) = heading else { continue };
        let near = clearance_rectangle_pose(footprint, &position, heading, walls, budget)?;
        if let Some(near) = near
            && near.value <= CONTACT
        {
            return Err(NoMotion::Occupied { at_goal, wall: near.wall });
        }
    }
    Ok(())
}

/// The shortest motion that keeps what is asked for.
pub(super) fn shortest(
    errand: &Errand<'_>,
    target: Target,
    planner: &mut Planner,
    found: &mut Found,
    budget: &Budget<'_>,
) -> Result<(), NoMotion> {
    found.gap = target.gap;
    found.is_complete = true;
    let radius = errand.footprint.width() / 2.0 + target.gap;
    planner.radii.clear();
    let Some(path) = taut_path(errand, radius, planner, budget)? else {
        return Err(refusal::no_way(errand, radius, planner, budget)?);
    };
    let legs = legs_of(errand, &path, Rung::Taut);
    let Some(contact) = fits(errand, target, legs, found, budget)? else { return Ok(()) };
    let other = wider(errand, target, (&path, contact), planner, found, budget);
    match other {
        Ok(true) => Ok(()),
        Ok(false) => Err(refusal::blocked(errand, found, &contact)),
        Err(spent) => Err(spent.into()),
    }
}

/// The taut path of a disc, with larger radii at some corners.
fn taut_path(
    errand: &Errand<'_>,
    radius: f64,
    planner: &mut Planner,
    budget: &Budget<'_>,
) -> Result<Option<TautPath>, Spent> {
    let Errand { start, goal, walls, floor, abilities, .. } = errand;
    let ends = [start.position, goal.position];
    let disc = Disc::new(radius, ends, (walls, floor.rounding()), budget)?;
    let Planner { taut, radii, .. } = planner;
    let own = |vertex: u32| radii.iter().find(|(other, _)| *other == vertex).map(|(_, own)| *own);
    let least = abilities.min_turn_radius;
    taut.find(
        floor,
        &disc,
        |vertex, point| {
            let radius = disc.radius_at(point).max(least);
            own(vertex).map_or(radius, |own| own.max(radius))
        },
        radii.is_empty(),
        budget,
    )
}

/// Whether a motion keeps what is asked for; otherwise where it does not.
fn fits(
    errand: &Errand<'_>,
    target: Target,
    legs: Vec<Leg<2>>,
    found: &mut Found,
    budget: &Budget<'_>,
) -> Result<Option<Contact>, Spent> {
    let contact = measure(errand, legs, found, budget)?;
    if contact.is_some() {
        return Ok(contact);
    }
    let turns = |leg: &Leg<2>| matches!(leg.curve, Curve::Turn { sweep, .. } if sweep != 0.0);
    if !errand.abilities.turn_in_place
        && let Some(leg) = found.legs.iter().position(turns)
    {
        return Ok(Some(Contact { leg, wall: None }));
    }
    let Some(least) = target.least else { return Ok(None) };
    bound::measure_free_clearance(errand, found, budget)?;
    if found.free_clearance >= least - PRECISION {
        return Ok(None);
    }
    let nearest = found.leg_clearances.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
    let wall = found.clearance.map(|clearance| clearance.wall);
    Ok(nearest.map(|(leg, _)| Contact { leg, wall }))
}

/// The least costly motion about larger circles; whether there is one.
fn wider(
    errand: &Errand<'_>,
    target: Target,
    (path, contact): (&TautPath, Contact),
    planner: &mut Planner,
    found: &mut Found,
    budget: &Budget<'_>,
) -> Result<bool, Spent> {
    let least = errand.footprint.width() / 2.0 + target.gap;
    // Where the turning circle has this room, the robot keeps its gap in any heading.
    let most = errand.footprint.swing_radius() + target.gap;
    let levels = |level: usize| least + (most - least) * level as f64 / RADII as f64;
    let mut best: Option<(f64, Found)> = None;
    let mut offer = |planner: &mut Planner, candidate: &mut Found| {
        let cost = cost(errand, &candidate.legs);
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            let other = mem::replace(candidate, mem::take(&mut planner.spare));
            best = Some((cost, other));
        }
    };
    // Larger circles only where something is in the way.
    let (mut path, mut contact) = (path.clone(), contact);
    planner.radii.clear();
    for _ in 0..MOST_CHANGES {
        let mut changed = false;
        for vertex in corners_at(&path, &found.legs, contact.leg) {
            let known = planner.radii.iter_mut().find(|(other, _)| *other == vertex);
            let step = (most - least) / RADII as f64;
            match known {
                Some((_, radius)) if *radius < most => {
                    *radius = (*radius + step).min(most);
                    changed = true;
                }
                Some(_) => {}
                None => {
                    planner.radii.push((vertex, least + step));
                    changed = true;
                }
            }
        }
        if !changed {
            break;
        }
        let Some(next) = taut_path(errand, least, planner, budget)? else { break };
        path = next;
        match fits(errand, target, legs_of(errand, &path, Rung::Radius), found, budget)? {
            None => {
                offer(planner, found);
                break;
            }
            Some(next) => contact = next,
        }
    }
    planner.radii.clear();
    // And everywhere.
    for level in 1..=RADII {
        let Some(path) = taut_path(errand, levels(level), planner, budget)? else { break };
        if fits(errand, target, legs_of(errand, &path, Rung::Radius), found, budget)?.is_none() {
            offer(planner, found);
            break;
        }
    }
    let Some((_, motion)) = best else { return Ok(false) };
    planner.spare = mem::replace(found, motion);
    found.gap = target.gap;
    found.is_complete = true;
    Ok(true)
}

/// The corners about which a leg turns, or between which it runs.
fn corners_at(path: &TautPath, legs: &[Leg<2>], leg: usize) -> Vec<u32> {
    let turn = |index: usize| path.turns.get(index).map(|turn| turn.vertex);
    let Some(leg) = legs.get(leg) else { return Vec::new() };
    match (leg.curve, leg.junction) {
        (Curve::Arc { .. }, Some(junction)) => turn(junction).into_iter().collect(),
        (Curve::Line { .. }, Some(junction)) => {
            let before = junction.checked_sub(1).and_then(turn);
            before.into_iter().chain(turn(junction)).collect()
        }
        (Curve::Line { .. }, None) => {
            path.turns.last().map(|turn| turn.vertex).into_iter().collect()
        }
        (Curve::Turn { .. }, _) => {
            let turns = [path.turns.first(), path.turns.last()];
            turns.into_iter().flatten().map(|turn| turn.vertex).collect()
        }
        (Curve::Arc { .. }, None) => Vec::new(),
    }
}

/// The legs along a taut path.
fn legs_of(errand: &Errand<'_>, path: &TautPath, rung: Rung) -> Vec<Leg<2>> {
    let mut legs = Vec::with_capacity(2 * path.turns.len() + 3);
    let leg = |curve, junction| Leg { curve, junction, rule: None, rung: Some(rung) };
    let mut heading = wrapped(errand.start.heading);
    let lines = path.turns.iter().map(|turn| &turn.arrival).chain([&path.last]);
    for (index, line) in lines.enumerate() {
        let has_line = line.length > NO_LINE;
        let next = if has_line || index > 0 {
            libm::atan2(line.direction.y, line.direction.x)
        } else {
            heading
        };
        let mut turned = 0.0;
        if let Some(before) = index.checked_sub(1) {
            let turn = &path.turns[before];
            let sense = turn.circle.signed_radius.signum();
            if turn.sweep > 0.0 {
                let curve = Curve::Arc {
                    center: turn.circle.center,
                    radius: turn.circle.signed_radius.abs(),
                    start_angle: wrapped(heading - sense * FRAC_PI_2),
                    sweep: sense * turn.sweep,
                    reverse: false,
                };
                legs.push(leg(curve, Some(before)));
            }
        } else {
            let turn = shortest_turn(heading, next);
            if turn.abs() > SAME_HEADING {
                if has_line && errand.start_turn == StartTurn::WhileMoving {
                    turned = turn;
                } else {
                    legs.push(leg(turn_in_place(errand.start.position, heading, turn), None));
                }
            }
        }
        if has_line {
            let curve = Curve::Line { from: line.from, to: line.to, heading: next, turned };
            legs.push(leg(curve, (index < path.turns.len()).then_some(index)));
        }
        heading = next;
    }
    if let Some(goal) = errand.goal.heading {
        let turn = shortest_turn(heading, wrapped(goal));
        if turn.abs() > SAME_HEADING {
            legs.push(leg(turn_in_place(errand.goal.position, heading, turn), None));
        }
    }
    if legs.is_empty() {
        legs.push(leg(turn_in_place(errand.start.position, heading, 0.0), None));
    }
    legs
}

fn turn_in_place(position: Vector<2>, from_heading: f64, sweep: f64) -> Curve<2> {
    Curve::Turn { position, from_heading, sweep }
}
