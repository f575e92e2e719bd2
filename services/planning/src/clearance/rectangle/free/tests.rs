//! The free clearance: worked cases, and dense placements against dense wall points.

use std::f64::consts::{FRAC_PI_2, PI};

use proptest::prelude::*;

use super::super::TURNING_WHILE_MOVING_BOUND;
use super::super::along_wall::DistanceLaw;
use super::super::tests::{footprints, outline_distance, point, pose, scenes, walls};
use super::*;
use crate::budget::{Allowance, Cap};
use crate::clearance::clothoid::PRECISION;
use crate::motion::tests::{clothoid, motions};

fn leg(curve: Curve<2>) -> Leg<2> {
    Leg { curve, junction: None, rule: None, rung: None }
}

fn line(from: [f64; 2], to: [f64; 2], heading: f64) -> Curve<2> {
    Curve::Line { from: from.into(), to: to.into(), heading, turned: 0.0 }
}

fn ends_of(legs: &[Leg<2>]) -> [Pose; 2] {
    let (first, last) = (legs[0].curve, legs[legs.len() - 1].curve);
    [
        Pose { position: first.start(), heading: first.start_heading() },
        Pose { position: last.end(), heading: last.end_heading() },
    ]
}

fn free(footprint: &Footprint, curves: &[Curve<2>], walls: &Walls<2>) -> Option<Clearance<2>> {
    let legs: Vec<_> = curves.iter().copied().map(leg).collect();
    free_clearance(footprint, &legs, walls, &ends_of(&legs), &Budget::default()).unwrap()
}

/// 1 m wide, reaching 1.2 m ahead of its reference point and 0.3 m behind it.
fn robot() -> Footprint {
    Footprint::offset(1.0, 1.2, 0.3).unwrap()
}

#[test]
fn dock_behind_does_not_hide_the_rest() {
    // 0.02 m behind the rear; a passage that leaves 0.25 m on the left and 0.3 m on the right.
    let walls = walls(&[[-0.32, -5.0, -0.32, 5.0], [2.0, 0.75, 6.0, 0.75], [3.0, -0.8, 5.0, -0.8]]);
    let away = line([0.0, 0.0], [9.0, 0.0], 0.0);
    let found = free(&robot(), &[away], &walls).unwrap();
    assert!((found.value - 0.25).abs() < 1e-15);
    assert_eq!((found.wall, found.at), (point(2.0, 0.75), 0.8));
    let whole = nearest(&robot(), &away, &walls, 1.0, &Budget::default()).unwrap();
    assert!((whole.value - 0.02).abs() < 1e-15);
    // Backed into, the same dock hides as little.
    let found = free(&robot(), &[away.reversed()], &walls).unwrap();
    assert!((found.value - 0.25).abs() < 1e-15);
}

#[test]
fn driving_straight_away_from_a_wall_is_free() {
    let walls = walls(&[[-0.32, -5.0, -0.32, 5.0]]);
    assert_eq!(free(&robot(), &[line([0.0, 0.0], [9.0, 0.0], 0.0)], &walls), None);
    assert_eq!(free(&robot(), &[line([9.0, 0.0], [0.0, 0.0], 0.0)], &walls), None);
    // In steps, one of them a turn by nothing, and with a pause to come back.
    let steps = [
        Curve::Turn { position: point(0.0, 0.0), from_heading: 0.0, sweep: 0.0 },
        line([0.0, 0.0], [0.5, 0.0], 0.0),
        line([0.5, 0.0], [0.25, 0.0], 0.0),
        line([0.25, 0.0], [9.0, 0.0], 0.0),
    ];
    assert_eq!(free(&robot(), &steps, &walls), None);
}

#[test]
fn wall_beside_the_way_binds_all_along() {
    let walls = walls(&[[-5.0, 0.52, 20.0, 0.52]]);
    let found = free(&robot(), &[line([0.0, 0.0], [9.0, 0.0], 0.0)], &walls).unwrap();
    assert!((found.value - 0.02).abs() < 1e-15);
    // Only the points ahead of the front at the start do, and not those beside it at the goal.
    let short = [[-5.0, 0.52, 1.2, 0.52], [8.7, 0.52, 20.0, 0.52]];
    let walls = super::super::tests::walls(&short);
    assert_eq!(free(&robot(), &[line([0.0, 0.0], [9.0, 0.0], 0.0)], &walls), None);
}

