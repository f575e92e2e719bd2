//! Table 2 against the general tangents, and what does not depend on orientation.

use crate::budget::Budget;
use proptest::prelude::*;

use super::scene::{Scene, channel, corridors, mirrored, point, turned};
use crate::driving::rules::{TABLE_2, TurnRule};
use crate::driving::{CornerGaps, DrivingError, DrivingPath, Pose, StartTurn, drive, route};
use crate::geometry::{Vector, unit};
use crate::motion::{Curve, Leg, wrapped};

/// Reference point and heading at both ends of a leg.
fn ends(leg: &Leg<2>) -> [(Vector<2>, f64); 2] {
    match leg.curve {
        Curve::Line { from, to, heading, turned } => [(from, heading - turned), (to, heading)],
        Curve::Arc { center, radius, start_angle, sweep, .. } => [start_angle, start_angle + sweep]
            .map(|angle| {
                let heading = angle + std::f64::consts::FRAC_PI_2.copysign(sweep);
                (center + unit(angle) * radius, heading)
            }),
        Curve::Clothoid { from, to, .. } => {
            [(from, leg.curve.start_heading()), (to, leg.curve.end_heading())]
        }
        Curve::Turn { position, from_heading, sweep } => {
            [(position, from_heading), (position, from_heading + sweep)]
        }
    }
}

fn mirrored_pose((position, heading): (Vector<2>, f64)) -> (Vector<2>, f64) {
    (point(-position.x, position.y), std::f64::consts::PI - heading)
}

fn turned_pose((position, heading): (Vector<2>, f64)) -> (Vector<2>, f64) {
    (point(-position.y, position.x), heading + std::f64::consts::FRAC_PI_2)
}

fn check_same(left: (Vector<2>, f64), right: (Vector<2>, f64), bound: f64) {
    assert!((left.0 - right.0).amax() <= bound, "{left:?} {right:?}");
    assert!(wrapped(left.1 - right.1).abs() <= bound, "{left:?} {right:?}");
}

/// Walks from corner to corner with (5.2)-(5.5) and the corrected table alone.
/// Corners that the taut path does not touch are no part of either.
fn check_by_rules(scene: &Scene, gaps: &[f64], path: &DrivingPath) {
    let radius = |corner: usize| scene.footprint.width() / 2.0 + gaps[corner];
    let is_arc = |leg: &&Leg<2>| matches!(leg.curve, Curve::Arc { .. });
    let arcs: Vec<_> = path.legs().iter().filter(is_arc).collect();
    let touched: Vec<_> = arcs.iter().map(|arc| arc.junction.unwrap()).collect();
    let mut from = scene.start.position;
    for (nth, (&index, arc)) in touched.iter().zip(&arcs).enumerate() {
        let corner = &scene.corners[index];
        let (rule, rho) = (corner.rule, radius(index));
        let arriving = rule.arriving_angle(&from, &corner.point, rho);
        let (to, reach) = match touched.get(nth + 1) {
            Some(&next) if scene.corners[next].rule.turn == rule.turn => {
                (scene.corners[next].point, rho - radius(next))
            }
            Some(&next) => (scene.corners[next].point, rho + radius(next)),
            None => (scene.goal.position, rho),
        };
        let leaving = rule.leaving_angle(&corner.point, &to, reach);
        let [arrival, departure] = ends(arc).map(|(position, _)| position);
        let scale = 1e-12 * corner.point.amax().max(10.0);
        let near = |wanted: Vector<2>, is: Vector<2>| {
            let off = (wanted - is).amax();
            assert!(off < scale, "corner {index}: {wanted:?} and {is:?} are {off} apart");
        };
        near(rule.arriving_point(&corner.point, rho, arriving), arrival);
        near(rule.leaving_point(&corner.point, rho, leaving), departure);
        let Curve::Arc { sweep, .. } = arc.curve else { unreachable!() };
        let by_rules = std::f64::consts::FRAC_PI_2 - arriving - leaving;
        assert!((sweep.abs() - by_rules).abs() < 1e-11, "{sweep} {by_rules}");
        from = departure;
    }
}

