use std::f64::consts::{FRAC_PI_2, PI};

use proptest::prelude::*;

use super::*;
use crate::any_angle::{Abilities, Costs, measure};
use crate::clearance::rectangle::Footprint;
use crate::clearance::rectangle::tests::{outline_distance, pose};
use crate::driving::{Goal, Pose, StartTurn};
use crate::free_space::floor::Floor;
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::{Vector, rotated, unit};
use crate::motion::Leg;

/// A scene as people write it.
#[derive(Clone)]
struct Scene {
    walls: Vec<[[f64; 2]; 2]>,
    footprint: Footprint,
    start: ([f64; 2], f64),
    goal: ([f64; 2], Option<f64>),
    abilities: Abilities,
}

fn rectangle(min: [f64; 2], max: [f64; 2]) -> Vec<[[f64; 2]; 2]> {
    outline(&[min, [max[0], min[1]], max, [min[0], max[1]]])
}

fn outline(points: &[[f64; 2]]) -> Vec<[[f64; 2]; 2]> {
    (0..points.len()).map(|index| [points[index], points[(index + 1) % points.len()]]).collect()
}

impl Scene {
    fn new(
        sides: [f64; 2],
        walls: &[Vec<[[f64; 2]; 2]>],
        start: ([f64; 2], f64),
        goal: ([f64; 2], Option<f64>),
    ) -> Self {
        let footprint = Footprint::new(sides[0], sides[1]).unwrap();
        let walls = walls.concat();
        Self { walls, footprint, start, goal, abilities: Abilities::default() }
    }

    fn reverse(mut self) -> Self {
        self.abilities.reverse = true;
        self
    }

    fn moved(&self, angle: f64, by: [f64; 2]) -> Self {
        let place = |point: [f64; 2]| {
            let point = rotated(&point.into(), &unit(angle)) + Vector::from(by);
            [point.x, point.y]
        };
        let mut scene = self.clone();
        for wall in &mut scene.walls {
            *wall = wall.map(place);
        }
        scene.start = (place(self.start.0), self.start.1 + angle);
        scene.goal = (place(self.goal.0), self.goal.1.map(|heading| heading + angle));
        scene
    }

    fn with_errand<T>(&self, run: impl FnOnce(&Errand<'_>, &Budget<'_>) -> T) -> T {
        let budget = Budget::default();
        let mut walls = Walls::default();
        for [from, to] in &self.walls {
            walls.push(Wall { from: (*from).into(), to: (*to).into() });
        }
        walls.index(&budget).unwrap();
        let floor = Floor::new(&walls, &budget).unwrap();
        let errand = Errand {
            footprint: self.footprint,
            start: Pose { position: self.start.0.into(), heading: self.start.1 },
            goal: Goal { position: self.goal.0.into(), heading: self.goal.1 },
            start_turn: StartTurn::InPlace,
            abilities: self.abilities,
            costs: Costs::default(),
            walls: &walls,
            floor: &floor,
        };
        run(&errand, &budget)
    }
}

/// What is found.
#[derive(Debug, Clone)]
struct Measured {
    curves: Vec<Curve<2>>,
    length: f64,
    cost: f64,
}

type Search =
    fn(&Errand<'_>, Kept, &mut LatticeMemory, &Budget<'_>) -> Result<Option<Vec<Curve<2>>>, Spent>;

/// Runs a search and checks its answer: continuous, free, and the same by sampling.
fn run(scene: &Scene, search: Search, least: f64) -> Option<Measured> {
    scene.with_errand(|errand, budget| {
        let mut memory = LatticeMemory::default();
        let curves = search(errand, Kept::all_along(least), &mut memory, budget).unwrap();
        assert!(memory.bytes() > 0);
        let curves = curves?;
        check_continuous(errand, &curves);
        check_by_sampling(errand, &curves);
        let leg = |curve: &Curve<2>| Leg { curve: *curve, junction: None, rule: None, rung: None };
        let legs = curves.iter().map(leg).collect();
        let mut found = crate::any_angle::RobotMotion::default();
        assert_eq!(measure::measure(errand, legs, &mut found, budget), Ok(Vec::new()));
        assert!(found.clearance.is_none_or(|clearance| clearance.value >= least));
        let cost = measure::cost(errand, &found.legs);
        Some(Measured { curves, length: found.length, cost })
    })
}

