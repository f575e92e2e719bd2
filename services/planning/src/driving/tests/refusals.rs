//! What is refused, and that what the refusal says will do, does.

use crate::budget::Budget;
use std::f64::consts::{FRAC_PI_2, PI};

use super::scene::{Scene, channel, corridor_a, point};
use crate::driving::rules::TABLE_2;
use crate::driving::{
    Corner, CornerGaps, DrivingError, DrivingPath, Pose, StartTurn, drive, route,
};
use crate::free_space::walls::Wall;

fn refused(scene: &Scene, gap: f64) -> DrivingError {
    drive(&scene.drive(), CornerGaps::Uniform(gap), &mut DrivingPath::default(), &Budget::default())
        .unwrap_err()
}

fn accepted(scene: &Scene, gap: f64) {
    drive(
        &scene.drive(),
        CornerGaps::Uniform(gap),
        &mut DrivingPath::default(),
        &Budget::default(),
    )
    .unwrap();
}

fn block(scene: &mut Scene, [ax, ay, bx, by]: [f64; 4]) {
    scene.walls.push(Wall { from: point(ax, ay), to: point(bx, by) });
}

#[test]
fn closed_gap_is_rejected() {
    for gap in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        let DrivingError::GapOutOfRange { corner: 0, least: 0.0, most, .. } =
            refused(&corridor_a(), gap)
        else {
            panic!("{gap}");
        };
        assert!((most - 1.904737509655563).abs() < 1e-12);
    }
}

#[test]
fn gaps_must_be_as_many_as_corners() {
    let error = drive(
        &corridor_a().drive(),
        CornerGaps::PerCorner(&[0.2]),
        &mut DrivingPath::default(),
        &Budget::default(),
    );
    assert_eq!(error, Err(DrivingError::GapCount { has: 1, needs: 3 }));
}

#[test]
fn start_and_goal_must_be_in_their_corridors() {
    let mut scene = corridor_a();
    scene.start.position.x = 3.5;
    assert!(matches!(refused(&scene, 0.2), DrivingError::BodyOutside { .. }));
    let mut scene = corridor_a();
    scene.goal.position.x = 8.0;
    assert!(matches!(refused(&scene, 0.2), DrivingError::GoalOutside { .. }));
}

#[test]
fn start_in_a_wall_is_rejected() {
    let mut scene = corridor_a();
    scene.start.position.x = 0.25;
    let DrivingError::BodyTouchesWall { wall, .. } = refused(&scene, 0.2) else { panic!() };
    assert_eq!(wall.x, 0.0);
}

#[test]
fn goal_in_a_wall_is_rejected() {
    let mut scene = corridor_a();
    scene.goal.position.x = 21.5;
    let DrivingError::GoalTouchesWall { wall, heading, .. } = refused(&scene, 0.2) else {
        panic!()
    };
    assert_eq!(wall.x, 22.0);
    assert!(heading.abs() < 0.3);
}

#[test]
fn start_inside_the_guiding_circle_is_rejected_with_what_is_left() {
    let mut scene = corridor_a();
    scene.start.position = point(2.2, 7.5);
    let DrivingError::GapOutOfRange { corner: 0, gap: 0.6, most, .. } = refused(&scene, 0.6) else {
        panic!();
    };
    assert!((most - (libm::hypot(0.8, 0.5) - 0.5)).abs() < 1e-15);
    route(
        &scene.drive(),
        CornerGaps::Uniform(most),
        &mut DrivingPath::default(),
        &Budget::default(),
    )
    .unwrap();
}

#[test]
fn gap_that_touches_the_outer_wall_is_rejected_with_the_greatest() {
    let DrivingError::GapOutOfRange { corner, most, .. } = refused(&corridor_a(), 1.92) else {
        panic!();
    };
    // sqrt(W^2 - h^2 / 4) - w for 3 m (docs/method.md 6.4).
    assert_eq!(corner, 0);
    assert!((most - 1.904737509655563).abs() < 1e-12);
    accepted(&corridor_a(), most - 1e-9);
}