/// Legs follow each other without a jump in place or heading, from start to goal.
fn check_continuous(scene: &Scene, path: &DrivingPath) {
    let mut at = (scene.start.position, scene.start.heading);
    for leg in path.legs() {
        let [from, to] = ends(leg);
        check_same(at, from, 1e-10);
        if let Curve::Line { from, to, heading, .. } = leg.curve {
            let along = (to - from).normalize();
            assert!((along - unit(heading)).amax() < 1e-9);
        }
        at = to;
    }
    assert!((at.0 - scene.goal.position).amax() < 1e-10);
    if let Some(heading) = scene.goal.heading {
        check_same(at, (scene.goal.position, heading), 1e-10);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn rules_and_tangents_agree(
        scene in corridors(50),
        parts in prop::collection::vec(0.05..1.0, 50),
    ) {
        let mut gaps: Vec<_> =
            (0..scene.corners.len()).map(|i| parts[i] * scene.balanced()).collect();
        let mut path = DrivingPath::default();
        // Very different gaps on both sides of a thin wall: what the refusal says will do, does.
        while let Err(error) = route(&scene.drive(), CornerGaps::PerCorner(&gaps), &mut path, &Budget::default()) {
            let DrivingError::CornersTooClose { first, second, most, .. } = error else {
                panic!("{error}");
            };
            prop_assert!(gaps[first].max(gaps[second]) > most);
            // A little less: where circles just touch, the rules' arc cosines have no digits.
            gaps[first] = gaps[first].min(0.99 * most);
            gaps[second] = gaps[second].min(0.99 * most);
        }
        check_by_rules(&scene, &gaps, &path);
        check_continuous(&scene, &path);
    }

    #[test]
    fn length_grows_with_the_gap_by_the_sum_of_sweeps(scene in corridors(50), part in 0.1..0.9) {
        let gap = part * scene.balanced();
        let mut path = DrivingPath::default();
        let mut length = |gap: f64| {
            route(&scene.drive(), CornerGaps::Uniform(gap), &mut path, &Budget::default()).unwrap();
            let sweeps = path.legs().iter().map(|leg| match leg.curve {
                Curve::Arc { sweep, .. } => sweep.abs(),
                _ => 0.0,
            });
            (path.length(), sweeps.sum::<f64>())
        };
        let step = 1e-5;
        let slope = (length(gap + step).0 - length(gap - step).0) / (2.0 * step);
        let sweeps = length(gap).1;
        prop_assert!((slope - sweeps).abs() < 1e-5 * (1.0 + sweeps), "{slope} {sweeps}");
    }

    #[test]
    fn mirrored_and_turned_corridors_give_mirrored_and_turned_paths(
        scene in corridors(20),
        part in 0.1..0.9,
        goal_heading in prop::option::of(-3.0..3.0),
        moving in any::<bool>(),
    ) {
        let mut scene = scene;
        scene.goal.heading = goal_heading;
        scene.start_turn = if moving { StartTurn::WhileMoving } else { StartTurn::InPlace };
        let gap = CornerGaps::Uniform(part * scene.balanced());
        let mut path = DrivingPath::default();
        route(&scene.drive(), gap, &mut path, &Budget::default()).unwrap();
        let legs = path.legs().to_vec();
        let length = path.length();
        let images = [(mirrored(&scene), mirrored_pose as fn(_) -> _), (turned(&scene), turned_pose)];
        for (other, map) in images {
            route(&other.drive(), gap, &mut path, &Budget::default()).unwrap();
            prop_assert_eq!(legs.len(), path.legs().len());
            prop_assert!((length - path.length()).abs() <= 1e-12 * length);
            for (leg, image) in legs.iter().zip(path.legs()) {
                let [a, b] = ends(leg).map(map);
                let [c, d] = ends(image);
                check_same(a, c, 1e-10);
                check_same(b, d, 1e-10);
            }
        }
    }
}

/// One L corridor, entered upwards and left to the right: rule 1.
fn ell() -> Scene {
    Scene::new(
        &[channel([0.0, 3.0], [0.0, 11.0]), channel([0.0, 13.0], [8.0, 11.0])],
        Pose { position: point(1.3, 1.5), heading: std::f64::consts::FRAC_PI_2 },
        [11.5, 9.6],
    )
}

#[test]
fn eight_orientations_of_one_corridor_are_the_eight_rules() {
    let mut scene = ell();
    let mut found = Vec::new();
    let mut path = DrivingPath::default();
    let mut length = None;
    for _ in 0..2 {
        for _ in 0..4 {
            drive(&scene.drive(), CornerGaps::Uniform(0.6), &mut path, &Budget::default()).unwrap();
            found.push(scene.corners[0].rule.number);
            check_by_rules(&scene, &[0.6], &path);
            check_continuous(&scene, &path);
            let wanted = *length.get_or_insert(path.length());
            assert!((path.length() - wanted).abs() < 1e-12);
            let turning = path.turning().unwrap().value;
            assert!((turning - 0.6).abs() < 1e-12, "{turning}");
            scene = turned(&scene);
        }
        scene = mirrored(&scene);
    }
    assert_eq!(found, [1, 6, 4, 7, 3, 8, 2, 5]);
}

#[test]
fn rows_obey_the_law_of_signs() {
    // Rules 1 to 4: x-sign = -s_out, y-sign = +s_in; rules 5 to 8 the other way about.
    for rule in TABLE_2 {
        let (entering, leaving) = (rule.approach.sign, rule.leave.sign.opposite());
        let wanted = if rule.number <= 4 { [leaving, entering] } else { [entering, leaving] };
        assert_eq!(rule.signs, wanted, "rule {}", rule.number);
        assert_eq!(TurnRule::of(rule.approach, rule.leave).unwrap().number, rule.number);
        // p_n: the side entered first along the approach, the far side along the exit.
        assert_eq!(rule.corner[rule.approach.axis], rule.approach.sign.opposite());
        assert_eq!(rule.corner[rule.leave.axis], rule.leave.sign);
    }
    assert!(TurnRule::of(TABLE_2[0].approach, TABLE_2[0].approach).is_none());
}

#[test]
fn tangent_start_needs_no_turn() {
    let mut scene = ell();
    let mut path = DrivingPath::default();
    route(&scene.drive(), CornerGaps::Uniform(0.6), &mut path, &Budget::default()).unwrap();
    let Curve::Turn { sweep, .. } = path.legs()[0].curve else { panic!("{:?}", path.legs()) };
    scene.start.heading += sweep;
    route(&scene.drive(), CornerGaps::Uniform(0.6), &mut path, &Budget::default()).unwrap();
    assert!(matches!(path.legs()[0].curve, Curve::Line { turned: 0.0, .. }));
}

#[test]
fn turning_while_moving_ends_tangent() {
    let mut scene = ell();
    scene.start_turn = StartTurn::WhileMoving;
    scene.start.heading = 1.0;
    let mut path = DrivingPath::default();
    drive(&scene.drive(), CornerGaps::Uniform(0.6), &mut path, &Budget::default()).unwrap();
    let Curve::Line { heading, turned, .. } = path.legs()[0].curve else { panic!() };
    assert!((heading - turned - 1.0).abs() < 1e-15 && turned > 0.0);
    check_continuous(&scene, &path);
}

#[test]
fn half_a_turn_goes_left() {
    let mut scene = ell();
    scene.corners.clear();
    scene.goal.position = point(1.3, 5.0);
    scene.channels.truncate(1);
    scene.start.heading = -std::f64::consts::FRAC_PI_2;
    scene.goal.heading = Some(-std::f64::consts::FRAC_PI_2);
    let mut path = DrivingPath::default();
    route(&scene.drive(), CornerGaps::Uniform(0.6), &mut path, &Budget::default()).unwrap();
    let sweeps: Vec<_> = path
        .legs()
        .iter()
        .filter_map(|leg| match leg.curve {
            Curve::Turn { sweep, .. } => Some(sweep),
            _ => None,
        })
        .collect();
    assert_eq!(sweeps, [std::f64::consts::PI; 2]);
}

#[test]
fn goal_at_the_start_is_reached_by_turning() {
    let mut scene = ell();
    scene.corners.clear();
    scene.channels.truncate(1);
    scene.goal.position = scene.start.position;
    let mut path = DrivingPath::default();
    drive(&scene.drive(), CornerGaps::Uniform(0.6), &mut path, &Budget::default()).unwrap();
    // Already there, it turns by nothing.
    let Pose { position, heading } = scene.start;
    let stays = Curve::Turn { position, from_heading: heading, sweep: 0.0 };
    assert_eq!(path.legs().iter().map(|leg| leg.curve).collect::<Vec<_>>(), [stays]);
    assert_eq!(path.length().to_bits(), 0.0_f64.to_bits());
    assert!((path.clearance().unwrap().value - 0.75).abs() < 1e-15);
    scene.goal.heading = Some(0.0);
    drive(&scene.drive(), CornerGaps::Uniform(0.6), &mut path, &Budget::default()).unwrap();
    let sweeps = path.legs().iter().map(|leg| leg.curve).collect::<Vec<_>>();
    assert!(matches!(sweeps[..], [Curve::Turn { sweep, .. }] if sweep != 0.0), "{sweeps:?}");
}
