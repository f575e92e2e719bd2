//! Routes of bodies that are unions of boxes, against a flood over all displacements.

use std::collections::BTreeSet;

use proptest::strategy::ValueTree;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};

use super::*;
use crate::clearance::translating::{Body, clearance_body_legs};
use crate::free_space::solids::UnionInCavity;
use crate::free_space::walls::Walls;
use crate::motion::Curve;

/// The side of the cavity, metres.
const SIDE: i32 = 8;

/// A body among solids, all of whose coordinates are whole metres.
#[derive(Debug, Clone)]
struct UnionScene<const D: usize> {
    solids: Vec<AxisBox<D>>,
    body: Vec<AxisBox<D>>,
    exit: Direction,
}

fn whole_boxes<const D: usize>(
    count: std::ops::Range<usize>,
    least: std::ops::Range<i32>,
    sizes: std::ops::Range<i32>,
) -> impl Strategy<Value = Vec<AxisBox<D>>> {
    let part = (proptest::collection::vec(least, D), proptest::collection::vec(sizes, D));
    let part = part.prop_map(|(least, sizes)| {
        let min = Vector::from_iterator(least.iter().map(|value| f64::from(*value)));
        let size = Vector::from_iterator(sizes.iter().map(|value| f64::from(*value)));
        AxisBox::new(min, min + size).expect("a box")
    });
    proptest::collection::vec(part, count)
}

fn union_scenes<const D: usize>(most: usize) -> impl Strategy<Value = UnionScene<D>> {
    let solids = whole_boxes(2..most, 0..SIDE - 1, 1..5);
    let body = whole_boxes(2..4, 2..5, 1..3);
    let scene = (solids, body, 0..D, any::<bool>()).prop_map(|(solids, body, axis, up)| {
        let sign = if up { Sign::Positive } else { Sign::Negative };
        // Those that the body overlaps are left out.
        let is_apart =
            |solid: &AxisBox<D>| body.iter().all(|part| part.intersection(solid).is_none());
        let solids = solids.into_iter().filter(is_apart).collect();
        UnionScene { solids, body, exit: Direction { axis, sign } }
    });
    scene.prop_filter("no solids", |scene| !scene.solids.is_empty())
}

impl<const D: usize> UnionScene<D> {
    fn bounds() -> AxisBox<D> {
        AxisBox::new(Vector::zeros(), Vector::repeat(f64::from(SIDE))).expect("a box")
    }

    fn around(&self) -> AxisBox<D> {
        *Body::from_boxes(&self.body).expect("boxes").bounds()
    }

    /// Whether no box of the displaced body overlaps a solid, or is beside the bounds before the mouth,
    /// by more than `contact`, metres.
    fn is_free(&self, at: &Vector<D>, contact: f64) -> bool {
        let (bounds, exit) = (Self::bounds(), self.exit);
        self.body.iter().all(|part| {
            let part = part.translated(at);
            let overlaps = |solid: &AxisBox<D>| {
                (0..D).all(|axis| {
                    solid.min()[axis] + contact < part.max()[axis]
                        && part.min()[axis] + contact < solid.max()[axis]
                })
            };
            let reach = exit.coordinate(&bounds.min()).max(exit.coordinate(&bounds.max()));
            let last = exit.coordinate(&part.min()).min(exit.coordinate(&part.max()));
            let is_in = (0..D).all(|axis| {
                let below = part.min()[axis] >= bounds.min()[axis] - contact;
                let above = part.max()[axis] <= bounds.max()[axis] + contact;
                match (axis == exit.axis, exit.sign) {
                    (false, _) => below && above,
                    (true, Sign::Positive) => below,
                    (true, Sign::Negative) => above,
                }
            });
            !self.solids.iter().any(overlaps) && (is_in || last >= reach - contact)
        })
    }

    /// Whether the body gets out, from cell to cell of displacements through their common faces: what
    /// is free there does not change but at whole metres.
    fn floods_out(&self) -> bool {
        let (around, exit) = (self.around(), self.exit);
        let middle = |cell: &[i32; D]| Vector::from(cell.map(|low| f64::from(low) + 0.5));
        let mouth = mouth_of(&Self::bounds(), exit).bound;
        let is_out = |cell: &[i32; D]| match exit.sign {
            Sign::Positive => f64::from(cell[exit.axis] + 1) >= mouth - around.min()[exit.axis],
            Sign::Negative => f64::from(cell[exit.axis]) <= mouth - around.max()[exit.axis],
        };
        let corners = (0..1 << D).map(|corner| std::array::from_fn(|axis| -(corner >> axis & 1)));
        let mut open: Vec<[i32; D]> =
            corners.filter(|cell| self.is_free(&middle(cell), 0.0)).collect();
        let mut seen: BTreeSet<[i32; D]> = open.iter().copied().collect();
        while let Some(cell) = open.pop() {
            if is_out(&cell) {
                return true;
            }
            for axis in 0..D {
                for step in [-1, 1] {
                    let mut next = cell;
                    next[axis] += step;
                    let is_near = next.iter().all(|low| low.abs() < 3 * SIDE);
                    if is_near && self.is_free(&middle(&next), 0.0) && seen.insert(next) {
                        open.push(next);
                    }
                }
            }
        }
        false
    }

