//! Motions of all rungs: continuous, free of walls by dense sampling, and no shorter than their
//! bound.

use proptest::prelude::*;

use super::scene::{Room, floor, rooms};
use crate::any_angle::{Abilities, Costs, Errand, NoMotion, Planner, RobotMotion, Wish, drive};
use crate::budget::{Allowance, Budget, Cap, Spent};
use crate::clearance::rectangle::Footprint;
use crate::clearance::rectangle::tests::{outline_distance, pose};
use crate::driving::{Goal, Pose, StartTurn};
use crate::geometry::{Vector, rotated, unit};
use crate::motion::{Curve, wrapped};

#[track_caller]
fn check(errand: &Errand<'_>, found: &RobotMotion) {
    let (mut at, mut heading) = (errand.start.position, wrapped(errand.start.heading));
    let mut length = 0.0;
    for (leg, clearance) in found.legs.iter().zip(&found.leg_clearances) {
        let curve = &leg.curve;
        assert!((curve.start() - at).norm() < 1e-9, "{at:?} {curve:?}");
        assert!(wrapped(curve.start_heading() - heading).abs() < 1e-9, "{heading} {curve:?}");
        let steps = 2 + ((curve.length() + curve.turned().abs()) * 50.0) as usize;
        for step in 0..=steps {
            let pose = pose(curve, step as f64 / steps as f64);
            let distance = outline_distance(&errand.footprint, pose, errand.walls);
            assert!(distance >= clearance - 1e-9, "{distance} < {clearance} {curve:?}");
        }
        assert!(*clearance > 0.0);
        // On the taut path it may turn by more than a quarter turn on its first line.
        if curve.is_reverse() && !matches!(curve, Curve::Line { turned, .. } if *turned != 0.0) {
            assert!(errand.abilities.reverse);
        }
        length += curve.length();
        (at, heading) = (curve.end(), curve.end_heading());
    }
    assert!((errand.goal.position - at).norm() < 1e-9);
    if let Some(goal) = errand.goal.heading {
        assert!(wrapped(goal - heading).abs() < 1e-9);
    }
    assert!((found.length - length).abs() < 1e-9);
    assert!(found.bound <= found.length + 1e-9, "{} {}", found.bound, found.length);
    let least = found.leg_clearances.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((found.clearance.unwrap().value - least).abs() < 1e-9);
    assert!(found.free_clearance >= least - 1e-9);
}

fn footprints() -> impl Strategy<Value = Footprint> {
    let sizes = (0.1..0.8f64, 0.1..0.8f64, 0.1..0.8f64);
    prop_oneof![
        (0.1..0.8f64, 0.1..1.2f64).prop_map(|(width, length)| Footprint::new(width, length)),
        sizes.prop_map(|(width, front, rear)| Footprint::offset(width, front, rear)),
    ]
    .prop_map(Result::unwrap)
}

/// Where the robot stands and where it goes, with what it may do.
fn ends() -> impl Strategy<Value = (Pose, Goal, bool)> {
    let point = || prop::array::uniform2(0.3..9.7f64);
    (point(), -3.1..3.1f64, point(), prop::option::of(-3.1..3.1f64), any::<bool>()).prop_map(
        |(start, from, goal, to, reverse)| {
            let start = Pose { position: start.into(), heading: from };
            (start, Goal { position: goal.into(), heading: to }, reverse)
        },
    )
}

