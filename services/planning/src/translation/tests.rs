use std::f64::consts::TAU;

use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use super::blocks::{Block, Blocks};
use super::{Demand, NoWay};
use crate::budget::Budget;
use crate::clearance::translating::{Body, clearance_body_legs};
use crate::disassembly::DisassemblyPath;
use crate::free_space::walls::{Wall, Walls};
use crate::geometry::distance::distance_point_segment;
use crate::geometry::orientation::{Side, side_of_line};
use crate::geometry::polygon::{self, Polygon};
use crate::geometry::{Direction, Sign, Vector, unit};
use judge::Strictness;
use scene::{Scene, length, scenes};

mod judge;
mod kinds;
mod scene;

const CONTACT: Demand<2> = Demand::AtLeast(0.0);

/// The same random numbers in each run.
fn runner() -> TestRunner {
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    TestRunner::new_with_rng(Config::default(), rng)
}

/// Random scenes of all kinds, the same in each run.
fn each_scene(count: usize, mut check: impl FnMut(&Scene)) {
    let mut runner = runner();
    for _ in 0..count {
        let tree = scenes().new_tree(&mut runner).unwrap();
        check(&tree.current());
    }
}

/// Binds where the judge says the same with overlaps of +-1e-9 of the extent. Contact must not
/// matter then, and the length is that of a full visibility graph.
#[test]
fn shortest_way_is_that_of_all_sums() {
    let (mut solved, mut refused, mut snug) = (0, 0, 0);
    each_scene(400, |scene| {
        let margin = 1e-9 * scene.extent();
        let lenient = judge::shortest(scene, Strictness { grown: 0.0, allowed: margin });
        let strict = judge::shortest(scene, Strictness { grown: margin, allowed: 1e-12 });
        let found = scene.plan(CONTACT);
        match (lenient, strict, &found) {
            (Some(least), Some(most), Ok(way)) => {
                let length = length(way);
                let slack = 1e-9 * scene.extent();
                assert!(
                    least - slack <= length && length <= most + slack,
                    "{least} {length} {most} {scene:?}"
                );
                solved += 1;
            }
            (
                None,
                None,
                Err(NoWay::Closed(_) | NoWay::Overlap { .. } | NoWay::OutOfBounds { .. }),
            ) => {
                refused += 1;
            }
            // Contact decides.
            (Some(_), None, _) => snug += usize::from(found.is_ok()),
            _ => panic!("{lenient:?} {strict:?} {found:?} {scene:?}"),
        }
    });
    assert!(solved > 100 && refused > 50 && snug > 10, "{solved} {refused} {snug}");
}

/// Of solids in either sense, and of one with several hundred edges.
#[test]
fn blocks_are_convex_parts_of_solids_with_all_of_their_edges() {
    let star = |at: usize| unit(at as f64 * TAU / 300.0) * [5.0, 4.7, 3.0, 4.9, 4.95][at % 5];
    let mut outlines = vec![(0..300).map(star).collect::<Vec<_>>()];
    each_scene(100, |scene| outlines.extend(scene.outlines.iter().cloned()));
    let reversed = outlines.iter().map(|outline| outline.iter().rev().copied().collect());
    let outlines: Vec<Vec<_>> = reversed.chain(outlines.iter().cloned()).collect();
    let (mut edges, mut all) = (0, 0);
    for outline in outlines {
        let budget = Budget::default();
        let solid = Polygon::new(outline, &budget).unwrap();
        let (mut walls, mut blocks) = (Walls::default(), Blocks::default());
        walls.push_polygon(&solid);
        walls.index(&budget).unwrap();
        for (wall, Wall { from, to }) in walls.as_slice().iter().enumerate() {
            let block = blocks.of(&walls, wall, &budget).unwrap().unwrap();
            let Block { corners, walls: sides, .. } = blocks.get(block);
            assert_eq!(sides.iter().filter(|side| **side == wall).count(), 1);
            // As the blocks are listed by their first walls, each counts once.
            all += usize::from(sides[0] == wall);
            edges += 1;
            if let [a, b] = corners[..] {
                assert!([a, b].contains(from) && [a, b].contains(to));
                continue;
            }
            let sides: Vec<_> = polygon::edges(corners).collect();
            let has = |point: &Vector<2>, least: Side| {
                sides.iter().all(|(a, b)| {
                    let side = side_of_line(a, b, point);
                    side == Side::Left || side == least
                })
            };
            assert!(corners.iter().chain([from, to]).all(|corner| has(corner, Side::On)));
            assert!(!solid.vertices().iter().any(|vertex| has(vertex, Side::Left)));
            let middle = corners.iter().sum::<Vector<2>>() / corners.len() as f64;
            assert!(solid.contains(&middle), "{corners:?}");
        }
    }
    assert!(2 * all < edges, "{all} {edges}");
}