/// The rectangle touches no wall at many poses.
fn check_by_sampling(errand: &Errand<'_>, curves: &[Curve<2>]) {
    for curve in curves {
        let size = curve.length() + curve.turned().abs();
        let count = (size / 0.02).ceil().max(1.0);
        for sample in 0..=count as u32 {
            let pose = pose(curve, f64::from(sample) / count);
            let distance = outline_distance(&errand.footprint, pose, errand.walls);
            assert!(distance > 0.0, "{pose:?} {curves:?}");
        }
    }
}

/// Each curve begins where the one before it ends, and the whole is what the errand wants.
fn check_continuous(errand: &Errand<'_>, curves: &[Curve<2>]) {
    let (mut at, mut heading) = (errand.start.position, errand.start.heading);
    let same = |a: f64, b: f64| crate::motion::wrapped(a - b).abs() < 1e-8;
    for curve in curves {
        assert!((curve.start() - at).norm() < 1e-8, "{curves:?}");
        assert!(same(curve.start_heading(), heading), "{curves:?}");
        (at, heading) = (curve.end(), curve.end_heading());
    }
    assert!((at - errand.goal.position).norm() < 1e-8, "{curves:?}");
    assert!(errand.goal.heading.is_none_or(|goal| same(goal, heading)), "{curves:?}");
}

fn door_align() -> Scene {
    let walls = [
        rectangle([0.0, 0.0], [10.0, 10.0]),
        rectangle([4.95, 0.0], [5.05, 4.65]),
        rectangle([4.95, 5.35], [5.05, 10.0]),
    ];
    Scene::new([0.42, 1.4], &walls, ([2.0, 3.0], 0.0), ([8.0, 7.0], None))
}

fn bay() -> Scene {
    let walls = [outline(&[
        [4.65, 0.0],
        [5.35, 0.0],
        [5.35, 2.0],
        [10.0, 2.0],
        [10.0, 5.0],
        [0.0, 5.0],
        [0.0, 2.0],
        [4.65, 2.0],
    ])];
    Scene::new([0.6, 1.2], &walls, ([5.0, 0.8], FRAC_PI_2), ([9.0, 3.5], None))
}

fn dead_end() -> Scene {
    let walls =
        [outline(&[[0.0, 0.0], [1.0, 0.0], [1.0, 6.0], [8.0, 6.0], [8.0, 8.0], [0.0, 8.0]])];
    Scene::new([0.6, 1.2], &walls, ([0.5, 1.0], -FRAC_PI_2), ([7.0, 7.0], None)).reverse()
}

fn straight_door() -> Scene {
    let walls = [
        rectangle([0.0, 0.0], [10.0, 6.0]),
        rectangle([4.9, 0.0], [5.1, 2.5]),
        rectangle([4.9, 3.5], [5.1, 6.0]),
    ];
    Scene::new([0.6, 1.8], &walls, ([2.0, 3.0], 0.0), ([8.0, 3.0], None))
}

fn door_offset() -> Scene {
    Scene { start: ([2.0, 1.0], 0.0), goal: ([8.0, 5.0], None), ..straight_door() }
}

fn needs_reverse() -> Scene {
    let mut walls = vec![rectangle([0.0, 0.0], [10.0, 8.0])];
    let tops = [5.623_631_6, 5.808_440_1, 6.285_068_5, 6.021_192_1, 6.182_901_7];
    for (index, top) in tops.into_iter().enumerate() {
        let right = 1.781_752_05 * (index + 1) as f64;
        walls.push(rectangle([right - 0.8, 0.0], [right, top]));
    }
    Scene::new([0.6, 1.2], &walls, ([9.3, 1.1], -FRAC_PI_2), ([3.5, 7.2], None)).reverse()
}

fn aligned_refused() -> Scene {
    let walls = [outline(&[
        [-2.894, -1.097],
        [0.0, -1.097],
        [0.0, 1.097],
        [-0.783, 1.097],
        [-0.783, 3.768],
        [1.076, 3.768],
        [1.076, 3.235],
        [2.248, 3.235],
        [2.248, 5.195],
        [-2.894, 5.195],
    ])];
    Scene::new([0.6, 1.5], &walls, ([-0.85, 0.0], -PI), ([1.662, 4.085], None))
}

fn four_squares() -> Scene {
    let walls = [
        rectangle([0.0, 0.0], [10.0, 8.0]),
        outline(&[[3.614, 2.189], [3.308, 2.584], [2.913, 2.278], [3.219, 1.883]]),
        outline(&[[3.112, 2.037], [2.803, 2.430], [2.410, 2.122], [2.719, 1.728]]),
        outline(&[[7.826, 5.274], [7.379, 5.497], [7.156, 5.049], [7.604, 4.827]]),
        outline(&[[3.516, 3.959], [3.271, 4.395], [2.835, 4.149], [3.081, 3.714]]),
    ];
    Scene::new([0.6, 0.9], &walls, ([1.0, 1.0], 0.3), ([9.0, 7.0], None))
}

