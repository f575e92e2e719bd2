//! The planner on random scenes of the kinds that people have, beside the lattice search.
//! `peers kinds` runs more of them.

use peers::judge::{ask, judge};
use peers::kinds::Kind;
use peers::lattice::Resolution;
use peers::scene::Scene;
use peers::turned;
use serde_json::{Value, json};

/// Scenes of each kind.
const SCENES: u64 = 6;

/// Of those for which the safest motion is looked for.
const SAFEST_SCENES: u64 = 1;

/// Gap asked for, metres.
const GAP: f64 = 0.01;

fn check_kind(kind: Kind) {
    let mut solved = 0;
    for number in 0..SCENES {
        let verdict = judge(&kind.scene(number), GAP, Resolution::default());
        assert!(verdict.faults.is_empty(), "{kind:?} {number}: {:?}", verdict.faults);
        let Some(peer) = verdict.peer else { continue };
        solved += 1;
        match verdict.planner {
            Ok(drive) => {
                assert!(drive.length <= 1.1 * peer, "{kind:?} {number}: {} {peer}", drive.length);
                // Where the taut path can be driven, it is as short as can be.
                if drive.rungs == ["taut"] {
                    let most = 1.001 * drive.bound + 1e-9;
                    assert!(drive.length <= most, "{kind:?} {number}: {drive:?}");
                }
            }
            Err(refusal) => panic!("{kind:?} {number}: the peer has {peer} m, but: {refusal}"),
        }
    }
    // A grid that starts in one narrow aisle rarely meets the middle of another.
    assert!(solved > 0 || kind == Kind::ReverseAisles, "{kind:?}: the peer solves none");
}

#[test]
fn offices() {
    check_kind(Kind::Offices);
}

#[test]
fn turned_offices() {
    check_kind(Kind::TurnedOffices);
}

#[test]
fn boxes() {
    check_kind(Kind::Boxes);
}

#[test]
fn polygons() {
    check_kind(Kind::Polygons);
}

#[test]
fn slanted_corridors() {
    check_kind(Kind::SlantedCorridors);
}

#[test]
fn aisles() {
    check_kind(Kind::Aisles);
}

#[test]
fn reverse_aisles() {
    check_kind(Kind::ReverseAisles);
}

#[test]
fn narrow_doors() {
    check_kind(Kind::NarrowDoors);
}

/// A scene turned, scaled and moved.
fn placed(scene: &Scene, angle: f64, scale: f64, offset: [f64; 2]) -> Scene {
    let place = |point: [f64; 2]| {
        let [x, y] = turned(point, angle);
        [scale * x + offset[0], scale * y + offset[1]]
    };
    let mut placed = scene.clone();
    for outline in placed.solids.iter_mut().chain([&mut placed.room]) {
        for point in outline {
            *point = place(*point);
        }
    }
    placed.footprint = scene.footprint.map(|side| scale * side);
    placed.start.position = place(scene.start.position);
    placed.start.heading += angle;
    placed.goal = place(scene.goal);
    placed.goal_heading = scene.goal_heading.map(|heading| heading + angle);
    placed
}

/// Coordinates that are 10^6 m away are off by 1e-10 m, and the motion with them.
const SAME: f64 = 1e-9;

/// Scenes that are turned, scaled and moved have the same answers, whatever the rung.
#[track_caller]
fn check_places(places: impl Fn(u64) -> Vec<(f64, f64, [f64; 2])>) {
    check_clearance(SCENES, |scale| json!({ "gap": scale * GAP }), places);
}

/// The same with a clearance, by the scale.
#[track_caller]
fn check_clearance(
    scenes: u64,
    clearance: impl Fn(f64) -> Value,
    places: impl Fn(u64) -> Vec<(f64, f64, [f64; 2])>,
) {
    let mut differ = Vec::new();
    for kind in Kind::ALL {
        for number in 0..scenes {
            let scene = kind.scene(number);
            let (own, _) = ask(&scene, &clearance(1.0));
            for (angle, scale, offset) in places(number) {
                let other = placed(&scene, angle, scale, offset);
                let (other, _) = ask(&other, &clearance(scale));
                let is_same = match (&own, &other) {
                    (Ok(own), Ok(other)) => {
                        let off = (other.length / scale - own.length).abs();
                        off < SAME * own.length && own.rungs == other.rungs
                    }
                    (Err(_), Err(_)) => true,
                    _ => false,
                };
                if !is_same {
                    differ.push(format!(
                        "{kind:?} {number} at {angle} x {scale} + {offset:?}: {own:?} {other:?}"
                    ));
                }
            }
        }
    }
    assert!(differ.is_empty(), "{differ:#?}");
}

#[test]
fn direction_does_not_matter() {
    check_places(|number| vec![(0.1 + number as f64, 1.0, [0.0; 2])]);
}

#[test]
fn origin_does_not_matter() {
    let angle = |number| 0.1 + number as f64;
    let far = [1e6, -1e6];
    check_places(|number| vec![(0.0, 1.0, far), (angle(number), 1.0, [-1e6, 1e6])]);
}

#[test]
fn unit_does_not_matter() {
    check_places(|_| vec![(0.0, 1000.0, [0.0; 2]), (0.0, 0.001, [0.0; 2])]);
}

/// What is safest hangs together with many measured clearances.
#[test]
fn neither_direction_nor_unit_matters_to_the_safest() {
    let angle = |number| 0.1 + number as f64;
    let places = |number| vec![(angle(number), 1.0, [0.0; 2]), (0.0, 0.001, [0.0; 2])];
    check_clearance(SAFEST_SCENES, |_| json!("safest"), places);
}