#[test]
fn narrow_corridor_names_the_width_it_needs() {
    let scene = |wide: f64| {
        let channels = [channel([0.0, wide], [-6.0, wide]), channel([0.0, 9.0], [0.0, wide])];
        let start = Pose { position: point(wide / 2.0, -5.0), heading: FRAC_PI_2 };
        Scene::new(&channels, start, [8.0, wide / 2.0])
    };
    let error = refused(&scene(1.1), 0.01);
    assert_eq!(error, DrivingError::CornerTooNarrow { corner: 0, has: 1.1, needs: 1.25 });
    assert_eq!(
        error.to_string(),
        "corner 0: the corridors are 1.1000 m wide, the robot needs more than 1.2500 m to turn"
    );
    accepted(&scene(1.26), 0.005);
}

#[test]
fn blocked_turn_names_the_heading_that_is_free() {
    let mut scene = corridor_a();
    scene.start.heading = PI;
    block(&mut scene, [1.2, 2.3, 1.2, 2.4]);
    let DrivingError::TurnBlocked { heading, free, wall, .. } = refused(&scene, 0.2) else {
        panic!();
    };
    assert_eq!(wall, point(1.2, 2.3));
    // The post is 0.8 above the centre: the front right corner, a half diagonal
    // away, passes above it and the right side meets it.
    let met = FRAC_PI_2 + libm::asin(0.5 / 0.8);
    assert!(heading < free && (free - met).abs() < 1e-12, "{heading} {free} {met}");
    scene.start.heading = free - 1e-9;
    assert!(matches!(refused(&scene, 0.2), DrivingError::BodyTouchesWall { .. }));
    scene.start.heading = free + 1e-9;
    assert!(matches!(refused(&scene, 0.2), DrivingError::TurnBlocked { .. }));
}

#[test]
fn turn_at_the_goal_is_checked() {
    let mut scene = corridor_a();
    scene.goal.heading = Some(PI);
    accepted(&scene, 0.2);
    block(&mut scene, [20.5, 19.2, 20.5, 19.1]);
    let error = refused(&scene, 0.2);
    let DrivingError::TurnBlocked { position, free, .. } = error else { panic!("{error}") };
    assert_eq!(position, scene.goal.position);
    scene.goal.heading = Some(free - 1e-6);
    accepted(&scene, 0.2);
}

#[test]
fn wall_in_the_way_names_leg_and_place() {
    let mut scene = corridor_a();
    block(&mut scene, [16.0, 17.0, 16.0, 18.0]);
    let error = refused(&scene, 0.2);
    let DrivingError::WallInTheWay { leg, at, wall } = error else { panic!("{error}") };
    let mut path = DrivingPath::default();
    route(&scene.drive(), CornerGaps::Uniform(0.2), &mut path, &Budget::default()).unwrap();
    assert_eq!(leg + 1, path.legs().len());
    assert_eq!(wall.x, 16.0);
    assert!((0.0..path.legs()[leg].curve.length()).contains(&at));
    scene.start_turn = StartTurn::WhileMoving;
    assert!(matches!(refused(&scene, 0.2), DrivingError::WallInTheWay { .. }));
}

#[test]
fn thin_wall_between_unequal_gaps_is_refused_with_what_would_do() {
    // Two turns to the same side about a wall 0.3 thick.
    let channels = [
        channel([0.0, 3.0], [0.0, 9.0]),
        channel([0.0, 6.3], [6.0, 9.0]),
        channel([3.3, 6.3], [0.0, 9.0]),
    ];
    let start = Pose { position: point(1.5, 1.5), heading: FRAC_PI_2 };
    let scene = Scene::new(&channels, start, [4.8, 1.5]);
    let try_gaps = |gaps: [f64; 2]| {
        drive(
            &scene.drive(),
            CornerGaps::PerCorner(&gaps),
            &mut DrivingPath::default(),
            &Budget::default(),
        )
    };
    let Err(DrivingError::CornersTooClose { first: 0, second: 1, has, needs, most }) =
        try_gaps([0.2, 0.9])
    else {
        panic!();
    };
    assert!((has - 0.3).abs() < 1e-12 && (needs - 0.7).abs() < 1e-12);
    assert!((most - 0.5).abs() < 1e-12);
    try_gaps([0.2, most]).unwrap();
}