/// A robot with this least radius, that can't turn in place.
fn car(scene: Scene, min_turn_radius: f64, reverse: bool) -> Scene {
    let abilities = Abilities { reverse, turn_in_place: false, min_turn_radius };
    Scene { abilities, ..scene }
}

/// A car turns around in a road.
fn road(reverse: bool) -> Scene {
    let walls = [rectangle([0.0, 0.0], [12.0, 3.0])];
    let scene = Scene::new([0.6, 1.2], &walls, ([6.0, 1.5], 0.0), ([3.0, 1.5], Some(PI)));
    car(scene, 1.0, reverse)
}

/// The answer, the same for the scene turned, and turned and moved.
fn check(scene: &Scene, search: Search, most_cost: f64) -> Measured {
    let found = run(scene, search, 0.0).expect("a way");
    assert!(found.cost <= most_cost, "{found:?}");
    for (degrees, by) in [(10.0_f64, [0.0, 0.0]), (33.0, [0.0, 0.0]), (33.0, [1e6, -1e6])] {
        let other = run(&scene.moved(degrees.to_radians(), by), search, 0.0).expect("a way");
        let same = |a: f64, b: f64| (a - b).abs() <= 2e-9 * a;
        assert!(same(found.length, other.length), "{degrees} {by:?}: {found:?} {other:?}");
        assert!(same(found.cost, other.cost), "{degrees} {by:?}: {found:?} {other:?}");
    }
    found
}

/// Straight to the goal: sqrt(52) = 7.211 m, a turn by atan(2 / 3), with 5 cm to spare.
#[test]
fn long_robot_lines_up_with_a_door() {
    let straight = 52.0_f64.sqrt();
    let turn = Costs::default().turn * libm::atan2(2.0, 3.0);
    for search in [aligned, search] {
        let found = check(&door_align(), search, straight + turn + 1e-9);
        assert!((found.length - straight).abs() < 1e-9);
        check(&door_offset(), search, straight + turn + 1e-9);
    }
    // With more to spare it lines up: at most (2, 3), (3.5, 5), (6.5, 5), (8, 7).
    let found = run(&door_align(), aligned, 0.13).expect("a way");
    assert!(found.length <= 8.0, "{found:?}");
}

#[test]
fn door_straight_ahead_is_passed_without_a_turn() {
    let found = check(&straight_door(), aligned, 6.0);
    assert_eq!(found.curves.len(), 1);
}

/// Straight out to (5, 3.5), a quarter turn, to (9, 3.5): 6.7 m.
#[test]
fn robot_in_a_bay_drives_out_before_it_turns() {
    let most = 6.7 + Costs::default().turn * FRAC_PI_2 + Costs::default().stop;
    check(&bay(), aligned, most);
    let found = run(&bay(), aligned, 0.049).expect("a way");
    assert!(found.length <= 6.7, "{found:?}");
    // Backwards, if it stands the other way round.
    let mut scene = bay();
    scene.start.1 = -FRAC_PI_2;
    assert!(run(&scene, aligned, 0.0).is_none());
    check(&scene.reverse(), aligned, most);
}

/// Back along the corridor and around its corner: 11.51 m, with no stop.
#[test]
fn robot_backs_out_of_a_dead_end() {
    let found = check(&dead_end(), search, 11.545);
    assert!(found.curves.iter().all(Curve::is_reverse), "{found:?}");
}

#[test]
fn aisle_is_left_backwards() {
    let found = check(&needs_reverse(), aligned, 11.57);
    assert!(found.curves.iter().any(Curve::is_reverse));
    let forward = Scene { abilities: Abilities::default(), ..needs_reverse() };
    assert!(run(&forward, aligned, 0.0).is_none());
}

#[test]
fn corner_with_little_room_is_turned_on_arcs() {
    check(&aligned_refused(), search, 8.0);
}

/// Past the corner at (2.307, 2.454) or the like: 10.05 m.
#[test]
fn way_between_slanted_squares_is_short() {
    let found = check(&four_squares(), aligned, 10.36);
    assert!(found.length < 10.06);
}

