//! Scenes of each kind, with parts of each kind that fit tightly or exactly, or are a bit too large.
//!
//! `CLEARWAY_SCENES` is how many of each there are.

use proptest::prelude::*;
use proptest::strategy::ValueTree;

use super::scene::{self, PartKind, Scene, Shape, length, placed, space};
use super::{CONTACT, clearances, judge, runner};
use crate::geometry::{AxisBox, Vector};
use crate::translation::NoWay;
use judge::Strictness;

/// Scenes of each kind, unless `CLEARWAY_SCENES` says otherwise.
const SCENES: usize = 20;

/// The same of two numbers, as a part of the extent.
const SAME: f64 = 1e-9;

/// What the judge takes for rounding, as a part of the extent.
const ROUNDING: f64 = 1e-11;

/// How much wider a passage is than the part.
#[derive(Debug, Clone, Copy)]
enum Fit {
    /// By little; or it is too narrow.
    Tight,
    /// By nothing.
    Snug,
}

impl Fit {
    fn play(self) -> BoxedStrategy<f64> {
        match self {
            Self::Tight => {
                prop_oneof![1e-6..1e-5_f64, 1e-3..1e-2_f64, 0.02..0.1_f64, -0.05..-1e-6_f64].boxed()
            }
            Self::Snug => Just(0.0).boxed(),
        }
    }
}

/// What a scene is made from: a part, the play that it has, and numbers in [0, 1).
type Seed = (Shape, f64, [f64; 6]);

fn seeds(kind: &'static [PartKind], fit: Fit) -> impl Strategy<Value = Seed> {
    (scene::part(kind), fit.play(), prop::array::uniform6(0.0..1.0_f64))
}

/// How far a part reaches along a direction, from where to where.
fn span(part: &Shape, along: [f64; 2]) -> [f64; 2] {
    let along = Vector::from(along);
    let reaches = part.0.iter().map(|point| point.dot(&along));
    reaches.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
}

/// A part's width and height, and where it must be put to have its least corner at the origin.
fn size(part: &Shape) -> ([f64; 2], Vector<2>) {
    let [x, z] = [span(part, [1.0, 0.0]), span(part, [0.0, 1.0])];
    ([x[1] - x[0], z[1] - z[0]], Vector::from([-x[0], -z[0]]))
}

/// A shape of several convex pieces.
fn joined<const N: usize>(outline: &[[f64; 2]], pieces: [Shape; N]) -> Shape {
    let outline = outline.iter().copied().map(Vector::from).collect();
    (outline, pieces.into_iter().flat_map(|(_, pieces)| pieces).collect())
}

fn quadrangle(corners: [[f64; 2]; 4]) -> Shape {
    let outline = corners.map(Vector::from).to_vec();
    (outline.clone(), vec![outline])
}

/// Up a shaft, to the right through a corridor and up another shaft.
fn rectilinear((part, play, [lean, lift, height, long, ..]): Seed) -> Scene {
    let ([width, tall], to_origin) = size(&part);
    let shaft = width + play.max(0.0);
    let (floor, right) = (0.2 + height, shaft + width + 0.2 + long);
    let ceiling = floor + tall + play;
    let (inner, top) = (right - width - play, ceiling + 1.0);
    let below = joined(
        &[
            [-1.0, -1.0],
            [right + 1.0, -1.0],
            [right + 1.0, top],
            [right, top],
            [right, floor],
            [shaft, floor],
            [shaft, 0.0],
            [-1.0, 0.0],
        ],
        [
            space([-1.0, -1.0], [right + 1.0, 0.0]),
            space([shaft, 0.0], [right + 1.0, floor]),
            space([right, 0.0], [right + 1.0, top]),
        ],
    );
    let above = joined(
        &[[-1.0, 0.0], [0.0, 0.0], [0.0, ceiling], [inner, ceiling], [inner, top], [-1.0, top]],
        [space([-1.0, 0.0], [0.0, top]), space([-1.0, ceiling], [inner, top])],
    );
    let at = to_origin + Vector::from([lean * play.max(0.0), lift * floor]);
    scene::scene(vec![below, above], placed(&part, 0.0, at))
}

/// A room with blocks at some angle, and two doors.
fn room(((part, play, [x, z, first, second, angle, turn]), blocks): (Seed, Vec<Shape>)) -> Scene {
    // Half of the parts are not turned.
    let part = placed(&part, if turn < 0.5 { 0.0 } else { 3.0 * angle - 1.5 }, Vector::zeros());
    let ([width, _], to_origin) = size(&part);
    let doors = [1.0 + 2.0 * first, 6.0 + 2.0 * second].map(|from| [from, width + play]);
    let at = to_origin + Vector::from([0.2 + 8.0 * x, 0.1 + 5.0 * z]);
    scene::scene(scene::room_of(doors, blocks), placed(&part, 0.0, at))
}

