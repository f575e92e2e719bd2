//! Random corridors: nothing leaves the free space, and the clearance is exact.

use std::f64::consts::FRAC_PI_2;

use proptest::prelude::*;

use super::scene::{Scene, corridors, robots};
use crate::budget::Budget;
use crate::clearance::rectangle::tests::{check_densely, pose};
use crate::driving::{Corner, CornerGaps, DrivingPath, StartTurn, drive};
use crate::geometry::{AxisBox, Direction, unit};
use crate::motion::Curve;

/// All corners of the footprint, at many placements, lie in channels.
fn check_in_free_space(scene: &Scene, curve: &Curve<2>) {
    let footprint = &scene.footprint;
    let (front, rear, b) = (footprint.front(), footprint.rear(), footprint.width() / 2.0);
    for index in 0..=40 {
        let (x, y, heading) = pose(curve, f64::from(index) / 40.0);
        let (sin, cos) = (libm::sin(heading), libm::cos(heading));
        for (ahead, left) in [(front, b), (front, -b), (-rear, b), (-rear, -b), (0.0, 0.0)] {
            let (x, y) = (x + ahead * cos - left * sin, y + ahead * sin + left * cos);
            let inside = scene.channels.iter().any(|channel| {
                let (min, max) = (channel.min(), channel.max());
                min.x <= x && x <= max.x && min.y <= y && y <= max.y
            });
            assert!(inside, "({x}, {y}) is outside on {curve:?}");
        }
    }
}

