//! The safest gap, and length against clearance below it.

use std::f64::consts::FRAC_PI_2;

use crate::budget::{Allowance, Budget};
use proptest::prelude::*;

use super::scene::{Scene, approached_at, corridor_a, corridors, point, straight_ell};
use crate::clearance::rectangle::Footprint;
use crate::driving::limits::{balanced_gap, greatest_gap, least_width, outer_radius};
use crate::driving::{CornerGaps, DrivingError, DrivingPath, Pose, StartTurn, drive, safest};
use crate::free_space::walls::Wall;
use crate::geometry::AxisBox;
use crate::motion::Curve;

fn turning(scene: &Scene, gap: f64) -> f64 {
    let mut path = DrivingPath::default();
    let driven = drive(&scene.drive(), CornerGaps::Uniform(gap), &mut path, &Budget::default());
    driven.map_or(0.0, |()| path.turning().unwrap().value)
}

#[test]
fn limits_of_the_worked_robot() {
    let robot = corridor_a().footprint;
    assert_eq!(least_width(&robot), 1.25);
    assert_eq!(balanced_gap(&robot, 3.0), 119.0 / 128.0);
    assert_eq!(balanced_gap(&robot, 4.0), 1.44375);
    assert!((greatest_gap(&robot, 3.0) - 1.904737509655563).abs() < 1e-14);
    assert!((greatest_gap(&robot, 4.0) - 2.929058411375428).abs() < 1e-14);
    assert!((outer_radius(&robot, greatest_gap(&robot, 3.0)) - 3.0).abs() < 1e-15);
}

/// About which corners the way with this gap turns.
fn turned_about(scene: &Scene, gap: f64) -> Vec<usize> {
    let mut path = DrivingPath::default();
    let _ = drive(&scene.drive(), CornerGaps::Uniform(gap), &mut path, &Budget::default());
    let arcs = path.legs().iter().filter(|leg| matches!(leg.curve, Curve::Arc { .. }));
    arcs.filter_map(|leg| leg.junction).collect()
}

/// No gap of a fine series leaves more than the one found. Where corridors overlap, another
/// gap may leave out corners, for another way altogether: that does not count.
fn check_unbeaten(scene: &Scene, found: f64, most: f64) {
    let best = turning(scene, found);
    let corners = turned_about(scene, found);
    for k in 1..=400 {
        let gap = most * f64::from(k) / 400.0;
        let other = turning(scene, gap);
        if other > best + 1e-9 && turned_about(scene, gap) != corners {
            continue;
        }
        assert!(other <= best + 1e-9, "{gap} leaves {other}, {found} only {best}");
    }
}

#[test]
fn pillar_beside_the_way_makes_the_gap_smaller() {
    let mut scene = corridor_a();
    scene.walls.push(Wall { from: point(1.2, 10.2), to: point(1.3, 10.0) });
    let mut path = DrivingPath::default();
    let found = safest(&scene.drive(), &mut path, &Budget::default()).unwrap();
    assert!(found < 119.0 / 128.0);
    assert_eq!(path.turning().unwrap().value, turning(&scene, found));
    check_unbeaten(&scene, found, 1.9);
}