#[test]
fn stopping_before_a_wall_is_free() {
    let walls = walls(&[[10.21, -5.0, 10.21, 5.0]]);
    assert_eq!(free(&robot(), &[line([0.0, 0.0], [9.0, 0.0], 0.0)], &walls), None);
    // Going nearer than where it stops is not.
    let steps = [line([0.0, 0.0], [9.0, 0.0], 0.0), line([9.0, 0.0], [8.0, 0.0], 0.0)];
    let found = free(&robot(), &steps, &walls).unwrap();
    assert!((found.value - 0.01).abs() < 1e-14 && (found.at - 9.0).abs() < 1e-14);
}

#[test]
fn tail_that_swings_out_binds_where_it_does() {
    // A turn to the right: the left rear corner, at (-0.3, 0.5), swings out to its radius.
    let turn = Curve::Turn { position: point(0.0, 0.0), from_heading: 0.0, sweep: -FRAC_PI_2 };
    let swing = libm::hypot(0.3, 0.5);
    let found = free(&robot(), &[turn], &walls(&[[-9.0, 0.6, -0.1, 0.6]])).unwrap();
    // Nearest to the wall's end, which it passes.
    assert!((found.value - (libm::hypot(0.1, 0.6) - swing)).abs() < 1e-15, "{found:?}");
    // The left side ahead of the reference point only moves away.
    assert_eq!(free(&robot(), &[turn], &walls(&[[0.9, 0.55, 1.2, 0.55]])), None);
}

#[test]
fn line_without_walls_is_free() {
    assert_eq!(free(&robot(), &[line([0.0, 0.0], [9.0, 0.0], 0.0)], &Walls::default()), None);
}

#[test]
fn budget_ends_the_search() {
    let walls = walls(&[[-0.32, -5.0, -0.32, 5.0]]);
    let legs = [leg(Curve::Line {
        from: point(0.0, 0.0),
        to: point(3.0, 0.0),
        heading: 0.0,
        turned: 0.5,
    })];
    let budget = Budget::new(Allowance { steps: 500, ..Allowance::NONE });
    let found = free_clearance(&robot(), &legs, &walls, &ends_of(&legs), &budget);
    assert_eq!(found, Err(Spent::Limit { cap: Cap::Steps, most: 500 }));
}

fn point_wall(at: &Vector<2>) -> Walls<2> {
    walls(&[[at.x, at.y, at.x, at.y]])
}

/// Distance of a wall point over the motion, at `samples` placements per leg.
fn sampled(footprint: &Footprint, curves: &[Curve<2>], at: &Vector<2>, samples: u32) -> f64 {
    let wall = point_wall(at);
    let mut least = f64::INFINITY;
    for curve in curves {
        for index in 0..=samples {
            let part = f64::from(index) / f64::from(samples);
            least = least.min(outline_distance(footprint, pose(curve, part), &wall));
        }
    }
    least
}

/// The same by the exact clearance, which is tested on its own.
fn exact(footprint: &Footprint, curves: &[Curve<2>], at: &Vector<2>) -> f64 {
    let wall = point_wall(at);
    let met = |curve| nearest(footprint, curve, &wall, 1.0, &Budget::default()).unwrap().value;
    curves.iter().map(met).fold(f64::INFINITY, f64::min)
}

fn cap(footprint: &Footprint, curves: &[Curve<2>], at: &Vector<2>) -> f64 {
    let wall = point_wall(at);
    let (first, last) = (curves[0], curves[curves.len() - 1]);
    outline_distance(footprint, pose(&first, 0.0), &wall).min(outline_distance(
        footprint,
        pose(&last, 1.0),
        &wall,
    ))
}

fn touches(footprint: &Footprint, curves: &[Curve<2>], walls: &Walls<2>) -> bool {
    let met = |curve| nearest(footprint, curve, walls, 1.0, &Budget::default()).unwrap();
    curves.iter().any(|curve| met(curve).value == 0.0)
}