/// Every leg's clearance against dense placements; the whole from its parts.
fn check_path(scene: &Scene, path: &DrivingPath) {
    assert_eq!(path.legs().len(), path.leg_clearances().len());
    let mut least = f64::INFINITY;
    for (leg, &value) in path.legs().iter().zip(path.leg_clearances()) {
        check_in_free_space(scene, &leg.curve);
        check_densely(&scene.footprint, &leg.curve, &scene.walls, 40, value);
        least = least.min(value);
    }
    let whole = path.clearance().unwrap();
    assert_eq!(whole.value, least);
    assert!(whole.value > 0.0 && (0.0..=path.length()).contains(&whole.at));
    assert!(path.turning().unwrap().value >= least);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]

    #[test]
    fn gaps_up_to_the_balanced_one_are_kept(
        scene in corridors(50),
        part in 0.05..1.0,
        moving in any::<bool>(),
    ) {
        let mut scene = scene;
        scene.start_turn = if moving { StartTurn::WhileMoving } else { StartTurn::InPlace };
        let gap = part * scene.balanced();
        let mut path = DrivingPath::default();
        drive(&scene.drive(), CornerGaps::Uniform(gap), &mut path, &Budget::default()).unwrap();
        check_path(&scene, &path);
        // docs/method.md 6.3: with g up to g* nothing comes closer than the corners; only
        // where start or goal are nearer to the inner wall than the guiding circle
        // the angle is negative, and the body's inner corner comes closer.
        let rho = scene.footprint.width() / 2.0 + gap;
        let (first, last) = (&scene.corners[0], scene.corners.last().unwrap());
        let arriving = first.rule.arriving_angle(&scene.start.position, &first.point, rho);
        let leaving = last.rule.leaving_angle(&last.point, &scene.goal.position, rho);
        let (front, rear) = (scene.footprint.front(), scene.footprint.rear());
        let across = scene.footprint.width() + gap;
        // As it arrives the rear is towards the inner wall, the front towards the outer one.
        let sides = [(arriving, first.width_in, rear, front), (leaving, last.width_out, front, rear)];
        let least = sides.map(|(angle, width, inner, outer)| {
            let (sin, cos) = libm::sincos(angle.min(0.0));
            (gap * cos + inner * sin).min(width - across * cos + outer * sin)
        });
        let least = least[0].min(least[1]);
        let turning = path.turning().unwrap().value;
        prop_assert!(turning >= least - 1e-9, "{turning} is less than {least}");
    }

    #[test]
    fn whatever_is_driven_stays_in_the_free_space(
        scene in corridors(12),
        parts in prop::collection::vec(0.05..2.5, 12),
    ) {
        let gaps: Vec<_> = scene.corners.iter().zip(&parts)
            .map(|(corner, part)| part * scene.balanced().min(corner.width()))
            .collect();
        let mut path = DrivingPath::default();
        if drive(&scene.drive(), CornerGaps::PerCorner(&gaps), &mut path, &Budget::default()).is_ok() {
            check_path(&scene, &path);
        }
    }

    #[test]
    fn same_question_same_answer(scene in corridors(20), other in corridors(50), part in 0.1..0.9) {
        let gap = CornerGaps::Uniform(part * scene.balanced());
        let mut path = DrivingPath::default();
        let first = drive(&scene.drive(), gap, &mut path, &Budget::default());
        let before = path.clone();
        let _ = drive(&other.drive(), gap, &mut path, &Budget::default());
        prop_assert_eq!(drive(&scene.drive(), gap, &mut path, &Budget::default()), first);
        prop_assert_eq!(before.legs(), path.legs());
        prop_assert_eq!(before.leg_clearances(), path.leg_clearances());
        prop_assert_eq!((before.clearance(), before.turning()), (path.clearance(), path.turning()));
    }

    /// docs/method.md 6.2: the closed forms of a single turn, where its angles are small.
    #[test]
    fn single_turn_obeys_the_closed_forms(
        robot in (robots(), 0.3..2.5),
        part in 0.05..0.99,
    ) {
        use crate::driving::limits::{greatest_gap, outer_radius};
        let scene = super::scene::straight_ell(robot);
        let width = scene.corners.iter().map(Corner::width).fold(f64::INFINITY, f64::min);
        let gap = part * greatest_gap(&scene.footprint, width);
        let mut path = DrivingPath::default();
        let scene = super::scene::approached_at(scene, gap);
        drive(&scene.drive(), CornerGaps::Uniform(gap), &mut path, &Budget::default()).unwrap();
        let wanted = gap.min(width - outer_radius(&scene.footprint, gap));
        let turning = path.turning().unwrap();
        prop_assert!((turning.value - wanted).abs() < 1e-12, "{} {wanted}", turning.value);
    }

    /// docs/method.md 6.3: the clearance from the first arc to the last in closed form. It may
    /// be more where a turn is too short for the robot's outer corners, or where corridors
    /// cross and so lack walls.
    #[test]
    fn corridors_obey_the_closed_form(scene in corridors(20), part in 0.05..1.6) {
        let gap = part * scene.balanced();
        let mut path = DrivingPath::default();
        if drive(&scene.drive(), CornerGaps::Uniform(gap), &mut path, &Budget::default()).is_err() {
            return Ok(());
        }
        let arcs: Vec<_> = path
            .legs()
            .iter()
            .filter_map(|leg| match leg.curve {
                Curve::Arc { start_angle, sweep, .. } => Some((start_angle, sweep)),
                _ => None,
            })
            .collect();
        prop_assume!(arcs.len() == scene.corners.len());
        // In the corridor that it leaves the outer rear corner lags behind, in the next one,
        // seen backwards, the front one; the other of the two leads.
        let across = scene.footprint.width() + gap;
        let (front, rear) = (scene.footprint.front(), scene.footprint.rear());
        let lags = [(rear, front), (front, rear)];
        let circle = |along: f64| (libm::hypot(across, along), libm::atan2(along, across));
        let crossing = scene.channels.iter().enumerate().any(|(index, channel)| {
            let mut later = scene.channels.iter().skip(index + 2);
            later.any(|other| channel.intersection(other).is_some())
        });
        // A body that hardly reaches ahead may have its outer corner where a channel that goes on
        // beyond the junction leaves no wall.
        let ends = |channel: &AxisBox<2>, along: Direction| {
            let ends = [channel.min(), channel.max()].map(|end| along.coordinate(&end));
            [ends[0].min(ends[1]), ends[0].max(ends[1])]
        };
        let goes_on = scene.channels.windows(2).zip(&scene.corners).any(|(pair, corner)| {
            let (approach, leave) = (corner.rule.approach, corner.rule.leave);
            ends(&pair[0], approach)[1] > ends(&pair[1], approach)[1]
                || ends(&pair[1], leave)[0] < ends(&pair[0], leave)[0]
        });
        let (mut wanted, mut more) = (gap, crossing || (front != rear && goes_on));
        for (&(start_angle, sweep), corner) in arcs.iter().zip(&scene.corners) {
            let angle = |turned: f64, along: Direction, across: Direction| {
                let heading = unit(start_angle + turned + FRAC_PI_2.copysign(sweep));
                libm::atan2(across.coordinate(&heading), along.coordinate(&heading))
            };
            let (approach, leave) = (corner.rule.approach, corner.rule.leave);
            let angles = [angle(0.0, approach, leave), angle(sweep, leave, approach)];
            let widths = [corner.width_in, corner.width_out];
            for (side, width) in widths.into_iter().enumerate() {
                let (theta, other) = (angles[side], angles[1 - side]);
                let (lagging, leading) = lags[side];
                let (outer, lag) = circle(lagging);
                wanted = wanted.min(width - outer * libm::cos((theta - lag).max(0.0)));
                let (outer, lead) = circle(leading);
                wanted = wanted.min(width - outer * libm::cos((theta + lead).max(0.0)));
                let (sin, cos) = libm::sincos(theta.min(0.0));
                wanted = wanted.min(gap * cos + lagging * sin);
                more |= other > FRAC_PI_2 - lag;
            }
        }
        let turning = path.turning().unwrap().value;
        prop_assert!(turning > wanted - 1e-9, "{turning} is less than {wanted}");
        prop_assert!(more || turning < wanted + 1e-9, "{turning} is not {wanted}");
    }
}