#[test]
fn opposite_turns_too_close_are_refused_with_what_would_do() {
    // A jog: the way between the two corners is 1.6 wide.
    let channels = [
        channel([0.0, 3.0], [0.0, 9.0]),
        channel([0.0, 6.0], [8.0, 9.6]),
        channel([3.2, 6.0], [8.0, 18.0]),
    ];
    let start = Pose { position: point(1.5, 1.5), heading: FRAC_PI_2 };
    let scene = Scene::new(&channels, start, [4.6, 16.0]);
    let has = libm::hypot(0.2, 1.6);
    let DrivingError::CornersTooClose { first: 0, second: 1, most, .. } = refused(&scene, 0.4)
    else {
        panic!();
    };
    assert!((most - (has - 1.0) / 2.0).abs() < 1e-12);
    route(
        &scene.drive(),
        CornerGaps::Uniform(most),
        &mut DrivingPath::default(),
        &Budget::default(),
    )
    .unwrap();
}

#[test]
fn corner_that_the_path_does_not_touch_is_left_out() {
    // The jog is small: the robot passes it without touching either guiding circle.
    let channels = [
        channel([0.0, 4.0], [0.0, 12.0]),
        channel([0.0, 5.0], [8.0, 12.0]),
        channel([1.0, 5.0], [8.0, 20.0]),
    ];
    let start = Pose { position: point(2.5, 1.5), heading: FRAC_PI_2 };
    let mut scene = Scene::new(&channels, start, [2.5, 18.0]);
    let mut path = DrivingPath::default();
    drive(&scene.drive(), CornerGaps::Uniform(0.2), &mut path, &Budget::default()).unwrap();
    assert_eq!(path.legs().len(), 1);
    assert_eq!(path.turning(), path.clearance());
    assert!((path.clearance().unwrap().value - 0.75).abs() < 1e-12);
    // From further left the first corner is touched, the second is not.
    scene.start.position.x = 3.4;
    scene.goal.position.x = 3.4;
    drive(&scene.drive(), CornerGaps::Uniform(0.2), &mut path, &Budget::default()).unwrap();
    let touched: Vec<_> = path.legs().iter().filter_map(|leg| leg.junction).collect();
    assert_eq!(touched, [0, 0]);
}

#[test]
fn corner_behind_the_one_before_is_refused() {
    // To the right about (1, -1), then to the left about (1, -3), on the way up.
    let mut scene = corridor_a();
    scene.walls.clear();
    scene.channels = vec![channel([-9.0, 9.0], [-9.0, 9.0])];
    scene.start.position = point(0.0, -6.0);
    scene.goal.position = point(0.0, 6.0);
    scene.corners = [(0, 1.0, -1.0), (2, 1.0, -3.0)]
        .map(|(row, x, y)| Corner {
            point: point(x, y),
            rule: &TABLE_2[row],
            width_in: 9.0,
            width_out: 9.0,
        })
        .to_vec();
    let DrivingError::CornerNotPassed { corner: 1, sweep } = refused(&scene, 0.2) else { panic!() };
    assert!(sweep < 0.0);
}

#[test]
fn body_inside_a_solid_is_rejected() {
    // No wall is touched: the solid is larger than the robot.
    let mut scene = corridor_a();
    scene.walls.clear();
    scene.walls.push_box(&channel([-5.0, 8.0], [-5.0, 6.0]));
    assert!(matches!(refused(&scene, 0.2), DrivingError::BodyTouchesWall { .. }));
}

#[test]
fn heading_beyond_half_a_turn_is_the_same_heading() {
    let mut scene = corridor_a();
    let mut path = DrivingPath::default();
    drive(&scene.drive(), CornerGaps::Uniform(0.2), &mut path, &Budget::default()).unwrap();
    let legs = path.legs().to_vec();
    scene.start.heading += 4.0 * PI;
    drive(&scene.drive(), CornerGaps::Uniform(0.2), &mut path, &Budget::default()).unwrap();
    assert_eq!(legs.len(), path.legs().len());
    assert_eq!(legs[1..], path.legs()[1..]);
}