fn with_errand<T>(
    room: &Room,
    footprint: Footprint,
    (start, goal, reverse): (Pose, Goal, bool),
    run: impl FnOnce(&Errand<'_>) -> T,
) -> T {
    let walls = room.walls(|point| point);
    let floor = floor(&walls);
    run(&Errand {
        footprint,
        start,
        goal,
        start_turn: StartTurn::InPlace,
        abilities: Abilities { reverse, ..Abilities::default() },
        costs: Costs::default(),
        walls: &walls,
        floor: &floor,
    })
}

fn find(errand: &Errand<'_>, wish: Wish, planner: &mut Planner) -> Result<RobotMotion, NoMotion> {
    let mut found = RobotMotion::default();
    drive(errand, wish, planner, &mut found, &Budget::default()).map(|()| found)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn motions_are_free_and_no_shorter_than_their_bound(
        room in rooms(),
        footprint in footprints(),
        ends in ends(),
        gap in 0.001..0.4f64,
    ) {
        let (start, goal, _) = ends;
        prop_assume!(!room.is_taken(&start.position, 0.0) && !room.is_taken(&goal.position, 0.0));
        with_errand(&room, footprint, ends, |errand| {
            let mut planner = Planner::default();
            if let Ok(found) = find(errand, Wish::Gap(gap), &mut planner) {
                check(errand, &found);
                let is_taut = found.legs.iter().all(|leg| leg.rung == Some(crate::motion::Rung::Taut));
                if is_taut && found.free_clearance >= gap {
                    assert!(found.length <= 1.001 * found.bound + 1e-9, "{found:?}");
                }
            }
            if let Ok(found) = find(errand, Wish::AtLeast(gap), &mut planner) {
                check(errand, &found);
                assert!(found.free_clearance >= gap - 1e-9);
            }
            // Whatever the rung, it takes up its first heading as it is asked to.
            let errand = Errand { start_turn: StartTurn::WhileMoving, ..*errand };
            for wish in [Wish::Gap(gap), Wish::AtLeast(gap)] {
                let Ok(found) = find(&errand, wish, &mut planner) else { continue };
                check(&errand, &found);
                let curves: Vec<_> = found.legs.iter().map(|leg| leg.curve).collect();
                let turns_first =
                    matches!(curves[..], [Curve::Turn { .. }, Curve::Line { .. }, ..]);
                assert!(!turns_first, "{found:?}");
            }
        });
    }

}

proptest! {
    // Fifty motions each, some of which take a search over poses.
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn no_gap_beats_the_safest(room in rooms(), footprint in footprints(), ends in ends()) {
        let (start, goal, _) = ends;
        prop_assume!(!room.is_taken(&start.position, 0.0) && !room.is_taken(&goal.position, 0.0));
        with_errand(&room, footprint, ends, |errand| {
            let mut planner = Planner::default();
            let safest = find(errand, Wish::Safest, &mut planner);
            if let Ok(found) = &safest {
                check(errand, found);
            }
            let mut best = 0.0_f64;
            for gap in 1..=50 {
                let gap = f64::from(gap) * 0.02;
                let Ok(found) = find(errand, Wish::Gap(gap), &mut planner) else { continue };
                best = best.max(found.free_clearance);
                let safest = safest.as_ref().expect("a motion, as with a gap");
                let [least, most] = [&found, safest].map(|found| found.free_clearance);
                assert!(most >= least - 1e-9, "gap {gap}: {least} > {most}");
                // With any heading at the goal, what the robot keeps there depends on the way.
                if errand.goal.heading.is_some() {
                    let [least, most] =
                        [&found, safest].map(|found| found.clearance.unwrap().value);
                    assert!(most >= least - 1e-9, "gap {gap}: {least} > {most}");
                }
            }
            // What a gap reaches, or the safest, can be asked for by itself.
            let Ok(safest) = safest else { return };
            for least in [best, safest.free_clearance].into_iter().filter(|least| least.is_finite())
            {
                let found = find(errand, Wish::AtLeast(least), &mut planner).expect("a motion");
                check(errand, &found);
                assert!(found.free_clearance >= least - 1e-9);
            }
        });
    }
}

/// Two bars in line between start and goal, in a room that lies in any direction: the path turns at both
/// outer corners, and goes straight past those between them.
#[test]
fn corners_in_line_are_no_turns() {
    let bar = |from: f64, to: f64| {
        [[from, 4.0], [to, 4.0], [to, 6.0], [from, 6.0]].map(Vector::<2>::from).to_vec()
    };
    let room = Room { size: 20.0, solids: vec![bar(4.0, 9.0), bar(11.0, 16.0)] };
    for step in 0..40 {
        let angle = 0.16 * f64::from(step);
        let place = |point: Vector<2>| rotated(&point, &unit(angle));
        let walls = room.walls(place);
        let floor = floor(&walls);
        let errand = Errand {
            footprint: Footprint::new(0.5, 0.8).unwrap(),
            start: Pose { position: place([2.0, 5.0].into()), heading: angle },
            goal: Goal { position: place([18.0, 5.0].into()), heading: None },
            start_turn: StartTurn::InPlace,
            abilities: Abilities::default(),
            costs: Costs::default(),
            walls: &walls,
            floor: &floor,
        };
        let found = find(&errand, Wish::Gap(0.1), &mut Planner::default()).unwrap();
        check(&errand, &found);
        let shapes: Vec<_> = found.legs.iter().map(|leg| leg.curve).collect();
        let is_plain = matches!(
            shapes[..],
            [
                Curve::Turn { .. },
                Curve::Line { .. },
                Curve::Arc { .. },
                Curve::Line { .. },
                Curve::Arc { .. },
                Curve::Line { .. }
            ]
        );
        assert!(is_plain, "at {angle}: {shapes:?}");
    }
}

/// Where the budget ends before the search does, what was found is an answer that says so.
#[test]
fn search_cut_short_keeps_the_best_so_far() {
    let post = |x: f64, y: f64| {
        [[x, y], [x + 1.0, y + 0.2], [x + 0.8, y + 1.0]].map(Vector::<2>::from).to_vec()
    };
    let solids = [(2.0, 2.1), (4.5, 1.7), (7.0, 2.4), (2.3, 5.0), (4.9, 5.2), (6.8, 6.9)];
    let room = Room { size: 10.0, solids: solids.map(|(x, y)| post(x, y)).to_vec() };
    let start = Pose { position: [0.8, 0.8].into(), heading: 0.3 };
    let goal = Goal { position: [9.0, 9.1].into(), heading: Some(1.0) };
    let footprint = Footprint::new(0.5, 0.9).unwrap();
    with_errand(&room, footprint, (start, goal, false), |errand| {
        let find = |steps: u64| {
            let budget = Budget::new(Allowance { steps, ..Allowance::NONE });
            let mut found = RobotMotion::default();
            drive(errand, Wish::Safest, &mut Planner::default(), &mut found, &budget)
                .map(|()| (found, budget.drawn(Cap::Steps)))
        };
        let (whole, steps) = find(u64::MAX).unwrap();
        assert!(whole.is_complete);
        assert!(matches!(find(100), Err(NoMotion::Spent(Spent::Limit { .. }))));
        let mut cut_short = 0;
        for part in 1..8 {
            let most = steps * part / 8;
            let Ok((found, drawn)) = find(most) else { continue };
            check(errand, &found);
            // Something is left to write it.
            assert!(drawn < most);
            assert!(!found.is_complete && found.free_clearance <= whole.free_clearance + 1e-9);
            cut_short += 1;
        }
        assert!(cut_short > 3, "{cut_short}");
    });
}