/// The same scene at another size has the same gap, to the precision of 1e-9 m; so, too, where
/// numbers are farther apart than that.
#[test]
fn search_for_the_gap_ends_at_any_size() {
    let found = |size: f64, start_turn| {
        let scaled = |x: f64, y: f64| point(x * size, y * size);
        let channels = [
            AxisBox::new(scaled(0.0, 0.0), scaled(3.0, 11.0)).unwrap(),
            AxisBox::new(scaled(0.0, 8.0), scaled(13.0, 11.0)).unwrap(),
        ];
        // 5 cm from a wall: turned in place, only wide gaps clear it, and none in closed form.
        let start = Pose { position: scaled(0.55, 1.5), heading: FRAC_PI_2 };
        let mut scene = Scene::new(&channels, start, [12.0 * size, 9.5 * size]);
        scene.footprint = Footprint::new(size, 1.5 * size).unwrap();
        scene.start_turn = start_turn;
        let budget = Budget::new(Allowance { steps: 1_000_000, ..Allowance::NONE });
        let gap = safest(&scene.drive(), &mut DrivingPath::default(), &budget)?;
        Ok::<f64, DrivingError>(gap / size)
    };
    for start_turn in [StartTurn::InPlace, StartTurn::WhileMoving] {
        let gap = found(1.0, start_turn).unwrap();
        for size in [1e-6, 1e-3, 1e6, 1e9, 1e12, 1e30, 1e100, 1e149] {
            let scaled = found(size, start_turn);
            let off = scaled.map(|scaled| (scaled - gap).abs());
            let precision = 1e-9 + 1e-9 / size;
            assert!(off.is_ok_and(|off| off <= precision), "{size:e}: {off:?} from {gap}");
        }
        // So small that everything is in contact.
        let refusal = found(1e-30, start_turn).unwrap_err();
        assert!(matches!(refusal, DrivingError::BodyTouchesWall { .. }), "{refusal:?}");
    }
}

#[test]
fn start_near_the_corner_bounds_the_gap() {
    let mut scene = corridor_a();
    scene.start.position = point(2.2, 7.3);
    scene.start.heading = 1.2;
    let most = libm::hypot(0.8, 0.7) - 0.5;
    let found = safest(&scene.drive(), &mut DrivingPath::default(), &Budget::default()).unwrap();
    assert!(found <= most + 1e-12);
    check_unbeaten(&scene, found, most);
}

#[test]
fn corridor_without_a_way_says_why() {
    let mut scene = corridor_a();
    scene.walls.push(Wall { from: point(0.0, 5.0), to: point(3.0, 5.0) });
    let refusal = safest(&scene.drive(), &mut DrivingPath::default(), &Budget::default());
    assert!(matches!(refusal, Err(DrivingError::WallInTheWay { .. })), "{refusal:?}");
}

#[test]
fn no_corner_no_gap() {
    let mut scene = corridor_a();
    scene.corners.clear();
    scene.channels.truncate(1);
    scene.goal.position = point(1.5, 8.0);
    let mut path = DrivingPath::default();
    assert_eq!(safest(&scene.drive(), &mut path, &Budget::default()), Ok(0.0));
    assert_eq!(path.length(), (point(1.5, 8.0) - point(1.2, 1.5)).norm());
}

#[test]
fn parts_of_the_safest_gap_run_from_short_to_safe() {
    let (scene, mut path) = (corridor_a(), DrivingPath::default());
    let found = safest(&scene.drive(), &mut path, &Budget::default()).unwrap();
    assert_eq!(found, 119.0 / 128.0);
    let (mut length, mut turning) = (0.0, 0.0);
    for part in 1..=9 {
        let gap = found * f64::from(part) / 9.0;
        drive(&scene.drive(), CornerGaps::Uniform(gap), &mut path, &Budget::default()).unwrap();
        let clearance = path.turning().unwrap().value;
        assert!(length < path.length() && turning < clearance, "{part} ninths");
        (length, turning) = (path.length(), clearance);
    }
    assert!((length - 31.917340963672473).abs() < 1e-11);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn nothing_beats_the_safest_gap(scene in corridors(6)) {
        let mut path = DrivingPath::default();
        if let Ok(found) = safest(&scene.drive(), &mut path, &Budget::default()) {
            let most = scene.corners.iter().map(crate::driving::Corner::width).fold(f64::INFINITY, f64::min);
            check_unbeaten(&scene, found, most - scene.footprint.width() / 2.0);
        }
    }

    #[test]
    fn single_turn_is_safest_with_the_balanced_gap(robot in (0.4..1.2, 0.4..2.0, 0.3..2.5)) {
        let scene = straight_ell(robot);
        let gap = scene.balanced();
        let scene = approached_at(scene, gap);
        prop_assert_eq!(safest(&scene.drive(), &mut DrivingPath::default(), &Budget::default()), Ok(gap));
    }
}