#[test]
fn car_turns_around_in_a_road() {
    let three_points = check(&road(true), search, 4.6);
    let senses: Vec<_> = three_points.curves.iter().map(Curve::is_reverse).collect();
    assert!(senses.contains(&true) && senses.contains(&false));
    let turns = |curve: &Curve<2>| matches!(curve, Curve::Turn { .. });
    assert!(!three_points.curves.iter().any(turns));
    // Forwards it runs around a circle.
    let forward = check(&road(false), search, 10.1);
    assert!(!forward.curves.iter().any(Curve::is_reverse));
    for curve in three_points.curves.iter().chain(&forward.curves) {
        assert!(!matches!(curve, Curve::Arc { radius, .. } if *radius < 1.0));
    }
}

#[test]
fn car_drives_between_obstacles() {
    check(&car(four_squares(), 0.8, false), search, 10.1);
    check(&car(dead_end(), 0.5, true), search, 11.65);
    assert!(run(&car(dead_end(), 0.5, false), search, 0.0).is_none());
}

/// Through 100 rooms of 4 m with a door of 0.75 m to each neighbour: nine to the right and nine
/// up. The doors are in line, so that 18 of them cost 36 m along the axes.
#[test]
fn way_through_many_rooms_is_found() {
    let mut walls = vec![rectangle([0.0, 0.0], [40.0, 40.0])];
    for line in 1..10 {
        let middle = 4.0 * f64::from(line);
        for room in 0..10 {
            let from = 4.0 * f64::from(room);
            // From one door to the next, with the crossing in the middle.
            let (first, last) = (from - 1.625, from + 1.625);
            let (first, last) = (first.max(0.05), if room == 9 { 37.625 } else { last });
            walls.push(rectangle([middle - 0.05, first], [middle + 0.05, last]));
            walls.push(rectangle([first, middle - 0.05], [last, middle + 0.05]));
        }
    }
    let scene = Scene::new([0.6, 1.2], &walls, ([2.0, 2.0], 0.0), ([38.0, 38.0], None));
    let turn = Costs::default().turn * FRAC_PI_2 + Costs::default().stop;
    let found = run(&scene.moved(0.3, [0.0, 0.0]), aligned, 0.0).expect("a way");
    assert!(found.cost <= 72.0 + turn, "{found:?}");
}

/// A bend that a robot of this length can't pass at all.
#[test]
fn way_for_a_disc_alone_is_no_way() {
    let bend = outline(&[[0.0, 0.0], [8.0, 0.0], [8.0, 9.0], [7.3, 9.0], [7.3, 0.7], [0.0, 0.7]]);
    let room = outline(&[
        [-20.0, -10.0],
        [0.0, -10.0],
        [0.0, 0.0],
        [8.0, 0.0],
        [8.0, 9.0],
        [7.3, 9.0],
        [7.3, 0.7],
        [0.0, 0.7],
        [0.0, 10.0],
        [-20.0, 10.0],
    ]);
    for walls in [bend, room] {
        let scene = Scene::new([0.6, 1.4], &[walls], ([1.0, 0.35], 0.0), ([7.65, 8.0], None));
        assert!(run(&scene.clone().reverse(), aligned, 0.0).is_none());
        scene.reverse().with_errand(|errand, budget| {
            let mut memory = LatticeMemory::default();
            assert_eq!(search(errand, Kept::all_along(0.0), &mut memory, budget), Ok(None));
            assert!(memory.resolution().is_some_and(|resolution| resolution.step <= 0.075));
        });
    }
}

#[test]
fn passage_too_narrow_for_a_disc_is_no_way() {
    let walls = [
        rectangle([0.0, 0.0], [4.0, 2.0]),
        rectangle([1.9, 0.0], [2.1, 0.85]),
        rectangle([1.9, 1.15], [2.1, 2.0]),
    ];
    let scene = Scene::new([0.6, 0.8], &walls, ([0.8, 1.0], 0.0), ([3.2, 1.0], None));
    scene.with_errand(|errand, budget| {
        let mut memory = LatticeMemory::default();
        assert_eq!(search(errand, Kept::all_along(0.0), &mut memory, budget), Ok(None));
        assert_eq!(memory.resolution(), None);
    });
}