/// No wall point comes closer than the value, the start and the goal allow; and beside the
/// place found there is one that comes as close.
fn check(footprint: &Footprint, curves: &[Curve<2>], walls: &Walls<2>, bound: f64) {
    let whole = walls.as_slice().iter();
    let whole = whole.map(|wall| (wall.from, wall.to - wall.from));
    if touches(footprint, curves, walls) {
        return;
    }
    let legs: Vec<_> = curves.iter().copied().map(leg).collect();
    let [start, goal] = ends_of(&legs);
    let tolerance = binding_tolerance(footprint, [&start, &goal]);
    let found = free(footprint, curves, walls);
    let value = found.map_or(f64::INFINITY, |found| found.value);
    for (from, span) in whole {
        for index in 0..=200 {
            let at = from + span * (f64::from(index) / 200.0);
            let cap = cap(footprint, curves, &at);
            let least = value.min(cap - tolerance) - bound - 1e-10;
            let exact = exact(footprint, curves, &at);
            assert!(exact >= least, "at {at:?} {exact} is less than {value} and {cap}");
            if exact < least + 1e-3 {
                let sampled = sampled(footprint, curves, &at, 300);
                assert!(sampled >= least, "at {at:?} {sampled} is less than {value} and {cap}");
            }
        }
    }
    let Some(found) = found else { return };
    let there = exact(footprint, curves, &found.wall);
    assert!((there - found.value).abs() < 1e-9 + bound, "{there} at the place, not {found:?}");
    // Wall points that bind may begin right beside the place.
    let binds = |at: &Vector<2>| {
        let exact = exact(footprint, curves, at);
        exact < cap(footprint, curves, at) - tolerance + bound + 1e-12
    };
    let beside = [0.0, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6];
    let near = walls.as_slice().iter().any(|wall| {
        let span = wall.to - wall.from;
        let length = span.norm();
        let along = if length > 0.0 { span / length } else { span };
        let foot = (found.wall - wall.from).dot(&along);
        beside.into_iter().flat_map(|by| [foot - by, foot + by]).any(|place| {
            let at = wall.from + along * place.clamp(0.0, length);
            (at - found.wall).norm() < 2e-6 && binds(&at)
        })
    });
    assert!(near, "no wall point binds beside {found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_wall_point_comes_closer_than_it_is_free(
        footprint in footprints(), curves in motions(3), walls in scenes(),
    ) {
        check(&footprint, &curves, &walls, 0.0);
    }

    /// The way back comes as close.
    #[test]
    fn reversed_motion_is_as_free(
        footprint in footprints(), curves in motions(3), walls in scenes(),
    ) {
        prop_assume!(!touches(&footprint, &curves, &walls));
        let back: Vec<_> = curves.iter().rev().map(Curve::reversed).collect();
        let value = |curves: &[Curve<2>]| {
            free(&footprint, curves, &walls).map_or(f64::INFINITY, |found| found.value)
        };
        let (there, back) = (value(&curves), value(&back));
        // What binds is told to a tolerance, and where it begins moves by more where distances cross flatly.
        prop_assert!(there == back || (there - back).abs() < 1e-8, "{} {}", there, back);
    }

    /// A wall right behind the start, or beside it, changes nothing for who drives away.
    #[test]
    fn docks_do_not_bind(
        footprint in footprints(), walls in scenes(), apart in 1e-4..0.5_f64,
        length in 0.1..4.0_f64, heading in -PI..PI,
    ) {
        let from = point(0.3, -0.2);
        let curve = Curve::Line { from, to: from + unit(heading) * length, heading, turned: 0.0 };
        let mut docked = walls.clone();
        let behind = from - unit(heading) * (footprint.rear() + apart);
        let across = unit(heading + FRAC_PI_2) * 3.0;
        docked.push(Wall { from: behind - across, to: behind + across });
        let value = |walls: &Walls<2>| {
            free(&footprint, &[curve], walls).map_or(f64::INFINITY, |found| found.value)
        };
        let (open, behind) = (value(&walls), value(&docked));
        prop_assert!(open == behind || (open - behind).abs() < 1e-12, "{} {}", open, behind);
        check(&footprint, &[curve], &docked, 0.0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn turning_while_moving_is_free_to_its_bound(
        footprint in footprints(), walls in scenes(),
        (x, y, u, v) in (-2.0..2.0, -2.0..2.0, -2.0..2.0, -2.0..2.0),
        heading in -PI..PI, turned in 0.05..3.0,
    ) {
        let (from, to) = (point(x, y), point(u, v));
        let curve = Curve::Line { from, to, heading, turned };
        check(&footprint, &[curve], &walls, FREE_TURNING_WHILE_MOVING_BOUND + TURNING_WHILE_MOVING_BOUND);
    }

    #[test]
    fn clothoids_are_free_to_their_bound(
        footprint in footprints(), walls in scenes(), from in (-1.5..1.5, -1.5..1.5),
        heading in -PI..PI, curvatures in prop::array::uniform2(-1.5..1.5_f64),
        length in 0.2..2.0_f64, reverse in any::<bool>(),
    ) {
        let from = point(from.0, from.1);
        let curve = clothoid(from, heading, (curvatures, length), reverse);
        let size = length + footprint.swing_radius();
        check(&footprint, &[curve], &walls, 3.0 * PRECISION * size);
    }
}

/// Distances that are almost the same cross where the tolerance says, with all their digits.
#[test]
fn tolerance_moves_a_crossing_but_does_not_lose_it() {
    let law = |foot: f64, square: f64, add: f64| DistanceLaw::Root { foot, square, add, sign: 1.0 };
    let (one, other) = (law(1.4875758118803468, 1.4830164193681075, 0.0), law(1.8, 0.8, -1e-9));
    let mut found = Vec::new();
    one.crossings(&other, (-5.0, 5.0), |place| found.push(place));
    // (u - a)^2 + b = (u - c)^2 + d, but for the tolerance.
    let (a, b, c, d) = (1.4875758118803468_f64, 1.4830164193681075, 1.8_f64, 0.8);
    let middle = (c * c - a * a + d - b) / (2.0 * (c - a));
    assert_eq!(found.len(), 2);
    for place in found {
        assert!((place - middle).abs() < 1e-8, "{place} {middle}");
    }
}

proptest! {
    /// A change of order between any two places is found, to rounding.
    #[test]
    fn crossings_are_all_found(
        laws in prop::array::uniform2((any::<bool>(), -3.0..3.0_f64, 0.0..4.0_f64, -1.0..1.0_f64)),
        close in any::<bool>(),
    ) {
        let [one, mut other] = laws.map(|(is_root, foot, square, add)| if is_root {
            DistanceLaw::Root { foot, square, add: if close { 0.0 } else { add }, sign: 1.0 }
        } else {
            DistanceLaw::Linear { at: foot, slope: add }
        });
        if let (true, DistanceLaw::Root { add, .. }) = (close, &mut other) {
            *add = -1e-9;
        }
        let mut places = vec![-5.0, 5.0];
        one.crossings(&other, (-5.0, 5.0), |place| places.push(place));
        places.sort_by(f64::total_cmp);
        for pair in places.windows(2) {
            let apart = |part: f64| {
                let place = pair[0] + (pair[1] - pair[0]) * part;
                one.at(place) - other.at(place)
            };
            let apart: Vec<_> = (1..100).map(|part| apart(f64::from(part) / 100.0)).collect();
            let (least, most) = apart.iter().fold((0.0_f64, 0.0_f64), |(a, b), &x| (a.min(x), b.max(x)));
            prop_assert!(least > -1e-13 || most < 1e-13, "{one:?} {other:?} {pair:?} {least} {most}");
        }
    }
}

#[test]
fn side_that_turns_about_its_middle_is_bounded() {
    // The front edge turns about a point of itself: what it sweeps is no quadrangle.
    let footprint = Footprint::offset(1.875058490121111, 0.0, 0.05).unwrap();
    let curve = Curve::Line {
        from: point(1.6624289746395775, -1.6301584352217209),
        to: point(-0.25179301426803663, 1.1266868837717894),
        heading: 0.9304674087862562,
        turned: 0.7349478462032978,
    };
    let dots = [[1.140492664896409, 1.4589327582268765], [0.0, -2.1895405540542976]];
    let walls = walls(&dots.map(|[x, y]| [x, y, x, y]));
    let found = free(&footprint, &[curve], &walls).unwrap();
    let dot = Vector::from(dots[1]);
    let exact = exact(&footprint, &[curve], &dot);
    assert!((found.value - exact).abs() < 2e-7 && found.wall == dot, "{found:?} {exact}");
}

/// A side that slides along itself while it turns is as near to the wall as at the start at one
/// of its points, which moves.
#[test]
fn turning_away_from_a_wall_takes_few_looks() {
    let robot =
        Footprint::offset(0.626630831085728, 0.4962362836842866, 0.780250303057996).unwrap();
    let walls = walls(&[[10.0, 10.0, 0.0, 10.0]]);
    let away = Curve::Line {
        from: [8.897548456528591, 9.512207671470232].into(),
        to: [7.564575876291074, 5.040656997259776].into(),
        heading: -1.86050977451007,
        turned: -1.6420469636095627,
    };
    let legs = [leg(away)];
    let budget = Budget::new(Allowance { steps: 50_000, ..Allowance::NONE });
    let found = free_clearance(&robot, &legs, &walls, &ends_of(&legs), &budget).unwrap().unwrap();
    // The rear side is nearer to a wall point than at the start by the tolerance, 8.408e-10, in
    // closed form by the progress, the least of it at a progress of 1.20e-5 by a search in 40
    // digits.
    assert!((found.value - 0.559_628_360_992_011_9).abs() < 1e-7, "{found:?}");
}
