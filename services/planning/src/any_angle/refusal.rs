//! Why there is no motion: the narrowest place of the widest way.

use super::disc::{disc_of, distance_to};
use super::measure::Contact;
use super::planner::Planner;
use super::taut::{TautPath, TurnRadii};
use super::{Errand, NoMotion, RobotMotion};
use crate::budget::{Budget, Held, Spent};
use crate::geometry::Vector;
use crate::geometry::box_tree::BoxTree;
use crate::geometry::distance::{cross, distance_segment_segment, nearest_on_segment};
use crate::motion::Curve;

/// Widths are found to this part of the least that will not do.
const PRECISION: f64 = 1e-9;

/// How often a radius is halved at most.
const MOST_HALVINGS: usize = 60;

/// No disc of this radius can pass: the widest that can, and where it is stuck beyond that.
pub(super) fn no_way(
    errand: &Errand<'_>,
    radius: f64,
    planner: &mut Planner,
    budget: &Budget<'_>,
) -> Result<NoMotion, Spent> {
    // No disc is wider than all there is.
    let most = radius.min(errand.floor.extent());
    let Some((widest, path)) = widest(errand, most, planner, budget)? else {
        return enclosed(errand, budget);
    };
    let across = narrowest(errand, &path, widest, budget)?;
    let has = across.map_or(2.0 * widest, |[one, other]| (other - one).norm());
    let across = across.unwrap_or([errand.start.position; 2]);
    Ok(NoMotion::TooNarrow { across, has, needs: 2.0 * radius })
}

/// The radius of the widest disc that passes, less than `radius`, and its path; `None` if not
/// even a point does.
pub(super) fn widest(
    errand: &Errand<'_>,
    radius: f64,
    planner: &mut Planner,
    budget: &Budget<'_>,
) -> Result<Option<(f64, TautPath)>, Spent> {
    let mut path_of = |radius: f64| {
        let disc = disc_of(errand, radius, budget)?;
        planner.bounds.find(errand.floor, &disc, TurnRadii::DISC, budget)
    };
    let mut low = radius * PRECISION;
    let Some(mut path) = path_of(low)? else { return Ok(None) };
    let mut high = radius;
    for _ in 0..MOST_HALVINGS {
        if high - low <= PRECISION * radius {
            break;
        }
        let middle = (low + high) / 2.0;
        match path_of(middle)? {
            Some(wider) => (low, path) = (middle, wider),
            None => high = middle,
        }
    }
    Ok(Some((low, path)))
}

/// The shortest line across the narrowest passage of a path that is as wide as it can be.
fn narrowest(
    errand: &Errand<'_>,
    path: &TautPath,
    radius: f64,
    budget: &Budget<'_>,
) -> Result<Option<[Vector<2>; 2]>, Spent> {
    let walls = errand.walls;
    // A little more, so that what is touched is found.
    let reach = radius * (1.0 + 1e-6) + 4.0 * errand.floor.rounding();
    let mut best: Option<(f64, [Vector<2>; 2])> = None;
    // Less is no passage, but a wall.
    let narrow = 2.0 * (2.0 * radius - reach);
    let mut offer = |one: Vector<2>, other: Vector<2>| {
        let width = (other - one).norm();
        if width >= narrow && best.is_none_or(|(least, _)| width < least) {
            best = Some((width, [one, other]));
        }
    };
    // From a corner to a wall.
    for turn in &path.turns {
        let corner = turn.circle.center;
        budget.step(1)?;
        walls.near(&corner, &corner, 2.0 * reach, budget, |_, wall| {
            let apart = distance_to(wall, &corner);
            if wall.from != corner && wall.to != corner && apart <= 2.0 * reach {
                offer(corner, nearest_on_segment(&corner, (&wall.from, &wall.to)));
            }
        })?;
    }
    // From wall to wall across a line.
    let lines = path.turns.iter().map(|turn| &turn.arrival).chain([&path.last]);
    for line in lines {
        let mut touched: [Vec<Vector<2>>; 2] = [Vec::new(), Vec::new()];
        walls.near_line((&line.from, &line.to), reach, budget, |_, wall| {
            let ends = (&line.from, &line.to);
            let near = distance_segment_segment(ends, (&wall.from, &wall.to));
            if near.distance <= reach && touched[0].len() + touched[1].len() < MOST_TOUCHED {
                let is_left = cross(&line.direction, &(near.point - line.from)) > 0.0;
                touched[usize::from(is_left)].push(near.point);
            }
            true
        })?;
        for one in &touched[0] {
            budget.step(touched[1].len() as u64)?;
            for other in &touched[1] {
                offer(*one, *other);
            }
        }
    }
    Ok(best.map(|(_, across)| across))
}

/// So many walls that a line touches are looked at.
const MOST_TOUCHED: usize = 64;

/// Walls are between the start and the goal: where they are thinnest.
fn enclosed(errand: &Errand<'_>, budget: &Budget<'_>) -> Result<NoMotion, Spent> {
    let Errand { floor, start, goal, .. } = errand;
    let from = floor.reachable(&start.position, budget)?;
    let to = floor.reachable(&goal.position, budget)?;
    let at_goal = to.faces < from.faces;
    let mut tree = BoxTree::default();
    let edges = &from.border;
    let ends = |edge: &[u32; 2]| edge.map(|vertex| floor.vertex(vertex));
    let held = BoxTree::<2>::bytes_for(edges.len());
    let _held = Held::new(budget, held)?;
    let bounds = |index: usize| {
        let [from, to] = ends(&edges[index]);
        (from.inf(&to), from.sup(&to))
    };
    tree.build(edges.len(), bounds, budget)?;
    let mut thickness = f64::INFINITY;
    let mut across = [start.position, goal.position];
    for edge in &to.border {
        let [one, other] = ends(edge);
        tree.visit(&one.inf(&other), &one.sup(&other), thickness, budget, |index| {
            let [from, to] = ends(&edges[index]);
            let near = distance_segment_segment((&one, &other), (&from, &to));
            if near.distance < thickness {
                thickness = near.distance;
                across = [near.point, one + (other - one) * near.at];
            }
            thickness
        })?;
    }
    Ok(NoMotion::Enclosed { at_goal, across, thickness })
}

/// A disc can pass, and the robot can't.
pub(super) fn blocked(errand: &Errand<'_>, found: &RobotMotion, contact: &Contact) -> NoMotion {
    let turning =
        found.legs.get(contact.leg).is_some_and(|leg| matches!(leg.curve, Curve::Turn { .. }));
    let wall = contact.wall.unwrap_or(errand.start.position);
    NoMotion::Blocked { wall, turning, reverse_helps: false, resolution: None }
}