fn up() -> Direction {
    Direction { axis: 1, sign: Sign::Positive }
}

/// The exact clearance along a way, of all and of all legs but the first.
fn clearances(scene: &Scene, way: &[Vector<2>]) -> (f64, f64) {
    let budget = Budget::default();
    let body = Polygon::new(scene.outline.clone(), &budget).unwrap();
    let mut path = DisassemblyPath::default();
    path.set_way(way);
    let (mut each, body) = (Vec::new(), Body::from_polygon(&body));
    let whole = clearance_body_legs(&body, &scene.walls(), path.legs(), &mut each, &budget);
    let later = each.iter().skip(1).map(|near| near.value).fold(f64::INFINITY, f64::min);
    (whole.unwrap().unwrap().value, later)
}

#[test]
fn ways_keep_what_is_asked() {
    let mut kept = 0;
    each_scene(60, |scene| {
        let at_start = clearances(scene, &[Vector::zeros(); 2]).0;
        let slack = 1e-9 * scene.extent();
        for gap in [0.01, 0.05, 0.2] {
            for wish in [Demand::Gap(Vector::from([gap, gap])), Demand::AtLeast(gap)] {
                let Ok(way) = scene.plan(wish) else { continue };
                let (whole, _) = clearances(scene, &way);
                let at_end = clearances(scene, &[way[way.len() - 1]; 2]).0;
                // Nothing is relaxed there.
                if at_start.min(at_end) > 1.5 * gap {
                    assert!(whole >= gap - slack, "{whole} {gap} {scene:?}");
                    kept += 1;
                }
            }
        }
    });
    assert!(kept > 50, "{kept}");
}

#[test]
fn no_gap_beats_the_safest() {
    let mut compared = 0;
    each_scene(60, |scene| {
        let Ok(way) = scene.plan(Demand::Part(1.0)) else {
            assert!(scene.plan(CONTACT).is_err());
            return;
        };
        let safest = clearances(scene, &way).0;
        let slack = 2e-9 * scene.extent();
        for step in 1..20 {
            let gap = f64::from(step) * 0.03;
            let Ok(way) = scene.plan(Demand::Gap(Vector::from([gap, gap]))) else { break };
            let found = clearances(scene, &way).0;
            assert!(found <= safest + slack, "gap {gap}: {found}, safest {safest} {scene:?}");
            compared += 1;
        }
    });
    assert!(compared > 100, "{compared}");
}

#[test]
fn what_a_gap_is_refused_for_is_the_least_that_would_do() {
    let mut refused = 0;
    each_scene(60, |scene| {
        let gap = 0.3;
        let wish = |part: f64| Demand::Gap(Vector::from([gap, gap]) * part);
        let Err(NoWay::TooMuch { part }) = scene.plan(wish(1.0)) else { return };
        refused += 1;
        assert!(scene.plan(wish(part + 1e-6)).is_err());
        if part > 1e-6 {
            scene.plan(wish(part - 1e-6)).unwrap();
        }
    });
    assert!(refused > 5, "{refused}");
}

/// A part stops at each place of its way, so there is none on a straight line, however the scene lies.
#[test]
fn ways_turn_at_every_place() {
    let mut turns = 0;
    each_scene(60, |scene| {
        for (scale, far) in [(1.0, 0.0), (1000.0, 0.0), (0.001, 0.0), (1.0, 300.0)] {
            let scene = scene.changed(|point| point * scale + Vector::from([far, -far]));
            for demand in [CONTACT, Demand::Part(1.0), Demand::Gap(Vector::repeat(0.05 * scale))] {
                let Ok(way) = scene.plan(demand) else { continue };
                for three in way.windows(3) {
                    let bend = distance_point_segment(&three[1], (&three[0], &three[2]));
                    assert!(bend > 1e-13 * scene.extent(), "{bend} {three:?} {scene:?}");
                    turns += 1;
                }
            }
        }
    });
    assert!(turns > 500, "{turns}");
}

#[test]
fn turned_moved_and_scaled_scenes_have_the_same_way() {
    each_scene(120, |scene| {
        let found = scene.plan(CONTACT);
        let same = |other: &Scene, exit: Direction, scale: f64| {
            let there = other.plan_to(exit, CONTACT);
            match (&found, there) {
                (Ok(way), Ok(there)) => {
                    let (length, there) = (scale * length(way), length(&there));
                    assert!((length - there).abs() < 1e-8 * scale * scene.extent(), "{scene:?}");
                }
                (Err(_), Err(_)) => {}
                (found, there) => panic!("{found:?} {there:?} {scene:?}"),
            }
        };
        let moved = scene.changed(|point| point + Vector::from([300.0, -200.0]));
        same(&moved, up(), 1.0);
        same(&scene.changed(|point| point * 1024.0), up(), 1024.0);
        let turned = scene.changed(|point| Vector::from([point.y, -point.x]));
        same(&turned, Direction { axis: 0, sign: Sign::Positive }, 1.0);
    });
}