/// A search that ends at its own limit has not looked everywhere, and says so.
#[test]
fn search_that_meets_its_limit_says_so() {
    door_align().with_errand(|errand, budget| {
        let mut memory = LatticeMemory::default();
        let mut is_cut_short = |most_steps: u64| {
            let level = Level { most_steps, ..COARSE };
            let run = |probes: &Probes<'_>, memory: &mut _| straight(probes, level, memory);
            let kept = Kept::all_along(0.0);
            let found = in_own_scene((errand, kept), &mut memory, budget, run).unwrap();
            (found.is_some(), memory.resolution().unwrap().is_cut_short)
        };
        assert_eq!(is_cut_short(1), (false, true));
        assert_eq!(is_cut_short(COARSE.most_steps), (true, false));
        memory.end(budget);
    });
}

#[test]
fn spent_budget_ends_a_search() {
    needs_reverse().with_errand(|errand, _| {
        let limits = crate::budget::Allowance { steps: 20_000, ..crate::budget::Allowance::NONE };
        let budget = Budget::new(limits);
        let spent = search(errand, Kept::all_along(0.0), &mut LatticeMemory::default(), &budget);
        assert!(matches!(spent, Err(Spent::Limit { most: 20_000, .. })));
        let limits = crate::budget::Allowance { bytes: 20_000, ..crate::budget::Allowance::NONE };
        let budget = Budget::new(limits);
        let spent = search(errand, Kept::all_along(0.0), &mut LatticeMemory::default(), &budget);
        assert!(matches!(spent, Err(Spent::Limit { most: 20_000, .. })));
        assert_eq!(budget.drawn(crate::budget::Cap::Bytes), 0);
    });
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    /// A door in a slanted wall, 5 cm wider than the robot on each side.
    #[test]
    fn narrow_door_is_found(
        length in 0.8..1.8_f64,
        slant in -0.35..0.35_f64,
        door in 3.0..7.0_f64,
        thick in 0.05..0.5_f64,
        start in -3.0..3.0_f64,
        goal in proptest::option::of(-3.0..3.0_f64),
        turned in -3.0..3.0_f64,
    ) {
        let along = unit(FRAC_PI_2 + slant);
        let across = Vector::<2>::new(along.y, -along.x) * thick;
        let middle = Vector::from([5.0, 5.0]) - along * 5.0;
        let part = |from: f64, to: f64| {
            let ends = [middle + along * from, middle + along * to];
            outline(&[ends[0].into(), ends[1].into(), (ends[1] + across).into(), (ends[0] + across).into()])
        };
        let walls = [
            rectangle([0.0, -2.0], [10.0, 12.0]),
            part(-5.0, door - 0.35),
            part(door + 0.35, 15.0),
        ];
        // The walls stand on the floor's border; the ends of the slanted ones lie outside.
        let scene = Scene::new([0.6, length], &walls, ([1.2, 0.0], start), ([8.8, 10.0], goal));
        let found = run(&scene.moved(turned, [0.0, 0.0]), aligned, 0.0);
        prop_assert!(found.is_some());
    }

    /// From bay to bay.
    #[test]
    fn robot_leaves_a_bay_and_enters_another(
        length in 0.7..1.6_f64,
        depth in 1.0..3.0_f64,
        width in 0.66..0.9_f64,
        slant in -0.5..0.5_f64,
        turned in -3.0..3.0_f64,
    ) {
        let along = unit(-FRAC_PI_2 + slant);
        let bay = |x: f64, y: f64, along: Vector<2>| {
            let across = Vector::<2>::new(-along.y, along.x) * (width / 2.0);
            let mouth = Vector::from([x, y]);
            let end = mouth + along * (depth + length);
            let ends = [mouth - across, end - across, end + across, mouth + across];
            // Up to the border of the room.
            ends.map(|point| [point.x, point.y])
        };
        let [a, b, c, d] = bay(2.0, 0.0, along);
        let [e, f, g, h] = bay(8.0, 0.0, Vector::from([0.0, -1.0]));
        let cut = |point: [f64; 2]| [point[0] - point[1] * along.x / along.y, 0.0];
        let walls = [outline(&[
            [-2.0, 0.0], cut(a), b, c, cut(d), e, f, g, h, [12.0, 0.0], [12.0, 4.5], [-2.0, 4.5],
        ])];
        let deep = Vector::from([2.0, 0.0]) + along * (depth + 0.4 * length);
        let scene = Scene::new(
            [0.6, length],
            &walls,
            (deep.into(), -FRAC_PI_2 + slant + PI),
            ([8.0, -depth - 0.4 * length], Some(-FRAC_PI_2)),
        );
        let found = run(&scene.moved(turned, [0.0, 0.0]), aligned, 0.0);
        prop_assert!(found.is_some());
    }
}