    /// The path by the rules through the channels made for the union.
    fn plan(&self) -> Result<DisassemblyPath<D>, RouteError> {
        let budget = Budget::default();
        let mut solids = Solids::default();
        self.solids.iter().for_each(|solid| solids.push_box(*solid, &budget).unwrap());
        let (boxes, around, exit) = (&self.body[..], self.around(), self.exit);
        let cavity = UnionInCavity { boxes, around, bounds: Self::bounds(), exit };
        let mut channels = Vec::new();
        solids.channels_for_union(&cavity, &budget, &mut channels).unwrap();
        let room = cavity.room().expect("there is room");
        let reach =
            |sides: &AxisBox<D>| exit.coordinate(&sides.min()).max(exit.coordinate(&sides.max()));
        if !channels.iter().any(|channel| reach(channel) >= reach(&room)) {
            return Err(RouteError::NoChannels);
        }
        let (gap, end) = (Gap::Fraction(0.5), End::Exit(exit));
        let (route, _) = find(&channels, &BodyMover::new(&around, gap, end)?)?;
        let travelled: Vec<_> = route.iter().map(|channel| channels[*channel]).collect();
        let (mut chain, mut path) = (Chain::default(), DisassemblyPath::default());
        chain.build(&travelled, &around.center(), end, &budget).expect("a chain");
        chain.set_mouth(mouth_of(&Self::bounds(), exit));
        disassemble(&chain, &around, gap, &mut path, &budget).expect("a path");
        Ok(path)
    }
}

/// A way is found exactly where there is one, and the body is free all along it.
fn check_union<const D: usize>(scene: &UnionScene<D>) -> Result<bool, TestCaseError> {
    let path = match scene.plan() {
        Err(error) => {
            prop_assert!(!scene.floods_out(), "{error}");
            return Ok(false);
        }
        Ok(path) => path,
    };
    prop_assert!(scene.floods_out());
    for leg in path.legs() {
        let Curve::Line { from, to, .. } = &leg.curve else { panic!("{leg:?}") };
        for step in 0..=64 {
            let at = from + (to - from) * (f64::from(step) / 64.0);
            prop_assert!(scene.is_free(&at, 1e-12), "at {at:?} on {leg:?}");
        }
    }
    let mut walls = Walls::default();
    scene.solids.iter().for_each(|solid| walls.push_box(solid));
    let body = Body::from_boxes(&scene.body).expect("boxes");
    let mut each = Vec::new();
    clearance_body_legs(&body, &walls, path.legs(), &mut each, &Budget::default()).unwrap();
    // Half of what there is in every junction is kept.
    prop_assert!(each.iter().skip(1).all(|near| near.value > 0.0), "{each:?}");
    Ok(true)
}

/// An S in a slot under a ledge: it moves aside while its upper half is above the wall opposite.
#[test]
fn bent_body_passes_where_its_bounds_do_not() {
    let solids = vec![
        space([0., 0., 0.], [6., 4., 1.]),
        space([0., 0., 1.], [1., 4., 6.]),
        space([5., 0., 1.], [6., 4., 4.5]),
        space([1., 0., 1.], [5., 1., 8.]),
        space([1., 3., 1.], [5., 4., 8.]),
        space([1., 1., 5.], [3.5, 3., 6.]),
    ];
    let body = vec![space([2., 1.5, 1.], [3.25, 2.5, 2.]), space([3., 1.5, 2.], [4., 2.5, 4.])];
    let exit = Direction { axis: 2, sign: Sign::Positive };
    let scene = UnionScene { solids, body, exit };
    let path = scene.plan().expect("a path");
    let end = path.legs().last().expect("a leg").curve.end();
    assert_eq!((end[1].abs() < 1e-12, end[2]), (true, 7.0));
    let solid = UnionScene { body: vec![scene.around()], ..scene.clone() };
    assert_eq!(solid.plan().map(|path| path.length()).ok(), None);
    // With a wall as high as the ledge is low it does not pass either.
    let mut higher = scene;
    higher.solids[2] = space([5., 0., 1.], [6., 4., 5.]);
    assert!(higher.plan().is_err());
}

/// Both outcomes are among the random scenes, and bodies that get out as their bounds could not.
#[test]
fn random_unions_are_of_all_kinds() {
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(ProptestConfig::default(), rng);
    let (mut out, mut held, mut bent) = (0, 0, 0);
    for _ in 0..300 {
        let scene = union_scenes::<3>(24).new_tree(&mut runner).unwrap().current();
        let box_alone = UnionScene { body: vec![scene.around()], ..scene.clone() };
        match scene.floods_out() {
            false => held += 1,
            true if box_alone.floods_out() => out += 1,
            true => bent += 1,
        }
    }
    assert!(out > 30 && held > 30 && bent > 30, "{out} {held} {bent}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn unions_get_out_exactly_where_there_is_a_way_in_the_plane(scene in union_scenes::<2>(12)) {
        check_union(&scene)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn unions_get_out_exactly_where_there_is_a_way_in_space(scene in union_scenes::<3>(24)) {
        check_union(&scene)?;
    }
}