/// A wide hollow with a neck, at an angle, in which the part is turned as well or is not.
fn flask((part, play, [angle, beside, lean, lift, depth, roomy]): Seed, turned: bool) -> Scene {
    let angle = 2.8 * angle - 1.4;
    let part = if turned { part } else { placed(&part, -angle, Vector::zeros()) };
    let ([width, tall], to_origin) = size(&part);
    let (room, depth) = (0.2 + 0.4 * roomy, 0.3 + depth);
    let right = 1.0 + width + room;
    let (shoulder, top) = (1.0 + tall + room, 1.0 + tall + room + depth);
    let left_lip = 1.0 + (room - play) * beside;
    let right_lip = left_lip + width + play;
    let solid = joined(
        &[
            [0.0, 0.0],
            [right + 1.0, 0.0],
            [right + 1.0, top],
            [right_lip, top],
            [right_lip, shoulder],
            [right, shoulder],
            [right, 1.0],
            [1.0, 1.0],
            [1.0, shoulder],
            [left_lip, shoulder],
            [left_lip, top],
            [0.0, top],
        ],
        [
            space([0.0, 0.0], [right + 1.0, 1.0]),
            space([0.0, 0.0], [1.0, top]),
            space([right, 0.0], [right + 1.0, top]),
            space([0.0, shoulder], [left_lip, top]),
            space([right_lip, shoulder], [right + 1.0, top]),
        ],
    );
    let part = placed(&part, 0.0, to_origin + Vector::from([1.0 + room * lean, 1.0 + room * lift]));
    let at = Vector::from([3.0, 2.0]);
    let scene = scene::scene(vec![placed(&solid, angle, at)], placed(&part, angle, at));
    // Room beside the solid, into which the neck may lead.
    let (low, high) = (scene.bounds.min(), scene.bounds.max());
    let beside = Vector::from([2.0, 0.0]);
    Scene { bounds: AxisBox::new(low - beside, high + beside).unwrap(), ..scene }
}

/// A channel between slanted walls, narrower in its upper half, with a block in some of them.
fn slanted((part, play, [lean, beside, inside, step, has_block, block]): Seed) -> Scene {
    const ROOM: f64 = 0.3;
    let lean = 1.6 * lean - 0.8;
    // Along the floor, the part takes what it does across the walls.
    let [left, right] = span(&part, [1.0, -lean]);
    let (wide, narrow) = (right - left + ROOM, right - left + play);
    let from = (ROOM - play) * step;
    let to = from + narrow;
    let (half, top) = (3.0 * lean, 6.0 * lean);
    let walls = |lower: [f64; 2], upper: [f64; 2]| {
        let below = quadrangle([
            [lower[0], 0.0],
            [lower[1], 0.0],
            [lower[1] + half, 3.0],
            [lower[0] + half, 3.0],
        ]);
        let above = quadrangle([
            [upper[0] + half, 3.0],
            [upper[1] + half, 3.0],
            [upper[1] + top, 6.0],
            [upper[0] + top, 6.0],
        ]);
        [below, above]
    };
    let mut solids = vec![space([-8.0, -1.0], [12.0, 0.0])];
    solids.extend(walls([-2.0, 0.0], [-2.0, from]));
    solids.extend(walls([wide, wide + 2.0], [to, wide + 2.0]));
    if has_block < 0.3 {
        let piece = space([-0.1, -0.05], [0.1, 0.05]);
        solids.push(placed(&piece, 3.0 * block, [wide * beside + 0.8 * half, 2.4].into()));
    }
    let z = 0.1 - span(&part, [0.0, 1.0])[0];
    let at = Vector::from([lean * z - left + ROOM * inside, z]);
    scene::scene(solids, placed(&part, 0.0, at))
}

/// Compares the planner with the judge, which takes nothing but rounding for contact: so exact fits
/// bind as well. Returns whether the part gets out.
fn gets_out(scene: &Scene) -> bool {
    let extent = scene.extent();
    let strictness = Strictness { grown: 0.0, allowed: ROUNDING * extent };
    match (judge::shortest(scene, strictness), scene.plan(CONTACT)) {
        (Some(least), Ok(way)) => {
            let off = (length(&way) - least).abs();
            assert!(off <= SAME * extent, "{} for {least} {scene:?}", length(&way));
            let (exact, found) = (judge::clearance(scene, &way), clearances(scene, &way).0);
            assert!((found - exact).abs() <= SAME * extent, "{found} for {exact} {scene:?}");
            true
        }
        (None, Err(NoWay::Closed(_) | NoWay::Overlap { .. } | NoWay::OutOfBounds { .. })) => false,
        (least, found) => panic!("{least:?} {found:?} {scene:?}"),
    }
}

/// At least so many of a hundred get out, and so many do not.
fn check<S: Strategy<Value = Scene>>(
    scenes: impl Fn(&'static [PartKind], Fit) -> S,
    [least_out, least_shut]: [usize; 2],
) {
    let count = match std::env::var("CLEARWAY_SCENES") {
        Ok(count) => count.parse().expect("CLEARWAY_SCENES is a number"),
        Err(_) => SCENES,
    };
    let (mut out, mut all) = (0, 0);
    let mut runner = runner();
    for kind in PartKind::ALL.chunks(1) {
        for fit in [Fit::Tight, Fit::Snug] {
            let scenes = scenes(kind, fit);
            for _ in 0..count {
                out += usize::from(gets_out(&scenes.new_tree(&mut runner).unwrap().current()));
                all += 1;
            }
        }
    }
    assert!(
        100 * out >= least_out * all && 100 * (all - out) >= least_shut * all,
        "{out} of {all}"
    );
}

#[test]
fn rectilinear_cavities_open_where_they_do() {
    check(|kind, fit| seeds(kind, fit).prop_map(rectilinear), [50, 5]);
}

#[test]
fn rooms_open_where_they_do() {
    let blocks = || scene::blocks(prop_oneof![Just(0.0), -1.5..1.5_f64]);
    check(|kind, fit| (seeds(kind, fit), blocks()).prop_map(room), [20, 20]);
}

#[test]
fn turned_cavities_open_where_they_do() {
    check(|kind, fit| seeds(kind, fit).prop_map(|seed| flask(seed, false)), [50, 5]);
}

#[test]
fn cavities_turned_with_their_parts_open_where_they_do() {
    check(|kind, fit| seeds(kind, fit).prop_map(|seed| flask(seed, true)), [50, 5]);
}

#[test]
fn slanted_channels_open_where_they_do() {
    check(|kind, fit| seeds(kind, fit).prop_map(slanted), [30, 5]);
}
