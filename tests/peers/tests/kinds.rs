//! The planner on random scenes of the kinds that people have, beside the lattice search.
//! `peers kinds` runs more of them.

use peers::judge::{Drive, ask, judge};
use peers::kinds::Kind;
use peers::lattice::Resolution;
use peers::scene::Scene;
use peers::turned;

/// Scenes of each kind.
const SCENES: u64 = 6;

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

/// Whether a motion was found without a search over poses.
fn is_exact(drive: &Drive) -> bool {
    drive.rungs.iter().all(|rung| ["taut", "radius"].contains(rung))
}

#[test]
fn rotation_origin_and_unit_do_not_matter() {
    for kind in Kind::ALL {
        for number in 0..SCENES {
            let scene = kind.scene(number);
            let (own, _) = ask(&scene, GAP);
            let angle = 0.1 + number as f64;
            let places = [
                (angle, 1.0, [0.0; 2]),
                (0.0, 1.0, [1e6, -1e6]),
                (angle, 1.0, [-1e6, 1e6]),
                (0.0, 1000.0, [0.0; 2]),
                (angle, 0.001, [0.0; 2]),
            ];
            for (angle, scale, offset) in places {
                let (other, _) = ask(&placed(&scene, angle, scale, offset), scale * GAP);
                let says = || {
                    format!(
                        "{kind:?} {number} at {angle} x {scale} + {offset:?}: {own:?} {other:?}"
                    )
                };
                match (&own, &other) {
                    (Ok(own), Ok(other)) => {
                        let off = (other.length / scale - own.length).abs() / own.length;
                        // Far from the origin, coordinates themselves are off by 1e-10 m. A search
                        // over poses may meet a tie that rounding decides.
                        let most = match (is_exact(own), offset == [0.0; 2]) {
                            (true, true) => 1e-9,
                            (true, false) => 1e-7,
                            (false, _) => 0.05,
                        };
                        assert!(off < most, "{}", says());
                    }
                    (Err(_), Err(_)) => {}
                    (Ok(drive), Err(_)) | (Err(_), Ok(drive)) => {
                        assert!(!is_exact(drive), "{}", says());
                    }
                }
            }
        }
    }
}