/// A square of 1 m before a door between two corners, of 1 m by 1 m apart.
#[test]
fn way_between_two_corners_is_exact() {
    // Two triangles point at each other, their tips 2 m apart along a slanted line.
    let outlines = [[[-3.0, 3.0], [0.0, 3.2], [-3.0, 3.4]], [[1.2, 4.8], [6.0, 4.6], [6.0, 5.0]]];
    let outlines = outlines.map(|outline| outline.map(Vector::from).to_vec());
    let mut solids: Vec<scene::Shape> =
        outlines.iter().map(|outline| (outline.clone(), vec![outline.clone()])).collect();
    solids.push(scene::space([-3.0, -1.0], [6.0, 0.0]));
    solids.push(scene::space([-4.0, -1.0], [-3.0, 6.0]));
    solids.push(scene::space([6.0, -1.0], [7.0, 6.0]));
    let small = scene::placed(&scene::space([0.0, 0.0], [0.1, 0.1]), 0.0, [1.0, 1.5].into());
    let scene = scene::scene(solids, small);
    let way = scene.plan(Demand::Part(1.0)).unwrap();
    // The tips are 1.2 m and 1.6 m apart along the axes, the square takes 0.1 m of each.
    let expected = libm::hypot(1.1, 1.5) / 2.0;
    let (whole, _) = clearances(&scene, &way);
    assert!((whole - expected).abs() < 1e-9, "{whole} {expected}");
}

/// A slot that is 1.4 m wide, but less between stops at its mouth; turned by an angle.
fn slot(stops: Vec<scene::Shape>, part: scene::Shape, angle: f64) -> Scene {
    let mut solids = stops;
    solids.push(scene::space([-1.0, 0.0], [0.0, 3.0]));
    solids.push(scene::space([1.4, 0.0], [2.4, 3.0]));
    solids.push(scene::space([-1.0, -1.0], [2.4, 0.0]));
    let place = |shape: &scene::Shape| scene::placed(shape, angle, Vector::from([5.0, 5.0]));
    scene::scene(solids.iter().map(place).collect(), place(&part))
}

#[test]
fn narrow_slot_is_measured() {
    // A square of 1 m in a slot that is 0.8 m wide at its mouth, turned by some angle.
    for angle in [0.0, 0.4, -0.7] {
        let stop = scene::space([0.8, 2.0], [1.4, 3.0]);
        let part = scene::space([0.1, 0.1], [1.1, 1.1]);
        let scene = slot(vec![stop], part, angle);
        let Err(NoWay::Closed(Some(narrow))) = scene.plan(CONTACT) else { panic!("{angle}") };
        assert!((narrow.needs - 1.0).abs() < 1e-9 && (narrow.has - 0.8).abs() < 1e-9, "{narrow:?}");
        assert!(!narrow.is_for_piece);
    }
}

/// An L whose foot is 1 m wide and 0.4 m high.
fn with_foot() -> scene::Shape {
    scene::placed(&scene::l_shape(1.0, 1.2, 0.4), 0.0, [0.1, 0.1].into())
}

#[test]
fn narrow_slot_is_measured_for_the_piece_that_lacks_most() {
    for angle in [0.0, 0.4, -0.7] {
        let stop = scene::space([0.8, 2.0], [1.4, 3.0]);
        let scene = slot(vec![stop], with_foot(), angle);
        let Err(NoWay::Closed(Some(narrow))) = scene.plan(CONTACT) else { panic!("{angle}") };
        assert!((narrow.needs - 1.0).abs() < 1e-9 && (narrow.has - 0.8).abs() < 1e-9, "{narrow:?}");
        assert!(narrow.is_for_piece);
    }
}

#[test]
fn passage_is_named_only_where_a_piece_cannot_get_out_alone() {
    // The foot must shift to the left between the stops, before the leg on its right is past the upper.
    let stops = vec![scene::space([0.0, 2.0], [0.35, 2.2]), scene::space([1.05, 2.7], [1.4, 3.0])];
    let mirrored = |points: &Vec<Vector<2>>| {
        points.iter().rev().map(|point| Vector::from([1.2 - point.x, point.y])).collect::<Vec<_>>()
    };
    let (outline, pieces) = with_foot();
    let part = (mirrored(&outline), pieces.iter().map(mirrored).collect());
    let scene = slot(stops, part, 0.0);
    assert_eq!(scene.plan(CONTACT), Err(NoWay::Closed(None)));
    for piece in &scene.body {
        let alone = Scene { outline: piece.clone(), body: vec![piece.clone()], ..scene.clone() };
        alone.plan(CONTACT).unwrap();
    }
}
